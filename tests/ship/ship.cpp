#include "ship/ship.hpp"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "core/errors.hpp"
#include "core/units.hpp"
#include "forces/registry.hpp"
#include "io/files.hpp"
#include "io/json.hpp"
#include "temporary_folder.hpp"

using namespace leeway;
using Catch::Matchers::Contains;

namespace {

// Reads a ship with one change.
template <typename Change>
void read_changed(const Change& change, const std::string& name = "vectwin-3m") {
  io::Json json = io::read_json(io::find_config("ships", name));
  change(json);
  const test::TemporaryFolder folder;
  read_ship(folder.write("ship.json", io::to_text(json)));
}

}  // namespace

TEST_CASE("ship: the shipped ships are complete, in SI and radians", "[ship]") {
  const Ship twin = read_ship("vectwin-3m");
  CHECK(twin.actuator_channels() == std::vector{Channel::delta_p, Channel::delta_s, Channel::n_p, Channel::n_bt});
  CHECK(twin.find_actuator(Channel::delta_p)->min == -105.0 * kDegree);
  CHECK(twin.find_actuator(Channel::delta_s)->random_sd == 30.0 * kDegree);
  CHECK(twin.initial_actuators()[Channel::n_p] == 10.0);
  CHECK(twin.find_actuator(Channel::delta) == nullptr);
  const Ship esso = read_ship("esso-osaka-3m");
  CHECK(esso.actuator_channels() == std::vector{Channel::delta, Channel::n_p, Channel::n_bt, Channel::n_st});
  CHECK(esso.modules->thrusters.size() == 2);
  CHECK(esso.find_actuator(Channel::n_st)->is_optional);
  CHECK_FALSE(twin.find_actuator(Channel::n_bt)->is_optional);
  CHECK(twin.scale == 50.0);
  const Ship tanker = read_ship("kvlcc2-full");
  CHECK(tanker.scale == 1.0);
  CHECK(tanker.particulars.L_pp / read_ship("kvlcc2-l7").particulars.L_pp == read_ship("kvlcc2-l7").scale);
}

TEST_CASE("ship: a misspelled, missing or impossible value is refused with its place", "[ship]") {
  CHECK_THROWS_WITH(read_changed([](io::Json& j) { j["hull"]["Y_vv"] = 0.1; }), Contains("/hull/Y_vv: unknown key"));
  CHECK_THROWS_WITH(read_changed([](io::Json& j) { j["hull"].erase("C_D"); }), Contains("/hull/C_D: missing"));
  CHECK_THROWS_WITH(read_changed([](io::Json& j) { j["particulars"]["L_pp_m"] = -7; }),
                    Contains("/particulars/L_pp_m: expected a number > 0, got -7"));
  CHECK_THROWS_WITH(read_changed([](io::Json& j) { j["wind"]["type"] = "wnid"; }),
                    Contains("/wind/type: unknown 'wnid'; known: fujiwara-1998"));
  CHECK_THROWS_WITH(read_changed([](io::Json& j) { j["rudder"].erase("source"); }), Contains("/rudder/source"));
  CHECK_THROWS_WITH(read_changed([](io::Json& j) { j["actuators"][3]["max_rps"] = -40; }),
                    Contains("/actuators/3/max_rps: expected a number > -30"));
  CHECK_THROWS_WITH(read_changed([](io::Json& j) { j["actuators"].erase(2); }), Contains("no actuator 'n_p'"));
  CHECK_THROWS_WITH(read_changed([](io::Json& j) { j["thrusters"].clear(); }),
                    Contains("no force module reads 'n_bt'"));
  CHECK_THROWS_WITH(read_changed([](io::Json& j) { j["actuators"][1]["channel"] = "delta_p"; }),
                    Contains("stands twice"));
  CHECK_THROWS_WITH(read_changed([](io::Json& j) { j["actuators"][2]["optional"] = true; }),
                    Contains("/actuators/2/optional: a thruster can be optional, 'n_p' cannot"));
  CHECK_THROWS_WITH(read_changed([](io::Json& j) {
                      j["actuators"][3]["optional"] = true;
                      j["actuators"][3]["initial_rps"] = 4;
                    }),
                    Contains("/actuators/3/initial_rps: expected 0"));
  CHECK_THROWS_WITH(read_changed([](io::Json& j) { j["actuators"][3]["pitch_current"]["n_rps_at_1"] = 0; }),
                    Contains("/actuators/3/pitch_current/n_rps_at_1: expected a number > 0, got 0"));
  CHECK_THROWS_WITH(read_changed([](io::Json& j) { j["actuators"][3]["pitch_current"].erase("source"); }),
                    Contains("/actuators/3/pitch_current/source"));
  CHECK_THROWS_WITH(read_changed([](io::Json& j) { j["actuators"][2]["pitch_current"] = j["actuators"][3]; }),
                    Contains("/actuators/2/pitch_current: a bow thruster (n_bt) can have it, 'n_p' cannot"));
  CHECK_THROWS_WITH(read_changed([](io::Json& j) { j["scale"] = 0; }), Contains("/scale: expected a number > 0"));
  CHECK_THROWS_AS(read_ship("no-such-ship"), UsageError);
}

TEST_CASE("ship: the standard method's modules are checked as the others are", "[ship]") {
  const auto changed = [](const auto& change) { read_changed(change, "kvlcc2-l7"); };
  CHECK_THROWS_WITH(changed([](io::Json& j) { j["hull"].erase("Y_vvr"); }), Contains("/hull/Y_vvr: missing"));
  CHECK_THROWS_WITH(changed([](io::Json& j) { j["hull"]["C_D"] = 0.8; }), Contains("/hull/C_D: unknown key"));
  CHECK_THROWS_WITH(changed([](io::Json& j) { j["rudder"]["k_x"] = 0.5; }), Contains("/rudder/k_x: unknown key"));
  CHECK_THROWS_WITH(changed([](io::Json& j) { j["propeller"]["reversed"].erase("source"); }),
                    Contains("/propeller/reversed/source"));
  CHECK_THROWS_WITH(changed([](io::Json& j) { j["propeller"].erase("reversed"); }), Contains("no object 'reversed'"));
  CHECK_NOTHROW(changed([](io::Json& j) {
    j["propeller"].erase("reversed");
    j["actuators"][1]["min_rps"] = 0;
  }));
  // VecTwin rudders need the pitch, which the standard propeller may or may not give.
  const auto twin_rudders = [](io::Json& j) {
    const io::Json twin = io::read_json(io::find_config("ships", "vectwin-3m"));
    j["rudder"] = twin["rudder"];
    j["actuators"].erase(0);
    j["actuators"].push_back(twin["actuators"][0]);
    j["actuators"].push_back(twin["actuators"][1]);
  };
  CHECK_THROWS_WITH(changed(twin_rudders), Contains("/propeller/pitch_ratio: missing"));
  CHECK_NOTHROW(changed([&](io::Json& j) {
    twin_rudders(j);
    j["propeller"]["pitch_ratio"] = 0.7;
  }));
}

TEST_CASE("ship: every part of every shipped ship says where its numbers come from", "[ship]") {
  for (const std::string& name : io::config_names("ships")) {
    const Ship ship = read_ship(name);
    CAPTURE(name);
    CHECK(ship.name == name);
    CHECK_FALSE(ship.description.empty());
    const Actuator* bow_thruster = ship.find_actuator(Channel::n_bt);
    const bool has_current = bow_thruster != nullptr && bow_thruster->n_at_pitch_current_1 > 0.0;
    CHECK(ship.sources.size() == 4 + (ship.modules->propeller ? 2 : 0) + ship.modules->thrusters.size() +
                                     (ship.modules->wind ? 1 : 0) + (has_current ? 1 : 0));
    for (const PartSource& s : ship.sources) CHECK_FALSE(s.source.empty());
  }
}
