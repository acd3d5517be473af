#include <GeographicLib/LocalCartesian.hpp>
#include <algorithm>
#include <cmath>

#include <catch2/catch.hpp>

#include "core/errors.hpp"
#include "foreign/disguise.hpp"
#include "io/trajectory_csv.hpp"
#include "recording/froude_law.hpp"
#include "temporary_folder.hpp"

using namespace leeway;
using Catch::Matchers::Contains;
using test::column;

namespace {

const Trajectory& original() {
  static const Trajectory simulated = test::simulated_zigzag();
  return simulated;
}

Trajectory read_disguised(const test::TemporaryFolder& folder, const std::string& text, const std::string& map) {
  const io::ColumnsMap columns = io::read_columns_map(folder.write("map.json", map));
  return io::read_trajectory(folder.write("raw.txt", text), &columns);
}

// 10 or 12 digits were written.
void check_same(const Trajectory& read, const Trajectory& expected, const std::vector<Channel>& channels,
                double tolerance = 1e-8) {
  REQUIRE(read.size() == expected.size());
  for (const Channel channel : channels) {
    CAPTURE(info(channel).name);
    REQUIRE(read.has(channel));
    double worst = 0.0, largest = 0.0;
    for (std::size_t i = 0; i < read.size(); ++i) {
      worst = std::max(worst, std::abs(read[channel][i] - expected[channel][i]));
      largest = std::max(largest, std::abs(expected[channel][i]));
    }
    CHECK(worst <= tolerance * std::max(1.0, largest));
  }
}

const std::vector<Channel> kMotion{Channel::t, Channel::u, Channel::vm, Channel::r, Channel::psi};
const std::vector<Channel> kAll{Channel::t,  Channel::u,  Channel::vm,    Channel::r,  Channel::psi,
                                Channel::x0, Channel::y0, Channel::delta, Channel::n_p};
constexpr double kDeg = 1.0 / kDegree;

}  // namespace

TEST_CASE("foreign: other signs, units, scales and offsets read back as what was simulated", "[io][foreign]") {
  const test::TemporaryFolder folder;
  const std::string text = test::foreign_text(
      original(),
      {column("minutes", Channel::t, 1.0 / 60.0), column("speed", Channel::u, 1.0 / kKnot),
       column("leeward", Channel::vm, -3.6), column("ROT", Channel::r, 60.0 * kDeg),
       column("heading", [](const Trajectory& t, std::size_t i) { return kDeg * t[Channel::psi][i] - 3.5; }),
       column("x", Channel::x0, 0.001), column("y", Channel::y0, -1.0), column("rudder", Channel::delta, -kDeg),
       column("shaft", Channel::n_p, 60.0)});
  const Trajectory read = read_disguised(folder, text, R"({
    "t_s": {"from": "minutes", "unit": "min"}, "u_mps": {"from": "speed", "unit": "kn"},
    "vm_mps": {"from": 3, "unit": "kmh", "sign": -1}, "r_degps": {"from": "ROT", "unit": "degpmin"},
    "psi_deg": {"from": "heading", "offset": 3.5}, "x0_m": {"from": "x", "scale": 1000},
    "y0_m": {"from": "y", "scale": -1}, "delta_deg": {"from": "rudder", "sign": -1},
    "n_p_rps": {"from": "shaft", "unit": "rpm"}})");
  check_same(read, original(), kAll);
}

TEST_CASE("foreign: velocities along the earth's axes, or as course and speed, are turned to the ship's",
          "[io][foreign]") {
  const test::TemporaryFolder folder;
  const std::vector<test::ForeignColumn> columns{
      column("t", Channel::t, 1.0),
      column("vx", test::north),
      column("vy", test::east),
      column("psi", Channel::psi, kDeg),
      column("r", Channel::r, kDeg),
      column("sog", [](const Trajectory& t, std::size_t i) { return std::hypot(t[Channel::u][i], t[Channel::vm][i]); }),
      column("cog", [](const Trajectory& t, std::size_t i) {
        return std::fmod(kDeg * std::atan2(test::east(t, i), test::north(t, i)) + 360.0, 360.0);
      })};
  const std::string text = test::foreign_text(original(), columns, '\t', false);
  const std::string common = R"("t_s": {"from": 1}, "psi_deg": {"from": 4}, "r_degps": {"from": 5}, )";
  check_same(read_disguised(folder, text, "{" + common + R"("u_mps": {"from": 2}, "vm_mps": {"from": 3},
    "file": {"delimiter": "tab", "header": false, "velocity_frame": "earth"}})"),
             original(), kMotion);
  for (const std::string names :
       {R"("speed_mps": {"from": 6}, "course_deg": {"from": 7})", R"("u_mps": {"from": 6}, "vm_mps": {"from": 7})"})
    check_same(read_disguised(folder, text,
                              "{" + common + names +
                                  R"(, "file": {"delimiter": "tab", "header": false,
                                               "velocity_frame": "course-and-speed"}})"),
               original(), kMotion);
}

TEST_CASE("foreign: latitude and longitude are laid on a plane that touches the earth", "[io][foreign]") {
  const test::TemporaryFolder folder;
  const GeographicLib::LocalCartesian plane(54.3, 179.9995);  // across the date line
  const auto position = [&](bool is_latitude) {
    return [&plane, is_latitude](const Trajectory& t, std::size_t i) {
      double lat = 0.0, lon = 0.0, h = 0.0;
      plane.Reverse(t[Channel::y0][i], t[Channel::x0][i], 0.0, lat, lon, h);
      return is_latitude ? lat : lon;
    };
  };
  const std::vector<test::ForeignColumn> columns{column("t", Channel::t, 1.0),   column("Lat", position(true)),
                                                 column("Lon", position(false)), column("u", Channel::u, 1.0),
                                                 column("v", Channel::vm, 1.0),  column("psi", Channel::psi, kDeg),
                                                 column("r", Channel::r, kDeg)};
  const std::string rest = R"(, "t_s": "t", "u_mps": "u", "vm_mps": "v", "psi_deg": "psi", "r_degps": "r",
                              "file": {"position": "latitude-longitude"}})";
  for (const std::string names :
       {R"({"latitude_deg": "Lat", "longitude_deg": "Lon")", R"({"x0_m": "Lat", "y0_m": "Lon")"}) {
    const Trajectory read = read_disguised(folder, test::foreign_text(original(), columns), names + rest);
    // Twelve digits of 180 deg are 6e-5 m.
    check_same(read, original(), {Channel::x0, Channel::y0}, 1e-4);
  }
}

TEST_CASE("foreign: clocks, also over midnight and in zones, count from the first row", "[io][foreign]") {
  const test::TemporaryFolder folder;
  // From 23:59:30 on, in milliseconds.
  const auto clock = [](const std::string& pattern) {
    return test::ForeignColumn{
        "clock", [pattern](const Trajectory& t, std::size_t i) {
          const long ms = std::lround(1000.0 * t[Channel::t][i]) + 86'370'000, day = ms / 86'400'000;
          const long h = ms / 3'600'000 % 24, min = ms / 60'000 % 60, s = ms / 1000 % 60, rest = ms % 1000;
          return fmt::format(fmt::runtime(pattern), fmt::arg("day", 12 + day), fmt::arg("h", h), fmt::arg("min", min),
                             fmt::arg("s", s), fmt::arg("ms", rest),
                             fmt::arg("epoch", 1'605'225'600 + ms / 1000 - 86'400));
        }};
  };
  const auto check = [&](const std::string& text, const std::string& format, const std::string& delimiter) {
    CAPTURE(text, format);
    auto columns = std::vector{clock(text), column("u", Channel::u, 1.0), column("v", Channel::vm, 1.0),
                               column("psi", Channel::psi, kDeg), column("r", Channel::r, kDeg)};
    const std::string map =
        R"({"u_mps": "u", "vm_mps": "v", "psi_deg": "psi", "r_degps": "r", "file": {"delimiter": ")" + delimiter +
        R"(", "time": {"from": "clock", "format": ")" + format + "\"}}}";
    check_same(read_disguised(folder, test::foreign_text(original(), columns, delimiter[0]), map), original(), kMotion);
  };
  check("{h:02}:{min:02}:{s:02}.{ms:03}", "hms", ",");
  check("{h}:{min:02}:{s:02},{ms:03}", "hms", ";");
  check("2020-11-{day}T{h:02}:{min:02}:{s:02}.{ms:03}+09:00", "iso8601", ",");
  check("202011{day}T{h:02}{min:02}{s:02}.{ms:03}Z", "iso8601", ",");
  check("{epoch}.{ms:03}", "epoch", ",");
  check("{day}.11.2020 {h:02}:{min:02}:{s:02}.{ms:03}", "%d.%m.%Y %H:%M:%S", ",");
  check("{h:02}-{min:02}-{s:02},{ms:03}", "%H-%M-%S", ";");
}

TEST_CASE("foreign: decimal commas, a Latin-1 header, lines of text before it, date and time apart", "[io][foreign]") {
  const test::TemporaryFolder folder;
  const std::vector<test::ForeignColumn> columns{{"Datum", [](const Trajectory&, std::size_t) { return "12.11.2020"; }},
                                                 {"Uhrzeit",
                                                  [](const Trajectory& t, std::size_t i) {
                                                    const long ms = std::lround(1000.0 * t[Channel::t][i]);
                                                    return fmt::format("10:{:02}:{:02}.{:03}", ms / 60'000,
                                                                       ms / 1000 % 60, ms % 1000);
                                                  }},
                                                 column("L\xE4ngsgeschwindigkeit", Channel::u, 1.0),
                                                 column("quer", Channel::vm, 1.0),
                                                 column("Kurs [\xB0]", Channel::psi, kDeg),
                                                 column("Drehrate", Channel::r, kDeg)};
  const std::string text =
      "Fahrt 7; bei D\xFCnung\n\n\"halb offen\n" + test::foreign_text(original(), columns, ';', true, true);
  const Trajectory read = read_disguised(folder, text, R"({
    "file": {"delimiter": ";", "decimal": ",", "skip_lines": 3, "encoding": "latin-1",
             "time": {"from": ["Datum", "Uhrzeit"], "format": "%d.%m.%Y %H:%M:%S"}},
    "u_mps": "Längsgeschwindigkeit", "vm_mps": {"from": 4}, "psi_deg": "Kurs [°]", "r_degps": "Drehrate"})");
  check_same(read, original(), kMotion);
}

TEST_CASE("foreign: a recording of the ship is read at the model's scale, by Froude's law", "[io][foreign]") {
  const test::TemporaryFolder folder;
  const double scale = 45.7;
  const Trajectory full = scaled_down(original(), FroudeLaw(1.0 / scale));
  const std::vector<test::ForeignColumn> columns{
      column("t", Channel::t, 1.0),  column("u", Channel::u, 1.0),      column("v", Channel::vm, 1.0),
      column("r", Channel::r, kDeg), column("psi", Channel::psi, kDeg), column("x", Channel::x0, 1.0),
      column("y", Channel::y0, 1.0), column("d", Channel::delta, kDeg), column("n", Channel::n_p, 60.0)};
  const Trajectory read = read_disguised(folder, test::foreign_text(full, columns), R"({
    "t_s": "t", "u_mps": "u", "vm_mps": "v", "r_degps": "r", "psi_deg": "psi", "x0_m": "x", "y0_m": "y",
    "delta_deg": "d", "n_p_rps": {"from": "n", "unit": "rpm"}, "file": {"scale_factor": 45.7}})");
  check_same(read, original(), kAll, 1e-7);
  CHECK(read.longest_step.length_s() == Approx(0.5));
}

TEST_CASE("foreign: derived channels agree with those simulated, and are known as derived ever after",
          "[io][foreign]") {
  const test::TemporaryFolder folder;
  const std::vector<test::ForeignColumn> columns{column("psi", Channel::psi, kDeg), column("x", Channel::x0, 1.0),
                                                 column("y", Channel::y0, 1.0)};
  const Trajectory read = read_disguised(folder, test::foreign_text(original(), columns), R"({
    "file": {"sample_interval_s": 0.5}, "psi_deg": "psi", "x0_m": "x", "y0_m": "y",
    "u_mps": {"derive": "x0_m"}, "vm_mps": {"derive": "y0_m"}, "r_degps": {"derive": "psi_deg"}})");
  // Fourth order in the sampling time; largest where the rudder begins to move.
  check_same(read, original(), {Channel::u, Channel::vm, Channel::r}, 2e-3);
  for (const Channel channel : {Channel::u, Channel::vm, Channel::r}) CHECK(read.is_derived(channel));
  CHECK_FALSE(read.is_derived(Channel::psi));

  io::write_trajectory(folder / "copy.csv", read);
  const Trajectory copy = io::read_trajectory(folder / "copy.csv");
  for (const Channel channel : {Channel::u, Channel::vm, Channel::r}) CHECK(copy.is_derived(channel));
  CHECK(copy.ignored_columns.empty());
  io::write_trajectory(folder / "again.csv", copy);
  CHECK(io::read_trajectory(folder / "again.csv").is_derived(Channel::r));
}
