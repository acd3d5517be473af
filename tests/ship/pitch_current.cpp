#include "ship/pitch_current.hpp"

#include <cmath>

#include <catch2/catch.hpp>

#include "core/errors.hpp"
#include "core/units.hpp"

using namespace leeway;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinRel;

namespace {

Trajectory with_pitch_current() {
  Trajectory recording;
  recording.file = "voyage.csv";
  recording[Channel::t] = {0.0, 1.0, 2.0, 3.0};
  recording[Channel::i_bt] = {0.5, -1.0, kMissing, 0.25};
  return recording;
}

}  // namespace

TEST_CASE("pitch current: n_bt is 30 i_bt at 3 m, and Froude's law of it at 150 m", "[ship]") {
  for (const auto& [name, n_at_1] :
       {std::pair{"vectwin-3m", 30.0}, std::pair{"vectwin-150m", 30.0 / std::sqrt(50.0)}}) {
    const Ship ship = read_ship(name);
    std::vector<Trajectory> recordings{with_pitch_current()};
    add_revolutions(recordings, ship);
    const std::vector<double>& n = recordings[0][Channel::n_bt];
    CHECK_THAT(n[0], WithinRel(0.5 * n_at_1, 1e-11));
    CHECK_THAT(n[1], WithinRel(ship.find_actuator(Channel::n_bt)->min, 1e-11));  // full pitch is the limit
    CHECK(std::isnan(n[2]));
    CHECK(recordings[0][Channel::i_bt][0] == 0.5);

    Trajectory back;
    back[Channel::n_bt] = n;
    add_pitch_current(back, ship);
    CHECK_THAT(back[Channel::i_bt][3], WithinRel(0.25, 1e-14));
  }
}

TEST_CASE("pitch current: recorded revolutions count where both are there", "[ship]") {
  std::vector<Trajectory> recordings{with_pitch_current()};
  recordings[0][Channel::n_bt] = {1.0, 2.0, 3.0, 4.0};
  add_revolutions(recordings, read_ship("vectwin-3m"));
  CHECK(recordings[0][Channel::n_bt] == std::vector{1.0, 2.0, 3.0, 4.0});
}

TEST_CASE("pitch current: a ship that does not state it is an error; one without a bow thruster does not ask",
          "[ship]") {
  std::vector<Trajectory> recordings{with_pitch_current()};
  const Ship esso = read_ship("esso-osaka-3m");
  CHECK_THROWS_WITH(add_revolutions(recordings, esso), Contains("voyage.csv:1: has 'i_bt' and no 'n_bt_rps'") &&
                                                           Contains("'esso-osaka-3m' does not state") &&
                                                           Contains("expected 'pitch_current'"));
  CHECK_THROWS_WITH(add_pitch_current(recordings[0], esso), Contains("no actuator n_bt with a 'pitch_current'"));
  add_revolutions(recordings, read_ship("kvlcc2-l7"));
  CHECK_FALSE(recordings[0].has(Channel::n_bt));
}

TEST_CASE("pitch current: its value follows from the revolutions of a ship that states it", "[ship]") {
  const Ship ship = read_ship("vectwin-3m"), esso = read_ship("esso-osaka-3m");
  Actuators<double> actuators;
  actuators[Channel::n_bt] = -12.0;
  CHECK(knows(ship, Channel::i_bt));
  CHECK_FALSE(knows(esso, Channel::i_bt));
  CHECK(knows(esso, Channel::n_bt));
  CHECK(value_of(Channel::i_bt, actuators, ship) == -0.4);
  CHECK(value_of(Channel::n_bt, actuators, ship) == -12.0);
}
