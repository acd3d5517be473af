#include "gap/detect/effect_library.hpp"

#include <catch2/catch.hpp>

using namespace leeway;

namespace {

// A ship at 0.5 m/s whose heading and rudder swing to and fro.
gap::Campaign swinging(double heading_deg, double rudder_deg) {
  Trajectory recording;
  recording.name = recording.file = "run";
  double x = 0.0, y = 0.0;
  for (int k = 0; k <= 200; ++k) {
    const double t = k, phase = 2.0 * kPi * t / 40.0, psi = heading_deg * kDegree * std::sin(phase);
    x += 0.5 * std::cos(psi), y += 0.5 * std::sin(psi);
    const std::pair<Channel, double> row[] = {{Channel::t, t},
                                              {Channel::x0, x},
                                              {Channel::y0, y},
                                              {Channel::psi, psi},
                                              {Channel::u, 0.5},
                                              {Channel::vm, 0.0},
                                              {Channel::r, heading_deg * kDegree * 2.0 * kPi / 40.0 * std::cos(phase)},
                                              {Channel::delta, -rudder_deg * kDegree * std::sin(phase)},
                                              {Channel::n_p, 10.0}};
    for (const auto& [channel, value] : row) recording[channel].push_back(value);
  }
  return gap::prepare(read_ship("kvlcc2-l7"), {recording}, {});
}

}  // namespace

TEST_CASE("effects: a ship that keeps its course says nothing of how hull and rudder answer", "[gap]") {
  const gap::Identifiable course(swinging(1.0, 0.5)), zigzag(swinging(10.0, 10.0)), led(swinging(10.0, 0.5)),
      pushed(swinging(1.0, 10.0));
  for (const char* effect : {"shallow-water", "rudder-effectiveness", "actuator-delay"}) {
    CHECK_FALSE(course(effect));
    for (const gap::Identifiable* turned : {&zigzag, &led, &pushed}) CHECK((*turned)(effect));
  }
  for (const char* effect : {"steady-current", "thrust-loss", "fouling", "unmeasured-wind", "propeller-walk"})
    CHECK(course(effect));
}
