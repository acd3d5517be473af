#pragma once

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/errors.hpp"
#include "io/json.hpp"

namespace leeway::io {

/// Objects and arrays within each other. Ours are less than 15 deep; what recurs over them must not fill the stack.
inline constexpr std::size_t kDeepestJson = 100;

/// "file:line:column", as an editor counts them, of the byte before `offset`.
std::string place_in(std::string_view text, std::size_t offset, const std::string& name);

/// Goes over a JSON text, or one in binary form, without making values of it, and throws InputError for what these
/// would hide or break on: nesting without end, a key that stands twice in one object, a number that overflows.
/// AnyJson decides how large a number may be.
template <typename AnyJson>
class JsonChecker {
 public:
  /// `taken`: how much of the text has been read, kept up to date by who reads it.
  JsonChecker(std::string_view text, std::string name, const std::size_t& taken)
      : text_(text), name_(std::move(name)), taken_(taken) {}

  bool null() { return value(); }
  bool boolean(bool) { return value(); }
  bool number_integer(typename AnyJson::number_integer_t) { return value(); }
  bool number_unsigned(typename AnyJson::number_unsigned_t) { return value(); }
  bool number_float(typename AnyJson::number_float_t, const std::string&) { return value(); }
  bool string(std::string&) { return value(); }
  bool binary(typename AnyJson::binary_t&) { return value(); }
  bool start_object(std::size_t) { return open(true); }
  bool start_array(std::size_t) { return open(false); }
  bool end_object() { return close(); }
  bool end_array() { return close(); }
  bool key(std::string& name) {
    levels_.back().key = name;
    if (levels_.back().keys.insert(name).second) return true;
    std::size_t quote = taken_ > 0 ? taken_ - 1 : 0;  // the closing one; to the one that opens
    while (quote > 0 && (text_[--quote] != '"' || is_escaped(quote))) continue;
    throw InputError(place_in(text_, quote + 1, name_), 0, pointer(), "the key stands twice in one object");
  }
  bool parse_error(std::size_t position, const std::string&, const nlohmann::detail::exception& error) {
    std::string what = error.what();  // "[json.exception.parse_error.101] parse error at line 1, column 2: reason"
    constexpr int kOverflow = 406;
    const std::string before = error.id == kOverflow ? "] " : ": ";
    if (const std::size_t reason = what.find(before); reason != std::string::npos)
      what = what.substr(reason + before.size());
    if (error.id == kOverflow)
      throw InputError(place_in(text_, position, name_), 0, pointer(), "the number is too large: " + what);
    if (text_.find_first_not_of(" \t\r\n") == std::string_view::npos) what = "the file is empty";
    throw InputError(place_in(text_, position, name_), "not valid JSON: " + what);
  }

 private:
  struct Level {
    bool is_object;
    std::string key;
    std::set<std::string> keys;
    std::size_t index = 0;
  };

  bool value() {
    if (!levels_.empty()) ++levels_.back().index;
    return true;
  }
  bool open(bool is_object) {
    if (levels_.size() == kDeepestJson)
      throw InputError(place_in(text_, taken_, name_),
                       fmt::format("objects and arrays are nested more than {} deep", kDeepestJson));
    levels_.push_back({is_object, {}, {}});
    return true;
  }
  bool close() {
    levels_.pop_back();
    return value();
  }
  bool is_escaped(std::size_t i) const {
    std::size_t slashes = 0;
    while (slashes < i && text_[i - 1 - slashes] == '\\') ++slashes;
    return slashes % 2 == 1;
  }
  std::string pointer() const {
    std::string result;
    for (const Level& level : levels_) result += "/" + (level.is_object ? level.key : std::to_string(level.index));
    return result;
  }

  std::string_view text_;
  std::string name_;
  const std::size_t& taken_;
  std::vector<Level> levels_;
};

/// A text's bytes for a parser; counts how many it has taken.
class CountingIterator {
 public:
  using iterator_category = std::input_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = const char&;

  CountingIterator(const char* at, std::size_t* taken) : at_(at), taken_(taken) {}
  reference operator*() const { return *at_; }
  CountingIterator& operator++() {
    ++at_;
    ++*taken_;
    return *this;
  }
  CountingIterator operator++(int) {
    const CountingIterator before = *this;
    ++*this;
    return before;
  }
  bool operator==(const CountingIterator& other) const { return at_ == other.at_; }

 private:
  const char* at_;
  std::size_t* taken_;
};

/// Throws InputError unless the text is sound JSON and its top is as expected; see JsonChecker.
template <typename AnyJson>
void check_json(const std::string& text, const std::string& name, JsonTop expected) {
  if (const std::size_t nul = text.find('\0'); nul != std::string::npos)
    throw InputError(place_in(text, nul + 1, name), "not valid JSON: a NUL byte; expected text in UTF-8");
  std::size_t taken = 0;
  JsonChecker<AnyJson> checker(text, name, taken);
  const char* const begin = text.data();
  AnyJson::sax_parse(CountingIterator(begin, &taken), CountingIterator(begin + text.size(), &taken), &checker);
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  const std::size_t first =
      text.find_first_not_of(" \t\r\n", text.starts_with(kByteOrderMark) ? kByteOrderMark.size() : 0);
  if (text[first] == '{' || (text[first] == '[' && expected == JsonTop::object_or_array)) return;
  std::string found = text.substr(first, text.find_last_not_of(" \t\r\n") + 1 - first);
  if (found.size() > 40) found = found.substr(0, 37) + "...";
  throw InputError(
      place_in(text, first + 1, name),
      fmt::format("expected an object{}, got {}", expected == JsonTop::object ? "" : " or an array of objects", found));
}

/// The same for CBOR, which has neither lines nor a top of ours.
template <typename AnyJson>
void check_cbor(std::string_view body, const std::string& name) {
  const std::size_t taken = 0;
  JsonChecker<AnyJson> checker({}, name, taken);
  AnyJson::sax_parse(body.begin(), body.end(), &checker, nlohmann::detail::input_format_t::cbor);
}

}  // namespace leeway::io
