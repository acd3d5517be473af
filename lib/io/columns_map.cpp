#include "io/columns_map.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "core/similar_words.hpp"
#include "io/files.hpp"
#include "io/json.hpp"

namespace leeway::io {
namespace {

constexpr Bounds kScales{1e-12, 1e12}, kSkippedLines{0.0, 1e6}, kIntervals_s{1e-6, 1e6}, kScaleFactors{1e-4, 1e4};
constexpr double kMostColumns = 1e6;

// The columns under other names, of what the file's frame and position make of them.
struct FrameName {
  std::string_view name;
  Channel channel;
  Quantity quantity;
};
constexpr FrameName kCourseNames[] = {{"speed", Channel::u, Quantity::speed}, {"course", Channel::vm, Quantity::angle}};
constexpr FrameName kPositionNames[] = {{"latitude", Channel::x0, Quantity::angle},
                                        {"longitude", Channel::y0, Quantity::angle}};

ColumnReference reference(const Json& value, const JsonObject& of, const std::string& key) {
  if (value.is_string() && !value.get<std::string>().empty()) return {value.get<std::string>(), 0};
  const bool is_whole = value.is_number_integer() && value >= 1 && value <= kMostColumns;
  if (!is_whole) of.fail(key, fmt::format("expected a column's name or its number from 1, got {}", value.dump()));
  return {"", value.get<std::size_t>()};
}

void read_clock(const JsonObject& file, ColumnsMap& map) {
  const auto time = file.object_if("time");
  if (!time) return;
  ClockColumns clock;
  const Json& from = time->value("from");
  if (from.is_array()) {
    for (const Json& column : from) clock.from.push_back(reference(column, *time, "from"));
  } else {
    clock.from.push_back(reference(from, *time, "from"));
  }
  if (clock.from.empty() || clock.from.size() > 2)
    time->fail("from", fmt::format("expected one or two columns, got {}", clock.from.size()));
  if (clock.from.size() == 2 && clock.from[0] == clock.from[1])
    time->fail("from", fmt::format("the column {} stands twice", clock.from[0].text()));
  const std::string format = time->text("format");
  clock.format = format == "iso8601" ? ClockFormat::iso8601
                 : format == "epoch" ? ClockFormat::epoch
                 : format == "hms"   ? ClockFormat::hms
                                     : ClockFormat::pattern;
  if (clock.format == ClockFormat::pattern) clock.pattern = format;
  if (clock.format == ClockFormat::pattern && !is_clock_pattern(format))
    time->fail("format",
               fmt::format("expected iso8601, epoch, hms or a pattern such as '%d.%m.%Y %H:%M:%S', got '{}'", format));
  if (clock.from.size() == 2 && (clock.format == ClockFormat::epoch || clock.format == ClockFormat::hms))
    time->fail("from", fmt::format("a time of the format {} stands in one column, got two", format));
  time->check_all_known();
  map.clock = std::move(clock);
}

void read_form(const JsonObject& file, CsvForm& form) {
  if (file.has("delimiter")) {
    const std::string word = file.word("delimiter", {",", ";", "tab", "blank"});
    form.delimiter = word == "tab" ? '\t' : word == "blank" ? CsvForm::kBlank : word[0];
  }
  if (file.has("decimal")) form.decimal_comma = file.word("decimal", {".", ","}) == ",";
  if (form.decimal_comma && form.delimiter == ',')
    file.fail("decimal", "a decimal comma needs another delimiter: \"delimiter\": \";\", \"tab\" or \"blank\"");
  form.skip_lines = static_cast<std::size_t>(file.integer_or("skip_lines", 0, kSkippedLines));
  form.has_header = file.flag_or("header", true);
  if (file.has("encoding"))
    form.encoding = file.word("encoding", {"utf-8", "latin-1"}) == "latin-1" ? Encoding::latin1 : Encoding::utf8;
}

void read_file(const JsonObject& map_json, ColumnsMap& map) {
  const auto file = map_json.object_if("file");
  if (!file) return;
  read_form(*file, map.form);
  if (file->has("sample_interval_s")) map.sample_interval_s = file->number("sample_interval_s", kIntervals_s);
  read_clock(*file, map);
  if (map.clock && map.sample_interval_s)
    file->fail("sample_interval_s", "stands beside \"time\"; expected one of the two");
  if (file->has("velocity_frame")) {
    const std::string word = file->word("velocity_frame", {"ship", "earth", "course-and-speed"});
    map.velocity_frame = word == "ship"    ? VelocityFrame::ship
                         : word == "earth" ? VelocityFrame::earth
                                           : VelocityFrame::course_and_speed;
  }
  if (file->has("position") && file->word("position", {"plane", "latitude-longitude"}) != "plane")
    map.position = PositionForm::latitude_longitude;
  map.scale_factor = file->number_or("scale_factor", 1.0, kScaleFactors);
  file->check_all_known();
}

std::vector<std::string> own_names() {
  std::vector<std::string> names;
  names.reserve(kChannelCount);
  for (std::size_t c = 0; c < kChannelCount; ++c) names.push_back(column_name(static_cast<Channel>(c)));
  return names;
}

// What a key names: a column of leeway's form, or of the file's frame.
std::optional<KnownColumn> meaning_of(const std::string& key, const ColumnsMap& map) {
  const auto among = [&](auto& names) -> std::optional<KnownColumn> {
    for (const FrameName& name : names)
      for (const std::string_view suffix : units_of(name.quantity))
        if (key == fmt::format("{}_{}", name.name, suffix))
          return KnownColumn{name.channel, *unit_of(name.quantity, suffix)};
    return std::nullopt;
  };
  if (map.velocity_frame == VelocityFrame::course_and_speed)
    if (const auto column = among(kCourseNames)) return column;
  if (map.position == PositionForm::latitude_longitude)
    if (const auto column = among(kPositionNames)) return column;
  auto column = known_column(key);
  if (!column) return std::nullopt;
  // vm_mps and x0_m, y0_m may name a course and a position on the earth as well: these are angles, in degrees.
  const bool is_course = map.velocity_frame == VelocityFrame::course_and_speed && column->channel == Channel::vm;
  const bool is_on_earth = map.position == PositionForm::latitude_longitude &&
                           (column->channel == Channel::x0 || column->channel == Channel::y0);
  if (is_course || is_on_earth) column->unit = *unit_of(Quantity::angle, "deg");
  return column;
}

void fail_unit(const JsonObject& entry, const std::string& unit, Quantity quantity) {
  std::string known = fmt::format("{}", fmt::join(units_of(quantity), ", "));
  if (const std::string_view other = quantity_measured_in(unit); !other.empty())
    entry.fail("unit",
               fmt::format("'{}' is a unit of {}, expected one of {}: {}", unit, other, described(quantity), known));
  entry.fail("unit", fmt::format("unknown unit '{}'; known: {}", unit, known));
}

void read_source(const JsonObject& entry, const KnownColumn& column, ColumnsMap& map) {
  if (!entry.has("from")) entry.text("from");  // throws
  ColumnsMap::Source source{column.channel, reference(entry.value("from"), entry, "from"), column.unit};
  if (entry.has("unit")) {
    const std::string unit = entry.text("unit");
    const auto known = unit_of(column.unit.quantity, unit);
    if (!known) fail_unit(entry, unit, column.unit.quantity);
    source.unit = *known;
  }
  double scale = 1.0;
  if (entry.has("scale")) {
    scale = entry.number("scale");
    if (std::abs(scale) < kScales.low || std::abs(scale) > kScales.high)
      entry.fail("scale", fmt::format("expected a number from {:g} to {:g}, or the same negative, got {}", kScales.low,
                                      kScales.high, scale));
  }
  if (entry.has("sign")) {
    const double sign = entry.number("sign");
    if (std::abs(sign) != 1.0) entry.fail("sign", fmt::format("expected 1 or -1, got {}", sign));
    scale *= sign;
  }
  source.factor = source.unit.factor * scale;
  source.offset = source.unit.factor * entry.number_or("offset", 0.0, {-1e12, 1e12});
  entry.check_all_known();
  map.columns.push_back(std::move(source));
}

void read_derivation(const JsonObject& entry, Channel channel, ColumnsMap& map) {
  const std::string of = entry.text("derive");
  const auto* const derivable = std::find_if(kDerivableChannels.begin(), kDerivableChannels.end(),
                                             [&](const DerivableChannel& d) { return d.channel == channel; });
  const auto column = known_column(of);
  if (derivable == kDerivableChannels.end() || !column || column->channel != derivable->of)
    entry.fail("derive", fmt::format("expected u_mps derived from x0_m, vm_mps from y0_m or r_degps from psi_deg, got "
                                     "{} from '{}'",
                                     column_name(channel), of));
  map.derived.push_back({channel, derivable->of, entry.number_or("window_s", 0.0, kNotNegative)});
  entry.check_all_known();
}

// Refuses a column that the map names twice, and a channel.
void check_twice(const JsonObject& json, const std::string& key, const ColumnsMap& map,
                 const std::vector<std::string>& keys) {
  const ColumnsMap::Source& last = map.columns.back();
  for (std::size_t i = 0; i + 1 < map.columns.size(); ++i) {
    if (map.columns[i].from == last.from)
      json.fail(key, fmt::format("the column {} is already taken by '{}'", last.from.text(), keys[i]));
    if (map.columns[i].channel == last.channel)
      json.fail(key, fmt::format("'{}' is already given by the column {}", info(last.channel).name,
                                 map.columns[i].from.text()));
  }
  if (map.clock && std::find(map.clock->from.begin(), map.clock->from.end(), last.from) != map.clock->from.end())
    json.fail(key, fmt::format("the column {} is already taken by /file/time", last.from.text()));
}

void check_clocks(const JsonObject& json, const ColumnsMap& map) {
  if (map.source_of(Channel::t) == nullptr) return;
  if (map.clock) json.fail("t_s", "stands beside /file/time; expected one of the two");
  if (map.sample_interval_s) json.fail("t_s", "stands beside /file/sample_interval_s; expected one of the two");
}

// What the frame, the position and derived channels need. A file with a header may have it under leeway's own name, so
// that whoever reads it looks for it.
void check_complete(const JsonObject& json, const ColumnsMap& map) {
  const auto is_there = [&](Channel channel) { return map.source_of(channel) != nullptr; };
  for (const ColumnsMap::Derivation& derivation : map.derived) {
    const std::string key = column_name(derivation.channel);
    if (is_there(derivation.channel)) json.fail(key, "is derived and has a column as well; expected one of the two");
    if (!is_there(derivation.of) && !map.form.has_header)
      json.fail(key, fmt::format("is derived from {}, which has no column", column_name(derivation.of)));
  }
  const bool derives_velocity = map.derives(Channel::u) || map.derives(Channel::vm);
  if (derives_velocity && map.derives(Channel::u) != map.derives(Channel::vm))
    json.fail(map.derives(Channel::u) ? "u_mps" : "vm_mps",
              "u_mps and vm_mps are derived both or not at all: a position's derivative has the earth's axes");
  if ((derives_velocity || map.velocity_frame != VelocityFrame::ship) && !is_there(Channel::psi) &&
      !map.form.has_header)
    json.fail("psi_deg", "missing: the heading turns velocities over ground into those along the ship");
  if (map.position == PositionForm::latitude_longitude && is_there(Channel::x0) != is_there(Channel::y0))
    json.fail(is_there(Channel::x0) ? "longitude_deg" : "latitude_deg", "missing: a position has both");
}

}  // namespace

std::string ColumnReference::text() const { return number > 0 ? fmt::format("{}", number) : "'" + name + "'"; }

const ColumnsMap::Source* ColumnsMap::source_of(Channel channel) const {
  const auto found =
      std::find_if(columns.begin(), columns.end(), [&](const Source& s) { return s.channel == channel; });
  return found == columns.end() ? nullptr : &*found;
}

bool ColumnsMap::derives(Channel channel) const {
  return std::any_of(derived.begin(), derived.end(), [&](const Derivation& d) { return d.channel == channel; });
}

ColumnsMap read_columns_map(const std::string& name_or_path) {
  const std::string path = find_config("columns", name_or_path);
  return columns_map_of(read_json(path), path);
}

ColumnsMap columns_map_of(const Json& json, const std::string& name) {
  const JsonObject object(json, name);
  ColumnsMap map;
  std::vector<std::string> keys;  // of the columns
  read_file(object, map);
  for (const std::string& key : object.keys()) {
    if (key == "file") continue;
    if (key == "description" || key == "source") {
      object.text(key);
      continue;
    }
    if (key == "missing" || key == "notes") {
      const std::vector<std::string> texts = object.texts(key);
      if (key == "missing") map.missing = texts;
      continue;
    }
    const auto column = meaning_of(key, map);
    if (!column)
      object.fail(key, "unknown column name; docs/formats.md lists the names" + did_you_mean(key, own_names()));
    if (!object.value(key).is_object()) {
      if (const Json& value = object.value(key); !value.is_string())
        object.fail(key,
                    fmt::format("expected a column's name, or {{\"from\": 5}} with its number, got {}", value.dump()));
      map.columns.push_back({column->channel, {object.text(key), 0}, column->unit, column->unit.factor});
    } else {
      const JsonObject entry = object.object(key);
      if (entry.has("derive")) {
        if (map.derives(column->channel)) object.fail(key, "is derived twice");
        read_derivation(entry, column->channel, map);
        continue;
      }
      read_source(entry, *column, map);
    }
    keys.push_back(key);
    check_twice(object, key, map, keys);
  }
  check_clocks(object, map);
  check_complete(object, map);
  return map;
}

}  // namespace leeway::io
