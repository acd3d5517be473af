#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

namespace leeway::io {

/// Declared only: who makes or reads values includes <nlohmann/json.hpp>, which costs the compiler a second.
using Json = nlohmann::ordered_json;

/// What a JSON text may be.
enum class JsonTop { object, object_or_array };

/// Reads a JSON file ("-": standard input). Throws IoError, or InputError with line and column for bad syntax, with the
/// pointer as well where there is one: see check_json().
Json read_json(const std::string& path, JsonTop expected = JsonTop::object);

/// Parses a JSON text; `name` stands in the messages.
Json parse_json(const std::string& text, const std::string& name, JsonTop expected = JsonTop::object);

/// Two-space indented text with a line end. Bytes that are not UTF-8 (a file's name may hold them) become U+FFFD.
std::string to_text(const Json& json);

/// The numbers that a key may have. Bounds themselves are allowed unless `open_low`.
struct Bounds {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool open_low = false;
};
inline constexpr Bounds kPositive{0.0, std::numeric_limits<double>::infinity(), true};
inline constexpr Bounds kNotNegative{0.0, std::numeric_limits<double>::infinity(), false};

/// A checked view of one JSON object: a value that is missing, of the wrong type or out of bounds throws InputError
/// with the file and the JSON pointer; so does check_all_known() if there is a key that nobody asked for.
/// The unit of a number is part of its key.
class JsonObject {
 public:
  JsonObject(const Json& value, std::string file, std::string pointer = "");

  /// From here on, missing values of this object and of those read from it are noted, and something is returned in
  /// their place, so that all of them can be told at once: require_complete() throws if there is one.
  void note_missing();
  void require_complete() const;

  const std::string& file() const { return file_; }
  std::string pointer(const std::string& key) const { return pointer_ + "/" + key; }
  bool has(const std::string& key) const;

  double number(const std::string& key, Bounds bounds = {}) const;
  double number_or(const std::string& key, double otherwise, Bounds bounds = {}) const;
  long integer(const std::string& key, Bounds bounds = {}) const;
  long integer_or(const std::string& key, long otherwise, Bounds bounds = {}) const;
  bool flag_or(const std::string& key, bool otherwise) const;
  std::string text(const std::string& key) const;
  std::string text_or(const std::string& key, const std::string& otherwise) const;
  /// One of the given words.
  std::string word(const std::string& key, const std::vector<std::string>& words) const;
  std::vector<double> numbers(const std::string& key) const;                 ///< any length
  std::vector<double> numbers(const std::string& key, std::size_t n) const;  ///< exactly n
  template <std::size_t n>
  std::array<double, n> array(const std::string& key) const {  ///< exactly n
    std::array<double, n> result{};
    std::ranges::copy(numbers(key, n), result.begin());
    return result;
  }
  std::vector<std::string> texts(const std::string& key) const;
  JsonObject object(const std::string& key) const;
  std::optional<JsonObject> object_if(const std::string& key) const;  ///< nothing if absent
  std::vector<JsonObject> objects(const std::string& key) const;      ///< an array of objects
  std::vector<std::string> keys() const;
  const Json& value(const std::string& key) const;  ///< as it is; counts as asked for

  /// Throws for a key that was never asked for: a misspelled coefficient must not become a silent zero.
  void check_all_known() const;

  /// Throws an InputError that points to `key`.
  [[noreturn]] void fail(const std::string& key, const std::string& problem) const;

 private:
  struct Missing {
    std::string pointer, problem;
  };

  /// What to say of a value that is missing.
  std::string missing_value(const std::string& expected) const;
  /// Nothing, and a note, where it is missing and missing values are noted; else it throws.
  const Json* find(const std::string& key, const std::string& expected) const;
  JsonObject part(const Json& value, const std::string& pointer) const;

  const Json* value_;
  std::shared_ptr<std::vector<Missing>> missing_;  // shared by all objects of a file; nullptr: the first one throws
  mutable bool is_absent_ = false;                 // stands for an object that is missing: nothing more is noted of it
  std::string file_, pointer_;
  mutable std::set<std::string> asked_;
};

}  // namespace leeway::io
