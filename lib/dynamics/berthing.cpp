#include "dynamics/berthing.hpp"

#include <cmath>
#include <limits>

#include <nlohmann/json.hpp>

#include "core/units.hpp"
#include "dynamics/joystick.hpp"

namespace leeway {
namespace {

using Kind = PilotLeg::Kind;

constexpr double kGoesOn = std::numeric_limits<double>::infinity();

PilotTraits draw_pilot(const FroudeLaw& law, const Actuator& thruster, RandomStream& stream) {
  PilotTraits pilot;
  pilot.reaction_s = law.time * stream.uniform(2.0, 6.0);
  pilot.interval_s = law.time * stream.uniform(5.5, 10.0);
  pilot.deceleration_mps2 = stream.uniform(0.003, 0.006);
  pilot.heading_s = law.time * stream.uniform(20.0, 32.0);
  pilot.settle_s = law.time * 9.0;
  pilot.turn_under_way = 2.0 * kDegree / law.time;
  pilot.turn_on_the_spot = 2.5 * kDegree / law.time;
  pilot.lookahead_m = law.length * stream.uniform(6.0, 10.0);
  pilot.rudder_step_rad = 5.0 * kDegree;
  pilot.thruster_step_rps = thruster.max / (stream.uniform() < 0.5 ? 12.0 : 6.0);
  pilot.misjudgment = stream.uniform(0.05, 0.2);
  pilot.headway_mps = 0.01 * law.of(Quantity::speed);
  pilot.least_headway_mps = -0.02 * law.of(Quantity::speed);
  return pilot;
}

}  // namespace

BerthingPlan draw_berthing(const Ship& ship, RandomStream stream) {
  const Joystick joystick(ship, "berthing");
  const FroudeLaw law = froude_law(ship);
  const double of_speed = law.of(Quantity::speed);
  const double L = ship.particulars.L_pp;
  BerthingPlan plan;
  const double lot = stream.uniform();
  plan.pattern = lot < 0.3    ? BerthingPattern::straight
                 : lot < 0.6  ? BerthingPattern::curved
                 : lot < 0.8  ? BerthingPattern::turn
                 : lot < 0.92 ? BerthingPattern::shift
                              : BerthingPattern::leave;
  plan.is_starboard_side = stream.uniform() < 0.5;
  plan.quay_heading = stream.uniform(0.0, 2.0 * kPi);
  PilotTraits& pilot = plan.steering.pilot;
  pilot = draw_pilot(law, joystick.thruster(), stream);
  const double to_water = plan.is_starboard_side ? -1.0 : 1.0;  // to starboard of the moored ship
  const double speed = of_speed * stream.uniform(0.2, 0.4), crab = of_speed * stream.uniform(0.03, 0.08);
  const double clearance = to_water * L * stream.uniform(0.8, 1.5), misplaced = L * stream.uniform(-0.5, 0.0);
  // What the brake takes, and a while at full speed.
  const double distance = 0.5 * speed * speed / pilot.deceleration_mps2 + speed * law.time * stream.uniform(5.0, 45.0);
  const double offset = to_water * L * stream.uniform(0.0, 1.5);
  const double angle = stream.uniform(10.0, 40.0) * kDegree, turn = stream.uniform(45.0, 150.0) * kDegree;
  const bool turns_to_starboard = stream.uniform() < 0.5;

  const Vec3<double> berth(0.0, 0.0, plan.quay_heading);
  const Vec3<double> off_berth = moved(berth, misplaced, clearance);
  const PilotLeg to_berth{Kind::on_the_spot, berth, crab};
  switch (plan.pattern) {
    case BerthingPattern::straight:
      plan.steering.start = turned(moved(off_berth, -distance, 0.3 * offset), stream.uniform(-8.0, 8.0) * kDegree);
      plan.steering.u0_mps = speed;
      plan.steering.legs = {{Kind::under_way, off_berth, speed}, to_berth};
      break;
    case BerthingPattern::curved:  // from further out, heading for the quay
      plan.steering.start = turned(
          moved(off_berth, -distance, 0.3 * offset + to_water * 0.5 * distance * std::sin(angle)), -to_water * angle);
      plan.steering.u0_mps = speed;
      plan.steering.legs = {{Kind::under_way, off_berth, speed}, to_berth};
      break;
    case BerthingPattern::turn: {  // from the water side
      const Vec3<double> approach = turned(off_berth, -to_water * turn);
      plan.steering.start = turned(moved(approach, -0.4 * distance, 0.0), stream.uniform(-8.0, 8.0) * kDegree);
      plan.steering.u0_mps = 0.6 * speed;
      plan.steering.legs = {{Kind::under_way, approach, 0.6 * speed},
                            {Kind::on_the_spot, turned(approach, to_water * turn), crab},
                            to_berth};
      break;
    }
    case BerthingPattern::shift: {
      const double shift = 0.5 * distance, clear = to_water * L * 0.6;
      plan.steering.start = moved(berth, -shift, 0.0);
      plan.steering.legs = {{Kind::on_the_spot, moved(berth, -shift, clear), crab},
                            {Kind::under_way, moved(berth, misplaced, clear), 0.6 * speed},
                            to_berth};
      break;
    }
    case BerthingPattern::leave: {
      const Vec3<double> out = turned(moved(berth, 0.0, clearance), to_water * (turns_to_starboard ? angle : turn));
      plan.steering.start = berth;
      plan.steering.legs = {{Kind::on_the_spot, moved(berth, 0.0, clearance), crab},
                            {Kind::on_the_spot, out, crab},
                            {Kind::under_way, moved(out, 100.0 * L, 0.0), speed, kGoesOn}};
      break;
    }
  }
  return plan;
}

io::Json to_json(const BerthingPlan& plan) {
  return {{"pattern", kBerthingPatterns[static_cast<std::size_t>(plan.pattern)]},
          {"quay_side", plan.is_starboard_side ? "starboard" : "port"},
          {"quay_heading_deg", rad_to_deg(plan.quay_heading)},
          {"x0_m", plan.steering.start(0)},
          {"y0_m", plan.steering.start(1)},
          {"psi_deg", rad_to_deg(plan.steering.start(2))}};
}

MeanWind draw_mean_wind(const Ship& ship, RandomStream stream) {
  const double speed = froude_law(ship).of(Quantity::speed) * stream.uniform();
  return {speed, 2.0 * kPi * stream.uniform()};
}

std::unique_ptr<Maneuver> berthing(const Ship& ship, const BerthingPlan& plan, RandomStream stream) {
  const double longest_s = 450.0 * std::sqrt(ship.particulars.L_pp / kGravity_mps2);
  return piloted(ship, plan.steering, stream, "berthing", longest_s);
}

}  // namespace leeway
