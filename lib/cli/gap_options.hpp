#pragma once

#include <string>
#include <vector>

#include "cli/options.hpp"
#include "gap/gap_locate.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::cli {

/// What gap-locate and gap-explain ask alike.
struct GapOptions {
  std::string ship, columns;
  std::vector<std::string> recordings;
  bool no_correct = false;
  double false_alarm = gap::kPolicy.detect.false_alarm, step_s = 0.0;
};

/// Returns the option --ship, which is required.
CLI::Option* add_gap_options(CLI::App& app, GapOptions& options);

/// As the library takes them, without `progress`.
gap::GapLocateOptions locate_options(const GapOptions& options, const CommonOptions& common);

/// How the tool was called, for commands that its summary proposes.
gap::Called called(const GapOptions& options, const std::string& output);

/// The CSV files that are meant: themselves, or those that a dataset.json lists.
std::vector<std::string> recording_files(const std::vector<std::string>& given);

}  // namespace leeway::cli
