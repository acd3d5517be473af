#include "dynamics/dataset_runs.hpp"

#include <cmath>
#include <stdexcept>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/errors.hpp"
#include "core/units.hpp"
#include "dynamics/berthing.hpp"
#include "dynamics/phased_maneuvers.hpp"
#include "dynamics/port_navigation.hpp"
#include "dynamics/scaled_replay.hpp"

namespace leeway {
namespace {

constexpr std::size_t kMostWinds = 200;  // that are drawn for one replay

// What sets one run apart from another of the same specification.
struct RunSeed {
  std::uint64_t seed = 0, place = 0;
  RandomStream stream(std::string_view purpose) const { return {seed, purpose, place}; }
};

BerthingPlan berthing_plan(const Ship& ship, const RunSeed& seed) {
  return draw_berthing(ship, seed.stream("berthing plan"));
}

PortPlan port_plan(const Ship& ship, const RunSpec& run, const RunSeed& seed) {
  return draw_port_navigation(ship, run.duration_s, seed.stream("port navigation plan"));
}

SimulatedShip start_of(const Ship& ship, const RunSpec& run, const RunSeed& seed) {
  if (run.kind == ManeuverKind::straight) return steady_ahead(ship, run.u0_mps);
  if (run.kind == ManeuverKind::berthing) return ship_at_start(ship, berthing_plan(ship, seed).steering);
  if (run.kind == ManeuverKind::port_navigation) return ship_at_start(ship, port_plan(ship, run, seed).steering);
  return SimulatedShip(ship, run.u0_mps);
}

// The ship at the start outlives the maneuver.
std::unique_ptr<Maneuver> maneuver_of(const SimulatedShip& start, const RunSpec& run, const RunSeed& seed) {
  switch (run.kind) {
    case ManeuverKind::random:
      return random_orders(start.ship, seed.stream("random orders"));
    case ManeuverKind::berthing:
      return berthing(start.ship, berthing_plan(start.ship, seed), seed.stream("berthing pilot"));
    case ManeuverKind::port_navigation:
      return port_navigation(start.ship, port_plan(start.ship, run, seed), run.duration_s,
                             seed.stream("port navigation pilot"));
    case ManeuverKind::zigzag:
      return zigzag(start.ship, run.rudder, run.heading);
    case ManeuverKind::turning:
      return turning(start.ship, run.rudder);
    case ManeuverKind::pull_out:
      return pull_out(start, run.rudder);
    case ManeuverKind::spiral:
      return spiral(start, run.rudder, run.rudder / 5.0, run.rudder / 50.0);
    case ManeuverKind::crash_stop:
      return crash_stop(start);
    case ManeuverKind::coast_down:
      return coast_down(start);
    case ManeuverKind::thruster_pulses:
      return thruster_pulses(start, thruster_pulses_for(start.ship));
    case ManeuverKind::straight:
      return straight(start.ship, course_keeper(start));
    case ManeuverKind::replay:
      break;
  }
  throw std::logic_error("a maneuver without a case");
}

double draw(const DrawnRange& range, RandomStream& stream) {
  return range.low == range.high ? range.low : stream.uniform(range.low, range.high);
}

// The wind of a run, and its mean for the notes.
struct DrawnWind {
  WindProcess process;
  io::Json mean;
};

//   of  "" for a run's own; a replay, which has the place of the run that it replays, has its wind by other numbers
DrawnWind draw_wind(const RunSpec& run, const RunSeed& seed, const std::string& of = "") {
  RandomStream stream = seed.stream("wind of a run" + of);
  const double speed = draw(run.wind_speed_mps, stream);
  const double direction = draw(run.wind_dir, stream);
  return {run.has_stochastic_wind ? WindProcess::stochastic(speed, direction, seed.stream("stochastic wind" + of))
                                  : WindProcess::steady(speed, direction),
          {{"speed_mps", speed}, {"dir_deg", rad_to_deg(direction)}}};
}

Ship ship_of(const Ship& ship, const RunSpec& run) {
  Ship result = ship;
  result.effects.insert(result.effects.end(), run.unrecorded.begin(), run.unrecorded.end());
  return result;
}

io::Json to_json(const EffectEntry& effect) {
  io::Json json{{"type", effect.type}};
  for (const auto& [name, value] : effect.parameters) json[name] = value ? io::Json(*value) : io::Json(nullptr);
  return json;
}

//   duration_s  that is simulated, of a run that is planned for its own
SimulatedRun steer(const DatasetSpec& spec, const RunSpec& run, const RunSeed& seed, double duration_s) {
  const Ship ship = ship_of(spec.ship, run);
  const SimulatedShip start = start_of(ship, run, seed);
  DrawnWind wind = draw_wind(run, seed);
  const auto maneuver = maneuver_of(start, run, seed);
  SimulatedRun result{simulate(start, *maneuver, wind.process, {spec.grid.dt_s, spec.grid.sample_s, duration_s}), {}};
  if (!has_notes(run)) return result;
  if (run.kind == ManeuverKind::port_navigation) result.notes["plan"] = to_json(port_plan(ship, run, seed));
  result.notes["wind"] = wind.mean;
  result.notes["unrecorded"] = io::Json::array();
  for (const EffectEntry& effect : run.unrecorded) result.notes["unrecorded"].push_back(to_json(effect));
  return result;
}

// Winds are drawn until the replay keeps to the run that it replays.
SimulatedRun replay_in_wind(const DatasetSpec& spec, const RunSpec& run, const RunSeed& seed) {
  const DatasetSpec& other = *run.replayed;
  const RunSpec source = placed_runs(other, seed.seed)[run.replayed_place].run;
  // A sample more than it has: rounding may have cut off the end of the replay's last one.
  const double duration_s = source.duration_s + other.grid.sample_s;
  const Trajectory recording = steer(other, source, {seed.seed, run.replayed_place}, duration_s).truth;
  const FroudeLaw law(other.ship.particulars.L_pp / spec.ship.particulars.L_pp);
  const Trajectory scaled = scaled_down(recording, law);
  for (std::size_t winds = 1; winds <= kMostWinds; ++winds) {
    const DrawnWind wind = draw_wind(run, seed, fmt::format(" of a replay, drawn {}", winds));
    Trajectory truth =
        replay_to_scale(spec.ship, recording, law, wind.process, {spec.grid.dt_s, spec.grid.sample_s, run.duration_s});
    if (is_like(truth, scaled))
      return {std::move(truth), {{"replay_of", source.name}, {"winds_drawn", winds}, {"wind", wind.mean}}};
  }
  throw NumericalError(fmt::format("in none of {} winds does the replay keep to the run '{}'; expected weaker wind",
                                   kMostWinds, source.name));
}

// Whole samples for runs that share a duration [samples].
std::vector<std::size_t> drawn_samples(const SharedDuration& shared, double sample_s, RandomStream stream) {
  const double time = FroudeLaw(shared.replayed_at_scale).time;
  const auto total = static_cast<std::size_t>(std::llround(shared.total_s / sample_s));
  const auto replayed = static_cast<std::size_t>(std::llround(shared.total_s / sample_s / time));
  std::vector<std::size_t> samples = share_samples(replayed, shared.count, stream);
  std::size_t of_replays = 0, given = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    of_replays += samples[i];
    const bool is_last = i + 1 == samples.size();
    const auto until = is_last ? total : static_cast<std::size_t>(std::llround(static_cast<double>(of_replays) * time));
    samples[i] = until - given;
    given = until;
  }
  return samples;
}

}  // namespace

std::vector<std::size_t> share_samples(std::size_t total, std::size_t count, RandomStream stream) {
  std::vector<double> until{0.0};  // sums of the weights
  for (std::size_t i = 0; i < count; ++i) until.push_back(until.back() + stream.uniform(0.7, 1.3));
  std::vector<std::size_t> samples;
  std::size_t given = 0;
  for (std::size_t i = 1; i <= count; ++i) {
    const double due = static_cast<double>(total) * (until[i] / until.back());
    const std::size_t next = i == count ? total : static_cast<std::size_t>(std::llround(due));
    samples.push_back(next - given);
    given = next;
  }
  return samples;
}

std::vector<PlacedRun> placed_runs(const DatasetSpec& spec, std::uint64_t seed) {
  std::vector<PlacedRun> places;
  for (std::size_t s = 0; s < spec.sets.size(); ++s) {
    const DatasetSpec::Set& set = spec.sets[s];
    const std::size_t first_of_set = places.size();
    for (const RunSpec& run : set.runs) places.push_back({s, run});
    for (const SharedDuration& shared : set.shared_durations) {
      const std::size_t first = first_of_set + shared.first;
      const std::vector<std::size_t> samples = drawn_samples(shared, spec.grid.sample_s, {seed, "durations", first});
      for (std::size_t i = 0; i < shared.count; ++i)
        places[first + i].run.duration_s = grid_time(samples[i], spec.grid.sample_s);
    }
  }
  const DatasetSpec* other = nullptr;
  std::vector<PlacedRun> of_other;
  for (auto& [set, run] : places) {
    if (run.kind != ManeuverKind::replay) continue;
    if (other != run.replayed.get()) of_other = placed_runs(*run.replayed, seed);
    other = run.replayed.get();
    const double time = FroudeLaw(other->ship.particulars.L_pp / spec.ship.particulars.L_pp).time;
    const double samples = of_other[run.replayed_place].run.duration_s / time / spec.grid.sample_s;
    run.duration_s = grid_time(static_cast<std::size_t>(std::llround(samples)), spec.grid.sample_s);
  }
  return places;
}

bool has_notes(const RunSpec& run) {
  return run.kind == ManeuverKind::port_navigation || run.kind == ManeuverKind::replay || !run.unrecorded.empty();
}

SimulatedRun simulate_run(const DatasetSpec& spec, const RunSpec& run, std::uint64_t seed, std::size_t place) {
  try {
    return run.kind == ManeuverKind::replay ? replay_in_wind(spec, run, {seed, place})
                                            : steer(spec, run, {seed, place}, run.duration_s);
  } catch (const NumericalError& error) {
    throw NumericalError(fmt::format("{}: {}", run.name, error.what()));
  }
}

void require_possible(const Ship& ship, const RunSpec& run) {
  const SimulatedShip start = start_of(ship_of(ship, run), run, {});
  maneuver_of(start, run, {});
}

io::Json summary_of(const std::vector<io::Json>& notes) {
  std::size_t replays = 0, winds = 0, anew = 0;
  for (const io::Json& note : notes) {
    if (!note.contains("winds_drawn")) continue;
    const auto of_run = note["winds_drawn"].get<std::size_t>();
    ++replays;
    winds += of_run;
    anew += of_run > 1 ? 1 : 0;
  }
  if (replays == 0) return io::Json::object();
  return {{"winds_drawn", winds}, {"share_drawn_anew", static_cast<double>(anew) / static_cast<double>(replays)}};
}

}  // namespace leeway
