#pragma once

#include <optional>
#include <variant>
#include <vector>

#include "forces/four_quadrant_propeller.hpp"
#include "forces/fujiwara_wind.hpp"
#include "forces/kang_propeller.hpp"
#include "forces/side_thruster.hpp"
#include "forces/single_rudder.hpp"
#include "forces/standard_hull.hpp"
#include "forces/standard_propeller.hpp"
#include "forces/standard_rudder.hpp"
#include "forces/unified_hull.hpp"
#include "forces/vectwin_rudders.hpp"
#include "ship/ship.hpp"

namespace leeway {

/// The one list of force modules, by slot. A new one adds its header and its name here, its coefficients to
/// ship/coefficients.hpp and its keys to ship/ship.cpp.
template <typename T>
using HullModule = std::variant<UnifiedHull<T>, StandardHull<T>>;
template <typename T>
using PropellerModule = std::variant<KangPropeller<T>, FourQuadrantPropeller<T>, StandardPropeller<T>>;
template <typename T>
using RudderModule = std::variant<VectwinRudders<T>, SingleRudder<T>, StandardRudder<T>>;
template <typename T>
using ThrusterModule = std::variant<SideThruster<T>>;
template <typename T>
using WindModule = std::variant<FujiwaraWind<T>>;

/// The force modules of a ship.
template <typename T>
struct ForceModules {
  HullModule<T> hull;
  PropellerModule<T> propeller;
  RudderModule<T> rudder;
  std::vector<ThrusterModule<T>> thrusters;
  std::optional<WindModule<T>> wind;

  explicit ForceModules(const Ship& ship);

  /// The sum of all modules at midship (X [N], Y [N], N [N m]).
  ///   nu  through the water;  wind  apparent wind in ship axes [m/s], pointing to where it comes from
  Vec3<T> force(const Vec3<T>& nu, const ActingActuators<T>& actuators, const Vec2<T>& apparent_wind) const {
    const Motion<T> motion(nu);
    const PropellerFlow<T> flow =
        std::visit([&](const auto& m) { return m.flow(motion, actuators[Channel::n_p]); }, propeller);
    Vec3<T> sum = flow.force;
    sum += std::visit([&](const auto& m) { return m.force(motion); }, hull);
    sum += std::visit([&](const auto& m) { return m.force(motion, flow, actuators); }, rudder);
    for (const ThrusterModule<T>& thruster : thrusters)
      sum += std::visit([&](const auto& m) { return m.force(motion, actuators); }, thruster);
    if (wind) sum += std::visit([&](const auto& m) { return m.force(apparent_wind); }, *wind);
    return sum;
  }

 private:
  static HullModule<T> module_of(const UnifiedHullCoefficients<double>& c, const Ship& s) {
    return UnifiedHull<T>(c, s.particulars);
  }
  static HullModule<T> module_of(const StandardHullCoefficients<double>& c, const Ship& s) {
    return StandardHull<T>(c, s.particulars);
  }
  static PropellerModule<T> module_of(const KangPropellerCoefficients<double>& c, const Ship& s) {
    return KangPropeller<T>(c, s.particulars);
  }
  static PropellerModule<T> module_of(const FourQuadrantPropellerCoefficients<double>& c, const Ship& s) {
    return FourQuadrantPropeller<T>(c, s.particulars);
  }
  static PropellerModule<T> module_of(const StandardPropellerCoefficients<double>& c, const Ship& s) {
    return StandardPropeller<T>(c, s.particulars);
  }
  static RudderModule<T> module_of(const VectwinRuddersCoefficients<double>& c, const Ship& s) {
    const auto [D_P, pitch] =
        std::visit([](const auto& m) { return std::pair(m.D_P, m.D_P * m.pitch_ratio); }, s.propeller);
    return VectwinRudders<T>(c, s.particulars, D_P, pitch);
  }
  static RudderModule<T> module_of(const SingleRudderCoefficients<double>& c, const Ship& s) {
    return SingleRudder<T>(c, s.particulars, std::visit([](const auto& m) { return m.D_P; }, s.propeller));
  }
  static RudderModule<T> module_of(const StandardRudderCoefficients<double>& c, const Ship& s) {
    return StandardRudder<T>(c, s.particulars, std::visit([](const auto& m) { return m.D_P; }, s.propeller));
  }
  static ThrusterModule<T> module_of(const SideThrusterCoefficients<double>& c, const Ship& s) {
    return SideThruster<T>(c, s.particulars);
  }
  static WindModule<T> module_of(const FujiwaraWindGeometry& c, const Ship& s) {
    return FujiwaraWind<T>(c, s.particulars);
  }
  template <typename Coefficients>
  static auto make(const Coefficients& coefficients, const Ship& ship) {
    return std::visit([&](const auto& c) { return module_of(c, ship); }, coefficients);
  }
};

template <typename T>
ForceModules<T>::ForceModules(const Ship& ship)
    : hull(make(ship.hull, ship)), propeller(make(ship.propeller, ship)), rudder(make(ship.rudder, ship)) {
  for (const ThrusterCoefficients& thruster : ship.thrusters) thrusters.push_back(make(thruster, ship));
  if (ship.wind) wind = make(*ship.wind, ship);
}

}  // namespace leeway
