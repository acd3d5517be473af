#include "metrics/proper_scores.hpp"

#include <cmath>
#include <vector>

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "core/random.hpp"
#include "core/units.hpp"

using namespace leeway;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

// The law of a spread: members' offsets, particles about them, noise of what they are laid beside.
struct Law {
  Eigen::Matrix3d members, particles;  // factors of covariances
  Vec3<double> noise = Vec3<double>::Zero();
};

Vec3<double> normal(RandomStream& random) {
  const double a = random.normal(), b = random.normal(), c = random.normal();
  return {a, b, c};
}

std::vector<ParticleState> draw(const Law& law, std::size_t members, std::size_t particles, RandomStream& random) {
  std::vector<Vec3<double>> offset;
  for (std::size_t m = 0; m < members; ++m) offset.push_back(law.members * normal(random));
  std::vector<ParticleState> result;
  for (std::size_t p = 0; p < particles; ++p)
    result.push_back(
        {Vec3<double>(1.0, -0.2, 0.03) + offset[p % members] + law.particles * normal(random), p % members});
  return result;
}

Law law_of(double between, double within, double noise) {
  Law law;
  law.members << 0.1, 0, 0, 0.05, 0.2, 0, -0.004, 0.003, 0.01;
  law.particles = within * law.members;
  law.particles(1, 1) *= 0.5;
  law.members *= between;
  law.noise = noise * Vec3<double>(0.05, 0.1, 0.005);
  return law;
}

}  // namespace

TEST_CASE("honest distance: members that share the particles evenly have Hotelling's law", "[metrics]") {
  const Law law = law_of(1.0, 0.0, 0.0);
  RandomStream random(2, "even");
  HonestDistances honest;
  const auto of_24 = honest.of(spread_of_members(draw(law, 24, 96, random)), law.noise);
  REQUIRE(of_24);
  CHECK_THAT(*of_24->mean, WithinRel(3.0 * 25.0 / 19.0, 1e-12));  // 3.95
  // 3 (M+1)/(M-3) F(3, M-3): the median of F(3, 21) is 0.814, its quantiles 2.365 and 4.874.
  const double factor = 3.0 * 25.0 / 21.0;
  CHECK_THAT(of_24->radii[0], WithinRel(factor * 0.8139, 0.02));
  CHECK_THAT(of_24->radii[1], WithinRel(factor * 2.3649, 0.02));
  CHECK_THAT(of_24->radii[2], WithinRel(factor * 4.8740, 0.05));
  // 100 particles of 24 members: four have one particle more.
  CHECK(spread_of_members(draw(law, 24, 100, random)).members == 24);
  // Infinite with five members, of no rank with three.
  const auto of_5 = honest.of(spread_of_members(draw(law, 5, 100, random)), law.noise);
  REQUIRE(of_5);
  CHECK_FALSE(of_5->mean);
  CHECK_FALSE(honest.of(spread_of_members(draw(law, 3, 99, random)), law.noise));
}

TEST_CASE("honest distance: a truth of the same law has its mean and lies within its radii as often as they say",
          "[metrics][long]") {
  // As large within as between, with the sensors' noise and without; a thousand truths each.
  for (const double noise : {0.0, 1.0}) {
    CAPTURE(noise);
    const Law law = law_of(1.0, 1.0, noise);
    RandomStream random(3, "same law");
    HonestDistances honest;
    double found = 0.0, expected = 0.0;
    std::array<double, 3> covered{};
    const int n = 1000;
    for (int i = 0; i < n; ++i) {
      const std::vector<ParticleState> particles = draw(law, 12, 120, random);
      const Vec3<double> truth = draw(law, 1, 1, random).front().nu + law.noise.cwiseProduct(normal(random));
      Vec3<double> mean = Vec3<double>::Zero();
      for (const ParticleState& p : particles) mean += p.nu / 120.0;
      Eigen::Matrix3d Sigma = law.noise.cwiseAbs2().asDiagonal();
      for (const ParticleState& p : particles) Sigma += (p.nu - mean) * (p.nu - mean).transpose() / 120.0;
      const double squared = (truth - mean).dot(Sigma.llt().solve(truth - mean));
      const auto distance = honest.of(spread_of_members(particles), law.noise);
      REQUIRE(distance);
      found += squared / n;
      expected += *distance->mean / n;
      for (std::size_t k = 0; k < 3; ++k) covered[k] += squared <= distance->radii[k] ? 1.0 / n : 0.0;
    }
    CHECK_THAT(found, WithinRel(expected, 0.12));  // four standard errors of the mean of a thousand
    for (std::size_t k = 0; k < 3; ++k) {
      const double p = kCoverageLevels[k];
      CHECK_THAT(covered[k], WithinAbs(p, 4.0 * std::sqrt(p * (1.0 - p) / n) + 0.01));
    }
  }
}

TEST_CASE("spread of members: what varies between and within is distinguished", "[metrics]") {
  const Law law = law_of(1.0, 0.5, 0.0);
  RandomStream random(4, "apart");
  Eigen::Matrix3d between = Eigen::Matrix3d::Zero(), within = between;
  const int n = 400;
  for (int i = 0; i < n; ++i) {
    const SpreadOfMembers spread = spread_of_members(draw(law, 20, 100, random));
    between += spread.between / n;
    within += spread.within / n;
  }
  const Eigen::Matrix3d B = law.members * law.members.transpose(), W = law.particles * law.particles.transpose();
  CHECK((between - B).norm() < 0.05 * B.norm());
  CHECK((within - W).norm() < 0.05 * W.norm());
}

TEST_CASE("proper scores: of a normal law they are what the formulas say", "[metrics]") {
  // CRPS of N(0, 1) at y: y (2 Phi(y) - 1) + 2 phi(y) - 1/sqrt(pi). Gneiting & Raftery (2007), eq. 21.
  RandomStream random(5, "normal");
  std::vector<double> values(20000);
  for (double& value : values) value = random.normal();
  for (const double y : {0.0, 0.7, -2.0}) {
    const double Phi = 0.5 * std::erfc(-y / std::sqrt(2.0)), phi = std::exp(-0.5 * y * y) / std::sqrt(2.0 * kPi);
    CHECK_THAT(crps(values, y), WithinAbs(y * (2.0 * Phi - 1.0) + 2.0 * phi - 1.0 / std::sqrt(kPi), 0.01));
    CHECK_THAT(pit(values, y), WithinAbs(Phi, 0.01));
  }
  // Energy score of few particles by hand, and of many the same whether all pairs are taken or some.
  const std::vector<Vec3<double>> two{{0, 0, 0}, {3, 4, 0}};
  CHECK_THAT(energy_score(two, {0, 0, 0}), WithinRel(2.5 - 0.25 * 5.0, 1e-12));
  CHECK(energy_score(std::span(two).first(1), {0, 0, 2}) == 2.0);
  std::vector<Vec3<double>> many(1500);
  for (Vec3<double>& nu : many) nu = normal(random);
  double to_truth = 0.0, apart = 0.0;
  for (const auto& a : many) {
    to_truth += (a - Vec3<double>(1, 0, 0)).norm() / 1500.0;
    for (const auto& b : many) apart += (a - b).norm() / (1500.0 * 1500.0);
  }
  CHECK_THAT(energy_score(many, {1, 0, 0}), WithinRel(to_truth - 0.5 * apart, 0.01));
  Eigen::Matrix3d Sigma = Vec3<double>(0.04, 0.25, 1e-6).asDiagonal();
  CHECK_THAT(gaussian_log_score(2.0, Sigma),
             WithinRel(0.5 * (2.0 + 3.0 * std::log(2.0 * kPi)) + std::log(0.2 * 0.5 * 1e-3), 1e-12));
}
