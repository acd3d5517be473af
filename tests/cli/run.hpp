#pragma once

#include <cstdlib>
#include <string>
#include <sys/wait.h>

#include "io/files.hpp"
#include "temporary_folder.hpp"

namespace leeway::test {

struct Outcome {
  int exit_code;    ///< 128 + signal, as a shell reports it
  std::string out;  ///< standard output
  std::string err;  ///< standard error
};

/// Runs a command line by /bin/sh in a folder, with the tools of this build first in the PATH and nothing on the
/// standard input unless the command says so. Its streams are captured in a folder beside.
inline Outcome run(const TemporaryFolder& folder, const std::string& command) {
  const TemporaryFolder streams;
  const std::string script = streams.write(
      "run.sh",
      fmt::format("cd '{}' || exit 99\nPATH='" LEEWAY_BIN "':\"$PATH\"\n{}\n", folder.path().string(), command));
  const std::string line =
      fmt::format("/bin/sh '{}' > '{}' 2> '{}' < /dev/null", script, streams / "out", streams / "err");
  const int status = std::system(line.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), io::read_text(streams / "out"),
          io::read_text(streams / "err")};
}

}  // namespace leeway::test
