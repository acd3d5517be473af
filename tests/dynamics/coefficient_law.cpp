#include "dynamics/coefficient_law.hpp"

#include <cmath>

#include <catch2/catch.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/errors.hpp"
#include "dynamics/ship_draws.hpp"
#include "dynamics/straight_run.hpp"
#include "gap/filter/uncertainty.hpp"
#include "io/files.hpp"
#include "temporary_folder.hpp"

using namespace leeway;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinRel;

namespace {

// A shipped ship with more keys.
Ship ship_with(const test::TemporaryFolder& folder, const io::Json& more) {
  io::Json json = io::read_json(io::find_config("ships", "esso-osaka-3m"));
  json.update(more);
  io::write_text(folder / "ship.json", io::to_text(json));
  return read_ship(folder / "ship.json");
}

std::size_t place_of(const CoefficientLaw& law, const std::string& name) {
  for (std::size_t i = 0; i < law.coefficients.size(); ++i)
    if (law.coefficients[i].name == name) return i;
  throw std::out_of_range(name);
}

const io::Json kJoint{{"names", {"hull.Y_v", "hull.N_r"}}, {"matrix", {{0.04, -0.03}, {-0.03, 0.09}}}};

}  // namespace

TEST_CASE("coefficient law: defaults of the modules, what the file states, and jointly above both", "[dynamics][law]") {
  const test::TemporaryFolder folder;
  const Ship ship = ship_with(folder, {{"uncertainty", {{"hull.Y_v", 0.5}, {"hull.N_v", 0.07}, {"source", "a test"}}},
                                       {"coefficient_covariance", kJoint}});
  const CoefficientLaw law = coefficient_law(ship);
  const auto sd = [&](const std::string& name) { return law.coefficients[place_of(law, name)].sd; };
  CHECK(sd("hull.Y_v") == 0.2);
  CHECK_THAT(sd("hull.N_r"), WithinRel(0.3, 1e-15));
  CHECK(sd("hull.N_v") == 0.07);
  CHECK(sd("hull.Y_r") == 0.25);  // the module's
  CHECK(law.coefficients[place_of(law, "hull.N_v")].is_stated);
  CHECK_FALSE(law.coefficients[place_of(law, "hull.Y_r")].is_stated);
  const auto i = static_cast<Eigen::Index>(place_of(law, "hull.Y_v")),
             j = static_cast<Eigen::Index>(place_of(law, "hull.N_r"));
  CHECK(law.covariance(i, j) == -0.03);
  CHECK(law.covariance(j, i) == -0.03);
  CHECK(law.covariance(i, i) == 0.04);

  // The gap tools read the same.
  for (const gap::UncertainParameter& parameter : gap::uncertain_parameters(ship))
    if (parameter.name != kTiming) CHECK(parameter.sd == sd(parameter.name));
}

TEST_CASE("coefficient law: one error stands for most of both sides, unless the file says otherwise",
          "[dynamics][law]") {
  const auto correlation = [](const CoefficientLaw& law, const std::string& one, const std::string& other) {
    const auto i = static_cast<Eigen::Index>(place_of(law, one)), j = static_cast<Eigen::Index>(place_of(law, other));
    return law.covariance(i, j) / std::sqrt(law.covariance(i, i) * law.covariance(j, j));
  };
  const CoefficientLaw vectwin = coefficient_law(read_ship("vectwin-3m"));
  CHECK(correlation(vectwin, "rudder.gain_port", "rudder.gain_starboard") == Approx(kSidesCorrelation));
  CHECK(correlation(vectwin, "thruster.K_T_bow_negative", "thruster.K_T_bow_positive") == Approx(kSidesCorrelation));
  CHECK(correlation(vectwin, "propeller.c_1", "propeller.c_2") == 0.0);
  CHECK(correlation(vectwin, "rudder.gain_port", "thruster.K_T_bow_positive") == 0.0);

  const test::TemporaryFolder folder;
  const std::string one = "rudder.gamma_R_negative", other = "rudder.gamma_R_positive";
  CHECK(correlation(coefficient_law(ship_with(folder, {{"uncertainty", {{one, 0.1}}}})), one, other) ==
        Approx(kSidesCorrelation));
  for (const double stated : {0.0, 1.0}) {
    const io::Json joint{{"names", {one, other}}, {"matrix", {{0.04, 0.04 * stated}, {0.04 * stated, 0.04}}}};
    CHECK(correlation(coefficient_law(ship_with(folder, {{"coefficient_covariance", joint}})), one, other) ==
          Approx(stated));
  }
}

TEST_CASE("coefficient law: draws have the stated spread and correlation, times the scale", "[dynamics][law]") {
  const test::TemporaryFolder folder;
  const CoefficientLaw law = coefficient_law(ship_with(folder, {{"coefficient_covariance", kJoint}}));
  const std::size_t i = place_of(law, "hull.Y_v"), j = place_of(law, "hull.N_r"), k = place_of(law, "hull.Y_r");
  constexpr int kDraws = 4000;
  RandomStream random(7, "a test");
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (int n = 0; n < kDraws; ++n) {
    const std::vector<CoefficientFactor> factors = draw_factors(law, 2.0, random);
    const Eigen::Vector3d theta(std::log(factors[i].factor), std::log(factors[j].factor), std::log(factors[k].factor));
    sum += theta * theta.transpose() / kDraws;
  }
  // Within four standard errors of a variance of so many draws, 4 sqrt(2 / 4000).
  CHECK_THAT(sum(0, 0), WithinRel(4.0 * 0.04, 0.09));
  CHECK_THAT(sum(1, 1), WithinRel(4.0 * 0.09, 0.09));
  CHECK_THAT(sum(2, 2), WithinRel(4.0 * 0.0625, 0.09));
  CHECK_THAT(sum(0, 1) / std::sqrt(sum(0, 0) * sum(1, 1)), WithinRel(-0.5, 0.1));
  CHECK(std::abs(sum(0, 2)) / std::sqrt(sum(0, 0) * sum(2, 2)) < 0.07);
}

TEST_CASE("coefficient law: what is no law is refused with its place", "[dynamics][law]") {
  const test::TemporaryFolder folder;
  const auto refused = [&](const io::Json& more, const char* message) {
    CHECK_THROWS_WITH(coefficient_law(ship_with(folder, more)), Contains(message));
  };
  refused({{"uncertainty", {{"hull.Y_w", 0.1}}}}, "/uncertainty/hull.Y_w: 'hull.Y_w' is not an uncertain parameter");
  const auto joint = [](const io::Json& names, const io::Json& matrix) {
    return io::Json{{"coefficient_covariance", {{"names", names}, {"matrix", matrix}}}};
  };
  const io::Json two{"hull.Y_v", "hull.N_r"};
  refused(joint({"hull.Y_v", "wnid.k_X"}, {{1, 0}, {0, 1}}), "/coefficient_covariance/names/1: 'wnid.k_X' is not");
  refused(joint({"hull.Y_v", "hull.Y_v"}, {{1, 0}, {0, 1}}),
          "/coefficient_covariance/names/1: 'hull.Y_v' stands twice");
  refused(joint(two, {{1, 0}}), "/coefficient_covariance/matrix: expected a row for each of the 2 names");
  refused(joint(two, {{1, 0}, {0}}), "/coefficient_covariance/matrix/1");
  refused(joint(two, {{1, 0.5}, {0.4, 1}}), "expected a symmetric matrix");
  refused(joint(two, {{1, 2}, {2, 1}}), "is no covariance");
  refused(joint(two, {{1, 0}, {0, 0}}),
          "/coefficient_covariance/matrix/1/1: expected a variance from 1e-08 to 9, got 0");
  refused(joint({"hull.Y_v", "actuators.timing"}, {{1, 0}, {0, 1}}), "names/1: is no coefficient");
}

TEST_CASE("ship draws: each is the same whichever others are drawn, and its file reads as it", "[dynamics][law]") {
  const test::TemporaryFolder folder;
  const Ship ship = read_ship("vectwin-3m");
  const io::Json json = io::read_json(ship.file);
  const ShipDraws draws(ship, 0.5, 3);
  const ShipDraw second = draws.draw(1);
  CHECK(ShipDraws(ship, 0.5, 3).draw(1).factors[0].factor == second.factors[0].factor);
  CHECK(draws.draw(0).factors[0].factor != second.factors[0].factor);
  CHECK(ShipDraws(ship, 0.5, 4).draw(1).factors[0].factor != second.factors[0].factor);
  // Another scale is the same draw, farther off (as long as neither is refused).
  CHECK_THAT(std::log(ShipDraws(ship, 1.0, 3).draw(1).factors[0].factor),
             WithinRel(2.0 * std::log(second.factors[0].factor), 1e-12));
  io::write_text(folder / "draw.json", io::to_text(draws.json(json, second, 1)));
  const Ship read = read_ship(folder / "draw.json");
  CHECK(read.name == "vectwin-3m-draw-01");
  const Actuators<double> actuators = ship.initial_actuators();
  const Vec3<double> nu{0.4, -0.05, 0.03};
  const Vec2<double> wind{0.3, 0.1};
  const Vec3<double> from_file = Model<double>(read).acceleration(nu, actuators, wind);
  CHECK(from_file == Model<double>(second.ship).acceleration(nu, actuators, wind));
  CHECK(from_file != Model<double>(ship).acceleration(nu, actuators, wind));
}

TEST_CASE("ship draws: one whose factors no ship's file may have is drawn anew", "[dynamics][law]") {
  const Ship ship = read_ship("vectwin-3m");
  const ShipDraws draws(ship, 5.0, 1);
  int refused = 0;
  for (int i = 0; i < 80; ++i) {
    const ShipDraw draw = draws.draw(i);
    refused += draw.refused;
    for (const CoefficientFactor& by : draw.factors) {
      CAPTURE(i, by.name);
      CHECK(by.factor >= 0.01);
      CHECK(by.factor <= 100.0);
    }
  }
  CHECK(refused > 0);
}

TEST_CASE("ship draws: one that is too slow, or never turns steadily, is drawn anew", "[dynamics][law]") {
  const Ship ship = read_ship("esso-osaka-3m");
  const double most = steady_speed(ship, ship.propulsion().front().max);
  CHECK(runs_and_turns(ship, 0.9 * most));
  CHECK_FALSE(runs_and_turns(ship, 1.1 * most));
  Ship unstable = ship;
  unstable.multiply({{"hull.C_D", 0.02}, {"hull.Y_v", 0.02}, {"hull.N_r", 0.02}});  // spins and never comes to rest
  CHECK_FALSE(runs_and_turns(unstable, 0.1 * most));

  // Half of the draws cannot reach what the ship itself just reaches.
  const ShipDraws draws(ship, 1.0, 1, 0.999 * most);
  int refused = 0;
  for (int i = 0; i < 40; ++i) {
    const ShipDraw draw = draws.draw(i);
    refused += draw.refused;
    CHECK(steady_speed(draw.ship, ship.propulsion().front().max) >= 0.999 * most);
  }
  CAPTURE(refused);
  CHECK(refused > 20);
  CHECK(refused < 80);
}
