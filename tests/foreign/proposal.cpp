#include "foreign/proposal.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include <catch2/catch.hpp>

#include "core/errors.hpp"
#include "foreign/disguise.hpp"
#include "foreign/proposed.hpp"
#include "io/trajectory_csv.hpp"
#include "temporary_folder.hpp"

using namespace leeway;
using Catch::Matchers::Contains;
using io::Json;
using test::column;

namespace {

constexpr double kDegrees = 1.0 / kDegree;

const Trajectory& simulated() {
  static const Trajectory run = test::simulated_zigzag();
  return run;
}

Json check_proposal(const std::string& text, const std::vector<Channel>& channels, double tolerance = 1e-6) {
  return test::check_proposal(text, simulated(), channels, tolerance);
}

using test::kEverything;

using test::course_deg;
using test::speed;

}  // namespace

TEST_CASE("proposal: leeway's own form needs no map, and is recognized", "[foreign]") {
  check_proposal(io::trajectory_text(simulated()), kEverything);
}

TEST_CASE("proposal: names with units, a rudder that is positive to port, knots and revolutions per minute",
          "[foreign]") {
  const Json map = check_proposal(
      test::foreign_text(
          simulated(),
          {column("Time [s]", Channel::t, 1.0), column("Surge speed (kn)", Channel::u, 1.0 / kKnot),
           column("Sway [m/s]", Channel::vm, 1.0), column("Rate of turn [deg/min]", Channel::r, 60.0 * kDegrees),
           column("Heading [deg]", Channel::psi, kDegrees), column("X [m]", Channel::x0, 1.0),
           column("Y [m]", Channel::y0, 1.0), column("Rudder angle [deg]", Channel::delta, -kDegrees),
           column("Propeller [rpm]", Channel::n_p, 60.0)}),
      kEverything);
  CHECK(map["delta_deg"]["sign"] == -1);
}

TEST_CASE("proposal: units and signs without a word about them, by the kinematics", "[foreign]") {
  check_proposal(test::foreign_text(simulated(), {column("t", Channel::t, 1.0), column("u", Channel::u, 1.0 / kKnot),
                                                  column("v", Channel::vm, -1.0 / kKnot), column("r", Channel::r, 1.0),
                                                  column("psi", Channel::psi, kDegrees), column("x", Channel::x0, 1.0),
                                                  column("y", Channel::y0, 1.0), column("delta", Channel::delta, -1.0),
                                                  column("n", Channel::n_p, 1.0)}),
                 kEverything);
  // A heading that counts counterclockwise, and a plane with y0 to port: each by itself.
  check_proposal(
      test::foreign_text(
          simulated(),
          {column("t", Channel::t, 1.0), column("u", Channel::u, 1.0), column("v", Channel::vm, 1.0),
           column("r", Channel::r, kDegrees), column("psi", Channel::psi, -kDegrees), column("x", Channel::x0, 1.0),
           column("y", Channel::y0, 1.0), column("delta", Channel::delta, kDegrees), column("n", Channel::n_p, 60.0)}),
      kEverything);
  check_proposal(
      test::foreign_text(
          simulated(),
          {column("t", Channel::t, 1.0), column("u", Channel::u, 1.0), column("v", Channel::vm, -1.0),
           column("r", Channel::r, kDegrees), column("psi", Channel::psi, kDegrees), column("x", Channel::x0, 1.0),
           column("y", Channel::y0, -1.0), column("delta", Channel::delta, kDegrees), column("n", Channel::n_p, 1.0)}),
      kEverything);
}

TEST_CASE("proposal: a line of units below the names, and names that say less than the kinematics", "[foreign]") {
  const std::vector<test::ForeignColumn> columns{
      column("time", Channel::t, 1.0),          column("East", Channel::y0, 1.0),
      column("North", Channel::x0, 1.0),        column("yaw", Channel::psi, kDegrees),
      column("velocity_x", Channel::u, 1.0),    column("velocity_y", Channel::vm, 1.0),
      column("yaw rate", Channel::r, kDegrees), column("rudder", Channel::delta, -kDegrees)};
  std::string text = test::foreign_text(simulated(), columns, '\t');
  text.insert(text.find('\n') + 1, "[s]\t[m]\t[m]\t[deg]\t[m/s]\t[m/s]\t[deg/s]\t[deg]\n");
  const Json map = check_proposal(
      text, {Channel::t, Channel::u, Channel::vm, Channel::r, Channel::psi, Channel::x0, Channel::y0, Channel::delta});
  CHECK_FALSE(map["file"].contains("velocity_frame"));
}

TEST_CASE("proposal: latitude, longitude, day and month, and a turning rate per minute, as a ship logs them",
          "[foreign]") {
  const std::vector<test::ForeignColumn> columns{
      {"Date", [](const Trajectory&, std::size_t) { return "13.06.2021"; }},
      {"Time UTC",
       [](const Trajectory& t, std::size_t i) {
         const long ms = std::lround(1000.0 * t[Channel::t][i]);
         return fmt::format("10:{:02}:{:02}.{:03}", ms / 60'000, ms / 1000 % 60, ms % 1000);
       }},
      // A sphere of the ellipsoid's radii at 54 deg is the same plane to 1e-5 over 100 m.
      column("Latitude",
             [](const Trajectory& t, std::size_t i) { return 54.0 + t[Channel::x0][i] * kDegrees / 6377270.0; }),
      column("Longitude",
             [](const Trajectory& t, std::size_t i) {
               return 8.0 + t[Channel::y0][i] * kDegrees / (6392117.0 * std::cos(54.0 * kDegree));
             }),
      column("SOG [kn]", [](const Trajectory& t, std::size_t i) { return speed(t, i) / kKnot; }),
      column("COG", course_deg),
      column("HDG", Channel::psi, kDegrees),
      column("ROT [deg/min]", Channel::r, 60.0 * kDegrees),
      column("RPM", Channel::n_p, 60.0)};
  const Json map = check_proposal("Ship: X\n" + test::foreign_text(simulated(), columns, ';'),
                                  {Channel::t, Channel::u, Channel::vm, Channel::r, Channel::psi, Channel::n_p});
  CHECK(map["file"]["position"] == "latitude-longitude");
  CHECK(map["file"]["velocity_frame"] == "course-and-speed");
  CHECK(map["file"]["time"]["format"] == "%d.%m.%Y %H:%M:%S");
}

TEST_CASE("proposal: course and speed, with decimal commas and a clock", "[foreign]") {
  const std::vector<test::ForeignColumn> columns{
      {"Time",
       [](const Trajectory& t, std::size_t i) {
         const long ms = std::lround(1000.0 * t[Channel::t][i]) + 86'370'000;
         return fmt::format("{:02}:{:02}:{:02}.{:03}", ms / 3'600'000 % 24, ms / 60'000 % 60, ms / 1000 % 60,
                            ms % 1000);
       }},
      column("SOG [kn]", [](const Trajectory& t, std::size_t i) { return speed(t, i) / kKnot; }),
      column("COG [\xC2\xB0]", course_deg),
      column("HDG [\xC2\xB0]", Channel::psi, kDegrees),
      column("x [m]", Channel::x0, 1.0),
      column("y [m]", Channel::y0, 1.0),
      column("Rudder [\xC2\xB0]", Channel::delta, kDegrees)};
  const Json map =
      check_proposal(test::foreign_text(simulated(), columns, ';', true, true),
                     {Channel::t, Channel::u, Channel::vm, Channel::psi, Channel::x0, Channel::y0, Channel::delta});
  CHECK(map["file"]["velocity_frame"] == "course-and-speed");
  CHECK(map["file"]["time"]["format"] == "hms");
  CHECK(map["r_degps"]["derive"] == "psi_deg");
}

TEST_CASE("proposal: a file without names, in any order of columns, in ship's and earth's axes", "[foreign]") {
  const auto roll = [](const Trajectory& t, std::size_t i) { return 0.4 * std::sin(0.9 * t[Channel::t][i]); };
  const auto torque = [](const Trajectory& t, std::size_t i) { return 1.0 + 0.2 * std::sin(0.05 * t[Channel::t][i]); };
  const Json ship = check_proposal(
      test::foreign_text(simulated(),
                         {column("", Channel::t, 1.0), column("", roll), column("", Channel::psi, kDegrees),
                          column("", Channel::delta, -kDegrees), column("", Channel::u, 1.0),
                          column("", Channel::vm, 1.0), column("", torque), column("", Channel::r, kDegrees),
                          column("", Channel::y0, 1.0), column("", Channel::x0, 1.0), column("", Channel::n_p, 1.0)},
                         '\t', false),
      kEverything);
  CHECK_FALSE(ship["file"].contains("velocity_frame"));
  const Json earth = check_proposal(
      "a text\n\n" +
          test::foreign_text(
              simulated(),
              {column("", Channel::t, 1.0), column("", Channel::x0, 1.0), column("", Channel::y0, 1.0),
               column("", roll), column("", Channel::psi, kDegrees), column("", test::north), column("", test::east),
               column("", Channel::r, kDegrees), column("", Channel::delta, kDegrees), column("", Channel::n_p, 60.0)},
              ' ', false),
      kEverything);
  CHECK(earth["file"]["velocity_frame"] == "earth");
  CHECK(earth["n_p_rps"]["unit"] == "rpm");
}

TEST_CASE("proposal: it says what nobody can know from the file, and refuses what is no table", "[foreign]") {
  const test::TemporaryFolder folder;
  const foreign::Proposal proposal =
      foreign::propose_columns_map(folder.write("raw.csv", io::trajectory_text(simulated())));
  std::string all;
  for (const std::string& note : proposal.unknowable) all += note + "\n";
  CHECK_THAT(all, Contains("mirror image") && Contains("midship") && Contains("model or of the ship"));
  CHECK_THROWS_AS(foreign::propose_columns_map(folder.write("x.txt", "no\ntable\n")), InputError);
  CHECK_THROWS_AS(foreign::propose_columns_map(folder.write("x.txt", "")), InputError);
}

TEST_CASE("proposal: for the recordings of two basins it is the shipped map", "[foreign][real]") {
  namespace fs = std::filesystem;
  const fs::path real = LEEWAY_SHARED_FOLDER "/real";
  if (!fs::exists(real / "kvlcc2")) {
    WARN("SKIPPED: the recordings of KVLCC2 are not here");
    return;
  }
  int checked = 0;
  for (const auto& [folder, prefix, name] :
       {std::tuple{"kvlcc2", "HSVA", "hsva-kvlcc2"}, std::tuple{"kvlcc2", "MARIN", "marin-kvlcc2"},
        std::tuple{"esso-osaka/zigzag", "zigzag", "frt-ds-esso"},
        std::tuple{"esso-osaka/turning", "turn_14", "frt-ds-esso"}})
    for (const auto& file : fs::directory_iterator(real / folder)) {
      const std::string path = file.path().string();
      if (!file.path().filename().string().starts_with(prefix)) continue;
      CAPTURE(path);
      const test::TemporaryFolder temporary;
      const std::string text = foreign::map_text(foreign::propose_columns_map(path));
      INFO(text);
      const io::ColumnsMap proposed = io::read_columns_map(temporary.write("map.json", text));
      const io::ColumnsMap shipped =
          io::read_columns_map(std::string(LEEWAY_SOURCE_FOLDER "/configs/columns/") + name + ".json");
      CHECK(proposed.velocity_frame == shipped.velocity_frame);
      REQUIRE(proposed.columns.size() == shipped.columns.size());
      for (const io::ColumnsMap::Source& source : shipped.columns) {
        const io::ColumnsMap::Source* const same = proposed.source_of(source.channel);
        CAPTURE(info(source.channel).name);
        REQUIRE(same != nullptr);
        CHECK(same->from == source.from);
        CHECK(same->factor == Approx(source.factor));
      }
      CHECK(proposed.sample_interval_s.has_value() == shipped.sample_interval_s.has_value());
      if (shipped.sample_interval_s)
        CHECK(*proposed.sample_interval_s == Approx(*shipped.sample_interval_s).epsilon(2e-4));
      ++checked;
    }
  CHECK(checked >= 20);
}
