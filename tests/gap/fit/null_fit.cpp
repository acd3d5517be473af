#include <catch2/catch.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/errors.hpp"
#include "core/random.hpp"
#include "core/units.hpp"
#include "dynamics/maneuvers.hpp"
#include "dynamics/model_parts.hpp"
#include "dynamics/observation_noise.hpp"
#include "gap/detect/detect.hpp"
#include "gap/filter/campaign.hpp"
#include "gap/fit/events.hpp"
#include "gap/locate/locate.hpp"
#include "gap/sensors/channel_quality.hpp"
#include "gap/simulated_campaign.hpp"

using namespace leeway;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinRel;

namespace {

// Two zigzags with noise; the ship may have more physics than the simulator.
//   correlation  of the noise from sample to sample
std::vector<Trajectory> zigzags(const Ship& truth, double duration_s = 200.0, std::uint64_t seed = 1,
                                double correlation = 0.0) {
  std::vector<Trajectory> recordings;
  for (const double angle_deg : {15.0, 25.0}) {
    SimulatedShip ship(truth);
    Trajectory run;
    double side = 1.0;
    const auto steps = static_cast<int>(duration_s / 0.1);
    for (int k = 0; k <= steps; ++k) {
      if (k % 10 == 0) append_sample(run, truth, 0.1 * k, ship.state, {ship.actuators, Vec2<double>::Zero(), 0.1 * k});
      if (side * ship.state.eta(2) > angle_deg * kDegree) side = -side;
      Actuators<double> command = truth.initial_actuators();
      for (const Actuator& actuator : truth.actuators)
        if (actuator.is_rudder()) command[actuator.channel] = side * angle_deg * kDegree;
      ship.step(command, Vec2<double>::Zero(), 0.1);
    }
    RandomStream random(seed, "zigzags", static_cast<std::uint64_t>(angle_deg));
    const std::array<double, 6> sd{0.03, 0.03, 0.1 * kDegree, 0.01, 0.01, 0.1 * kDegree};
    for (std::size_t c = 0; c < gap::kMeasured.size(); ++c) {
      double noise = random.normal();
      for (double& x : run[gap::kMeasured[c]]) {
        x += sd[c] * noise;
        noise = correlation * noise + std::sqrt(1.0 - correlation * correlation) * random.normal();
      }
    }
    run[Channel::wind_speed].clear();
    run[Channel::wind_dir].clear();
    run[Channel::app_wind_speed].clear();
    run[Channel::app_wind_dir].clear();
    run.name = run.file = "zigzag" + std::to_string(static_cast<int>(angle_deg));
    recordings.push_back(std::move(run));
  }
  return recordings;
}

Ship with_effect(Ship ship, const std::string& type,
                 const std::vector<std::pair<std::string, std::optional<double>>>& parameters) {
  ship.effects.push_back({type, parameters, "ship.json", "/effects/0"});
  return ship;
}

}  // namespace

TEST_CASE("gap: coefficients that the file lets go together stay together", "[gap]") {
  Ship stated = read_ship("esso-osaka-3m");
  // What a zigzag tells of the added mass in sway holds for one that it tells nothing about.
  stated.coefficient_covariance =
      Ship::JointUncertainty{{"inertia.m_y", "wind.k_X"}, (Eigen::Matrix2d() << 0.04, 0.04, 0.04, 0.04).finished()};
  Ship truth = stated;
  truth.multiply({{"inertia.m_y", 1.2}});
  const gap::FittedNull fit = gap::fit_null(gap::prepare(stated, zigzags(truth, 120.0), {}), {});
  const auto shift = [&](const std::string& name) {
    for (std::size_t i = 0; i < fit.parameters.size(); ++i)
      if (fit.parameters[i].name == name) return fit.theta[static_cast<Eigen::Index>(i)];
    throw std::out_of_range(name);
  };
  CHECK(shift("inertia.m_y") > 0.05);
  CHECK(shift("wind.k_X") == Approx(shift("inertia.m_y")).epsilon(0.01));
  CHECK(std::abs(shift("wind.k_Y")) < 1e-3);  // calm air
}

TEST_CASE("gap: noise levels are recovered, and a perfect simulator errs by nothing", "[gap][long]") {
  const Ship ship = read_ship("esso-osaka-3m");
  gap::Campaign campaign = gap::prepare(ship, zigzags(ship), {});
  const gap::FittedNull fit = gap::fit_null(campaign, {});
  CHECK(fit.report.converged);
  // 400 samples each: standard error 3.5 %.
  const std::array<double, 6> planted{0.03, 0.03, 0.1, 0.01, 0.01, 0.1};
  for (std::size_t i = 0; i < planted.size(); ++i) {
    CAPTURE(fit.report.noise[i].name);
    CHECK_THAT(fit.report.noise[i].value, WithinRel(planted[i], 0.15));
  }
  for (int axis = 0; axis < 3; ++axis) CHECK(fit.report.sigma_w[axis] < 0.15 * fit.report.typical[axis]);
  CHECK_FALSE(fit.report.receiver);
  for (const gap::ParameterShift& shift : fit.report.parameters) {
    CAPTURE(shift.name);
    CHECK(std::abs(shift.factor - 1.0) < 4.0 * shift.factor_sd + 0.02);
  }
}

TEST_CASE("gap: an error that positions and velocities share is the receiver's, not the simulator's", "[gap][long]") {
  const Ship ship = read_ship("esso-osaka-3m");
  constexpr double sd_mps = 0.02, tau_s = 3.0;
  std::vector<Trajectory> recordings = zigzags(ship, 300.0);
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    Trajectory& run = recordings[r];
    RandomStream random(5, "receiver", r);
    const double kept = std::exp(-1.0 / tau_s);
    Vec2<double> error(sd_mps * random.normal(), sd_mps * random.normal()), way = Vec2<double>::Zero();
    for (std::size_t k = 0; k < run.size(); ++k) {
      const double c = std::cos(run[Channel::psi][k]), s = std::sin(run[Channel::psi][k]);
      run[Channel::u][k] += c * error(0) + s * error(1);
      run[Channel::vm][k] += -s * error(0) + c * error(1);
      run[Channel::x0][k] += way(0);
      run[Channel::y0][k] += way(1);
      const Vec2<double> next =
          kept * error + sd_mps * std::sqrt(1.0 - kept * kept) * Vec2<double>(random.normal(), random.normal());
      way += 0.5 * (error + next);
      error = next;
    }
  }
  const gap::FittedNull fit = gap::fit_null(gap::prepare(ship, recordings, {}), {});
  CHECK(fit.report.converged);
  REQUIRE(fit.report.receiver);
  CHECK_THAT(fit.report.receiver->sd_mps, WithinRel(sd_mps, 0.25));
  CHECK_THAT(fit.report.receiver->tau_s, WithinRel(tau_s, 0.5));
  for (int axis = 0; axis < 3; ++axis) CHECK(fit.report.sigma_w[axis] < 0.15 * fit.report.typical[axis]);
}

TEST_CASE("gap: correlated noise is not taken for a simulator that errs", "[gap][long]") {
  const Ship ship = read_ship("esso-osaka-3m");
  gap::Campaign campaign = gap::prepare(ship, zigzags(ship, 300.0, 1, std::exp(-0.5)), {});
  CHECK_THAT(fmt::format("{}", fmt::join(campaign.notices, "; ")),
             Contains("u_mps") && Contains("are alike: one measurement every 3 s is used"));
  for (const gap::Stretch& stretch : campaign.stretches) {
    double last_s = -3.0;
    for (std::size_t k = 0; k < stretch.size(); ++k) {
      if (std::isnan(stretch.measured[k][3])) continue;
      CHECK(stretch.t_s[k] - last_s == Approx(3.0));
      last_s = stretch.t_s[k];
    }
  }
  const gap::FittedNull fit = gap::fit_null(campaign, {});
  CHECK(fit.report.converged);
  for (std::size_t i = 0; i < 2; ++i) CHECK_THAT(fit.report.noise[i].value, WithinRel(0.03, 0.3));
  for (int axis = 0; axis < 3; ++axis) CHECK(fit.report.sigma_w[axis] < 0.15 * fit.report.typical[axis]);
}

TEST_CASE("gap: an acceleration error of known size is estimated as such", "[gap][long]") {
  const Ship ship = read_ship("esso-osaka-3m");
  const Ship truth =
      with_effect(ship, "model-error",
                  {{"surge_mps2", 1e-3}, {"sway_mps2", 1e-3}, {"yaw_degps2", 0.08}, {"tau_s", 12.0}, {"seed", 3.0}});
  gap::Campaign campaign = gap::prepare(ship, zigzags(truth, 400.0), {});
  const gap::FittedNull fit = gap::fit_null(campaign, {});
  // About 60 correlation times in all: 10 % and more of standard error, and parameters take a part.
  CHECK_THAT(fit.report.sigma_w[0], WithinRel(1e-3, 0.5));
  CHECK_THAT(fit.report.sigma_w[1], WithinRel(1e-3, 0.5));
  CHECK_THAT(fit.report.sigma_w[2], WithinRel(0.08 * kDegree, 0.5));
}

TEST_CASE("gap: a single speed that no ship has ends no fit, and is left out", "[gap]") {
  const Ship ship = read_ship("vectwin-3m");
  std::vector<Trajectory> recordings = zigzags(ship);
  const gap::FittedNull before = gap::fit_null(gap::prepare(ship, recordings, {}), {.jobs = 2});
  recordings[1][Channel::u][50] = 20.0;
  const gap::FittedNull fit = gap::fit_null(gap::prepare(ship, recordings, {}), {.jobs = 2});
  CHECK(fit.report.outliers > before.report.outliers);
  CHECK(fit.report.outliers < before.report.outliers + 6);  // and what it drew along beside it
  CHECK((fit.theta - before.theta).cwiseQuotient(fit.prior.sd()).cwiseAbs().maxCoeff() < 0.2);
  // What no simulator follows is told with the measurement that is farthest from the others.
  for (std::size_t k = 50; k < 60; ++k) recordings[1][Channel::u][k] = 2000.0;
  CHECK_THROWS_WITH(gap::fit_null(gap::prepare(ship, recordings, {}), {.jobs = 2}),
                    Contains("zigzag25") && Contains("u_mps is 2000 at 5"));
}

// A heading that is 1 deg off stands out by less than 6 sd from what was recorded before, where the simulator errs in
// yaw.
TEST_CASE("gap: outliers are those that lie far from what is recorded before and after them", "[gap][long]") {
  const Ship ship = read_ship("esso-osaka-3m");
  const Ship truth =
      with_effect(ship, "model-error",
                  {{"surge_mps2", 1e-3}, {"sway_mps2", 1e-3}, {"yaw_degps2", 0.08}, {"tau_s", 12.0}, {"seed", 3.0}});
  std::vector<Trajectory> recordings = zigzags(truth, 400.0);
  std::size_t planted = 0;
  for (Trajectory& run : recordings)
    for (std::size_t k = 20; k < run.size(); k += 40, ++planted)
      run[Channel::psi][k] += (k % 80 == 20 ? 1.0 : -1.0) * kDegree;
  gap::Campaign campaign = gap::prepare(ship, std::move(recordings), {});
  const gap::FittedNull fit = gap::fit_null(campaign, {});
  CHECK(fit.report.outliers >= planted - 1);  // noise of its own brings one of them back
  CHECK(fit.report.outliers <= planted);
  REQUIRE(fit.report.noise[2].name == "psi_deg");
  CHECK_THAT(fit.report.noise[2].value, WithinRel(0.1, 0.15));
}

TEST_CASE("gap: nothing is found where nothing is, a current is found and named first", "[gap][long]") {
  const Ship ship = read_ship("esso-osaka-3m");
  const auto detect = [&](const Ship& truth) {
    gap::Campaign campaign = gap::prepare(ship, zigzags(truth), {});
    const gap::FittedNull fit = gap::fit_null(campaign, {});
    gap::DetectOptions options;
    options.refitted = 2;
    return gap::detect(campaign, fit, gap::EffectLibrary(campaign, fit), options);
  };
  CHECK(detect(ship).p_value > 0.01);
  const gap::Detection found =
      detect(with_effect(ship, "steady-current", {{"current_speed_mps", 0.05}, {"current_set_deg", 80.0}}));
  CHECK(found.p_value < 1e-6);
  REQUIRE_FALSE(found.effects.empty());
  CHECK(found.effects.front().name == "steady-current");
}

// What the rudder feels halves where the propeller ceases to push, and when it does hangs on the wake.
TEST_CASE("gap: a step of the model that comes earlier or later than thought is nothing missing", "[gap][long]") {
  const Ship ship = read_ship("esso-osaka-3m");
  Ship truth = ship;
  truth.multiply({{"propeller.1-w_P", 0.94}});
  std::vector<Trajectory> recordings;
  for (const double side : {1.0, -1.0}) {
    SimulatedShip at(truth);
    Trajectory run;
    for (int k = 0; k <= 2400; ++k) {
      if (k % 10 == 0) append_sample(run, truth, 0.1 * k, at.state, {at.actuators, Vec2<double>::Zero(), 0.1 * k});
      Actuators<double> command = truth.initial_actuators();
      command[Channel::delta] = (k / 200 % 2 == 0 ? side : -side) * 18.0 * kDegree;
      if (k / 600 % 2 == 1) command[Channel::n_p] *= 0.27;
      at.step(command, Vec2<double>::Zero(), 0.1);
    }
    run.name = run.file = side > 0.0 ? "starboard" : "port";
    recordings.push_back(observed(run, test::usual_noise(), RandomStream(5, run.name, 0)));
  }
  gap::Campaign campaign = gap::prepare(ship, std::move(recordings), {});
  const gap::FittedNull fit = gap::fit_null(campaign, {});
  CHECK(gap::detect(campaign, fit, gap::EffectLibrary(campaign, fit), {}).p_value > 0.01);
}

TEST_CASE("gap: a tug is located in time, in axis and along the ship", "[gap][long]") {
  const Ship ship = read_ship("esso-osaka-3m");
  const Ship truth = with_effect(
      ship, "tug", {{"force_N", 0.8}, {"direction_deg", 90.0}, {"x_m", 1.0}, {"t_start_s", 80.0}, {"t_end_s", 140.0}});
  gap::Campaign campaign = gap::prepare(ship, zigzags(truth), {});
  const gap::FittedNull fit = gap::fit_null(campaign, {});
  const gap::Location location = gap::locate(campaign, fit, {});
  CHECK(location.scan_p_value < 0.01);
  REQUIRE(location.located.intervals.size() >= 2);
  for (std::size_t i = 0; i < 2; ++i) {  // blocks are 10 s long
    CHECK(std::abs(location.located.intervals[i].t_start_s - 80.0) <= 20.0);
    CHECK(std::abs(location.located.intervals[i].t_end_s - 140.0) <= 20.0);
    CHECK(location.located.intervals[i].axis != 0);
  }
  // The tug is an event, no everyday error of the simulator: 0.8 N on 115 kg in sway are 7 mm/s^2.
  CHECK(fit.report.sigma_w[1] < 2e-3);
  REQUIRE(location.located.line_of_action);
  const gap::Estimate& x_F = *location.located.line_of_action;
  CHECK(std::abs(x_F.value - 1.0 / 3.0) < 3.0 * x_F.sd + 0.03);
}

TEST_CASE("gap: an event gains more than it costs, and where nothing acts there is none", "[gap][long]") {
  const Ship ship = read_ship("esso-osaka-3m");
  const Ship pushed = with_effect(
      ship, "tug", {{"force_N", 0.8}, {"direction_deg", 90.0}, {"x_m", 1.0}, {"t_start_s", 80.0}, {"t_end_s", 140.0}});
  for (const Ship& truth : {ship, pushed}) {
    const gap::Campaign campaign = gap::prepare(ship, zigzags(truth), {});
    const gap::FittedNull fit = gap::fit_null(campaign, {});
    const std::vector<gap::Event> events = gap::events_of(fit, campaign);
    CHECK(events.empty() == truth.effects.empty());
    CHECK((fit.log_prior_of_events < 0.0) == !events.empty());
    for (const gap::Event& event : events) {
      CAPTURE(event.stretch, event.begin, event.end, event.axis);
      gap::FittedNull without = fit;
      gap::leave_out(event, without);
      without.total = gap::Evidence(fit.theta.size());
      for (std::size_t s = 0; s < without.stretches.size(); ++s) {
        without.stretches[s].event_scale = without.event_scale[s];
        without.total += gap::evidence(without.stretches[s], without.noise);
      }
      CHECK(gap::log_evidence(without) < gap::log_evidence(fit));
    }
  }
}

TEST_CASE("gap: force residuals are the inertia matrix times the accelerations", "[gap]") {
  const Ship ship = read_ship("esso-osaka-3m");
  gap::Campaign campaign = gap::prepare(ship, zigzags(ship, 60.0), {});
  const gap::FittedNull fit = gap::fit_null(campaign, {});
  const Inertia<double> inertia(ship.inertia, ship.particulars);
  for (const gap::Residual& residual : gap::residuals(campaign, fit)) {
    REQUIRE(residual.t_s.size() == 61);
    for (std::size_t k = 0; k < residual.t_s.size(); k += 7) {
      // At rest the equations of motion hold nothing but the inertia.
      const Vec3<double> back = inertia.acceleration(Vec3<double>::Zero(), residual.force[k]);
      for (int axis = 0; axis < 3; ++axis) CHECK(back[axis] == Approx(residual.acceleration[k][axis]).margin(1e-15));
      CHECK(residual.acceleration_sd[k].minCoeff() > 0.0);
    }
  }
}

TEST_CASE("gap: fast recordings are thinned to means, missing samples stay missing, long gaps end a stretch", "[gap]") {
  const Ship ship = read_ship("esso-osaka-3m");
  Trajectory run;
  for (int i = 0; i < 2000; ++i) {
    const double t = 0.1 * i + (i >= 1000 ? 50.0 : 0.0);
    append_sample(run, ship, t, {{0.3 * t, 0.0, 0.0}, {0.3 + 0.001 * t, 0.0, 0.0}}, {{}, Vec2<double>::Zero(), t});
  }
  for (std::size_t i = 300; i < 330; ++i) run[Channel::u][i] = kMissing;
  run.name = run.file = "fast";
  const gap::Campaign campaign = gap::prepare(ship, {run}, {});
  REQUIRE(campaign.stretches.size() == 2);
  CHECK(campaign.step_s == Approx(1.1));
  const gap::Stretch& first = campaign.stretches.front();
  std::size_t missing = 0;
  for (std::size_t k = 0; k < first.size(); ++k) {
    if (std::isnan(first.measured[k][3]))
      ++missing;
    else  // the mean of a linear course is its value at the mean time
      CHECK(first.measured[k][3] == Approx(0.3 + 0.001 * first.t_s[k]));
    CHECK(first.measured[k][0] == Approx(0.3 * first.t_s[k]));
  }
  CHECK(missing >= 3);
  CHECK(missing <= 4);
  CHECK_THAT(campaign.notices.back(), Contains("thinned"));
}

TEST_CASE("gap: inputs act by their mean over a step", "[gap]") {
  const Ship ship = read_ship("esso-osaka-3m");
  Trajectory recording = zigzags(ship, 60.0).front();
  // A corner inside the step from 10 to 14 s that three points alone would miss.
  for (std::size_t k = 0; k < recording.size(); ++k) recording[Channel::delta][k] = k == 11 ? 0.4 : 0.0;
  const RecordedInputs inputs(recording, ship, InputInterpolation::linear);
  const StepInputs<double> step = gap::averaged_step(inputs, 10.0, 4.0);
  const auto mean = [&](Channel c) {
    return (step.start.actuators[c] + 4.0 * step.middle.actuators[c] + step.end.actuators[c]) / 6.0;
  };
  CHECK(mean(Channel::delta) == Approx(0.4 / 4.0));
  CHECK(mean(Channel::n_p) == Approx(recording[Channel::n_p][10]));
}

TEST_CASE("gap: recordings that cannot be used are refused with the reason", "[gap]") {
  const Ship ship = read_ship("esso-osaka-3m");
  std::vector<Trajectory> recordings = zigzags(ship, 60.0);
  SECTION("the same twice") {
    recordings[1] = recordings[0];
    CHECK_THROWS_WITH(gap::prepare(ship, recordings, {}), Contains("holds the same as"));
  }
  SECTION("no rudder") {
    recordings[0][Channel::delta].clear();
    CHECK_THROWS_WITH(gap::prepare(ship, recordings, {}), Contains("no column 'delta_deg'"));
  }
  SECTION("too short") {
    CHECK_THROWS_WITH(gap::prepare(ship, zigzags(ship, 10.0), {}), Contains("no recording is long enough"));
  }
  SECTION("one sample") { CHECK_THROWS_WITH(gap::prepare(ship, zigzags(ship, 0.0), {}), Contains("a single sample")); }
  SECTION("wind without heading") {
    recordings[0][Channel::wind_speed].assign(recordings[0].size(), 1.0);
    recordings[0][Channel::wind_dir].assign(recordings[0].size(), 0.5);
    recordings[0][Channel::psi].clear();
    CHECK_THROWS_WITH(gap::prepare(ship, recordings, {}), Contains("no column 'psi_deg'"));
  }
}

TEST_CASE("gap: a recording that says nothing is left out with the reason, holes are reported", "[gap]") {
  const Ship ship = read_ship("esso-osaka-3m");
  std::vector<Trajectory> recordings = zigzags(ship, 120.0);
  REQUIRE(recordings.size() > 1);
  Trajectory& first = recordings[0];
  const std::size_t n = first.size();
  const auto notices = [&] { return fmt::format("{}", fmt::join(gap::prepare(ship, recordings, {}).notices, "\n")); };
  CHECK_THAT(notices(), !Contains("left out") && !Contains("hole"));
  SECTION("a ship at rest") {
    for (const Channel channel : gap::kMeasured) first[channel].assign(n, 0.0);
    CHECK_THAT(notices(), Contains("no measured channel ever changes"));
  }
  SECTION("an actuator without values") {
    first[Channel::delta].assign(n, kMissing);
    CHECK_THAT(notices(), Contains("'delta_deg' has no value at all"));
  }
  SECTION("a hole") {
    for (const Channel channel : gap::kMeasured) std::fill_n(first[channel].begin() + 40, 10, kMissing);
    CHECK_THAT(notices(), Contains("1 hole without any measurement"));
  }
  SECTION("wind in one of them") {
    first[Channel::wind_speed].assign(n, 1.0);
    first[Channel::wind_dir].assign(n, 0.5);
    CHECK_THAT(notices(), Contains("recordings have no wind columns while the others have"));
  }
}

TEST_CASE("gap: frozen channels and actuators are seen, steady ones are not suspected", "[gap]") {
  const Ship ship = read_ship("esso-osaka-3m");
  Trajectory recording = zigzags(ship, 200.0).front();
  const std::size_t n = recording.size();
  const auto missing = [](const std::vector<double>& x) {
    return std::count_if(x.begin(), x.end(), [](double v) { return std::isnan(v); });
  };
  const auto measured_rudder = [&](std::size_t from, std::size_t to) {
    for (std::size_t k = 0; k < n; ++k) {
      recording[Channel::delta][k] += 1e-3 * std::sin(static_cast<double>(k * k));
      if (k > from && k < to) recording[Channel::delta][k] = recording[Channel::delta][from];
    }
  };
  CHECK(gap::suspect_actuators(recording, {}).empty());
  SECTION("a rudder that is measured") {
    measured_rudder(0, 0);
    CHECK(gap::suspect_actuators(recording, {}).empty());
  }
  SECTION("the same, frozen for a while") {
    measured_rudder(100, 150);
    REQUIRE(gap::suspect_actuators(recording, {}).size() == 1);
    CHECK_THAT(gap::suspect_actuators(recording, {}).front(),
               Contains("'delta_deg' keeps one value from 100 to 149 s"));
  }
  SECTION("sway frozen throughout") {
    recording[Channel::vm].assign(n, 0.01);
    const Trajectory rest = gap::without_frozen(recording, {});
    CHECK(missing(rest[Channel::vm]) == static_cast<std::ptrdiff_t>(n) - 1);
    CHECK(missing(rest[Channel::u]) == 0);
  }
  SECTION("a steady turn is none") {
    for (const auto& [channel, value] : {std::pair{Channel::u, 0.4}, {Channel::vm, -0.05}, {Channel::r, 0.03}})
      recording[channel].assign(n, value);
    const Trajectory rest = gap::without_frozen(recording, {});
    for (const Channel channel : {Channel::u, Channel::vm, Channel::r}) CHECK(missing(rest[channel]) == 0);
  }
}

TEST_CASE("gap: a ship states how well its coefficients are known, by names that exist", "[gap]") {
  Ship ship = read_ship("kvlcc2-l7");
  ship.uncertainty = {{"hull.N_vvr", 0.03}};
  for (const gap::UncertainParameter& parameter : gap::uncertain_parameters(ship)) {
    if (parameter.name == "hull.N_vvr") CHECK(parameter.sd == 0.03);
  }
  ship.uncertainty = {{"hull.C_D", 0.1}};  // of another hull model
  CHECK_THROWS_WITH(gap::uncertain_parameters(ship), Contains("/uncertainty/hull.C_D"));
}

TEST_CASE("gap: derivatives of a step by automatic differentiation are those by differences", "[gap]") {
  for (const char* name : {"esso-osaka-3m", "vectwin-3m", "kvlcc2-l7"}) {
    CAPTURE(name);
    const Ship ship = read_ship(name);
    gap::Stretch stretch;
    stretch.t_s = {0.0, 1.0};
    stretch.measured.assign(2, gap::Vec6::Constant(kMissing));
    stretch.spread_s2.assign(2, 0.0);
    Inputs<double> in;
    for (const Actuator& actuator : ship.actuators)
      in.actuators[actuator.channel] = actuator.is_rudder() ? 0.17 : actuator.channel == Channel::n_p ? 9.0 : 12.0;
    in.true_wind = {0.7, -0.4};
    stretch.inputs.assign(1, {StepInputs<double>{in, in, in}, StepInputs<double>{in, in, in}});
    stretch.late_inputs = stretch.inputs;
    stretch.wind_speed_mps = 0.8;
    gap::StateVector x;
    x << 1.0, 2.0, 0.3, 0.21, 0.031, -0.02, 1e-3, -2e-3, 5e-4, 0.05, -0.03;
    const std::vector<gap::UncertainParameter> parameters_of_ship = gap::uncertain_parameters(ship);
    const auto p = static_cast<Eigen::Index>(parameters_of_ship.size());
    Eigen::VectorXd theta = Eigen::VectorXd::LinSpaced(p, -1.0, 1.0);  // by their standard deviations
    for (Eigen::Index j = 0; j < p; ++j) theta[j] *= parameters_of_ship[static_cast<std::size_t>(j)].sd;
    const gap::LinearStretch linear =
        gap::linearize(ship, std::make_shared<const gap::Stretch>(stretch), {x, x}, theta);
    const auto step = [&](const gap::StateVector& at, const Eigen::VectorXd& parameters) {
      Model<double> model(ship);
      gap::apply_uncertainty(model, parameters);
      return gap::advance<double>(model, at, stretch.inputs[0], 0.5);
    };
    const double h = 1e-6;
    for (int j = 0; j < gap::kStates; ++j) {
      const gap::StateVector d = h * gap::StateVector::Unit(j);
      const gap::Vec6 difference = (step(x + d, theta) - step(x - d, theta)) / (2.0 * h);
      CHECK((linear.steps[0].A.col(j) - difference).norm() < 1e-6 * (1.0 + difference.norm()));
    }
    const double largest = linear.steps[0].G.leftCols(p - 1).colwise().norm().maxCoeff();
    for (Eigen::Index j = 0; j + 1 < p; ++j) {  // the last one is the timing, a difference itself
      const Eigen::VectorXd d = h * Eigen::VectorXd::Unit(p, j);
      const gap::Vec6 difference = (step(x, theta + d) - step(x, theta - d)) / (2.0 * h);
      CHECK((linear.steps[0].G.col(j) - difference).norm() < 0.02 * difference.norm() + 3e-4 * largest);
    }
  }
}

TEST_CASE("gap: blocks without measurements, and with any number of them, add up", "[gap]") {
  const Ship ship = read_ship("esso-osaka-3m");
  gap::Campaign campaign = gap::prepare(ship, test::recorded({"esso-osaka-3m", 2, 1, 120.0, 1.0, 0.5}, ship), {});
  gap::Stretch& stretch = campaign.stretches.front();
  for (std::size_t k = 40; k < 60; ++k) stretch.measured[k].setConstant(kMissing);
  const auto p = static_cast<Eigen::Index>(gap::uncertain_parameters(ship).size());
  const gap::LinearStretch linear = gap::linearize(ship, std::make_shared<const gap::Stretch>(stretch),
                                                   gap::measured_path(stretch), Eigen::VectorXd::Zero(p));
  gap::Noise noise;
  noise.sigma_w.setConstant(1e-3);
  noise.tau_s = 12.0;
  noise.wind_tau_s = 15.0;
  noise.measurement_sd.setConstant(0.01);
  const gap::Evidence whole = gap::evidence(linear, noise);
  for (const std::size_t points : {1, 7, 16, 20}) {  // 16 points hold as many measurements as are gathered at once
    CAPTURE(points);
    gap::Evidence sum(p);
    for (const gap::Evidence& block : gap::evidence_by_blocks(linear, noise, points)) sum += block;
    CHECK(sum.measurements == whole.measurements);
    CHECK(sum.log_likelihood == Approx(whole.log_likelihood));
    CHECK((sum.F - whole.F).norm() < 1e-9 * whole.F.norm());
    CHECK((sum.b - whole.b).norm() < 1e-9 * (1.0 + whole.b.norm()));
  }
}
