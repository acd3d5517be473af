#pragma once

#include <span>
#include <string_view>

#include "core/types.hpp"
#include "metrics/honest_distance.hpp"
#include "metrics/scores.hpp"

/// Scores that reward the law that the truth comes from more than any other.
/// Source: Gneiting & Raftery (2007), J. American Statistical Association 102, 359-378.
namespace leeway {

/// -ln of a Gaussian density at this squared Mahalanobis distance.
double gaussian_log_score(double squared_maha, const Eigen::Matrix3d& Sigma);

/// (1/P) sum |x_p - y| - (1/2P^2) sum sum |x_p - x_q|. Beyond 200 particles the second sum is taken over 200 shifts of
/// the particles against each other.
double energy_score(std::span<const Vec3<double>> particles, const Vec3<double>& truth);

/// The energy score of one channel, by sorting; the values are left sorted.
double crps(std::span<double> values, double truth);

/// Share of values, sorted, that lie below the truth; of those that equal it, half.
double pit(std::span<const double> sorted, double truth);

/// Which point: noise is drawn for it alone.
struct PointName {
  std::string_view recording;
  std::size_t sequence, step;
};

/// Fills what `point` has of an honest law and of proper scores, given its truth and squared_maha. Sensor noise is
/// added to the particles, a draw for each, where the truth has it.
void add_proper_scores(std::span<const ParticleState> particles, const Vec3<double>& noise_sd, const PointName& name,
                       HonestDistances& honest, PointScore& point);

}  // namespace leeway
