#include "gap/sensors/conventions.hpp"

#include <algorithm>
#include <optional>

#include <fmt/format.h>

#include "core/errors.hpp"
#include "core/parallel.hpp"
#include "core/statistics.hpp"
#include "gap/policy/policy.hpp"
#include "gap/sensors/force_check.hpp"
#include "gap/sensors/kinematic_check.hpp"

namespace leeway::gap {
namespace {

Conventions check(const Ship& ship, bool knows_forces, const std::vector<Trajectory>& given) {
  Conventions result;
  std::vector<Trajectory> recordings = given;
  DecidedByKinematics decided;
  const std::size_t unchecked = result.unchecked.size();
  const Combination by_motion = contradicted_by_motion(recordings, FroudeScale(ship.particulars.L_pp), result);
  decided.velocities = result.unchecked.size() == unchecked;
  recordings = applied(std::move(recordings), by_motion);

  const std::size_t tested = result.tested.size();
  const Combination by_winds = contradicted_by_winds(recordings, result);
  decided.wind = result.tested.size() > tested;
  recordings = applied(std::move(recordings), by_winds);
  if (knows_forces)
    contradicted_by_forces(ship, std::move(recordings), decided, result);
  else
    result.unchecked.emplace_back("actuators and the wind's force: there is no ship's model to compare with");
  std::stable_sort(result.tested.begin(), result.tested.end(),
                   [](const Reading& a, const Reading& b) { return a.log_odds > b.log_odds; });
  return result;
}

}  // namespace

Conventions check_conventions(const Ship& ship, const std::vector<Trajectory>& recordings) {
  return check(ship, true, recordings);
}

Conventions check_motion(const Ship& ship, const std::vector<Trajectory>& recordings) {
  return check(ship, false, recordings);
}

std::vector<Reading> contradicted_in_one(const Ship& ship, const std::vector<Trajectory>& recordings,
                                         const Conventions& of_all, std::size_t jobs) {
  const auto odds_of_all = [&](const Reading& reading) {
    for (const Reading& known : of_all.tested)
      if (known.channel == reading.channel && known.name == reading.name) return known.log_odds;
    return 0.0;
  };
  const auto is_read_by_all = [&](std::size_t i) { return reread(recordings[i], of_all.contradicted); };
  // Strong forces that the model lacks are imitated by a reading that weakens an actuator; a right one leaves an error
  // as in the other recordings.
  const auto is_mended = [&](std::size_t i, const Reading& by) {
    std::vector<double> others;
    for (std::size_t j = 0; j < recordings.size(); ++j)
      if (const auto error = typical_force_error(ship, is_read_by_all(j)); j != i && error) others.push_back(*error);
    const auto error = typical_force_error(ship, reread(is_read_by_all(i), {by}));
    if (others.empty() || !error) return true;
    return *error < kPolicy.sensors.like_others * median(others);
  };
  std::vector<std::optional<Reading>> found(recordings.size());
  parallel_for(recordings.size(), jobs, [&](std::size_t i) {
    const std::vector<Reading> tested = check_conventions(ship, {is_read_by_all(i)}).tested;
    if (tested.empty()) return;
    const Reading& best = tested.front();
    if (best.log_odds > kPolicy.sensors.odd_one_odds && best.error_ratio > kPolicy.sensors.odd_one_ratio &&
        odds_of_all(best) - best.log_odds < -kPolicy.sensors.decisive_odds &&
        (!is_judged_by_forces(best.channel) || is_mended(i, best)))
      found[i] = best;
  });
  std::vector<Reading> result;
  for (std::size_t i = 0; i < found.size(); ++i)
    if (found[i]) {
      found[i]->recording = recordings[i].name;
      found[i]->sentence = recordings[i].name + ": " + found[i]->sentence;
      result.push_back(*found[i]);
    }
  return result;
}

Trajectory reread(const Trajectory& recording, const std::vector<Reading>& readings) {
  std::vector<const ReadingEntry*> known;
  for (const Reading& reading : readings) {
    if (!reading.recording.empty() && reading.recording != recording.name) continue;
    const ReadingEntry* entry = find_reading(reading.channel, reading.name);
    if (!entry) throw UsageError(fmt::format("no reading '{}' of '{}' is known", reading.name, reading.channel));
    known.push_back(entry);
  }
  return applied({recording}, known)[0];
}

}  // namespace leeway::gap
