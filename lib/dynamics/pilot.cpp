#include "dynamics/pilot.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/errors.hpp"
#include "core/units.hpp"
#include "dynamics/joystick.hpp"

namespace leeway {
namespace {

using Kind = PilotLeg::Kind;

constexpr double kModelLength_m = 3.0;  // of the ship that plans are made for
constexpr double kSameStep_s = 1e-9;
constexpr double kMostToLine = 15.0 * kDegree;  // in a fairway: from its direction
constexpr double kNever_s = std::numeric_limits<double>::infinity();

// The opening (-a, a) of the rudders that comes closest to holding the speed.
void hold_speed(SimulatedShip& ship) {
  const Vec3<double>& nu = ship.state.nu;
  double least = std::numeric_limits<double>::infinity();
  const Actuators<double> at_start = ship.actuators;
  for (int i = 0; i <= 21; ++i) {
    const double a = 5.0 * i * kDegree;
    Actuators<double> actuators = at_start;
    actuators[Channel::delta_p] = ship.ship.find_actuator(Channel::delta_p)->clip(-a);
    actuators[Channel::delta_s] = ship.ship.find_actuator(Channel::delta_s)->clip(a);
    const double du = std::abs(ship.model.acceleration(nu, actuators, nu.head<2>())(0));
    if (du >= least) continue;
    least = du;
    ship.actuators = actuators;
  }
}

// From the ship to a pose, in axes along a heading and to starboard of it.
Vec2<double> gap_in(double heading, const Vec3<double>& to, const Vec3<double>& from) {
  const double dx = to(0) - from(0), dy = to(1) - from(1), c = std::cos(heading), s = std::sin(heading);
  return {c * dx + s * dy, -s * dx + c * dy};
}

class Pilot : public Maneuver {
 public:
  Pilot(const Ship& ship, PilotPlan plan, RandomStream stream, std::string_view maneuver, double longest_s)
      : law_(froude_law(ship)),
        L_(ship.particulars.L_pp),
        joystick_(ship, maneuver),
        plan_(std::move(plan)),
        stream_(stream),
        longest_s_(longest_s) {}

  void order(double t_s, const ShipState<double>& state, Actuators<double>& command) override {
    if (t_s >= order_s_ - kSameStep_s) {
      command = ordered_;
      order_s_ = kNever_s;
    }
    if (t_s < look_s_ - kSameStep_s) return;
    ordered_ = decide(t_s, state, command);
    const PilotTraits& pilot = plan_.pilot;
    order_s_ = t_s + pilot.reaction_s;
    look_s_ = t_s + std::max(pilot.reaction_s, pilot.interval_s * stream_.uniform(0.7, 1.3));
  }

  std::optional<double> longest_s() const override { return longest_s_; }

 private:
  struct Intention {
    Vec3<double> nu = Vec3<double>::Zero();
    double surge_mps2 = 0.0;    // of a speed that is to change steadily
    bool leaves_speed = false;  // the speed is right enough
  };

  Actuators<double> decide(double t_s, const ShipState<double>& state, const Actuators<double>& current) {
    const PilotTraits& pilot = plan_.pilot;
    learn_disturbance(t_s, state, current);
    // Where the ship will be about the middle of the time for which the order stands.
    const double ahead_s = pilot.reaction_s + 0.25 * pilot.interval_s;
    const Vec3<double> pose = moved(state.eta, state.nu(0) * ahead_s, state.nu(1) * ahead_s);
    const Vec3<double> expected = turned(pose, state.nu(2) * ahead_s);
    while (leg_ + 1 < plan_.legs.size() && is_over(plan_.legs[leg_], expected, state.nu)) ++leg_;
    const PilotLeg& leg = plan_.legs[leg_];
    const Intention intention =
        leg.kind == Kind::on_the_spot ? on_the_spot(leg, expected) : under_way(leg, expected, state.nu);
    const bool is_slow = state.nu(0) < 0.15 * law_.of(Quantity::speed);
    const bool together = leg.kind == Kind::fairway && !is_slow;
    const double time_s = std::max(pilot.settle_s, 0.9 * (pilot.reaction_s + pilot.interval_s));
    Vec3<double> wanted = (intention.nu - state.nu) / time_s;
    if (together) wanted(2) *= time_s / pilot.settle_together_s;
    wanted(0) += intention.surge_mps2;
    for (int i = 0; i < 3; ++i) wanted(i) *= 1.0 + pilot.misjudgment * stream_.normal();
    const Joystick::Steps steps{pilot.rudder_step_rad, pilot.thruster_step_rps};
    if (together)
      return joystick_.together(state.nu, wanted - disturbance_, pilot.together_rad, intention.leaves_speed, steps,
                                current);
    const bool sways = leg.kind == Kind::on_the_spot;
    return joystick_.each_alone(state.nu, wanted - disturbance_, sways, sways || is_slow, steps, current);
  }

  bool is_over(const PilotLeg& leg, const Vec3<double>& pose, const Vec3<double>& nu) const {
    const Vec2<double> gap = gap_in(leg.pose(2), leg.pose, pose);
    if (leg.kind == Kind::on_the_spot)
      return gap.norm() < 0.3 * L_ && std::abs(wrap_angle(leg.pose(2) - pose(2))) < 8.0 * kDegree;
    const bool stops = leg.way_to_stop_m == 0.0;
    return gap(0) < leg.leave_m || (stops && gap(0) < 0.4 * L_ && nu(0) < 0.07 * law_.of(Quantity::speed));
  }

  Intention under_way(const PilotLeg& leg, const Vec3<double>& pose, const Vec3<double>& nu) const {
    const PilotTraits& pilot = plan_.pilot;
    const Vec2<double> gap = gap_in(leg.pose(2), leg.pose, pose);
    const double a = pilot.deceleration_mps2;
    const double slow = std::sqrt(2.0 * a * std::max(gap(0) + leg.way_to_stop_m, 0.0));
    Intention intention;
    intention.nu(0) = leg.speed_mps;
    if (slow < leg.speed_mps) {
      intention.nu(0) = leg.kind == Kind::fairway ? std::max(slow, pilot.headway_mps) : slow;
      if (nu(0) > 0.05 * law_.of(Quantity::speed)) intention.surge_mps2 = -a;
    }
    const double drift = std::clamp(std::atan2(nu(1), std::max(nu(0), 0.1 * law_.of(Quantity::speed))), -0.5, 0.5);
    double to_line = std::atan(gap(1) / pilot.lookahead_m);
    if (leg.kind == Kind::fairway) to_line = std::clamp(to_line, -kMostToLine, kMostToLine);
    double turn = wrap_angle(leg.pose(2) + to_line - pose(2) - drift);
    if (leg.kind == Kind::fairway) {
      if (std::abs(turn) < pilot.heading_band) turn = 0.0;
      intention.leaves_speed = std::abs(nu(0) - intention.nu(0)) < pilot.speed_band_mps;
    }
    intention.nu(2) = std::clamp(turn / pilot.heading_s, -pilot.turn_under_way, pilot.turn_under_way);
    return intention;
  }

  Intention on_the_spot(const PilotLeg& leg, const Vec3<double>& pose) const {
    const PilotTraits& pilot = plan_.pilot;
    const Vec2<double> gap = gap_in(pose(2), leg.pose, pose);
    const double turn = wrap_angle(leg.pose(2) - pose(2)), position_s = 30.0 * law_.time;
    Intention intention;
    // He creeps ahead rather than gather sternway, the slower the less room is left.
    const double room = std::min(1.0, 1.0 + gap(0) / (0.3 * L_));
    const double least = std::max(pilot.least_headway_mps, pilot.headway_mps * room);
    intention.nu(0) = std::clamp(gap(0) / position_s, least, 0.06 * law_.of(Quantity::speed));
    intention.nu(1) = std::clamp(gap(1) / position_s, -leg.speed_mps, leg.speed_mps);
    if (std::abs(turn) > 25.0 * kDegree) intention.nu(1) = 0.0;
    intention.nu(2) = std::clamp(turn / pilot.heading_s, -pilot.turn_on_the_spot, pilot.turn_on_the_spot);
    return intention;
  }

  // What the model in calm air does not explain of the acceleration since the last look, smoothed.
  void learn_disturbance(double t_s, const ShipState<double>& state, const Actuators<double>& current) {
    const Vec3<double> now = joystick_.acceleration(state.nu, current);
    if (t_s > seen_s_) {
      const Vec3<double> actual = (state.nu - seen_nu_) / (t_s - seen_s_);
      const Vec3<double> unexplained = actual - 0.5 * (now + seen_acceleration_);
      const double most = 0.008;  // [m/s^2], more than wind does
      for (int i = 0; i < 3; ++i) {
        const double limit = i < 2 ? most : most / L_;
        disturbance_(i) += 0.35 * (std::clamp(unexplained(i), -limit, limit) - disturbance_(i));
      }
    }
    seen_s_ = t_s;
    seen_nu_ = state.nu;
    seen_acceleration_ = now;
  }

  FroudeLaw law_;
  double L_;
  Joystick joystick_;
  PilotPlan plan_;
  RandomStream stream_;
  double longest_s_;
  std::size_t leg_ = 0;
  double look_s_ = 0.0, order_s_ = kNever_s;
  Actuators<double> ordered_;
  double seen_s_ = 0.0;
  Vec3<double> seen_nu_ = Vec3<double>::Zero(), seen_acceleration_ = Vec3<double>::Zero(),
               disturbance_ = Vec3<double>::Zero();
};

}  // namespace

FroudeLaw froude_law(const Ship& ship) { return FroudeLaw(ship.particulars.L_pp / kModelLength_m); }

Vec3<double> moved(const Vec3<double>& pose, double ahead, double to_starboard) {
  const double c = std::cos(pose(2)), s = std::sin(pose(2));
  return {pose(0) + c * ahead - s * to_starboard, pose(1) + s * ahead + c * to_starboard, pose(2)};
}

Vec3<double> turned(const Vec3<double>& pose, double angle) { return {pose(0), pose(1), pose(2) + angle}; }

SimulatedShip ship_at_start(const Ship& ship, const PilotPlan& plan) {
  SimulatedShip start(ship, plan.u0_mps);
  start.state.eta = plan.start;
  start.state.nu = water_velocity(start.model, start.state.eta, 0.0);
  start.state.nu(0) += plan.u0_mps;
  hold_speed(start);
  return start;
}

std::unique_ptr<Maneuver> piloted(const Ship& ship, PilotPlan plan, RandomStream stream, std::string_view maneuver,
                                  double longest_s) {
  if (plan.legs.empty()) throw UsageError("a pilot's plan needs a leg");
  return std::make_unique<Pilot>(ship, std::move(plan), stream, maneuver, longest_s);
}

}  // namespace leeway
