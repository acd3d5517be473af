#include "nn/rollout.hpp"

#include <cmath>

#include <catch2/catch.hpp>

#include "core/errors.hpp"
#include "ensemble/synthetic.hpp"
#include "ensemble/training.hpp"
#include "nn/numeric_gradient.hpp"
#include "nn/reference_kernels.hpp"

using namespace leeway;
using namespace leeway::ensemble;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

TrainingConfig rollout_config() {
  TrainingConfig config;
  config.steps = 12;
  config.initial_state_steps = 4;
  config.hidden_layers = 2;
  config.hidden_units = 7;
  config.pose_scale = {0.3, 0.3, 0.2};  // so that the heading correction matters
  config.sigma = {0.05, 0.04, 0.02};
  return config;
}

struct Case {
  TrainingData data;
  TrainingState state;
  std::vector<std::size_t> windows;

  explicit Case(const TrainingConfig& config, bool with_wind = true)
      // 29 points: windows of 12 with an overlap; 9 and 3: shorter than K, and shorter than K_init.
      : data(prepare_training_data(
            {test::synthetic_recording(1, 29, 1.0, with_wind), test::synthetic_recording(2, 9, 1.0, with_wind),
             test::synthetic_recording(3, 3, 1.0, with_wind)},
            config)),
        state(initial_training_state(data, 5, 0, nn::kernels("portable"))) {
    for (std::size_t i = 0; i < data.windows.size(); ++i) windows.push_back(i);
  }
};

nn::AlignedVector<double> as_double(const nn::AlignedVector<float>& values) { return {values.begin(), values.end()}; }

template <typename A, typename B>
double relative_difference(const A& values, const B& expected) {
  double difference = 0.0, norm = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    difference += std::pow(static_cast<double>(values[i]) - static_cast<double>(expected[i]), 2);
    norm += std::pow(static_cast<double>(expected[i]), 2);
  }
  return std::sqrt(difference / norm);
}

}  // namespace

TEST_CASE("rollout: the gradient through time agrees with central differences", "[nn]") {
  const bool with_wind = GENERATE(true, false);
  const Case c(rollout_config(), with_wind);
  REQUIRE(c.windows.size() == 5);
  const RolloutConstants<double> constants(c.data.inputs, c.data.config, c.state.member);
  WindowBatch<double> batch;
  batch.assign(c.data, c.windows.data(), c.windows.size());
  const nn::Kernels<double>& kernels = nn::kernels_double();
  const nn::KernelWorkspace<double> workspace(kernels);
  nn::AlignedVector<double> parameters = as_double(c.state.member.parameters);
  nn::AlignedVector<double> gradient(parameters.size());
  const auto loss = [&](nn::AlignedVector<double>& out) {
    return kernels.loss_and_gradient(workspace.get(), constants.view(), batch.view(), parameters.data(), out.data());
  };
  loss(gradient);
  REQUIRE(test::largest_component(gradient) > 0.0);
  CHECK(test::gradient_error(loss, parameters, gradient, 1e-6) < 1e-6);
}

TEST_CASE("rollout: the loss of a hand-computed case", "[nn]") {
  // No hidden signal (all weights zero, output bias given): the acceleration is the bias. Two windows of 3 and 2
  // points, dt = 0.5, no initial-state network. Window 1: nu = (1,0,0), (1.5,0,0), (2,0,0) against observations
  // (1,0,0), (1.5,0,0), (2.3,0,0): error -0.3 at the last point. Window 2: nu = (0,0,0), (0.5,0,0) against (0,0,0),
  // (0.5,0.2,0): error -0.2. With 1/sigma^2 = 4: loss = 4 (0.09 + 0.04) / 5 points.
  const nn::NetworkShape shape{4, 1, 2, 3};
  nn::AlignedVector<double> parameters(nn::parameter_count(shape), 0.0);
  parameters[parameters.size() - 3] = 1.0;  // output bias of u'
  const double mean[4] = {0, 0, 0, 0}, inverse_sd[4] = {1, 1, 1, 1}, offset[3] = {0, 0, 0}, scale[3] = {1, 1, 1};
  nn::RolloutModel<double> model;
  model.dynamics = shape;
  model.controls = 1;
  model.dt = 0.5;
  model.input_mean = mean;
  model.input_inverse_sd = inverse_sd;
  model.output_offset = offset;
  model.output_scale = scale;
  const double nu[18] = {1, 0, 0, 0, 0, 0, 1.5, 0, 0, 0.5, 0.2, 0, 2.3, 0, 0, 0, 0, 0};
  const double weight[18] = {4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 0, 0, 0};
  const double psi[2] = {0, 0}, controls[6] = {1, 2, 3, 4, 5, 6}, wind[12] = {};
  nn::RolloutBatch<double> batch;
  batch.windows = 2;
  batch.points = 3;
  batch.nu_observed = nu;
  batch.weight = weight;
  batch.psi_initial = psi;
  batch.controls = controls;
  batch.true_wind = wind;
  batch.count = 5;
  const nn::KernelWorkspace<double> workspace(nn::kernels_double());
  nn::AlignedVector<double> gradient(parameters.size());
  const double loss =
      nn::kernels_double().loss_and_gradient(workspace.get(), model, batch, parameters.data(), gradient.data());
  CHECK_THAT(loss, WithinRel(4.0 * (0.09 + 0.04) / 5.0, 1e-14));
  // d loss / d bias_u = 2/5 * 4 * (-0.3) * (2 steps * dt); d / d bias_v = 2/5 * 4 * (-0.2) * (1 step * dt).
  CHECK_THAT(gradient[parameters.size() - 3], WithinRel(-0.48, 1e-14));
  CHECK_THAT(gradient[parameters.size() - 2], WithinRel(-0.16, 1e-14));
}

TEST_CASE("rollout: every kernel of this processor gives the reference's gradient to 1e-5", "[nn]") {
  // Units that fill no vector, and batches below, at and above the widths of blocks.
  const int units = GENERATE(33, 64);
  const std::size_t windows = GENERATE(as<std::size_t>(), 1, 5, 8, 15, 17, 33, 47);
  CAPTURE(units, windows);
  TrainingConfig config = rollout_config();
  config.steps = 40;
  config.hidden_units = units;
  const Case c(config);
  std::vector<std::size_t> drawn;
  for (std::size_t i = 0; i < windows; ++i) drawn.push_back(c.windows[(i * 2) % c.windows.size()]);
  const RolloutConstants<double> exact_constants(c.data.inputs, config, c.state.member);
  WindowBatch<double> exact_batch;
  exact_batch.assign(c.data, drawn.data(), drawn.size());
  const nn::AlignedVector<double> parameters = as_double(c.state.member.parameters);
  nn::AlignedVector<double> exact(parameters.size()), own(parameters.size());
  const double exact_loss =
      test::reference_loss_and_gradient(exact_constants.view(), exact_batch.view(), parameters.data(), exact.data());
  const nn::KernelWorkspace<double> own_workspace(nn::kernels_double());
  const double own_loss = nn::kernels_double().loss_and_gradient(own_workspace.get(), exact_constants.view(),
                                                                 exact_batch.view(), parameters.data(), own.data());
  CHECK_THAT(own_loss, WithinRel(exact_loss, 1e-12));
  CHECK(relative_difference(own, exact) < 1e-12);

  const RolloutConstants<float> constants(c.data.inputs, config, c.state.member);
  WindowBatch<float> batch;
  batch.assign(c.data, drawn.data(), drawn.size());
  nn::AlignedVector<float> reference(parameters.size()), gradient(parameters.size());
  test::reference_loss_and_gradient(constants.view(), batch.view(), c.state.member.parameters.data(), reference.data());
  for (const std::string& name : nn::available_kernels()) {
    CAPTURE(name);
    const nn::Kernels<float>& kernels = nn::kernels(name);
    const nn::KernelWorkspace<float> workspace(kernels);
    const double loss = kernels.loss_and_gradient(workspace.get(), constants.view(), batch.view(),
                                                  c.state.member.parameters.data(), gradient.data());
    CHECK_THAT(loss, WithinRel(exact_loss, 1e-5));
    CHECK(relative_difference(gradient, reference) < 1e-5);
    CHECK(relative_difference(gradient, exact) < 1e-5);
  }
}

TEST_CASE("rollout: kernels that are said to give the same bits have the same gradient, to the last one", "[nn]") {
  if (nn::available_kernels().front() != "avx512") {
    WARN("SKIPPED: this processor lacks AVX-512");
    return;
  }
  CHECK(nn::give_same_bits("avx2", "avx512"));
  CHECK(nn::give_same_bits("an older one", "an older one"));
  for (const std::string other : {"portable", "an older one"}) CHECK_FALSE(nn::give_same_bits("avx2", other));
  // Batches that fill no vector, some vectors, one block and several; rollouts of no whole number of chunks.
  const bool with_wind = GENERATE(true, false);
  const std::size_t windows = GENERATE(as<std::size_t>(), 1, 3, 8, 9, 16, 17, 24, 32, 33, 40, 41, 75);
  CAPTURE(windows, with_wind);
  TrainingConfig config = rollout_config();
  config.steps = 27;
  config.hidden_units = 21;
  const Case c(config, with_wind);
  std::vector<std::size_t> drawn;
  for (std::size_t i = 0; i < windows; ++i) drawn.push_back(c.windows[i % c.windows.size()]);
  const RolloutConstants<float> constants(c.data.inputs, config, c.state.member);
  WindowBatch<float> batch;
  batch.assign(c.data, drawn.data(), drawn.size());
  const auto gradient_of = [&](const std::string& name) {
    const nn::KernelWorkspace<float> workspace(nn::kernels(name));
    nn::AlignedVector<float> gradient(c.state.member.parameters.size());
    const double loss = nn::kernels(name).loss_and_gradient(workspace.get(), constants.view(), batch.view(),
                                                            c.state.member.parameters.data(), gradient.data());
    return std::pair(loss, gradient);
  };
  CHECK(gradient_of("avx2") == gradient_of("avx512"));
}

TEST_CASE("network: a column has the same bits whatever stands beside it, and the reference's value", "[nn]") {
  const nn::NetworkShape shape{7, 3, 37, 5};
  RandomStream random(3, "test");
  const nn::AlignedVector<float> parameters = nn::initial_parameters(shape, random);
  constexpr int most = 131;
  nn::AlignedVector<float> inputs(7 * most), expected(5 * most), alone(5 * most);
  for (float& x : inputs) x = static_cast<float>(2.0 * random.normal());
  test::reference_forward(shape, parameters.data(), inputs.data(), most, expected.data());
  for (const std::string& name : nn::available_kernels()) {
    CAPTURE(name);
    const nn::Kernels<float>& kernels = nn::kernels(name);
    const nn::KernelWorkspace<float> workspace(kernels);
    const nn::PackedNetwork<float> network(kernels, shape, parameters.data());
    for (int i = 0; i < most; ++i)
      kernels.forward(workspace.get(), network.get(), inputs.data() + 7 * i, 1, alone.data() + 5 * i);
    double worst = 0.0;
    for (std::size_t i = 0; i < alone.size(); ++i)
      worst = std::max(worst, std::abs(static_cast<double>(alone[i]) - expected[i]));
    CHECK(worst < 1e-6);
    for (int n = 1; n <= most; n += n < 40 ? 1 : 13) {
      nn::AlignedVector<float> outputs(5 * static_cast<std::size_t>(n));
      kernels.forward(workspace.get(), network.get(), inputs.data(), n, outputs.data());
      if (!std::equal(outputs.begin(), outputs.end(), alone.begin())) FAIL_CHECK("the bits differ at n = " << n);
    }
  }
}

TEST_CASE("adam: the first two steps follow the published update", "[nn]") {
  // Step 1 moves each parameter by -rate * g / (|g| + eps); step 2 computed from m, v with their corrections.
  const nn::AdamSettings settings{0.1, 0.9, 0.999, 1e-8};
  std::vector<double> p{1.0, -2.0}, m(2, 0.0), v(2, 0.0);
  std::vector<double> g{0.5, -4.0};
  nn::kernels_double().adam(settings, 1, 2, g.data(), p.data(), m.data(), v.data());
  CHECK_THAT(p[0], WithinAbs(0.9, 1e-8));
  CHECK_THAT(p[1], WithinAbs(-1.9, 1e-8));
  g = {-1.0, 2.0};
  nn::kernels_double().adam(settings, 2, 2, g.data(), p.data(), m.data(), v.data());
  const double m0 = (0.9 * 0.1 * 0.5 + 0.1 * -1.0) / (1.0 - 0.81);
  const double v0 = (0.999 * 0.001 * 0.25 + 0.001 * 1.0) / (1.0 - 0.999 * 0.999);
  CHECK_THAT(p[0], WithinAbs(0.9 - 0.1 * m0 / (std::sqrt(v0) + 1e-8), 1e-7));
}

TEST_CASE("network: initial weights are uniform in one over the root of the fan-in", "[nn]") {
  const nn::NetworkShape shape{8, 3, 64, 3};
  RandomStream random(1, "test");
  const nn::AlignedVector<float> p = nn::initial_parameters(shape, random);
  REQUIRE(p.size() == 64 * 9 + 2 * 64 * 65 + 3 * 65);
  double largest_first = 0.0, square_second = 0.0;
  for (int i = 0; i < 64 * 9; ++i) largest_first = std::max(largest_first, std::abs(static_cast<double>(p[i])));
  for (int i = 64 * 9; i < 64 * 9 + 64 * 65; ++i) square_second += static_cast<double>(p[i]) * p[i] / (64 * 65);
  CHECK(largest_first <= 1.0 / std::sqrt(8.0));
  CHECK(largest_first > 0.98 / std::sqrt(8.0));
  CHECK_THAT(square_second, WithinRel(1.0 / 64.0 / 3.0, 0.05));  // variance of a uniform distribution
}

TEST_CASE("kernels: an unknown name is refused with the names there are", "[nn]") {
  CHECK_THROWS_AS(nn::kernels("sse9"), UsageError);
  CHECK(nn::kernels("auto").name == nn::available_kernels().front());
}
