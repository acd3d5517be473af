#include "io/json.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "core/errors.hpp"
#include "core/similar_words.hpp"
#include "io/csv.hpp"
#include "io/files.hpp"
#include "io/json_check.hpp"

namespace leeway::io {
namespace {

std::string describe(const Json& value) {
  std::string text = value.dump(-1, ' ', false, Json::error_handler_t::replace);
  if (text.size() > 40) text = text.substr(0, 37) + "...";
  return text;
}

std::string describe(Bounds bounds) {
  const bool low = std::isfinite(bounds.low), high = std::isfinite(bounds.high);
  if (low && high) return fmt::format(" from {} to {}", bounds.low, bounds.high);
  if (low) return fmt::format(" {} {}", bounds.open_low ? ">" : ">=", bounds.low);
  if (high) return fmt::format(" <= {}", bounds.high);
  return "";
}

// A number that the bounds allow, in the place of one that is missing.
double within_bounds(Bounds bounds) {
  if (std::isfinite(bounds.low) && std::isfinite(bounds.high)) return 0.5 * (bounds.low + bounds.high);
  return std::isfinite(bounds.low) ? bounds.low + 1.0 : std::isfinite(bounds.high) ? bounds.high - 1.0 : 1.0;
}

bool within(double x, Bounds bounds) {
  return std::isfinite(x) && x >= bounds.low && x <= bounds.high && !(bounds.open_low && x == bounds.low);
}

}  // namespace

std::string place_in(std::string_view text, std::size_t offset, const std::string& name) {
  const std::size_t end = std::min(offset > 0 ? offset - 1 : 0, text.size());
  const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(end), '\n');
  const std::size_t start = end == 0 ? std::string_view::npos : text.rfind('\n', end - 1);
  return fmt::format("{}:{}:{}", name, line, start == std::string_view::npos ? end + 1 : end - start);
}

Json parse_json(const std::string& text, const std::string& name, JsonTop expected) {
  check_json<Json>(text, name, expected);
  return Json::parse(text);
}

Json read_json(const std::string& path, JsonTop expected) { return parse_json(read_text(path), path, expected); }

std::string to_text(const Json& json) { return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n"; }

JsonObject::JsonObject(const Json& value, std::string file, std::string pointer)
    : value_(&value), file_(std::move(file)), pointer_(std::move(pointer)) {
  if (!value.is_object())
    throw InputError(file_, 0, pointer_, fmt::format("expected an object, got {}", describe(value)));
}

bool JsonObject::has(const std::string& key) const {
  asked_.insert(key);
  return value_->contains(key);
}

void JsonObject::fail(const std::string& key, const std::string& problem) const {
  throw InputError(file_, 0, pointer(key), problem);
}

void JsonObject::note_missing() { missing_ = std::make_shared<std::vector<Missing>>(); }

void JsonObject::require_complete() const {
  if (!missing_ || missing_->empty()) return;
  std::string problem = missing_->front().problem;
  for (std::size_t i = 1; i < missing_->size(); ++i)
    problem += fmt::format("{}{}: {}", i == 1 ? "; and " : "; ", (*missing_)[i].pointer, (*missing_)[i].problem);
  throw InputError(file_, 0, missing_->front().pointer, problem);
}

const Json* JsonObject::find(const std::string& key, const std::string& expected) const {
  if (has(key)) return &(*value_)[key];
  if (is_absent_) return nullptr;
  std::string problem = missing_value(expected);
  std::vector<std::string> others;
  for (const auto& item : value_->items())
    if (!asked_.contains(item.key())) others.push_back(item.key());
  if (const std::vector<std::string> like = similar_words(key, others); !like.empty())
    problem += fmt::format(" (is '{}' meant?)", like.front());
  if (!missing_) fail(key, problem);
  missing_->push_back({pointer(key), problem});
  return nullptr;
}

JsonObject JsonObject::part(const Json& value, const std::string& pointer) const {
  JsonObject result(value, file_, pointer);
  result.missing_ = missing_;
  result.is_absent_ = is_absent_;
  return result;
}

std::string JsonObject::missing_value(const std::string& expected) const {
  // A misspelled key is the likelier story than a forgotten one: name the keys that are there and not known.
  std::vector<std::string> unknown;
  for (const auto& item : value_->items())
    if (!asked_.contains(item.key())) unknown.push_back(item.key());
  return fmt::format("missing, expected {}{}", expected,
                     unknown.empty() ? "" : fmt::format("; not yet read here: {}", listed(unknown)));
}

double JsonObject::number(const std::string& key, Bounds bounds) const {
  const std::string expected = "a number" + describe(bounds);
  const Json* found = find(key, expected);
  if (found == nullptr) return within_bounds(bounds);
  const Json& v = *found;
  if (!v.is_number() || !within(v.get<double>(), bounds))
    fail(key, fmt::format("expected {}, got {}", expected, describe(v)));
  return v.get<double>();
}

double JsonObject::number_or(const std::string& key, double otherwise, Bounds bounds) const {
  return has(key) ? number(key, bounds) : otherwise;
}

long JsonObject::integer(const std::string& key, Bounds bounds) const {
  const std::string expected = "a whole number" + describe(bounds);
  const Json* found = find(key, expected);
  if (found == nullptr) return std::lround(within_bounds(bounds));
  const Json& v = *found;
  const bool too_large = v.is_number_unsigned() && v.get<std::uint64_t>() > std::numeric_limits<long>::max();
  if (!v.is_number_integer() || too_large || !within(v.get<double>(), bounds))
    fail(key, fmt::format("expected {}, got {}", expected, describe(v)));
  return v.get<long>();
}

long JsonObject::integer_or(const std::string& key, long otherwise, Bounds bounds) const {
  return has(key) ? integer(key, bounds) : otherwise;
}

bool JsonObject::flag_or(const std::string& key, bool otherwise) const {
  if (!has(key)) return otherwise;
  const Json& v = (*value_)[key];
  if (!v.is_boolean()) fail(key, fmt::format("expected true or false, got {}", describe(v)));
  return v.get<bool>();
}

std::string JsonObject::text(const std::string& key) const {
  const Json* found = find(key, "a text");
  if (found == nullptr) return "missing";
  const Json& v = *found;
  if (!v.is_string()) fail(key, fmt::format("expected a text, got {}", describe(v)));
  return v.get<std::string>();
}

std::string JsonObject::text_or(const std::string& key, const std::string& otherwise) const {
  return has(key) ? text(key) : otherwise;
}

std::string JsonObject::word(const std::string& key, const std::vector<std::string>& words) const {
  if (find(key, "a text") == nullptr) {
    is_absent_ = true;  // what else it holds depends on the word
    return words.front();
  }
  std::string found = text(key);
  if (std::find(words.begin(), words.end(), found) == words.end())
    fail(key, fmt::format("unknown '{}'; known: {}{}", found, fmt::join(words, ", "), did_you_mean(found, words)));
  return found;
}

std::vector<double> JsonObject::numbers(const std::string& key) const {
  const Json* found = find(key, "an array of numbers");
  if (found == nullptr) return {};
  const Json& v = *found;
  if (!v.is_array()) fail(key, fmt::format("expected an array of numbers, got {}", describe(v)));
  std::vector<double> result;
  for (const Json& item : v) {
    if (!item.is_number() || !std::isfinite(item.get<double>()))
      fail(fmt::format("{}/{}", key, result.size()), fmt::format("expected a number, got {}", describe(item)));
    result.push_back(item.get<double>());
  }
  return result;
}

std::vector<double> JsonObject::numbers(const std::string& key, std::size_t n) const {
  if (find(key, fmt::format("an array of {} numbers", n)) == nullptr) return std::vector<double>(n, 0.0);
  std::vector<double> result = numbers(key);
  if (result.size() != n) fail(key, fmt::format("expected {} numbers, got {}", n, result.size()));
  return result;
}

std::vector<std::string> JsonObject::texts(const std::string& key) const {
  const Json* found = find(key, "an array of texts");
  if (found == nullptr) return {};
  const Json& v = *found;
  if (!v.is_array()) fail(key, fmt::format("expected an array of texts, got {}", describe(v)));
  std::vector<std::string> result;
  for (const Json& item : v) {
    if (!item.is_string())
      fail(fmt::format("{}/{}", key, result.size()), fmt::format("expected a text, got {}", describe(item)));
    result.push_back(item.get<std::string>());
  }
  return result;
}

JsonObject JsonObject::object(const std::string& key) const {
  static const Json kNothing = Json::object();
  const Json* found = find(key, "an object");
  if (found != nullptr) return part(*found, pointer(key));
  JsonObject result = part(kNothing, pointer(key));
  result.is_absent_ = true;
  return result;
}

std::optional<JsonObject> JsonObject::object_if(const std::string& key) const {
  if (!has(key)) return std::nullopt;
  return object(key);
}

std::vector<JsonObject> JsonObject::objects(const std::string& key) const {
  const Json* found = find(key, "an array of objects");
  if (found == nullptr) return {};
  const Json& v = *found;
  if (!v.is_array()) fail(key, fmt::format("expected an array of objects, got {}", describe(v)));
  std::vector<JsonObject> result;
  for (const Json& item : v) result.push_back(part(item, fmt::format("{}/{}", pointer(key), result.size())));
  return result;
}

std::vector<std::string> JsonObject::keys() const {
  std::vector<std::string> result;
  for (const auto& item : value_->items()) result.push_back(item.key());
  return result;
}

const Json& JsonObject::value(const std::string& key) const {
  static const Json kNull;
  const Json* found = find(key, "a value");
  return found == nullptr ? kNull : *found;
}

void JsonObject::check_all_known() const {
  for (const auto& item : value_->items())
    if (!asked_.contains(item.key()))
      fail(item.key(), fmt::format("unknown key; known here: {}{}", fmt::join(asked_, ", "),
                                   did_you_mean(item.key(), {asked_.begin(), asked_.end()})));
}

}  // namespace leeway::io
