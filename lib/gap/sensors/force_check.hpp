#pragma once

#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "dynamics/replay.hpp"
#include "gap/result/sensor_findings.hpp"
#include "gap/sensors/reading_odds.hpp"
#include "ship/ship.hpp"

namespace leeway::gap {

/// Of the predicted velocities (u, v_m, r) at three times of a window, in units of their typical changes.
using WindowError = Eigen::Matrix<double, 9, 1>;

/// Of one way to read against another, from the windows in which they differ.
Odds odds_of(const std::vector<WindowError>& better, const std::vector<WindowError>& worse);

/// Short predictions by the ship's model from recorded states, against what was recorded.
class ForceCheck {
 public:
  /// Windows and typical changes are those of these recordings.
  ForceCheck(const Ship& ship, const std::vector<Trajectory>& recordings);

  std::size_t blocks() const;
  /// Of the same recordings, read in one way or another; NaN where there is nothing to compare.
  std::vector<WindowError> errors(const std::vector<Trajectory>& recordings) const;

 private:
  struct Window {
    std::size_t recording;
    double start_s;
  };
  std::optional<ShipState<double>> state_at(const Trajectory& t, double time) const;
  WindowError error(const Trajectory& recording, const RecordedInputs& inputs, double start_s) const;

  const Ship& ship_;
  Model<double> model_;
  double horizon_s_ = 0.0;
  std::vector<Window> windows_;
  Vec3<double> spread_ = Vec3<double>::Ones();
};

/// Root mean square of the errors of one recording, in units of its own typical changes; none where it is too short.
std::optional<double> typical_force_error(const Ship& ship, const Trajectory& recording);

/// Whether a channel shows in the forces alone.
bool is_judged_by_forces(std::string_view channel);

/// What the kinematics have decided before.
struct DecidedByKinematics {
  bool wind = false, velocities = false;
};

/// Tries the readings of actuators, wind and undecided velocities by the forces, and notes what they contradict.
void contradicted_by_forces(const Ship& ship, std::vector<Trajectory> recordings, DecidedByKinematics decided,
                            Conventions& result);

}  // namespace leeway::gap
