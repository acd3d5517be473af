#pragma once

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "forces/module_forces.hpp"
#include "forces/registry.hpp"

namespace leeway {

/// The force modules of a ship.
template <typename T>
struct ForceModules {
  HullModules::Of<T> hull;
  std::optional<PropellerModules::Of<T>> propeller;
  std::optional<RudderModules::Of<T>> rudder;
  std::vector<ThrusterModules::Of<T>> thrusters;
  std::optional<WindModules::Of<T>> wind;

  ForceModules(const ModuleCoefficients& ship, const Particulars& p) : hull(HullModules::make<T>(ship.hull, p)) {
    if (ship.propeller) propeller = PropellerModules::make<T>(*ship.propeller, p);
    if (ship.rudder) {
      const auto size_of = [](const auto& c) { return PropellerSize{c.D_P, c.pitch_ratio}; };
      rudder = RudderModules::make<T>(*ship.rudder, p, std::visit(size_of, ship.propeller.value()));
    }
    for (const auto& thruster : ship.thrusters) thrusters.push_back(ThrusterModules::make<T>(thruster, p));
    if (ship.wind) wind = WindModules::make<T>(*ship.wind, p);
  }

  /// The sum of all modules at midship (X [N], Y [N], N [N m]).
  ///   nu  through the water;  wind  apparent wind in ship axes [m/s], pointing to where it comes from
  Vec3<T> force(const Vec3<T>& nu, const ActingActuators<T>& actuators, const Vec2<T>& apparent_wind) const {
    const Motion<T> motion(nu);
    const PropellerFlow<T> flow = propeller_flow(motion, actuators);
    Vec3<T> sum = flow.force;
    sum += std::visit([&](const auto& m) { return m.force(motion); }, hull);
    if (rudder) sum += std::visit([&](const auto& m) { return m.force(motion, flow, actuators); }, *rudder);
    for (const auto& thruster : thrusters)
      sum += std::visit([&](const auto& m) { return m.force(motion, actuators); }, thruster);
    if (wind) sum += std::visit([&](const auto& m) { return m.force(apparent_wind); }, *wind);
    return sum;
  }
  /// The same by place.
  ModuleForces<T> forces(const Vec3<T>& nu, const ActingActuators<T>& actuators, const Vec2<T>& apparent_wind) const {
    const Motion<T> motion(nu);
    const Vec3<T> zero = Vec3<T>::Zero();
    ModuleForces<T> by{propeller_flow(motion, actuators), zero, zero, zero, zero};
    by.hull = std::visit([&](const auto& m) { return m.force(motion); }, hull);
    if (rudder)
      by.rudder = std::visit([&](const auto& m) { return m.force(motion, by.propeller, actuators); }, *rudder);
    for (const auto& thruster : thrusters)
      by.thrusters += std::visit([&](const auto& m) { return m.force(motion, actuators); }, thruster);
    if (wind) by.wind = std::visit([&](const auto& m) { return m.force(apparent_wind); }, *wind);
    return by;
  }

  /// Calls visit(module) for each module, always in the same order.
  template <typename Visit>
  void for_each(const Visit& visit) {
    for_each_of(*this, visit);
  }
  template <typename Visit>
  void for_each(const Visit& visit) const {
    for_each_of(*this, visit);
  }

  /// The groups of modules whose force has a scale: "hull", and "propeller", "rudder", "thruster", "wind" where the
  /// ship has them.
  std::vector<std::string> names() const {
    std::vector<std::string> result;
    for_each([&](const auto& m) {
      if (std::find(result.begin(), result.end(), m.group) == result.end()) result.emplace_back(m.group);
    });
    return result;
  }
  /// Whether the force of one of them is of the wind, so that it does nothing where none is known.
  bool is_of_wind(std::string_view group) const {
    bool result = false;
    for_each([&]<typename M>(const M& m) {
      if constexpr (HasWindForce<M>) result = result || m.group == group;
    });
    return result;
  }
  /// Multiplies the force of one of them.
  void scale(std::string_view group, const T& k) {
    for_each([&](auto& m) {
      if (m.group == group) m.scale_force(k);
    });
  }

 private:
  PropellerFlow<T> propeller_flow(const Motion<T>& motion, const ActingActuators<T>& actuators) const {
    if (!propeller) return {Vec3<T>::Zero(), T(0.0), T(1.0), motion.u, T(0.0), T(0.0)};
    return std::visit([&](const auto& m) { return m.flow(motion, actuators[Channel::n_p]); }, *propeller);
  }
  template <typename Self, typename Visit>
  static void for_each_of(Self& self, const Visit& visit) {
    std::visit(visit, self.hull);
    if (self.propeller) std::visit(visit, *self.propeller);
    if (self.rudder) std::visit(visit, *self.rudder);
    for (auto& thruster : self.thrusters) std::visit(visit, thruster);
    if (self.wind) std::visit(visit, *self.wind);
  }
};

}  // namespace leeway
