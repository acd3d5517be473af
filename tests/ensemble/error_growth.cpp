#include "ensemble/error_growth.hpp"

#include <cmath>

#include <catch2/catch.hpp>

#include "core/random.hpp"
#include "ensemble/disturbance.hpp"

using namespace leeway;
using namespace leeway::ensemble;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

constexpr int kPoints = 60;

// A ship that forgets a surge in about 25 steps, a sway in 6 and a yaw in 3, sway and yaw coupled; one input.
StepDerivatives plain_step() {
  StepDerivatives step;
  step.by_state << 1.0, 0.0, 0.0, 1.0,  //
      0.0, 0.96, 0.0, 0.0,              //
      0.0, 0.0, 0.85, -0.1,             //
      0.0, 0.0, 0.3, 0.7;
  step.by_input = Eigen::Matrix4Xd::Zero(4, 1);
  step.by_input(1) = 2e-4;
  step.by_input(3) = 3e-4;
  return step;
}

// What noises of known size and networks that are draws of the truth make of a sequence.
struct Planted {
  Disturbance disturbance;
  Vec3<double> sensor_sd = Vec3<double>::Zero();
  bool inputs = false;       // further on by a share that is uniform, the same all the way
  double networks_sd = 0.0;  // a push of (u, v_m, r) at every step, the same all the way
  int networks = 4;
};

MissedBlocks simulated(const Planted& planted, const Noises& noises, std::uint64_t number) {
  RandomStream random(3, "sequence", number);
  const StepDerivatives step = plain_step();
  DisturbancePath path(planted.disturbance, 1.0, random);
  std::vector<Vec3<double>> error;
  std::vector<Eigen::Matrix3Xd> networks;
  const auto pushed = [&](double sd) {
    return Eigen::Vector4d(0.0, sd * random.normal(), sd * random.normal(), sd * random.normal());
  };
  Eigen::Matrix4Xd push(4, planted.networks + 1), state = Eigen::Matrix4Xd::Zero(4, planted.networks + 1);
  for (Eigen::Index m = 0; m < push.cols(); ++m) push.col(m) = pushed(planted.networks_sd);
  Eigen::Vector4d start = Eigen::Vector4d::Zero();  // the networks start from what is recorded
  for (int i = 0; i < 3; ++i) start(i + 1) = planted.sensor_sd(i) * random.normal();
  state.leftCols(planted.networks).colwise() += start;
  const double share = planted.inputs ? random.uniform(-0.5, 0.5) : 0.0;
  for (int k = 0; k < kPoints; ++k) {
    state = (step.by_state * state + push).eval();
    // The last column is the truth.
    state.rightCols<1>() += step.by_input * share;
    state.rightCols<1>().tail<3>() += path.next(random);
    networks.emplace_back(state.leftCols(planted.networks).bottomRows<3>());
    Vec3<double> recorded = state.rightCols<1>().tail<3>();
    for (int i = 0; i < 3; ++i) recorded(i) += planted.sensor_sd(i) * random.normal();
    error.emplace_back(recorded - networks.back().rowwise().mean());
  }
  return missed_blocks(error, networks, std::vector<StepDerivatives>(kPoints, step), noises);
}

std::vector<double> found(const Planted& planted, const Noises& noises, int sequences = 400) {
  std::vector<MissedBlocks> all;
  for (int n = 0; n < sequences; ++n) all.push_back(simulated(planted, noises, static_cast<std::uint64_t>(n)));
  return noise_variances(all, noises);
}

// What an axis' processes add up to over times that are long against their time constants.
double white_equivalent(const std::vector<double>& v, const Noises& noises, std::size_t axis) {
  double sum = 0.0;
  for (std::size_t i = 0; i < noises.tau_s.size(); ++i) sum += 2.0 * v[noises.disturbance(axis, i)] * noises.tau_s[i];
  return sum;
}

}  // namespace

TEST_CASE("error growth: covariances by a unit of each noise are those of simulated errors",
          "[ensemble][calibration]") {
  const Noises noises(1.0, kPoints);
  REQUIRE(noises.tau_s.size() == 4);
  CHECK_THAT(noises.tau_s[2], WithinRel(10.0, 1e-12));
  const std::size_t tau = 2;
  for (const std::size_t noise : {noises.disturbance(1, tau), noises.sensor(2), noises.size()}) {
    Planted planted;
    if (noise == noises.disturbance(1, tau)) planted.disturbance.axes[1] = {{1.0, noises.tau_s[tau]}};
    if (noise == noises.sensor(2)) planted.sensor_sd(2) = 1.0;
    planted.inputs = noise == noises.size();
    Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(18, 18), unit;
    constexpr int kSequences = 4000;
    for (std::uint64_t n = 0; n < kSequences; ++n) {
      const MissedBlocks one = simulated(planted, noises, n);
      covariance += one.missed * one.missed.transpose() / kSequences;
      unit = planted.inputs ? one.of_inputs : one.by_unit[noise];
      CHECK(one.of_members.norm() < 1e-20);
    }
    // A covariance of 4000 has errors of 1/sqrt(4000) of its size, times four.
    CHECK((covariance - unit).norm() < 0.09 * unit.norm());
  }
}

TEST_CASE("error growth: planted variances are found beside networks that disagree", "[ensemble][calibration][long]") {
  const Noises noises(1.0, kPoints);
  Planted planted;
  planted.disturbance.axes = {{{{2e-3, 3.2}}, {{4e-3, 1.0}}, {{1e-3, 30.0}}}};
  planted.sensor_sd = {0.01, 0.01, 2e-3};
  planted.networks_sd = 4e-4;
  for (const int networks : {3, 6}) {
    planted.networks = networks;
    planted.inputs = true;
    const std::vector<double> v = found(planted, noises);
    CAPTURE(networks);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      CAPTURE(axis);
      const OrnsteinUhlenbeck& process = planted.disturbance.axes[axis].front();
      // The time constant is one of four, so that their sum is known to some tens of percent.
      CHECK_THAT(white_equivalent(v, noises, axis), WithinRel(2.0 * process.sd * process.sd * process.tau_s, 0.35));
    }
    CHECK_THAT(std::sqrt(v[noises.sensor(0)]), WithinRel(0.01, 0.1));
    CHECK_THAT(std::sqrt(v[noises.sensor(1)]), WithinRel(0.01, 0.1));
  }
}

TEST_CASE("error growth: where nothing is planted, next to nothing is found", "[ensemble][calibration][long]") {
  const Noises noises(1.0, kPoints);
  Planted planted;
  planted.sensor_sd = {0.01, 0.01, 2e-3};
  planted.networks_sd = 4e-4;
  planted.inputs = true;
  const std::vector<double> v = found(planted, noises);
  Planted disturbed = planted;
  disturbed.disturbance.axes = {{{{2e-3, 3.2}}, {{4e-3, 1.0}}, {{1e-3, 30.0}}}};
  const std::vector<double> other = found(disturbed, noises);
  for (std::size_t axis = 0; axis < 3; ++axis)
    CHECK(white_equivalent(v, noises, axis) < 0.15 * white_equivalent(other, noises, axis));
}
