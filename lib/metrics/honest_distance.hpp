#pragma once

#include <array>
#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/types.hpp"

namespace leeway {

inline constexpr std::array<double, 3> kCoverageLevels{0.5, 0.9, 0.99};

/// A particle's velocities, and the member that moved it there.
struct ParticleState {
  Vec3<double> nu = Vec3<double>::Zero();  ///< (u, v_m [m/s], r [rad/s])
  std::size_t member = 0;
};

/// What varies between members and within each, as the particles at one step show it: [SI], per particle.
struct SpreadOfMembers {
  Eigen::Matrix3d between = Eigen::Matrix3d::Zero(), within = between;
  std::size_t particles = 0;
  /// Members that share the particles evenly and vary as much in the mean: 1 / sum of squared shares, rounded.
  std::size_t members = 0;
};
SpreadOfMembers spread_of_members(std::span<const ParticleState> particles);

/// The squared Mahalanobis distance of a truth that comes from the same law as the particles.
struct HonestDistance {
  std::optional<double> mean;     ///< nothing where it is infinite: up to five members without anything within them
  std::array<double, 3> radii{};  ///< squared: quantiles of kCoverageLevels
};

/// By simulation: a member's offset is drawn from a normal law with the covariance between members, a particle's from
/// one with that within; the truth is one more of both, and what it is laid beside has the sensors' noise. Particles
/// that differ by their M members alone have the mean 3 (M+1)/(M-5). Random numbers are the same for all calls.
/// Safe to call from several threads.
class HonestDistances {
 public:
  /// Nothing where the particles' covariance has no full rank.
  ///   noise_sd  of the reference, by channel: (u, v_m [m/s], r [rad/s])
  std::optional<HonestDistance> of(const SpreadOfMembers& spread, const Vec3<double>& noise_sd);

 private:
  // Of standard normal members and particles: what does not depend on the two covariances.
  struct Draw {
    Eigen::Matrix3d members, particles;  ///< covariance of the members' means; of particles about them
    Vec3<double> mean, truth;
  };
  struct Draws {
    std::vector<Draw> draws;
    HonestDistance of_members_alone;
    double mean_of_few = 0.0;  ///< of the draws that calls use, of members alone
  };
  const Draws& draws_of(std::size_t members, std::size_t particles);

  std::mutex mutex_;
  std::map<std::pair<std::size_t, std::size_t>, Draws> draws_;
};

}  // namespace leeway
