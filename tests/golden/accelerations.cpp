#include <catch2/catch.hpp>

#include "core/units.hpp"
#include "dynamics/model.hpp"

using namespace leeway;
using Catch::Matchers::WithinRel;

// Golden values: leeway's own accelerations, written down when vectwin-3m agreed with an independent code to 6e-5 of
// each axis's rms and esso-osaka-3m followed the recorded tests of the model. They are no reference; they guard against
// change.
TEST_CASE("model: accelerations of eight states are what they were", "[golden]") {
  struct State {
    const char* ship;
    Vec3<double> nu;
    double delta_p_deg, delta_s_deg, n_p, n_bt;  // delta_p_deg is the one rudder of a ship that has one
    Vec2<double> apparent_wind;
    Vec3<double> acceleration;
  };
  const State states[] = {
      {"vectwin-3m",
       {0.41, 0.03, 0.02},
       -12,
       14,
       10,
       8,
       {0.9, -0.6},
       {0.00316516559045, -0.00955881602888, -0.00712804828865}},
      {"vectwin-3m",
       {0.22, -0.09, -0.05},
       -80,
       71,
       10,
       -22,
       {-1.1, 0.4},
       {0.00535703419508, 0.0213336374963, 0.0185216705055}},
      {"vectwin-3m",
       {-0.18, 0.06, 0.04},
       -105,
       104,
       10,
       25,
       {0.2, 1.3},
       {0.00243320802666, -0.00501952512511, 8.85625203091e-05}},
      {"vectwin-3m",
       {0.03, 0.12, -0.08},
       -35,
       52,
       15,
       -5,
       {-0.7, -1.6},
       {0.0106084565947, -0.0211778895536, 0.0124575376321}},
      {"esso-osaka-3m",
       {0.41, 0.03, 0.015},
       12,
       0,
       10,
       0,
       {0.9, -0.6},
       {-2.58332060335e-05, -0.00624225485932, -0.00816740366822}},
      {"esso-osaka-3m",
       {0.22, -0.09, -0.05},
       -33,
       0,
       3,
       0,
       {-1.1, 0.4},
       {0.00666207886567, 0.0177284201241, 0.0229653486878}},
      {"esso-osaka-3m",
       {0.17, 0.04, 0.06},
       21,
       0,
       -14,
       0,
       {0.2, 1.3},
       {-0.00404525100455, -0.0120160876362, -0.0110302471674}},
      {"esso-osaka-3m",
       {-0.13, -0.05, 0.03},
       -17,
       0,
       -9,
       0,
       {-0.7, -1.6},
       {-0.00320540328011, 0.00868923260336, -0.00974163676911}},
  };
  for (const State& s : states) {
    const Ship ship = read_ship(s.ship);
    Actuators<double> actuators;
    if (ship.find_actuator(Channel::delta) != nullptr) actuators[Channel::delta] = s.delta_p_deg * kDegree;
    actuators[Channel::delta_p] = s.delta_p_deg * kDegree;
    actuators[Channel::delta_s] = s.delta_s_deg * kDegree;
    actuators[Channel::n_p] = s.n_p;
    actuators[Channel::n_bt] = s.n_bt;
    const Vec3<double> acceleration = Model<double>(ship).acceleration(s.nu, actuators, s.apparent_wind);
    CAPTURE(s.ship, s.nu.transpose());
    for (int i = 0; i < 3; ++i) CHECK_THAT(acceleration(i), WithinRel(s.acceleration(i), 1e-10));
  }
}
