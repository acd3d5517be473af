#include "gap/sensors/kinematic_check.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/types.hpp"
#include "core/wind.hpp"
#include "gap/policy/policy.hpp"
#include "gap/sensors/kinematic_windows.hpp"

namespace leeway::gap {
namespace {

// Root mean square of the windows' residuals of one kind, by unit of the windows. That of the heading is a share of
// what the heading turned: otherwise radians read as degrees would do well by being small.
BlockErrors window_errors(const KinematicWindows& windows, Kinematics kind) {
  Eigen::VectorXd residuals = windows.residuals({});
  if (kind == Kinematics::heading) residuals /= std::max(kPolicy.sensors.least_turned_rad, windows.rms_turned());
  BlockErrors sums(windows.unit_count(), 0.0), counts(windows.unit_count(), 0.0);
  for (const WindowRun& run : windows.runs())
    if (run.kind == kind) {
      sums[run.unit] += residuals.segment(run.begin, run.size).squaredNorm();
      counts[run.unit] += static_cast<double>(run.size);
    }
  for (std::size_t b = 0; b < sums.size(); ++b) sums[b] = counts[b] > 0.0 ? std::sqrt(sums[b] / counts[b]) : kMissing;
  return sums;
}

// The longest side of the area that the recordings sailed in: in feet, errors of feet are no smaller.
double extent(const std::vector<Trajectory>& recordings) {
  double longest = 0.0;
  for (const Trajectory& recording : recordings)
    for (const Channel axis : {Channel::x0, Channel::y0}) {
      std::vector<double> places = recording[axis];
      std::erase_if(places, [](double place) { return std::isnan(place); });
      if (places.empty()) continue;
      const auto [least, most] = std::ranges::minmax(places);
      longest = std::max(longest, most - least);
    }
  return longest > 0.0 ? longest : 1.0;
}

// The windows' errors of the recordings under combinations. r leaves the track alone, and positions and velocities
// leave psi' - r alone: neither is computed twice. No reading of r does worse than none of it: what is noise on a held
// course would do well by being made small.
class ErrorsOfMotion {
 public:
  ErrorsOfMotion(const std::vector<Trajectory>& recordings, const FroudeScale& scale) {
    for (const Trajectory& recording : recordings) recordings_.push_back(at_3m(recording, scale));
  }

  BlockErrors of(const Combination& combination, Kinematics kind) {
    Combination needed;
    for (const ReadingEntry* entry : combination)
      if (entry->of == Channel::psi || (entry->of == Channel::r) == (kind == Kinematics::heading))
        needed.push_back(entry);
    BlockErrors errors = of_windows(needed, kind, true);
    if (kind == Kinematics::track) return errors;
    std::erase_if(needed, [](const ReadingEntry* entry) { return entry->of == Channel::r; });
    const BlockErrors without_r = of_windows(needed, kind, false);
    for (std::size_t b = 0; b < errors.size(); ++b) errors[b] = std::min(errors[b], without_r[b]);
    return errors;
  }

 private:
  struct Known {
    Kinematics kind;
    Combination readings;
    bool turns;  // whether r is as it is read, and not 0
    BlockErrors errors;
  };

  BlockErrors of_windows(const Combination& readings, Kinematics kind, bool turns) {
    for (const Known& known : known_)
      if (known.kind == kind && known.readings == readings && known.turns == turns) return known.errors;
    std::vector<Trajectory> read = applied(recordings_, readings);
    if (!turns)
      for (Trajectory& recording : read) scale_channel(recording, Channel::r, 0.0);
    known_.push_back({kind, readings, turns, window_errors(KinematicWindows(read), kind)});
    if (kind == Kinematics::track) {
      const double sailed = extent(read);
      for (double& error : known_.back().errors) error /= sailed;
    }
    return known_.back().errors;
  }

  std::vector<Trajectory> recordings_;  // at 3 m
  std::vector<Known> known_;
};

// Root mean square difference of the winds in parts of a recording, from samples far apart.
BlockErrors wind_errors(const Trajectory& t, std::size_t parts) {
  BlockErrors blocks;
  const std::size_t step = std::max<std::size_t>(1, t.size() / kPolicy.sensors.wind_samples);
  for (std::size_t part = 0; part < parts; ++part) {
    double sum = 0.0, count = 0.0;
    for (std::size_t k = part * t.size() / parts; k < (part + 1) * t.size() / parts; k += step) {
      const Vec2<double> expected =
          apparent_wind<double>(wind_from_vector(t[Channel::wind_speed][k], t[Channel::wind_dir][k]),
                                t[Channel::psi][k], t[Channel::u][k], t[Channel::vm][k]);
      const Vec2<double> error =
          expected - wind_from_vector(t[Channel::app_wind_speed][k], t[Channel::app_wind_dir][k]);
      if (!error.allFinite()) continue;
      sum += error.squaredNorm();
      count += 1.0;
    }
    blocks.push_back(count > 0.0 ? std::sqrt(sum / count) : kMissing);
  }
  return blocks;
}

bool has_both_winds(const Trajectory& t) {
  for (const Channel needed : {Channel::wind_speed, Channel::wind_dir, Channel::app_wind_speed, Channel::app_wind_dir,
                               Channel::psi, Channel::u, Channel::vm})
    if (!t.has(needed)) return false;
  return true;
}

}  // namespace

Combination contradicted_by_motion(const std::vector<Trajectory>& recordings, const FroudeScale& scale,
                                   Conventions& result) {
  ErrorsOfMotion errors(recordings, scale);
  const bool has_track = blocks_with_data(errors.of({}, Kinematics::track)) >= kPolicy.sensors.fewest_blocks;
  if (blocks_with_data(errors.of({}, Kinematics::heading)) < kPolicy.sensors.fewest_blocks) {
    result.unchecked.push_back("psi and r: too little heading and yaw rate to compare psi' with r");
    return {};
  }
  std::vector<Combination> groups{
      pick_readings({{"psi", "counter-clockwise"}, {"psi", "radians"}, {"psi", "degrees"}}),
      pick_readings({{"r", "counter-clockwise"}, {"r", "radians"}, {"r", "degrees"}, {"r", "degpmin"}})};
  if (has_track) {
    groups.push_back(pick_readings({{"x0", "east"}, {"y0", "west"}}));
    groups.push_back(pick_readings({{"vm", "port-positive"}}));
    groups.push_back(pick_readings({{"x0", "km"}, {"x0", "ft"}}));
    groups.push_back(pick_readings({{"u", "knots"}, {"u", "kmh"}}));
  } else {
    result.unchecked.push_back("x0, y0, u, vm: no track with a heading to compare eta' with R(psi) nu");
  }
  const auto errors_of = [&](const Combination& combination) {
    std::vector<BlockErrors> all{errors.of(combination, Kinematics::heading)};
    if (has_track) all.push_back(errors.of(combination, Kinematics::track));
    return all;
  };
  return claimed_of(groups, errors_of, "the kinematics", result);
}

Combination contradicted_by_winds(const std::vector<Trajectory>& recordings, Conventions& result) {
  const std::size_t parts = recordings.empty() ? 1
                                               : std::clamp<std::size_t>(kPolicy.sensors.blocks / recordings.size(), 1,
                                                                         kPolicy.sensors.most_wind_blocks);
  const auto errors = [&](const Combination& combination) -> std::vector<BlockErrors> {
    BlockErrors blocks;
    for (const Trajectory& t : applied(recordings, combination)) {
      if (!has_both_winds(t)) return {};
      const BlockErrors of_one = wind_errors(t, parts);
      blocks.insert(blocks.end(), of_one.begin(), of_one.end());
    }
    return {blocks};
  };
  const std::vector<BlockErrors> stated = errors({});
  if (stated.empty() || blocks_with_data(stated[0]) < kPolicy.sensors.fewest_blocks) return {};
  return claimed_of(
      {pick_readings({{"wind", "apparent"}}), pick_readings({{"wind_dir", "wind-to"}, {"wind_dir", "radians"}}),
       pick_readings({{"app_wind_dir", "wind-to"}, {"app_wind_dir", "radians"}}),
       pick_readings({{"wind_speed", "knots"}}), pick_readings({{"app_wind_speed", "knots"}})},
      errors, "true against apparent wind", result);
}

}  // namespace leeway::gap
