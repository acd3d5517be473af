#include <algorithm>
#include <cmath>

#include <catch2/catch.hpp>

#include "core/random.hpp"
#include "nn/reference_kernels.hpp"
#include "nn/rollout.hpp"

using namespace leeway;

#ifdef LEEWAY_EMULATED_TILES
namespace leeway::nn::amx_emulated {
const Kernels<float>& kernels_float();
}
#endif

namespace {

bool has(const std::string& kernel) {
  const std::vector<std::string> names = nn::available_kernels();
  return std::find(names.begin(), names.end(), kernel) != names.end();
}

// A rollout of random numbers with layers that are made of whole tiles.
template <typename S>
struct RandomRollout {
  nn::AlignedVector<S> mean, inverse_sd, offset, scale, nu, weight, psi, controls, wind, parameters;
  nn::RolloutModel<S> model;
  nn::RolloutBatch<S> batch;

  RandomRollout(int windows, int points) {
    RandomStream random(4, "tiles");
    const auto fill = [&](nn::AlignedVector<S>& to, int size, double center, double spread) {
      for (int i = 0; i < size; ++i)
        to.push_back(static_cast<S>(static_cast<float>(center + spread * random.normal())));
    };
    model.dynamics = {7, 3, 64, 3};
    model.controls = 2;
    model.wind = true;
    model.dt = S(1);
    fill(mean, 7, 0.0, 0.1);
    fill(inverse_sd, 7, 1.0, 0.1);
    fill(offset, 3, 0.0, 0.01);
    fill(scale, 3, 0.05, 0.0);
    model.input_mean = mean.data();
    model.input_inverse_sd = inverse_sd.data();
    model.output_offset = offset.data();
    model.output_scale = scale.data();
    batch.windows = windows;
    batch.points = points;
    batch.count = windows * points;
    fill(nu, 3 * windows * points, 0.0, 0.1);
    fill(weight, 3 * windows * points, 10.0, 0.0);
    fill(psi, windows, 0.0, 1.0);
    fill(controls, 2 * windows * points, 0.0, 1.0);
    fill(wind, 2 * windows * points, 0.0, 0.5);
    batch.nu_observed = nu.data();
    batch.weight = weight.data();
    batch.psi_initial = psi.data();
    batch.controls = controls.data();
    batch.true_wind = wind.data();
    const nn::AlignedVector<float> drawn = nn::initial_parameters(model.dynamics, random);
    parameters.assign(drawn.begin(), drawn.end());
  }
};

// Error of the gradient by the norm of that in double precision.
double gradient_error(const nn::Kernels<float>& kernels, int windows) {
  const RandomRollout<double> exact(windows, 23);
  const RandomRollout<float> single(windows, 23);
  nn::AlignedVector<double> expected(exact.parameters.size());
  nn::AlignedVector<float> gradient(exact.parameters.size());
  test::reference_loss_and_gradient(exact.model, exact.batch, exact.parameters.data(), expected.data());
  const nn::KernelWorkspace<float> workspace(kernels);
  kernels.loss_and_gradient(workspace.get(), single.model, single.batch, single.parameters.data(), gradient.data());
  double difference = 0.0, square = 0.0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    difference += std::pow(gradient[i] - expected[i], 2);
    square += expected[i] * expected[i];
  }
  return std::sqrt(difference / square);
}

}  // namespace

TEST_CASE("tiles: three products of bf16 give the gradient to 1e-4, in software", "[nn]") {
#ifdef LEEWAY_EMULATED_TILES
  if (!has("avx512")) {
    WARN("skipped: this processor has no AVX-512, which the emulated tiles are compiled for");
    return;
  }
  // Below, at and above the widths of blocks; the last chunk is not full.
  for (const int windows : {5, 16, 30, 32, 47}) {
    CAPTURE(windows);
    const double error = gradient_error(nn::amx_emulated::kernels_float(), windows);
    CHECK(error < 1e-4);
    CHECK(error > 1e-9);
  }
#else
  WARN("skipped: not built for x86-64");
#endif
}

TEST_CASE("tiles: three products of bf16 give the gradient to 1e-4, in the processor", "[nn]") {
  if (!has("amx")) {
    WARN("skipped: this processor has no AMX, or the system does not give it");
    return;
  }
  for (const int windows : {5, 16, 30, 32, 47}) {
    CAPTURE(windows);
    CHECK(gradient_error(nn::kernels("amx"), windows) < 1e-4);
  }
}
