#include "gap/locate/regime_variables.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/units.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {

std::vector<RegimeVariable> regime_variables(const Campaign& campaign) {
  const double L = campaign.ship.particulars.L_pp, deg = 1.0 / kDegree;
  std::vector<RegimeVariable> variables{
      {"u", "u", "m/s", "surge", 1.0, false, [](const Moment& m) { return m.u; }},
      {"beta", "drift angle", "deg", "drift angle", deg, false, [](const Moment& m) { return std::atan2(-m.v, m.u); }},
      {"r_prime", "r L/U", "", "yaw rate r L/U", 1.0, false, [L](const Moment& m) {
         return std::clamp(m.r * L / std::max(m.U, kPolicy.locate.least_froude * std::sqrt(kGravity_mps2 * L)),
                           -kPolicy.locate.most_yaw_rate, kPolicy.locate.most_yaw_rate);
       }}};
  for (const Actuator& actuator : campaign.ship.actuators) {
    const Channel c = actuator.channel;
    const std::string name(info(c).name);
    variables.push_back({name, name, actuator.is_angle() ? "deg" : "1/s",
                         (actuator.is_rudder()  ? "rudder angle "
                          : actuator.is_angle() ? "angle "
                                                : "revolutions ") +
                             name,
                         actuator.is_angle() ? deg : 1.0, false, [c](const Moment& m) { return m.actuators[c]; }});
  }
  if (campaign.has_wind) {
    // Pressure, with the sign of where it comes from.
    variables.push_back({"U_A", "U_A^2 from ahead", "m^2/s^2", "square of the apparent wind from ahead", 1.0, false,
                         [](const Moment& m) { return m.apparent.norm() * m.apparent(0); }, 0, 0});
    variables.push_back({"U_A", "U_A^2 from starboard", "m^2/s^2", "square of the apparent wind from starboard", 1.0,
                         false, [](const Moment& m) { return m.apparent.norm() * m.apparent(1); }, 1, 2});
    variables.push_back({"gamma_A", "apparent wind from", "deg", "direction of the apparent wind", deg, true,
                         [](const Moment& m) { return std::atan2(m.apparent(1), m.apparent(0)); }});
  }
  if (campaign.has_heading)
    variables.push_back(
        {"psi", "heading", "deg", "heading", deg, true, [](const Moment& m) { return wrap_angle(m.psi); }});
  if (campaign.has_position) {
    variables.push_back({"x0", "x0", "m", "position x0", 1.0, false, [](const Moment& m) { return m.x0; }});
    variables.push_back({"y0", "y0", "m", "position y0", 1.0, false, [](const Moment& m) { return m.y0; }});
  }
  variables.push_back({"t", "time", "s", "time", 1.0, false, [](const Moment& m) { return m.t_s; }});
  return variables;
}

}  // namespace leeway::gap
