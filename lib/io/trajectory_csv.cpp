#include "io/trajectory_csv.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "core/errors.hpp"
#include "core/units.hpp"
#include "io/csv.hpp"
#include "io/files.hpp"
#include "recording/differentiation.hpp"
#include "recording/froude_law.hpp"
#include "recording/local_plane.hpp"
#include "recording/velocity_frames.hpp"

namespace leeway::io {
namespace {

// A column of the file, and what becomes of it.
struct ReadColumn {
  std::vector<double>* values;
  Unit unit;
  double factor, offset;
  std::size_t field;
  bool is_latitude = false;
};

constexpr std::array kWinds{std::pair{Channel::wind_speed, Channel::wind_dir},
                            std::pair{Channel::app_wind_speed, Channel::app_wind_dir}};

// Reads the rows of one recording.
class RecordingReader {
 public:
  RecordingReader(const std::string& path, const ColumnsMap* map, bool keep_unknown)
      : map_(map), csv_(path, map != nullptr ? map->form : CsvForm{}) {
    trajectory_.name = stem(path);
    trajectory_.file = path;
    taken_by_.fill(kNoColumn);
    if (map != nullptr) {
      find_mapped_columns(*map);
      if (csv_.form().has_header) find_unnamed_columns(*map);
    } else {
      find_own_columns();
    }
    for (std::size_t i = 0; i < csv_.header().size(); ++i) {
      if (is_used_[i] || !csv_.form().has_header || csv_.header()[i].empty()) continue;
      trajectory_.ignored_columns.push_back(csv_.header()[i]);
      if (keep_unknown) kept_.push_back(i);
    }
    check_columns();
    if (map != nullptr) check_sources(*map);
    find_marks();
  }

  Trajectory read() {
    std::vector<std::string_view> fields;
    trajectory_.ignored_texts.resize(kept_.size());
    for (std::size_t row = 0; csv_.next(fields); ++row) {
      if (!read_time(fields, row)) continue;
      for (const ReadColumn& column : columns_) read_field(column, fields[column.field]);
      for (std::size_t k = 0; k < kept_.size(); ++k) trajectory_.ignored_texts[k].emplace_back(fields[kept_[k]]);
      check_time();
    }
    if (trajectory_.size() == 0) throw InputError(csv_.file(), csv_.line() + 1, "", "no data row below the header");
    for (std::size_t d = 0; d < flags_.size(); ++d)
      trajectory_.is_derived(kDerivableChannels[d].channel) =
          std::any_of(flags_[d].begin(), flags_[d].end(), [](double flag) { return flag != 0.0 && !std::isnan(flag); });
    return std::move(trajectory_);
  }

 private:
  static constexpr std::size_t kNoColumn = static_cast<std::size_t>(-1);

  void take(Channel channel, std::size_t field, const Unit& unit, double factor, double offset) {
    std::size_t& taken = taken_by_[static_cast<std::size_t>(channel)];
    if (taken != kNoColumn)
      throw InputError(csv_.file(), csv_.line(), csv_.column_text(field),
                       fmt::format("holds the same quantity as {}", csv_.column_text(taken)));
    taken = field;
    is_used_[field] = true;
    const ReadColumn column{&trajectory_[channel], unit, factor, offset, field};
    if (channel == Channel::t)
      time_ = column;
    else
      columns_.push_back(column);
  }

  void find_own_columns() {
    is_used_.resize(csv_.header().size());
    for (std::size_t i = 0; i < csv_.header().size(); ++i) {
      const std::string& name = csv_.header()[i];
      if (const auto known = known_column(name)) take(known->channel, i, known->unit, known->unit.factor, 0.0);
      for (std::size_t d = 0; d < flags_.size(); ++d) {
        if (name != kDerivableChannels[d].flag) continue;
        is_used_[i] = true;
        columns_.push_back({&flags_[d], *unit_of(Quantity::ratio, ""), 1.0, 0.0, i});
      }
    }
  }

  // Whether a channel that a map does not name, or names by a column that is not there, may stand in a column of
  // leeway's own name: not where the map says how else it comes about, nor where the file's axes are others than those
  // that the name means.
  bool may_be_unnamed(const ColumnsMap& map, Channel channel) const {
    const ColumnsMap::Source* source = map.source_of(channel);
    if ((source != nullptr && !is_absent(source->from)) || map.derives(channel)) return false;
    switch (channel) {
      case Channel::t:
        return !map.clock && !map.sample_interval_s;
      case Channel::u:
      case Channel::vm:
        return map.velocity_frame == VelocityFrame::ship;
      case Channel::x0:
      case Channel::y0:
        return map.position == PositionForm::plane;
      default:
        return true;
    }
  }

  // The channels that a map leaves out, by leeway's own names. Half a wind is none.
  void find_unnamed_columns(const ColumnsMap& map) {
    const std::vector<std::string>& header = csv_.header();
    std::vector<std::pair<std::size_t, KnownColumn>> unnamed;
    for (std::size_t i = 0; i < header.size(); ++i) {
      const auto known = is_used_[i] ? std::nullopt : known_column(header[i]);
      if (known && may_be_unnamed(map, known->channel)) unnamed.emplace_back(i, *known);
    }
    const auto comes = [&](Channel channel) {
      return has(channel) || std::ranges::any_of(unnamed, [&](const auto& c) { return c.second.channel == channel; });
    };
    for (const auto& wind : kWinds)
      if (comes(wind.first) != comes(wind.second))
        std::erase_if(unnamed,
                      [&](const auto& c) { return c.second.channel == wind.first || c.second.channel == wind.second; });
    for (const auto& [field, column] : unnamed) take(column.channel, field, column.unit, column.unit.factor, 0.0);
    for (std::size_t i = 0; i < header.size(); ++i)
      for (std::size_t d = 0; d < flags_.size(); ++d) {
        const bool is_of_unnamed = std::ranges::any_of(
            unnamed, [&](const auto& c) { return c.second.channel == kDerivableChannels[d].channel; });
        if (is_used_[i] || !is_of_unnamed || header[i] != kDerivableChannels[d].flag) continue;
        is_used_[i] = true;
        columns_.push_back({&flags_[d], *unit_of(Quantity::ratio, ""), 1.0, 0.0, i});
      }
  }

  // The field that a map's column stands in.
  std::size_t field_of(const ColumnReference& from) const {
    const std::vector<std::string>& header = csv_.header();
    if (from.number > header.size())
      throw InputError(csv_.file(), csv_.line(), "",
                       fmt::format("no column {}; found {} columns", from.number, header.size()));
    if (from.number > 0) return from.number - 1;
    if (!csv_.form().has_header)
      throw InputError(
          csv_.file(), csv_.line(), "",
          fmt::format("no column '{}': the map says that the file has no header; give the column's number", from.name));
    const auto found = std::find(header.begin(), header.end(), from.name);
    if (found == header.end())
      throw InputError(csv_.file(), csv_.line(), "",
                       fmt::format("no column '{}'; found {}", from.name, listed(header)));
    if (std::find(found + 1, header.end(), from.name) != header.end())
      throw InputError(csv_.file(), csv_.line(), fmt::format("column '{}'", from.name),
                       "stands twice; give the number of the one that is meant");
    return static_cast<std::size_t>(found - header.begin());
  }

  // Over ground into those along the ship, by the heading.
  static bool turns_velocities(const ColumnsMap& map) {
    return map.velocity_frame != VelocityFrame::ship || map.derives(Channel::u);
  }

  // A map may name more than each of its files has, but not what the others need.
  static bool is_needed(const ColumnsMap& map, Channel channel) {
    const bool is_on_earth = map.position == PositionForm::latitude_longitude;
    switch (channel) {
      case Channel::t:
      case Channel::u:
      case Channel::vm:
      case Channel::r:
        return true;
      case Channel::psi:
        return turns_velocities(map) || map.derives(Channel::r);
      case Channel::x0:
      case Channel::y0:
        return is_on_earth || map.derives(Channel::u);
      default:
        return false;
    }
  }

  bool is_absent(const ColumnReference& from) const {
    const std::vector<std::string>& header = csv_.header();
    return from.number == 0 && csv_.form().has_header &&
           std::find(header.begin(), header.end(), from.name) == header.end();
  }

  void find_mapped_columns(const ColumnsMap& map) {
    is_used_.resize(csv_.header().size());
    for (const ColumnsMap::Source& source : map.columns) {
      if (is_absent(source.from) && !is_needed(map, source.channel)) {
        trajectory_.absent_columns.push_back(source.from.name);
        continue;
      }
      const std::size_t field = field_of(source.from);
      if (is_used_[field])
        throw InputError(csv_.file(), csv_.line(), csv_.column_text(field),
                         "the map names it twice, by its name and by its number");
      take(source.channel, field, source.unit, source.factor, source.offset);
      if (source.channel == Channel::x0) columns_.back().is_latitude = map.position == PositionForm::latitude_longitude;
    }
    if (!map.clock) return;
    clock_.emplace(map.clock->format, map.clock->pattern);
    for (const ColumnReference& from : map.clock->from) {
      clock_fields_.push_back(field_of(from));
      if (is_used_[clock_fields_.back()])
        throw InputError(csv_.file(), csv_.line(), csv_.column_text(clock_fields_.back()),
                         "the map names it twice, as the clock and otherwise");
      is_used_[clock_fields_.back()] = true;
    }
  }

  bool has(Channel channel) const {
    const bool has_clock = map_ != nullptr && (map_->clock || map_->sample_interval_s);
    return taken_by_[static_cast<std::size_t>(channel)] != kNoColumn || (channel == Channel::t && has_clock) ||
           (map_ != nullptr && map_->derives(channel));
  }

  // The columns that every trajectory needs, and both of a wind.
  void check_columns() const {
    for (const Channel channel : {Channel::t, Channel::u, Channel::vm, Channel::r}) {
      if (has(channel)) continue;
      if (map_ != nullptr && channel == Channel::t)
        throw InputError(csv_.file(), csv_.line(), "",
                         "the columns map has no time: neither t_s nor /file/time nor /file/sample_interval_s");
      if (map_ != nullptr)
        throw InputError(
            csv_.file(), csv_.line(), "",
            fmt::format("the columns map has no {0}; name its column, or write \"{0}\": {{\"derive\": \"{1}\"}}",
                        column_name(channel), derived_from(channel)));
      throw InputError(csv_.file(), 1, "",
                       fmt::format("no column '{}'; found {}", column_name(channel), listed(csv_.header())));
    }
    for (const auto& [speed, direction] : kWinds)
      if (has(speed) != has(direction))
        throw InputError(
            csv_.file(), 1, "",
            fmt::format("column '{}' without '{}': a wind needs both", column_name(has(speed) ? speed : direction),
                        column_name(has(speed) ? direction : speed)));
  }

  // What derived channels and other axes are computed from.
  void check_sources(const ColumnsMap& map) const {
    for (const ColumnsMap::Derivation& derivation : map.derived)
      if (!has(derivation.of))
        throw InputError(csv_.file(), csv_.line(), "",
                         fmt::format("{} is derived from {}, which neither the columns map nor the file has",
                                     column_name(derivation.channel), column_name(derivation.of)));
    if (turns_velocities(map) && !has(Channel::psi))
      throw InputError(
          csv_.file(), csv_.line(), "",
          "neither the columns map nor the file has psi_deg: the heading turns velocities over ground into "
          "those along the ship");
  }

  static std::string derived_from(Channel channel) {
    for (const DerivableChannel& derivable : kDerivableChannels)
      if (derivable.channel == channel) return column_name(derivable.of);
    return "";
  }

  // Marks of missing samples that are numbers hold however such a number is written.
  void find_marks() {
    if (map_ == nullptr) return;
    for (const std::string& mark : map_->missing)
      if (double value = 0.0; csv_.is_number(mark, value) || parse_number(mark, value)) marks_.push_back(value);
  }

  bool is_missing(std::string_view field) const {
    field = trim(field);
    if (field.empty()) return true;
    if (map_ == nullptr) return false;
    double value = 0.0;
    return std::find(map_->missing.begin(), map_->missing.end(), field) != map_->missing.end() ||
           (!marks_.empty() && csv_.is_number(field, value) && is_mark(value));
  }
  bool is_mark(double value) const { return std::find(marks_.begin(), marks_.end(), value) != marks_.end(); }

  [[noreturn]] void fail(std::size_t field, const std::string& problem) const {
    throw InputError(csv_.file(), csv_.line(), csv_.column_text(field), problem);
  }

  [[noreturn]] void fail_number(const ReadColumn& column, std::string_view text) const {
    fail(column.field, fmt::format("expected a finite number{}{}, got '{}'",
                                   column.unit.printed.empty() ? "" : fmt::format(" [{}]", column.unit.printed),
                                   csv_.form().decimal_comma ? " with a decimal comma" : "", text.substr(0, 40)));
  }

  // False for a row that is passed over.
  bool read_time(const std::vector<std::string_view>& fields, std::size_t row) {
    const auto is_empty_row = [&] {
      return std::all_of(fields.begin(), fields.end(), [&](std::string_view field) { return is_missing(field); });
    };
    std::vector<double>& time = trajectory_[Channel::t];
    if (map_ != nullptr && map_->sample_interval_s) {
      if (is_missing(fields.front()) && is_empty_row()) return false;
      time.push_back(static_cast<double>(row) * *map_->sample_interval_s);
      return true;
    }
    if (clock_) {
      if (is_missing(fields[clock_fields_.front()]) && is_empty_row()) return false;
      time.push_back(read_clock(fields));
      return true;
    }
    const std::string_view field = fields[time_.field];
    double value = 0.0;
    if (!csv_.is_number(field, value) || is_mark(value)) {
      if (is_missing(field) && is_empty_row()) return false;
      fail_number(time_, field);
    }
    time.push_back(converted(time_, value));
    return true;
  }

  double read_clock(const std::vector<std::string_view>& fields) {
    std::string_view text = trim(fields[clock_fields_.front()]);
    if (clock_fields_.size() > 1) {
      clock_text_.assign(text);
      clock_text_ += ' ';
      clock_text_ += trim(fields[clock_fields_[1]]);
      text = clock_text_;
    }
    const auto seconds = clock_->seconds(text);
    if (!seconds)
      fail(clock_fields_.front(), fmt::format("expected {}, got '{}'", clock_->expected(), text.substr(0, 60)));
    return *seconds;
  }

  static double converted(const ReadColumn& column, double value) {
    const bool is_as_it_stands = column.offset == 0.0 && column.factor > 0.0;  // the sum makes 0 of -0
    return is_as_it_stands ? value * column.factor : value * column.factor + column.offset;
  }

  void read_field(const ReadColumn& column, std::string_view field) {
    double value = 0.0;
    if (!csv_.is_number(field, value) || (!marks_.empty() && is_mark(value))) {
      if (!is_missing(field)) fail_number(column, field);
      column.values->push_back(kMissing);
      return;
    }
    const double si = converted(column, value);
    column.values->push_back(si);
    if (column.unit.quantity != Quantity::angle) return;
    const double largest = column.is_latitude ? kPi / 2.0 : kLargestAngle;
    if (std::abs(si) > largest * (1.0 + 1e-12))
      fail(column.field,
           fmt::format("expected {} within +-{:g} deg, got '{}'", column.is_latitude ? "a latitude" : "an angle",
                       rad_to_deg(largest), field.substr(0, 40)));
  }

  void check_time() {
    const std::vector<double>& time = trajectory_[Channel::t];
    const std::size_t field = clock_ ? clock_fields_.front() : time_.field;
    const double now = time.back();
    if (std::abs(now) > kFarthestTime_s)
      fail(field, fmt::format("expected seconds within +-{} (3,000 years), got {}", kFarthestTime_s, now));
    if (time.size() == 1) return;
    const double before = time[time.size() - 2];
    if (now > before && now - before < kSameTime_s)
      fail(field, fmt::format("time must increase by {} s at least, but {} s follows {} s", kSameTime_s, now, before));
    if (!(now > before)) fail(field, fmt::format("time must increase, but {} s follows {} s", now, before));
    if (now - before > trajectory_.longest_step.length_s()) trajectory_.longest_step = {csv_.line(), before, now};
  }

  const ColumnsMap* map_;
  CsvReader csv_;
  Trajectory trajectory_;
  ReadColumn time_{};
  std::vector<ReadColumn> columns_;
  std::array<std::vector<double>, kDerivableChannels.size()> flags_;
  std::vector<std::size_t> kept_;  // of columns that are unknown
  std::vector<bool> is_used_;
  std::array<std::size_t, kChannelCount> taken_by_{};
  std::optional<ClockReader> clock_;
  std::vector<std::size_t> clock_fields_;
  std::string clock_text_;
  std::vector<double> marks_;
};

// From what a file has to leeway's channels, in the order in which one needs the other.
void convert_as(const ColumnsMap& map, Trajectory& trajectory) {
  std::vector<double>&x0 = trajectory[Channel::x0], &y0 = trajectory[Channel::y0], &psi = trajectory[Channel::psi];
  if (map.position == PositionForm::latitude_longitude && !x0.empty()) lay_on_plane(x0, y0);
  if (map.velocity_frame == VelocityFrame::earth)
    turn_into_ship_axes(trajectory[Channel::u], trajectory[Channel::vm], psi);
  else if (map.velocity_frame == VelocityFrame::course_and_speed)
    resolve_course(trajectory[Channel::u], trajectory[Channel::vm], psi);
  if (map.scale_factor != 1.0) {
    const FroudeLaw scale(map.scale_factor);
    trajectory = scaled_down(trajectory, scale);
    trajectory.longest_step.from_s /= scale.time;
    trajectory.longest_step.to_s /= scale.time;
  }
}

void derive_channels(const ColumnsMap& map, Trajectory& trajectory) {
  for (const ColumnsMap::Derivation& derivation : map.derived) {
    trajectory[derivation.channel] = derivative(trajectory[Channel::t], trajectory[derivation.of], derivation.window_s);
    trajectory.is_derived(derivation.channel) = true;
  }
  if (map.derives(Channel::u))
    turn_into_ship_axes(trajectory[Channel::u], trajectory[Channel::vm], trajectory[Channel::psi]);
}

}  // namespace

std::optional<std::string> unread_columns(const std::set<std::string>& ignored, const std::set<std::string>& absent) {
  const auto names = [](const std::set<std::string>& of) {
    return listed(std::vector<std::string>(of.begin(), of.end()));
  };
  if (ignored.empty()) return std::nullopt;
  return fmt::format(
      "columns that no tool knows are ignored: {}{}", names(ignored),
      absent.empty() ? "" : fmt::format("; the columns map names columns that are not there: {}", names(absent)));
}

Trajectory read_trajectory(const std::string& path, const ColumnsMap* map, bool keep_unknown) {
  Trajectory trajectory = RecordingReader(path, map, keep_unknown).read();
  unwrap(trajectory[Channel::psi]);
  for (const ChannelInfo& channel : kChannels)
    if (channel.role == Role::azimuth) unwrap(trajectory[channel.channel]);
  if (map == nullptr) return trajectory;
  convert_as(*map, trajectory);
  derive_channels(*map, trajectory);
  return trajectory;
}

namespace {

bool is_flag(std::string_view name) {
  return std::any_of(kDerivableChannels.begin(), kDerivableChannels.end(),
                     [&](const DerivableChannel& derivable) { return name == derivable.flag; });
}

}  // namespace

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
    columns.push_back({&trajectory[channel.channel], unit_of(channel.quantity, channel.unit)->factor});
  }
  std::string flags;  // the same in each row
  for (const DerivableChannel& derivable : kDerivableChannels) {
    if (!trajectory.has(derivable.channel) || !trajectory.is_derived(derivable.channel)) continue;
    text += fmt::format(",{}", derivable.flag);
    flags += ",1";
  }
  std::vector<const std::vector<std::string>*> kept;
  for (std::size_t k = 0; k < trajectory.ignored_texts.size(); ++k) {
    const std::string& name = trajectory.ignored_columns[k];
    const auto channel = known_column(name);
    if ((channel && trajectory.has(channel->channel)) || is_flag(name)) continue;
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
    text += flags;
    for (const std::vector<std::string>* texts : kept) text += ',' + csv_field((*texts)[i]);
    text += '\n';
  }
  return text;
}

void write_trajectory(const std::string& path, const Trajectory& trajectory) {
  write_text(path, trajectory_text(trajectory));
}

}  // namespace leeway::io
