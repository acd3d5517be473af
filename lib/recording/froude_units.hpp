#pragma once

#include <array>
#include <cmath>
#include <string_view>

namespace leeway {

/// What a number is multiplied by from one ship to another one of the same shape by Froude's law, told by the unit that
/// its key ends with; 1 where it has none of these.
///   length_ratio, density_ratio  length and water's density of the other ship by those of the one
inline double froude_factor(std::string_view key, double length_ratio, double density_ratio = 1.0) {
  struct Unit {
    std::string_view end;
    double power;   // of length
    bool has_mass;  // goes with the water's density as well
  };
  static constexpr std::array<Unit, 14> kUnits{{{"_m", 1.0, false},
                                                {"_m2", 2.0, false},
                                                {"_s", 0.5, false},
                                                {"_mps", 0.5, false},
                                                {"_spm", -0.5, false},
                                                {"_1ps", -0.5, false},
                                                {"_rps", -0.5, false},
                                                {"_degps", -0.5, false},
                                                {"_rpsps", -1.0, false},
                                                {"_degps2", -1.0, false},
                                                {"_mps2", 0.0, false},
                                                {"_N", 3.0, true},
                                                {"_Nm", 4.0, true},
                                                {"_npm", 2.0, true}}};
  if (key == "J_s" || key == "c_N" || key == "C_N") return 1.0;  // an advance ratio, coefficients of a moment
  if (key == "n_rps_at_1") return std::pow(length_ratio, -0.5);
  const std::size_t at = key.rfind('_');
  if (at == std::string_view::npos) return 1.0;
  for (const Unit& unit : kUnits)
    if (key.substr(at) == unit.end) return std::pow(length_ratio, unit.power) * (unit.has_mass ? density_ratio : 1.0);
  return 1.0;
}

}  // namespace leeway
