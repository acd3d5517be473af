#pragma once

#include <chrono>
#include <mutex>
#include <string>

#include "cli/options.hpp"

namespace leeway::cli {

/// "1:23:45" or "3:07".
std::string duration(double seconds);

/// Progress of long work on stderr: a bar with the time left on a terminal, else one plain line per 10 %; nothing with
/// --quiet. Safe to call from several threads.
class Progress {
 public:
  Progress(std::string what, double total, const CommonOptions& options);
  ~Progress();  ///< ends the bar's line
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// `done` of `total`; `note` follows the bar ("loss 12.3").
  void update(double done, const std::string& note);
  /// Work that was done before this run began; the time left is estimated from the rest.
  void skip(double done) { skipped_ += done; }

 private:
  using Clock = std::chrono::steady_clock;
  std::string what_;
  double total_, skipped_ = 0.0;
  bool quiet_, terminal_;
  int tenths_said_ = 0;
  bool bar_open_ = false;
  Clock::time_point start_ = Clock::now(), last_ = start_;
  std::mutex mutex_;
};

}  // namespace leeway::cli
