#include "io/trajectory_csv.hpp"

#include <cmath>
#include <filesystem>

#include <catch2/catch.hpp>

#include "core/errors.hpp"
#include "core/random.hpp"
#include "core/units.hpp"
#include "temporary_folder.hpp"

using namespace leeway;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinRel;

namespace {

Trajectory random_trajectory(std::size_t n) {
  RandomStream stream(6, "trajectory");
  Trajectory trajectory;
  for (const ChannelInfo& channel : kChannels)
    for (std::size_t i = 0; i < n; ++i) trajectory[channel.channel].push_back(stream.uniform(-3.0, 3.0));
  for (std::size_t i = 0; i < n; ++i) trajectory[Channel::t][i] = 0.1 * static_cast<double>(i);
  for (const Channel unwrapped : {Channel::psi, Channel::az1, Channel::az2})
    for (std::size_t i = 0; i < n; ++i) trajectory[unwrapped][i] = 0.02 * static_cast<double>(i);
  return trajectory;
}

Trajectory read_text(const test::TemporaryFolder& folder, const std::string& text) {
  return io::read_trajectory(folder.write("rec.csv", text));
}

}  // namespace

TEST_CASE("trajectory: what is written comes back, to the bit where no unit changes", "[io][trajectory]") {
  const test::TemporaryFolder folder;
  Trajectory written = random_trajectory(500);
  written[Channel::delta_s][17] = kMissing;
  written[Channel::n_st].clear();
  io::write_trajectory(folder / "run.csv", written);
  const Trajectory read = io::read_trajectory(folder / "run.csv");
  CHECK(read.name == "run");
  CHECK(read.ignored_columns.empty());
  CHECK_FALSE(read.has(Channel::n_st));
  CHECK(std::isnan(read[Channel::delta_s][17]));
  for (const ChannelInfo& channel : kChannels) {
    CAPTURE(channel.name);
    const auto &a = written[channel.channel], &b = read[channel.channel];
    REQUIRE(a.size() == b.size());
    const bool in_degrees = channel.quantity == Quantity::angle || channel.quantity == Quantity::angular_rate;
    for (std::size_t i = 0; i < a.size(); ++i) {
      if (std::isnan(a[i])) continue;
      // rad -> deg -> rad rounds twice, half a unit in the last place each.
      if (in_degrees) {
        REQUIRE_THAT(b[i], WithinRel(a[i], 2.3e-16));
      } else {
        REQUIRE(b[i] == a[i]);
      }
    }
  }
  // Written again, the file is read to the same bits: no drift from one copy to the next.
  io::write_trajectory(folder / "copy.csv", read);
  const Trajectory again = io::read_trajectory(folder / "copy.csv");
  for (std::size_t i = 0; i < read.size(); ++i)
    REQUIRE_THAT(again[Channel::r][i], WithinRel(read[Channel::r][i], 2.3e-16));
}

TEST_CASE("trajectory: radians and knots are converted once, columns may stand in any order", "[io][trajectory]") {
  const test::TemporaryFolder folder;
  const Trajectory t = read_text(folder,
                                 "r_radps,psi_rad,wind_speed_kn,u_kn,vm_mps,t_s,delta_deg,weather,wind_dir_deg\n"
                                 "0.1,2.5,10,3,-0.2,7,30,fine,90\n"
                                 "0.2,-2.5,10,3,-0.2,8,-30,,90\n");
  CHECK(t[Channel::r] == std::vector<double>{0.1, 0.2});
  CHECK_THAT(t[Channel::u][0], WithinRel(3.0 * 1852.0 / 3600.0, 1e-15));
  CHECK_THAT(t[Channel::wind_speed][1], WithinRel(10.0 * 1852.0 / 3600.0, 1e-15));
  CHECK_THAT(t[Channel::delta][1], WithinRel(-kPi / 6.0, 1e-15));
  CHECK_THAT(t[Channel::psi][1], WithinRel(2.0 * kPi - 2.5, 1e-15));  // unwrapped
  CHECK(t.ignored_columns == std::vector<std::string>{"weather"});
}

TEST_CASE("trajectory: an empty field is a missing sample, never zero", "[io][trajectory]") {
  const test::TemporaryFolder folder;
  const Trajectory t =
      read_text(folder, "t_s,u_mps,vm_mps,r_degps,psi_deg\n0,1, ,0,\n1,,0.2,0,350\n,,,,\n2,1,0.1,0,10\n");
  REQUIRE(t.size() == 3);
  CHECK(std::isnan(t[Channel::vm][0]));
  CHECK(std::isnan(t[Channel::u][1]));
  CHECK(std::isnan(t[Channel::psi][0]));
  CHECK_THAT(t[Channel::psi][2] - t[Channel::psi][1], WithinRel(deg_to_rad(20.0), 1e-12));
}

TEST_CASE("trajectory: what is wrong in a file is named with line, column and unit", "[io][trajectory]") {
  const test::TemporaryFolder folder;
  const std::string header = "t_s,u_mps,vm_mps,r_degps\n";
  const auto refused = [&](const std::string& text, const std::string& because) {
    CHECK_THROWS_AS(read_text(folder, text), InputError);
    CHECK_THROWS_WITH(read_text(folder, text), Contains(because));
  };
  refused(header, "rec.csv:2: no data row below the header");
  refused("t_s,u_mps,r_degps\n0,0,0\n", "rec.csv:1: no column 'vm_mps'; found t_s, u_mps, r_degps");
  refused("t_s,u_mps,vm_mps,r_degps,wind_speed_mps\n", "column 'wind_speed_mps' without 'wind_dir_deg'");
  refused("t_s,u_mps,vm_mps,r_degps,app_wind_dir_deg\n", "column 'app_wind_dir_deg' without 'app_wind_speed_mps'");
  refused("t_s,u_mps,vm_mps,r_degps,u_kn\n", "column 'u_kn': holds the same quantity as column 'u_mps'");
  refused(header + "0,1,0,0\n1,nan,0,0\n", "rec.csv:3: column 'u_mps': expected a finite number [m/s], got 'nan'");
  refused(header + "0,1,0,zero\n", "rec.csv:2: column 'r_degps': expected a finite number [deg/s], got 'zero'");
  refused(header + "0,1,0,0\n,1,0,0\n", "rec.csv:3: column 't_s': expected a finite number [s], got ''");
  refused(header + "0,1,0\n", "rec.csv:2: expected 4 fields, found 3");
  refused(header + "0,1,0,0,0\n", "rec.csv:2: expected 4 fields, found 5");
  refused(header + "0,1,0,0\n2,1,0,0\n2,1,0,0\n", "rec.csv:4: column 't_s': time must increase, but 2 s follows 2 s");
}

TEST_CASE("trajectory: a copy keeps the columns that no tool knows, as they stand", "[io][trajectory]") {
  const test::TemporaryFolder folder;
  const std::string file = folder.write("rec.csv",
                                        "note,t_s,u_mps,vm_mps,r_degps,\"sea, state\"\n"
                                        "\"turn, then stop\",0,1,0,0,007\n"
                                        ",,,,,\n"
                                        ",1,1,0,0,\"a \"\"b\"\"\"\n");
  const Trajectory kept = io::read_trajectory(file, nullptr, true);
  CHECK(io::trajectory_text(kept) ==
        "t_s,u_mps,vm_mps,r_degps,note,\"sea, state\"\n"
        "0,1,0,0,\"turn, then stop\",007\n"
        "1,1,0,0,,\"a \"\"b\"\"\"\n");
  CHECK(io::read_trajectory(file).ignored_texts.empty());
}

TEST_CASE("trajectory: a columns map reads a foreign recording", "[io][columns]") {
  const test::TemporaryFolder folder;
  const std::string map_file = folder.write(
      "map.json",
      R"({"description": "hand-made", "missing": ["-"], "t_s": "time", "u_mps": {"from": "speed", "unit": "kn"},
          "vm_mps": "side", "r_degps": {"from": "yaw rate", "unit": "radps"}})");
  const io::ColumnsMap map = io::read_columns_map(map_file);
  const std::string rec = folder.write("rec.csv", "time,speed,side,yaw rate,psi_deg\n0,2,-,0.3,5\n1,2,0.1,-,6\n");
  const Trajectory t = io::read_trajectory(rec, &map);
  CHECK_THAT(t[Channel::u][0], WithinRel(2.0 * 1852.0 / 3600.0, 1e-15));
  CHECK(t[Channel::r][0] == 0.3);
  CHECK(std::isnan(t[Channel::vm][0]));
  CHECK(std::isnan(t[Channel::r][1]));
  // What the map does not name is read under leeway's own name.
  CHECK(t.ignored_columns.empty());
  CHECK(t[Channel::psi][1] == 6.0 * kDegree);
  CHECK_THROWS_WITH(io::read_trajectory(folder.write("bad.csv", "time,side,yaw rate\n"), &map),
                    Contains("no column 'speed'; found time, side, yaw rate"));
}

TEST_CASE("trajectory: a number may mark a missing sample, however it is written", "[io][columns]") {
  const test::TemporaryFolder folder;
  const io::ColumnsMap map = io::read_columns_map(folder.write(
      "map.json",
      R"({"missing": ["-9999"], "t_s": "t_s", "u_mps": "u_mps", "vm_mps": "vm_mps", "r_degps": "r_degps"})"));
  const std::string header = "t_s,u_mps,vm_mps,r_degps\n";
  const Trajectory t = io::read_trajectory(
      folder.write("rec.csv", header + "0,-9999,0.1,0\n1,1, -9999 ,0\n-9999,-9999,-9999,-9999\n"), &map);
  REQUIRE(t.size() == 2);
  CHECK(std::isnan(t[Channel::u][0]));
  CHECK(std::isnan(t[Channel::vm][1]));
  const Trajectory other = io::read_trajectory(
      folder.write("rec.csv", header + "0,-9999.0,0.1,0\n1,1,-9.999e3,0\n2,-09999,-9998,0\n"), &map);
  CHECK(std::isnan(other[Channel::u][0]));
  CHECK(std::isnan(other[Channel::vm][1]));
  CHECK(std::isnan(other[Channel::u][2]));
  CHECK(other[Channel::vm][2] == -9998.0);
  CHECK_THROWS_WITH(io::read_trajectory(folder.write("rec.csv", header + "-9999,1,0,0\n"), &map),
                    Contains("rec.csv:2: column 't_s': expected a finite number [s], got '-9999'"));
}

TEST_CASE("trajectory: a columns map that is wrong is refused with the pointer to the place", "[io][columns]") {
  const test::TemporaryFolder folder;
  const auto refused = [&](const std::string& text, const std::string& because) {
    const std::string path = folder.write("map.json", text);
    CHECK_THROWS_WITH(io::read_columns_map(path), Contains(because));
  };
  refused(R"({"t_sec": "time"})", "map.json: /t_sec: unknown column name");
  refused(R"({"t_s": 5})", "map.json: /t_s: expected a column's name, or {\"from\": 5} with its number, got 5");
  refused(R"({"u_mps": {"from": "u", "unit": "mph"}})", "map.json: /u_mps/unit: unknown unit 'mph'; known: mps, kn");
  refused(R"({"u_mps": {"from": "u", "units": "kn"}})",
          "map.json: /u_mps/units: unknown key; known here: derive, from");
  refused(R"({"u_mps": {"unit": "kn"}})", "map.json: /u_mps/from: missing, expected a text");
  refused(R"({"u_mps": "a", "vm_mps": "a"})", "the column 'a' is already taken");
  CHECK_THROWS_AS(io::read_columns_map("no-such-map"), UsageError);
}

TEST_CASE("trajectory: the shipped map reads the free-running tests of the Esso Osaka", "[io][columns][real]") {
  const std::string folder = LEEWAY_SHARED_FOLDER "/real/esso-osaka";
  if (!std::filesystem::exists(folder)) {
    WARN("SKIPPED: the recordings of the Esso Osaka model are not here");
    return;
  }
  const io::ColumnsMap map = io::read_columns_map(LEEWAY_SOURCE_FOLDER "/configs/columns/frt-ds-esso.json");
  const std::string file = folder + "/zigzag/zigzag_31-Jul-2020_13_04_24.csv";
  const Trajectory t = io::read_trajectory(file, &map);
  // Its first line, as the file has it.
  CHECK(t[Channel::t][0] == 0.0);
  CHECK(t[Channel::x0][0] == 1.3298703205053);
  CHECK(t[Channel::u][0] == 0.0025057078707378);
  CHECK(t[Channel::vm][0] == -0.0039246040296549);
  CHECK(t[Channel::psi][0] == -0.0151383612269067);
  CHECK(t[Channel::r][0] == -0.0002462725103782);
  CHECK(t[Channel::n_p][0] == 1.66666666666667);
  CHECK(t[Channel::delta][0] == 0.0);
  CHECK(t[Channel::wind_dir][0] == 5.22074011522602);
  CHECK(t.has_wind());
  CHECK(t.size() > 500);
}
