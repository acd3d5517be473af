#include <cmath>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "core/errors.hpp"
#include "dynamics/model.hpp"
#include "dynamics/model_parts.hpp"
#include "io/files.hpp"
#include "io/json.hpp"
#include "temporary_folder.hpp"

using namespace leeway;
using Catch::Matchers::Contains;

namespace {

Ship esso_with_factors(const io::Json& factors) {
  io::Json json = io::read_json(io::find_config("ships", "esso-osaka-3m"));
  json["coefficient_factors"] = factors;
  const test::TemporaryFolder folder;
  return read_ship(folder.write("ship.json", io::to_text(json)));
}

Vec3<double> acceleration_of(const Ship& ship) {
  Actuators<double> actuators = ship.initial_actuators();
  actuators[Channel::delta] = 0.2;
  return Model<double>(ship).acceleration({0.4, 0.05, 0.03}, actuators, Vec2<double>(0.0, 0.0));
}

}  // namespace

TEST_CASE("coefficient factors: a factor on the thrust is the effect that takes thrust away", "[ship]") {
  Ship loses = read_ship("esso-osaka-3m");
  loses.effects.push_back({"thrust-loss", {{"k_T", 0.8}}, "ship.json", "/effects/0"});
  const Vec3<double> with = acceleration_of(esso_with_factors({{"propeller.K_T", 0.8}, {"source", "a test"}}));
  CHECK((with - acceleration_of(loses)).norm() < 1e-12);
  CHECK((with - acceleration_of(read_ship("esso-osaka-3m"))).norm() > 1e-4);
}

TEST_CASE("coefficient factors: they multiply, whatever was there", "[ship]") {
  Ship ship = esso_with_factors({{"hull.Y_v", 1.2}});
  ship.multiply({{"hull.Y_v", 0.5}, {"inertia.I_z", 2.0}});
  const Ship other = esso_with_factors({{"inertia.I_z", 2.0}, {"hull.Y_v", 0.6}});
  CHECK((acceleration_of(ship) - acceleration_of(other)).norm() < 1e-12);
}

TEST_CASE("coefficient factors: how resistance changes with speed is what it is at half the speed", "[ship]") {
  for (const char* name : {"esso-osaka-3m", "kvlcc2-l7"}) {
    Ship ship = read_ship(name);
    const auto resistance = [&](double u) {
      const ForceModules<double> modules = Model<double>(ship).parts().modules;
      return std::visit([&](const auto& hull) { return hull.force(Motion<double>(u, 0.0, 0.0))(0); }, modules.hull);
    };
    const double u = 0.1 * std::sqrt(kGravity_mps2 * ship.particulars.L_pp), fast = resistance(u);
    const double slow = resistance(0.5 * u), crawling = resistance(0.01 * u);
    CHECK(slow == Approx(0.25 * fast).epsilon(1e-12));
    ship.multiply({{"hull.resistance_slow", 1.15}});
    CHECK(resistance(u) == Approx(fast).epsilon(1e-12));
    CHECK(resistance(0.5 * u) == Approx(1.15 * slow).epsilon(0.01));
    // It stays bounded where the ship stops: 1.15 for each of log2(10) halves.
    CHECK(resistance(0.01 * u) / crawling < std::pow(1.15, std::log2(10.0)) + 1e-9);
    CHECK(resistance(0.0) == 0.0);
  }
}

TEST_CASE("coefficient factors: a coefficient that the ship has not is refused by its place", "[ship]") {
  const Ship ship = esso_with_factors({{"rudder.gain_port", 0.9}});
  CHECK_THROWS_WITH(Model<double>(ship), Contains("ship.json") && Contains("/coefficient_factors/rudder.gain_port") &&
                                             Contains("rudder.gain_35deg"));
  CHECK_THROWS_WITH(esso_with_factors({{"hull.Y_v", 0.0}}), Contains("/coefficient_factors/hull.Y_v"));
}
