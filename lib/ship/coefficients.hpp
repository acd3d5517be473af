#pragma once

#include <array>
#include <cstddef>
#include <variant>

#include "recording/trajectory.hpp"

/// Coefficients of the force modules, as a ship's JSON gives them. Those that a fit may move are of the scalar type T;
/// lengths, areas and densities are double. Primes are dropped: without a unit, a coefficient is nondimensional.
namespace leeway {

template <typename U, typename T, std::size_t n>
std::array<U, n> cast_all(const std::array<T, n>& from) {
  std::array<U, n> to{};
  for (std::size_t i = 0; i < n; ++i) to[i] = U(from[i]);
  return to;
}

struct Particulars {
  double L_pp = 0.0, B = 0.0, d = 0.0;  ///< [m]
  double rho = 0.0;                     ///< water [kg/m^3]
};

/// Scales: mass 0.5 rho L^2 d, moment of inertia 0.5 rho L^4 d, length L.
template <typename T>
struct InertiaCoefficients {
  T m, x_G, m_x, m_y;
  T I_zG_plus_J_z;  ///< about the center of gravity: x_G^2 m comes on top at midship

  template <typename U>
  InertiaCoefficients<U> cast() const {
    return {U(m), U(x_G), U(m_x), U(m_y), U(I_zG_plus_J_z)};
  }
};

/// Yoshimura, Nakao & Ishibashi (2009); forces/unified_hull.hpp.
template <typename T>
struct UnifiedHullCoefficients {
  T X_0F, X_0A, X_vr, Y_v, Y_r, N_v, N_r, C_D, C_rY, C_rN;

  template <typename U>
  UnifiedHullCoefficients<U> cast() const {
    return {U(X_0F), U(X_0A), U(X_vr), U(Y_v), U(Y_r), U(N_v), U(N_r), U(C_D), U(C_rY), U(C_rN)};
  }
};

/// Yasukawa & Yoshimura (2015), MMG standard method; forces/standard_hull.hpp.
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
};

/// Kang et al. (2008), propeller of a single-propeller twin-rudder ship; forces/kang_propeller.hpp.
template <typename T>
struct KangPropellerCoefficients {
  double D_P;          ///< [m]
  double pitch_ratio;  ///< P/D
  double x_P;          ///< by L_pp, + forward
  double v_P_sign;     ///< v_P' = v' + v_P_sign x_P' r': -1 as coded by the model's authors, +1 at the propeller
  std::array<T, 3> K_T_ahead, K_T_astern;  ///< constant, J, J^2; for J >= 0 and J < 0
  std::array<T, 3> a, b, c, d;             ///< wake (a, b) and thrust deduction (c, d)

  template <typename U>
  KangPropellerCoefficients<U> cast() const {
    return {D_P,
            pitch_ratio,
            x_P,
            v_P_sign,
            cast_all<U>(K_T_ahead),
            cast_all<U>(K_T_astern),
            cast_all<U>(a),
            cast_all<U>(b),
            cast_all<U>(c),
            cast_all<U>(d)};
  }
};

/// Propeller of the Esso Osaka model, ahead and astern; forces/four_quadrant_propeller.hpp.
template <typename T>
struct FourQuadrantPropellerCoefficients {
  double D_P, pitch_ratio, x_P;   ///< as above
  std::array<T, 3> K_T;           ///< n >= 0: constant, J, J^2
  T t_P;                          ///< n >= 0
  std::array<T, 3> w_P;           ///< constant, |v_P'|, v_P'^2
  std::array<T, 2> K_T_reversed;  ///< n < 0, J_s above J_s_reversed: constant, J_s
  T K_T_reversed_low;             ///< n < 0, J_s below
  double J_s_reversed;
  std::array<T, 3> Y_backing, N_backing;  ///< n >= 0, u < 0: constant, J_s, J_s^2; by (n P)^2
  std::array<double, 2> J_s_walk;         ///< n < 0: bounds of the three ranges
  std::array<T, 2> Y_walk_low, Y_walk_middle, N_walk_low, N_walk_middle;  ///< constant, J_s; by (n D_P)^2
  T Y_walk_high, N_walk_high;

  template <typename U>
  FourQuadrantPropellerCoefficients<U> cast() const {
    return {D_P,
            pitch_ratio,
            x_P,
            cast_all<U>(K_T),
            U(t_P),
            cast_all<U>(w_P),
            cast_all<U>(K_T_reversed),
            U(K_T_reversed_low),
            J_s_reversed,
            cast_all<U>(Y_backing),
            cast_all<U>(N_backing),
            J_s_walk,
            cast_all<U>(Y_walk_low),
            cast_all<U>(Y_walk_middle),
            cast_all<U>(N_walk_low),
            cast_all<U>(N_walk_middle),
            U(Y_walk_high),
            U(N_walk_high)};
  }
};

/// Propeller of the MMG standard method; forces/standard_propeller.hpp.
template <typename T>
struct StandardPropellerCoefficients {
  double D_P, x_P;                ///< as above
  double pitch_ratio;             ///< 0 where it is not given: for rudders that ask for it
  std::array<T, 3> K_T;           ///< n >= 0: constant, J, J^2
  T t_P, w_P0;                    ///< w_P0: on a straight run
  T C_1;                          ///< how fast the wake goes away with |beta_P|
  T C_2_negative, C_2_positive;   ///< (1 - w_P)/(1 - w_P0) far out, for beta_P < 0 and > 0
  bool is_reversible;             ///< whether the law for n < 0 is there
  std::array<T, 2> K_T_reversed;  ///< n < 0, J_s above J_s_reversed: constant, J_s
  T K_T_reversed_low;             ///< n < 0, J_s below
  double J_s_reversed;

  template <typename U>
  StandardPropellerCoefficients<U> cast() const {
    return {D_P,
            x_P,
            pitch_ratio,
            cast_all<U>(K_T),
            U(t_P),
            U(w_P0),
            U(C_1),
            U(C_2_negative),
            U(C_2_positive),
            is_reversible,
            cast_all<U>(K_T_reversed),
            U(K_T_reversed_low),
            J_s_reversed};
  }
};

/// VecTwin rudders after Kang et al. (2008); the regression's polynomials stand in forces/vectwin_rudders.hpp.
template <typename T>
struct VectwinRuddersCoefficients {
  double A_R;  ///< of each rudder [m^2]
  double aspect_ratio;
  double x_R;  ///< [m], + forward
  T t_R, k_x;

  template <typename U>
  VectwinRuddersCoefficients<U> cast() const {
    return {A_R, aspect_ratio, x_R, U(t_R), U(k_x)};
  }
};

/// One rudder behind one propeller; forces/single_rudder.hpp.
template <typename T>
struct SingleRudderCoefficients {
  double A_R;  ///< [m^2]
  double aspect_ratio;
  double x_R;  ///< [m], + forward
  T t_R, a_H, x_H, l_R, epsilon, k_x, gamma_R_negative, gamma_R_positive, f_alpha;
  T k_reversed, k_hull_wake;  ///< slipstream factor and u^2 term behind a reversed propeller

  template <typename U>
  SingleRudderCoefficients<U> cast() const {
    return {A_R,
            aspect_ratio,
            x_R,
            U(t_R),
            U(a_H),
            U(x_H),
            U(l_R),
            U(epsilon),
            U(k_x),
            U(gamma_R_negative),
            U(gamma_R_positive),
            U(f_alpha),
            U(k_reversed),
            U(k_hull_wake)};
  }
};

/// Rudder of the MMG standard method; forces/standard_rudder.hpp.
template <typename T>
struct StandardRudderCoefficients {
  double A_R;  ///< [m^2]
  double H_R;  ///< height [m]
  double x_R;  ///< [m], + forward
  T t_R, a_H, x_H, l_R, epsilon, kappa, gamma_R_negative, gamma_R_positive, f_alpha;
  T k_reversed;  ///< share of a race that goes forward, felt on the propeller's suction side

  template <typename U>
  StandardRudderCoefficients<U> cast() const {
    return {A_R,
            H_R,
            x_R,
            U(t_R),
            U(a_H),
            U(x_H),
            U(l_R),
            U(epsilon),
            U(kappa),
            U(gamma_R_negative),
            U(gamma_R_positive),
            U(f_alpha),
            U(k_reversed)};
  }
};

/// Side thruster after Kobayashi (1988); forces/side_thruster.hpp.
template <typename T>
struct SideThrusterCoefficients {
  Channel channel;            ///< n_bt or n_st
  double D, x;                ///< [m]
  T K_T_positive;             ///< n >= 0: force to starboard
  T K_T_negative;             ///< n < 0: a negative number
  std::array<T, 3> a_Y, a_N;  ///< constant, Fr, Fr^2
  double u_max;               ///< [m/s], no force from here on

  template <typename U>
  SideThrusterCoefficients<U> cast() const {
    return {channel, D, x, U(K_T_positive), U(K_T_negative), cast_all<U>(a_Y), cast_all<U>(a_N), u_max};
  }
};

/// Geometry above water for Fujiwara et al. (1998); forces/fujiwara_wind.hpp.
struct FujiwaraWindGeometry {
  double rho_air;         ///< [kg/m^3]
  double B;               ///< [m]
  double A_T, A_L, A_OD;  ///< front, side, side of superstructure and deck cargo [m^2]
  double C, C_BR;         ///< midship to the centroids of A_L and A_OD, + forward [m]
  double H_BR, H_C;       ///< waterline to top of bridge and to the centroid of A_L [m]
};

using HullCoefficients = std::variant<UnifiedHullCoefficients<double>, StandardHullCoefficients<double>>;
using PropellerCoefficients = std::variant<KangPropellerCoefficients<double>, FourQuadrantPropellerCoefficients<double>,
                                           StandardPropellerCoefficients<double>>;
using RudderCoefficients = std::variant<VectwinRuddersCoefficients<double>, SingleRudderCoefficients<double>,
                                        StandardRudderCoefficients<double>>;
using ThrusterCoefficients = std::variant<SideThrusterCoefficients<double>>;
using WindCoefficients = std::variant<FujiwaraWindGeometry>;

}  // namespace leeway
