#include "cli/options.hpp"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <limits>
#include <set>
#include <thread>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include "cli/command_line.hpp"
#include "cli/completion.hpp"
#include "cli/messages.hpp"
#include "cli/resources.hpp"
#include "core/errors.hpp"
#include "core/parallel.hpp"
#include "io/csv.hpp"
#include "io/files.hpp"
#include "io/trajectory_csv.hpp"
#include "ship/plausibility.hpp"

namespace leeway::cli {

void add_common_options(CLI::App& app, CommonOptions& options) {
  options.jobs = std::max(1U, std::thread::hardware_concurrency());
  app.add_option("--seed", options.seed, "seed of every random number")->transform(at_least(0))->capture_default_str();
  app.add_option("--jobs", options.jobs, "threads; they change the time, never the result")
      ->transform(at_least(1))
      ->default_str("the cores");
  app.add_flag("-v,--verbose", options.verbose, "say more on the standard error");
  app.add_flag("--quiet", options.quiet, "say nothing but errors");
  app.set_version_flag("--version", "leeway " LEEWAY_VERSION);
}

std::optional<int> parse(CLI::App& app, int argc, char** argv, const CommonOptions& options) {
  keep_closed_streams_closed();
  std::signal(SIGPIPE, SIG_IGN);  // a broken pipe is an error of write(), reported as BrokenPipe
  std::signal(SIGXFSZ, SIG_IGN);  // and so is a file that grows beyond what the user may write
  const std::string program = app.get_name();
  end_in_order_without_memory(program);
  keep_freed_memory();
#ifdef __AVX2__
  if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma")) {
    say(fmt::format("{}: error: built for processors with AVX2 and FMA; build with -DLEEWAY_MARCH= on this one\n",
                    program));
    return kComputationFailed;
  }
#endif
  if (argc > 1 && argv[1] == std::string(kComplete)) {
    io::write_text("-", completion_text(app, {argv + 2, argv + argc}));
    return kOk;
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& done) {
    const int code = app.exit(done, std::cout, std::cout);
    if (std::cout.flush() || errno == EPIPE) return code;
    say(fmt::format("{}: error: standard output: cannot be written: {}\n", program, std::strerror(errno)));
    return kBadFile;
  } catch (const CLI::ParseError& error) {
    const std::string what = one_line(what_is_wrong(app, error));
    std::string called = program;
    for (const CLI::App* sub : app.get_subcommands()) called += ' ' + sub->get_name();
    say(fmt::format("{}: error: {}{} Try '{} --help'.\n", program, what, what.ends_with('?') ? "" : ".", called));
    return kUsage;
  }
  log_to_messages(program, options.verbose, options.quiet);
  // A file that is read twice is remarked on once.
  listen_to_ships([told = std::set<std::string>()](const std::string& file, const std::string& warning) mutable {
    if (told.insert(file + warning).second) spdlog::warn("{}: {}", file, warning);
  });
  return std::nullopt;
}

int report_current_exception(const std::string& program) {
  const auto ended = [&](const std::string& what, int code) {
    say(fmt::format("{}: error: {}\n", program, one_line(what)));
    return code;
  };
  try {
    throw;
  } catch (const BrokenPipe&) {
    return kOk;
  } catch (const NumericalError& error) {
    return ended(error.what(), kComputationFailed);
  } catch (const UsageError& error) {
    return ended(error.what(), kUsage);
  } catch (const InputError& error) {
    return ended(error.what(), kBadInput);
  } catch (const IoError& error) {
    return ended(error.what(), kBadFile);
  } catch (const std::bad_alloc&) {
    return ended("out of memory", kComputationFailed);
  } catch (const std::exception& error) {
    return ended(fmt::format("this is a bug in leeway {}: {}", LEEWAY_VERSION, error.what()), kBug);
  } catch (...) {
    return ended(fmt::format("this is a bug in leeway {}: an exception of unknown type", LEEWAY_VERSION), kBug);
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
CLI::Validator at_least(std::uint64_t low) {
  return {[low](std::string& text) {
            std::uint64_t value = 0;
            const char* const end = text.data() + text.size();
            const auto [stopped, error] = std::from_chars(text.data() + (text.starts_with('+') ? 1 : 0), end, value);
            if (error != std::errc() || stopped != end || value < low)
              return fmt::format("expected a whole number from {} to {}, got '{}'", low,
                                 std::numeric_limits<std::uint64_t>::max(), text);
            text = fmt::format("{}", value);  // 010 is ten
            return std::string();
          },
          ""};
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
                                        std::size_t jobs, bool keep_unknown, bool warn_of_jumps) {
  std::optional<io::ColumnsMap> map;
  if (!columns_map.empty()) map = io::read_columns_map(columns_map);
  std::map<std::string, std::string> path_of_name;
  for (const std::string& path : paths)
    if (const auto [other, is_new] = path_of_name.emplace(io::stem(path), path); !is_new)
      throw UsageError(
          fmt::format("{}: has the same name as {}; recordings are distinguished by their names", path, other->second));
  std::vector<Trajectory> recordings(paths.size());
  parallel_for(paths.size(), jobs, [&](std::size_t i) {
    recordings[i] = io::read_trajectory(paths[i], map ? &*map : nullptr, keep_unknown);
  });
  std::set<std::string> ignored, absent;
  for (const Trajectory& recording : recordings) {
    ignored.insert(recording.ignored_columns.begin(), recording.ignored_columns.end());
    if (!recording.ignored_columns.empty())
      absent.insert(recording.absent_columns.begin(), recording.absent_columns.end());
  }
  if (const auto notice = io::unread_columns(ignored, absent)) spdlog::warn("{}", *notice);
  for (const DerivableChannel& derivable : kDerivableChannels) {
    const auto count = std::count_if(recordings.begin(), recordings.end(),
                                     [&](const Trajectory& r) { return r.is_derived(derivable.channel); });
    if (count > 0)
      spdlog::warn("{} of {} of {} recordings is derived from {}, not measured", column_name(derivable.channel), count,
                   recordings.size(), column_name(derivable.of));
  }
  for (const Trajectory& recording : recordings)
    if (warn_of_jumps && clock_jumps(recording))
      spdlog::warn("{}:{}: column 't_s': {}: was the clock set? Nothing is computed across it", recording.file,
                   recording.longest_step.line, jump_text(recording));
  return recordings;
}

void tell_skipped(const std::vector<std::string>& too_short, std::size_t of, std::size_t K, double time_step_s) {
  if (too_short.empty()) return;
  spdlog::warn("{} of {} recordings {} no {} points {} s apart without a gap, {} skipped: {}", too_short.size(), of,
               too_short.size() == 1 ? "holds" : "hold", K, time_step_s, too_short.size() == 1 ? "and is" : "and are",
               io::listed(too_short));
}

void warn_all(const std::vector<std::string>& notices) {
  for (const std::string& notice : notices) spdlog::warn("{}", notice);
}

}  // namespace leeway::cli
