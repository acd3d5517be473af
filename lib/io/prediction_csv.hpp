#pragma once

#include <string>
#include <string_view>

#include "core/types.hpp"
#include "io/csv.hpp"
#include "io/files.hpp"

namespace leeway::io {

/// One particle at one step of one sequence.
struct PredictionRow {
  std::string_view recording;
  std::size_t sequence = 0, step = 0;
  double t_s = 0.0;
  std::size_t particle = 0, member = 0;
  Vec3<double> eta = Vec3<double>::Zero();  ///< (x0 [m], y0 [m], psi [rad])
  Vec3<double> nu = Vec3<double>::Zero();   ///< (u, v_m [m/s], r [rad/s])
};

/// Writes a prediction CSV as a stream: memory does not grow with its length.
class PredictionWriter {
 public:
  explicit PredictionWriter(const std::string& path);  ///< "-": standard output
  void write(const PredictionRow& row);
  void commit();

 private:
  void flush();

  OutputFile file_;
  std::string buffer_;
};

/// Reads a prediction CSV row by row ("-": standard input).
class PredictionReader {
 public:
  explicit PredictionReader(const std::string& path);
  /// False at the end. `row.recording` is valid until the next call.
  bool next(PredictionRow& row);
  const CsvReader& csv() const { return csv_; }

 private:
  CsvReader csv_;
  std::size_t index_[12];
  std::vector<std::string_view> fields_;
};

}  // namespace leeway::io
