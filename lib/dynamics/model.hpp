#pragma once

#include "core/wind.hpp"
#include "forces/registry.hpp"

namespace leeway {

/// Mass properties in SI; (m_x, m_y: added mass, I_z: I_zG + J_z about the center of gravity).
template <typename T>
struct Inertia {
  T m, m_x, m_y, x_G, I_z;

  Inertia(const InertiaCoefficients<double>& c, const Particulars& p) {
    const double mass = 0.5 * p.rho * p.L_pp * p.L_pp * p.d;
    m = T(mass * c.m);
    m_x = T(mass * c.m_x);
    m_y = T(mass * c.m_y);
    x_G = T(p.L_pp * c.x_G);
    I_z = T(mass * p.L_pp * p.L_pp * c.I_zG_plus_J_z);
  }

  /// (du/dt, dv_m/dt [m/s^2], dr/dt [rad/s^2]) under a force at midship: the MMG equations of motion,
  ///   (m + m_x) u' - (m + m_y) v_m r - x_G m r^2 = X
  ///   (m + m_y) v_m' + (m + m_x) u r + x_G m r'  = Y
  ///   (I_z + x_G^2 m) r' + x_G m (v_m' + u r)    = N,
  /// sway and yaw solved together. Source: Yasukawa & Yoshimura (2015), JMST 20, 37-52.
  Vec3<T> acceleration(const Vec3<T>& nu, const Vec3<T>& force) const {
    const T &u = nu(0), &v = nu(1), &r = nu(2);
    const T M_x = m + m_x, M_y = m + m_y, S = x_G * m, I = I_z + x_G * S;
    const T Y = force(1) - M_x * u * r, N = force(2) - S * u * r;
    const T determinant = M_y * I - S * S;
    return {(force(0) + M_y * v * r + S * r * r) / M_x, (I * Y - S * N) / determinant, (M_y * N - S * Y) / determinant};
  }
};

/// A ship in deep, still water: mass and force modules. T is double, or an autodiff scalar for derivatives by state,
/// actuators or, after they were set, coefficients of the modules.
template <typename T>
struct Model {
  Inertia<T> inertia;
  ForceModules<T> modules;

  explicit Model(const Ship& ship) : inertia(ship.inertia, ship.particulars), modules(ship) {}

  /// (du/dt, dv_m/dt, dr/dt) at midship.
  ///   nu             (u, v_m [m/s], r [rad/s]) at midship
  ///   actuators      actual values
  ///   apparent_wind  in ship axes [m/s], pointing to where it comes from: apparent_wind() of core/wind.hpp
  Vec3<T> acceleration(const Vec3<T>& nu, const Actuators<T>& actuators, const Vec2<T>& apparent_wind) const {
    return inertia.acceleration(nu, modules.force(nu, actuators, apparent_wind));
  }
};

}  // namespace leeway
