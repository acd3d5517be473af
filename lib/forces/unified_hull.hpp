#pragma once

#include <array>
#include <cmath>
#include <string_view>

#include "core/scalar.hpp"
#include "core/types.hpp"
#include "core/units.hpp"
#include "forces/coefficient_list.hpp"
#include "forces/concepts.hpp"
#include "forces/motion.hpp"
#include "forces/particulars.hpp"
#include "forces/resistance_law.hpp"
#include "io/json.hpp"

namespace leeway {

/// Cross-flow integrals over the length: (Int |w| w dx / L, Int |w| w x dx / L^2) [m^2/s^2] with w = v + a x and x
/// from -L/2 to L/2.
///   v      sway at midship [m/s]
///   b      a L/2: what the yaw rate adds to the cross flow at the bow [m/s]
/// Exact: the integrand changes sign inside the hull where |b| > |v|. Neither form divides by what goes to zero in its
/// own range, so nothing cancels at b = 0 or v = 0.
template <typename T>
Vec2<T> cross_flow_integrals(const T& v, const T& b) {
  using std::abs;
  const T abs_v = abs(v), abs_b = abs(b);
  if (!(abs_b > abs_v)) {
    const T b2_3 = b * b / 3.0;
    return {v < T(0.0) ? T(-v * v - b2_3) : T(v * v + b2_3), abs_v * b / 3.0};
  }
  const T q = v / abs_b;  // minus the place of the zero crossing, by L/2
  const T moment = (abs_b * abs_b / 2.0 + v * v - q * q * v * v / 6.0) / 4.0;
  return {v * abs_b + q * v * v / 3.0, b < T(0.0) ? T(-moment) : moment};
}

/// The same of what the ends of the hull have more of the drag than its middle, weighted with (2 x/L)^2 - 1/3, whose
/// mean over the length is zero.
template <typename T>
Vec2<T> cross_flow_integrals_of_ends(const T& v, const T& b) {
  using std::abs;
  constexpr double kEnds = 4.0 / 45.0;
  const T abs_b = abs(b);
  if (!(abs_b > abs(v))) return {v < T(0.0) ? T(-kEnds * b * b) : T(kEnds * b * b), kEnds * abs(v) * b};
  const T s = -v / abs_b * (b < T(0.0) ? -1.0 : 1.0), s2 = s * s;  // the zero crossing, by L/2
  const T b2 = b * abs_b;
  return {b2 * s * (-1.0 / 6.0 + s2 * (1.0 / 9.0 - s2 / 30.0)),
          b2 * (1.0 / 24.0 + s2 * (1.0 / 24.0 + s2 * (1.0 / 72.0 - s2 / 120.0)))};
}

/// What other hulls' forces differ by from the unified form; nothing as it is shipped. Side force and moment of drift
/// level off with the angle, or grow (a lift goes with sin cos, a polynomial does not); drift makes resistance (X_vv'
/// is -0.04 for the KVLCC2, Yasukawa & Yoshimura 2015); the drag across is not the same over the length (Hooft 1994).
template <typename T>
struct UnifiedHullForm {
  static constexpr std::string_view reference = "another curve over drift and length (ours), as published hulls differ";
  static constexpr double kSine30 = 0.5;

  T Y_v_30deg = T(0.0), N_v_30deg = T(0.0);  ///< what their force has more at a drift of 30 deg and beyond
  T X_vv = T(0.0);
  T C_D_arm = T(0.0);   ///< of the drag across, farther forward by these lengths
  T C_D_ends = T(0.0);  ///< what it has more at the ends, in 2/3, and less amidships, in 1/3
  bool is_own = true;   ///< whether all are zero

  template <typename Visit>
  void coefficients(const Visit& visit) {
    visit("hull.Y_v_30deg", 0.2, reference, FormTerm<T>{Y_v_30deg, is_own});
    visit("hull.N_v_30deg", 0.2, reference, FormTerm<T>{N_v_30deg, is_own});
    visit("hull.X_vv_term", 0.04, reference, FormTerm<T>{X_vv, is_own});
    visit("hull.C_D_arm", 0.03, reference, FormTerm<T>{C_D_arm, is_own});
    visit("hull.C_D_ends", 0.5, reference, FormTerm<T>{C_D_ends, is_own});
  }
};

/// Yoshimura, Nakao & Ishibashi (2009).
template <typename T>
struct UnifiedHullCoefficients {
  T X_0F, X_0A, X_vr, Y_v, Y_r, N_v, N_r, C_D, C_rY, C_rN;

  template <typename U>
  UnifiedHullCoefficients<U> cast() const {
    return {U(X_0F), U(X_0A), U(X_vr), U(Y_v), U(Y_r), U(N_v), U(N_r), U(C_D), U(C_rY), U(C_rN)};
  }

  /// Its keys in a ship's JSON, besides type and source.
  static UnifiedHullCoefficients read(const io::JsonObject& json) {
    return {json.number("X_0F"), json.number("X_0A"), json.number("X_vr"), json.number("Y_v"),  json.number("Y_r"),
            json.number("N_v"),  json.number("N_r"),  json.number("C_D"),  json.number("C_rY"), json.number("C_rN")};
  }
};

/// Hull force for any drift angle; added mass is in dynamics/, the Munk moment is in N_v.
///   motion  (u [m/s], v_m [m/s], r [rad/s]) at midship, through the water
///   returns (X_H [N], Y_H [N], N_H [N m]) at midship
/// Source: Yoshimura, Nakao & Ishibashi (2009), Unified Mathematical Model for Ocean and Harbour Manoeuvring, MARSIM.
template <typename T>
struct UnifiedHull {
  using Coefficients = UnifiedHullCoefficients<double>;
  static constexpr std::string_view group = "hull", name = "unified-2009";
  static constexpr std::string_view reference = "Yoshimura, Nakao & Ishibashi (2009), MARSIM";
  UnifiedHullCoefficients<T> c;
  Particulars p;
  ResistanceLaw<T> resistance_law;
  UnifiedHullForm<T> form;

  UnifiedHull(const UnifiedHullCoefficients<double>& coefficients, const Particulars& particulars)
      : c(coefficients.cast<T>()), p(particulars), resistance_law(particulars) {}

  /// The resistance ahead and astern by this factor.
  void scale_resistance(const T& k) {
    c.X_0F *= k;
    c.X_0A *= k;
  }
  /// All forces by this factor.
  void scale_force(const T& k) {
    scale_resistance(k);
    for (T* coefficient : {&c.X_vr, &c.Y_v, &c.Y_r, &c.N_v, &c.N_r, &c.C_D, &form.X_vv}) *coefficient *= k;
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
    visit("hull.C_D", 0.2, reference, factor_on(c.C_D));
    visit("hull.C_rY", 0.2, reference, factor_on(c.C_rY));
    visit("hull.C_rN", 0.2, reference, factor_on(c.C_rN));
    visit("hull.X_0A", 0.10, reference, factor_on(c.X_0A));
    form.coefficients(visit);
  }

  Vec3<T> force(const Motion<T>& motion) const {
    using std::abs;
    const T &u = motion.u, &v = motion.v;
    const T Lr = p.L_pp * motion.r;

    const T X_0 = (c.X_0F + (c.X_0A - c.X_0F) * (1.0 / kPi) * abs(motion.beta)) * resistance_law(motion.U2);
    const T X = X_0 * u * motion.U + c.X_vr * v * Lr;
    const T abs_u = abs(u);
    const T across = cross_flow_integrals<T>(v, c.C_rY * Lr / 2.0)(0);
    const T Y = c.Y_v * v * abs_u + c.Y_r * Lr * u - c.C_D * across;
    const T N = c.N_v * v * u + c.N_r * Lr * abs_u - c.C_D * cross_flow_integrals<T>(v, c.C_rN * Lr / 2.0)(1);

    const double q = 0.5 * p.rho * p.L_pp * p.d;  // [kg/m]
    const Vec3<T> own(q * X, q * Y, q * p.L_pp * N);
    return form.is_own ? own : Vec3<T>(own + q * of_other_form(motion, across));
  }

 private:
  // What the other form adds, by q.
  Vec3<T> of_other_form(const Motion<T>& motion, const T& across) const {
    using std::abs;
    const T &u = motion.u, &v = motion.v;
    const T drift = limited<T>(abs(v) * motion.per_U * (1.0 / UnifiedHullForm<T>::kSine30), 0.0, 1.0);
    const T Lr = p.L_pp * motion.r;
    const T Y = form.Y_v_30deg * drift * c.Y_v * v * abs(u) -
                form.C_D_ends * c.C_D * cross_flow_integrals_of_ends<T>(v, c.C_rY * Lr / 2.0)(0);
    const T N = form.N_v_30deg * drift * c.N_v * v * u - form.C_D_arm * c.C_D * across -
                form.C_D_ends * c.C_D * cross_flow_integrals_of_ends<T>(v, c.C_rN * Lr / 2.0)(1);
    return {form.X_vv * v * v, Y, p.L_pp * N};
  }
};

static_assert(HasResistance<UnifiedHull<double>> && HasLinearDerivatives<UnifiedHull<double>> &&
              HasCrossFlowDrag<UnifiedHull<double>>);

}  // namespace leeway
