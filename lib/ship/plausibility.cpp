#include "ship/plausibility.hpp"

#include <algorithm>
#include <cmath>
#include <mutex>

#include <fmt/format.h>

#include "core/units.hpp"
#include "forces/registry.hpp"

namespace leeway {
namespace {

// What ships have, merchant ships and their models above all; wider than what one expects of a good one, since what
// lies outside is to be a mistake most of the time.
struct Usual {
  double low, high;
};
constexpr Usual kDensity{990.0, 1035.0}, kLengthByBreadth{2.5, 12.0}, kBreadthByDraft{1.2, 10.0}, kBlock{0.35, 0.95},
    kMass{0.03, 0.6}, kSurgeMass{0.01, 0.25}, kSwayMass{0.3, 2.0}, kGyration{0.2, 0.5}, kGravityCenter{-0.1, 0.1},
    kResistance{0.002, 0.08}, kSwayByYaw{-0.3, 0.3}, kFourthDrift{-1.0, 3.0}, kCrossFlow{0.1, 2.5};
constexpr Usual kDiameter{0.15, 1.0}, kThrust{0.1, 0.8}, kWake{-0.1, 0.75}, kDeduction{-0.05, 0.6};
constexpr Usual kRudderArea{0.005, 0.08}, kRudderPlace{-0.6, 0.0}, kRudderHeight{0.2, 1.2}, kHullShare{0.0, 1.0},
    kHullSharePlace{-0.6, -0.2}, kRudderArm{-1.5, -0.3}, kStraightening{0.1, 1.2}, kWakeRatio{0.5, 2.0},
    kNormalForce{1.0, 5.0};
constexpr Usual kFrontArea{0.01, 3.0}, kSideArea{0.05, 8.0};  // of the wind, by L d
constexpr Usual kThrusterThrust{0.05, 0.8}, kThrusterPlace{-0.55, 0.55};
// As of a full-scale ship by Froude's law: [m/s], [deg/s]; angles [deg].
constexpr Usual kPropellerTip{0.0, 120.0}, kThrusterTip{0.0, 60.0}, kRudderRate{0.5, 40.0}, kRudderAngle{5.0, 180.0};

// The fastest that hulls of this block coefficient go: Alexander's formula, C_b = 1.08 - 1.68 Fr, and 0.1 more.
Usual usual_froude(double C_b) {
  return {0.0, 0.01 * std::round(100.0 * std::clamp((1.08 - C_b) / 1.68 + 0.1, 0.15, 0.6))};
}

class Remarks {
 public:
  void usual(const std::string& what, double value, Usual range, const std::string& hint = "") {
    if (value >= range.low && value <= range.high) return;
    told.push_back(fmt::format("{} is {:.3g}; usual: {:g} to {:g}{}", what, value, range.low, range.high,
                               hint.empty() ? "" : ": " + hint));
  }
  void negative(const std::string& what, double value, const std::string& why) {
    if (!(value < 0.0)) told.push_back(fmt::format("{} is {:.3g}; usual: below 0, {}", what, value, why));
  }
  std::vector<std::string> told;
};

void look_at_hull(const Ship& ship, Remarks& remarks) {
  const Particulars& p = ship.particulars;
  remarks.usual("/particulars/rho_kgpm3", p.rho, kDensity, "of water, in kg/m^3");
  remarks.usual("L_pp/B", p.L_pp / p.B, kLengthByBreadth, "lengths are in m");
  remarks.usual("B/d", p.B / p.d, kBreadthByDraft, "lengths are in m");
  const InertiaCoefficients<double>& c = ship.inertia;
  if (c.m > kMass.high)
    remarks.usual("/inertia/m", c.m, kMass, "it is m/(0.5 rho L^2 d), no mass in kg or t");
  else
    remarks.usual("C_b = m L_pp/(2 B), from /inertia/m,", ship.block_coefficient(), kBlock);
  remarks.usual("/inertia/m_x by m", c.m_x / c.m, kSurgeMass);
  remarks.usual("/inertia/m_y by m", c.m_y / c.m, kSwayMass);
  remarks.usual("the radius of gyration from /inertia/I_zG_plus_J_z, by L_pp,", std::sqrt(c.I_zG_plus_J_z / c.m),
                kGyration, "it is (I_zG + J_z)/(0.5 rho L^4 d)");
  remarks.usual("/inertia/x_G", c.x_G, kGravityCenter, "it is by L_pp, from midship");
  remarks.usual("the Froude number of /u0_mps", std::abs(ship.u0_mps) / std::sqrt(kGravity_mps2 * p.L_pp),
                usual_froude(ship.block_coefficient()), "for this block coefficient; u0_mps is in m/s");
  const auto signs = [&](const auto& hull) {
    if constexpr (requires { hull.R_0; }) remarks.usual("/hull/R_0", hull.R_0, kResistance);
    if constexpr (requires { hull.X_0F; }) remarks.usual("-/hull/X_0F", -hull.X_0F, kResistance, "X_0F is negative");
    remarks.negative("/hull/Y_v", hull.Y_v, "since the hull resists drift");
    remarks.negative("/hull/N_v", hull.N_v, "since the flow turns a drifting hull further");
    remarks.negative("/hull/N_r", hull.N_r, "since the hull damps yaw");
    remarks.usual("/hull/Y_r", hull.Y_r, kSwayByYaw);
    if constexpr (requires { hull.C_D; }) remarks.usual("/hull/C_D", hull.C_D, kCrossFlow);
    if constexpr (requires { hull.X_vvvv; }) remarks.usual("/hull/X_vvvv", hull.X_vvvv, kFourthDrift);
    if constexpr (requires { hull.Y_vvv; }) {
      remarks.negative("/hull/Y_vvv", hull.Y_vvv, "since the cross flow resists drift");
      remarks.negative("/hull/Y_vrr", hull.Y_vrr, "since yawing adds to the resistance to drift");
      remarks.negative("/hull/N_vvr", hull.N_vvr, "since drift adds to the damping of yaw");
      remarks.negative("/hull/N_rrr", hull.N_rrr, "since the cross flow damps yaw");
    }
  };
  std::visit(signs, ship.modules->hull);
}

void look_at_propeller(const Ship& ship, Remarks& remarks) {
  if (!ship.modules->propeller) return;
  const auto falls = [&](const char* key, const auto& K_T) {
    const double slope = K_T[1] + 0.5 * K_T[2];  // from J = 0 to 0.5
    remarks.negative(fmt::format("the slope of {} over J", key), slope, "since thrust falls with the advance ratio");
  };
  std::visit(
      [&](const auto& c) {
        remarks.usual("/propeller/D_P_m by the draft", c.D_P / ship.particulars.d, kDiameter);
        if constexpr (requires { c.x_P; })
          remarks.negative("/propeller/x_P", c.x_P, "since the propeller is behind midship");
        if constexpr (requires { c.K_T; }) {
          remarks.usual("/propeller/K_T/0", c.K_T[0], kThrust);
          falls("/propeller/K_T", c.K_T);
        }
        if constexpr (requires { c.K_T_ahead; }) falls("/propeller/K_T_ahead", c.K_T_ahead);
        if constexpr (requires { c.t_P; }) remarks.usual("/propeller/t_P", c.t_P, kDeduction);
        if constexpr (requires { c.w_P0; }) remarks.usual("/propeller/w_P0", c.w_P0, kWake);
        if (const Actuator* n = ship.find_actuator(Channel::n_p))
          remarks.usual("the speed of the propeller's tips at the largest revolutions, as of a full-scale ship,",
                        kPi * c.D_P * n->max * std::sqrt(ship.scale), kPropellerTip,
                        "in m/s; revolutions are per second");
      },
      *ship.modules->propeller);
}

void look_at_rudder(const Ship& ship, Remarks& remarks) {
  if (!ship.modules->rudder) return;
  const Particulars& p = ship.particulars;
  std::visit(
      [&](const auto& c) {
        if (c.x_R < 0.0)
          remarks.usual("/rudder/x_R_m by L_pp", c.x_R / p.L_pp, kRudderPlace, "it is in m");
        else
          remarks.negative("/rudder/x_R_m", c.x_R, "since the rudder is behind midship");
        remarks.usual("/rudder/A_R_m2 by L_pp d", c.A_R / (p.L_pp * p.d), kRudderArea, "it is in m^2");
        if constexpr (requires { c.H_R; })
          remarks.usual("/rudder/H_R_m by the draft", c.H_R / p.d, kRudderHeight, "it is in m");
        if constexpr (requires { c.a_H + c.x_H + c.l_R + c.gamma_R_negative + c.epsilon; }) {
          remarks.usual("/rudder/a_H", c.a_H, kHullShare);
          remarks.usual("/rudder/x_H", c.x_H, kHullSharePlace, "it is by L_pp, from midship");
          remarks.usual("/rudder/l_R", c.l_R, kRudderArm, "it is by L_pp, about twice x_R");
          remarks.usual("/rudder/gamma_R_negative", c.gamma_R_negative, kStraightening);
          remarks.usual("/rudder/gamma_R_positive", c.gamma_R_positive, kStraightening);
          remarks.usual("/rudder/epsilon", c.epsilon, kWakeRatio);
          remarks.usual("/rudder/f_alpha", c.f_alpha, kNormalForce);
        }
      },
      *ship.modules->rudder);
  for (std::size_t i = 0; i < ship.actuators.size(); ++i) {
    const Actuator& a = ship.actuators[i];
    if (!a.is_angle() || a.turns_freely()) continue;
    const std::string at = fmt::format("/actuators/{}", i);
    for (const auto& [key, bound] : {std::pair{"/min_deg", a.min}, std::pair{"/max_deg", a.max}})
      if (bound != 0.0)
        remarks.usual(at + key + " without its sign", std::abs(bound) / kDegree, kRudderAngle, "it is in degrees");
    remarks.usual(at + "/rate_degps, as of a full-scale ship,", a.rate / kDegree / std::sqrt(ship.scale), kRudderRate,
                  "it is in degrees per second");
  }
}

void look_at_thrusters(const Ship& ship, Remarks& remarks) {
  for (std::size_t i = 0; i < ship.modules->thrusters.size(); ++i)
    std::visit(
        [&](const auto& c) {
          const std::string at = fmt::format("/thrusters/{}", i);
          remarks.usual(at + "/x_m by L_pp", c.x / ship.particulars.L_pp, kThrusterPlace, "it is in m");
          const char* hint = "T/(rho n^2 D^4), thrust in N, revolutions per second";
          if constexpr (requires { c.K_T_positive; }) {
            remarks.usual(at + "/K_T_positive", c.K_T_positive, kThrusterThrust, hint);
            remarks.usual("-" + at + "/K_T_negative", -c.K_T_negative, kThrusterThrust, hint);
          }
          if constexpr (requires { c.K_T; }) remarks.usual(at + "/K_T/0", c.K_T[0], kThrusterThrust, hint);
          if (const Actuator* n = ship.find_actuator(c.channels()[0]))
            remarks.usual("the speed of the blades' tips of " + at + ", as of a full-scale ship,",
                          kPi * c.D * n->max * std::sqrt(ship.scale), kThrusterTip,
                          "in m/s; revolutions are per second");
        },
        ship.modules->thrusters[i]);
}

void look_at_wind(const Ship& ship, Remarks& remarks) {
  if (!ship.modules->wind) return;
  const double L_d = ship.particulars.L_pp * ship.particulars.d;
  std::visit(
      [&](const auto& g) {
        remarks.usual("/wind/A_T_m2 by L_pp d", g.A_T / L_d, kFrontArea, "it is in m^2");
        remarks.usual("/wind/A_L_m2 by L_pp d", g.A_L / L_d, kSideArea, "it is in m^2");
      },
      *ship.modules->wind);
}

struct Listening {
  std::mutex mutex;
  ShipListener listener;
};
Listening& listening() {
  static Listening result;
  return result;
}

}  // namespace

std::vector<std::string> implausible(const Ship& ship) {
  Remarks remarks;
  look_at_hull(ship, remarks);
  look_at_propeller(ship, remarks);
  look_at_rudder(ship, remarks);
  look_at_thrusters(ship, remarks);
  look_at_wind(ship, remarks);
  return remarks.told;
}

void listen_to_ships(ShipListener listener) {
  const std::lock_guard lock(listening().mutex);
  listening().listener = std::move(listener);
}

void tell_implausible(const Ship& ship) {
  const std::lock_guard lock(listening().mutex);
  if (!listening().listener) return;
  for (const std::string& warning : implausible(ship)) listening().listener(ship.file, warning);
}

}  // namespace leeway
