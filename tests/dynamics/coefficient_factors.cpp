#include <catch2/catch.hpp>

#include "core/errors.hpp"
#include "dynamics/model.hpp"
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

TEST_CASE("coefficient factors: a coefficient that the ship has not is refused by its place", "[ship]") {
  const Ship ship = esso_with_factors({{"rudder.gain_port", 0.9}});
  CHECK_THROWS_WITH(Model<double>(ship), Contains("ship.json") && Contains("/coefficient_factors/rudder.gain_port") &&
                                             Contains("rudder.gain_35deg"));
  CHECK_THROWS_WITH(esso_with_factors({{"hull.Y_v", 0.0}}), Contains("/coefficient_factors/hull.Y_v"));
}
