#include "dynamics/dataset.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <stdexcept>

#include <fmt/format.h>

#include "core/errors.hpp"
#include "core/parallel.hpp"
#include "core/units.hpp"
#include "dynamics/berthing.hpp"
#include "dynamics/phased_maneuvers.hpp"
#include "io/files.hpp"
#include "io/trajectory_csv.hpp"

namespace leeway {
namespace {

using io::JsonObject;

// "Test-ZT" -> "test-zt"; the name of a set is a folder and the beginning of file names.
std::string prefix_of(const JsonObject& set, const std::string& name) {
  std::string prefix;
  for (const char c : name) {
    const bool is_upper = c >= 'A' && c <= 'Z';
    if (!is_upper && !(c >= 'a' && c <= 'z') && !(c >= '0' && c <= '9') && c != '-' && c != '_')
      set.fail("name", fmt::format("expected letters, digits, '-' and '_', got '{}'", name));
    prefix += is_upper ? static_cast<char>(c - 'A' + 'a') : c;
  }
  if (name.empty() || name == "truth") set.fail("name", fmt::format("'{}' cannot be a set's name", name));
  return prefix;
}

DrawnRange read_range(const JsonObject& json, const std::string& key, io::Bounds bounds) {
  if (!json.has(key)) return {};
  if (json.value(key).is_number()) {
    const double value = json.number(key, bounds);
    return {value, value};
  }
  const std::vector<double> ends = json.numbers(key, 2);
  if (!(ends[0] <= ends[1]) || ends[0] < bounds.low) json.fail(key, "expected a number, or two numbers [low, high]");
  return {ends[0], ends[1]};
}

std::vector<double> one_or_more(const JsonObject& json, const std::string& key) {
  if (json.value(key).is_number()) return {json.number(key)};
  std::vector<double> values = json.numbers(key);
  if (values.empty()) json.fail(key, "expected at least one number");
  return values;
}

struct KindInfo {
  ManeuverKind kind;
  std::string_view word, in_names;
  bool has_rudder;  // one run for each of the given angles
};
constexpr std::array<KindInfo, 10> kKinds{{
    {ManeuverKind::random, "random", "r", false},
    {ManeuverKind::berthing, "berthing", "b", false},
    {ManeuverKind::zigzag, "zigzag", "z", true},
    {ManeuverKind::turning, "turning", "t", true},
    {ManeuverKind::pull_out, "pull-out", "pull-out-", true},
    {ManeuverKind::spiral, "spiral", "spiral-", true},
    {ManeuverKind::crash_stop, "crash-stop", "crash-stop", false},
    {ManeuverKind::coast_down, "coast-down", "coast-down", false},
    {ManeuverKind::thruster_pulses, "thruster-pulses", "thruster-pulses", false},
    {ManeuverKind::straight, "straight", "straight", false},
}};

// What sets one run apart from another of the same specification.
struct RunSeed {
  std::uint64_t seed = 0, place = 0;
  RandomStream stream(std::string_view purpose) const { return {seed, purpose, place}; }
};

BerthingPlan berthing_plan(const Ship& ship, const RunSeed& seed) {
  return draw_berthing(ship, seed.stream("berthing plan"));
}

SimulatedShip start_of(const Ship& ship, const RunSpec& run, const RunSeed& seed) {
  if (run.kind == ManeuverKind::straight) return steady_ahead(ship, run.u0_mps);
  if (run.kind == ManeuverKind::berthing) return berthing_start(ship, berthing_plan(ship, seed));
  return SimulatedShip(ship, run.u0_mps);
}

// The ship at the start outlives the maneuver.
std::unique_ptr<Maneuver> maneuver_of(const SimulatedShip& start, const RunSpec& run, const RunSeed& seed) {
  switch (run.kind) {
    case ManeuverKind::random:
      return random_orders(start.ship, seed.stream("random orders"));
    case ManeuverKind::berthing:
      return berthing(start.ship, berthing_plan(start.ship, seed), seed.stream("berthing pilot"));
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
  }
  throw std::logic_error("a maneuver without a case");
}

// The runs of one entry: every parameter `count` times.
void read_runs(const JsonObject& json, const std::string& prefix, const Ship& ship, const TimeGrid& grid,
               DatasetSpec::Set& set) {
  RunSpec run;
  std::vector<std::string> words;
  words.reserve(kKinds.size());
  for (const KindInfo& info : kKinds) words.emplace_back(info.word);
  const std::string word = json.word("maneuver", words);
  const KindInfo& kind = *std::find_if(kKinds.begin(), kKinds.end(), [&](const KindInfo& k) { return k.word == word; });
  run.kind = kind.kind;
  const bool is_shared = json.has("total_duration_s");
  if (is_shared && json.has("duration_s")) json.fail("total_duration_s", "expected this or duration_s, not both");
  const std::string duration_key = is_shared ? "total_duration_s" : "duration_s";
  run.duration_s = json.number(duration_key, io::kPositive);
  try {
    TimeGrid{grid.dt_s, grid.sample_s, run.duration_s}.check();
  } catch (const UsageError& error) {
    json.fail(duration_key, error.what());
  }
  if (run.kind == ManeuverKind::berthing && json.has("u0_mps")) json.fail("u0_mps", "a berthing draws its own speed");
  run.u0_mps = json.number_or("u0_mps", ship.u0_mps);
  if (const auto wind = json.object_if("wind")) {
    run.wind_speed_mps = read_range(*wind, "speed_mps", io::kNotNegative);
    const DrawnRange deg = read_range(*wind, "dir_deg", {});
    run.wind_dir = {deg_to_rad(deg.low), deg_to_rad(deg.high)};
    run.has_stochastic_wind = wind->has("kind") && wind->word("kind", {"steady", "stochastic"}) == "stochastic";
    if (run.has_stochastic_wind) {
      const double longest_s = longest_wind_step_s(run.wind_speed_mps.high);
      if (grid.dt_s > longest_s)
        wind->fail("kind", fmt::format("stochastic wind of {} m/s needs a dt_s of at most {:.3g} s, not {} s",
                                       run.wind_speed_mps.high, longest_s, grid.dt_s));
    }
    wind->check_all_known();
  }
  const auto count = static_cast<std::size_t>(json.integer_or("count", 1, {1.0, 100000.0}));
  std::vector<double> rudders{0.0}, headings;
  if (kind.has_rudder) {
    rudders = one_or_more(json, "rudder_deg");
    if (std::count(rudders.begin(), rudders.end(), 0.0) > 0) json.fail("rudder_deg", "expected numbers other than 0");
  }
  if (run.kind == ManeuverKind::zigzag) {
    if (json.has("heading_deg"))
      headings = one_or_more(json, "heading_deg");
    else
      for (const double rudder : rudders) headings.push_back(std::abs(rudder));
    if (headings.size() != rudders.size())
      json.fail("heading_deg", fmt::format("expected as many numbers as rudder_deg has ({})", rudders.size()));
    if (std::any_of(headings.begin(), headings.end(), [](double h) { return !(h > 0.0); }))
      json.fail("heading_deg", "expected numbers > 0");
  }
  json.check_all_known();
  try {  // what cannot be done is said before anything is simulated
    const SimulatedShip start = start_of(ship, run, {});
    for (const double rudder : rudders) {
      run.rudder = deg_to_rad(rudder);
      maneuver_of(start, run, {});
    }
  } catch (const UsageError& error) {
    json.fail("maneuver", error.what());
  } catch (const NumericalError& error) {
    json.fail("u0_mps", error.what());
  }

  if (is_shared) {
    const std::size_t runs = count * rudders.size();
    const double shortest_s = 2.0 * static_cast<double>(runs) * grid.sample_s;
    if (run.duration_s < shortest_s - 1e-9)
      json.fail("total_duration_s",
                fmt::format("expected at least two samples for each run, {} s for {} of them, got {}", shortest_s, runs,
                            run.duration_s));
    set.shared_durations.push_back({set.runs.size(), runs, run.duration_s});
    run.duration_s /= static_cast<double>(runs);
  }
  for (std::size_t i = 0; i < rudders.size(); ++i)
    for (std::size_t k = 1; k <= count; ++k) {
      run.rudder = deg_to_rad(rudders[i]);
      const std::string angle = fmt::format("{}{}", rudders[i] < 0.0 ? "port" : "", std::abs(rudders[i]));
      run.name = fmt::format("{}-{}", prefix, kind.in_names);
      if (kind.has_rudder) run.name += angle;
      if (run.kind == ManeuverKind::zigzag) {
        run.heading = deg_to_rad(headings[i]);
        if (headings[i] != std::abs(rudders[i])) run.name += fmt::format("-{}", headings[i]);
      }
      if (!kind.has_rudder || count > 1) run.name += fmt::format("-{:02}", k);
      set.runs.push_back(run);
    }
}

double draw(const DrawnRange& range, RandomStream& stream) {
  return range.low == range.high ? range.low : stream.uniform(range.low, range.high);
}

// The noise-free run with the given place in the dataset.
Trajectory simulate_run(const DatasetSpec& spec, const RunSpec& run, const RunSeed& seed) {
  const SimulatedShip ship = start_of(spec.ship, run, seed);
  RandomStream wind = seed.stream("wind of a run");
  const double speed = draw(run.wind_speed_mps, wind);
  const double direction = draw(run.wind_dir, wind);
  const auto maneuver = maneuver_of(ship, run, seed);
  try {
    return simulate(ship, *maneuver,
                    run.has_stochastic_wind ? WindProcess::stochastic(speed, direction, seed.stream("stochastic wind"))
                                            : WindProcess::steady(speed, direction),
                    {spec.grid.dt_s, spec.grid.sample_s, run.duration_s});
  } catch (const NumericalError& error) {
    throw NumericalError(fmt::format("{}: {}", run.name, error.what()));
  }
}

}  // namespace

DatasetSpec read_dataset_spec(const std::string& name_or_path) {
  const std::string path = io::find_config("datasets", name_or_path);
  const io::Json text = io::read_json(path);
  const JsonObject json(text, path);
  json.text_or("description", "");
  DatasetSpec spec;
  spec.ship = read_ship(json.text("ship"));
  spec.input_files = {path, spec.ship.file};
  spec.grid.dt_s = json.number_or("dt_s", spec.grid.dt_s, io::kPositive);
  spec.grid.sample_s = json.number_or("sample_s", spec.grid.sample_s, io::kPositive);
  if (json.has("noise")) {
    if (json.value("noise").is_object()) {
      spec.noise = parse_noise(json.object("noise"));
    } else {
      const std::string file = io::find_config("noise", json.text("noise"));
      spec.noise = read_noise(file);
      spec.input_files.push_back(file);
    }
  }
  std::set<std::string> names, set_names;
  const std::vector<JsonObject> sets = json.objects("sets");
  if (sets.empty()) json.fail("sets", "expected at least one set");
  for (const JsonObject& set : sets) {
    DatasetSpec::Set& result = spec.sets.emplace_back();
    result.name = set.text("name");
    const std::string prefix = prefix_of(set, result.name);
    if (!set_names.insert(result.name).second) set.fail("name", fmt::format("'{}' stands twice", result.name));
    const std::vector<JsonObject> entries = set.objects("runs");
    if (entries.empty()) set.fail("runs", "expected at least one entry");
    for (const JsonObject& runs : entries) read_runs(runs, prefix, spec.ship, spec.grid, result);
    for (const RunSpec& run : result.runs)
      if (!names.insert(run.name).second)
        set.fail("runs", fmt::format("two recordings would be called '{}'", run.name));
    set.check_all_known();
  }
  json.check_all_known();
  return spec;
}

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

void generate_dataset(const DatasetSpec& spec, const std::string& folder, std::uint64_t seed, std::size_t jobs,
                      const io::Json& provenance) {
  struct Place {
    const DatasetSpec::Set* set;
    RunSpec run;
  };
  std::vector<Place> places;
  io::Json sets = io::Json::array();
  for (const DatasetSpec::Set& set : spec.sets) {
    io::make_directories(fmt::format("{}/{}/truth", folder, set.name));
    io::Json recordings = io::Json::array();
    const std::size_t first_place = places.size();
    for (const RunSpec& run : set.runs) {
      places.push_back({&set, run});
      recordings.push_back({{"file", fmt::format("{}/{}.csv", set.name, run.name)},
                            {"truth", fmt::format("{}/truth/{}.csv", set.name, run.name)}});
    }
    for (const SharedDuration& shared : set.shared_durations) {
      const std::size_t first = first_place + shared.first;
      const std::vector<std::size_t> samples =
          share_samples(static_cast<std::size_t>(std::llround(shared.total_s / spec.grid.sample_s)), shared.count,
                        {seed, "durations", first});
      for (std::size_t i = 0; i < shared.count; ++i)
        places[first + i].run.duration_s = grid_time(samples[i], spec.grid.sample_s);
    }
    sets.push_back({{"name", set.name}, {"noise", to_json(spec.noise)}, {"recordings", recordings}});
  }
  parallel_for(places.size(), jobs, [&](std::size_t i) {
    const auto& [set, run] = places[i];
    const Trajectory truth = simulate_run(spec, run, {seed, i});
    const Trajectory recording = observed(truth, spec.noise, {seed, "observation noise", i});
    io::write_trajectory(fmt::format("{}/{}/truth/{}.csv", folder, set->name, run.name), truth);
    io::write_trajectory(fmt::format("{}/{}/{}.csv", folder, set->name, run.name), recording);
  });
  io::write_text(folder + "/dataset.json", io::to_text({{"sets", sets}, {"provenance", provenance}}));
}

}  // namespace leeway
