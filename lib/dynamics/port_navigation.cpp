#include "dynamics/port_navigation.hpp"

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "core/units.hpp"
#include "dynamics/joystick.hpp"

namespace leeway {
namespace {

using Kind = PilotLeg::Kind;

struct Berth {
  PortEnd end;
  bool is_starboard_side;
  double turn_deg;  // on the spot, to starboard
};

struct CourseChange {
  double angle_deg;
  double share;  // of the route, from the entrance on
};

// Drawn so that they differ in what matters to a model: how often, where, how far and to which side the ship turns.
struct Port {
  std::string_view name;
  double quay_heading_deg;
  std::vector<CourseChange> course_changes;
  std::array<Berth, 2> berths;
};

const std::array<Port, 3>& ports() {
  static const std::array<Port, 3> all{{
      {"north", 40.0, {{55.0, 0.45}}, {{{PortEnd::crab, false, 0.0}, {PortEnd::turn, true, -75.0}}}},
      {"river", 155.0, {{-40.0, 0.3}, {50.0, 0.65}}, {{{PortEnd::hover, true, 0.0}, {PortEnd::turn, false, 60.0}}}},
      {"basin",
       280.0,
       {{30.0, 0.2}, {-45.0, 0.45}, {-35.0, 0.75}},
       {{{PortEnd::crab, true, 0.0}, {PortEnd::hover, false, 0.0}}}},
  }};
  return all;
}

PilotTraits draw_harbor_pilot(const FroudeLaw& law, const Actuator& thruster, RandomStream& stream) {
  PilotTraits pilot;
  pilot.reaction_s = law.time * stream.uniform(0.6, 1.4);
  pilot.interval_s = law.time * stream.uniform(1.8, 3.2);
  pilot.deceleration_mps2 = stream.uniform(0.007, 0.011);
  pilot.heading_s = law.time * stream.uniform(10.0, 16.0);
  pilot.settle_s = law.time * stream.uniform(8.0, 11.0);
  pilot.settle_together_s = law.time * stream.uniform(1.2, 2.2);
  pilot.turn_under_way = stream.uniform(1.6, 2.8) * kDegree / law.time;
  pilot.turn_on_the_spot = stream.uniform(1.5, 2.5) * kDegree / law.time;
  pilot.lookahead_m = law.length * stream.uniform(5.0, 9.0);
  pilot.rudder_step_rad = 5.0 * kDegree;
  pilot.thruster_step_rps = thruster.max / (stream.uniform() < 0.5 ? 12.0 : 6.0);
  pilot.misjudgment = stream.uniform(0.05, 0.2);
  pilot.headway_mps = law.of(Quantity::speed) * stream.uniform(0.025, 0.045);
  pilot.least_headway_mps = 0.8 * pilot.headway_mps;
  pilot.together_rad = stream.uniform() < 0.5 ? 25.0 * kDegree : 35.0 * kDegree;
  pilot.heading_band = stream.uniform(1.0, 3.0) * kDegree;
  pilot.speed_band_mps = law.of(Quantity::speed) * stream.uniform(0.01, 0.03);
  return pilot;
}

// Where the ship has to stop, and what then remains to be done.
struct Arrival {
  Vec3<double> pose = Vec3<double>::Zero();  // heading of the approach
  std::vector<PilotLeg> legs;
  double duration_s = 0.0;
};

Arrival draw_arrival(const PortPlan& plan, const Berth& berth, double L, const FroudeLaw& law, RandomStream& stream) {
  const PilotTraits& pilot = plan.steering.pilot;
  const double to_water = plan.is_starboard_side ? -1.0 : 1.0;  // to starboard of the moored ship
  const double crab = law.of(Quantity::speed) * stream.uniform(0.04, 0.07);
  const double clearance = L * (plan.end == PortEnd::hover  ? stream.uniform(0.25, 0.5)
                                : plan.end == PortEnd::crab ? stream.uniform(0.6, 1.2)
                                                            : stream.uniform(0.5, 0.8));
  const double turn = (berth.turn_deg + stream.uniform(-12.0, 12.0)) * kDegree;
  const Vec3<double> moored(0.0, 0.0, plan.quay_heading);
  const double sideways_s = clearance / crab + 10.0 * law.time;
  // He creeps ahead meanwhile, and so stops short of the berth.
  const Vec3<double> off_berth = moved(moored, -pilot.headway_mps * sideways_s, to_water * clearance);
  Arrival arrival{off_berth, {{Kind::on_the_spot, moored, crab}}, sideways_s};
  if (plan.end == PortEnd::turn) {
    arrival.pose = turned(off_berth, -turn);
    arrival.legs.insert(arrival.legs.begin(), {Kind::on_the_spot, off_berth, crab});
    arrival.duration_s += std::abs(turn) / pilot.turn_on_the_spot + 15.0 * law.time;
  }
  return arrival;
}

}  // namespace

double usual_port_navigation_s(const Ship& ship) { return 320.0 * std::sqrt(ship.particulars.L_pp / kGravity_mps2); }

PortPlan draw_port_navigation(const Ship& ship, double duration_s, RandomStream stream) {
  const Joystick joystick(ship, "port navigation");
  const FroudeLaw law = froude_law(ship);
  const double L = ship.particulars.L_pp;
  const Port& port = ports()[stream.below(ports().size())];
  const Berth& berth = port.berths[stream.below(port.berths.size())];
  PortPlan plan;
  plan.port = port.name;
  plan.end = berth.end;
  plan.is_starboard_side = berth.is_starboard_side;
  plan.quay_heading = port.quay_heading_deg * kDegree;
  PilotTraits& pilot = plan.steering.pilot;
  pilot = draw_harbor_pilot(law, joystick.thruster(), stream);
  Arrival arrival = draw_arrival(plan, berth, L, law, stream);

  // About the speed of the model's constant revolutions, rudders amidships.
  const double harbor = law.of(Quantity::speed) * stream.uniform(0.46, 0.51);
  plan.steering.u0_mps = harbor * stream.uniform(0.85, 1.0);
  const double braking_s = harbor / pilot.deceleration_mps2, braking_m = 0.5 * harbor * braking_s;
  const double steady_s = std::max(duration_s - arrival.duration_s - braking_s, 10.0 * law.time);
  const double route_m = 0.95 * harbor * steady_s + braking_m;  // turning takes some speed

  // Backward, from the pose off the berth to the entrance.
  std::vector<PilotLeg> route{{Kind::fairway, arrival.pose, harbor}};
  Vec3<double> pose = arrival.pose;
  double until = 1.0;
  for (std::size_t i = port.course_changes.size(); i-- > 0;) {
    const CourseChange& change = port.course_changes[i];
    const double share = change.share + stream.uniform(-0.06, 0.06);
    const double angle = change.angle_deg * stream.uniform(0.75, 1.25) * kDegree;
    pose = turned(moved(pose, -(until - share) * route_m, 0.0), -angle);
    const double radius_m = harbor / pilot.turn_under_way;
    const double wheel_over_m = radius_m * std::tan(0.5 * std::abs(angle)) + 3.0 * law.time * harbor;
    route.push_back({Kind::fairway, pose, harbor, (1.0 - share) * route_m,
                     std::min(wheel_over_m, 0.45 * (until - share) * route_m)});
    plan.course_changes.insert(plan.course_changes.begin(), angle);
    until = share;
  }
  plan.steering.start =
      turned(moved(pose, -until * route_m, L * stream.uniform(-0.3, 0.3)), stream.uniform(-5.0, 5.0) * kDegree);
  plan.steering.legs.assign(route.rbegin(), route.rend());
  plan.steering.legs.insert(plan.steering.legs.end(), arrival.legs.begin(), arrival.legs.end());
  return plan;
}

io::Json to_json(const PortPlan& plan) {
  io::Json changes = io::Json::array();
  for (const double angle : plan.course_changes) changes.push_back(rad_to_deg(angle));
  return {{"port", plan.port},
          {"end", kPortEnds[static_cast<std::size_t>(plan.end)]},
          {"quay_side", plan.is_starboard_side ? "starboard" : "port"},
          {"quay_heading_deg", rad_to_deg(plan.quay_heading)},
          {"course_changes_deg", changes},
          {"x0_m", plan.steering.start(0)},
          {"y0_m", plan.steering.start(1)},
          {"psi_deg", rad_to_deg(plan.steering.start(2))}};
}

std::unique_ptr<Maneuver> port_navigation(const Ship& ship, const PortPlan& plan, double duration_s,
                                          RandomStream stream) {
  return piloted(ship, plan.steering, stream, "port navigation", duration_s);
}

}  // namespace leeway
