#include "gap/show/maneuver_menu.hpp"

#include <algorithm>

#include "core/random.hpp"
#include "core/units.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {

std::vector<MenuItem> maneuver_menu(const Ship& ship, double time_scale) {
  constexpr const ShowPolicy& policy = kPolicy.show;
  const double largest = policy.turning_rudder_deg * kDegree;
  const auto turn = [&](double sign) {
    return ManeuverRun{0.0, [=](const SimulatedShip& s) { return turning(s.ship, sign * largest); }};
  };
  const auto zigzag_of = [](double deg) {
    return ManeuverRun{0.0, [=](const SimulatedShip& s) { return zigzag(s.ship, deg * kDegree, deg * kDegree); }};
  };
  const auto straight_at = [](double heading) {
    return ManeuverRun{heading, [](const SimulatedShip& s) { return straight(s.ship, course_keeper(s)); }};
  };
  const auto pulses = [](const SimulatedShip& at) { return thruster_pulses(at, thruster_pulses_for(at.ship)); };
  const double s = time_scale;
  std::vector<MenuItem> menu{
      {"a straight run and its reciprocal", "straight", policy.straight_s * s, {straight_at(0.0), straight_at(kPi)}},
      {"turning circles, 35 deg to both sides",
       "turning --rudder-deg 35",
       policy.turning_s * s,
       {turn(1.0), turn(-1.0)}},
      {"a zigzag 10/10", "zigzag --rudder-deg 10 --heading-deg 10", policy.zigzag_s * s, {zigzag_of(10.0)}},
      {"a zigzag 20/20", "zigzag --rudder-deg 20 --heading-deg 20", policy.zigzag_s * s, {zigzag_of(20.0)}},
      {"a coast-down with stopped propeller",
       "coast-down",
       policy.stopping_s * s,
       {{0.0, [](const SimulatedShip& at) { return coast_down(at); }}}},
      {"a crash stop",
       "crash-stop",
       policy.stopping_s * s,
       {{0.0, [](const SimulatedShip& at) { return crash_stop(at); }}}},
      {"a pull-out",
       "pull-out",
       policy.pull_out_s * s,
       {{0.0, [=](const SimulatedShip& at) { return pull_out(at, policy.pull_out_rudder_deg * kDegree); }}}},
      {"random orders to all actuators",
       "random",
       policy.orders_s * s,
       {{0.0, [](const SimulatedShip& at) { return random_orders(at.ship, RandomStream(1, "next-maneuver")); }}}},
  };
  if (std::any_of(ship.actuators.begin(), ship.actuators.end(),
                  [](const Actuator& a) { return a.channel == Channel::n_bt || a.channel == Channel::n_st; }))
    menu.push_back({"thruster pulses", "thruster-pulses", policy.orders_s * s, {{0.0, pulses}}});
  return menu;
}

}  // namespace leeway::gap
