#include "cli/gap_options.hpp"

#include "gap/result/numbers.hpp"
#include "io/dataset_json.hpp"

namespace leeway::cli {

CLI::Option* add_gap_options(CLI::App& app, GapOptions& o) {
  app.add_option("recordings", o.recordings, "recordings: CSV files, or a dataset.json or dataset.json#SET")
      ->required();
  CLI::Option* const ship =
      app.add_option("--ship", o.ship, "the simulator: a ship's JSON file or a shipped name")->required();
  app.add_option("--columns", o.columns, "columns map of the recordings (JSON), or the name of a shipped one");
  app.add_flag("--no-correct", o.no_correct, "leave the sensor faults that are found in the recordings");
  app.add_option("--false-alarm", o.false_alarm, "rate of finding something where there is nothing")
      ->check(in_range(1e-4, 0.2))
      ->capture_default_str();
  app.add_option("--step-s", o.step_s,
                 "time grid of the filter [s], rounded to whole samples (default: 2 sqrt(L_pp/g))")
      ->check(in_range(1e-3, 1e3));
  return ship;
}

gap::GapLocateOptions locate_options(const GapOptions& o, const CommonOptions& common) {
  gap::GapLocateOptions options;
  options.correct = !o.no_correct;
  options.false_alarm = o.false_alarm;
  options.step_s = o.step_s;
  options.jobs = common.jobs;
  options.seed = common.seed;
  return options;
}

gap::Called called(const GapOptions& o, const std::string& output) {
  std::string recordings;
  for (const std::string& recording : o.recordings)
    recordings += (recordings.empty() ? "" : " ") + gap::shell_word(recording);
  if (!o.columns.empty()) recordings += " --columns " + gap::shell_word(o.columns);
  return {gap::shell_word(o.ship), recordings, output};
}

std::vector<std::string> recording_files(const std::vector<std::string>& given) {
  std::vector<std::string> files;
  for (const io::RecordingFile& file : io::expand_recordings(given)) files.push_back(file.path);
  return files;
}

}  // namespace leeway::cli
