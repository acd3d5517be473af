#include "io/trajectory_csv.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "core/errors.hpp"
#include "core/units.hpp"
#include "io/csv.hpp"
#include "io/files.hpp"
#include "io/json.hpp"

namespace leeway::io {
namespace {

struct Unit {
  Quantity quantity;
  std::string_view suffix;
  double factor;             // to SI
  std::string_view printed;  // in messages
};

constexpr Unit kUnits[] = {
    {Quantity::time, "s", 1.0, "s"},
    {Quantity::length, "m", 1.0, "m"},
    {Quantity::speed, "mps", 1.0, "m/s"},
    {Quantity::speed, "kn", kKnot, "kn"},
    {Quantity::angle, "deg", kDegree, "deg"},
    {Quantity::angle, "rad", 1.0, "rad"},
    {Quantity::angular_rate, "degps", kDegree, "deg/s"},
    {Quantity::angular_rate, "radps", 1.0, "rad/s"},
    {Quantity::revolutions, "rps", 1.0, "1/s"},
    {Quantity::ratio, "", 1.0, ""},
};

std::optional<double> factor_of(Quantity quantity, std::string_view unit) {
  for (const Unit& u : kUnits)
    if (u.quantity == quantity && u.suffix == unit) return u.factor;
  return std::nullopt;
}

std::string_view printed_unit(std::string_view suffix) {
  for (const Unit& u : kUnits)
    if (u.suffix == suffix) return u.printed;
  return suffix;
}

// "psi_rad" -> the channel psi, factor 1; nothing for a name that is not ours.
std::optional<ColumnsMap::Source> known_column(std::string_view name) {
  for (const ChannelInfo& channel : kChannels)
    for (const Unit& unit : kUnits)
      if (unit.quantity == channel.quantity) {
        const std::string full =
            std::string(channel.name) + (unit.suffix.empty() ? "" : "_" + std::string(unit.suffix));
        if (name == full) return ColumnsMap::Source{channel.channel, unit.factor, std::string(unit.suffix)};
      }
  return std::nullopt;
}

}  // namespace

ColumnsMap read_columns_map(const std::string& name_or_path) {
  const std::string path = find_config("columns", name_or_path);
  const Json json = read_json(path);
  const JsonObject map(json, path);
  ColumnsMap result;
  for (const std::string& key : map.keys()) {
    if (key == "description" || key == "source") {
      map.text(key);
      continue;
    }
    if (key == "missing") {
      result.missing = map.texts(key);
      continue;
    }
    auto source = known_column(key);
    if (!source) map.fail(key, "unknown column name; docs/formats.md lists the names");
    std::string foreign;
    if (map.value(key).is_object()) {
      const JsonObject entry = map.object(key);
      foreign = entry.text("from");
      if (entry.has("unit")) {
        const std::string unit = entry.text("unit");
        const auto factor = factor_of(info(source->channel).quantity, unit);
        if (!factor) {
          std::vector<std::string_view> known;
          for (const Unit& u : kUnits)
            if (u.quantity == info(source->channel).quantity) known.push_back(u.suffix);
          entry.fail("unit", fmt::format("unknown unit '{}'; known: {}", unit, fmt::join(known, ", ")));
        }
        source->factor = *factor;
        source->unit = unit;
      }
      entry.check_all_known();
    } else {
      foreign = map.text(key);
    }
    if (!result.columns.emplace(foreign, *source).second)
      map.fail(key, fmt::format("the column '{}' is already taken by another key", foreign));
  }
  return result;
}

namespace {

// Where a trajectory's values stand in the fields of a row.
struct Fields {
  struct Column {
    std::vector<double>* values;
    std::string_view name;
    double factor;
    std::string unit;
    std::size_t field;
    bool is_angle;
  };
  std::vector<Column> columns;
  std::vector<std::size_t> kept;  // of columns that are unknown
  std::array<std::string, kChannelCount> taken_by;
  std::size_t time = 0;
};

// Finds the columns of the header; those that are unknown go to the trajectory's ignored ones.
Fields find_fields(const CsvReader& csv, const std::string& path, const ColumnsMap* map, bool keep_unknown,
                   Trajectory& trajectory) {
  Fields fields;
  for (std::size_t i = 0; i < csv.header().size(); ++i) {
    const std::string& name = csv.header()[i];
    std::optional<ColumnsMap::Source> source;
    if (map == nullptr) {
      source = known_column(name);
    } else if (const auto found = map->columns.find(name); found != map->columns.end()) {
      source = found->second;
    }
    if (!source) {
      trajectory.ignored_columns.push_back(name);
      if (keep_unknown) fields.kept.push_back(i);
      continue;
    }
    std::string& taken = fields.taken_by[static_cast<std::size_t>(source->channel)];
    if (!taken.empty())
      throw InputError(path, csv.line(), fmt::format("column '{}'", name),
                       fmt::format("holds the same quantity as column '{}'", taken));
    taken = name;
    if (source->channel == Channel::t) fields.time = i;
    fields.columns.push_back({&trajectory[source->channel], name, source->factor, source->unit, i,
                              info(source->channel).quantity == Quantity::angle});
  }
  return fields;
}

// The columns that every trajectory needs, and both of a wind.
void check_columns(const CsvReader& csv, const std::string& path, const ColumnsMap* map, const Fields& fields) {
  const auto foreign_name = [&](Channel channel) {
    if (map != nullptr)
      for (const auto& [foreign, source] : map->columns)
        if (source.channel == channel) return foreign;
    return column_name(channel);
  };
  const auto is_absent = [&](Channel channel) { return fields.taken_by[static_cast<std::size_t>(channel)].empty(); };
  for (const Channel channel : {Channel::t, Channel::u, Channel::vm, Channel::r})
    if (is_absent(channel))
      throw InputError(path, 1, "",
                       fmt::format("no column '{}'; found {}", foreign_name(channel), listed(csv.header())));
  for (const auto& [speed, direction] :
       {std::pair{Channel::wind_speed, Channel::wind_dir}, std::pair{Channel::app_wind_speed, Channel::app_wind_dir}})
    if (is_absent(speed) != is_absent(direction))
      throw InputError(
          path, 1, "",
          fmt::format("column '{}' without '{}': a wind needs both", foreign_name(is_absent(speed) ? direction : speed),
                      foreign_name(is_absent(speed) ? speed : direction)));
}

}  // namespace

Trajectory read_trajectory(const std::string& path, const ColumnsMap* map, bool keep_unknown) {
  CsvReader csv(path);
  Trajectory trajectory;
  trajectory.name = stem(path);
  trajectory.file = path;
  const Fields of = find_fields(csv, path, map, keep_unknown, trajectory);
  check_columns(csv, path, map, of);

  std::vector<double> marks;  // of missing samples that are numbers: however such a number is written
  if (map != nullptr)
    for (const std::string& mark : map->missing)
      if (double value = 0.0; parse_number(mark, value)) marks.push_back(value);
  const auto is_missing = [&](std::string_view field) {
    field = trim(field);
    if (field.empty()) return true;
    if (map == nullptr) return false;
    double value = 0.0;
    return std::find(map->missing.begin(), map->missing.end(), field) != map->missing.end() ||
           (!marks.empty() && parse_number(field, value) &&
            std::find(marks.begin(), marks.end(), value) != marks.end());
  };
  const std::vector<double>& time = trajectory[Channel::t];
  trajectory.ignored_texts.resize(of.kept.size());
  std::vector<std::string_view> fields;
  while (csv.next(fields)) {
    if (is_missing(fields[of.time]) && std::all_of(fields.begin(), fields.end(), is_missing)) continue;
    for (const Fields::Column& column : of.columns) {
      const std::string_view field = fields[column.field];
      double value = kMissing;
      if (!is_missing(field))  // also where the mark of a missing sample is a number
        value = csv.number(field, column.name, printed_unit(column.unit));
      else if (column.field == of.time)
        throw InputError(path, csv.line(), fmt::format("column '{}'", column.name),
                         fmt::format("expected a finite number [{}], got '{}'", printed_unit(column.unit), field));
      column.values->push_back(value * column.factor);
      if (column.is_angle && std::abs(value * column.factor) > kLargestAngle)
        throw InputError(path, csv.line(), fmt::format("column '{}'", column.name),
                         fmt::format("expected an angle within +-{:g} deg, got '{}'", rad_to_deg(kLargestAngle),
                                     field.substr(0, 40)));
    }
    for (std::size_t k = 0; k < of.kept.size(); ++k) trajectory.ignored_texts[k].emplace_back(fields[of.kept[k]]);
    if (std::abs(time.back()) > kFarthestTime_s)
      throw InputError(path, csv.line(), fmt::format("column '{}'", csv.header()[of.time]),
                       fmt::format("expected seconds within +-{} (3,000 years), got {}", kFarthestTime_s, time.back()));
    if (time.size() > 1 && time.back() > time[time.size() - 2] && time.back() - time[time.size() - 2] < kSameTime_s)
      throw InputError(path, csv.line(), fmt::format("column '{}'", csv.header()[of.time]),
                       fmt::format("time must increase by {} s at least, but {} s follows {} s", kSameTime_s,
                                   time.back(), time[time.size() - 2]));
    if (time.size() > 1 && !(time.back() > time[time.size() - 2]))
      throw InputError(path, csv.line(), fmt::format("column '{}'", csv.header()[of.time]),
                       fmt::format("time must increase, but {} s follows {} s", time.back(), time[time.size() - 2]));
    if (time.size() > 1 && time.back() - time[time.size() - 2] > trajectory.longest_step.length_s())
      trajectory.longest_step = {csv.line(), time[time.size() - 2], time.back()};
  }
  if (time.empty()) throw InputError(path, csv.line() + 1, "", "no data row below the header");
  unwrap(trajectory[Channel::psi]);
  for (const ChannelInfo& channel : kChannels)
    if (channel.role == Role::azimuth) unwrap(trajectory[channel.channel]);
  return trajectory;
}

std::string trajectory_text(const Trajectory& trajectory) {
  struct Column {
    const std::vector<double>* values;
    double divisor;
  };
  std::vector<Column> columns;
  std::string text;
  for (const ChannelInfo& channel : kChannels) {
    if (!trajectory.has(channel.channel)) continue;
    text += (columns.empty() ? "" : ",") + column_name(channel.channel);
    columns.push_back({&trajectory[channel.channel], *factor_of(channel.quantity, channel.unit)});
  }
  std::vector<const std::vector<std::string>*> kept;
  for (std::size_t k = 0; k < trajectory.ignored_texts.size(); ++k) {
    const std::string& name = trajectory.ignored_columns[k];
    const auto channel = known_column(name);
    if (channel && trajectory.has(channel->channel)) continue;
    text += ',' + csv_field(name);
    kept.push_back(&trajectory.ignored_texts[k]);
  }
  text += '\n';
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    for (std::size_t c = 0; c < columns.size(); ++c) {
      if (c > 0) text += ',';
      const double value = (*columns[c].values)[i];
      if (std::isinf(value / columns[c].divisor))
        throw NumericalError(fmt::format("{}: a number at {} s is too large to be written",
                                         trajectory.name.empty() ? "the trajectory" : trajectory.name,
                                         trajectory[Channel::t][i]));
      append_number(text, value / columns[c].divisor);
    }
    for (const std::vector<std::string>* texts : kept) text += ',' + csv_field((*texts)[i]);
    text += '\n';
  }
  return text;
}

void write_trajectory(const std::string& path, const Trajectory& trajectory) {
  write_text(path, trajectory_text(trajectory));
}

}  // namespace leeway::io
