#include "dynamics/dataset.hpp"

#include <algorithm>
#include <atomic>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/parallel.hpp"
#include "dynamics/dataset_runs.hpp"
#include "io/files.hpp"
#include "io/outputs.hpp"
#include "io/result_folder.hpp"
#include "io/trajectory_csv.hpp"

namespace leeway {
namespace {

// <set>/<below><run>.csv
std::string file_of(const DatasetSpec& spec, const PlacedRun& place, const char* below) {
  return fmt::format("{}/{}{}.csv", spec.sets[place.set].name, below, place.run.name);
}

std::string notes_file(const DatasetSpec::Set& set) { return fmt::format("{}/truth/runs.json", set.name); }

bool has_notes(const DatasetSpec::Set& set) {
  return std::any_of(set.runs.begin(), set.runs.end(), [](const RunSpec& run) { return has_notes(run); });
}

// What dataset.json says of the sets.
io::Json listed_sets(const DatasetSpec& spec, const std::vector<PlacedRun>& places) {
  io::Json sets = io::Json::array();
  for (const DatasetSpec::Set& set : spec.sets)
    sets.push_back({{"name", set.name}, {"noise", to_json(spec.noise)}, {"recordings", io::Json::array()}});
  for (const PlacedRun& place : places)
    sets[place.set]["recordings"].push_back(
        {{"file", file_of(spec, place, "")}, {"truth", file_of(spec, place, "truth/")}});
  return sets;
}

}  // namespace

void generate_dataset(const DatasetSpec& spec, const std::string& folder, std::uint64_t seed, std::size_t jobs,
                      const io::Json& provenance, const std::function<void(double)>& progress) {
  const std::vector<PlacedRun> places = placed_runs(spec, seed);
  std::vector<std::string> files;
  for (const PlacedRun& place : places)
    for (const char* below : {"", "truth/"}) files.push_back(file_of(spec, place, below));
  for (const DatasetSpec::Set& set : spec.sets)
    if (has_notes(set)) files.push_back(notes_file(set));
  io::ResultFolder results(folder, "dataset.json", files);
  io::require_apart(spec.input_files, results.outputs());
  results.begin();
  for (const DatasetSpec::Set& set : spec.sets) io::make_directories(results.path(set.name + "/truth"));
  std::vector<io::Json> notes(places.size());
  std::atomic<std::size_t> done{0};
  parallel_for(places.size(), jobs, [&](std::size_t i) {
    SimulatedRun run = simulate_run(spec, places[i].run, seed, i);
    notes[i] = std::move(run.notes);
    complete_truth(run.truth, spec.recorded, spec.ship);
    Trajectory recording = observed(run.truth, spec.noise, {seed, "observation noise", i});
    leave_recorded(recording, spec.recorded);
    results.write(file_of(spec, places[i], "truth/"), io::trajectory_text(run.truth));
    results.write(file_of(spec, places[i], ""), io::trajectory_text(recording));
    if (progress) progress(static_cast<double>(++done) / static_cast<double>(places.size()));
  });
  for (std::size_t s = 0; s < spec.sets.size(); ++s) {
    if (!has_notes(spec.sets[s])) continue;
    std::vector<io::Json> of_set;
    for (std::size_t i = 0; i < places.size(); ++i) {
      if (places[i].set != s || notes[i].is_null()) continue;
      io::Json entry{{"recording", places[i].run.name}};
      entry.update(notes[i]);
      of_set.push_back(std::move(entry));
    }
    io::Json json = summary_of(of_set);
    json["runs"] = of_set;
    results.write(notes_file(spec.sets[s]), io::to_text(json));
  }
  results.commit({{"sets", listed_sets(spec, places)}, {"provenance", provenance}});
}

}  // namespace leeway
