#pragma once

#include <string_view>

#include "core/types.hpp"
#include "forces/coefficient_list.hpp"

namespace leeway {

/// What other published curves of wind forces over the direction differ by from a module's; nothing as it is shipped.
/// Regressions of wind tunnel tests err by 5 to 15 % of the largest side force and by 0.01 to 0.03 in C_N (standard
/// errors of Isherwood 1972), which is 0.01 to 0.04 L of the side force's arm; side forces go with the sine or are
/// fuller (Blendermann 1994), and their arm moves with the direction by 0.18 L a radian there.
template <typename T>
struct WindForm {
  static constexpr std::string_view reference =
      "another curve over the direction (ours), as far as Isherwood (1972), Trans. RINA 115, 327-338 errs";

  T X_astern = T(0.0);   ///< of the force along the ship in a wind from astern; none ahead
  T Y_oblique = T(0.0);  ///< of the side force in a wind nearly along the ship; none across
  T Y_ahead = T(0.0);    ///< the same, from ahead more and from astern less
  T arm = T(0.0);        ///< of the side force, farther forward by these lengths
  T arm_ahead = T(0.0);  ///< the same in a wind from ahead, aft in one from astern
  bool is_own = true;    ///< whether all are zero

  template <typename Visit>
  void coefficients(const Visit& visit) {
    visit("wind.X_astern", 0.2, reference, FormTerm<T>{X_astern, is_own});
    visit("wind.Y_oblique", 0.2, reference, FormTerm<T>{Y_oblique, is_own});
    visit("wind.Y_ahead", 0.1, reference, FormTerm<T>{Y_ahead, is_own});
    visit("wind.arm", 0.03, reference, FormTerm<T>{arm, is_own});
    visit("wind.arm_ahead", 0.1, reference, FormTerm<T>{arm_ahead, is_own});
  }

  /// (C_X, C_Y, C_N) of the module for the direction with this cosine, in the other form.
  Vec3<T> other(const Vec3<T>& own, const T& cosine) const {
    const T C_Y = own(1) * (1.0 + (Y_oblique * cosine + Y_ahead) * cosine);
    return {own(0) * (1.0 + 0.5 * X_astern * (1.0 - cosine)), C_Y, own(2) + C_Y * (arm + arm_ahead * cosine)};
  }
};

}  // namespace leeway
