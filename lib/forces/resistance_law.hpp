#pragma once

#include <cmath>
#include <string_view>

#include "core/units.hpp"
#include "forces/particulars.hpp"

namespace leeway {

/// How the resistance of a hull changes with speed besides its square: a factor (U/U_0)^p, 1 at U_0, the Froude number
/// 0.1, and everywhere unless scaled. Friction alone falls by p = -0.21 at a model's Reynolds number of 1.5e6 and by
/// p = -0.12 at a ship's 1e9 (slope of the ITTC-57 line, C_F = 0.075/(log10 Re - 2)^2).
template <typename T>
class ResistanceLaw {
 public:
  static constexpr std::string_view reference = "a power of the speed (ours), which the ITTC-57 line bounds";

  explicit ResistanceLaw(const Particulars& particulars)
      : U_0_2_(0.01 * kGravity_mps2 * particulars.L_pp), slowest_2_(0.01 * U_0_2_) {}

  /// The resistance at half a speed, over that at the speed, by k.
  void scale_slow(const T& k) {
    using std::log;
    half_p_ -= log(k) / std::log(4.0);
    is_square_ = false;
  }
  /// U2: square of the speed through the water [m^2/s^2]. Below a tenth of U_0 the factor no longer changes.
  T operator()(const T& U2) const {
    using std::exp, std::log;
    if (is_square_) return T(1.0);
    return exp(half_p_ * log((U2 + slowest_2_) / (U_0_2_ + slowest_2_)));
  }

 private:
  double U_0_2_, slowest_2_;  // [m^2/s^2]
  T half_p_ = T(0.0);
  bool is_square_ = true;
};

}  // namespace leeway
