#include "foreign/clock_columns.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/units.hpp"
#include "foreign/anonymous_columns.hpp"
#include "io/clock_time.hpp"

namespace leeway::foreign {
namespace {

constexpr double kFirstEpoch_s = 3e8, kLastEpoch_s = 5e9;  // 1979 to 2128

// In the order of how sure they are: a day beyond 12 tells the first two of each pair apart.
constexpr const char* kPatterns[] = {"iso8601",           "hms",
                                     "%d.%m.%Y %H:%M:%S", "%d/%m/%Y %H:%M:%S",
                                     "%m/%d/%Y %H:%M:%S", "%Y/%m/%d %H:%M:%S",
                                     "%d-%m-%Y %H:%M:%S", "%d-%b-%Y %H:%M:%S",
                                     "%d %b %Y %H:%M:%S", "%Y.%m.%d %H:%M:%S",
                                     "%d.%m.%y %H:%M:%S", "%H:%M:%S %d.%m.%Y",
                                     "%I:%M:%S %p"};

io::ClockReader reader_of(const std::string& format) {
  if (format == "iso8601") return io::ClockReader(io::ClockFormat::iso8601);
  if (format == "hms") return io::ClockReader(io::ClockFormat::hms);
  return io::ClockReader(io::ClockFormat::pattern, format);
}

// All texts as seconds, if this format reads all of them and they increase.
std::optional<std::vector<double>> seconds_of(const std::vector<std::string>& texts, const std::string& format) {
  io::ClockReader reader = reader_of(format);
  std::vector<double> t;
  for (const std::string& text : texts) {
    const auto seconds = reader.seconds(text);
    if (!seconds || (!t.empty() && *seconds <= t.back())) return std::nullopt;
    t.push_back(*seconds);
  }
  return t;
}

std::optional<FoundClock> text_clock(const RawTable& table, const std::vector<std::size_t>& columns) {
  std::vector<std::string> texts = table.texts[columns[0]];
  if (columns.size() > 1)
    for (std::size_t i = 0; i < texts.size(); ++i) texts[i] += " " + table.texts[columns[1]][i];
  FoundClock clock{columns, "", "", std::nullopt, {}, ""};
  for (const char* pattern : kPatterns) {
    auto t = seconds_of(texts, pattern);
    if (!t) continue;
    if (clock.format.empty()) {
      clock.format = pattern;
      clock.t = std::move(*t);
    } else {
      clock.note = fmt::format("times are read as '{}', but '{}' reads them as well: is it the day or the month first?",
                               clock.format, pattern);
      break;
    }
  }
  return clock.format.empty() ? std::nullopt : std::optional(clock);
}

std::optional<FoundClock> number_clock(const RawTable& table, std::size_t column, const std::string& unit) {
  const std::vector<double>& values = table.columns[column];
  FoundClock clock{{column}, "", unit, std::nullopt, values, ""};
  for (std::size_t i = 1; i < values.size(); ++i)
    if (!(values[i] > values[i - 1])) return std::nullopt;
  if (unit.empty() && values.front() > kFirstEpoch_s && values.back() < kLastEpoch_s) {
    clock.format = "epoch";
    for (double& t : clock.t) t -= values.front();
  } else if (!unit.empty()) {
    for (double& t : clock.t) t *= io::unit_of(Quantity::time, unit)->factor;
  }
  return clock;
}

FoundClock interval_clock(const RawTable& table, double step_s) {
  FoundClock clock{{}, "", "", step_s, {}, ""};
  for (std::size_t i = 0; i < table.rows(); ++i) clock.t.push_back(step_s * static_cast<double>(i));
  return clock;
}

// Five digits are what a step can be known to.
double rounded(double step) {
  double value = step;
  io::parse_number(fmt::format("{:.5g}", step), value);
  return value;
}

}  // namespace

std::optional<FoundClock> find_clock(const RawTable& table, const std::vector<NamedColumn>& meanings) {
  std::vector<std::size_t> clocks, dates;
  for (std::size_t c = 0; c < meanings.size(); ++c) {
    if (meanings[c].meaning == Meaning::clock) clocks.push_back(c);
    if (meanings[c].meaning == Meaning::date) dates.push_back(c);
  }
  if (meanings.empty())
    for (std::size_t c = 0; c < table.texts.size(); ++c)
      if (table.is_text(c)) clocks.push_back(c);
  for (const std::size_t date : dates)
    for (const std::size_t clock : clocks)
      if (table.is_text(date) && table.is_text(clock))
        if (auto found = text_clock(table, {date, clock})) return found;
  for (const std::size_t c : clocks)
    if (auto found = table.is_text(c) ? text_clock(table, {c})
                                      : number_clock(table, c, c < meanings.size() ? meanings[c].unit : ""))
      return found;
  const auto linear = find_linear_clock(table.columns);
  if (!linear) return std::nullopt;
  if (linear->is_increasing) return number_clock(table, linear->column, "");
  FoundClock clock = interval_clock(table, rounded(linear->step));
  clock.columns.push_back(linear->column);
  clock.note = fmt::format(
      "the time in column {} is rounded too much to be a clock: time is taken from the row's number, {} s from row to "
      "row as its slope says, if rows are evenly spaced",
      linear->column + 1, *clock.sample_interval_s);
  return clock;
}

}  // namespace leeway::foreign
