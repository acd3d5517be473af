#pragma once

#include <cmath>
#include <functional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "fuzz/hostile_files.hpp"
#include "io/json.hpp"

/// What reads files that others wrote, each with what must hold of everything that it accepts. libFuzzer feeds them
/// (fuzzer.cpp), and so does an ordinary test from the corpus (corpus.cpp).
namespace leeway::test {

/// A reader has accepted what is invalid, or made something else of it.
struct Misread : std::logic_error {
  using std::logic_error::logic_error;
};

inline void expect(bool holds, std::string_view what) {
  if (!holds) throw Misread(std::string(what));
}

/// Equal but for the rounding of the factor between degrees and radians, which is taken twice; NaN equals NaN.
inline bool same(double a, double b) {
  return a == b || (std::isnan(a) && std::isnan(b)) || std::abs(a - b) <= 1e-14 * std::abs(a) + 1e-320;
}

/// What a reader does with a wrong text: a clear error, or, of what is only a note to other runs, as if it were not
/// there.
enum class Wrong { refused, passed_over };

struct Reader {
  const char* name;   ///< of its corpus, tests/fuzz/corpus/<name>
  const char* seeds;  ///< a folder of shipped files that belong to the corpus as they lie; empty: none
  /// Reads `text` as a file of its kind. Throws InputError or IoError where it is refused, Misread where a check fails.
  void (*read)(HostileFiles& files, std::string_view text);
  Wrong wrong = Wrong::refused;
};

const std::vector<Reader>& csv_readers();
const std::vector<Reader>& json_readers();
const std::vector<Reader>& model_readers();
/// All of them.
std::vector<Reader> readers();

/// Reads a text and says whether it was accepted. Throws Misread where a check fails, where it is refused by any other
/// error than InputError and IoError, or by a message that does not begin with the file.
bool accepts(const Reader& reader, HostileFiles& files, std::string_view text);

/// Throws Misread where a reader still accepts a JSON text, which it has accepted, when an object of it gets a key that
/// nobody knows, or one of its numbers becomes a text. Whether, and which of them, is drawn by the text itself.
///   free  keys below which anything may stand
void expect_strict(const std::string& text, const std::vector<std::string>& free,
                   const std::function<void(const std::string&)>& read);

}  // namespace leeway::test
