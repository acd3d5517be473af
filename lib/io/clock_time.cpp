#include "io/clock_time.hpp"

#include <charconv>
#include <chrono>
#include <cmath>
#include <limits>
#include <sstream>
#include <utility>

// Words of the C locale by date.h itself: libstdc++ passes over AM and PM. GCC cannot see that fields which are not
// read are not used.
#define ONLY_C_LOCALE 1
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#include <date/date.h>
#pragma GCC diagnostic pop

#include "io/csv.hpp"

namespace leeway::io {
namespace {

using Nanoseconds = std::chrono::nanoseconds;
constexpr std::int64_t kSecond = 1'000'000'000, kMinute = 60 * kSecond, kHour = 60 * kMinute, kDay = 24 * kHour;

// Takes numbers and marks off the front of a text.
class Cursor {
 public:
  explicit Cursor(std::string_view text) : rest_(text) {}
  bool is_at_end() const { return rest_.empty(); }
  bool take(char c) {
    if (rest_.empty() || rest_.front() != c) return false;
    rest_.remove_prefix(1);
    return true;
  }
  bool take_digits(std::size_t least, std::size_t most, std::int64_t& value) {
    value = 0;
    std::size_t n = 0;
    for (; n < most && n < rest_.size() && rest_[n] >= '0' && rest_[n] <= '9'; ++n)
      value = 10 * value + (rest_[n] - '0');
    if (n < least) return false;
    rest_.remove_prefix(n);
    return true;
  }
  // Digits behind a point or a comma, as nanoseconds; what is finer is cut off.
  std::int64_t take_fraction() {
    if (rest_.size() < 2 || (rest_[0] != '.' && rest_[0] != ',') || rest_[1] < '0' || rest_[1] > '9') return 0;
    rest_.remove_prefix(1);
    std::int64_t value = 0, unit = kSecond;
    for (; !rest_.empty() && rest_.front() >= '0' && rest_.front() <= '9'; rest_.remove_prefix(1)) {
      unit /= 10;
      value += unit * (rest_.front() - '0');
    }
    return value;
  }
  // hh:mm[:ss[.fraction]], the seconds up to a leap second, with or without colons.
  std::optional<std::int64_t> take_time_of_day() {
    std::int64_t h = 0, min = 0, s = 0, fraction = 0;
    if (!take_digits(1, 2, h)) return std::nullopt;
    const bool has_colons = take(':');
    if (!take_digits(2, 2, min)) return std::nullopt;
    const bool has_seconds = has_colons ? take(':') : !rest_.empty() && rest_.front() >= '0' && rest_.front() <= '9';
    if (has_seconds && !take_digits(2, 2, s)) return std::nullopt;
    if (has_seconds) fraction = take_fraction();
    if (h > 23 || min > 59 || s > 60) return std::nullopt;
    return h * kHour + min * kMinute + s * kSecond + fraction;
  }

 private:
  std::string_view rest_;
};

std::optional<std::int64_t> read_hms(std::string_view text) {
  Cursor cursor(text);
  const auto time = cursor.take_time_of_day();
  return cursor.is_at_end() ? time : std::nullopt;
}

// Z, +hh, +hh:mm or +hhmm as what is to be subtracted; nothing taken is UTC.
std::optional<std::int64_t> take_zone(Cursor& cursor) {
  if (cursor.is_at_end() || cursor.take('Z') || cursor.take('z')) return 0;
  const bool is_east = cursor.take('+');
  if (!is_east && !cursor.take('-')) return std::nullopt;
  std::int64_t h = 0, min = 0;
  if (!cursor.take_digits(2, 2, h)) return std::nullopt;
  if (cursor.take(':') || !cursor.is_at_end())
    if (!cursor.take_digits(2, 2, min)) return std::nullopt;
  if (h > 23 || min > 59) return std::nullopt;
  return (is_east ? 1 : -1) * (h * kHour + min * kMinute);
}

std::optional<std::int64_t> days_ns(std::int64_t year, std::int64_t month, std::int64_t day) {
  const std::chrono::year_month_day date{std::chrono::year(static_cast<int>(year)),
                                         std::chrono::month(static_cast<unsigned>(month)),
                                         std::chrono::day(static_cast<unsigned>(day))};
  if (!date.ok() || year < 1700 || year > 2250) return std::nullopt;  // what nanoseconds in 64 bits hold
  return std::chrono::sys_days(date).time_since_epoch().count() * kDay;
}

std::optional<std::int64_t> read_iso8601(std::string_view text) {
  Cursor cursor(text);
  std::int64_t year = 0, month = 0, day = 0;
  if (!cursor.take_digits(4, 4, year)) return std::nullopt;
  const bool has_dashes = cursor.take('-');
  if (!cursor.take_digits(2, 2, month) || (has_dashes && !cursor.take('-')) || !cursor.take_digits(2, 2, day))
    return std::nullopt;
  const auto date = days_ns(year, month, day);
  if (!date || (!cursor.take('T') && !cursor.take('t') && !cursor.take(' '))) return std::nullopt;
  const auto time = cursor.take_time_of_day();
  if (!time) return std::nullopt;
  cursor.take(' ');
  const auto zone = take_zone(cursor);
  if (!zone || !cursor.is_at_end()) return std::nullopt;
  return *date + *time - *zone;
}

std::optional<std::int64_t> read_epoch(std::string_view text) {
  Cursor cursor(text);
  const bool is_negative = cursor.take('-');
  std::int64_t whole = 0;
  if (cursor.take_digits(1, 9 + 1, whole)) {  // to the digit, where a double of seconds holds 2e-7 s
    const std::int64_t value = whole * kSecond + cursor.take_fraction();
    if (cursor.is_at_end()) return is_negative ? -value : value;
  }
  double seconds = 0.0;
  constexpr double kLargest_s = 9e9;
  if (!parse_number(text, seconds) || std::abs(seconds) > kLargest_s) return std::nullopt;
  return static_cast<std::int64_t>(std::llround(seconds * static_cast<double>(kSecond)));
}

constexpr std::string_view kDateLetters = "CDFGUVWYbBcdeghjmuwxy", kTimeLetters = "HIMSTRXcrp", kOthers = "zZntaA%";

// The letters behind %, without the modifiers E and O.
std::string letters_of(const std::string& pattern) {
  std::string letters;
  for (std::size_t i = 0; i < pattern.size(); ++i) {
    if (pattern[i] != '%') continue;
    ++i;
    if (i < pattern.size() && (pattern[i] == 'E' || pattern[i] == 'O')) ++i;
    letters += i < pattern.size() ? pattern[i] : '\0';
  }
  return letters;
}

bool has_any(const std::string& letters, std::string_view of) {
  return letters.find_first_of(of.data(), 0, of.size()) != std::string::npos;
}

}  // namespace

bool is_clock_pattern(const std::string& pattern) {
  const std::string letters = letters_of(pattern);
  for (const char c : letters)
    if (kDateLetters.find(c) == std::string_view::npos && kTimeLetters.find(c) == std::string_view::npos &&
        kOthers.find(c) == std::string_view::npos)
      return false;
  return has_any(letters, kDateLetters) || has_any(letters, kTimeLetters);
}

struct ClockReader::Pattern {
  std::string text;
  std::istringstream stream;
};

ClockReader::ClockReader(ClockFormat format, std::string pattern) : format_(format) {
  has_date_ = format == ClockFormat::iso8601 || format == ClockFormat::epoch;
  if (format != ClockFormat::pattern) return;
  has_date_ = has_any(letters_of(pattern), kDateLetters);
  pattern_ = std::make_unique<Pattern>(Pattern{std::move(pattern), {}});
  pattern_->stream.imbue(std::locale::classic());
}

ClockReader::~ClockReader() = default;
ClockReader::ClockReader(ClockReader&&) noexcept = default;
ClockReader& ClockReader::operator=(ClockReader&&) noexcept = default;

std::optional<std::int64_t> ClockReader::nanoseconds(std::string_view text) {
  switch (format_) {
    case ClockFormat::iso8601:
      return read_iso8601(text);
    case ClockFormat::epoch:
      return read_epoch(text);
    case ClockFormat::hms:
      return read_hms(text);
    case ClockFormat::pattern:
      break;
  }
  std::string with_point(text);  // %S takes a point alone
  for (std::size_t i = 1; i + 1 < with_point.size(); ++i)
    if (with_point[i] == ',' && std::isdigit(static_cast<unsigned char>(with_point[i - 1])) != 0 &&
        std::isdigit(static_cast<unsigned char>(with_point[i + 1])) != 0 &&
        pattern_->text.find(',') == std::string::npos)
      with_point[i] = '.';
  std::istringstream& stream = pattern_->stream;
  stream.clear();
  stream.str(with_point);
  date::fields<Nanoseconds> fields{};
  std::chrono::minutes zone{0};
  date::from_stream(stream, pattern_->text.c_str(), fields, static_cast<std::string*>(nullptr), &zone);
  if (stream.fail() || stream.peek() != std::istringstream::traits_type::eof()) return std::nullopt;
  std::int64_t date = 0;
  if (has_date_) {
    if (!fields.ymd.ok()) return std::nullopt;
    const auto days = days_ns(static_cast<int>(fields.ymd.year()), static_cast<unsigned>(fields.ymd.month()),
                              static_cast<unsigned>(fields.ymd.day()));
    if (!days) return std::nullopt;
    date = *days;
  }
  const std::int64_t time = fields.has_tod ? fields.tod.to_duration().count() : 0;
  return date + time - Nanoseconds(zone).count();
}

std::optional<double> ClockReader::seconds(std::string_view text) {
  std::optional<std::int64_t> now = nanoseconds(trim(text));
  if (!now) return std::nullopt;
  if (!has_date_) {
    if (last_ && *now + midnights_ * kDay < *last_ - kDay / 2) ++midnights_;
    *now += midnights_ * kDay;
  }
  last_ = now;
  if (!first_) first_ = now;
  return static_cast<double>(*now - *first_) / static_cast<double>(kSecond);
}

std::string ClockReader::expected() const {
  switch (format_) {
    case ClockFormat::iso8601:
      return "a time as in ISO 8601 (2020-11-12T23:59:58.5+01:00)";
    case ClockFormat::epoch:
      return "seconds since 1970";
    case ClockFormat::hms:
      return "a time of day (23:59:58.5)";
    case ClockFormat::pattern:
      break;
  }
  return "a time as '" + pattern_->text + "'";
}

}  // namespace leeway::io
