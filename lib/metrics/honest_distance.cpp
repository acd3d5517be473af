#include "metrics/honest_distance.hpp"

#include <algorithm>
#include <cmath>

#include "core/linear_algebra.hpp"
#include "core/random.hpp"
#include "core/statistics.hpp"

namespace leeway {
namespace {

constexpr std::size_t kDraws = 2000;            // for each point: levels are known to 1 %
constexpr std::size_t kDrawsOfMembers = 20000;  // where one law holds for all points
constexpr double kNothingWithin = 1e-9;         // of the whole variance: rounding of particles that coincide
constexpr std::size_t kFewestForMean = 6;       // members: 3 (M+1)/(M-5)

// The symmetric root of a covariance; what rounding made negative counts as zero.
Eigen::Matrix3d root_of(const Eigen::Matrix3d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(covariance);
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal() *
         eigen.eigenvectors().transpose();
}

std::array<double, 3> radii_of(std::vector<double> distances) {
  std::sort(distances.begin(), distances.end());
  std::array<double, 3> result{};
  for (std::size_t i = 0; i < result.size(); ++i) result[i] = quantile(distances, kCoverageLevels[i]);
  return result;
}

double mean_of(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

}  // namespace

SpreadOfMembers spread_of_members(std::span<const ParticleState> particles) {
  struct Group {
    std::size_t count = 0;
    Vec3<double> mean = Vec3<double>::Zero();
  };
  // Relative to the first particle, as the spread may be a millionth of the velocity.
  const Vec3<double> first = particles.front().nu;
  std::map<std::size_t, Group> groups;
  for (const ParticleState& particle : particles) {
    Group& group = groups[particle.member];
    ++group.count;
    group.mean += (particle.nu - first - group.mean) / static_cast<double>(group.count);
  }
  SpreadOfMembers spread;
  const auto P = static_cast<double>(particles.size()), M = static_cast<double>(groups.size());
  Vec3<double> mean = Vec3<double>::Zero();
  double squared_shares = 0.0, of_one = 0.0;  // of_one: of what is within, in a member's mean
  for (const auto& [member, group] : groups) {
    const double share = static_cast<double>(group.count) / P;
    mean += share * group.mean;
    squared_shares += share * share;
    of_one += 1.0 / static_cast<double>(group.count) / M;
  }
  spread.particles = particles.size();
  spread.members = static_cast<std::size_t>(std::lround(1.0 / squared_shares));
  for (const ParticleState& particle : particles) {
    const Vec3<double> off = particle.nu - first - groups[particle.member].mean;
    spread.within += off * off.transpose();
  }
  if (P > M) spread.within /= P - M;
  Eigen::Matrix3d of_means = Eigen::Matrix3d::Zero();
  for (const auto& [member, group] : groups)
    of_means += static_cast<double>(group.count) / P * (group.mean - mean) * (group.mean - mean).transpose();
  if (groups.size() > 1) of_means /= 1.0 - squared_shares;
  const Eigen::Matrix3d root = root_of(of_means - of_one * spread.within);
  spread.between = root * root;
  return spread;
}

const HonestDistances::Draws& HonestDistances::draws_of(std::size_t M, std::size_t P) {
  const std::lock_guard lock(mutex_);
  const auto [found, is_new] = draws_.try_emplace({M, P});
  Draws& result = found->second;
  if (!is_new) return result;
  RandomStream random(1, "honest distances");
  const auto normal = [&] { return Vec3<double>(random.normal(), random.normal(), random.normal()); };
  std::vector<Vec3<double>> members(M);
  std::vector<double> distances;
  for (std::size_t i = 0; i < kDrawsOfMembers; ++i) {
    Draw draw{Eigen::Matrix3d::Zero(), Eigen::Matrix3d::Zero(), Vec3<double>::Zero(), normal()};
    for (Vec3<double>& member : members) draw.mean += (member = normal()) / static_cast<double>(M);
    for (const Vec3<double>& member : members)
      draw.members += (member - draw.mean) * (member - draw.mean).transpose() / static_cast<double>(M);
    if (M > 3) {
      const Vec3<double> error = draw.truth - draw.mean;
      distances.push_back(error.dot(draw.members.llt().solve(error)));
    }
    if (i >= kDraws) continue;
    // The scatter of P - M normal vectors by Bartlett's decomposition; chi-square by sums of squares.
    const std::size_t freedom = P - M;
    Eigen::Matrix3d factor_of_scatter = Eigen::Matrix3d::Zero();
    for (int row = 0; row < 3; ++row) {
      double square = 0.0;
      for (std::size_t k = static_cast<std::size_t>(row); k < freedom; ++k) {
        const double z = random.normal();
        square += z * z;
      }
      factor_of_scatter(row, row) = std::sqrt(square);
      for (int column = 0; column < row && freedom > static_cast<std::size_t>(column); ++column)
        factor_of_scatter(row, column) = random.normal();
    }
    draw.particles = factor_of_scatter * factor_of_scatter.transpose() / static_cast<double>(P);
    result.draws.push_back(draw);
  }
  if (!distances.empty()) {
    result.mean_of_few = mean_of({distances.begin(), distances.begin() + kDraws});
    if (M >= kFewestForMean) {
      const auto n = static_cast<double>(M);
      result.of_members_alone.mean = 3.0 * (n + 1.0) / (n - 5.0);
    }
    result.of_members_alone.radii = radii_of(std::move(distances));
  }
  return result;
}

std::optional<HonestDistance> HonestDistances::of(const SpreadOfMembers& spread, const Vec3<double>& noise_sd) {
  const Eigen::Matrix3d noise = noise_sd.cwiseAbs2().asDiagonal();
  const Eigen::Matrix3d whole = spread.between + spread.within + noise;
  const bool is_of_members_alone = noise_sd.isZero() && spread.within.trace() <= kNothingWithin * whole.trace();
  if (is_of_members_alone && spread.members <= 3) return std::nullopt;
  const Draws& draws = draws_of(spread.members, spread.particles);
  if (is_of_members_alone) return draws.of_members_alone;

  const double of_one = static_cast<double>(spread.members) / static_cast<double>(spread.particles);
  const Eigen::Matrix3d members = root_of(spread.between + of_one * spread.within), particles = root_of(spread.within),
                        truth = root_of(whole);
  std::vector<double> distances;
  for (const Draw& draw : draws.draws) {
    const Vec3<double> error = truth * draw.truth - members * draw.mean;
    const Eigen::Matrix3d Sigma = members * draw.members * members + particles * draw.particles * particles + noise;
    const Eigen::LLT<Eigen::Matrix3d> factor(Sigma);
    if (factor.info() != Eigen::Success) return std::nullopt;
    distances.push_back(error.dot(factor.solve(error)));
  }
  HonestDistance result;
  result.mean = mean_of(distances);
  // The same draws of members alone have a mean that is known: what they miss of it, these miss as well.
  if (draws.of_members_alone.mean) *result.mean *= *draws.of_members_alone.mean / draws.mean_of_few;
  result.radii = radii_of(std::move(distances));
  return result;
}

}  // namespace leeway
