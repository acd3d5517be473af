#include "cli/progress.hpp"

#include <algorithm>
#include <cmath>
#include <unistd.h>

#include <fmt/format.h>

#include "cli/messages.hpp"

namespace leeway::cli {

std::string duration(double seconds) {
  const long s = std::lround(seconds);
  if (s >= 3600) return fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
  return fmt::format("{}:{:02}", s / 60, s % 60);
}

Progress::Progress(std::string what, double total, const CommonOptions& options)
    : what_(std::move(what)), total_(total), quiet_(options.quiet), terminal_(::isatty(STDERR_FILENO) == 1) {}

Progress::~Progress() {
  if (bar_open_) say("\n");
}

void Progress::update(double done, const std::string& note) {
  const std::lock_guard lock(mutex_);
  if (quiet_ || total_ <= 0.0) return;
  const double share = std::clamp(done / total_, 0.0, 1.0);
  const Clock::time_point now = Clock::now();
  const double elapsed = std::chrono::duration<double>(now - start_).count();
  const double left = done > skipped_ ? elapsed * (total_ - done) / (done - skipped_) : 0.0;
  if (terminal_) {
    if (share < 1.0 && now - last_ < std::chrono::milliseconds(200)) return;
    last_ = now;
    const int filled = static_cast<int>(share * 30.0);
    say(fmt::format("\r{} [{:#<{}}{:.<{}}] {:3.0f} %  {}  {} left \x1b[K", what_, "", filled, "", 30 - filled,
                    100.0 * share, note, duration(left)));
    bar_open_ = true;
    return;
  }
  const int tenths = static_cast<int>(share * 10.0);
  if (tenths <= tenths_said_) return;
  tenths_said_ = tenths;
  say(fmt::format("{}: {} %, {}, {} left\n", what_, 10 * tenths, note, duration(left)));
}

}  // namespace leeway::cli
