#include "gap/show/module_changes.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

#include <fmt/format.h>

#include "core/errors.hpp"
#include "core/units.hpp"
#include "dynamics/straight_run.hpp"
#include "effects/description.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {
namespace {

// One of the numbers by which the field knows a module.
struct Quantity {
  std::string name, where, unit;
  std::function<double(const Ship&)> of;
  std::string by_effect{};  // that does nothing but change it
};

constexpr const char* kRevolutions = "1/s";

std::string multiplied_by(MultipliedForce force) {
  for (const EffectDescription& effect : effect_catalogue())
    if (effect.info.multiplies == force) return std::string(effect.info.name);
  return "";
}

std::string at_speed(double u) { return fmt::format("at {:.3g} m/s", u); }

ModuleForces<double> forces(const Ship& ship, const Vec3<double>& nu, const Actuators<double>& actuators,
                            const Vec2<double>& wind = Vec2<double>::Zero()) {
  return Model<double>(ship).forces(nu, actuators, wind);
}

// The actuators that drive the ship, all others idle.
Actuators<double> driving(const Ship& ship, const UsualConditions& usual) {
  Actuators<double> result;
  for (const Actuator& actuator : ship.propulsion()) result[actuator.channel] = usual.actuators[actuator.channel];
  return result;
}

std::vector<Quantity> of_hull(const UsualConditions& usual) {
  const double u = usual.u, v = usual.v, r = usual.r;
  const auto hull = [](double surge, double sway, double yaw) {
    return [=](const Ship& ship) { return Vec3<double>(forces(ship, {surge, sway, yaw}, {}).hull); };
  };
  const auto less_straight = [=](int axis, double sway, double yaw) {
    return [=](const Ship& ship) { return hull(u, sway, yaw)(ship)(axis)-hull(u, 0.0, 0.0)(ship)(axis); };
  };
  const std::string drifting = fmt::format("at {:.2g} deg of drift", std::atan2(v, u) / kDegree),
                    turning = fmt::format("at {:.2g} deg/s", r / kDegree);
  std::vector<Quantity> result{{"resistance", at_speed(u), "N",
                                [=](const Ship& ship) { return -hull(u, 0.0, 0.0)(ship)(0); },
                                multiplied_by(MultipliedForce::resistance)}};
  if (v > 0.0) {
    result.push_back({"side force of drift", drifting, "N", less_straight(1, v, 0.0)});
    result.push_back({"turning moment of drift", drifting, "N m", less_straight(2, v, 0.0)});
  }
  if (r > 0.0) result.push_back({"yaw damping", turning, "N m", less_straight(2, 0.0, r)});
  return result;
}

std::vector<Quantity> of_propeller(const Ship& ship, const UsualConditions& usual) {
  const Actuators<double> orders = driving(ship, usual);
  return {{"thrust", at_speed(usual.u), "N",
           [=, u = usual.u](const Ship& s) {
             return forces(s, {u, 0.0, 0.0}, orders).propeller.force(0);
           },
           multiplied_by(MultipliedForce::thrust)}};
}

std::vector<Quantity> of_rudder(const Ship& ship, const UsualConditions& usual) {
  const Actuators<double> idle = driving(ship, usual);
  Actuators<double> turned = idle;
  double angle = 0.0;
  for (const Actuator& actuator : ship.actuators)
    if (actuator.is_rudder()) {
      turned[actuator.channel] = usual.actuators[actuator.channel];
      angle = std::max(angle, usual.actuators[actuator.channel]);
    }
  if (!(angle > 0.0)) return {};
  const std::string where = fmt::format("at {:.2g} deg", angle / kDegree);
  const auto less_amidships = [=, u = usual.u](int axis) {
    return [=](const Ship& s) {
      return forces(s, {u, 0.0, 0.0}, turned).rudder(axis) - forces(s, {u, 0.0, 0.0}, idle).rudder(axis);
    };
  };
  return {{"side force of the rudder", where, "N", less_amidships(1), multiplied_by(MultipliedForce::rudder)},
          {"turning moment of the rudder", where, "N m", less_amidships(2), multiplied_by(MultipliedForce::rudder)}};
}

std::vector<Quantity> of_thrusters(const Ship& ship, const UsualConditions& usual) {
  Actuators<double> orders;
  bool acts = false;
  for (const Actuator& actuator : ship.actuators)
    if (actuator.is_thruster() && usual.actuators[actuator.channel] > 0.0) {
      orders[actuator.channel] = usual.actuators[actuator.channel];
      acts = true;
    }
  if (!acts) return {};
  return {{"side force of the thrusters", at_speed(usual.u), "N", [=, u = usual.u](const Ship& s) {
             return forces(s, {u, 0.0, 0.0}, orders).thrusters(1);
           }}};
}

std::vector<Quantity> of_wind(const UsualConditions& usual) {
  if (!(usual.wind > 0.0)) return {};
  const std::string where = fmt::format("at {:.2g} m/s", usual.wind);
  const auto wind = [](double ahead, double starboard, int axis) {
    return [=](const Ship& s) { return forces(s, Vec3<double>::Zero(), {}, {ahead, starboard}).wind(axis); };
  };
  return {{"force of a wind from ahead", where, "N", wind(usual.wind, 0.0, 0)},
          {"side force of a wind abeam", where, "N", wind(0.0, usual.wind, 1)},
          {"turning moment of a wind on the bow", where, "N m",
           wind(usual.wind * std::sqrt(0.5), usual.wind * std::sqrt(0.5), 2)}};
}

std::vector<Quantity> of_inertia() {
  const auto value = [](std::string_view name) {
    return [name](const Ship& ship) {
      for (const Coefficient& c : Model<double>(ship).coefficients())
        if (c.name == name && c.value) return *c.value;
      return kMissing;
    };
  };
  return {{"added mass ahead", "", "kg", value("inertia.m_x")},
          {"added mass sideways", "", "kg", value("inertia.m_y")},
          {"moment of inertia in yaw", "", "kg m^2", value("inertia.I_z")}};
}

std::vector<Quantity> quantities_of(const std::string& module, const Ship& ship, const UsualConditions& usual) {
  if (module == "inertia") return of_inertia();
  if (module == "hull") return of_hull(usual);
  if (module == "propeller") return of_propeller(ship, usual);
  if (module == "rudder") return of_rudder(ship, usual);
  if (module == "thruster") return of_thrusters(ship, usual);
  if (module == "wind") return of_wind(usual);
  return {};
}

// Revolutions that hold the usual speed, of the whole ship: what hull and propeller do together.
std::optional<Quantity> self_propulsion(const std::string& module, const Ship& ship, const UsualConditions& usual) {
  if ((module != "hull" && module != "propeller") || !ship.has_propeller() || !(usual.u > 0.0)) return std::nullopt;
  return Quantity{"self-propulsion", at_speed(usual.u), kRevolutions, [u = usual.u](const Ship& s) {
                    try {
                      return self_propulsion_n(s, u);
                    } catch (const NumericalError&) {
                      return kMissing;
                    }
                  }};
}

Ship with_theta(Ship ship, const std::vector<UncertainParameter>& parameters, const Eigen::VectorXd& theta) {
  std::vector<CoefficientFactor> factors;
  for (Eigen::Index i = 0; i < theta.size(); ++i)
    if (theta[i] != 0.0) factors.push_back(changed(parameters[static_cast<std::size_t>(i)], theta[i]));
  ship.multiply(factors);
  return ship;
}

}  // namespace

UsualConditions usual_conditions(const Campaign& campaign, const std::vector<Smoothed>& smoothed) {
  UsualConditions usual;
  double points = 0.0, steps = 0.0, wind = 0.0;
  Actuators<double> mean;
  for (std::size_t s = 0; s < campaign.stretches.size(); ++s) {
    const Stretch& stretch = campaign.stretches[s];
    for (std::size_t k = 0; k < stretch.size(); ++k) {
      const StateVector& x = smoothed[s].state[k];
      usual.u += x[3];
      usual.v += x[4] * x[4];
      usual.r += x[5] * x[5];
      points += 1.0;
      if (k + 1 == stretch.size()) continue;
      const Inputs<double>& in = stretch.inputs[k].front().start;
      for (std::size_t a = 0; a < mean.values.size(); ++a) {
        mean.values[a] += in.actuators.values[a];
        usual.actuators.values[a] += in.actuators.values[a] * in.actuators.values[a];
      }
      wind += (in.true_wind + Vec2<double>(x[3], 0.0)).squaredNorm() * (stretch.wind_speed_mps > 0.0 ? 1.0 : 0.0);
      steps += 1.0;
    }
  }
  usual.u /= std::max(1.0, points);
  usual.v = std::sqrt(usual.v / std::max(1.0, points));
  usual.r = std::sqrt(usual.r / std::max(1.0, points));
  usual.wind = std::sqrt(wind / std::max(1.0, steps));
  for (std::size_t a = 0; a < mean.values.size(); ++a)
    usual.actuators.values[a] = std::sqrt(usual.actuators.values[a] / std::max(1.0, steps));
  for (const Actuator& actuator : campaign.ship.propulsion())
    usual.actuators[actuator.channel] = mean[actuator.channel] / std::max(1.0, steps);
  return usual;
}

bool is_of_module(const std::string& coefficient, const std::string& module) {
  return coefficient.size() > module.size() && coefficient.starts_with(module) && coefficient[module.size()] == '.';
}

std::vector<std::string> modules_of(std::span<const UncertainParameter> coefficients) {
  std::vector<std::string> modules;
  for (const UncertainParameter& p : coefficients) {
    const std::string module = p.name.substr(0, p.name.find('.'));
    if (std::find(modules.begin(), modules.end(), module) == modules.end()) modules.push_back(module);
  }
  return modules;
}

std::vector<ModuleChange> module_changes(const Ship& ship, const std::string& module,
                                         const std::vector<UncertainParameter>& parameters,
                                         const Eigen::VectorXd& theta, const Eigen::MatrixXd& covariance,
                                         const UsualConditions& usual) {
  std::vector<Quantity> quantities = quantities_of(module, ship, usual);
  if (std::optional<Quantity> of_both = self_propulsion(module, ship, usual)) quantities.push_back(*of_both);
  const Ship fitted = with_theta(ship, parameters, theta);
  std::vector<ModuleChange> changes;
  for (const Quantity& quantity : quantities) {
    const double before = quantity.of(ship), after = quantity.of(fitted);
    if (!(before * after > 0.0)) continue;  // without a ratio, or not there at all
    Eigen::VectorXd slope = Eigen::VectorXd::Zero(covariance.rows());
    for (Eigen::Index i = 0; i < theta.size(); ++i) {
      const double step = kPolicy.show.difference_sd * std::sqrt(std::max(0.0, covariance(i, i)));
      if (!(step > 0.0)) continue;
      Eigen::VectorXd moved = theta;
      moved[i] += step;
      const double there = quantity.of(with_theta(ship, parameters, moved));
      slope[i] = there * after > 0.0 ? std::log(there / after) / step : 0.0;
    }
    const double by = std::log(after / before), sd = std::sqrt(std::max(0.0, slope.dot(covariance * slope)));
    const double reach = kPolicy.show.normal95 * sd;
    changes.push_back({quantity.name,
                       quantity.where,
                       quantity.unit,
                       before,
                       after,
                       {std::exp(by), std::exp(by - reach), std::exp(by + reach)},
                       quantity.by_effect});
  }
  const auto certainty = [](const ModuleChange& change) {
    return std::abs(std::log(change.by.factor)) /
           std::max(kPolicy.show.least_sd, std::log(change.by.high / change.by.low));
  };
  // What hull and propeller make together last.
  const auto own = changes.end() - (!changes.empty() && changes.back().unit == kRevolutions ? 1 : 0);
  std::stable_sort(changes.begin(), own,
                   [&](const ModuleChange& a, const ModuleChange& b) { return certainty(a) > certainty(b); });
  return changes;
}

}  // namespace leeway::gap
