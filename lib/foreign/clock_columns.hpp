#pragma once

#include <optional>
#include <string>
#include <vector>

#include "foreign/column_names.hpp"
#include "foreign/raw_table.hpp"
#include "io/columns_map.hpp"

namespace leeway::foreign {

/// The clock of a table.
struct FoundClock {
  std::vector<std::size_t> columns;         ///< one, or date and time
  std::string format;                       ///< of /file/time; empty: numbers
  std::string unit;                         ///< of numbers
  std::optional<double> sample_interval_s;  ///< where no column is a clock, or it was rounded too much
  std::vector<double> t;                    ///< [s], by row
  std::string note;                         ///< what is doubtful; empty: nothing
  double scale = 1.0;                       ///< of numbers, to the unit
  bool is_assumed = false;                  ///< numbers are taken as seconds, and nothing says so
};

/// By the columns' meanings, where they have names; else a column that is linear in the row's number. Nothing where
/// there is none.
std::optional<FoundClock> find_clock(const RawTable& table, const std::vector<NamedColumn>& meanings);

/// Other readings of a clock whose unit is assumed: milliseconds, minutes, hours, days, hhmmss.
std::vector<FoundClock> other_readings(const RawTable& table, const FoundClock& clock);

}  // namespace leeway::foreign
