#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

#include "cli/options.hpp"

namespace leeway::cli {

/// "1:23:45" or "3:07".
std::string duration(double seconds);

/// Progress of long work on stderr: a bar with the time left on a terminal; else, as in a log file, plain lines: one
/// per 10 %, and one whenever a minute has passed without, also while nothing is reported. Nothing with --quiet. Safe
/// to call from several threads.
class Progress {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds kSilence{50'000};  ///< so that a busy machine keeps to the minute

  /// Where lines begin: at once, or, for what mostly takes a moment, once it has lasted for some seconds.
  enum class Lines { at_once, of_long_work };

  ///   silence  the longest time without a line
  Progress(std::string what, double total, const CommonOptions& options, Lines lines = Lines::at_once,
           std::chrono::milliseconds silence = kSilence);
  ~Progress();  ///< ends the bar's line
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// `done` of `total`; `note` follows the bar ("loss 12.3").
  void update(double done, const std::string& note);
  /// So much more is done.
  void advance(double more = 1.0, const std::string& note = "");
  /// Work that was done before this run began; the time left is estimated from the rest.
  void skip(double done);

 private:
  void show(double done, const std::string& note);  // under the lock
  void say_line();
  void break_silence(const std::stop_token& stop);
  double share() const;
  double seconds_left() const;

  std::string what_, note_;
  double total_, done_ = 0.0, skipped_ = 0.0;
  bool quiet_, terminal_;
  Lines lines_;
  int tenths_said_ = 0;
  bool bar_open_ = false;
  Clock::time_point start_ = Clock::now(), last_ = start_;
  std::chrono::milliseconds silence_;
  std::mutex mutex_;
  std::condition_variable_any ended_;
  std::jthread watch_;  // the last member: it uses the others
};

}  // namespace leeway::cli
