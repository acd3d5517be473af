#include "cli/interruption.hpp"

#include <atomic>
#include <csignal>

namespace leeway::cli {
namespace {

constexpr std::array kSignals{SIGTERM, SIGINT, SIGHUP};

std::atomic<int> signal_that_came{0};
static_assert(std::atomic<int>::is_always_lock_free);  // else a signal handler must not touch it

void note(int signal) { signal_that_came = signal; }

}  // namespace

Interruption::Interruption() {
  signal_that_came = 0;
  for (std::size_t i = 0; i < kSignals.size(); ++i) {
    struct sigaction before {};
    ::sigaction(kSignals[i], nullptr, &before);
    before_[i] = before.sa_handler;
    if (before_[i] != SIG_IGN) std::signal(kSignals[i], note);
  }
}

Interruption::~Interruption() {
  for (std::size_t i = 0; i < kSignals.size(); ++i) std::signal(kSignals[i], before_[i]);
}

bool Interruption::requested() { return signal_that_came != 0; }

std::string Interruption::signal_name() {
  const int signal = signal_that_came;
  return signal == SIGINT ? "SIGINT" : signal == SIGHUP ? "SIGHUP" : "SIGTERM";
}

}  // namespace leeway::cli
