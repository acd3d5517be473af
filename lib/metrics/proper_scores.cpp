#include "metrics/proper_scores.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/linear_algebra.hpp"
#include "core/random.hpp"
#include "core/units.hpp"

namespace leeway {
namespace {

constexpr std::size_t kShifts = 200;  // of P particles: 200 P distances at most

}  // namespace

double gaussian_log_score(double squared_maha, const Eigen::Matrix3d& Sigma) {
  const Vec3<double> sd = Sigma.diagonal().cwiseSqrt();
  const Eigen::Matrix3d correlation = sd.cwiseInverse().asDiagonal() * Sigma * sd.cwiseInverse().asDiagonal();
  return 0.5 * (squared_maha + std::log(correlation.determinant()) + 3.0 * std::log(2.0 * kPi)) +
         sd.array().log().sum();
}

double energy_score(std::span<const Vec3<double>> particles, const Vec3<double>& truth) {
  const std::size_t P = particles.size(), shifts = std::min(P - 1, kShifts);
  double to_truth = 0.0, apart = 0.0;
  for (const Vec3<double>& particle : particles) to_truth += (particle - truth).norm();
  for (std::size_t i = 0; i < shifts; ++i) {
    const std::size_t shift = 1 + i * (P - 1) / shifts;
    for (std::size_t p = 0; p < P; ++p) apart += (particles[p] - particles[(p + shift) % P]).norm();
  }
  const auto n = static_cast<double>(P);
  return to_truth / n - (shifts > 0 ? 0.5 * apart / n / static_cast<double>(shifts) * (n - 1.0) / n : 0.0);
}

double crps(std::span<double> values, double truth) {
  std::sort(values.begin(), values.end());
  const auto n = static_cast<double>(values.size());
  double to_truth = 0.0, apart = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    to_truth += std::abs(values[i] - truth);
    apart += (2.0 * static_cast<double>(i) + 1.0 - n) * (values[i] - values.front());
  }
  return to_truth / n - apart / (n * n);
}

double pit(std::span<const double> sorted, double truth) {
  const auto [below, above] = std::equal_range(sorted.begin(), sorted.end(), truth);
  return 0.5 * static_cast<double>((below - sorted.begin()) + (above - sorted.begin())) /
         static_cast<double>(sorted.size());
}

void add_proper_scores(std::span<const ParticleState> particles, const Vec3<double>& noise_sd, const PointName& name,
                       HonestDistances& honest, PointScore& point) {
  if (!std::isnan(point.squared_maha))
    if (const auto distance = honest.of(spread_of_members(particles), noise_sd)) {
      if (distance->mean) point.honest_maha = *distance->mean;
      for (std::size_t i = 0; i < point.covered.size(); ++i)
        point.covered[i] = point.squared_maha <= distance->radii[i];
    }
  std::vector<Vec3<double>> drawn;
  for (const ParticleState& particle : particles) drawn.push_back(particle.nu);
  if (!noise_sd.isZero()) {
    RandomStream random(name.sequence, "noise of " + std::string(name.recording), name.step);
    for (Vec3<double>& nu : drawn)
      nu += noise_sd.cwiseProduct(Vec3<double>(random.normal(), random.normal(), random.normal()));
  }
  point.energy = energy_score(drawn, point.truth);
  std::vector<double> values(drawn.size());
  for (int i = 0; i < 3; ++i) {
    std::transform(drawn.begin(), drawn.end(), values.begin(), [&](const Vec3<double>& nu) { return nu(i); });
    point.crps(i) = crps(values, point.truth(i));
    point.pit(i) = pit(values, point.truth(i));
  }
}

}  // namespace leeway
