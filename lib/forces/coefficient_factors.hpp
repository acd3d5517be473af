#pragma once

#include <algorithm>
#include <string>
#include <variant>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/errors.hpp"
#include "forces/inertia.hpp"
#include "forces/registry.hpp"

namespace leeway {

/// Calls visit(name, log_sd, scale) for each coefficient of a ship, or group of them, that is known up to a factor,
/// always in the same order; scale(k) multiplies it by k. The log_sd are those of docs/gap-locate.md for a model with
/// empirical or regressed coefficients. A ship's JSON multiplies them by its `coefficient_factors`.
template <typename T, typename Visit>
void for_each_coefficient(Inertia<T>& inertia, ForceModules<T>& modules, const Visit& visit) {
  const auto one = [&](const char* name, double log_sd, T& coefficient) {
    visit(name, log_sd, [&coefficient](const T& k) { coefficient *= k; });
  };
  one("inertia.m_x", 0.3, inertia.m_x);
  one("inertia.m_y", 0.15, inertia.m_y);
  one("inertia.I_z", 0.15, inertia.I_z);

  std::visit(
      [&](auto& hull) {
        visit("hull.resistance", 0.10, [&](const T& k) { hull.scale_resistance(k); });
        visit("hull.resistance_slow", 0.10, [&](const T& k) { hull.resistance_law.scale_slow(k); });
        one("hull.X_vr", 0.3, hull.c.X_vr);
        one("hull.Y_v", 0.15, hull.c.Y_v);
        one("hull.Y_r", 0.25, hull.c.Y_r);
        one("hull.N_v", 0.15, hull.c.N_v);
        one("hull.N_r", 0.15, hull.c.N_r);
        if constexpr (requires { hull.c.C_D; }) {
          one("hull.C_D", 0.2, hull.c.C_D);
          one("hull.C_rY", 0.2, hull.c.C_rY);
          one("hull.C_rN", 0.2, hull.c.C_rN);
          one("hull.X_0A", 0.10, hull.c.X_0A);
        } else {
          one("hull.X_vv", 0.3, hull.c.X_vv);
          one("hull.X_rr", 0.3, hull.c.X_rr);
          one("hull.X_vvvv", 0.3, hull.c.X_vvvv);
          one("hull.Y_vvv", 0.2, hull.c.Y_vvv);
          one("hull.Y_vvr", 0.2, hull.c.Y_vvr);
          one("hull.Y_vrr", 0.2, hull.c.Y_vrr);
          one("hull.Y_rrr", 0.2, hull.c.Y_rrr);
          one("hull.N_vvv", 0.2, hull.c.N_vvv);
          one("hull.N_vvr", 0.2, hull.c.N_vvr);
          one("hull.N_vrr", 0.2, hull.c.N_vrr);
          one("hull.N_rrr", 0.2, hull.c.N_rrr);
        }
      },
      modules.hull);

  std::visit(
      [&](auto& propeller) {
        // Levels on a straight run, (1 - w_P), (1 - t_P) and K_T, and on top of them what changes them.
        auto& c = propeller.c;
        visit("propeller.K_T", 0.05, [&](const T& k) { propeller.scale_thrust(k); });
        if constexpr (requires { c.K_T_ahead; }) {
          one("propeller.K_T_J", 0.10, c.K_T_ahead[1]);
          one("propeller.K_T_JJ", 0.10, c.K_T_ahead[2]);
          visit("propeller.K_T_astern", 0.10, [&](const T& k) {
            for (T& K_T : c.K_T_astern) K_T *= k;
          });
        } else {
          one("propeller.K_T_J", 0.10, c.K_T[1]);
          one("propeller.K_T_JJ", 0.10, c.K_T[2]);
          visit("propeller.K_T_reversed", 0.10, [&](const T& k) {
            for (T& K_T : c.K_T_reversed) K_T *= k;
            c.K_T_reversed_low *= k;
          });
        }
        if constexpr (requires { c.a; }) {
          visit("propeller.1-w_P", 0.05, [&](const T& k) {
            for (T& a : c.a) a *= k;
          });
          one("propeller.a_1", 0.10, c.a[1]);
          one("propeller.a_2", 0.10, c.a[2]);
          one("propeller.b_0", 0.2, c.b[0]);
          visit("propeller.1-t_P", 0.05, [&](const T& k) {
            for (T& coefficient : c.c) coefficient *= k;
          });
          one("propeller.c_1", 0.10, c.c[1]);
          one("propeller.c_2", 0.10, c.c[2]);
          one("propeller.d_0", 0.2, c.d[0]);
        } else {
          T& w_P = [&]() -> T& {
            if constexpr (requires { c.w_P0; })
              return c.w_P0;
            else
              return c.w_P[0];
          }();
          visit("propeller.1-w_P", 0.05, [&w_P](const T& k) { w_P = 1.0 - k * (1.0 - w_P); });
          visit("propeller.1-t_P", 0.05, [&](const T& k) { c.t_P = 1.0 - k * (1.0 - c.t_P); });
          if constexpr (requires { c.C_1; }) {
            one("propeller.C_1", 0.2, c.C_1);
            one("propeller.C_2_negative", 0.10, c.C_2_negative);
            one("propeller.C_2_positive", 0.10, c.C_2_positive);
          } else {
            one("propeller.w_P_v", 0.2, c.w_P[1]);
            one("propeller.w_P_vv", 0.2, c.w_P[2]);
          }
        }
      },
      modules.propeller);

  std::visit(
      [&](auto& rudder) {
        auto& c = rudder.c;
        visit("rudder.1-t_R", 0.05, [&](const T& k) { c.t_R = 1.0 - k * (1.0 - c.t_R); });
        if constexpr (requires { rudder.k_port; }) {
          one("rudder.gain_port", 0.10, rudder.k_port);
          one("rudder.gain_starboard", 0.10, rudder.k_starboard);
          one("rudder.k_x", 0.10, c.k_x);
          visit("rudder.gamma_R", 0.2, [&](const T& k) { rudder.scale_flow_straightening(k); });
          one("rudder.interference", 0.2, rudder.k_interference);
          one("rudder.a_H", 0.2, rudder.k_a_H);
          one("rudder.x_H", 0.10, rudder.k_x_H);
          one("rudder.l_R", 0.15, rudder.k_l_R);
        } else {
          one("rudder.gain", 0.10, c.f_alpha);
          one("rudder.a_H", 0.2, c.a_H);
          one("rudder.x_H", 0.10, c.x_H);
          one("rudder.l_R", 0.15, c.l_R);
          one("rudder.epsilon", 0.05, c.epsilon);
          if constexpr (requires { c.kappa; })
            one("rudder.kappa", 0.10, c.kappa);
          else
            one("rudder.k_x", 0.10, c.k_x);
          one("rudder.gamma_R_negative", 0.2, c.gamma_R_negative);
          one("rudder.gamma_R_positive", 0.2, c.gamma_R_positive);
        }
        one("rudder.gain_35deg", 0.2, rudder.shape.k_35);
        one("rudder.gain_90deg", 0.2, rudder.shape.k_90);
      },
      modules.rudder);

  for (ThrusterModule<T>& thruster : modules.thrusters)
    std::visit(
        [&](auto& t) {
          const bool is_bow = t.c.channel == Channel::n_bt;
          one(is_bow ? "thruster.K_T_bow_positive" : "thruster.K_T_stern_positive", 0.10, t.c.K_T_positive);
          one(is_bow ? "thruster.K_T_bow_negative" : "thruster.K_T_stern_negative", 0.10, t.c.K_T_negative);
        },
        thruster);
  if (modules.wind)
    std::visit(
        [&](auto& wind) {
          visit("wind.k_X", 0.2, [&](const T& k) { wind.scale(k, T(1.0), T(1.0)); });
          visit("wind.k_Y", 0.15, [&](const T& k) { wind.scale(T(1.0), k, T(1.0)); });
          visit("wind.k_N", 0.3, [&](const T& k) { wind.scale(T(1.0), T(1.0), k); });
        },
        *modules.wind);
}

/// Multiplies coefficients by the factors of the ship. Throws InputError for a name that it does not have.
template <typename T>
void multiply_coefficients(const Ship& ship, Inertia<T>& inertia, ForceModules<T>& modules) {
  for (const CoefficientFactor& by : ship.coefficient_factors) {
    std::vector<std::string> known;
    for_each_coefficient(inertia, modules, [&](const char* name, double, const auto& scale) {
      known.emplace_back(name);
      if (by.name == name) scale(T(by.factor));
    });
    if (std::find(known.begin(), known.end(), by.name) == known.end())
      throw InputError(ship.file, 0, "/coefficient_factors/" + by.name,
                       fmt::format("not a coefficient of this ship; known: {}", fmt::join(known, ", ")));
  }
}

}  // namespace leeway
