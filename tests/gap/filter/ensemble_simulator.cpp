#include "gap/filter/ensemble_simulator.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>

#include <catch2/catch.hpp>

#include "core/errors.hpp"
#include "dynamics/observation_noise.hpp"
#include "ensemble/simulated.hpp"
#include "gap/filter/state_space.hpp"
#include "gap/gap_locate.hpp"

using namespace leeway;
using Catch::Matchers::Contains;

namespace {

using Matrix34 = Eigen::Matrix<double, 3, 4>;

// A ship that is linear in (u, v_m, r, rudder angle): nu' = kSlopes (nu, delta) + kOffset.
const Matrix34 kSlopes = (Matrix34() << -0.02, 0.0, 0.0, 0.0,  //
                          0.0, -0.06, -0.09, 0.008,            //
                          0.0, 0.11, -0.2, 0.03)
                             .finished();
const Vec3<double> kOffset(0.01, 0.0, 0.0);
constexpr double kTrainedAngle = 0.5;  // of the training data [rad]

// Members that are this ship: tanh units in the range where they are straight lines. They differ by a sway acceleration
// of `apart` from one to the next.
ensemble::Ensemble linear_ensemble(int count, double apart) {
  constexpr double kSmall = 0.02;
  ensemble::EnsembleHeader header;
  header.config.hidden_layers = 1;
  header.config.hidden_units = 4;
  header.config.initial_state_net = false;
  header.config.members = count;
  header.inputs.actuators = {Channel::delta};
  for (const char* name : {"u_mps", "vm_mps", "r_radps", "delta_rad"}) header.inputs.inputs.push_back({name, 0.0, 1.0});
  for (const char* name : {"udot_mps2", "vmdot_mps2", "rdot_radps2"})
    header.inputs.accelerations.push_back({name, 0.0, 0.01});
  header.inputs.domain = {
      {"u_mps", 0.2, 0.8}, {"vm_mps", -0.2, 0.2}, {"r_radps", -0.2, 0.2}, {"delta_rad", -kTrainedAngle, kTrainedAngle}};
  std::vector<ensemble::Member> members;
  for (int number = 0; number < count; ++number) {
    ensemble::Member member;
    member.number = number;
    member.kernel = "portable";
    member.output_sd = {0.01, 0.01, 0.01};  // that of the accelerations: the last layer's are those themselves
    member.dynamics = ensemble::dynamics_shape(header.inputs, header.config);
    member.initial_state = ensemble::initial_state_shape(header.inputs, header.config);
    for (int j = 0; j < 4; ++j)
      for (int i = 0; i < 4; ++i) member.parameters.push_back(i == j ? static_cast<float>(kSmall) : 0.0F);
    member.parameters.resize(member.parameters.size() + 4, 0.0F);
    for (int j = 0; j < 4; ++j)
      for (int i = 0; i < 3; ++i) member.parameters.push_back(static_cast<float>(kSlopes(i, j) / kSmall));
    for (int i = 0; i < 3; ++i)
      member.parameters.push_back(
          static_cast<float>(kOffset(i) + (i == 1 ? apart * (number - 0.5 * (count - 1)) : 0.0)));
    members.push_back(member);
  }
  return {header, std::move(members), nn::kernels("portable")};
}

// What acts on the ship besides.
using Push = std::function<Vec3<double>(double t_s, const Eigen::Vector4d& inputs)>;

// Recordings of the linear ship with the paper's noise; its rudder swings by up to `angle`.
std::vector<Trajectory> recorded(double angle, const Push& push) {
  std::vector<Trajectory> recordings;
  for (std::uint64_t i = 0; i < 3; ++i) {
    RandomStream random(i, "linear ship");
    const double first = random.uniform(0.0, 6.0), second = random.uniform(0.0, 6.0);
    const auto delta = [&](double t) {
      return angle * (0.6 * std::sin(t / 9.0 + first) + 0.4 * std::sin(t / 3.7 + second));
    };
    Trajectory t;
    t.name = "run" + std::to_string(i);
    t.file = t.name + ".csv";
    Vec3<double> eta(1.0, -2.0, 0.4 + static_cast<double>(i)), nu(0.4, 0.0, 0.0);
    constexpr int kSubsteps = 50;
    for (int k = 0; k < 240; ++k) {
      const std::pair<Channel, double> row[] = {
          {Channel::t, k},       {Channel::u, nu(0)},   {Channel::vm, nu(1)},   {Channel::r, nu(2)},
          {Channel::x0, eta(0)}, {Channel::y0, eta(1)}, {Channel::psi, eta(2)}, {Channel::delta, delta(k)}};
      for (const auto& [channel, value] : row) t[channel].push_back(value);
      for (int s = 0; s < kSubsteps; ++s) {
        const double now = k + (s + 0.5) / kSubsteps, h = 1.0 / kSubsteps;
        Eigen::Vector4d inputs;
        inputs << nu, delta(k) + (now - k) * (delta(k + 1) - delta(k));  // straight between samples
        const double c = std::cos(eta(2)), sn = std::sin(eta(2));
        eta += h * Vec3<double>(c * nu(0) - sn * nu(1), sn * nu(0) + c * nu(1), nu(2));
        nu += h * (kSlopes * inputs + kOffset + (i == 1 ? push(now, inputs) : Vec3<double>::Zero()));
      }
    }
    recordings.push_back(observed(t, {0.03, 0.03, 0.1 * kDegree, 0.01, 0.01, 0.1 * kDegree},
                                  RandomStream(i, "noise of the linear ship")));
  }
  return recordings;
}

const Push kNothing = [](double, const Eigen::Vector4d&) { return Vec3<double>::Zero(); };
const Push kPushed = [](double t_s, const Eigen::Vector4d&) {
  return Vec3<double>(0.0, t_s > 100.0 && t_s < 160.0 ? 0.004 : 0.0, 0.0);
};

gap::Findings located(ensemble::Ensemble ensemble, std::vector<Trajectory> recordings) {
  const auto simulator = std::make_shared<const gap::EnsembleSimulator>(std::move(ensemble), "linear");
  return gap::gap_locate(simulator, recordings, {});
}

}  // namespace

TEST_CASE("gap-locate --model: recordings of the system that the ensemble learned are no mismatch", "[gap][long]") {
  const gap::Findings findings = located(linear_ensemble(3, 1e-5), recorded(0.45, kNothing));
  CAPTURE(findings.detection.reason);
  CHECK(findings.verdict == gap::Verdict::no_mismatch);
  CHECK(findings.located.intervals.empty());
  CHECK_FALSE(findings.located.line_of_action);  // without a base ship nothing is known of forces
  REQUIRE(findings.residuals.size() == 3);
  CHECK(findings.residuals.front().force.empty());
  REQUIRE(findings.ensemble);
  CHECK(findings.ensemble->members == 3);
  CHECK(findings.ensemble->outside_share < 0.05);
  CHECK(findings.ensemble->spread(1) == Approx(1e-5).epsilon(0.05));
  CHECK(findings.L_pp == 3.0);
  for (int axis = 0; axis < 3; ++axis) CHECK(findings.fit.sigma_w[axis] < 0.2 * findings.fit.typical[axis]);
}

TEST_CASE("gap-locate --model: a force that comes and goes is found in time and axis", "[gap]") {
  const gap::Findings findings = located(linear_ensemble(3, 1e-5), recorded(0.45, kPushed));
  CAPTURE(findings.detection.reason);
  CHECK(findings.verdict == gap::Verdict::mismatch);
  REQUIRE_FALSE(findings.located.intervals.empty());
  const gap::Interval& interval = findings.located.intervals.front();
  CHECK(interval.recording == "run1");
  CHECK(interval.axis == 1);
  CHECK(interval.t_start_s > 80.0);
  CHECK(interval.t_start_s < 115.0);
  CHECK(interval.t_end_s > 145.0);
  CHECK(interval.t_end_s < 180.0);
  CHECK(interval.acceleration(1) == Approx(0.004).epsilon(0.25));
  REQUIRE(interval.training);
  CHECK_FALSE(interval.is_untrained());
  CHECK(interval.training->mismatch_by_spread > 100.0);
}

TEST_CASE(
    "gap-locate --model: where the inputs leave the training data the region is untrained, not the physics missing",
    "[gap][long]") {
  // Beyond the angles of the training the rudder stalls, which no member knows.
  const auto stalled = [](double, const Eigen::Vector4d& inputs) {
    const double beyond = std::max(std::abs(inputs(3)) - kTrainedAngle, 0.0) * (inputs(3) < 0.0 ? -1.0 : 1.0);
    return Vec3<double>(-0.02 * std::abs(beyond), -0.02 * beyond, -0.03 * beyond);
  };
  std::vector<Trajectory> recordings = recorded(0.45, kNothing);
  recordings[1] = recorded(2.0, stalled)[1];
  const gap::Findings findings = located(linear_ensemble(3, 1e-5), recordings);
  CAPTURE(findings.detection.reason);
  CHECK(findings.verdict == gap::Verdict::undecided);
  CHECK_THAT(findings.detection.reason, Contains("not trained"));
  REQUIRE_FALSE(findings.located.intervals.empty());
  for (const gap::Interval& interval : findings.located.intervals) {
    CHECK(interval.recording == "run1");
    CHECK(interval.is_untrained());
    REQUIRE(interval.training);
    CHECK(interval.training->outside_share > 0.5);
    CHECK(std::any_of(interval.training->outside.begin(), interval.training->outside.end(),
                      [](const gap::OutsideInput& input) { return input.name == "delta_rad"; }));
  }
}

TEST_CASE("gap-locate --model: what is no more than the members differ by is no mismatch", "[gap][long]") {
  const gap::Findings findings = located(linear_ensemble(4, 0.002), recorded(0.45, kPushed));
  CAPTURE(findings.detection.reason);
  CHECK(findings.verdict == gap::Verdict::undecided);
  REQUIRE_FALSE(findings.located.intervals.empty());
  for (const gap::Interval& interval : findings.located.intervals) {
    CHECK(interval.is_untrained());
    CHECK(interval.training->outside_share < 0.5);
    // Over a step the members' drag takes 3 % off what they differ by.
    CHECK(interval.training->spread == Approx(0.002 * std::sqrt(5.0 / 3.0)).epsilon(0.05));
  }
}

TEST_CASE("gap-locate --model: steps are those of the base ship where the networks are silent", "[gap]") {
  const Ship ship = read_ship("vectwin-3m");
  ensemble::TrainingConfig config;
  config.steps = 20;
  config.initial_state_net = false;
  config.hidden_layers = 1;
  config.hidden_units = 3;
  config.members = 2;
  const ensemble::TrainingData data = ensemble::prepare_training_data({test::simulated_recording(ship, 1, 60)}, config,
                                                                      ensemble::BaseModel::read("vectwin-3m"));
  std::vector<ensemble::Member> members;
  for (int number = 0; number < 2; ++number) {
    ensemble::Member member;
    member.number = number;
    member.output_sd = {1.0, 1.0, 1.0};
    member.dynamics = ensemble::dynamics_shape(data.inputs, config);
    member.initial_state = ensemble::initial_state_shape(data.inputs, config);
    member.parameters.assign(nn::parameter_count(member.dynamics), 0.0F);
    members.push_back(member);
  }
  ensemble::EnsembleHeader header = ensemble::make_header(data, 1, {});
  for (ensemble::Spread& spread : header.inputs.accelerations) spread.mean = 0.0;
  const gap::EnsembleSimulator simulator({header, std::move(members), nn::kernels("portable"), data.base}, "silent");
  CHECK(simulator.knows_inertia());
  CHECK(simulator.ship().particulars.L_pp == ship.particulars.L_pp);

  Inputs<double> in{ship.initial_actuators(), Vec2<double>(0.7, -0.4), 0.0};
  in.actuators[Channel::delta_p] = -0.3;
  in.actuators[Channel::n_bt] = 8.0;
  const std::vector<StepInputs<double>> inputs(2, {in, in, in});
  gap::StateVector x;
  x << 1.0, 2.0, 0.3, 0.31, 0.031, -0.02, 1e-3, -2e-3, 5e-4, 0.05, -0.03;
  const Model<double> model(ship);
  const gap::EnsembleSteps::Step step = gap::EnsembleSteps(simulator).step(x, inputs, 0.5);
  CHECK((step.end - gap::advance<double>(model, x, inputs, 0.5)).norm() < 1e-12);
  CHECK(step.spread.norm() == 0.0);
  for (int j = 0; j < gap::kStates; ++j) {
    const gap::StateVector d = 1e-6 * gap::StateVector::Unit(j);
    const gap::Vec6 slope =
        (gap::advance<double>(model, x + d, inputs, 0.5) - gap::advance<double>(model, x - d, inputs, 0.5)) / 2e-6;
    CAPTURE(j, step.derivatives.col(j).transpose(), slope.transpose());
    CHECK((step.derivatives.col(j) - slope).norm() < 2e-3 * (0.01 + slope.norm()));  // differences over finite steps
  }
}

TEST_CASE("gap-locate --model: recordings that do not fit the ensemble are refused with the reason", "[gap]") {
  const gap::EnsembleSimulator simulator(linear_ensemble(2, 0.0), "linear");
  const std::vector<Trajectory> recordings = recorded(0.45, kNothing);
  simulator.check(recordings.front());
  Trajectory renamed = recordings.front();
  std::swap(renamed[Channel::delta_p], renamed[Channel::delta]);
  CHECK_THROWS_WITH(simulator.check(renamed),
                    Contains("no column 'delta_deg', which the ensemble 'linear' was trained with; found actuators: "
                             "delta_p_deg"));
  Trajectory slow = recordings.front();
  for (double& t : slow[Channel::t]) t *= 2.0;
  CHECK_THROWS_WITH(simulator.check(slow), Contains("sampled every 2 s") && Contains("at least every 1.5 s"));
}
