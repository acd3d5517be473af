#include "ship/plausibility.hpp"

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
    kFroude{0.0, 0.6}, kMass{0.03, 0.6}, kSurgeMass{0.01, 0.25}, kSwayMass{0.3, 2.0}, kGyration{0.2, 0.5},
    kResistance{0.002, 0.08}, kDiameter{0.15, 1.0}, kThrust{0.1, 0.8}, kWake{-0.1, 0.75}, kDeduction{-0.05, 0.6},
    kRudderArea{0.005, 0.08};

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
  remarks.usual("the Froude number of /u0_mps", std::abs(ship.u0_mps) / std::sqrt(kGravity_mps2 * p.L_pp), kFroude,
                "u0_mps is in m/s");
  const auto signs = [&](const auto& hull) {
    if constexpr (requires { hull.R_0; }) remarks.usual("/hull/R_0", hull.R_0, kResistance);
    if constexpr (requires { hull.X_0F; }) remarks.usual("-/hull/X_0F", -hull.X_0F, kResistance, "X_0F is negative");
    remarks.negative("/hull/Y_v", hull.Y_v, "since the hull resists drift");
    remarks.negative("/hull/N_v", hull.N_v, "since the flow turns a drifting hull further");
    remarks.negative("/hull/N_r", hull.N_r, "since the hull damps yaw");
  };
  std::visit(signs, ship.modules->hull);
}

void look_at_stern(const Ship& ship, Remarks& remarks) {
  const Particulars& p = ship.particulars;
  if (ship.modules->propeller)
    std::visit(
        [&](const auto& c) {
          remarks.usual("/propeller/D_P_m by the draft", c.D_P / p.d, kDiameter);
          if constexpr (requires { c.x_P; })
            remarks.negative("/propeller/x_P", c.x_P, "since the propeller is behind midship");
          if constexpr (requires { c.K_T; }) remarks.usual("/propeller/K_T/0", c.K_T[0], kThrust);
          if constexpr (requires { c.t_P; }) remarks.usual("/propeller/t_P", c.t_P, kDeduction);
          if constexpr (requires { c.w_P0; }) remarks.usual("/propeller/w_P0", c.w_P0, kWake);
        },
        *ship.modules->propeller);
  if (ship.modules->rudder)
    std::visit(
        [&](const auto& c) {
          remarks.negative("/rudder/x_R_m", c.x_R, "since the rudder is behind midship");
          remarks.usual("/rudder/A_R_m2 by L_pp d", c.A_R / (p.L_pp * p.d), kRudderArea, "it is in m^2");
        },
        *ship.modules->rudder);
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
  look_at_stern(ship, remarks);
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
