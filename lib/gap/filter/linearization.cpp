#include <algorithm>
#include <cmath>
#include <optional>

#include <ceres/jet.h>

#include "core/statistics.hpp"
#include "core/units.hpp"
#include "gap/filter/reference_units.hpp"
#include "gap/filter/state_space.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {
namespace {

Vec6 initial_sd(const Ship& ship) {
  const double L = ship.particulars.L_pp, V = std::sqrt(kGravity_mps2 * L);
  constexpr FilterPolicy of = kPolicy.filter;
  const double position = of.initial_position_L * L, velocity = of.initial_froude * V;
  return (Vec6() << position, position, of.initial_heading_rad, velocity, velocity, of.initial_rate_froude * V / L)
      .finished();
}

// A mean over a bin in which the rate of the state changes is not its value at the mean time: to second order, half the
// variance of the sample times, times the second derivative; that from the simulator's rates at the neighbors, which
// know little of the measurements' noise.
//   end  (x, inputs, h_s): where a step leads
template <typename End>
std::vector<Vec6> mean_offsets(const End& end, const Stretch& stretch, const std::vector<StateVector>& path) {
  const std::size_t n = stretch.size();
  std::vector<Vec6> offsets(n, Vec6::Zero());
  if (*std::max_element(stretch.spread_s2.begin(), stretch.spread_s2.end()) == 0.0) return offsets;
  std::vector<Vec6> rate(n);
  for (std::size_t k = 0; k < n; ++k) {
    const Inputs<double>& in = k + 1 < n ? stretch.inputs[k].front().start : stretch.inputs[k - 1].back().end;
    const std::vector<StepInputs<double>> instant(1, StepInputs<double>{in, in, in});
    rate[k] =
        (end(path[k], instant, kPolicy.filter.instant_s) - path[k].head<kShipStates>()) / kPolicy.filter.instant_s;
  }
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t before = k > 0 ? k - 1 : k, after = std::min(k + 1, n - 1);
    offsets[k] = 0.5 * stretch.spread_s2[k] * (rate[after] - rate[before]) / (stretch.t_s[after] - stretch.t_s[before]);
  }
  return offsets;
}

}  // namespace

std::vector<StateVector> measured_path(const Stretch& stretch, std::size_t neighbors) {
  const std::size_t n = stretch.size();
  std::vector<StateVector> path(n, StateVector::Zero());
  for (int i = 0; i < kShipStates; ++i) {
    std::vector<std::size_t> known;
    for (std::size_t k = 0; k < n; ++k)
      if (!std::isnan(stretch.measured[k][i])) known.push_back(k);
    if (known.empty()) continue;
    std::vector<double> value;
    for (std::size_t j = 0; j < known.size(); ++j) {
      std::vector<double> around;
      for (std::size_t l = j - std::min(j, neighbors); l <= std::min(j + neighbors, known.size() - 1); ++l)
        around.push_back(stretch.measured[known[l]][i]);
      value.push_back(median(std::move(around)));
    }
    std::size_t next = 0;
    for (std::size_t k = 0; k < n; ++k) {
      while (next < known.size() && known[next] < k) ++next;
      const std::size_t after = std::min(next, known.size() - 1), before = next > 0 ? next - 1 : 0;
      const std::size_t a = known[before], b = known[after];
      const double weight =
          b > a && k < b ? (stretch.t_s[k] - stretch.t_s[a]) / (stretch.t_s[b] - stretch.t_s[a]) : 1.0;
      path[k][i] = value[before] + weight * (value[after] - value[before]);
    }
  }
  bool has_heading = false;
  for (const Vec6& y : stretch.measured) has_heading |= !std::isnan(y[2]);
  for (std::size_t k = 1; k < n && !has_heading; ++k)
    path[k][2] = path[k - 1][2] + stretch.dt_s(k - 1) * path[k - 1][5];
  return path;
}

namespace {

// Derivatives of advance(). By the state and the wind's error: by automatic differentiation through the Runge-Kutta
// steps. By theta, of which there are many: those of the acceleration in the middle of each substep, carried to its end
// (midpoint rule), which is about a hundredth off. A kick's are exact.
// Where the model switches within a tenth of the speed, as a rudder's inflow where the propeller begins to push, a
// derivative knows nothing of when it does; there those by theta are slopes of chords over a tenth to both sides, and
// what the switch changes is not certain.
class Derivatives {
 public:
  Derivatives(const Ship& ship, const Eigen::VectorXd& theta)
      : ship_(ship), plain_(ship), by_state_(ship), theta_(theta) {
    switching_ << kPolicy.filter.switching_mps2, kPolicy.filter.switching_mps2,
        kPolicy.filter.switching_mps2 / gyration_radius(ship);  // the same at any scale
    apply_uncertainty(plain_, theta);
    apply_uncertainty(by_state_, theta);
    for (Eigen::Index first = 0; first < theta.size(); first += kDirections) {
      Eigen::Matrix<ByTheta, Eigen::Dynamic, 1> dual = theta.cast<ByTheta>();
      for (Eigen::Index j = 0; j < std::min<Eigen::Index>(kDirections, theta.size() - first); ++j)
        dual[first + j].v[j] = 1.0;
      apply_uncertainty(by_theta_.emplace_back(ship), dual);
    }
    acceleration_by_theta_.resize(3, theta.size());
  }

  const Model<double>& plain() const { return plain_; }

  /// The end of the step; A, spread and the part of G that is not the timing's are written.
  Vec6 advance(const StateVector& x, const std::vector<StepInputs<double>>& inputs, double h_s, LinearStep& step) {
    Vec6 end = advance(x, inputs, h_s, step, false);
    step.spread = switched(x, with_error(inputs[inputs.size() / 2], Vec2<double>(x.tail<2>())).middle);
    if ((step.spread.diagonal().cwiseSqrt().array() > switching_.array()).any()) advance(x, inputs, h_s, step, true);
    return end;
  }

 private:
  using ByState = ceres::Jet<double, kShipStates + 2>;
  static constexpr int kDirections = 16;
  using ByTheta = ceres::Jet<double, kDirections>;

  // Covariance of the accelerations that a switch within a tenth of the speed changes, to one side: what the chord
  // differs by from the tangent, to which curves add nothing up to the third order.
  Mat3<double> switched(const StateVector& x, const Inputs<double>& in) const {
    const ShipState<double> at = through_water(x.head<kShipStates>(), in.t_s);
    const double chord = kPolicy.filter.chord * at.nu.head<2>().norm();
    const auto slope = [&](double by) {
      ShipState<double> less = at, more = at;
      less.nu(0) -= by;
      more.nu(0) += by;
      return Vec3<double>((rate_of_change(plain_, more, in).nu - rate_of_change(plain_, less, in).nu) / (2.0 * by));
    };
    if (!(chord > 0.0)) return Mat3<double>::Zero();
    const Vec3<double> half = chord * (slope(chord) - slope(kPolicy.filter.tangent * chord));
    return 2.0 * half * half.transpose();  // all of it or nothing, as likely
  }

  ShipState<double> through_water(const Vec6& over_ground, double t_s) const {
    ShipState<double> at{over_ground.head<3>(), over_ground.tail<3>()};
    if (plain_.moves_water()) at.nu -= water_velocity(plain_, at.eta, t_s);
    return at;
  }

  Vec6 advance(const StateVector& x, const std::vector<StepInputs<double>>& inputs, double h_s, LinearStep& step,
               bool by_chords) {
    Vec6 state = x.head<kShipStates>();
    auto G = step.G.leftCols(theta_.size());
    step.A.leftCols<kShipStates>().setIdentity();
    step.A.rightCols<kStates - kShipStates>().setZero();
    G.setZero();
    const auto kick = [&] {
      state.tail<3>() += 0.5 * h_s * x.segment<3>(kErrorStart);
      step.A.block<3, 3>(3, kErrorStart).diagonal().array() += 0.5 * h_s;
    };
    for (const StepInputs<double>& in : inputs) {
      kick();
      const Vec6 begin = state;
      Eigen::Matrix<ByState, kShipStates, 1> dual = begin.cast<ByState>();
      for (int i = 0; i < kShipStates; ++i) dual[i].v[i] = 1.0;
      Vec2<ByState> wind_error = x.tail<2>().cast<ByState>();
      for (int i = 0; i < 2; ++i) wind_error[i].v[kShipStates + i] = 1.0;
      const ShipState<ByState> end =
          integrate(by_state_, ShipState<ByState>{dual.head<3>(), dual.tail<3>()}, with_error(in, wind_error), h_s);
      Eigen::Matrix<double, kShipStates, kShipStates> F;
      Eigen::Matrix<double, kShipStates, 2> W;
      for (int i = 0; i < kShipStates; ++i) {
        const ByState& y = i < 3 ? end.eta[i] : end.nu[i - 3];
        state[i] = y.a;
        F.row(i) = y.v.head<kShipStates>();
        W.row(i) = y.v.tail<2>();
      }
      step.A = F.lazyProduct(step.A).eval();
      step.A.rightCols<2>() += W;
      if (&in != &inputs.front()) G = F.lazyProduct(G).eval();
      find_acceleration_by_theta(0.5 * (begin + state), with_error(in, Vec2<double>(x.tail<2>())).middle, by_chords);
      Eigen::Matrix<double, kShipStates, 3> from_middle = 0.5 * h_s * F.rightCols<3>();
      from_middle.bottomRows<3>().diagonal().array() += 0.5 * h_s;
      G += from_middle.lazyProduct(acceleration_by_theta_);
      kick();
    }
    return state;
  }

  void find_acceleration_by_theta(const Vec6& over_ground, const Inputs<double>& in, bool by_chords) {
    const ShipState<double> at = through_water(over_ground, in.t_s);
    if (by_chords) {
      for (Eigen::Index j = 0; j < theta_.size(); ++j) {
        const auto [less, more] = beside(j);
        acceleration_by_theta_.col(j) =
            (rate_of_change(more, at, in).nu - rate_of_change(less, at, in).nu) / (2.0 * kPolicy.filter.chord);
      }
      return;
    }
    const ShipState<ByTheta> state{at.eta.cast<ByTheta>(), at.nu.cast<ByTheta>()};
    const Inputs<ByTheta> inputs{in.actuators.cast<ByTheta>(), in.true_wind.cast<ByTheta>(), in.t_s};
    for (std::size_t pass = 0; pass < by_theta_.size(); ++pass) {
      const Vec3<ByTheta> acceleration = rate_of_change(by_theta_[pass], state, inputs).nu;
      const Eigen::Index first = static_cast<Eigen::Index>(pass) * kDirections,
                         count = std::min<Eigen::Index>(kDirections, theta_.size() - first);
      for (int i = 0; i < 3; ++i)
        acceleration_by_theta_.row(i).segment(first, count) = acceleration[i].v.head(count).transpose();
    }
  }

  // The model with a coefficient less and more.
  std::pair<const Model<double>&, const Model<double>&> beside(Eigen::Index j) {
    if (beside_.empty())
      for (Eigen::Index i = 0; i < theta_.size(); ++i)
        for (const double by : {-kPolicy.filter.chord, kPolicy.filter.chord})
          apply_uncertainty(beside_.emplace_back(ship_),
                            (theta_ + by * Eigen::VectorXd::Unit(theta_.size(), i)).eval());
    return {beside_[static_cast<std::size_t>(2 * j)], beside_[static_cast<std::size_t>(2 * j + 1)]};
  }

  const Ship& ship_;
  Vec3<double> switching_;  // accelerations from which on a step counts as one in which the model switches
  Model<double> plain_;
  Model<ByState> by_state_;
  std::vector<Model<double>> beside_;     // two for each of theta, where they are needed
  std::vector<Model<ByTheta>> by_theta_;  // kDirections of theta each
  Eigen::VectorXd theta_;
  ByRow<3> acceleration_by_theta_;
};

// Renews the path of a stretch as its steps are linearized: the filter takes the measurements up to each point.
class PathFilter {
 public:
  PathFilter(LinearStretch& stretch, const Noise& noise) : stretch_(stretch), filter_(stretch, noise, 0) {
    filter_.update(0, [](auto&&...) {});
  }
  /// When step k stands.
  void follow(std::size_t k) {
    filter_.predict(k);
    filter_.update(k + 1, [](auto&&...) {});
    if (k + 1 < kPolicy.filter.first_points) return;
    stretch_.path[k + 1] += filter_.mean.head<kStates>();
    stretch_.steps[k].offset -= filter_.mean.head<kShipStates>();
    filter_.mean.head<kStates>().setZero();
  }

 private:
  LinearStretch& stretch_;
  Filter filter_;
};

// What the errors of the inputs do to step k, each by its standard deviation.
//   end      of the step with the inputs as recorded
//   advance  the step with others
template <typename Advance>
ByRow<kShipStates> by_actuators(const Stretch& stretch, std::size_t k, const Vec6& end, const Advance& advance) {
  ByRow<kShipStates> result = ByRow<kShipStates>::Zero(kShipStates, kActuatorErrors);
  for (std::size_t a = 0; a < stretch.uncertain.size(); ++a) {
    const double sd = stretch.actuator_errors[k].sd[a];
    if (sd == 0.0) continue;
    std::vector<StepInputs<double>> inputs = stretch.inputs[k];
    for (StepInputs<double>& in : inputs)
      for (Inputs<double>* at : {&in.start, &in.middle, &in.end}) at->actuators[stretch.uncertain[a]] += sd;
    result.col(static_cast<Eigen::Index>(a)) = advance(inputs) - end;
  }
  return result;
}

// Closes the loop of a helmsman in step k: its first and last angle are those of the law, the last one by where the
// step leads.
//   end      of the step with the inputs as recorded
//   advance  the step with others
template <typename Advance>
void close_loop(const LinearStretch& of, std::size_t k, const Vec6& end, const Advance& advance, LinearStep& step) {
  const Stretch& stretch = *of.data;
  const HelmLaw& law = *stretch.helm;
  if (std::isnan(law.angle[k]) || std::isnan(law.angle[k + 1])) return;
  const auto by_angle = [&](const auto& share) -> Vec6 {
    std::vector<StepInputs<double>> inputs = stretch.inputs[k];
    const double parts = static_cast<double>(inputs.size());
    for (std::size_t i = 0; i < inputs.size(); ++i) {
      const double begin = static_cast<double>(i) / parts;
      for (const auto& [at, when] :
           {std::pair{&inputs[i].start, begin}, std::pair{&inputs[i].middle, begin + 0.5 / parts},
            std::pair{&inputs[i].end, begin + 1.0 / parts}})
        for (const Channel rudder : law.rudders) at->actuators[rudder] += kPolicy.filter.helm_difference * share(when);
    }
    return (advance(inputs) - end) / kPolicy.filter.helm_difference;
  };
  const Vec6 by_first = by_angle([](double when) { return 1.0 - when; }),
             by_last = by_angle([](double when) { return when; });
  Eigen::Matrix<double, 1, kShipStates> by_ship = Eigen::Matrix<double, 1, kShipStates>::Zero();
  by_ship[2] = law.per_heading;
  by_ship[5] = law.per_rate_s;
  const auto off = [&](std::size_t i) { return law.at(of.path[i][2], of.path[i][5]) - law.angle[i]; };
  // (1 - by_last by_ship)^-1, after Sherman & Morrison.
  step.answer =
      Eigen::Matrix<double, kShipStates, kShipStates>::Identity() + by_last * by_ship / (1.0 - by_ship.dot(by_last));
  step.A.leftCols<kShipStates>() += by_first * by_ship;
  step.A = *step.answer * step.A;
  step.offset = *step.answer * (step.offset + by_first * off(k) + by_last * off(k + 1));
  step.G = *step.answer * step.G;
  step.by_actuators = *step.answer * step.by_actuators;
  for (std::size_t a = 0; a < stretch.uncertain.size(); ++a)  // that nobody has used
    if (info(stretch.uncertain[a]).role == Role::rudder) step.by_actuators.col(static_cast<Eigen::Index>(a)).setZero();
  step.by_helm = law.sd * (*step.answer * (by_first + by_last));
}

// Derivatives of the steps along result.path, which the filter renews on the way if there is `noise`.
LinearStretch linearize(const Ship& ship, LinearStretch result, const Eigen::VectorXd& theta, const Noise* noise) {
  const Stretch& stretch = *result.data;
  result.steps.resize(stretch.size() - 1);
  result.initial_sd = initial_sd(ship);
  const Eigen::Index p = theta.size() - 1, timing = p;
  for (LinearStep& step : result.steps) step.G.resize(kShipStates, p + 1);
  Derivatives derivatives(ship, theta.head(p));
  const Model<double>& plain = derivatives.plain();
  std::optional<PathFilter> filter;
  if (noise != nullptr) filter.emplace(result, *noise);
  for (std::size_t k = 0; k + 1 < stretch.size(); ++k) {
    LinearStep& step = result.steps[k];
    const double h = stretch.dt_s(k) / static_cast<double>(stretch.inputs[k].size());
    const Vec6 end = derivatives.advance(result.path[k], stretch.inputs[k], h, step);
    step.G.col(timing) = advance<double>(plain, result.path[k], stretch.late_inputs[k], h) - end;
    step.offset = end - result.path[k + 1].head<kShipStates>() + theta[timing] * step.G.col(timing);
    if (!stretch.uncertain.empty())
      step.by_actuators = by_actuators(stretch, k, end, [&](const std::vector<StepInputs<double>>& inputs) {
        return advance<double>(plain, result.path[k], inputs, h);
      });
    if (stretch.helm)
      close_loop(
          result, k, end, [&](const auto& inputs) { return advance<double>(plain, result.path[k], inputs, h); }, step);
    if (filter) filter->follow(k);
  }
  result.mean_offset =
      mean_offsets([&](const auto& x, const auto& inputs, double h) { return advance<double>(plain, x, inputs, h); },
                   stretch, result.path);
  for (std::size_t k = 0; k < stretch.size(); ++k) result.mean_offset[k] += stretch.by_faults.of(k, theta);
  return result;
}

// The same with an ensemble.
LinearStretch linearize(const EnsembleSimulator& simulator, LinearStretch result, const Eigen::VectorXd& theta,
                        const Noise* noise) {
  const Stretch& stretch = *result.data;
  result.steps.resize(stretch.size() - 1);
  result.initial_sd = initial_sd(simulator.ship());
  result.untrained_sd = simulator.typical_acceleration();
  EnsembleSteps steps(simulator);
  std::optional<PathFilter> filter;
  if (noise != nullptr) filter.emplace(result, *noise);
  for (std::size_t k = 0; k + 1 < stretch.size(); ++k) {
    const StateVector& x = result.path[k];
    const std::vector<StepInputs<double>>& inputs = stretch.inputs[k];
    const double h = stretch.dt_s(k) / static_cast<double>(inputs.size());
    const EnsembleSteps::Step to = steps.step(x, inputs, h);
    LinearStep& step = result.steps[k];
    step.A = to.derivatives;
    step.spread = to.spread;
    const std::vector<double> beyond = simulator.beyond(x[2], x.segment<3>(3), inputs.front().start);
    step.beyond = beyond.empty() ? 0.0 : *std::max_element(beyond.begin(), beyond.end());
    step.G = steps.end(x, stretch.late_inputs[k], h) - to.end;
    step.offset = to.end - result.path[k + 1].head<kShipStates>() + theta[0] * step.G;
    if (!stretch.uncertain.empty())
      step.by_actuators = by_actuators(stretch, k, to.end, [&](const std::vector<StepInputs<double>>& acting) -> Vec6 {
        return steps.end(x, acting, h);
      });
    if (filter) filter->follow(k);
  }
  result.mean_offset = mean_offsets(
      [&](const auto& x, const auto& inputs, double h) { return steps.end(x, inputs, h); }, stretch, result.path);
  return result;
}

LinearStretch begun(std::shared_ptr<const Stretch> stretch, std::vector<StateVector> path) {
  LinearStretch result{};
  result.data = std::move(stretch);
  result.path = std::move(path);
  return result;
}

LinearStretch begun(const LinearStretch& before, std::shared_ptr<const Stretch> data,
                    std::vector<Vec3<double>> event_scale) {
  LinearStretch result = begun(std::move(data), before.path);
  result.mean_offset = before.mean_offset;
  result.event_scale = std::move(event_scale);
  return result;
}

}  // namespace

LinearStretch linearize(const Ship& ship, std::shared_ptr<const Stretch> stretch, std::vector<StateVector> path,
                        const Eigen::VectorXd& theta) {
  return linearize(ship, begun(std::move(stretch), std::move(path)), theta, nullptr);
}

LinearStretch linearize(const EnsembleSimulator& simulator, std::shared_ptr<const Stretch> stretch,
                        std::vector<StateVector> path, const Eigen::VectorXd& theta) {
  return linearize(simulator, begun(std::move(stretch), std::move(path)), theta, nullptr);
}

LinearStretch linearize_filtered(const Ship& ship, const LinearStretch& before, std::shared_ptr<const Stretch> data,
                                 const Noise& noise, std::vector<Vec3<double>> event_scale,
                                 const Eigen::VectorXd& theta) {
  return linearize(ship, begun(before, std::move(data), std::move(event_scale)), theta, &noise);
}

LinearStretch linearize_filtered(const EnsembleSimulator& simulator, const LinearStretch& before,
                                 std::shared_ptr<const Stretch> data, const Noise& noise,
                                 std::vector<Vec3<double>> event_scale, const Eigen::VectorXd& theta) {
  return linearize(simulator, begun(before, std::move(data), std::move(event_scale)), theta, &noise);
}

}  // namespace leeway::gap
