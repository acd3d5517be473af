#pragma once

#include "dynamics/model.hpp"

namespace leeway {

/// The two rudders and the bow thruster of a VecTwin ship as one lever: which of the orders that a pilot gives (whole
/// steps within the actuators' limits) come closest to an acceleration, by the ship's model in calm air.
class Joystick {
 public:
  /// Throws UsageError, which begins with the maneuver's name, for a ship without VecTwin rudders or bow thruster.
  Joystick(const Ship& ship, std::string_view maneuver);

  struct Steps {
    double rudder_rad = 0.0, thruster_rps = 0.0;
  };

  /// du/dt, dv_m/dt, dr/dt in calm air, of the model without effects.
  Vec3<double> acceleration(const Vec3<double>& nu, const Actuators<double>& actuators) const {
    return model_.acceleration(nu, actuators, nu.head<2>());
  }

  /// Each rudder on its own, and the thruster. Among equals little is changed and the rudders are kept symmetric.
  ///   sway       whether the acceleration sideways counts
  ///   thruster   whether it may be used; else it is stopped
  ///   current    what is ordered now
  Actuators<double> each_alone(const Vec3<double>& nu, const Vec3<double>& wanted, bool sway, bool thruster,
                               const Steps& steps, const Actuators<double>& current) const;

  /// Both rudders together by one angle, opened by another: (angle - opening, angle + opening), the thruster stopped.
  /// Sideways nothing is asked for. Among equals little is changed and the rudders are kept closed.
  ///   most_rad      largest angle that is common to both
  ///   keep_opening  whether the opening stays as it is, so that only the turning counts
  Actuators<double> together(const Vec3<double>& nu, const Vec3<double>& wanted, double most_rad, bool keep_opening,
                             const Steps& steps, const Actuators<double>& current) const;

  const Actuator& port() const { return port_; }
  const Actuator& starboard() const { return starboard_; }
  const Actuator& thruster() const { return thruster_; }

 private:
  double L_;
  Model<double> model_;
  Actuator port_, starboard_, thruster_;
};

}  // namespace leeway
