#include "ship/ship.hpp"

#include <catch2/catch.hpp>

#include "core/errors.hpp"
#include "core/units.hpp"
#include "io/files.hpp"
#include "io/json.hpp"
#include "temporary_folder.hpp"

using namespace leeway;
using Catch::Matchers::Contains;

namespace {

// Reads vectwin-3m with one change.
template <typename Change>
void read_changed(const Change& change) {
  io::Json json = io::read_json(io::find_config("ships", "vectwin-3m"));
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
  CHECK(esso.actuator_channels() == std::vector{Channel::delta, Channel::n_p});
  CHECK(esso.thrusters.empty());
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
  CHECK_THROWS_AS(read_ship("no-such-ship"), UsageError);
}
