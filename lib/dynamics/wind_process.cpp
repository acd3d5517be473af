#include "dynamics/wind_process.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "core/errors.hpp"
#include "core/units.hpp"
#include "core/wind.hpp"

namespace leeway {
namespace {

// Hino's spectrum of natural wind.
constexpr double kSurfaceDrag = 0.001;       // K
constexpr double kPowerLaw = 1.0 / 8.0;      // alpha_H, exponent of the wind profile
constexpr double kStability = 2.0;           // m
constexpr double kHeight_m = 15.0;           // Z
constexpr double kReferenceFrequency = 0.5;  // [Hz], where the spectrum of the process meets Hino's

// Kuwashima's regression of the direction.
constexpr double kDirectionSigma = 2.3 * kDegree;  // [rad/s^0.5]
constexpr double kDirectionSd = 32.0 * kDegree;    // [rad] at 1 m/s

constexpr double kCalm_mps = 1e-6;  // below, the formulae lose their digits and the wind its effect

// Von Mises about 0: density proportional to exp(kappa cos x). Rejection from a wrapped Cauchy distribution.
// Source: Best & Fisher (1979), Applied Statistics 28, 152-157.
double von_mises(double kappa, RandomStream& stream) {
  if (kappa < 1e-6) return stream.uniform(-kPi, kPi);  // uniform within 1e-6
  const double tau = 1.0 + std::sqrt(1.0 + 4.0 * kappa * kappa);
  const double rho = (tau - std::sqrt(2.0 * tau)) / (2.0 * kappa);
  const double s = (1.0 + rho * rho) / (2.0 * rho);
  for (;;) {
    const double z = std::cos(kPi * stream.uniform());
    const double f = (1.0 + s * z) / (s + z);
    const double c = kappa * (s - f);
    const double accept = 1.0 - stream.uniform();  // (0, 1]
    const bool is_taken = c * (2.0 - c) > accept || std::log(c / accept) + 1.0 >= c;
    if (is_taken)
      return stream.uniform() < 0.5 ? -std::acos(std::clamp(f, -1.0, 1.0)) : std::acos(std::clamp(f, -1.0, 1.0));
  }
}

}  // namespace

WindSpeedProcess wind_speed_process(double mean_mps) {
  const double turbulence2 = 6.0 * kSurfaceDrag * mean_mps * mean_mps;
  const double beta_H = 1.169e-3 * (mean_mps * kPowerLaw / std::sqrt(kSurfaceDrag)) *
                        std::pow(kHeight_m / 10.0, 2.0 * kStability * kPowerLaw - 1.0);
  const double S_0 = 0.2382 * turbulence2 / beta_H;
  const double ratio = kReferenceFrequency / beta_H;
  const double S_f = S_0 * std::pow(1.0 + ratio * ratio, -5.0 / 6.0);
  // S_0 / (1 + (2 pi f / alpha)^2), the spectrum of the process, is S_f at the reference frequency.
  const double alpha = 2.0 * kPi * kReferenceFrequency * std::sqrt(S_f / (S_0 - S_f));
  return {alpha, alpha * std::sqrt(S_0)};
}

WindDirectionProcess wind_direction_process(double mean_mps) {
  const double sd2 = kDirectionSd * kDirectionSd * std::pow(mean_mps, -1.5);
  return {kDirectionSigma * kDirectionSigma / (2.0 * sd2), kDirectionSigma};
}

double longest_wind_step_s(double mean_mps) {
  if (mean_mps < kCalm_mps) return std::numeric_limits<double>::infinity();
  return 1.0 / std::max(wind_speed_process(mean_mps).alpha, wind_direction_process(mean_mps).alpha);
}

WindProcess WindProcess::steady(double speed_mps, double direction_rad) {
  return WindProcess(wind_from_vector(speed_mps, direction_rad));
}

WindProcess WindProcess::stochastic(double mean_speed_mps, double mean_direction_rad, RandomStream stream) {
  if (mean_speed_mps < kCalm_mps) return steady(mean_speed_mps, mean_direction_rad);
  WindProcess wind;
  Process& p =
      wind.process_.emplace(Process{mean_speed_mps, mean_direction_rad, 0.0, 0.0, wind_speed_process(mean_speed_mps),
                                    wind_direction_process(mean_speed_mps), stream});
  const double sd = p.of_speed.sigma / std::sqrt(2.0 * p.of_speed.alpha);
  p.speed = std::abs(mean_speed_mps + sd * p.stream.normal());
  const double kappa = 2.0 * p.of_direction.alpha / (p.of_direction.sigma * p.of_direction.sigma);
  p.direction = mean_direction_rad + von_mises(kappa, p.stream);
  wind.value_ = wind_from_vector(p.speed, p.direction);
  return wind;
}

void WindProcess::advance(double dt_s) {
  if (!process_) return;
  Process& p = *process_;
  if (std::max(p.of_speed.alpha, p.of_direction.alpha) * dt_s > 1.0)
    throw UsageError(fmt::format("a time step of {} s is too long for stochastic wind of {} m/s: at most {:.3g} s",
                                 dt_s, p.mean_speed, longest_wind_step_s(p.mean_speed)));
  const double speed_noise = p.stream.normal(), direction_noise = p.stream.normal();
  p.speed += -p.of_speed.alpha * (p.speed - p.mean_speed) * dt_s + p.of_speed.sigma * std::sqrt(dt_s) * speed_noise;
  p.speed = std::abs(p.speed);
  p.direction += -p.of_direction.alpha * std::sin(p.direction - p.mean_direction) * dt_s +
                 p.of_direction.sigma * std::sqrt(dt_s) * direction_noise;
  value_ = wind_from_vector(p.speed, p.direction);
}

}  // namespace leeway
