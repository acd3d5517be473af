#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

#include <catch2/catch.hpp>

#include "nn/rollout.hpp"

using namespace leeway;

namespace {

float from_bits(std::uint32_t bits) {
  float value;
  std::memcpy(&value, &bits, sizeof value);
  return value;
}

// Distance from `exact` in units in the last place of a float of its size.
double ulps(float value, double exact) {
  const double unit = std::ldexp(1.0, std::max(std::ilogb(exact), -126) - 23);
  return std::abs(static_cast<double>(value) - exact) / unit;
}

}  // namespace

TEST_CASE("tanh: 2.5 units in the last place over all floats", "[nn]") {
  for (const std::string& name : nn::available_kernels()) {
    CAPTURE(name);
    // Every 509th float from zero to infinity, and its negative.
    nn::AlignedVector<float> x;
    for (std::uint32_t bits = 1; bits < 0x7f800000U; bits += 509) x.push_back(from_bits(bits));
    const std::size_t positive = x.size();
    for (std::size_t i = 0; i < positive; ++i) x.push_back(-x[i]);
    nn::AlignedVector<float> y(x.size());
    nn::kernels(name).tanh(x.data(), x.size(), y.data());
    double worst = 0.0, worst_at = 0.0, largest = 0.0;
    bool odd = true;
    for (std::size_t i = 0; i < positive; ++i) {
      const double error = ulps(y[i], std::tanh(static_cast<double>(x[i])));
      if (error > worst) {
        worst = error;
        worst_at = static_cast<double>(x[i]);
      }
      largest = std::max(largest, static_cast<double>(y[i]));
      odd = odd && y[positive + i] == -y[i];
    }
    CAPTURE(worst_at);
    CHECK(worst < 2.5);
    CHECK(largest == 1.0);
    CHECK(odd);
  }
}

TEST_CASE("tanh: zero, infinity and what is no number", "[nn]") {
  const float infinity = std::numeric_limits<float>::infinity();
  for (const std::string& name : nn::available_kernels()) {
    CAPTURE(name);
    const float x[] = {0.0F, -0.0F, infinity, -infinity, std::numeric_limits<float>::quiet_NaN()};
    float y[5] = {};
    nn::kernels(name).tanh(x, 5, y);
    CHECK(y[0] == 0.0F);
    CHECK(std::signbit(y[1]));
    CHECK(y[2] == 1.0F);
    CHECK(y[3] == -1.0F);
    CHECK(std::isnan(y[4]));  // a diverged state must not become a finite one
  }
}
