#include "io/trajectory_csv.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

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

Trajectory read_trajectory(const std::string& path, const ColumnsMap* map, bool keep_unknown) {
  CsvReader csv(path);
  Trajectory trajectory;
  trajectory.name = stem(path);
  trajectory.file = path;

  struct Column {
    std::vector<double>* values;
    std::string_view name;
    double factor;
    std::string unit;
    std::size_t field;
  };
  std::vector<Column> columns;
  std::vector<std::size_t> kept;
  std::array<std::string, kChannelCount> taken_by;
  std::size_t time_field = 0;
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
      if (keep_unknown) kept.push_back(i);
      continue;
    }
    std::string& taken = taken_by[static_cast<std::size_t>(source->channel)];
    if (!taken.empty())
      throw InputError(path, csv.line(), fmt::format("column '{}'", name),
                       fmt::format("holds the same quantity as column '{}'", taken));
    taken = name;
    if (source->channel == Channel::t) time_field = i;
    columns.push_back({&trajectory[source->channel], name, source->factor, source->unit, i});
  }
  const auto foreign_name = [&](Channel channel) {
    if (map != nullptr)
      for (const auto& [foreign, source] : map->columns)
        if (source.channel == channel) return foreign;
    return column_name(channel);
  };
  const auto is_absent = [&](Channel channel) { return taken_by[static_cast<std::size_t>(channel)].empty(); };
  for (const Channel channel : {Channel::t, Channel::u, Channel::vm, Channel::r})
    if (is_absent(channel))
      throw InputError(path, 1, "",
                       fmt::format("no column '{}'; found {}", foreign_name(channel), fmt::join(csv.header(), ", ")));

  for (const auto& [speed, direction] :
       {std::pair{Channel::wind_speed, Channel::wind_dir}, std::pair{Channel::app_wind_speed, Channel::app_wind_dir}})
    if (is_absent(speed) != is_absent(direction))
      throw InputError(
          path, 1, "",
          fmt::format("column '{}' without '{}': a wind needs both", foreign_name(is_absent(speed) ? direction : speed),
                      foreign_name(is_absent(speed) ? speed : direction)));

  const auto is_missing = [&](std::string_view field) {
    if (field.find_first_not_of(" \t") == std::string_view::npos) return true;
    return map != nullptr && std::find(map->missing.begin(), map->missing.end(), field) != map->missing.end();
  };
  const std::vector<double>& time = trajectory[Channel::t];
  trajectory.ignored_texts.resize(kept.size());
  std::vector<std::string_view> fields;
  while (csv.next(fields)) {
    if (is_missing(fields[time_field]) && std::all_of(fields.begin(), fields.end(), is_missing)) continue;
    for (const Column& column : columns) {
      const std::string_view field = fields[column.field];
      double value = 0.0;
      if (!parse_number(field, value)) {
        if (!is_missing(field) || column.field == time_field) csv.number(field, column.name, printed_unit(column.unit));
        value = kMissing;
      }
      column.values->push_back(value * column.factor);
    }
    for (std::size_t k = 0; k < kept.size(); ++k) trajectory.ignored_texts[k].emplace_back(fields[kept[k]]);
    if (time.size() > 1 && !(time.back() > time[time.size() - 2]))
      throw InputError(path, csv.line(), fmt::format("column '{}'", csv.header()[time_field]),
                       fmt::format("time must increase, but {} s follows {} s", time.back(), time[time.size() - 2]));
  }
  if (time.empty()) throw InputError(path, csv.line() + 1, "", "no data row below the header");
  unwrap(trajectory[Channel::psi]);
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
      if (!std::isnan(value)) fmt::format_to(std::back_inserter(text), "{}", value / columns[c].divisor);
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
