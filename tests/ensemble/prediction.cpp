#include "ensemble/prediction.hpp"

#include <cmath>
#include <set>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "core/errors.hpp"
#include "core/wind.hpp"
#include "ensemble/ensemble_training.hpp"
#include "ensemble/synthetic.hpp"
#include "nn/reference_kernels.hpp"
#include "temporary_folder.hpp"

using namespace leeway;
using namespace leeway::ensemble;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

// A small trained ensemble, made once.
const Ensemble& trained() {
  static const Ensemble ensemble = [] {
    TrainingConfig config;
    config.steps = 20;
    config.initial_state_steps = 5;
    config.hidden_layers = 2;
    config.hidden_units = 12;
    config.epochs = 30;
    config.members = 4;
    config.learning_rate = 3e-3;
    config.gradient_clip_norm = 1000.0;
    const test::TemporaryFolder temporary;
    const std::string folder = temporary.path().string();
    const TrainingData data =
        prepare_training_data({test::synthetic_recording(1, 130), test::synthetic_recording(2, 75)}, config);
    const EnsembleHeader header = make_header(data, 1, {});
    write_header(folder, header, io::Json::object());
    train_ensemble(data, header, {folder, {0, 1, 2, 3}, false, 100.0, 2}, nn::kernels(), {});
    return Ensemble(folder, 0, nn::kernels());
  }();
  return ensemble;
}

Samples test_samples() {
  return resample(test::synthetic_recording(7, 60), trained().header().inputs.actuators, true, 1.0).front();
}

}  // namespace

TEST_CASE("prediction: a particle of TS-infinity is its member's own rollout", "[ensemble]") {
  const Samples samples = test_samples();
  EnsembleEvaluator evaluator(trained());
  const PredictionOptions options{40, Sampling::ts_infinity, Integrator::rk4, 3};
  const SequencePrediction p = predict_sequence(evaluator, trained(), samples, {20, 20}, 1, options);
  REQUIRE(p.eta.size() == 20);
  CHECK(p.nu[1].cols() == 4);  // one evaluation for each member that was drawn, not one for each particle
  std::set<int> members;
  for (const int particle : {0, 1, 7, 20, 39}) {
    const auto i = static_cast<std::size_t>(particle);
    const int m = p.member[0][i];
    members.insert(m);
    Eigen::Matrix3Xd eta = samples.eta.col(20), nu = samples.nu.col(20);
    for (Eigen::Index k = 0; k < 19; ++k)
      evaluator.step(m, Integrator::rk4, 1.0, samples.actuators.col(20 + k), samples.true_wind.col(20 + k), eta, nu);
    CHECK(p.member[19][i] == m);
    for (int j = 0; j < 3; ++j) {
      CHECK(p.nu[19](j, p.state[19][i]) == nu(j, 0));
      CHECK(p.eta[19](j, p.state[19][i]) == eta(j, 0));
    }
  }
  CHECK(members.size() > 1);
}

TEST_CASE("prediction: particles with disturbances, errors of the start and open inputs are the same in any company",
          "[ensemble]") {
  Samples samples = test_samples();
  samples.actuators_open = samples.actuators.cwiseAbs();
  Samples other = samples;
  other.recording = "another";
  EnsembleEvaluator evaluator(trained());
  PredictionOptions options{2000, Sampling::ts_infinity, Integrator::rk4, 3};
  options.disturbance.axes[1] = {{3e-3, 5.0}};
  options.initial_sd = {0.02, 0.0, 0.01};
  const std::vector<SequenceTask> tasks{{&samples, {0, 5}, 0}, {&other, {3, 9}, 0}};
  for (const Sampling sampling : {Sampling::ts_infinity, Sampling::ts1})
    for (const bool draws_inputs : {false, true}) {
      options.sampling = sampling;
      options.draws_inputs = draws_inputs;
      const std::vector<SequencePrediction> together = predict_sequences(evaluator, trained(), tasks, options);
      const SequencePrediction alone = predict_sequence(evaluator, trained(), other, {3, 9}, 0, options);
      CHECK(together[1].nu == alone.nu);
      CHECK(together[1].state == alone.state);
      CHECK(together[1].nu.front() != together[0].nu.front());
      const auto spread = [&](std::size_t k, int axis) {
        const Eigen::RowVectorXd row = together[0].nu[k].row(axis);
        return std::sqrt((row.array() - row.mean()).square().mean());
      };
      // Standard errors of a standard deviation of 2000 particles are 1.6 %.
      CHECK_THAT(spread(0, 0), WithinRel(0.02, 0.06));
      CHECK(spread(0, 1) < 1e-12);
      CHECK_THAT(spread(0, 2), WithinRel(0.01, 0.06));
    }
  // Alone, a disturbance adds its own: one member, no error at the start, one step.
  options = {2000, Sampling::ts_infinity, Integrator::rk4, 3};
  const SequencePrediction without = predict_sequence(evaluator, trained(), samples, {0, 2}, 0, options);
  options.disturbance.axes[1] = {{3e-3, 5.0}};
  const SequencePrediction with = predict_sequence(evaluator, trained(), samples, {0, 2}, 0, options);
  CHECK(with.member == without.member);
  double square = 0.0;
  for (std::size_t p = 0; p < 2000; ++p) {
    const Vec3<double> added = with.nu[1].col(with.state[1][p]) - without.nu[1].col(without.state[1][p]);
    CHECK(added(0) == 0.0);
    square += added(1) * added(1) / 2000.0;
  }
  CHECK_THAT(std::sqrt(square), WithinRel(3e-3, 0.07));
}

TEST_CASE("prediction: sequences together have the bits of each particle stepped alone", "[ensemble]") {
  const Samples samples = test_samples();
  Samples other = samples;
  other.recording = "another";
  other.actuators *= 0.5;
  const std::vector<SequenceTask> tasks{{&samples, {0, 12}, 0}, {&other, {3, 25}, 0}, {&samples, {30, 12}, 1}};
  EnsembleEvaluator evaluator(trained());
  for (const Sampling sampling : {Sampling::ts_infinity, Sampling::ts1}) {
    const PredictionOptions options{40, sampling, Integrator::rk4, 3};
    const std::vector<SequencePrediction> together = predict_sequences(evaluator, trained(), tasks, options);
    REQUIRE(together.size() == tasks.size());
    for (std::size_t s = 0; s < tasks.size(); ++s) {
      const auto& [recording, range, sequence] = tasks[s];
      const SequencePrediction& p = together[s];
      REQUIRE(p.eta.size() == static_cast<std::size_t>(range.size));
      const SequencePrediction alone = predict_sequence(evaluator, trained(), *recording, range, sequence, options);
      CHECK(p.eta == alone.eta);
      CHECK(p.nu == alone.nu);
      CHECK(p.state == alone.state);
      CHECK(p.member == alone.member);
      for (const std::size_t i : {0, 5, 23, 39}) {
        Eigen::Matrix3Xd eta = recording->eta.col(range.begin), nu = recording->nu.col(range.begin);
        for (Eigen::Index k = 0; k + 1 < range.size; ++k) {
          const auto point = static_cast<std::size_t>(k + 1);
          evaluator.step(p.member[point][i], Integrator::rk4, 1.0, recording->actuators.col(range.begin + k),
                         recording->true_wind.col(range.begin + k), eta, nu);
          CHECK(p.eta[point].col(p.state[point][i]) == eta.col(0));
          CHECK(p.nu[point].col(p.state[point][i]) == nu.col(0));
        }
      }
    }
  }
}

TEST_CASE("prediction: accelerations are those of the plain network in double precision", "[ensemble]") {
  const Samples samples = test_samples();
  EnsembleEvaluator evaluator(trained());
  const Member& member = trained().member(2);
  const RolloutConstants<double> constants(trained().header().inputs, trained().header().config, member);
  const nn::RolloutModel<double>& model = constants.view();
  const Eigen::Matrix3Xd eta = samples.eta.leftCols(21), nu = samples.nu.leftCols(21);
  const Eigen::Matrix3Xd found =
      evaluator.accelerations(2, eta, nu, samples.actuators.leftCols(21), samples.true_wind.leftCols(21));
  const std::vector<double> parameters(member.parameters.begin(), member.parameters.end());
  for (Eigen::Index k = 0; k < 21; ++k) {
    const Vec2<double> wind = apparent_wind<double>(samples.true_wind.col(k), eta(2, k), nu(0, k), nu(1, k));
    Eigen::VectorXd inputs(8);
    inputs << nu.col(k), samples.actuators.col(k), wind;
    for (int j = 0; j < 8; ++j) inputs(j) = (inputs(j) - model.input_mean[j]) * model.input_inverse_sd[j];
    double output[3];
    test::reference_forward(member.dynamics, parameters.data(), inputs.data(), 1, output);
    for (int i = 0; i < 3; ++i)
      CHECK_THAT(found(i, k), WithinAbs(model.output_offset[i] + model.output_scale[i] * output[i],
                                        3e-6 * model.output_scale[i]));  // single precision of a few units of output
  }
}

TEST_CASE("prediction: members share the particles evenly, and who gets one more is drawn", "[ensemble]") {
  std::vector<int> more(24, 0);
  for (std::uint64_t seed = 1; seed <= 600; ++seed) {
    RandomStream random(seed, "a test");
    std::vector<int> count(24, 0);
    for (const int m : shared_out(100, 24, random)) ++count[static_cast<std::size_t>(m)];
    for (std::size_t m = 0; m < 24; ++m) {
      CHECK((count[m] == 4 || count[m] == 5));
      more[m] += count[m] - 4;
    }
  }
  // Four of 24 get a fifth: 100 of 600, standard deviation 9.1; five of them.
  for (const int m : more) CHECK(std::abs(m - 100) < 46);
}

TEST_CASE("prediction: members are drawn anew at each step of TS1, and independently", "[ensemble]") {
  const Samples samples = test_samples();
  EnsembleEvaluator evaluator(trained());
  std::vector<int> count(4, 0);
  const SequencePrediction p =
      predict_sequence(evaluator, trained(), samples, {0, 4}, 0, {4000, Sampling::ts1, Integrator::rk4, 3});
  int kept = 0;
  for (std::size_t i = 0; i < 4000; ++i) {
    ++count[static_cast<std::size_t>(p.member[2][i])];
    if (p.member[1][i] == p.member[2][i]) ++kept;
  }
  for (const int c : count) CHECK(c == 1000);
  // Less than 4000 draws with probability 1/4 would vary, by 27; five of them.
  CHECK(std::abs(kept - 1000) < 137);
  CHECK(p.nu[1].cols() == 4);
  CHECK(p.nu[2].cols() == 16);  // histories, not particles
}

TEST_CASE("prediction: another seed draws other members, another recording's name too", "[ensemble]") {
  Samples samples = test_samples();
  EnsembleEvaluator evaluator(trained());
  const PredictionOptions options{50, Sampling::ts_infinity, Integrator::rk4, 3};
  const auto members = [&](std::uint64_t seed) {
    PredictionOptions o = options;
    o.seed = seed;
    return predict_sequence(evaluator, trained(), samples, {0, 3}, 0, o).member[0];
  };
  const std::vector<int> first = members(3);
  CHECK(first == members(3));
  CHECK(first != members(4));
  samples.recording = "another";
  CHECK(first != members(3));
}

TEST_CASE("prediction: Euler and RK4 differ by the order that they should", "[ensemble]") {
  const Samples samples = test_samples();
  EnsembleEvaluator evaluator(trained());
  const auto run = [&](Integrator integrator, int parts) {
    Eigen::Matrix3Xd eta = samples.eta.col(3), nu = samples.nu.col(3);
    for (int i = 0; i < parts; ++i)
      evaluator.step(0, integrator, 4.0 / parts, samples.actuators.col(3), samples.true_wind.col(3), eta, nu);
    return Eigen::Vector3d(nu.col(0));
  };
  const Eigen::Vector3d exact = run(Integrator::rk4, 64);
  const double euler1 = (run(Integrator::euler, 4) - exact).norm(), euler2 = (run(Integrator::euler, 8) - exact).norm();
  CHECK_THAT(euler1 / euler2, WithinRel(2.0, 0.25));
  CHECK((run(Integrator::rk4, 4) - exact).norm() < 0.05 * euler1);
}

TEST_CASE("prediction: the held velocity runs on a circle", "[ensemble]") {
  Samples samples = test_samples();
  samples.nu.col(0) = Eigen::Vector3d(0.5, 0.1, 0.05);
  samples.eta.col(0) = Eigen::Vector3d(3.0, -2.0, 0.7);
  const SequencePrediction p = hold_velocity(samples, {0, 30});
  const double psi = 0.7 + 29 * 0.05;
  CHECK_THAT(p.eta[29](2, 0), WithinRel(psi, 1e-12));
  const double x = 3.0 + (0.5 * (std::sin(psi) - std::sin(0.7)) + 0.1 * (std::cos(psi) - std::cos(0.7))) / 0.05;
  const double y = -2.0 + (-0.5 * (std::cos(psi) - std::cos(0.7)) + 0.1 * (std::sin(psi) - std::sin(0.7))) / 0.05;
  CHECK_THAT(p.eta[29](0, 0), WithinAbs(x, 1e-7));
  CHECK_THAT(p.eta[29](1, 0), WithinAbs(y, 1e-7));
  CHECK(p.nu[29].col(0) == p.nu[0].col(0));
}

TEST_CASE("prediction: the fitted rollout has the training loss", "[ensemble]") {
  // The curve's last entry is the mean over the last epoch while the weights still moved a little.
  EnsembleEvaluator evaluator(trained());
  const TrainingConfig& config = trained().header().config;
  const Samples samples =
      resample(test::synthetic_recording(1, 130), trained().header().inputs.actuators, true, 1.0).front();
  const Samples other =
      resample(test::synthetic_recording(2, 75), trained().header().inputs.actuators, true, 1.0).front();
  double loss = 0.0, points = 0.0;
  for (const Samples* s : {&samples, &other})
    for (const Range window : training_windows(s->size(), config.steps)) {
      const SequencePrediction p = fitted_rollout(evaluator, trained(), *s, window);
      for (Eigen::Index k = 0; k < window.size; ++k) {
        const Eigen::Vector3d e = p.nu[static_cast<std::size_t>(k)].col(1) - s->nu.col(window.begin + k);
        loss += e.cwiseQuotient(config.sigma).squaredNorm();
        points += 1.0;
      }
    }
  CHECK_THAT(loss / points, WithinRel(static_cast<double>(trained().member(1).training_curve.back()), 0.3));
}
