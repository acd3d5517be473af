#pragma once

#include <optional>
#include <string>
#include <vector>

#include "io/channel_units.hpp"
#include "io/clock_time.hpp"
#include "io/csv.hpp"
#include "io/json.hpp"

namespace leeway::io {

/// Which column of a file is meant.
struct ColumnReference {
  std::string name;
  std::size_t number = 0;  ///< from 1; 0: by the name

  std::string text() const;  ///< "'u'", "5", in messages
  friend bool operator==(const ColumnReference&, const ColumnReference&) = default;
};

/// What the two velocities of a file are: along ship axes, along x0 and y0, or speed and course over ground.
enum class VelocityFrame { ship, earth, course_and_speed };
/// What the two columns of a position are.
enum class PositionForm { plane, latitude_longitude };

/// Clock times in place of t_s.
struct ClockColumns {
  std::vector<ColumnReference> from;  ///< one, or two that are joined by a blank
  ClockFormat format = ClockFormat::iso8601;
  std::string pattern;
};

/// How a foreign recording is read: a columns map as in docs/formats.md.
struct ColumnsMap {
  /// A column that is read: value = factor * number + offset.
  struct Source {
    Channel channel;
    ColumnReference from;
    Unit unit;
    double factor = 1.0;  ///< to SI, with scale and sign
    double offset = 0.0;  ///< [SI]
  };
  /// A channel that is computed by differentiation of another one.
  struct Derivation {
    Channel channel, of;
    double window_s = 0.0;  ///< 0: the narrowest
  };

  std::vector<Source> columns;
  std::vector<Derivation> derived;
  std::vector<std::string> missing;  ///< texts that mark a missing sample, besides the empty field
  CsvForm form{.is_foreign = true};
  std::optional<double> sample_interval_s;
  std::optional<ClockColumns> clock;
  VelocityFrame velocity_frame = VelocityFrame::ship;
  PositionForm position = PositionForm::plane;
  double scale_factor = 1.0;  ///< length of the file's ship by that of the wanted one

  const Source* source_of(Channel channel) const;
  bool derives(Channel channel) const;
};

/// Reads a columns map: a path, or the name of a shipped one such as "frt-ds-esso".
ColumnsMap read_columns_map(const std::string& name_or_path);
/// The same of a map that stands in no file; messages name it so.
ColumnsMap columns_map_of(const Json& json, const std::string& name);

}  // namespace leeway::io
