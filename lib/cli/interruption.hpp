#pragma once

#include <array>
#include <string>

namespace leeway::cli {

/// While it lives, SIGTERM, SIGINT and SIGHUP do not end the program: long work asks whether one has come, and stops in
/// order. A signal that was ignored stays so, as SIGINT for what a shell runs in the background and SIGHUP under nohup.
/// One at a time.
class Interruption {
 public:
  Interruption();
  ~Interruption();
  Interruption(const Interruption&) = delete;
  Interruption& operator=(const Interruption&) = delete;

  static bool requested();
  static std::string signal_name();  ///< "SIGTERM"

 private:
  std::array<void (*)(int), 3> before_{};
};

}  // namespace leeway::cli
