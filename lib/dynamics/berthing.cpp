#include "dynamics/berthing.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "core/errors.hpp"
#include "core/units.hpp"

namespace leeway {
namespace {

using Kind = BerthingLeg::Kind;

constexpr double kModelLength_m = 3.0;  // of the ship that the numbers here are made for

// Froude's law from the 3 m model to the ship.
struct FroudeScale {
  double length, time, speed;
  explicit FroudeScale(const Ship& ship)
      : length(ship.particulars.L_pp / kModelLength_m), time(std::sqrt(length)), speed(std::sqrt(length)) {}
};

const Actuator& actuator_of(const Ship& ship, Channel channel) {
  const Actuator* actuator = ship.find_actuator(channel);
  if (actuator == nullptr || !ship.has_twin_rudders())
    throw UsageError(fmt::format(
        "berthing needs VecTwin rudders (delta_p, delta_s) and a bow thruster (n_bt), which '{}' does not have",
        ship.name));
  return *actuator;
}

// A point `ahead` along the heading and `to_starboard` of it.
Vec3<double> moved(const Vec3<double>& pose, double ahead, double to_starboard) {
  const double c = std::cos(pose(2)), s = std::sin(pose(2));
  return {pose(0) + c * ahead - s * to_starboard, pose(1) + s * ahead + c * to_starboard, pose(2)};
}

Vec3<double> turned(const Vec3<double>& pose, double angle) { return {pose(0), pose(1), pose(2) + angle}; }

PilotTraits draw_pilot(const Ship& ship, const FroudeScale& scale, RandomStream& stream) {
  PilotTraits pilot;
  pilot.reaction_s = scale.time * stream.uniform(2.0, 6.0);
  pilot.interval_s = scale.time * stream.uniform(5.5, 10.0);
  pilot.deceleration_mps2 = stream.uniform(0.003, 0.006);
  pilot.heading_s = scale.time * stream.uniform(20.0, 32.0);
  pilot.lookahead_m = scale.length * stream.uniform(6.0, 10.0);
  pilot.rudder_step_rad = 5.0 * kDegree;
  pilot.thruster_step_rps = actuator_of(ship, Channel::n_bt).max / (stream.uniform() < 0.5 ? 12.0 : 6.0);
  pilot.misjudgment = stream.uniform(0.05, 0.2);
  return pilot;
}

// The opening (-a, a) of the rudders that comes closest to holding the speed.
void hold_speed(SimulatedShip& ship) {
  const Vec3<double>& nu = ship.state.nu;
  double least = std::numeric_limits<double>::infinity();
  const Actuators<double> at_start = ship.actuators;
  for (int i = 0; i <= 21; ++i) {
    const double a = 5.0 * i * kDegree;
    Actuators<double> actuators = at_start;
    actuators[Channel::delta_p] = actuator_of(ship.ship, Channel::delta_p).clip(-a);
    actuators[Channel::delta_s] = actuator_of(ship.ship, Channel::delta_s).clip(a);
    const double du = std::abs(ship.model.acceleration(nu, actuators, nu.head<2>())(0));
    if (du >= least) continue;
    least = du;
    ship.actuators = actuators;
  }
}

class Berthing : public Maneuver {
 public:
  Berthing(const Ship& ship, BerthingPlan plan, RandomStream stream)
      : scale_(ship),
        L_(ship.particulars.L_pp),
        model_(ship, Effects<double>()),
        port_(actuator_of(ship, Channel::delta_p)),
        starboard_(actuator_of(ship, Channel::delta_s)),
        thruster_(actuator_of(ship, Channel::n_bt)),
        plan_(std::move(plan)),
        stream_(stream) {}

  void order(double t_s, const ShipState<double>& state, Actuators<double>& command) override {
    if (t_s >= order_s_ - kSameTime_s) {
      command = ordered_;
      order_s_ = std::numeric_limits<double>::infinity();
    }
    if (t_s < look_s_ - kSameTime_s) return;
    ordered_ = decide(t_s, state, command);
    const PilotTraits& pilot = plan_.pilot;
    order_s_ = t_s + pilot.reaction_s;
    look_s_ = t_s + std::max(pilot.reaction_s, pilot.interval_s * stream_.uniform(0.7, 1.3));
  }

  std::optional<double> longest_s() const override { return 450.0 * std::sqrt(L_ / kGravity_mps2); }

 private:
  static constexpr double kSameTime_s = 1e-9;
  struct Intention {
    Vec3<double> nu = Vec3<double>::Zero();
    double surge_mps2 = 0.0;  // of a speed that is to change steadily
  };

  Actuators<double> decide(double t_s, const ShipState<double>& state, const Actuators<double>& current) {
    const PilotTraits& pilot = plan_.pilot;
    learn_disturbance(t_s, state, current);
    // Where the ship will be about the middle of the time for which the order stands.
    const double ahead_s = pilot.reaction_s + 0.25 * pilot.interval_s;
    const Vec3<double> pose = moved(state.eta, state.nu(0) * ahead_s, state.nu(1) * ahead_s);
    const Vec3<double> expected = turned(pose, state.nu(2) * ahead_s);
    while (leg_ + 1 < plan_.legs.size() && is_over(plan_.legs[leg_], expected, state.nu)) ++leg_;
    const BerthingLeg& leg = plan_.legs[leg_];
    const Intention intention =
        leg.kind == Kind::under_way ? under_way(leg, expected, state.nu) : on_the_spot(leg, expected);
    const double time_s = std::max(9.0 * scale_.time, 0.9 * (pilot.reaction_s + pilot.interval_s));
    Vec3<double> wanted = (intention.nu - state.nu) / time_s;
    wanted(0) += intention.surge_mps2;
    for (int i = 0; i < 3; ++i) wanted(i) *= 1.0 + pilot.misjudgment * stream_.normal();
    return best_orders(state.nu, wanted - disturbance_, leg.kind == Kind::on_the_spot, current);
  }

  bool is_over(const BerthingLeg& leg, const Vec3<double>& pose, const Vec3<double>& nu) const {
    const Vec2<double> gap = gap_in(leg.pose(2), leg.pose, pose);
    if (leg.kind == Kind::under_way)
      return gap(0) < 0.0 || (leg.stops && gap(0) < 0.4 * L_ && nu(0) < 0.07 * scale_.speed);
    return gap.norm() < 0.3 * L_ && std::abs(wrap_angle(leg.pose(2) - pose(2))) < 8.0 * kDegree;
  }

  // From the ship to a pose, in axes along a heading and to starboard of it.
  static Vec2<double> gap_in(double heading, const Vec3<double>& to, const Vec3<double>& from) {
    const double dx = to(0) - from(0), dy = to(1) - from(1), c = std::cos(heading), s = std::sin(heading);
    return {c * dx + s * dy, -s * dx + c * dy};
  }

  Intention under_way(const BerthingLeg& leg, const Vec3<double>& pose, const Vec3<double>& nu) const {
    const Vec2<double> gap = gap_in(leg.pose(2), leg.pose, pose);
    Intention intention;
    intention.nu(0) = leg.speed_mps;
    if (leg.stops) {
      const double a = plan_.pilot.deceleration_mps2, slow = std::sqrt(2.0 * a * std::max(gap(0), 0.0));
      if (slow < leg.speed_mps) {
        intention.nu(0) = slow;
        if (nu(0) > 0.05 * scale_.speed) intention.surge_mps2 = -a;
      }
    }
    const double drift = std::clamp(std::atan2(nu(1), std::max(nu(0), 0.1 * scale_.speed)), -0.5, 0.5);
    const double course = leg.pose(2) + std::atan(gap(1) / plan_.pilot.lookahead_m);
    const double limit = 2.0 * kDegree / scale_.time;
    intention.nu(2) = std::clamp(wrap_angle(course - pose(2) - drift) / plan_.pilot.heading_s, -limit, limit);
    return intention;
  }

  Intention on_the_spot(const BerthingLeg& leg, const Vec3<double>& pose) const {
    const Vec2<double> gap = gap_in(pose(2), leg.pose, pose);
    const double turn = wrap_angle(leg.pose(2) - pose(2)), position_s = 30.0 * scale_.time;
    Intention intention;
    // He creeps ahead rather than gather sternway, the slower the less room is left.
    const double room = std::min(1.0, 1.0 + gap(0) / (0.3 * L_));
    const double least = std::max(-0.02, 0.01 * room) * scale_.speed;
    intention.nu(0) = std::clamp(gap(0) / position_s, least, 0.06 * scale_.speed);
    intention.nu(1) = std::clamp(gap(1) / position_s, -leg.speed_mps, leg.speed_mps);
    if (std::abs(turn) > 25.0 * kDegree) intention.nu(1) = 0.0;
    const double limit = 2.5 * kDegree / scale_.time;
    intention.nu(2) = std::clamp(turn / plan_.pilot.heading_s, -limit, limit);
    return intention;
  }

  // What the model in calm air does not explain of the acceleration since the last look, smoothed.
  void learn_disturbance(double t_s, const ShipState<double>& state, const Actuators<double>& current) {
    const Vec3<double> now = model_.acceleration(state.nu, current, state.nu.head<2>());
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

  // Of all rudder angles and revolutions that he orders, those whose accelerations come closest to what is wanted;
  // among equals he changes little and keeps the rudders symmetric.
  Actuators<double> best_orders(const Vec3<double>& nu, const Vec3<double>& wanted, bool is_on_the_spot,
                                const Actuators<double>& current) const {
    const double a_0 = 0.005;  // [m/s^2], an acceleration that matters
    const Vec3<double> weights(1.0, is_on_the_spot ? 1.5 : 0.0, 0.5 * L_);
    const auto cost = [&](const Actuators<double>& orders) {
      const Vec3<double> miss = model_.acceleration(nu, orders, nu.head<2>()) - wanted;
      const double p = orders[Channel::delta_p], s = orders[Channel::delta_s], n = orders[Channel::n_bt];
      const double change = std::abs(p - current[Channel::delta_p]) + std::abs(s - current[Channel::delta_s]);  // [rad]
      const double thruster = n / thruster_.max;
      return (weights.cwiseProduct(miss) / a_0).squaredNorm() + 0.02 * change + 0.01 * (p + s) * (p + s) +
             0.02 * thruster * thruster;
    };
    Actuators<double> best = current;
    double least = std::numeric_limits<double>::infinity();
    const auto consider = [&](const Actuators<double>& orders) {
      const double c = cost(orders);
      if (c >= least) return;
      least = c;
      best = orders;
    };
    const double rudder = plan_.pilot.rudder_step_rad, rps = plan_.pilot.thruster_step_rps;
    const auto first = [](double low, double step) { return static_cast<int>(std::ceil(low / step - 1e-9)); };
    const auto last = [](double high, double step) { return static_cast<int>(std::floor(high / step + 1e-9)); };
    const bool thruster_helps = is_on_the_spot || nu(0) < 0.15 * scale_.speed;
    if (!thruster_helps) best[Channel::n_bt] = 0.0;
    for (int round = 0; round < 2; ++round) {  // the thruster acts beside the rudders: two rounds settle both
      Actuators<double> orders = best;
      for (int i = first(port_.min, rudder); i <= last(port_.max, rudder); ++i)
        for (int k = first(starboard_.min, rudder); k <= last(starboard_.max, rudder); ++k) {
          orders[Channel::delta_p] = i * rudder;
          orders[Channel::delta_s] = k * rudder;
          consider(orders);
        }
      if (!thruster_helps) break;
      orders = best;
      for (int i = first(thruster_.min, rps); i <= last(thruster_.max, rps); ++i) {
        orders[Channel::n_bt] = i * rps;
        consider(orders);
      }
    }
    return best;
  }

  FroudeScale scale_;
  double L_;
  Model<double> model_;
  Actuator port_, starboard_, thruster_;
  BerthingPlan plan_;
  RandomStream stream_;
  std::size_t leg_ = 0;
  double look_s_ = 0.0, order_s_ = std::numeric_limits<double>::infinity();
  Actuators<double> ordered_;
  double seen_s_ = 0.0;
  Vec3<double> seen_nu_ = Vec3<double>::Zero(), seen_acceleration_ = Vec3<double>::Zero(),
               disturbance_ = Vec3<double>::Zero();
};

}  // namespace

BerthingPlan draw_berthing(const Ship& ship, RandomStream stream) {
  const FroudeScale scale(ship);
  for (const Channel channel : {Channel::delta_p, Channel::delta_s, Channel::n_bt}) actuator_of(ship, channel);
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
  plan.pilot = draw_pilot(ship, scale, stream);
  const double to_water = plan.is_starboard_side ? -1.0 : 1.0;  // to starboard of the moored ship
  const double speed = scale.speed * stream.uniform(0.2, 0.4), crab = scale.speed * stream.uniform(0.03, 0.08);
  const double clearance = to_water * L * stream.uniform(0.8, 1.5), misplaced = L * stream.uniform(-0.5, 0.0);
  // What the brake takes, and a while at full speed.
  const double distance =
      0.5 * speed * speed / plan.pilot.deceleration_mps2 + speed * scale.time * stream.uniform(5.0, 45.0);
  const double offset = to_water * L * stream.uniform(0.0, 1.5);
  const double angle = stream.uniform(10.0, 40.0) * kDegree, turn = stream.uniform(45.0, 150.0) * kDegree;
  const bool turns_to_starboard = stream.uniform() < 0.5;

  const Vec3<double> berth(0.0, 0.0, plan.quay_heading);
  const Vec3<double> off_berth = moved(berth, misplaced, clearance);
  const BerthingLeg to_berth{Kind::on_the_spot, berth, crab, true};
  switch (plan.pattern) {
    case BerthingPattern::straight:
      plan.start = turned(moved(off_berth, -distance, 0.3 * offset), stream.uniform(-8.0, 8.0) * kDegree);
      plan.u0_mps = speed;
      plan.legs = {{Kind::under_way, off_berth, speed, true}, to_berth};
      break;
    case BerthingPattern::curved:  // from further out, heading for the quay
      plan.start = turned(moved(off_berth, -distance, 0.3 * offset + to_water * 0.5 * distance * std::sin(angle)),
                          -to_water * angle);
      plan.u0_mps = speed;
      plan.legs = {{Kind::under_way, off_berth, speed, true}, to_berth};
      break;
    case BerthingPattern::turn: {  // from the water side
      const Vec3<double> approach = turned(off_berth, -to_water * turn);
      plan.start = turned(moved(approach, -0.4 * distance, 0.0), stream.uniform(-8.0, 8.0) * kDegree);
      plan.u0_mps = 0.6 * speed;
      plan.legs = {{Kind::under_way, approach, 0.6 * speed, true},
                   {Kind::on_the_spot, turned(approach, to_water * turn), crab, true},
                   to_berth};
      break;
    }
    case BerthingPattern::shift: {
      const double shift = 0.5 * distance, clear = to_water * L * 0.6;
      plan.start = moved(berth, -shift, 0.0);
      plan.legs = {{Kind::on_the_spot, moved(berth, -shift, clear), crab, true},
                   {Kind::under_way, moved(berth, misplaced, clear), 0.6 * speed, true},
                   to_berth};
      break;
    }
    case BerthingPattern::leave: {
      const Vec3<double> out = turned(moved(berth, 0.0, clearance), to_water * (turns_to_starboard ? angle : turn));
      plan.start = berth;
      plan.legs = {{Kind::on_the_spot, moved(berth, 0.0, clearance), crab, true},
                   {Kind::on_the_spot, out, crab, true},
                   {Kind::under_way, moved(out, 100.0 * L, 0.0), speed, false}};
      break;
    }
  }
  return plan;
}

io::Json to_json(const BerthingPlan& plan) {
  return {{"pattern", kBerthingPatterns[static_cast<std::size_t>(plan.pattern)]},
          {"quay_side", plan.is_starboard_side ? "starboard" : "port"},
          {"quay_heading_deg", rad_to_deg(plan.quay_heading)},
          {"x0_m", plan.start(0)},
          {"y0_m", plan.start(1)},
          {"psi_deg", rad_to_deg(plan.start(2))}};
}

MeanWind draw_mean_wind(const Ship& ship, RandomStream stream) {
  const double speed = FroudeScale(ship).speed * stream.uniform();
  return {speed, 2.0 * kPi * stream.uniform()};
}

SimulatedShip berthing_start(const Ship& ship, const BerthingPlan& plan) {
  SimulatedShip start(ship, plan.u0_mps);
  start.state.eta = plan.start;
  start.state.nu = water_velocity(start.model, start.state.eta, 0.0);
  start.state.nu(0) += plan.u0_mps;
  hold_speed(start);
  return start;
}

std::unique_ptr<Maneuver> berthing(const Ship& ship, BerthingPlan plan, RandomStream stream) {
  if (plan.legs.empty()) throw UsageError("a berthing plan needs a leg");
  return std::make_unique<Berthing>(ship, std::move(plan), stream);
}

}  // namespace leeway
