#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>

namespace leeway {

/// A file's contents are wrong. Exit code 3.
///   file    as the user named it; "-" for the standard input
///   line    as an editor counts it, 0 where a line makes no sense
///   item    "column 'u_mps'", a JSON pointer "/hull/L_pp_m", or empty
///   problem what was expected, with its unit, and what was found
struct InputError : std::runtime_error {
  InputError(const std::string& file, std::size_t line, const std::string& item, const std::string& problem);
  InputError(const std::string& file, const std::string& problem);
};

/// A file cannot be read or written. Exit code 4.
struct IoError : std::runtime_error {
  IoError(const std::string& file, const std::string& problem);
};

/// The reader of a pipe has gone: end quietly.
struct BrokenPipe : std::runtime_error {
  BrokenPipe() : std::runtime_error("broken pipe") {}
};

/// The computation failed: it diverged, did not converge, or missed a demanded threshold. Exit code 1.
struct NumericalError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The command line asks for something that does not exist or contradicts itself. Exit code 2.
struct UsageError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace leeway
