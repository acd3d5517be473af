#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dynamics/simulation.hpp"
#include "io/prediction_csv.hpp"

namespace leeway {

enum class InputInterpolation {
  linear,            ///< between samples
  at_actuator_rate,  ///< the same, but an actuator moves at the rate that the ship's file states
  hold               ///< a sample acts until the next one comes
};

/// The actuators (actual values) and the true wind of a recording as functions of time. A missing sample is bridged by
/// holding the last known value; before the first known one there is nothing. The true wind is that of the recording,
/// or follows from its apparent wind, heading and velocity; without wind columns the air is calm.
class RecordedInputs {
 public:
  /// Throws InputError if the recording lacks an actuator of the ship that is not optional, or has an apparent wind but
  /// no heading.
  RecordedInputs(const Trajectory& recording, const Ship& ship, InputInterpolation interpolation);

  /// Index of the first sample at which every input is known; nothing if there is none.
  std::optional<std::size_t> first_known() const { return first_known_; }
  /// The same recording, whose rudders act as `response` lets them.
  RecordedInputs through(const RudderResponse& response) const;
  /// What acts over the step from t_s to t_s + dt_s, within the recording's time.
  StepInputs<double> step(double t_s, double dt_s) const;
  /// What acts at one time.
  Inputs<double> at(double t_s) const;
  /// The ship's actuators that the recording has.
  const std::vector<Channel>& channels() const { return channels_; }
  bool has_wind() const { return has_wind_; }
  /// What a user should know: samples outside the limits of the ship's actuators, no wind.
  const std::vector<std::string>& notices() const { return notices_; }

 private:
  struct Place {
    std::size_t before, after;
    double weight;
    double value(const std::vector<double>& v) const {
      return weight == 0.0 ? v[before] : v[before] + weight * (v[after] - v[before]);
    }
  };
  Place place(double t_s) const;
  // An actuator that moves at its own rate rests before or after: it moves next to the interval in which it moves on
  // the same way. Where it does in neither nobody knows when: evenly, as in the mean over all that is possible; in the
  // middle where a rate limit follows, which would begin too soon. Evenly also where it moves on in both, or needs all
  // of the time.
  double angle_or_speed(std::size_t actuator, const Place& at) const;
  void let_rudders_act(Inputs<double>& inputs) const;

  std::vector<double> t_;
  std::vector<Channel> channels_;
  std::vector<std::vector<double>> actuators_;
  std::vector<double> rates_;  // at which they move [rad/s, 1/s^2]
  std::vector<double> tails_;  // what is left to an actuator that no longer moves at its full rate [rad, 1/s]
  bool rate_limit_follows_ = false;
  std::vector<double> wind_x_, wind_y_;
  bool has_wind_ = false;
  InputInterpolation interpolation_;
  std::optional<std::size_t> first_known_;
  std::vector<std::string> notices_;
  RudderResponse response_;
  std::vector<double> slow_t_;                    // where rudders have a memory, a finer grid
  std::vector<std::vector<double>> slow_angles_;  // by place in channels_; only those of rudders are used
};

/// What a replay says of the holes that it drives through, with the last inputs or those between two samples. Throws
/// InputError for one that is longer than all the rest of the recording, and for samples so far apart that they are
/// hardly in seconds.
std::vector<std::string> holes_to_drive_through(const Trajectory& recording, const TimeGrid& grid);

/// Drives the ship with a recording's inputs from its first complete state to its end, sampled every `sample_s` from
/// there on. Without a position the track starts at the origin. The duration in `grid` is not used. Throws InputError
/// if no sample has state and inputs, NumericalError with the time if the run diverges.
Trajectory replay(const Ship& ship, const Trajectory& recording, const RecordedInputs& inputs, const TimeGrid& grid);

/// Cuts a recording into sequences of K points at `grid.sample_s`, as ens-predict does (resample(), test_sequences()),
/// starts each at the recorded state and writes all points as predictions of particle 0, member 0. Sequences count
/// through the recording. Returns their number.
std::size_t replay_sequences(const Ship& ship, const Trajectory& recording, const RecordedInputs& inputs,
                             const TimeGrid& grid, std::size_t K, io::PredictionWriter& writer);

}  // namespace leeway
