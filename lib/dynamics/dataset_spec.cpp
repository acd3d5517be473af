#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/errors.hpp"
#include "core/units.hpp"
#include "dynamics/dataset_runs.hpp"
#include "io/files.hpp"
#include "recording/froude_law.hpp"

namespace leeway {
namespace {

using io::JsonObject;

DatasetSpec read_spec(const std::string& name_or_path, bool may_replay);

// The file of a shipped config, or of a path, that stands under `key`.
std::string config_of(const JsonObject& json, const std::string& folder, const std::string& key) {
  try {
    return io::find_config(folder, json.text(key));
  } catch (const UsageError& error) {
    json.fail(key, error.what());
  }
}

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

void read_wind(const JsonObject& json, const TimeGrid& grid, RunSpec& run) {
  const auto wind = json.object_if("wind");
  if (!wind) return;
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

// Rudder angles, and of a zigzag the headings, one run each. [deg]
struct Angles {
  std::vector<double> rudders{0.0}, headings;
};

Angles read_angles(const JsonObject& json, const ManeuverKindInfo& kind) {
  Angles angles;
  if (!kind.has_rudder) return angles;
  std::vector<double>&rudders = angles.rudders, &headings = angles.headings;
  rudders = one_or_more(json, "rudder_deg");
  if (std::count(rudders.begin(), rudders.end(), 0.0) > 0) json.fail("rudder_deg", "expected numbers other than 0");
  if (kind.kind != ManeuverKind::zigzag) return angles;
  if (json.has("heading_deg"))
    headings = one_or_more(json, "heading_deg");
  else
    for (const double rudder : rudders) headings.push_back(std::abs(rudder));
  if (headings.size() != rudders.size())
    json.fail("heading_deg", fmt::format("expected as many numbers as rudder_deg has ({})", rudders.size()));
  if (std::any_of(headings.begin(), headings.end(), [](double h) { return !(h > 0.0); }))
    json.fail("heading_deg", "expected numbers > 0");
  return angles;
}

// The total that the runs of an entry share.
SharedDuration read_shared_duration(const JsonObject& json, const TimeGrid& grid, std::size_t first, std::size_t runs) {
  SharedDuration shared{first, runs, json.number("total_duration_s")};
  shared.replayed_at_scale = json.number_or("replayed_at_scale", 1.0, {1.0});
  const double time = FroudeLaw(shared.replayed_at_scale).time;
  const double shortest_s = 2.0 * static_cast<double>(runs) * grid.sample_s * time;
  if (shared.total_s < shortest_s - 1e-9)
    json.fail("total_duration_s", fmt::format("expected at least two samples for each run, {} s for {} of them, got {}",
                                              shortest_s, runs, shared.total_s));
  const double nearest = std::round(std::round(shared.total_s / grid.sample_s / time) * time);
  if (std::abs(nearest - shared.total_s / grid.sample_s) > 0.5)
    json.fail("total_duration_s",
              fmt::format("expected whole samples of its replay at 1/{} of the length, so {} s, got {}",
                          shared.replayed_at_scale, nearest * grid.sample_s, shared.total_s));
  return shared;
}

// "unrecorded": physics that acts in some of the runs, counted from `first` on, and that no column holds.
void read_unrecorded(const JsonObject& json, const Ship& ship, std::size_t first, DatasetSpec::Set& set) {
  if (!json.has("unrecorded")) return;
  const auto count = static_cast<double>(set.runs.size() - first);
  for (const JsonObject& entry : json.objects("unrecorded")) {
    RunSpec& run = set.runs[first + static_cast<std::size_t>(entry.integer("run", {1.0, count})) - 1];
    for (const JsonObject& effect : entry.objects("effects")) run.unrecorded.push_back(parse_effect(effect));
    entry.text_or("description", "");
    entry.check_all_known();
    try {
      require_possible(ship, run);
    } catch (const UsageError& error) {
      entry.fail("effects", error.what());
    }
  }
}

// The runs of another data set's set, each replayed by this one's ship.
void read_replays(const JsonObject& json, const std::string& prefix, RunSpec run, DatasetSpec& spec,
                  DatasetSpec::Set& set) {
  const auto source = std::make_shared<const DatasetSpec>(read_spec(config_of(json, "datasets", "of"), false));
  const std::string wanted = json.text("set");
  json.check_all_known();
  const auto& sets = source->sets;
  const auto found = std::find_if(sets.begin(), sets.end(), [&](const auto& s) { return s.name == wanted; });
  if (found == sets.end()) json.fail("set", fmt::format("'{}' has no set '{}'", json.text("of"), wanted));
  spec.input_files.insert(spec.input_files.end(), source->input_files.begin(), source->input_files.end());
  run.replayed = source;
  for (auto before = sets.begin(); before != found; ++before) run.replayed_place += before->runs.size();
  for (std::size_t k = 1; k <= found->runs.size(); ++k, ++run.replayed_place) {
    run.name = fmt::format("{}-b-{:02}", prefix, k);
    set.runs.push_back(run);
  }
}

const ManeuverKindInfo& read_kind(const JsonObject& json) {
  std::vector<std::string> words;
  words.reserve(kManeuverKinds.size());
  for (const ManeuverKindInfo& info : kManeuverKinds) words.emplace_back(info.word);
  const std::string word = json.word("maneuver", words);
  return *std::find_if(kManeuverKinds.begin(), kManeuverKinds.end(), [&](const auto& k) { return k.word == word; });
}

// One run for each angle, `count` times.
void add_runs(RunSpec run, const ManeuverKindInfo& kind, const Angles& angles, std::size_t count,
              const std::string& prefix, DatasetSpec::Set& set) {
  for (std::size_t i = 0; i < angles.rudders.size(); ++i)
    for (std::size_t k = 1; k <= count; ++k) {
      const double rudder_deg = angles.rudders[i];
      run.rudder = deg_to_rad(rudder_deg);
      run.name = fmt::format("{}-{}", prefix, kind.in_names);
      if (kind.has_rudder) run.name += fmt::format("{}{}", rudder_deg < 0.0 ? "port" : "", std::abs(rudder_deg));
      if (run.kind == ManeuverKind::zigzag) {
        run.heading = deg_to_rad(angles.headings[i]);
        if (angles.headings[i] != std::abs(rudder_deg)) run.name += fmt::format("-{}", angles.headings[i]);
      }
      if (!kind.has_rudder || count > 1) run.name += fmt::format("-{:02}", k);
      set.runs.push_back(run);
    }
}

// What cannot be done is said before anything is simulated.
void require_all_possible(const JsonObject& json, const Ship& ship, RunSpec run, const Angles& angles) {
  try {
    for (const double rudder : angles.rudders) {
      run.rudder = deg_to_rad(rudder);
      require_possible(ship, run);
    }
  } catch (const UsageError& error) {
    json.fail("maneuver", error.what());
  } catch (const NumericalError& error) {
    json.fail("u0_mps", error.what());
  }
}

// The runs of one entry: every parameter `count` times.
void read_runs(const JsonObject& json, const std::string& prefix, bool may_replay, DatasetSpec& spec,
               DatasetSpec::Set& set) {
  const TimeGrid& grid = spec.grid;
  const ManeuverKindInfo& kind = read_kind(json);
  RunSpec run;
  run.kind = kind.kind;
  read_wind(json, grid, run);
  if (run.kind == ManeuverKind::replay) {
    if (!may_replay) json.fail("maneuver", "a replay cannot be replayed");
    return read_replays(json, prefix, run, spec, set);
  }
  const bool is_shared = json.has("total_duration_s");
  if (is_shared && json.has("duration_s")) json.fail("total_duration_s", "expected this or duration_s, not both");
  const std::string duration_key = is_shared ? "total_duration_s" : "duration_s";
  run.duration_s = json.number(duration_key, io::kPositive);
  try {
    TimeGrid{grid.dt_s, grid.sample_s, run.duration_s}.check();
  } catch (const UsageError& error) {
    json.fail(duration_key, error.what());
  }
  const bool draws_speed = run.kind == ManeuverKind::berthing || run.kind == ManeuverKind::port_navigation;
  if (draws_speed && json.has("u0_mps")) json.fail("u0_mps", fmt::format("a {} draws its own speed", kind.word));
  run.u0_mps = json.number_or("u0_mps", spec.ship.u0_mps);
  const auto count = static_cast<std::size_t>(json.integer_or("count", 1, {1.0, 100000.0}));
  const Angles angles = read_angles(json, kind);
  const std::size_t first = set.runs.size(), runs = count * angles.rudders.size();
  if (is_shared) {
    set.shared_durations.push_back(read_shared_duration(json, grid, first, runs));
    run.duration_s /= static_cast<double>(runs);
  }
  require_all_possible(json, spec.ship, run, angles);
  add_runs(run, kind, angles, count, prefix, set);
  read_unrecorded(json, spec.ship, first, set);
  json.check_all_known();
}

void read_dataset_noise(const JsonObject& json, DatasetSpec& spec) {
  if (!json.has("noise")) return;
  if (json.value("noise").is_object()) {
    spec.noise = parse_noise(json.object("noise"));
    return;
  }
  const std::string file = config_of(json, "noise", "noise");
  spec.noise = read_noise(file);
  spec.input_files.push_back(file);
}

DatasetSpec read_spec(const std::string& name_or_path, bool may_replay) {
  const std::string path = io::find_config("datasets", name_or_path);
  const io::Json text = io::read_json(path);
  const JsonObject json(text, path);
  json.text_or("description", "");
  DatasetSpec spec;
  spec.ship = read_ship(config_of(json, "ships", "ship"));
  spec.input_files = {path, spec.ship.file};
  spec.grid.dt_s = json.number_or("dt_s", spec.grid.dt_s, io::kPositive);
  spec.grid.sample_s = json.number_or("sample_s", spec.grid.sample_s, io::kPositive);
  read_dataset_noise(json, spec);
  if (const auto recorded = json.object_if("recorded")) {
    spec.recorded = parse_recorded_columns(*recorded);
    Trajectory nothing;
    complete_truth(nothing, spec.recorded, spec.ship);  // what the ship does not have is said before anything is done
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
    for (const JsonObject& runs : entries) read_runs(runs, prefix, may_replay, spec, result);
    for (const RunSpec& run : result.runs)
      if (!names.insert(run.name).second)
        set.fail("runs", fmt::format("two recordings would be called '{}'", run.name));
    set.check_all_known();
  }
  json.check_all_known();
  return spec;
}

}  // namespace

DatasetSpec read_dataset_spec(const std::string& name_or_path) { return read_spec(name_or_path, true); }

}  // namespace leeway
