#include "cli/options.hpp"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <set>
#include <thread>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include "core/errors.hpp"
#include "core/parallel.hpp"
#include "io/csv.hpp"
#include "io/files.hpp"

namespace leeway::cli {

namespace {

// A message may quote a file that is not text at all: no control characters reach the terminal, and not a megabyte.
std::string one_line(std::string text) {
  constexpr std::size_t kLongest = 2000;
  if (text.size() > kLongest) text = text.substr(0, kLongest) + "...";
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  return text;
}

}  // namespace

void add_common_options(CLI::App& app, CommonOptions& options) {
  options.jobs = std::max(1U, std::thread::hardware_concurrency());
  app.add_option("--seed", options.seed, "seed of every random number")->check(at_least(0))->capture_default_str();
  app.add_option("--jobs", options.jobs, "threads; they change the time, never the result")
      ->check(at_least(1))
      ->default_str("the cores");
  app.add_flag("-v,--verbose", options.verbose, "say more on the standard error");
  app.add_flag("--quiet", options.quiet, "say nothing but errors");
  app.set_version_flag("--version", "leeway " LEEWAY_VERSION);
}

std::optional<int> parse(CLI::App& app, int argc, char** argv, const CommonOptions& options) {
  std::signal(SIGPIPE, SIG_IGN);  // a broken pipe is an error of write(), reported as BrokenPipe
  std::signal(SIGXFSZ, SIG_IGN);  // and so is a file that grows beyond what the user may write
  const std::string program = app.get_name();
#ifdef __AVX2__
  if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma")) {
    fmt::print(stderr, "{}: error: built for processors with AVX2 and FMA; build with -DLEEWAY_MARCH= on this one\n",
               program);
    return kComputationFailed;
  }
#endif
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& done) {
    const int code = app.exit(done, std::cout, std::cerr);
    if (std::cout.flush() || errno == EPIPE) return code;
    fmt::print(stderr, "{}: error: standard output: cannot be written: {}\n", program, std::strerror(errno));
    return kBadFile;
  } catch (const CLI::ParseError& error) {
    fmt::print(stderr, "{}: error: {}. Try '{} --help'.\n", program, one_line(error.what()), program);
    return kUsage;
  }
  auto logger = spdlog::stderr_color_st("leeway");
  logger->set_pattern(program + ": %^%l%$: %v");
  logger->set_level(options.quiet ? spdlog::level::err : options.verbose ? spdlog::level::debug : spdlog::level::info);
  spdlog::set_default_logger(logger);
  return std::nullopt;
}

int report_current_exception(const std::string& program) {
  const auto say = [&](const std::string& what, int code) {
    fmt::print(stderr, "{}: error: {}\n", program, one_line(what));
    return code;
  };
  try {
    throw;
  } catch (const BrokenPipe&) {
    return kOk;
  } catch (const NumericalError& error) {
    return say(error.what(), kComputationFailed);
  } catch (const UsageError& error) {
    return say(error.what(), kUsage);
  } catch (const InputError& error) {
    return say(error.what(), kBadInput);
  } catch (const IoError& error) {
    return say(error.what(), kBadFile);
  } catch (const std::bad_alloc&) {
    return say("out of memory", kComputationFailed);
  } catch (const std::exception& error) {
    return say(fmt::format("this is a bug in leeway {}: {}", LEEWAY_VERSION, error.what()), kBug);
  }
}

namespace {

CLI::Validator numeric(const std::string& description, bool (*good)(double, double, double), double low, double high) {
  CLI::Validator validator(
      [=](std::string& text) {
        double value = 0.0;
        if (io::parse_number(text, value) && good(value, low, high)) return std::string();
        return fmt::format("expected {}, got '{}'", description, text);
      },
      "");
  return validator;
}

}  // namespace

CLI::Validator positive() {
  return numeric(
      "a number > 0", [](double x, double, double) { return x > 0.0; }, 0.0, 0.0);
}
CLI::Validator not_negative() {
  return numeric(
      "a number >= 0", [](double x, double, double) { return x >= 0.0; }, 0.0, 0.0);
}
CLI::Validator at_least(double low) {
  return numeric(
      fmt::format("a number >= {}", low), [](double x, double a, double) { return x >= a; }, low, 0.0);
}
CLI::Validator in_range(double low, double high) {
  return numeric(
      fmt::format("a number from {} to {}", low, high), [](double x, double a, double b) { return x >= a && x <= b; },
      low, high);
}

std::string input_sha256(const std::string& file) {
  std::error_code error;
  const bool readable_again = file != "-" && std::filesystem::is_regular_file(file, error);
  return readable_again ? io::sha256_of_file(file) : "";
}

io::Json provenance(const CLI::App& app, const CommonOptions& options, const std::vector<std::string>& input_files,
                    const std::vector<std::string>& also_leave_out) {
  std::set<std::string> left_out{"--jobs", "--quiet", "--verbose", "--output"};
  left_out.insert(also_leave_out.begin(), also_leave_out.end());
  std::vector<std::string> command{app.get_name()};
  const auto append = [&](const CLI::App& level) {
    for (const CLI::Option* option : level.get_options()) {
      const std::string name = option->get_name();
      if (option->count() == 0 || left_out.contains(name)) continue;
      if (!option->get_positional()) command.push_back(name);
      if (option->get_expected_max() > 0)
        for (const std::string& value : option->results()) command.push_back(value);
    }
  };
  append(app);
  for (const CLI::App* sub : app.get_subcommands()) {
    command.push_back(sub->get_name());
    append(*sub);
  }
  // A shipped configuration is called the same wherever leeway is installed.
  const auto shown = [](const std::string& file) {
    const std::size_t shipped = file.rfind("share/leeway/configs/");
    return shipped == std::string::npos ? file : file.substr(shipped + std::string("share/leeway/").size());
  };
  io::Json inputs = io::Json::array();
  for (const std::string& file : input_files) inputs.push_back({{"file", shown(file)}, {"sha256", input_sha256(file)}});
  return {{"tool", app.get_name()},
          {"version", LEEWAY_VERSION},
          {"command", command},
          {"seed", options.seed},
          {"inputs", inputs}};
}

std::vector<Trajectory> read_recordings(const std::vector<std::string>& paths, const std::string& columns_map,
                                        std::size_t jobs, bool keep_unknown) {
  std::optional<io::ColumnsMap> map;
  if (!columns_map.empty()) map = io::read_columns_map(columns_map);
  std::map<std::string, std::string> path_of_name;
  for (const std::string& path : paths)
    if (const auto [other, is_new] = path_of_name.emplace(io::stem(path), path); !is_new)
      throw UsageError(
          fmt::format("{}: has the same name as {}; recordings are told apart by their names", path, other->second));
  std::vector<Trajectory> recordings(paths.size());
  parallel_for(paths.size(), jobs, [&](std::size_t i) {
    recordings[i] = io::read_trajectory(paths[i], map ? &*map : nullptr, keep_unknown);
  });
  std::set<std::string> ignored;
  for (const Trajectory& recording : recordings)
    ignored.insert(recording.ignored_columns.begin(), recording.ignored_columns.end());
  if (!ignored.empty()) spdlog::warn("columns that no tool knows are ignored: {}", fmt::join(ignored, ", "));
  return recordings;
}

void warn_all(const std::vector<std::string>& notices) {
  for (const std::string& notice : notices) spdlog::warn("{}", notice);
}

}  // namespace leeway::cli
