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

bool increases(const std::vector<double>& t) {
  for (std::size_t i = 1; i < t.size(); ++i)
    if (!(t[i] - t[i - 1] >= kSameTime_s)) return false;
  return true;
}

// hhmmss.ss as the seconds of a day, on beyond midnight; nothing where these are none.
std::vector<double> seconds_of_day(const std::vector<double>& values) {
  constexpr double kHour = 3600.0, kMinute = 60.0, kDay = 24.0 * kHour;
  std::vector<double> t;
  double midnights = 0.0;
  for (const double value : values) {
    const double h = std::floor(value / 1e4), min = std::floor(std::fmod(value, 1e4) / 100.0),
                 s = std::fmod(value, 100.0);
    if (!(h >= 0.0 && h < 24.0 && min < 60.0 && s < 61.0)) return {};
    double now = h * kHour + min * kMinute + s + midnights;
    if (!t.empty() && now < t.back() - 0.5 * kDay) {
      midnights += kDay;
      now += kDay;
    }
    t.push_back(now);
  }
  return increases(t) ? t : std::vector<double>{};
}

std::optional<FoundClock> number_clock(const RawTable& table, std::size_t column, const NamedColumn& named) {
  const std::vector<double>& values = table.columns[column];
  FoundClock clock{{column}, "", named.unit, std::nullopt, values, ""};
  if (const std::vector<double> t = seconds_of_day(values); named.is_time_of_day && !t.empty()) {
    clock.format = "hms";
    clock.t = t;
    return clock;
  }
  for (std::size_t i = 1; i < values.size(); ++i)
    if (!(values[i] > values[i - 1])) {
      if (const std::vector<double> t = seconds_of_day(values); !t.empty()) {  // only so, over midnight
        clock.format = "hms";
        clock.t = t;
        return clock;
      }
      return std::nullopt;
    }
  clock.scale = named.scale;
  if (clock.unit.empty() && values.front() > kFirstEpoch_s && values.back() < kLastEpoch_s) {
    clock.format = "epoch";
    for (double& t : clock.t) t -= values.front();
    return clock;
  }
  if (clock.unit.empty() && values.front() > 1e3 * kFirstEpoch_s && values.back() < 1e3 * kLastEpoch_s)
    clock.unit = "ms";
  clock.is_assumed = clock.unit.empty();
  for (double& t : clock.t)
    t *= clock.scale * (clock.is_assumed ? 1.0 : io::unit_of(Quantity::time, clock.unit)->factor);
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
                                      : number_clock(table, c, c < meanings.size() ? meanings[c] : NamedColumn{}))
      return found;
  const auto linear = find_linear_clock(table.columns);
  if (!linear) return std::nullopt;
  if (linear->is_increasing) return number_clock(table, linear->column, {});
  FoundClock clock = interval_clock(table, rounded(linear->step));
  clock.columns.push_back(linear->column);
  clock.note = fmt::format(
      "the time in column {} is rounded too much to be a clock: time is taken from the row's number, {} s from row to "
      "row as its slope says, if rows are evenly spaced",
      linear->column + 1, *clock.sample_interval_s);
  return clock;
}

std::vector<FoundClock> other_readings(const RawTable& table, const FoundClock& clock) {
  constexpr double kHoursOfDay = 24.0;
  std::vector<FoundClock> all;
  if (!clock.is_assumed) return all;
  const std::vector<double>& values = table.columns[clock.columns.front()];
  for (const auto& [unit, scale] :
       {std::pair{"ms", 1.0}, std::pair{"min", 1.0}, std::pair{"h", 1.0}, std::pair{"h", kHoursOfDay}}) {
    FoundClock other{clock.columns, "", unit, std::nullopt, values, "", scale};
    for (double& t : other.t) t *= scale * io::unit_of(Quantity::time, unit)->factor;
    if (increases(other.t)) all.push_back(std::move(other));
  }
  if (std::vector<double> t = seconds_of_day(values); !t.empty())
    all.push_back({clock.columns, "hms", "", std::nullopt, std::move(t), ""});
  return all;
}

}  // namespace leeway::foreign
