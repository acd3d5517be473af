#include "dynamics/phased_maneuvers.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/errors.hpp"
#include "core/units.hpp"

namespace leeway {
namespace {

constexpr double kSteadyBand = 0.001;   // of u0/L_pp
constexpr double kSteadyLengths = 5.0;  // L_pp/u0
constexpr double kHoldLengths = 60.0;
constexpr double kApproachLengths = 5.0;
constexpr double kStopLengths = 200.0;
constexpr double kCoastLengths = 300.0;
constexpr double kCoastSpeed = 0.1;                       // of the speed at the start
constexpr double kPulseTimes = 40.0, kRestTimes = 120.0;  // sqrt(L_pp/g)

enum class Until { time, turn_is_steady, stopped, slow };

struct PlannedPhase {
  Actuators<double> command;
  double order;  // see Phase
  Until until;
  double longest_s;
  bool keeps_course = false;
};

class PhasedManeuver : public Maneuver {
 public:
  PhasedManeuver(const SimulatedShip& start, std::vector<PlannedPhase> plan)
      : ship_(start.ship), plan_(std::move(plan)), u0_mps_(start.surge_through_water()) {
    if (u0_mps_ > 0.0) keeper_ = course_keeper(start);
  }

  void order(double t_s, const ShipState<double>& state, Actuators<double>& command) override {
    if (phases_.empty()) begin_phase(t_s, state);
    if (!is_done()) {
      Phase& phase = phases_.back();
      phase.end_s = t_s;
      phase.is_fulfilled = has_come(t_s, state);
      phase.is_complete = phase.is_fulfilled || t_s - phase.start_s >= planned().longest_s - kSameStep_s;
      if (phase.is_complete && phases_.size() < plan_.size()) begin_phase(t_s, state);
    }
    command = planned().command;
    if (planned().keeps_course) order_rudders(ship_, keeper_.rudder(state), command);
  }

  bool is_done() const override { return phases_.size() == plan_.size() && phases_.back().is_complete; }

  std::optional<double> longest_s() const override {
    double sum = 0.0;
    for (const PlannedPhase& phase : plan_) sum += phase.longest_s;
    return 1.5 * sum;  // phases end at time steps, so each may take a little longer
  }

  std::vector<Phase> phases() const override { return phases_; }

 private:
  static constexpr double kSameStep_s = 1e-9;

  const PlannedPhase& planned() const { return plan_[phases_.size() - 1]; }

  void begin_phase(double t_s, const ShipState<double>& state) {
    phases_.push_back({t_s, t_s, plan_[phases_.size()].order});
    begin_band(t_s, state.nu(2));
  }

  void begin_band(double t_s, double r) {
    band_start_s_ = t_s;
    r_min_ = r_max_ = r;
  }

  bool has_come(double t_s, const ShipState<double>& state) {
    switch (planned().until) {
      case Until::time:
        return false;
      case Until::stopped:
        return state.nu(0) <= 0.0;
      case Until::slow:
        return state.nu.head<2>().norm() <= kCoastSpeed * u0_mps_;
      case Until::turn_is_steady:
        break;
    }
    const double r = state.nu(2), u0_per_L = u0_mps_ / ship_.particulars.L_pp;
    r_min_ = std::min(r_min_, r);
    r_max_ = std::max(r_max_, r);
    if (r_max_ - r_min_ > kSteadyBand * u0_per_L) begin_band(t_s, r);
    return t_s - band_start_s_ >= kSteadyLengths / u0_per_L;
  }

  Ship ship_;
  std::vector<PlannedPhase> plan_;
  double u0_mps_;
  CourseKeeper keeper_;
  std::vector<Phase> phases_;
  double band_start_s_ = 0.0, r_min_ = 0.0, r_max_ = 0.0;
};

// L_pp/u0, the time of one ship length.
double length_time_s(const SimulatedShip& start, const char* maneuver) {
  const double u0 = start.surge_through_water();
  if (!(u0 > 0.0))
    throw UsageError(fmt::format("{} needs a speed ahead at the start, got {} m/s: set --u0-mps", maneuver, u0));
  return start.ship.particulars.L_pp / u0;
}

// Throws where a rudder cannot do it: what is read off would belong to another angle.
PlannedPhase with_rudder(const SimulatedShip& start, double rudder_rad, double hold_s) {
  for (const Actuator& actuator : start.ship.actuators)
    if (actuator.is_rudder() && std::abs(actuator.clip(rudder_rad) - rudder_rad) > 1e-9)
      throw UsageError(fmt::format("a rudder angle of {:g} deg is outside the limits {:g} to {:g} deg of '{}'",
                                   rad_to_deg(rudder_rad), rad_to_deg(actuator.min), rad_to_deg(actuator.max),
                                   info(actuator.channel).name));
  PlannedPhase phase{start.actuators, rudder_rad, Until::turn_is_steady, hold_s};
  order_rudders(start.ship, rudder_rad, phase.command);
  return phase;
}

int whole_steps(double whole, double step, const char* whole_name, const char* step_name) {
  const double ratio = whole / step;
  if (!(step > 0.0) || !(ratio > 0.5) || ratio > 1000.0 || std::abs(ratio - std::round(ratio)) > 1e-6)
    throw UsageError(fmt::format("the {} must be a multiple of the {}, but {:g} deg is not one of {:g} deg", whole_name,
                                 step_name, rad_to_deg(whole), rad_to_deg(step)));
  return static_cast<int>(std::lround(ratio));
}

}  // namespace

std::unique_ptr<Maneuver> pull_out(const SimulatedShip& start, double rudder_rad, double amidships_rad,
                                   std::optional<double> hold_s) {
  const double hold = hold_s.value_or(kHoldLengths * length_time_s(start, "pull-out"));
  std::vector<PlannedPhase> plan;
  for (const double rudder : {rudder_rad, amidships_rad, -rudder_rad, amidships_rad})
    plan.push_back(with_rudder(start, rudder, hold));
  return std::make_unique<PhasedManeuver>(start, std::move(plan));
}

std::unique_ptr<Maneuver> spiral(const SimulatedShip& start, double rudder_rad, double step_rad, double fine_step_rad,
                                 std::optional<double> hold_s) {
  const double hold = hold_s.value_or(kHoldLengths * length_time_s(start, "spiral"));
  const int coarse = whole_steps(rudder_rad, step_rad, "largest rudder angle", "step");
  const int fine = whole_steps(step_rad, fine_step_rad, "step", "fine step");
  std::vector<double> leg;  // to port
  leg.reserve(2 * static_cast<std::size_t>(coarse + fine));
  for (int i = coarse; i > 1; --i) leg.push_back(i * step_rad);
  for (int i = fine; i >= -fine; --i) leg.push_back(i * step_rad / fine);
  for (int i = 2; i <= coarse; ++i) leg.push_back(-i * step_rad);
  std::vector<PlannedPhase> plan;
  plan.reserve(2 * leg.size());
  for (const double rudder : leg) plan.push_back(with_rudder(start, rudder, hold));
  for (auto rudder = leg.rbegin() + 1; rudder != leg.rend(); ++rudder)
    plan.push_back(with_rudder(start, *rudder, hold));
  return std::make_unique<PhasedManeuver>(start, std::move(plan));
}

std::unique_ptr<Maneuver> crash_stop(const SimulatedShip& start, std::optional<double> approach_s,
                                     std::optional<double> astern_rps) {
  const double length_s = length_time_s(start, "crash-stop");
  const Ship& ship = start.ship;
  const Actuator propeller = ship.propulsion().front();
  const Actuator *port = ship.find_actuator(Channel::delta_p), *starboard = ship.find_actuator(Channel::delta_s);
  const double ahead_rps = start.actuators[propeller.channel];
  PlannedPhase astern{start.actuators, ahead_rps, Until::stopped, kStopLengths * length_s};
  order_rudders(ship, 0.0, astern.command);
  if (propeller.min < 0.0 || astern_rps) {
    astern.order = astern_rps.value_or(std::max(-std::abs(ahead_rps), propeller.min));
    if (!(astern.order < 0.0) || propeller.clip(astern.order) != astern.order)
      throw UsageError(
          fmt::format("expected revolutions astern below 0 within the limits {} to {} 1/s of the ship '{}', got {}",
                      propeller.min, propeller.max, ship.name, astern.order));
    ship.order_propulsion(astern.order, astern.command);
  } else if (port != nullptr && starboard != nullptr) {
    astern.command[Channel::delta_p] = port->min;
    astern.command[Channel::delta_s] = starboard->max;
  } else {
    throw UsageError(
        fmt::format("the ship '{}' cannot stop: its propeller does not reverse and it has no twin rudders", ship.name));
  }
  PlannedPhase approach{start.actuators, ahead_rps, Until::time, approach_s.value_or(kApproachLengths * length_s)};
  approach.keeps_course = true;
  return std::make_unique<PhasedManeuver>(start, std::vector<PlannedPhase>{approach, astern});
}

std::unique_ptr<Maneuver> coast_down(const SimulatedShip& start) {
  const double length_s = length_time_s(start, "coast-down");
  PlannedPhase phase{start.actuators, 0.0, Until::slow, kCoastLengths * length_s};
  order_rudders(start.ship, 0.0, phase.command);
  start.ship.order_propulsion(0.0, phase.command);
  return std::make_unique<PhasedManeuver>(start, std::vector<PlannedPhase>{phase});
}

ThrusterPulses thruster_pulses_for(const Ship& ship, std::optional<Channel> thruster) {
  ThrusterPulses pulses;
  pulses.thruster = thruster.value_or(ship.find_actuator(Channel::n_bt) != nullptr ? Channel::n_bt : Channel::n_st);
  const Actuator* actuator = ship.find_actuator(pulses.thruster);
  if (actuator == nullptr)
    throw UsageError(fmt::format("the ship '{}' has no {} thruster", ship.name,
                                 !thruster                    ? "bow or stern"
                                 : *thruster == Channel::n_bt ? "bow"
                                                              : "stern"));
  pulses.rps = std::min(actuator->max, -actuator->min);
  const double unit_s = std::sqrt(ship.particulars.L_pp / kGravity_mps2);
  pulses.pulse_s = kPulseTimes * unit_s;
  pulses.rest_s = kRestTimes * unit_s;
  return pulses;
}

std::unique_ptr<Maneuver> thruster_pulses(const SimulatedShip& start, const ThrusterPulses& pulses) {
  const Actuator& actuator = *start.ship.find_actuator(pulses.thruster);
  if (!(pulses.rps > 0.0) || pulses.rps > actuator.max || -pulses.rps < actuator.min)
    throw UsageError(fmt::format("expected thruster revolutions above 0 that both sides have ({} to {} 1/s), got {}",
                                 actuator.min, actuator.max, pulses.rps));
  std::vector<PlannedPhase> plan;
  for (std::size_t i = 0; i < pulses.pulses; ++i) {
    PlannedPhase pulse{start.actuators, i % 2 == 0 ? pulses.rps : -pulses.rps, Until::time, pulses.pulse_s};
    PlannedPhase rest{start.actuators, 0.0, Until::time, pulses.rest_s};
    pulse.command[pulses.thruster] = pulse.order;
    rest.command[pulses.thruster] = 0.0;
    plan.push_back(pulse);
    plan.push_back(rest);
  }
  return std::make_unique<PhasedManeuver>(start, std::move(plan));
}

}  // namespace leeway
