#pragma once

#include <string_view>

#include "core/types.hpp"
#include "forces/coefficient_list.hpp"
#include "forces/particulars.hpp"
#include "io/json.hpp"

namespace leeway {

/// Scales: mass 0.5 rho L^2 d, moment of inertia 0.5 rho L^4 d, length L.
template <typename T>
struct InertiaCoefficients {
  T m, x_G, m_x, m_y;
  T I_zG_plus_J_z;  ///< about the center of gravity: x_G^2 m comes on top at midship

  template <typename U>
  InertiaCoefficients<U> cast() const {
    return {U(m), U(x_G), U(m_x), U(m_y), U(I_zG_plus_J_z)};
  }

  /// Its keys in a ship's JSON, besides source.
  static InertiaCoefficients read(const io::JsonObject& json) {
    return {json.number("m", io::kPositive), json.number("x_G", {-0.5, 0.5}), json.number("m_x", io::kNotNegative),
            json.number("m_y", io::kNotNegative), json.number("I_zG_plus_J_z", io::kPositive)};
  }
};

/// Mass properties in SI: m_x, m_y are added mass; I_z is I_zG + J_z about the center of gravity.
template <typename T>
struct Inertia {
  static constexpr std::string_view reference = "Yasukawa & Yoshimura (2015), JMST 20, 37-52";
  T m, m_x, m_y, x_G, I_z;

  Inertia(const InertiaCoefficients<double>& c, const Particulars& p) {
    const double mass = 0.5 * p.rho * p.L_pp * p.L_pp * p.d;
    m = T(mass * c.m);
    m_x = T(mass * c.m_x);
    m_y = T(mass * c.m_y);
    x_G = T(p.L_pp * c.x_G);
    I_z = T(mass * p.L_pp * p.L_pp * c.I_zG_plus_J_z);
  }
  /// What is known up to a factor: visit(name, log_sd, reference, scale), where scale(k) multiplies by k.
  template <typename Visit>
  void coefficients(const Visit& visit) {
    visit("inertia.m_x", 0.3, reference, factor_on(m_x));
    visit("inertia.m_y", 0.15, reference, factor_on(m_y));
    visit("inertia.I_z", 0.15, reference, factor_on(I_z));
  }

  /// (du/dt, dv_m/dt [m/s^2], dr/dt [rad/s^2]) under a force at midship: the MMG equations of motion,
  ///   (m + m_x) u' - (m + m_y) v_m r - x_G m r^2 = X
  ///   (m + m_y) v_m' + (m + m_x) u r + x_G m r'  = Y
  ///   (I_z + x_G^2 m) r' + x_G m (v_m' + u r)    = N,
  /// sway and yaw solved together. In water that moves, nu and its rate are those through the water and the force
  /// includes frame_force(). Source: Yasukawa & Yoshimura (2015), JMST 20, 37-52.
  Vec3<T> acceleration(const Vec3<T>& nu, const Vec3<T>& force) const {
    const T &u = nu(0), &v = nu(1), &r = nu(2);
    const T M_x = m + m_x, M_y = m + m_y, S = x_G * m, I = I_z + x_G * S;
    const T Y = force(1) - M_x * u * r, N = force(2) - S * u * r;
    const T inverse = 1.0 / (M_y * I - S * S);
    return {(force(0) + M_y * v * r + S * r * r) / M_x, (I * Y - S * N) * inverse, (M_y * N - S * Y) * inverse};
  }

  /// The force at midship that adds these accelerations to acceleration().
  Vec3<T> force_of(const Vec3<T>& added) const {
    const T S = x_G * m;
    return {(m + m_x) * added(0), (m + m_y) * added(1) + S * added(2), (I_z + x_G * S) * added(2) + S * added(1)};
  }

  /// What the equations through the water need where the water itself accelerates: -(m a_x, m a_y, x_G m a_y), with the
  /// rigid mass alone, since added mass goes with the water. a: dV/dt along the ship's path, in ship axes [m/s^2].
  /// The same equations as over ground with added-mass terms in u_c and v_c (Fossen 2021, Handbook of Marine Craft).
  Vec3<T> frame_force(const Vec2<T>& a) const { return {-m * a(0), -m * a(1), -x_G * m * a(1)}; }

  /// J_z, where the ship gives only I_zG + J_z: with a radius of gyration of 0.25 L_pp for I_zG, as in the MMG standard
  /// method; not below zero.
  T added_moment(double L_pp) const {
    const T J_z = I_z - m * (0.0625 * L_pp * L_pp);
    return J_z > T(0.0) ? J_z : T(0.0);
  }
};

}  // namespace leeway
