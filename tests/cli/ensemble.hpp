#pragma once

#include <algorithm>
#include <filesystem>
#include <map>
#include <string>

#include <catch2/catch.hpp>
#include <fmt/format.h>

#include "run.hpp"

/// A ship's recordings and a training of seconds, for the tests that run ens-train and what follows it.
namespace leeway::test {

inline const std::string kSpec = R"({"ship": "vectwin-3m", "noise": "paper-model-scale", "sets": [
  {"name": "train", "runs": [{"maneuver": "random", "count": 2, "duration_s": 50, "wind": {"speed_mps": [0.5, 1]}}]},
  {"name": "test", "runs": [{"maneuver": "random", "duration_s": 45, "wind": {"speed_mps": 0.7, "dir_deg": 40}},
                            {"maneuver": "turning", "rudder_deg": 20, "duration_s": 45}]}]})";

inline std::string config(int epochs, const std::string& more = "") {
  return fmt::format(
      R"({{"hidden_units": 8, "hidden_layers": 2, "steps": 20, "initial_state_steps": 5, "batch_size": 2,
          "epochs": {}, "members": 4, "learning_rate": 1e-3{}}})",
      epochs, more);
}

inline const std::string kTrain = "ens-train data/dataset.json#train --quiet --config ";

inline Outcome done(const TemporaryFolder& folder, const std::string& command) {
  const Outcome outcome = run(folder, command);
  CAPTURE(command, outcome.err);
  REQUIRE(outcome.exit_code == 0);
  return outcome;
}

/// Recordings of a ship in data/, and tiny.json to train on them.
inline void write_ensemble_inputs(const TemporaryFolder& folder) {
  folder.write("spec.json", kSpec);
  folder.write("tiny.json", config(6));
  done(folder, "mmg-sim dataset spec.json -o data --quiet");
}

inline void prepare_model(const TemporaryFolder& folder) {
  write_ensemble_inputs(folder);
  done(folder, kTrain + "tiny.json -o model");
}

/// One line that names the program, and nothing on the standard output.
inline void check_refused(const TemporaryFolder& folder, const std::string& command, int exit_code,
                          const std::string& message) {
  const Outcome outcome = run(folder, command + " --quiet");
  CAPTURE(command, outcome.err);
  CHECK(outcome.exit_code == exit_code);
  CHECK(outcome.out.empty());
  CHECK_THAT(outcome.err, Catch::Matchers::StartsWith(command.substr(0, command.find(' ')) + ": error: "));
  CHECK_THAT(outcome.err, Catch::Matchers::Contains(message));
  CHECK(std::count(outcome.err.begin(), outcome.err.end(), '\n') == 1);
}

/// A text with its first `what`, which it must hold, replaced.
inline std::string replaced(std::string text, const std::string& what, const std::string& with) {
  const std::size_t at = text.find(what);
  REQUIRE(at != std::string::npos);
  return text.replace(at, what.size(), with);
}

/// The same in a file.
inline void replace(const std::string& file, const std::string& what, const std::string& with) {
  io::write_text(file, replaced(io::read_text(file), what, with));
}

inline std::map<std::string, std::string> files_of(const std::string& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    files[entry.path().filename().string()] = io::read_text(entry.path().string());
  return files;
}

}  // namespace leeway::test
