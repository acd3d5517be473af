#include "io/prediction_csv.hpp"

#include <cmath>
#include <iterator>

#include <fmt/format.h>

#include "core/errors.hpp"
#include "core/units.hpp"

namespace leeway::io {
namespace {

constexpr const char* kColumns[] = {"recording", "sequence", "step",    "t_s",   "particle", "member",
                                    "x0_m",      "y0_m",     "psi_deg", "u_mps", "vm_mps",   "r_degps"};
constexpr std::size_t kFlushAt = 1 << 18;

}  // namespace

PredictionWriter::PredictionWriter(const std::string& path) : file_(path) {
  for (const char* column : kColumns) buffer_ += (buffer_.empty() ? "" : ",") + std::string(column);
  buffer_ += '\n';
}

void PredictionWriter::write(const PredictionRow& row) {
  const Vec3<double> eta(row.eta(0), row.eta(1), rad_to_deg(row.eta(2))),
      nu(row.nu(0), row.nu(1), rad_to_deg(row.nu(2)));
  if (!std::isfinite(row.t_s) || !eta.allFinite() || !nu.allFinite())
    throw NumericalError(fmt::format("recording '{}', sequence {}, step {}: the prediction is no finite number",
                                     row.recording, row.sequence, row.step));
  buffer_ += csv_field(row.recording);
  fmt::format_to(std::back_inserter(buffer_), ",{},{},{},{},{},{},{},{},{},{},{}\n", row.sequence, row.step, row.t_s,
                 row.particle, row.member, eta(0), eta(1), eta(2), nu(0), nu(1), nu(2));
  if (buffer_.size() > kFlushAt) flush();
}

void PredictionWriter::flush() {
  file_.write(buffer_);
  buffer_.clear();
}

void PredictionWriter::commit() {
  flush();
  file_.commit();
}

PredictionReader::PredictionReader(const std::string& path) : csv_(path) {
  for (std::size_t i = 0; i < std::size(kColumns); ++i) index_[i] = csv_.column(kColumns[i]);
}

bool PredictionReader::next(PredictionRow& row) {
  if (!csv_.next(fields_)) return false;
  const auto count = [&](std::size_t i) { return csv_.count(fields_[index_[i]], kColumns[i]); };
  const auto number = [&](std::size_t i, const char* unit) {
    return csv_.number(fields_[index_[i]], kColumns[i], unit);
  };
  row.recording = fields_[index_[0]];
  row.sequence = count(1);
  row.step = count(2);
  row.t_s = number(3, "s");
  if (std::abs(row.t_s) > kFarthestTime_s)
    throw InputError(csv_.file(), csv_.line(), "column 't_s'",
                     fmt::format("expected seconds within +-{} (3,000 years), got {}", kFarthestTime_s, row.t_s));
  row.particle = count(4);
  row.member = count(5);
  row.eta = {number(6, "m"), number(7, "m"), deg_to_rad(number(8, "deg"))};
  if (std::abs(row.eta(2)) > kLargestAngle)
    throw InputError(
        csv_.file(), csv_.line(), "column 'psi_deg'",
        fmt::format("expected an angle within +-{:g} deg, got {}", rad_to_deg(kLargestAngle), rad_to_deg(row.eta(2))));
  row.nu = {number(9, "m/s"), number(10, "m/s"), deg_to_rad(number(11, "deg/s"))};
  return true;
}

}  // namespace leeway::io
