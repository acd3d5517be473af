#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include "forces/azimuth_thruster.hpp"
#include "forces/four_quadrant_propeller.hpp"
#include "forces/fujiwara_wind.hpp"
#include "forces/kang_propeller.hpp"
#include "forces/module_list.hpp"
#include "forces/side_thruster.hpp"
#include "forces/single_rudder.hpp"
#include "forces/standard_hull.hpp"
#include "forces/standard_propeller.hpp"
#include "forces/standard_rudder.hpp"
#include "forces/unified_hull.hpp"
#include "forces/vectwin_rudders.hpp"

namespace leeway {

/// The one list of force modules, by place. A new one adds its header and its name here: the header has its
/// coefficients, their keys in a ship's JSON, its force, and what is known of it up to a factor.
using HullModules = ModuleList<UnifiedHull, StandardHull>;
using PropellerModules = ModuleList<KangPropeller, FourQuadrantPropeller, StandardPropeller>;
using RudderModules = ModuleList<VectwinRudders, SingleRudder, StandardRudder>;
using ThrusterModules = ModuleList<SideThruster, AzimuthThruster>;
using WindModules = ModuleList<FujiwaraWind>;

/// The numbers of a ship's force modules, as its JSON gives them. A ship has a propeller and a rudder, or thrusters
/// that drive it.
struct ModuleCoefficients {
  HullModules::Coefficients hull;
  std::optional<PropellerModules::Coefficients> propeller;
  std::optional<RudderModules::Coefficients> rudder;
  std::vector<ThrusterModules::Coefficients> thrusters;
  std::optional<WindModules::Coefficients> wind;

  /// Whether one of the modules is what `asked` says of its type: has([]<typename M>() { return HasWake<M>; }).
  template <typename Asked>
  bool has(const Asked& asked) const {
    return HullModules::is(hull, asked) || (propeller && PropellerModules::is(*propeller, asked)) ||
           (rudder && RudderModules::is(*rudder, asked)) || (wind && WindModules::is(*wind, asked)) ||
           std::ranges::any_of(thrusters, [&](const auto& c) { return ThrusterModules::is(c, asked); });
  }
};

}  // namespace leeway
