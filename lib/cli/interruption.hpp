#pragma once

#include <array>
#include <string>

namespace leeway::cli {

/// While it lives, SIGTERM and SIGINT do not end the program: long work asks whether one has come, and stops in order.
/// A signal that was ignored stays so, as for what a shell runs in the background. One at a time.
class Interruption {
 public:
  Interruption();
  ~Interruption();
  Interruption(const Interruption&) = delete;
  Interruption& operator=(const Interruption&) = delete;

  static bool requested();
  static std::string signal_name();  ///< "SIGTERM"

 private:
  std::array<void (*)(int), 2> before_{};
};

}  // namespace leeway::cli
