#pragma once

#include "forces/propeller_flow.hpp"

namespace leeway {

/// Forces of the modules of a ship at midship (X [N], Y [N], N [N m]); zero where it has no such module.
template <typename T>
struct ModuleForces {
  PropellerFlow<T> propeller;  ///< with its force
  Vec3<T> hull, rudder, thrusters, wind;
};

}  // namespace leeway
