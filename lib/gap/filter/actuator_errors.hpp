#pragma once

#include <map>
#include <tuple>
#include <utility>
#include <vector>

#include "gap/filter/campaign.hpp"

namespace leeway::gap {

/// How far the actuators that act are from those that are recorded: by rounding, and in holes. An indicator that shows
/// whole degrees is wrong by up to half of one for as long as it shows the same; in a hole nobody knows what an
/// actuator did between two samples, or after the last one. Both errors last, as a force that somebody forgot does, so
/// that the filter has them as states (state_space.hpp). Between samples that are there the timing of a step stands for
/// them (Noise::timing_sd).
class ActuatorErrors {
 public:
  /// What is known of the actuators of all recordings together.
  ActuatorErrors(const std::vector<Trajectory>& recordings, const Ship& ship);

  /// Holes in which nobody knows what an actuator did, from the last known sample to the next [s]: a filter that passed
  /// over them would know less than at a beginning.
  ///   step_s  of the grid
  std::vector<std::pair<double, double>> lost(const Trajectory& recording, double step_s);
  /// Of each step of a stretch, whose t_s and recording stand; nothing where all actuators are recorded well.
  void set(Stretch& stretch, const Trajectory& recording);
  /// Sentences on actuators that are rounded.
  std::vector<std::string> notices() const;

 private:
  struct Hole {
    std::size_t before, after;  ///< samples that are known
    double sd;                  ///< by which bridging it errs
  };
  std::vector<Hole> holes(const Trajectory& recording, Channel channel, std::size_t first, std::size_t end);
  /// Mean square by which a hole is bridged: a part, and one that goes with the squared change over it.
  struct Bridging {
    double rest, per_change;
  };
  Bridging bridging(Channel channel, double hole_s, bool holds) const;

  const std::vector<Trajectory>& recordings_;
  struct Known {
    double range, step;  ///< of the actuator; to which it is rounded, 0: it is not [rad, 1/s]
  };
  std::map<Channel, Known> known_;
  /// By actuator, length of the hole [s] and whether a value is held: pieces of a recording have holes alike.
  std::map<std::tuple<Channel, double, bool>, Bridging> bridgings_;
};

}  // namespace leeway::gap
