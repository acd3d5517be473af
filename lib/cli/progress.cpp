#include "cli/progress.hpp"

#include <algorithm>
#include <cmath>
#include <new>
#include <system_error>
#include <unistd.h>

#include <fmt/format.h>

#include "cli/messages.hpp"
#include "core/parallel.hpp"

namespace leeway::cli {
namespace {

constexpr std::chrono::seconds kShortWork{3};

}  // namespace

std::string duration(double seconds) {
  const long s = std::lround(seconds);
  if (s >= 3600) return fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
  return fmt::format("{}:{:02}", s / 60, s % 60);
}

Progress::Progress(std::string what, double total, const CommonOptions& options, Lines lines,
                   std::chrono::milliseconds silence)
    : what_(std::move(what)),
      total_(total),
      quiet_(options.quiet),
      terminal_(::isatty(STDERR_FILENO) == 1),
      lines_(lines),
      silence_(silence) {
  if (quiet_ || terminal_ || total_ <= 0.0 || threads_with_room() < 2) return;
  try {
    watch_ = std::jthread([this](const std::stop_token& stop) { break_silence(stop); });
  } catch (const std::system_error&) {  // no thread to be had: lines come with the work alone
  } catch (const std::bad_alloc&) {
  }
}

Progress::~Progress() {
  if (bar_open_) say("\n");
}

void Progress::update(double done, const std::string& note) {
  const std::lock_guard lock(mutex_);
  show(done, note);
}

void Progress::advance(double more, const std::string& note) {
  const std::lock_guard lock(mutex_);
  show(done_ + more, note);
}

void Progress::skip(double done) {
  const std::lock_guard lock(mutex_);
  skipped_ += done;
}

double Progress::share() const { return std::clamp(done_ / total_, 0.0, 1.0); }

double Progress::seconds_left() const {
  const double elapsed = std::chrono::duration<double>(Clock::now() - start_).count();
  return done_ > skipped_ ? elapsed * (total_ - done_) / (done_ - skipped_) : 0.0;
}

void Progress::show(double done, const std::string& note) {
  if (quiet_ || total_ <= 0.0) return;
  done_ = done;
  note_ = note;
  const Clock::time_point now = Clock::now();
  if (terminal_) {
    if (share() < 1.0 && now - last_ < std::chrono::milliseconds(200)) return;
    last_ = now;
    const int filled = static_cast<int>(share() * 30.0);
    say(fmt::format("\r{} [{:#<{}}{:.<{}}] {:3.0f} %  {}  {} left \x1b[K", what_, "", filled, "", 30 - filled,
                    100.0 * share(), note, duration(seconds_left())));
    bar_open_ = true;
    return;
  }
  const int tenths = static_cast<int>(share() * 10.0);
  if (tenths <= tenths_said_ || (lines_ == Lines::of_long_work && now - start_ < kShortWork)) return;
  say_line();
}

void Progress::say_line() {
  last_ = Clock::now();
  tenths_said_ = static_cast<int>(share() * 10.0);
  const std::string note = note_.empty() ? "" : ", " + note_;
  const std::string time = done_ > skipped_
                               ? duration(seconds_left()) + " left"
                               : duration(std::chrono::duration<double>(last_ - start_).count()) + " so far";
  say(fmt::format("{}: {:.0f} %{}, {}\n", what_, std::floor(100.0 * share()), note, time));
}

// Long steps of the work say nothing for minutes, and a log file that stands still looks like a tool that hangs.
void Progress::break_silence(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (!stop.stop_requested()) {
    ended_.wait_until(lock, stop, last_ + silence_, [] { return false; });
    if (!stop.stop_requested() && Clock::now() - last_ >= silence_) say_line();
  }
}

}  // namespace leeway::cli
