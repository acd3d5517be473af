#include <algorithm>
#include <array>
#include <cmath>

#include "core/units.hpp"
#include "gap/policy/policy.hpp"
#include "gap/sensors/force_check.hpp"

namespace leeway::gap {
namespace {

bool any_has(const std::vector<Trajectory>& recordings, Channel channel) {
  return std::any_of(recordings.begin(), recordings.end(), [&](const Trajectory& t) { return t.has(channel); });
}

// The force that a channel's input makes times `gain`, about as a wrong coefficient would have it.
void with_gain(Trajectory& recording, Channel channel, double gain) {
  if (info(channel).role == Role::rudder)
    for (const Channel rudder : {Channel::delta, Channel::delta_p, Channel::delta_s})
      scale_channel(recording, rudder, gain);
  else if (is_of_wind(channel))
    for (const Channel speed : {Channel::wind_speed, Channel::app_wind_speed})
      scale_channel(recording, speed, std::sqrt(gain));
  else
    scale_channel(recording, channel, std::sqrt(gain));
}

double largest_rudder_angle(const std::vector<Trajectory>& recordings) {
  double largest = 0.0;
  for (const Trajectory& t : recordings)
    for (const Channel rudder : {Channel::delta, Channel::delta_p, Channel::delta_s})
      if (t.has(rudder))
        for (const double angle : t[rudder])
          if (std::abs(angle) > largest) largest = std::abs(angle);
  return largest;
}

// Those which kinematics leave open without a track or a heading.
bool is_of_velocities(const ReadingEntry& entry) { return entry.of == Channel::vm || entry.of == Channel::r; }

// Whether a reading changes these recordings, and concerns what the ship's forces need.
bool concerns_forces(const ReadingEntry& entry, const Ship& ship, const std::vector<Trajectory>& recordings,
                     DecidedByKinematics decided) {
  const bool has_true = any_has(recordings, Channel::wind_speed) && any_has(recordings, Channel::wind_dir);
  const bool has_apparent = any_has(recordings, Channel::app_wind_speed) && any_has(recordings, Channel::app_wind_dir);
  if (is_of_wind(entry.of)) {
    if (!ship.has_wind() || decided.wind || !any_has(recordings, Channel::psi)) return false;
    if (entry.swaps_winds) return has_true != has_apparent;
    return entry.of == Channel::wind_speed || entry.of == Channel::wind_dir ? has_true : has_apparent && !has_true;
  }
  if (entry.of == Channel::delta) {  // of all rudders
    const double largest = largest_rudder_angle(recordings);
    return largest >= entry.least_recorded && largest <= entry.most_recorded;
  }
  if (is_of_velocities(entry)) return !decided.velocities;
  return info(entry.of).role != Role::none && ship.find_actuator(entry.of) && any_has(recordings, entry.of);
}

// Looks for readings that the forces contradict, with what others were found before.
class ForceReadings {
 public:
  ForceReadings(const Ship& ship, std::vector<Trajectory> recordings, DecidedByKinematics decided, Conventions& result)
      : ship_(ship),
        recordings_(std::move(recordings)),
        decided_(decided),
        result_(result),
        check_(ship, recordings_) {}

  std::size_t blocks() const { return check_.blocks(); }

  /// Claims a reading, or a pair of which each holds given the other; false where none is left.
  bool claim_next() {
    stated_ = check_.errors(recordings_);
    std::vector<Tried> tried = try_all();
    std::stable_sort(tried.begin(), tried.end(),
                     [](const Tried& a, const Tried& b) { return a.odds.log_odds > b.odds.log_odds; });
    const auto best = std::find_if(tried.begin(), tried.end(), [](const Tried& one) { return one.holds; });
    if (best != tried.end()) {
      result_.contradicted.push_back(reading_of(*best->entry, best->odds, "the forces"));
      recordings_ = applied(std::move(recordings_), {best->entry});
      return true;
    }
    // Two wrong readings can hide each other.
    std::erase_if(tried, [](const Tried& one) { return one.odds.log_odds == 0.0; });
    tried.resize(std::min(tried.size(), kPolicy.sensors.most_in_pairs));
    return claim_pair(tried);
  }

 private:
  struct Tried {
    const ReadingEntry* entry;
    std::vector<WindowError> errors;
    Odds odds;
    bool holds = false;
  };

  // Whether a reading of recordings that are read in the stated way, apart from what is decided, beats that way, and
  // also a plain error of the force, or none of it at all.
  bool holds(const ReadingEntry& entry, const std::vector<Trajectory>& as_stated,
             const std::vector<WindowError>& errors, const Odds& odds) const {
    if (!holds_by_forces(odds)) return false;
    if (is_of_velocities(entry)) return true;
    const auto beats = [&](double gain) {
      std::vector<Trajectory> plain = as_stated;
      for (Trajectory& recording : plain) with_gain(recording, entry.of, gain);
      return beats_plain_error(odds_of(errors, check_.errors(plain)), gain);
    };
    return info(entry.of).role == Role::rudder ? std::ranges::all_of(kPolicy.sensors.plain_gains_of_rudders, beats)
                                               : std::ranges::all_of(kPolicy.sensors.plain_gains, beats);
  }

  std::vector<Tried> try_all() {
    std::vector<Tried> tried;
    for (const ReadingEntry& entry : readings()) {
      if (!concerns_forces(entry, ship_, recordings_, decided_)) continue;
      const auto is_same_channel = [&](const Reading& known) { return known.channel == entry.channel; };
      if (std::any_of(result_.contradicted.begin(), result_.contradicted.end(), is_same_channel)) continue;
      Tried one{&entry, check_.errors(applied(recordings_, {&entry})), {}};
      one.odds = odds_of(one.errors, stated_);
      one.holds = holds(entry, recordings_, one.errors, one.odds);
      note_tested(result_, reading_of(entry, one.odds, "the forces"));
      tried.push_back(std::move(one));
    }
    return tried;
  }

  bool claim_pair(const std::vector<Tried>& tried) {
    double best_odds = 0.0;
    std::vector<Reading> best_pair;
    Combination best_entries;
    for (std::size_t a = 0; a < tried.size(); ++a)
      for (std::size_t b = a + 1; b < tried.size(); ++b) {
        if (tried[a].entry->channel == tried[b].entry->channel) continue;
        const std::vector<Trajectory> with_a = applied(recordings_, {tried[a].entry});
        const std::vector<Trajectory> with_b = applied(recordings_, {tried[b].entry});
        const std::vector<WindowError> both = check_.errors(applied(with_a, {tried[b].entry}));
        const Odds of_both = odds_of(both, stated_);
        if (!(of_both.log_odds > best_odds) || !holds_by_forces(of_both)) continue;
        const Odds of_a = odds_of(both, tried[b].errors), of_b = odds_of(both, tried[a].errors);
        if (!holds(*tried[a].entry, with_b, both, of_a) || !holds(*tried[b].entry, with_a, both, of_b)) continue;
        best_odds = of_both.log_odds;
        best_entries = {tried[a].entry, tried[b].entry};
        best_pair = {reading_of(*tried[a].entry, of_a, "the forces"), reading_of(*tried[b].entry, of_b, "the forces")};
      }
    if (best_entries.empty()) return false;
    result_.contradicted.insert(result_.contradicted.end(), best_pair.begin(), best_pair.end());
    recordings_ = applied(std::move(recordings_), best_entries);
    return true;
  }

  const Ship& ship_;
  std::vector<Trajectory> recordings_;
  const DecidedByKinematics decided_;
  Conventions& result_;
  const ForceCheck check_;
  std::vector<WindowError> stated_;
};

}  // namespace

void contradicted_by_forces(const Ship& ship, std::vector<Trajectory> recordings, DecidedByKinematics decided,
                            Conventions& result) {
  std::erase_if(recordings, [&](const Trajectory& t) {
    const auto lacks = [&](const Actuator& a) { return !a.is_optional && !t.has(a.channel); };
    const bool is_short = std::any_of(ship.actuators.begin(), ship.actuators.end(), lacks) ||
                          (t.has_wind() && ship.has_wind() && !t.has(Channel::psi));
    if (is_short) result.unchecked.push_back(t.name + ": lacks an actuator or the heading that the forces need");
    return is_short;
  });
  const bool has_wind =
      ship.has_wind() && std::any_of(recordings.begin(), recordings.end(), [](const auto& t) { return t.has_wind(); });
  ForceReadings search(ship, std::move(recordings), decided, result);
  if (search.blocks() < kPolicy.sensors.fewest_blocks) {
    result.unchecked.emplace_back("actuators and wind: too little to compare with the ship's model");
    return;
  }
  if (!has_wind) result.unchecked.emplace_back("wind: not recorded, or without a force in the ship's model");
  for (std::size_t round = 0; round < kPolicy.sensors.most_force_readings && search.claim_next(); ++round) {
  }
}

}  // namespace leeway::gap
