#pragma once

#include <array>
#include <cmath>
#include <string_view>

#include "core/scalar.hpp"
#include "core/types.hpp"
#include "forces/coefficient_list.hpp"
#include "forces/concepts.hpp"
#include "forces/motion.hpp"
#include "forces/particulars.hpp"
#include "forces/resistance_law.hpp"
#include "io/json.hpp"

namespace leeway {

/// What other polynomials in v' and r' differ by from the standard method's; nothing as it is shipped. With squares
/// v|v| and r|r| in place of cubes (Inoue, Hirano & Kijima 1981) the linear terms lose or gain with the first power of
/// the drift and of the yaw rate.
template <typename T>
struct StandardHullForm {
  static constexpr std::string_view reference =
      "squares in place of cubes (ours), as in Inoue, Hirano & Kijima (1981), Int. Shipbuilding Progress 28";

  T Y_v_30deg = T(0.0), N_v_30deg = T(0.0);  ///< what their terms have more at |v'| = 0.5 and beyond
  T Y_r_tight = T(0.0), N_r_tight = T(0.0);  ///< the same at |r'| = 1
  bool is_own = true;                        ///< whether all are zero

  template <typename Visit>
  void coefficients(const Visit& visit) {
    visit("hull.Y_v_30deg", 0.2, reference, FormTerm<T>{Y_v_30deg, is_own});
    visit("hull.N_v_30deg", 0.2, reference, FormTerm<T>{N_v_30deg, is_own});
    visit("hull.Y_r_tight", 0.2, reference, FormTerm<T>{Y_r_tight, is_own});
    visit("hull.N_r_tight", 0.2, reference, FormTerm<T>{N_r_tight, is_own});
  }
};

/// Yasukawa & Yoshimura (2015), MMG standard method.
template <typename T>
struct StandardHullCoefficients {
  T R_0, X_vv, X_vr, X_rr, X_vvvv;
  T Y_v, Y_r, Y_vvv, Y_vvr, Y_vrr, Y_rrr;
  T N_v, N_r, N_vvv, N_vvr, N_vrr, N_rrr;

  template <typename U>
  StandardHullCoefficients<U> cast() const {
    return {U(R_0),   U(X_vv),  U(X_vr), U(X_rr), U(X_vvvv), U(Y_v),   U(Y_r),   U(Y_vvv), U(Y_vvr),
            U(Y_vrr), U(Y_rrr), U(N_v),  U(N_r),  U(N_vvv),  U(N_vvr), U(N_vrr), U(N_rrr)};
  }

  /// Its keys in a ship's JSON, besides type and source.
  static StandardHullCoefficients read(const io::JsonObject& json) {
    return {json.number("R_0", io::kNotNegative),
            json.number("X_vv"),
            json.number("X_vr"),
            json.number("X_rr"),
            json.number("X_vvvv"),
            json.number("Y_v"),
            json.number("Y_r"),
            json.number("Y_vvv"),
            json.number("Y_vvr"),
            json.number("Y_vrr"),
            json.number("Y_rrr"),
            json.number("N_v"),
            json.number("N_r"),
            json.number("N_vvv"),
            json.number("N_vvr"),
            json.number("N_vrr"),
            json.number("N_rrr")};
  }
};

/// Hull force of the MMG standard method: polynomials in v' and r'. Added mass is in dynamics/, the Munk moment in N_v.
///   motion  (u [m/s], v_m [m/s], r [rad/s]) at midship, through the water
///   returns (X_H [N], Y_H [N], N_H [N m]) at midship; zero at rest, where v' and r' are undefined
/// Source: Yasukawa & Yoshimura (2015), JMST 20, 37-52, doi:10.1007/s00773-014-0293-y. The method is made for going
/// ahead. Within |beta| <= 30 deg and |r'| <= 1 its polynomials stand as printed; what follows is ours, so that the
/// force stays finite, continuous and dissipative in yaw elsewhere:
///   astern      the hull mirrored fore and aft: (u, v_m, r) -> (-u, v_m, -r) gives (-X, Y, -N). `ahead` below goes
///               from 1 to -1 as u/U goes from cos 30 deg to -cos 30 deg, and stands with the terms that this mirror
///               turns over;
///   |r'| > 1    U in v', r' and the scale of the force is held at |r| L_pp: a turn on the spot is damped by r |r|;
///   |v'| > 0.5  X keeps its value of |v'| = 0.5 (30 deg): X_vvvv would drive a ship ahead that drifts sideways.
template <typename T>
struct StandardHull {
  using Coefficients = StandardHullCoefficients<double>;
  static constexpr std::string_view group = "hull", name = "mmg-standard";
  static constexpr std::string_view reference = "Yasukawa & Yoshimura (2015), JMST 20, 37-52";
  static constexpr double kYawRange = 1.0, kDriftRange = 0.5, kAheadRange = 0.8660254037844386;  // r', sin, cos 30 deg
  StandardHullCoefficients<T> c;
  Particulars p;
  ResistanceLaw<T> resistance_law;
  StandardHullForm<T> form;

  StandardHull(const StandardHullCoefficients<double>& coefficients, const Particulars& particulars)
      : c(coefficients.cast<T>()), p(particulars), resistance_law(particulars) {}

  /// The resistance by this factor.
  void scale_resistance(const T& k) { c.R_0 *= k; }
  /// All forces by this factor.
  void scale_force(const T& k) {
    for (T* coefficient : {&c.R_0, &c.X_vv, &c.X_vr, &c.X_rr, &c.X_vvvv, &c.Y_v, &c.Y_r, &c.Y_vvv, &c.Y_vvr, &c.Y_vrr,
                           &c.Y_rrr, &c.N_v, &c.N_r, &c.N_vvv, &c.N_vvr, &c.N_vrr, &c.N_rrr})
      *coefficient *= k;
  }
  /// What is known up to a factor: visit(name, log_sd, reference, scale), where scale(k) multiplies by k.
  template <typename Visit>
  void coefficients(const Visit& visit) {
    visit("hull.resistance", 0.10, reference, [&](const T& k) { scale_resistance(k); });
    visit("hull.resistance_slow", 0.10, ResistanceLaw<T>::reference, [&](const T& k) { resistance_law.scale_slow(k); });
    visit("hull.X_vr", 0.3, reference, factor_on(c.X_vr));
    visit("hull.Y_v", 0.15, reference, factor_on(c.Y_v));
    visit("hull.Y_r", 0.25, reference, factor_on(c.Y_r));
    visit("hull.N_v", 0.15, reference, factor_on(c.N_v));
    visit("hull.N_r", 0.15, reference, factor_on(c.N_r));
    visit("hull.X_vv", 0.3, reference, factor_on(c.X_vv));
    visit("hull.X_rr", 0.3, reference, factor_on(c.X_rr));
    visit("hull.X_vvvv", 0.3, reference, factor_on(c.X_vvvv));
    visit("hull.Y_vvv", 0.2, reference, factor_on(c.Y_vvv));
    visit("hull.Y_vvr", 0.2, reference, factor_on(c.Y_vvr));
    visit("hull.Y_vrr", 0.2, reference, factor_on(c.Y_vrr));
    visit("hull.Y_rrr", 0.2, reference, factor_on(c.Y_rrr));
    visit("hull.N_vvv", 0.2, reference, factor_on(c.N_vvv));
    visit("hull.N_vvr", 0.2, reference, factor_on(c.N_vvr));
    visit("hull.N_vrr", 0.2, reference, factor_on(c.N_vrr));
    visit("hull.N_rrr", 0.2, reference, factor_on(c.N_rrr));
    form.coefficients(visit);
  }

  Vec3<T> force(const Motion<T>& motion) const {
    using std::sqrt;
    const T Lr = p.L_pp * motion.r;
    T U2 = motion.U2, per_U = motion.per_U;
    const T U2_yaw = Lr * Lr / (kYawRange * kYawRange);
    if (U2 < U2_yaw) {
      U2 = U2_yaw;
      if (U2 > T(kAtRest_m2ps2)) per_U = 1.0 / sqrt(U2);
    }
    if (!(U2 > T(kAtRest_m2ps2))) return Vec3<T>::Zero();
    const T v = motion.v * per_U, r = Lr * per_U;
    const T ahead = limited<T>(motion.u * per_U * (1.0 / kAheadRange), -1.0, 1.0);

    const T v2 = v * v, r2 = r * r;
    const T v2_X = v2 > T(kDriftRange * kDriftRange) ? T(kDriftRange * kDriftRange) : v2;
    const T R_0 = c.R_0 * resistance_law(motion.U2);
    const T X = ahead * (-R_0 + c.X_vv * v2_X + c.X_rr * r2 + c.X_vvvv * v2_X * v2_X) + c.X_vr * v * r;
    T Y = c.Y_v * v + c.Y_vvv * v2 * v + c.Y_vrr * v * r2 + ahead * (c.Y_r * r + c.Y_vvr * v2 * r + c.Y_rrr * r2 * r);
    T N = ahead * (c.N_v * v + c.N_vvv * v2 * v + c.N_vrr * v * r2) + c.N_r * r + c.N_vvr * v2 * r + c.N_rrr * r2 * r;
    if (!form.is_own) {
      using std::abs;
      const T drift = limited<T>(abs(v) * (1.0 / kDriftRange), 0.0, 1.0), turn = abs(r);  // |r| <= kYawRange
      Y += form.Y_v_30deg * drift * c.Y_v * v + ahead * form.Y_r_tight * turn * c.Y_r * r;
      N += ahead * form.N_v_30deg * drift * c.N_v * v + form.N_r_tight * turn * c.N_r * r;
    }

    const T q = 0.5 * p.rho * p.L_pp * p.d * U2;  // [N]
    return {q * X, q * Y, q * p.L_pp * N};
  }
};

static_assert(HasResistance<StandardHull<double>> && HasLinearDerivatives<StandardHull<double>>);

}  // namespace leeway
