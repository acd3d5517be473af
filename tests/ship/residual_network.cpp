#include "ship/residual_network.hpp"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "core/errors.hpp"
#include "core/units.hpp"
#include "dynamics/simulation.hpp"
#include "io/files.hpp"
#include "ship/ship.hpp"
#include "temporary_folder.hpp"

using namespace leeway;
using Catch::Matchers::Contains;

namespace {

// du/dt = 0.1 + 0.2 tanh(2 (u - 0.5)/0.25 + (delta - 0)/0.1), dr/dt = -0.3 of the same tanh.
io::Json small_network() {
  const auto input = [](const char* name, double mean, double sd, double low, double high) {
    return io::Json{{"name", name}, {"mean", mean}, {"sd", sd}, {"low", low}, {"high", high}};
  };
  return {{"source", "made for a test"},
          {"inputs",
           {input("u_mps", 0.5, 0.25, 0.0, 1.0), input("vm_mps", 0.0, 0.1, -0.5, 0.5),
            input("r_radps", 0.0, 0.05, -0.2, 0.2), input("delta_rad", 0.0, 0.1, -0.6, 0.6)}},
          {"layers",
           {{{"weights", {2.0, 0.0, 0.0, 1.0}}, {"biases", {0.0}}},
            {{"weights", {0.2, 0.0, -0.3}}, {"biases", {0.1, 0.0, 0.0}}}}}};
}

Ship esso_with(const io::Json& network) {
  io::Json json = io::read_json(io::find_config("ships", "esso-osaka-3m"));
  json["residual_network"] = network;
  const test::TemporaryFolder folder;
  return read_ship(folder.write("ship.json", io::to_text(json)));
}

Vec3<double> acceleration_of(const Ship& ship, const Vec3<double>& nu, double delta) {
  Inputs<double> inputs{ship.initial_actuators(), {0.3, -0.2}, 0.0};
  inputs.actuators[Channel::delta] = delta;
  return rate_of_change(Model<double>(ship), {Vec3<double>(1.0, 2.0, 0.4), nu}, inputs).nu;
}

}  // namespace

TEST_CASE("residual network: its accelerations are added to the equations of motion, inside its domain alone",
          "[ship]") {
  const Ship plain = read_ship("esso-osaka-3m"), with = esso_with(small_network());
  const auto added = [&](const Vec3<double>& nu, double delta) -> Vec3<double> {
    return acceleration_of(with, nu, delta) - acceleration_of(plain, nu, delta);
  };
  const double unit = std::tanh(2.0 * (0.6 - 0.5) / 0.25 + 0.2 / 0.1);
  CHECK((added({0.6, 0.05, 0.02}, 0.2) - Vec3<double>(0.1 + 0.2 * unit, 0.0, -0.3 * unit)).norm() < 1e-12);
  // A tenth of the box's width outside nothing is left, half of it half, and nothing jumps.
  CHECK(added({1.1, 0.0, 0.0}, 0.0).norm() == 0.0);
  CHECK(added({0.6, 0.0, 0.0}, -0.75).norm() == 0.0);
  const double beyond = std::tanh(2.0 * (1.05 - 0.5) / 0.25);
  CHECK(added({1.05, 0.0, 0.0}, 0.0)(0) == Approx(0.5 * (0.1 + 0.2 * beyond)));
  CHECK(added({1.0 + 1e-9, 0.0, 0.0}, 0.0)(0) == Approx(added({1.0 - 1e-9, 0.0, 0.0}, 0.0)(0)));
  CHECK(std::abs(added({1.1 - 1e-9, 0.0, 0.0}, 0.0)(0)) < 1e-9);
}

TEST_CASE("residual network: the apparent wind that it sees is that of the ship that moves", "[ship]") {
  io::Json json = small_network();
  for (const char* name : {"app_wind_x_mps", "app_wind_y_mps"})
    json["inputs"].push_back({{"name", name}, {"mean", 0.0}, {"sd", 1.0}, {"low", -9.0}, {"high", 9.0}});
  json["layers"][0]["weights"] = {0.0, 0.0, 0.0, 0.0, 0.1, 0.2};
  const Ship plain = read_ship("esso-osaka-3m"), with = esso_with(json);
  const Vec3<double> nu(0.6, 0.05, 0.0);
  const double c = std::cos(0.4), s = std::sin(0.4);  // the heading and the wind of acceleration_of()
  const double x = c * 0.3 + s * -0.2 + nu(0), y = -s * 0.3 + c * -0.2 + nu(1);
  CHECK(acceleration_of(with, nu, 0.0)(0) - acceleration_of(plain, nu, 0.0)(0) ==
        Approx(0.1 + 0.2 * std::tanh(0.1 * x + 0.2 * y)).epsilon(1e-9));
}

TEST_CASE("residual network: written and read again it is the same", "[ship]") {
  const Ship ship = esso_with(small_network());
  REQUIRE(ship.residual_network);
  CHECK(ship.residual_network->actuators == std::vector{Channel::delta});
  CHECK_FALSE(ship.residual_network->wind);
  CHECK(to_json(*ship.residual_network) == to_json(*esso_with(to_json(*ship.residual_network)).residual_network));
}

TEST_CASE("residual network: what does not fit is refused where it stands", "[ship]") {
  const auto message = [](const auto& change) -> std::string {
    io::Json json = small_network();
    change(json);
    try {
      esso_with(json);
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  };
  CHECK_THAT(message([](io::Json& j) { j["inputs"][3]["name"] = "delta_deg"; }),
             Contains("/residual_network/inputs: expected u_mps, vm_mps, r_radps, then actuators"));
  CHECK_THAT(message([](io::Json& j) { j["inputs"][3]["name"] = "delta_p_rad"; }),
             Contains("/residual_network/inputs: the ship has no actuator 'delta_p'"));
  CHECK_THAT(message([](io::Json& j) { j["inputs"].erase(1); }), Contains("found u_mps, r_radps, delta_rad"));
  CHECK_THAT(message([](io::Json& j) { j["inputs"][0]["sd"] = 0.0; }), Contains("/residual_network/inputs/0/sd"));
  CHECK_THAT(message([](io::Json& j) { j["inputs"][0]["low"] = 1.0; }), Contains("expected more than low"));
  CHECK_THAT(message([](io::Json& j) { j["layers"][0]["weights"].push_back(1.0); }),
             Contains("/residual_network/layers/0/weights"));
  CHECK_THAT(message([](io::Json& j) { j["layers"][1]["biases"] = {0.0}; }),
             Contains("/residual_network/layers/1/biases: expected 3, found 1"));
  CHECK_THAT(message([](io::Json& j) { j["layers"] = io::Json::array(); }), Contains("/residual_network/layers"));
  CHECK_THAT(message([](io::Json& j) { j["mean"] = 1.0; }), Contains("/residual_network/mean"));
}
