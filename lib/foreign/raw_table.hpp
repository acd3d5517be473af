#pragma once

#include <string>
#include <vector>

#include "io/csv.hpp"

namespace leeway::foreign {

/// A file as a table of numbers, before anybody knows what they are.
struct RawTable {
  io::CsvForm form;                             ///< how it is read
  std::vector<std::string> names;               ///< of the columns; empty where the file has none
  std::vector<std::string> units;               ///< from a line of units below the names; empty where there is none
  std::vector<std::vector<double>> columns;     ///< NaN where there is no number
  std::vector<std::vector<std::string>> texts;  ///< the fields of columns that hold no numbers
  std::vector<std::string> missing;             ///< texts in columns of numbers

  std::size_t rows() const { return columns.empty() ? 0 : columns.front().size(); }
  bool is_text(std::size_t column) const { return !texts[column].empty(); }
};

/// Finds the form of a file by its first lines and reads its table, 200,000 rows at most. Throws IoError, or InputError
/// where there is no table of two columns or more.
RawTable read_raw_table(const std::string& path);

}  // namespace leeway::foreign
