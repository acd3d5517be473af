#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include "io/json.hpp"
#include "io/trajectory_csv.hpp"

/// What the executables share: options, validators, logging, exit codes. It is the only part of the library that
/// writes to the terminal.
namespace leeway::cli {

inline constexpr int kOk = 0;
inline constexpr int kComputationFailed = 1;
inline constexpr int kUsage = 2;
inline constexpr int kBadInput = 3;
inline constexpr int kBadFile = 4;
inline constexpr int kBug = 5;

struct CommonOptions {
  std::uint64_t seed = 1;
  std::size_t jobs = 0;  ///< set to the number of cores by add_common_options
  bool verbose = false, quiet = false;
};

/// Adds --seed, --jobs, -v/--verbose, --quiet and --version to a program or a subcommand.
void add_common_options(CLI::App& app, CommonOptions& options);

/// Parses the command line and sets up logging (stderr only). Returns the exit code if the program is to stop: 0 after
/// --help or --version, 2 after a wrong command line, with one line that says what is wrong.
std::optional<int> parse(CLI::App& app, int argc, char** argv, const CommonOptions& options);

/// For a catch (...) at the end of main: one line on stderr, and the exit code of the error.
int report_current_exception(const std::string& program);

/// Validators that refuse nan and inf and answer in a short sentence. at_least() takes whole numbers alone, and none
/// that 64 bits do not hold; as a transform() it keeps CLI11 from reading 010 as 8.
CLI::Validator positive();
CLI::Validator not_negative();
CLI::Validator at_least(std::uint64_t low);
CLI::Validator in_range(double low, double high);

/// SHA-256 of an input file; empty for a pipe, which cannot be read twice.
std::string input_sha256(const std::string& file);

/// What made a result: tool, version, command line, seed and the hashes of the inputs; no clock, no host name. Options
/// that do not change the result are left out of the command line, so that equal results are equal files: --jobs,
/// --quiet, --verbose, --output, and those in `also_leave_out`.
io::Json provenance(const CLI::App& app, const CommonOptions& options, const std::vector<std::string>& input_files,
                    const std::vector<std::string>& also_leave_out = {});

/// Reads recordings in parallel, with one notice for the columns that no tool knows. Two recordings of one name are
/// a UsageError, since results refer to recordings by name.
///   keep_unknown   as for io::read_trajectory
///   warn_of_jumps  whether a clock that jumps gives a warning with file and line
std::vector<Trajectory> read_recordings(const std::vector<std::string>& paths, const std::string& columns_map,
                                        std::size_t jobs, bool keep_unknown = false, bool warn_of_jumps = true);

/// One warning that names the recordings without K points in a row, and how many they are; nothing where there is none.
///   of  how many were read
void tell_skipped(const std::vector<std::string>& too_short, std::size_t of, std::size_t K, double time_step_s);

/// Logs results' notices as warnings.
void warn_all(const std::vector<std::string>& notices);

}  // namespace leeway::cli
