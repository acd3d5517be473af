#include <algorithm>
#include <cmath>
#include <filesystem>
#include <vector>

#include <catch2/catch.hpp>

#include "core/units.hpp"
#include "dynamics/replay.hpp"
#include "gap/sensors/audit.hpp"
#include "io/files.hpp"
#include "io/trajectory_csv.hpp"
#include "recording/samples.hpp"
#include "temporary_folder.hpp"

using namespace leeway;
namespace fs = std::filesystem;

TEST_CASE("esso-osaka-3m: replayed random tests stay close to the recorded velocities", "[published]") {
  const fs::path folder = LEEWAY_SHARED_FOLDER "/real/esso-osaka/random";
  if (!fs::exists(folder)) {
    WARN("SKIPPED: no " << folder.string());
    return;
  }
  const Ship ship = read_ship("esso-osaka-3m");
  const io::ColumnsMap map = io::read_columns_map("frt-ds-esso");
  const TimeGrid grid{0.1, 1.0, 1.0};
  std::vector<Vec3<double>> rms_of_segments;
  std::vector<fs::path> files(fs::directory_iterator(folder), fs::directory_iterator{});
  std::sort(files.begin(), files.end());
  for (const fs::path& file : files) {
    const Trajectory recording = io::read_trajectory(file.string(), &map);
    const RecordedInputs inputs(recording, ship, InputInterpolation::linear);
    const test::TemporaryFolder temporary;
    const std::string path = temporary / "prediction.csv";
    {
      io::PredictionWriter writer(path);
      replay_sequences(ship, recording, inputs, grid, 101, writer);
      writer.commit();
    }
    const std::vector<Samples> stretches = resample(recording, inputs.channels(), true, 1.0);
    REQUIRE(stretches.size() == 1);
    const Samples& truth = stretches[0];
    io::PredictionReader reader(path);
    io::PredictionRow row;
    Vec3<double> sum = Vec3<double>::Zero();
    while (reader.next(row)) {
      const auto k = static_cast<Eigen::Index>(std::llround(row.t_s - truth.t0_s));
      sum += (row.nu - truth.nu.col(k)).cwiseAbs2();
      if (row.step < 100) continue;
      rms_of_segments.push_back((sum / 100.0).cwiseSqrt());
      sum.setZero();
    }
  }
  REQUIRE(rms_of_segments.size() == 27);
  Vec3<double> mean = Vec3<double>::Zero();
  for (const Vec3<double>& rms : rms_of_segments) mean += rms / static_cast<double>(rms_of_segments.size());
  // Another simulator with these coefficients is stated to reach 0.016, 0.011 m/s and 0.39 deg/s on a random test, so
  // 25 % more is the limit; ours has 0.014, 0.012 m/s and 0.40 deg/s.
  CHECK(mean(0) < 1.25 * 0.016);
  CHECK(mean(1) < 1.25 * 0.011);
  CHECK(mean(2) < 1.25 * 0.39 * kDegree);
}

// All channels but the positions have passed a filter there; noise that still holds the other fault hid each.
TEST_CASE("audit: in recordings of a real model, a heading turned by 3 deg is found beside their filter",
          "[published][long]") {
  const fs::path folder = LEEWAY_SHARED_FOLDER "/real/esso-osaka";
  if (!fs::exists(folder)) {
    WARN("SKIPPED: no " << folder.string());
    return;
  }
  const io::ColumnsMap map = io::read_columns_map("frt-ds-esso");
  std::vector<Trajectory> recordings;
  for (const char* const name : {"zigzag/zigzag_31-Jul-2020_13_04_24", "zigzag/zigzag_31-Jul-2020_13_29_19",
                                 "zigzag/zigzag_31-Jul-2020_13_50_28", "turning/turn_14-Sep-2020_14_50_41"}) {
    Trajectory recording = io::read_trajectory((folder / name).string() + ".csv", &map);
    for (std::vector<double>& column : recording.columns) {
      std::vector<double> kept;
      for (std::size_t k = 0; k < column.size(); k += 2) kept.push_back(column[k]);
      column = std::move(kept);
    }
    for (double& psi : recording[Channel::psi]) psi += 3.0 * kDegree;
    recordings.push_back(std::move(recording));
  }
  gap::AuditOptions options;
  options.false_alarm = 1e-3;
  const gap::Audit audit = gap::audit(recordings, options);
  const auto bias = std::find_if(audit.faults.begin(), audit.faults.end(),
                                 [](const gap::Fault& fault) { return fault.name == "heading-bias"; });
  for (const std::string& notice : audit.notices) UNSCOPED_INFO(notice);
  for (const gap::Fault& h : audit.hypotheses) UNSCOPED_INFO(h.sentence << " p " << h.p_value);
  REQUIRE(bias != audit.faults.end());
  CHECK(bias->parameters[0].value == Approx(3.0).margin(0.1));
}
