#pragma once

#include <optional>
#include <string>
#include <vector>

#include "ensemble/disturbance.hpp"
#include "ensemble/model_files.hpp"

namespace leeway::ensemble {

/// How far recordings lay from the mean prediction of networks that had not seen them: of one channel, a time after the
/// start. Nothing where there are too few recordings for a finite radius.
struct Radius {
  std::optional<double> half, most;  ///< of 50 and 90 % of recordings

  friend bool operator==(const Radius&, const Radius&) = default;
};

/// Radii at one time after the start of a sequence: u, v_m [m/s], r [rad/s], position [m].
struct RadiiAtTime {
  double t_s = 0.0;
  std::array<Radius, 4> channels;

  friend bool operator==(const RadiiAtTime&, const RadiiAtTime&) = default;
};

/// What a prediction needs besides members so that its spread is honest: <folder>/calibration.json. Found by
/// cross_fit(), never from the members' own training recordings.
struct Calibration {
  Disturbance disturbance;
  Vec3<double> sensor_sd = Vec3<double>::Zero();  ///< noise of recorded u, v_m [m/s], r [rad/s]: error of a start
  /// Means over held-out sequences of the squared error, averaged over blocks of time, and what each source is expected
  /// to have of it: (u, v_m [m/s], r [rad/s]) squared.
  Vec3<double> squared_error = Vec3<double>::Zero(), of_members = Vec3<double>::Zero(),
               of_inputs = Vec3<double>::Zero(), of_disturbance = Vec3<double>::Zero(),
               of_sensors = Vec3<double>::Zero();
  int folds = 0, members = 0;  ///< of the cross-fitting
  std::size_t recordings = 0, sequences = 0;
  std::vector<RadiiAtTime> radii;
};

/// With the training's id, which tells it from that of another ensemble.
void write_calibration(const std::string& folder, const Calibration& calibration, const EnsembleHeader& header,
                       const io::Json& provenance);
/// Nothing where the folder has none. Throws InputError where the file is damaged or of another training.
std::optional<Calibration> read_calibration(const std::string& folder, const EnsembleHeader& header);

/// The radii as calibration.json and prediction.json have them.
io::Json to_json(const std::vector<RadiiAtTime>& radii);

}  // namespace leeway::ensemble
