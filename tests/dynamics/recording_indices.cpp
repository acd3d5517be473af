#include "dynamics/recording_indices.hpp"

#include <cmath>
#include <filesystem>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "core/random.hpp"
#include "core/units.hpp"
#include "dynamics/maneuvers.hpp"
#include "dynamics/simulation.hpp"
#include "io/trajectory_csv.hpp"

using namespace leeway;
using Catch::Matchers::WithinAbs;
using io::Json;

namespace {

Json indices_of_file(const std::string& name, double L_pp_m) {
  const io::ColumnsMap map = io::read_columns_map(LEEWAY_SOURCE_FOLDER "/configs/columns/marin-kvlcc2.json");
  const Trajectory run = io::read_trajectory(LEEWAY_SHARED_FOLDER "/real/kvlcc2/" + name, &map);
  std::vector<std::string> notices;
  return recording_indices(run, {L_pp_m, 1.0, std::nullopt}, notices);
}

}  // namespace

TEST_CASE("recording indices: of a simulation they are those of every time step", "[dynamics][indices]") {
  const Ship ship = read_ship("kvlcc2-l7");
  const auto wind = WindProcess::steady(0.0, 0.0);
  std::vector<std::string> notices;
  for (const double side : {1.0, -1.0}) {
    CAPTURE(side);
    const double rudder = side * 35.0 * kDegree, half = side * 10.0 * kDegree;
    {
      Trajectory every_step;
      const auto maneuver = turning(ship, rudder);
      const Trajectory sampled =
          simulate(SimulatedShip(ship), *maneuver, wind, {0.1, 1.0, 300.0}, Integrator::rk4, &every_step);
      const Json truth = turning_indices(Track(every_step), rudder, 7.0);
      const Json read = recording_indices(sampled, recorded_ship(ship), notices);
      REQUIRE(read["maneuver"] == "turning");
      CHECK(read["order_s"] == 0.0);
      CHECK_THAT(read["rudder_deg"].get<double>(), WithinAbs(side * 35.0, 1e-9));
      // A second is what the pose is interpolated over: r changes by a few percent in it.
      for (const char* key : {"advance_over_L", "transfer_over_L", "tactical_diameter_over_L"})
        CHECK_THAT(read["indices"][key].get<double>(), WithinAbs(truth[key].get<double>(), 0.005));
    }
    Trajectory every_step;
    const auto maneuver = zigzag(ship, half, std::abs(half));
    const Trajectory sampled =
        simulate(SimulatedShip(ship), *maneuver, wind, {0.1, 1.0, 200.0}, Integrator::rk4, &every_step);
    const Json truth = zigzag_indices(Track(every_step), half, std::abs(half), 7.0);
    const Json read = recording_indices(sampled, recorded_ship(ship), notices);
    REQUIRE(read["maneuver"] == "zigzag");
    CHECK_THAT(read["rudder_deg"].get<double>(), WithinAbs(side * 10.0, 1e-9));
    CHECK_THAT(read["heading_deg"].get<double>(), WithinAbs(10.0, 1e-9));
    for (const char* key : {"first_overshoot_deg", "second_overshoot_deg"})
      CHECK_THAT(read["indices"][key].get<double>(), WithinAbs(truth[key].get<double>(), 0.1));
  }
  CHECK(notices.empty());
}

TEST_CASE("recording indices: the first execute counts also where the rudder turns back as soon as it is over",
          "[dynamics][indices]") {
  const Ship ship = read_ship("kvlcc2-l7");
  for (const auto& [rudder_deg, heading_deg] :
       {std::pair{35.0, 5.0}, std::pair{-35.0, 5.0}, std::pair{30.0, 5.0}, std::pair{7.5, 7.5}}) {
    CAPTURE(rudder_deg, heading_deg);
    const double rudder = rudder_deg * kDegree, heading = heading_deg * kDegree;
    Trajectory every_step;
    const auto maneuver = zigzag(ship, rudder, heading);
    const Trajectory sampled = simulate(SimulatedShip(ship), *maneuver, WindProcess::steady(0.0, 0.0),
                                        {0.1, 0.2, 120.0}, Integrator::rk4, &every_step);
    const Json truth = zigzag_indices(Track(every_step), rudder, heading, 7.0);
    std::vector<std::string> notices;
    const Json read = recording_indices(sampled, recorded_ship(ship), notices);
    REQUIRE(read["maneuver"] == "zigzag");
    CHECK(read["side"] == (rudder_deg > 0.0 ? "starboard" : "port"));
    CHECK(read["order_s"] == 0.0);
    CHECK_THAT(read["heading_deg"].get<double>(), WithinAbs(heading_deg, 1e-9));
    for (const char* key : {"first_overshoot_deg", "second_overshoot_deg"})
      CHECK_THAT(read["indices"][key].get<double>(), WithinAbs(truth[key].get<double>(), 0.1));
  }
}

TEST_CASE(
    "recording indices: a rudder that is recorded coarsely or with noise keeps the order, and the doubt is stated",
    "[dynamics][indices]") {
  const Ship ship = read_ship("kvlcc2-full");
  const auto wind = WindProcess::steady(0.0, 0.0);
  const auto disguised = [](Trajectory run, double resolution_deg, double sd_deg) {
    constexpr std::size_t kApproach = 500;  // samples of 0.2 s straight on before the order
    const double dt = run[Channel::t][1] - run[Channel::t][0], u = run[Channel::u][0];
    for (const ChannelInfo& channel : kChannels) {
      std::vector<double>& values = run[channel.channel];
      if (values.empty()) continue;
      values.insert(values.begin(), kApproach, values.front());
    }
    RandomStream noise(7, "rudder noise");
    for (std::size_t i = 0; i < run.size(); ++i) {
      run[Channel::t][i] = dt * static_cast<double>(i);
      if (i < kApproach) run[Channel::x0][i] = -u * dt * static_cast<double>(kApproach - i);
      double& delta = run[Channel::delta][i];
      delta += sd_deg * kDegree * noise.normal();
      if (resolution_deg > 0.0) delta = resolution_deg * kDegree * std::round(delta / (resolution_deg * kDegree));
    }
    return run;
  };
  const auto turn_maneuver = turning(ship, 35.0 * kDegree);
  const auto zigzag_maneuver = zigzag(ship, 20.0 * kDegree, 20.0 * kDegree);
  const Trajectory turn = simulate(SimulatedShip(ship), *turn_maneuver, wind, {0.1, 0.2, 700.0});
  const Trajectory zig = simulate(SimulatedShip(ship), *zigzag_maneuver, wind, {0.1, 0.2, 700.0});
  const Json turn_truth = turning_indices(Track(turn), 35.0 * kDegree, 320.0);
  const Json zig_truth = zigzag_indices(Track(zig), 20.0 * kDegree, 20.0 * kDegree, 320.0);
  for (const auto& [resolution_deg, sd_deg] :
       {std::pair{0.5, 0.0}, std::pair{1.0, 0.0}, std::pair{0.0, 0.2}, std::pair{0.0, 0.4}}) {
    CAPTURE(resolution_deg, sd_deg);
    std::vector<std::string> notices;
    const Json read = recording_indices(disguised(turn, resolution_deg, sd_deg), recorded_ship(ship), notices);
    REQUIRE(read["maneuver"] == "turning");
    CHECK(notices.size() == (read["order_doubt_s"].get<double>() > 0.0 ? 1U : 0U));
    // The rudder moves by 2.3 deg/s: what it is known to is less than a second, 8 m of about 950.
    CHECK_THAT(read["order_s"].get<double>(), WithinAbs(100.0, 1.0));
    CHECK(read["indices"]["advance_over_L"].get<double>() ==
          Approx(turn_truth["advance_over_L"].get<double>()).epsilon(0.01));
    const Json other = recording_indices(disguised(zig, resolution_deg, sd_deg), recorded_ship(ship), notices);
    REQUIRE(other["maneuver"] == "zigzag");
    CHECK_THAT(other["heading_deg"].get<double>(), WithinAbs(20.0, 1e-9));
    CHECK_THAT(other["indices"]["first_overshoot_deg"].get<double>(),
               WithinAbs(zig_truth["first_overshoot_deg"].get<double>(), 0.1));
  }
}

TEST_CASE("recording indices: without a length they are in meters, without positions these are integrated",
          "[dynamics][indices]") {
  const Ship ship = read_ship("kvlcc2-l7");
  const auto maneuver = turning(ship, 35.0 * kDegree);
  Trajectory run = simulate(SimulatedShip(ship), *maneuver, WindProcess::steady(0.0, 0.0), {0.1, 0.5, 250.0});
  std::vector<std::string> notices;
  const Json whole = recording_indices(run, {}, notices);
  CHECK(notices.empty());
  CHECK_FALSE(whole["indices"].contains("advance_over_L"));
  CHECK(whole["imo_msc_137_76"]["reason"] == "the ship's length is not given");
  for (const Channel channel : {Channel::x0, Channel::y0, Channel::psi}) run[channel].clear();
  const Json integrated = recording_indices(run, {}, notices);
  CHECK(notices.size() == 2);
  for (const char* key : {"advance_m", "tactical_diameter_m"})
    CHECK(integrated["indices"][key].get<double>() == Approx(whole["indices"][key].get<double>()).epsilon(0.005));
}

TEST_CASE("recording indices: what is neither a turn nor a zigzag says so", "[dynamics][indices]") {
  const Ship ship = read_ship("kvlcc2-l7");
  const Trajectory run =
      simulate(SimulatedShip(ship), *turning(ship, 0.0), WindProcess::steady(0.0, 0.0), {0.1, 1.0, 60.0});
  std::vector<std::string> notices;
  const Json json = recording_indices(run, recorded_ship(ship), notices);
  CHECK(json["maneuver"].is_null());
  CHECK_FALSE(json.contains("indices"));
  CHECK(json["run"].contains("duration_s"));
}

TEST_CASE("recording indices: KVLCC2's zigzag 35/5 at HSVA begins to starboard", "[dynamics][real]") {
  if (!std::filesystem::exists(LEEWAY_SHARED_FOLDER "/real/kvlcc2")) {
    WARN("SKIPPED: the recordings of KVLCC2 are not here");
    return;
  }
  const io::ColumnsMap map = io::read_columns_map(LEEWAY_SOURCE_FOLDER "/configs/columns/hsva-kvlcc2.json");
  const Trajectory run = io::read_trajectory(LEEWAY_SHARED_FOLDER "/real/kvlcc2/HSVA_CPMC_KVLCC2_Z_35_05.dat.gz", &map);
  std::vector<std::string> notices;
  const Json read = recording_indices(run, {7.0, 1.0, std::nullopt}, notices);
  CHECK(read["side"] == "starboard");
  CHECK(read["heading_deg"] == 5.0);
  CHECK_THAT(read["indices"]["first_overshoot_deg"].get<double>(), WithinAbs(13.9, 0.2));  // heading 18.9 deg at 12 s
}

TEST_CASE("recording indices: KVLCC2's runs at MARIN have the values that are published of them", "[dynamics][real]") {
  if (!std::filesystem::exists(LEEWAY_SHARED_FOLDER "/real/kvlcc2")) {
    WARN("SKIPPED: the recordings of KVLCC2 are not here");
    return;
  }
  // SIMMAN 2008, to port, port and starboard (docs/validation.md); within their last digit.
  const Json turn = indices_of_file("MARIN_FREE_KVLCC2_tc_35_m.dat.gz", 320.0);
  CHECK(turn["side"] == "port");
  CHECK_THAT(turn["indices"]["advance_over_L"].get<double>(), WithinAbs(3.11, 0.01));
  CHECK_THAT(turn["indices"]["tactical_diameter_over_L"].get<double>(), WithinAbs(3.08, 0.015));
  CHECK(turn["imo_msc_137_76"]["applies"] == true);
  const Json ten = indices_of_file("MARIN_FREE_KVLCC2_zz_10_m.dat.gz", 320.0);
  CHECK(ten["side"] == "port");
  CHECK_THAT(ten["indices"]["first_overshoot_deg"].get<double>(), WithinAbs(9.5, 0.11));
  CHECK_THAT(ten["indices"]["second_overshoot_deg"].get<double>(), WithinAbs(15.0, 0.11));
  const Json twenty = indices_of_file("MARIN_FREE_KVLCC2_zz_-20_m.dat.gz", 320.0);
  CHECK(twenty["side"] == "starboard");
  CHECK_THAT(twenty["indices"]["first_overshoot_deg"].get<double>(), WithinAbs(13.7, 0.11));
  CHECK_THAT(twenty["indices"]["second_overshoot_deg"].get<double>(), WithinAbs(14.9, 0.11));
}
