#include <cmath>

#include <catch2/catch.hpp>

#include "core/errors.hpp"
#include "foreign/disguise.hpp"
#include "foreign/proposed.hpp"

using namespace leeway;
using Catch::Matchers::Contains;
using io::Json;
using test::check_proposal;
using test::column;
using test::kEverything;

namespace {

constexpr double kPerDegree = 1.0 / kDegree;

const Trajectory& zigzag_run() {
  static const Trajectory run = test::simulated_zigzag();
  return run;
}
const Trajectory& turn_run() {
  static const Trajectory run = test::simulated_turn(35.0);
  return run;
}

std::vector<test::ForeignColumn> plain_columns() {
  return {column("t [s]", Channel::t, 1.0),
          column("u [m/s]", Channel::u, 1.0),
          column("v [m/s]", Channel::vm, 1.0),
          column("r [deg/s]", Channel::r, kPerDegree),
          column("x [m]", Channel::x0, 1.0),
          column("y [m]", Channel::y0, 1.0),
          column("psi [deg]", Channel::psi, kPerDegree),
          column("rudder [deg]", Channel::delta, kPerDegree),
          column("n [1/s]", Channel::n_p, 1.0)};
}

}  // namespace

TEST_CASE("proposal: a rudder held in a turning circle keeps the sign that turns the ship to its side", "[foreign]") {
  // The yaw rate falls as speed is lost, while the rudder stays: a plain regression reads that as the other side.
  for (const double rudder_deg : {35.0, -35.0, 15.0})
    for (const double sign : {1.0, -1.0}) {
      CAPTURE(rudder_deg, sign);
      const Trajectory turn = test::simulated_turn(rudder_deg);
      std::vector<test::ForeignColumn> columns = plain_columns();
      columns[7] = column("rudder [deg]", Channel::delta, sign * kPerDegree);
      const Json map = check_proposal(test::foreign_text(turn, columns), turn, kEverything);
      CHECK_THAT(test::notes_of(map), Contains("while delta is held"));
    }
}

TEST_CASE("proposal: leeway's own names are never turned, and a contradiction is noted", "[foreign]") {
  for (const double rudder_deg : {35.0, -10.0}) {
    const Trajectory turn = test::simulated_turn(rudder_deg);
    check_proposal(io::trajectory_text(turn), turn, kEverything);
  }
  Trajectory turned = turn_run();
  for (double& delta : turned[Channel::delta]) delta *= -1.0;
  const Json map = check_proposal(io::trajectory_text(turned), turned, kEverything);
  CHECK_THAT(test::notes_of(map), Contains("'delta_deg' has leeway's own name"));
}

TEST_CASE("proposal: the unit of a course without a word about it is one of angles, and the map can be read",
          "[foreign]") {
  // Without positions nothing tells the unit but the range of the numbers.
  const Json map = check_proposal(
      test::foreign_text(turn_run(), {column("t", Channel::t, 1.0), column("SOG [m/s]", test::speed),
                                      column("COG", test::course_deg), column("HDG [deg]", Channel::psi, kPerDegree)}),
      turn_run(), {Channel::u, Channel::vm, Channel::psi}, 1e-6);
  CHECK_FALSE(map["course_deg"].is_object());
  CHECK_THAT(test::notes_of(map), Contains("the unit of vm is taken to be deg"));
}

TEST_CASE("proposal: the unit of time that makes the motion fit is proposed", "[foreign]") {
  const auto with_time = [](const test::ForeignColumn& time) {
    std::vector<test::ForeignColumn> columns = plain_columns();
    columns[0] = time;
    return check_proposal(test::foreign_text(zigzag_run(), columns), zigzag_run(), kEverything, 1e-5);
  };
  CHECK(with_time(column("t", Channel::t, 1000.0))["t_s"]["unit"] == "ms");
  CHECK(with_time(column("t", Channel::t, 1.0 / 60.0))["t_s"]["unit"] == "min");
  CHECK(with_time(column("t", Channel::t, 1.0 / 3600.0))["t_s"]["unit"] == "h");
  const Json days = with_time({"DateTime", [](const Trajectory& t, std::size_t i) {
                                 return fmt::format("{:.10f}", 44259.9 + t[Channel::t][i] / 86400.0);
                               }});
  CHECK(days["t_s"]["scale"] == 24.0);
  CHECK(with_time({"timestamp", [](const Trajectory& t, std::size_t i) {
                     return fmt::format("{:.0f}", 1614900000000.0 + 1000.0 * t[Channel::t][i]);
                   }})["t_s"]["unit"] == "ms");
  const auto hhmmss = [](const Trajectory& t, std::size_t i) {
    const double s = 7080.0 + t[Channel::t][i];  // 11:58:00
    return fmt::format("{:02.0f}{:02.0f}{:04.1f}", 10.0 + std::floor(s / 3600.0),
                       std::floor(std::fmod(s, 3600.0) / 60.0), std::fmod(s, 60.0));
  };
  CHECK(with_time({"UTC", hhmmss})["file"]["time"]["format"] == "hms");
  CHECK(with_time({"Time (hhmmss)", hhmmss})["file"]["time"]["format"] == "hms");
}

TEST_CASE("proposal: where nothing is there to compare with, seconds are said to be assumed", "[foreign]") {
  const Json map =
      check_proposal(test::foreign_text(zigzag_run(), {column("t", Channel::t, 1.0), column("u [m/s]", Channel::u, 1.0),
                                                       column("v [m/s]", Channel::vm, 1.0),
                                                       column("psi [deg]", Channel::psi, kPerDegree)}),
                     zigzag_run(), {Channel::u});
  CHECK_THAT(test::notes_of(map), Contains("seconds are assumed"));
  CHECK_THAT(test::notes_of(map), Contains("no position to compare with"));
  CHECK_THAT(
      test::notes_of(check_proposal(test::foreign_text(zigzag_run(), plain_columns()), zigzag_run(), kEverything)),
      !Contains("seconds are assumed") && !Contains("no position to compare"));
}

TEST_CASE("proposal: feet, centimeters and the like become a scale, and a unit that is not known is noted",
          "[foreign]") {
  std::vector<test::ForeignColumn> columns = plain_columns();
  columns[1] = column("u [ft/s]", Channel::u, 1.0 / 0.3048);
  columns[2] = column("v [cm/s]", Channel::vm, 100.0);
  columns[4] = column("x [ft]", Channel::x0, 1.0 / 0.3048);
  columns[5] = column("y [mm]", Channel::y0, 1000.0);
  const Json map = check_proposal(test::foreign_text(zigzag_run(), columns), zigzag_run(), kEverything);
  CHECK(map["x0_m"]["scale"] == 0.3048);
  columns = plain_columns();
  columns[8].first = "n [furlongs]";
  const std::string notes =
      test::notes_of(check_proposal(test::foreign_text(zigzag_run(), columns), zigzag_run(), {Channel::u}));
  CHECK_THAT(notes, Contains("the unit 'furlongs' of column 'n [furlongs]'"));
}

TEST_CASE("proposal: east and north by letters, and axes that are exchanged", "[foreign]") {
  for (const Trajectory* run : {&zigzag_run(), &turn_run()}) {
    std::vector<test::ForeignColumn> columns = plain_columns();
    columns[4] = column("E [m]", Channel::y0, 1.0);
    columns[5] = column("N [m]", Channel::x0, 1.0);
    columns[8] = column("RPM", Channel::n_p, 60.0);
    check_proposal(test::foreign_text(*run, columns), *run, kEverything);
    columns[4] = column("x [m]", Channel::y0, 1.0);
    columns[5] = column("y [m]", Channel::x0, 1.0);
    const Json map = check_proposal(test::foreign_text(*run, columns), *run, kEverything);
    CHECK(map["x0_m"] == "y [m]");
    columns[1] = column("vx [m/s]", test::east);
    columns[2] = column("vy [m/s]", test::north);
    const Json earth = check_proposal(test::foreign_text(*run, columns), *run, kEverything);
    CHECK(earth["u_mps"] == "vy [m/s]");
  }
}

TEST_CASE("proposal: quoted files, and files of thousands of columns", "[foreign]") {
  std::vector<test::ForeignColumn> columns = plain_columns();
  for (auto& [name, text] : columns) {
    name = "\"" + name + "; as recorded\"";
    text = [inner = text](const Trajectory& t, std::size_t i) {
      std::string field = inner(t, i);
      std::replace(field.begin(), field.end(), '.', ',');
      return "\"" + field + "\"";
    };
  }
  check_proposal(test::foreign_text(zigzag_run(), columns, ';'), zigzag_run(), kEverything);
  columns = plain_columns();
  for (int k = 0; k < 3000; ++k)
    columns.emplace_back(fmt::format("pressure {}", k),
                         [](const Trajectory&, std::size_t i) { return fmt::format("{}", 1000 + i % 7); });
  check_proposal(test::foreign_text(zigzag_run(), columns), zigzag_run(), kEverything);
}

TEST_CASE("proposal: in a turning circle without names velocities along the earth's axes are not taken for positions",
          "[foreign]") {
  for (const double rudder_deg : {35.0, -20.0}) {
    const Trajectory turn = test::simulated_turn(rudder_deg);
    const Json map = check_proposal(
        test::foreign_text(turn,
                           {column("", Channel::t, 1.0), column("", Channel::x0, 1.0), column("", Channel::y0, 1.0),
                            column("", Channel::psi, kPerDegree), column("", test::north), column("", test::east),
                            column("", Channel::r, kPerDegree), column("", Channel::delta, -kPerDegree)},
                           '\t', false),
        turn, {Channel::x0, Channel::y0, Channel::psi, Channel::u, Channel::vm, Channel::r, Channel::delta});
    CHECK(map["file"]["velocity_frame"] == "earth");
  }
}

TEST_CASE("proposal: columns whose names say nothing are found by the kinematics beside those that do", "[foreign]") {
  std::vector<test::ForeignColumn> columns = plain_columns();
  columns[3] = column("Giergeschw. Kanal 7", Channel::r, kPerDegree);
  columns[6] = column("Kanal 3", Channel::psi, kPerDegree);
  const Json map = check_proposal(test::foreign_text(zigzag_run(), columns), zigzag_run(), kEverything);
  CHECK_THAT(test::notes_of(map), Contains("column 'Kanal 3' is taken to be psi"));
}

TEST_CASE("proposal: UTF-16 is named as such", "[foreign]") {
  const test::TemporaryFolder folder;
  std::string text("\xFF\xFE", 2);
  for (const char c : test::foreign_text(zigzag_run(), plain_columns())) text += {c, '\0'};
  for (const std::string& bytes : {text, text.substr(2)})
    CHECK_THROWS_WITH(foreign::propose_columns_map(folder.write("raw.csv", bytes)),
                      Contains("is UTF-16; expected UTF-8"));
}
