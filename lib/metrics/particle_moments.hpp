#pragma once

#include <cstddef>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "core/types.hpp"
#include "core/units.hpp"
#include "metrics/honest_distance.hpp"

namespace leeway {

/// Running mean and covariance of the particles at one step, by Welford's update relative to the first particle: no
/// difference of large sums, so that a covariance without full rank shows as one even where the spread is a
/// millionth of the velocity.
class ParticleMoments {
 public:
  void add(const Vec3<double>& nu, double x0, double y0);

  std::size_t count() const { return count_; }
  /// mu: mean of (u, v_m [m/s], r [rad/s]).
  Vec3<double> mean() const { return first_ + mean_; }
  /// Sigma = (1/P) sum nu nu' - mu mu'.
  Eigen::Matrix3d covariance() const;
  /// Mean of (x0, y0) [m].
  Vec2<double> mean_position() const { return mean_position_; }
  /// Mean squared distance of the particles from it [m^2].
  double position_variance() const { return count_ > 0 ? squared_off_ / static_cast<double>(count_) : 0.0; }

 private:
  std::size_t count_ = 0;
  Vec3<double> first_ = Vec3<double>::Zero(), mean_ = Vec3<double>::Zero();
  Eigen::Matrix3d comoment_ = Eigen::Matrix3d::Zero();
  Vec2<double> mean_position_ = Vec2<double>::Zero();
  double squared_off_ = 0.0;
};

/// The particles of one K-step sequence, and their moments.
struct PredictedSequence {
  struct Step {
    double t_s = 0.0;
    std::size_t line = 0;  ///< of its first row
    ParticleMoments moments;
    std::vector<ParticleState> particles;  ///< in the order of the rows
    std::size_t particle_hash = 0;         ///< sum of mixed particle numbers: equal for steps with the same particles
  };
  std::vector<Step> steps;
  std::vector<std::size_t> member_of_particle;  ///< the first one seen; kNoMember for a number that never came
  bool member_changes = false;                  ///< within a particle
};
inline constexpr std::size_t kNoMember = static_cast<std::size_t>(-1);

/// What a prediction says of one recording.
struct PredictedRecording {
  std::string name, file;
  std::map<std::size_t, PredictedSequence> sequences;
  std::set<std::size_t> members;
  std::string sampling, initial_state;  ///< what the prediction says of itself; may be empty
};

/// Reads a prediction CSV ("-": standard input) whose rows may come in any order; 32 bytes of memory for each of them.
/// Recordings come sorted by name.
///   known  names of the recordings with a truth
/// Throws InputError for a recording that is not known, two times for one step, times that do not increase, a particle
/// that comes twice at a step or not at all (so that the tail of a broken stream does not pass), or no row at all.
///   may_be_empty  a file without a row gives no recording
std::vector<PredictedRecording> read_prediction(const std::string& path, const std::set<std::string>& known,
                                                bool may_be_empty = false);

}  // namespace leeway
