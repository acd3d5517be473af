#include "dynamics/run_notices.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/errors.hpp"
#include "core/units.hpp"
#include "dynamics/straight_run.hpp"

namespace leeway {
namespace {

// Where revolutions lead, and which would hold the speed; nothing where there is no such thing.
std::optional<double> settled_speed(const Ship& ship, double n_rps) {
  try {
    return steady_speed(ship, n_rps);
  } catch (const NumericalError&) {
    return std::nullopt;
  }
}
std::optional<double> holding_revolutions(const Ship& ship, double u_mps) {
  try {
    return self_propulsion_n(ship, u_mps);
  } catch (const NumericalError&) {
    return std::nullopt;
  }
}

bool is_beyond(const Actuator& actuator, double order) { return std::abs(actuator.clip(order) - order) > 1e-9; }

}  // namespace

std::optional<std::string> speed_notice(const Ship& ship, double u_mps, double n_rps, bool only_slows) {
  if (ship.propulsion().empty() || u_mps == 0.0) return std::nullopt;  // a ship at rest gets under way
  const std::optional<double> settled = settled_speed(ship, n_rps);
  if (settled) {
    const double larger = std::max(std::abs(u_mps), std::abs(*settled));
    if (std::abs(u_mps - *settled) <= kSpeedMismatch * larger || (only_slows && u_mps < *settled)) return std::nullopt;
  }
  const std::optional<double> holding = holding_revolutions(ship, u_mps);
  return fmt::format(
      "the speed at the start, {:.4g} m/s (--u0-mps), and the revolutions, {:.4g} 1/s (--n-p-rps), do not belong "
      "together: on a straight course in calm air the ship '{}' {} with these revolutions, and {} that speed",
      u_mps, n_rps, ship.name,
      settled ? fmt::format("comes to {:.4g} m/s", *settled) : std::string("comes to no steady speed"),
      holding ? fmt::format("{:.4g} 1/s would hold", *holding)
              : fmt::format("no revolutions within {:g} to {:g} 1/s hold", ship.propulsion().front().min,
                            ship.propulsion().front().max));
}

std::optional<std::string> wind_notice(const Ship& ship, double wind_speed_mps) {
  if (ship.has_wind() || !(wind_speed_mps > 0.0)) return std::nullopt;
  return fmt::format("the ship '{}' has no wind module: the wind of {:.4g} m/s has no effect on it", ship.name,
                     wind_speed_mps);
}

std::optional<std::string> wind_notice(const Ship& ship, const Trajectory& recording) {
  if (ship.has_wind() || !recording.has(Channel::wind_speed)) return std::nullopt;
  double largest = 0.0;
  for (const double speed : recording[Channel::wind_speed])
    if (speed > largest) largest = speed;
  if (!(largest > 0.0)) return std::nullopt;
  return fmt::format("{}: the ship '{}' has no wind module: the recorded wind of up to {:.4g} m/s has no effect on it",
                     recording.file, ship.name, largest);
}

std::vector<std::string> rudder_notices(const Ship& ship, const std::vector<double>& orders) {
  std::vector<std::string> notices;
  for (const Actuator& actuator : ship.actuators) {
    if (!actuator.is_rudder()) continue;
    std::vector<double> beyond;
    std::ranges::copy_if(orders, std::back_inserter(beyond), [&](double order) { return is_beyond(actuator, order); });
    if (beyond.empty()) continue;
    std::string listed;
    for (const double order : beyond) listed += fmt::format("{}{:g}", listed.empty() ? "" : " and ", rad_to_deg(order));
    notices.push_back(fmt::format(
        "rudder angles of {} deg are ordered, beyond the limits {:g} to {:g} deg of {} of the ship '{}': it "
        "stays at its limit",
        listed, rad_to_deg(actuator.min), rad_to_deg(actuator.max), info(actuator.channel).name, ship.name));
  }
  return notices;
}

std::vector<std::string> dataset_notices(const DatasetSpec& spec) {
  double wind_mps = 0.0;
  std::vector<double> orders;
  for (const DatasetSpec::Set& set : spec.sets)
    for (const RunSpec& run : set.runs) {
      wind_mps = std::max(wind_mps, run.wind_speed_mps.high);
      if (run.kind == ManeuverKind::turning) orders.push_back(run.rudder);
      if (run.kind == ManeuverKind::zigzag) orders.insert(orders.end(), {run.rudder, -run.rudder});
    }
  std::ranges::sort(orders);
  orders.erase(std::unique(orders.begin(), orders.end()), orders.end());
  std::vector<std::string> notices = rudder_notices(spec.ship, orders);
  if (const auto notice = wind_notice(spec.ship, wind_mps)) notices.push_back(*notice);
  return notices;
}

}  // namespace leeway
