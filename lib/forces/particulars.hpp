#pragma once

namespace leeway {

struct Particulars {
  double L_pp = 0.0, B = 0.0, d = 0.0;  ///< [m]
  double rho = 0.0;                     ///< water [kg/m^3]
};

}  // namespace leeway
