#include "gap/bootstrap/simulated_recordings.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/errors.hpp"
#include "core/linear_algebra.hpp"
#include "core/wind.hpp"
#include "gap/filter/state_space.hpp"
#include "gap/fit/effect_columns.hpp"
#include "gap/policy/policy.hpp"
#include "gap/sensors/channel_quality.hpp"

namespace leeway::gap {
namespace {

// An Ornstein-Uhlenbeck process with variance 1, in so many independent components.
template <int components>
class UnitProcess {
 public:
  UnitProcess(double tau_s, RandomStream& random) : tau_s_(tau_s), random_(random), value_(draw()) {}

  const Eigen::Matrix<double, components, 1>& value() const { return value_; }
  void advance(double dt_s) {
    const double kept = tau_s_ > 0.0 ? std::exp(-dt_s / tau_s_) : 0.0;
    value_ = kept * value_ + std::sqrt(1.0 - kept * kept) * draw();
  }

 private:
  Eigen::Matrix<double, components, 1> draw() {
    Eigen::Matrix<double, components, 1> result;
    for (double& x : result) x = random_.normal();
    return result;
  }
  double tau_s_;
  RandomStream& random_;
  Eigen::Matrix<double, components, 1> value_;
};

Eigen::VectorXd drawn_theta(const Fitted& fitted, RandomStream& random) {
  const Eigen::MatrixXd precision = fitted.fit.total.F / fitted.kappa + fitted.fit.prior.precision();
  Eigen::VectorXd noise(precision.rows());
  for (double& x : noise) x = random.normal();
  return fitted.fit.theta + precision.llt().matrixU().solve(noise);
}

// Where a time lies among ascending ones, and how far towards the next.
struct Between {
  std::size_t before;
  double weight;
};
Between between(const std::vector<double>& t_s, double at_s) {
  const auto after =
      std::clamp<std::ptrdiff_t>(std::upper_bound(t_s.begin(), t_s.end(), at_s) - t_s.begin(), 1, std::ssize(t_s) - 1);
  const auto before = static_cast<std::size_t>(after) - 1;
  return {before, std::clamp((at_s - t_s[before]) / (t_s[before + 1] - t_s[before]), 0.0, 1.0)};
}

// Rudder angles on top of those recorded that bring the ship back to the recorded course.
class Helmsman {
 public:
  Helmsman(const std::vector<double>& t_s, const std::vector<StateVector>& path, double L_pp) : t_s_(t_s), path_(path) {
    double speed = 0.0;
    for (const StateVector& x : path) speed += std::abs(x[3]) / static_cast<double>(path.size());
    rate_share_s_ = kPolicy.bootstrap.helmsman_rate * L_pp / std::max(speed, kPolicy.sensors.least_speed_mps);
  }
  double correction(double t_s, const ShipState<double>& state) const {
    const auto [k, weight] = between(t_s_, t_s);
    const StateVector wanted = (1.0 - weight) * path_[k] + weight * path_[k + 1];
    return kPolicy.bootstrap.helmsman_course * (wanted[2] - state.eta(2)) + rate_share_s_ * (wanted[5] - state.nu(2));
  }

 private:
  const std::vector<double>& t_s_;
  const std::vector<StateVector>& path_;
  double rate_share_s_;
};

class SimulatedRecording {
 public:
  SimulatedRecording(const Campaign& campaign, const Fitted& fitted, std::size_t recording,
                     const Eigen::VectorXd& theta, RandomStream& random)
      : campaign_(campaign),
        fit_(fitted.fit),
        place_(recording),
        recorded_(campaign.recordings[recording]),
        theta_(theta),
        random_(random),
        result_(recorded_),
        inputs_(campaign.recorded_inputs[recording]) {
    const Eigen::Index first = theta.size() - 1 - fit_.effects;
    ship_ = fitted.hypothesis.applied_to(campaign.ship_in(recording), theta.segment(first, fit_.effects), recording);
    // The simulated ship delays what acts; what acted before it was recorded has to be looked up.
    if (const double delay_s = rudder_response_of(ship_).delay_s; delay_s < 0.0) inputs_ = inputs_.through({delay_s});
    for (const Channel channel : kMeasured)
      if (result_.has(channel)) std::ranges::fill(result_[channel], kMissing);
  }

  /// Runs through a stretch. Noise of its samples: white, or of correlated channels a first-order process.
  void run(std::size_t s, const Vec6& correlation_s) {
    const Stretch& stretch = campaign_.stretches[s];
    const std::vector<double>& t = recorded_[Channel::t];
    const auto first = static_cast<std::size_t>(std::ranges::lower_bound(t, stretch.t_s.front()) - t.begin());
    const auto end = static_cast<std::size_t>(std::ranges::upper_bound(t, stretch.t_s.back()) - t.begin());
    const std::vector<StateVector>& path = fit_.smoothed[s].state;

    SimulatedShip ship(ship_);
    apply_uncertainty(ship.model, without_effects(theta_, fit_.effects));
    ship.state = {path.front().segment<3>(0), path.front().segment<3>(3)};
    ship.t_s = t[first];
    UnitProcess<3> model_error(fit_.noise.tau_s, random_);
    UnitProcess<2> wind_error(fit_.noise.wind_tau_s, random_);
    UnitProcess<2> receiver(fit_.noise.receiver_tau_s, random_);
    const double receiver_sd = fit_.noise.one_receiver ? fit_.noise.receiver_sd : 0.0;
    std::vector<UnitProcess<1>> noise;
    for (const double tau_s : correlation_s) noise.emplace_back(tau_s, random_);
    const Vec6 noise_sd = sample_sd(stretch, end - first, correlation_s);
    const Helmsman helmsman(stretch.t_s, path, ship_.particulars.L_pp);

    double now = 0.0;                            // the helmsman's correction
    Vec2<double> led_to = Vec2<double>::Zero();  // where the receiver's error has
    for (std::size_t i = first; i < end; ++i) {
      record(i, as_received(ship.state, receiver_sd * receiver.value(), led_to), now, noise, noise_sd);
      if (i + 1 == end) break;
      const double dt_s = t[i + 1] - t[i], then = helmsman.correction(t[i], ship.state);
      const std::size_t k = between(stretch.t_s, t[i]).before;
      const Vec3<double> scale = fit_.event_scale[s].empty() ? Vec3<double>::Ones() : fit_.event_scale[s][k];
      advance(ship, dt_s, now, then, fit_.noise.sigma_w.cwiseProduct(scale).cwiseProduct(model_error.value()),
              fit_.noise.wind_share * stretch.wind_speed_mps * wind_error.value());
      now = then;
      led_to += dt_s * receiver_sd * receiver.value();
      receiver.advance(dt_s);
      model_error.advance(dt_s);
      wind_error.advance(dt_s);
      for (UnitProcess<1>& one : noise) one.advance(dt_s);
    }
  }

  Trajectory result() && { return std::move(result_); }

 private:
  // As a receiver with a velocity error shows her.
  static ShipState<double> as_received(ShipState<double> state, const Vec2<double>& error, const Vec2<double>& led_to) {
    const double c = std::cos(state.eta(2)), s = std::sin(state.eta(2));
    state.nu.head<2>() += Vec2<double>(c * error(0) + s * error(1), -s * error(0) + c * error(1));
    state.eta.head<2>() += led_to;
    return state;
  }

  // Of one sample, whose mean over a point of the grid has the fit's.
  Vec6 sample_sd(const Stretch& stretch, std::size_t samples, const Vec6& correlation_s) const {
    const auto n = static_cast<Eigen::Index>(
        std::max(1.0, std::round(static_cast<double>(samples) / static_cast<double>(stretch.size()))));
    Vec6 result = fit_.noise.measurement_sd;
    for (Eigen::Index c = 0; c < result.size(); ++c) {
      const double kept = correlation_s[c] > 0.0 ? std::exp(-stretch.sample_s / correlation_s[c]) : 0.0;
      double of_mean = 0.0;
      for (Eigen::Index a = 0; a < n; ++a)
        for (Eigen::Index b = 0; b < n; ++b)
          of_mean += std::pow(kept, static_cast<double>(std::abs(a - b))) / static_cast<double>(n * n);
      result[c] /= std::sqrt(of_mean);
    }
    return result;
  }

  void advance(SimulatedShip& ship, double dt_s, double from, double to, const Vec3<double>& error,
               const Vec2<double>& wind_error) const {
    const double longest_s = kPolicy.show.longest_step_s * campaign_.time_scale();
    const auto steps = static_cast<int>(std::ceil(dt_s / longest_s));
    const double h = dt_s / steps;
    const double late_s = theta_[theta_.size() - 1] * kPolicy.filter.timing_share * sampling_time_s(recorded_);
    for (int i = 0; i < steps; ++i) {
      StepInputs<double> inputs = with_error(inputs_.step(ship.t_s - late_s, h), wind_error);
      const double by = (to - from) / steps, start = from + i * by;
      correct_rudders(inputs.start.actuators, start);
      correct_rudders(inputs.middle.actuators, start + 0.5 * by);
      correct_rudders(inputs.end.actuators, start + by);
      ship.state.nu += 0.5 * h * error;
      ship.advance(inputs, h);
      ship.state.nu += 0.5 * h * error;
    }
    if (!ship.is_finite())
      throw NumericalError(fmt::format("{}: the simulated ship runs away at {} s", recorded_.file, ship.t_s));
  }

  void correct_rudders(Actuators<double>& actuators, double by) const {
    for (const Actuator& actuator : ship_.actuators)
      if (actuator.is_rudder()) actuators[actuator.channel] = actuator.clip(actuators[actuator.channel] + by);
  }

  void record(std::size_t i, const ShipState<double>& state, double correction,
              const std::vector<UnitProcess<1>>& noise, const Vec6& noise_sd) {
    Vec6 seen;
    seen << state.eta, state.nu;
    for (std::size_t c = 0; c < kMeasured.size(); ++c) {
      const auto at = static_cast<Eigen::Index>(c);
      if (result_.has(kMeasured[c]) && std::isfinite(recorded_[kMeasured[c]][i]))
        result_[kMeasured[c]][i] = seen[at] + noise_sd[at] * noise[c].value()(0);
    }
    for (const Actuator& actuator : ship_.actuators)
      if (actuator.is_rudder() && result_.has(actuator.channel))
        result_[actuator.channel][i] = actuator.clip(recorded_[actuator.channel][i] + correction);
    if (!result_.has(Channel::app_wind_speed) || !result_.has(Channel::app_wind_dir)) return;
    const Vec2<double> wind = campaign_.recorded_inputs[place_].at(recorded_[Channel::t][i]).true_wind;
    const Vec2<double> apparent = apparent_wind<double>(wind, state.eta(2), state.nu(0), state.nu(1));
    result_[Channel::app_wind_speed][i] = apparent.norm();
    result_[Channel::app_wind_dir][i] = std::atan2(apparent(1), apparent(0));
  }

  const Campaign& campaign_;
  const FittedNull& fit_;
  std::size_t place_;
  const Trajectory& recorded_;
  const Eigen::VectorXd& theta_;
  RandomStream& random_;
  Trajectory result_;
  RecordedInputs inputs_;
  Ship ship_;
};

}  // namespace

std::vector<Trajectory> simulated_recordings(const Campaign& campaign, const Fitted& fitted, RandomStream random) {
  const Eigen::VectorXd theta = drawn_theta(fitted, random);
  Vec6 correlation_s = Vec6::Zero();
  for (const ChannelQuality& quality :
       channel_qualities(campaign.recordings, FroudeScale(campaign.ship.particulars.L_pp)))
    for (std::size_t c = 0; c < kMeasured.size(); ++c)
      if (kMeasured[c] == quality.channel) correlation_s[static_cast<Eigen::Index>(c)] = quality.correlation_s;
  std::vector<Trajectory> result;
  for (std::size_t r = 0; r < campaign.recordings.size(); ++r) {
    SimulatedRecording recording(campaign, fitted, r, theta, random);
    for (std::size_t s = 0; s < campaign.stretches.size(); ++s)
      if (campaign.stretches[s].recording == r) recording.run(s, correlation_s);
    result.push_back(std::move(recording).result());
  }
  return result;
}

}  // namespace leeway::gap
