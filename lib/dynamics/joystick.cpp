#include "dynamics/joystick.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "core/errors.hpp"

namespace leeway {
namespace {

constexpr double kMatters_mps2 = 0.005;  // an acceleration that matters
constexpr double kRoundedStep = 1e-9;    // of a step

const Actuator& actuator_of(const Ship& ship, Channel channel, std::string_view maneuver) {
  const Actuator* actuator = ship.find_actuator(channel);
  if (actuator == nullptr || !ship.has_twin_rudders())
    throw UsageError(
        fmt::format("{} needs VecTwin rudders (delta_p, delta_s) and a bow thruster (n_bt), which '{}' does not have",
                    maneuver, ship.name));
  return *actuator;
}

// The least costly orders that were offered.
class Choice {
 public:
  explicit Choice(const Actuators<double>& current) : orders_(current) {}
  void consider(const Actuators<double>& orders, double cost) {
    if (cost >= least_) return;
    least_ = cost;
    orders_ = orders;
  }
  const Actuators<double>& orders() const { return orders_; }

 private:
  Actuators<double> orders_;
  double least_ = std::numeric_limits<double>::infinity();
};

int first_step(double low, double step) { return static_cast<int>(std::ceil(low / step - kRoundedStep)); }
int last_step(double high, double step) { return static_cast<int>(std::floor(high / step + kRoundedStep)); }

double change(const Actuators<double>& from, const Actuators<double>& to) {  // [rad]
  return std::abs(to[Channel::delta_p] - from[Channel::delta_p]) +
         std::abs(to[Channel::delta_s] - from[Channel::delta_s]);
}

}  // namespace

Joystick::Joystick(const Ship& ship, std::string_view maneuver)
    : L_(ship.particulars.L_pp),
      model_(Model<double>::without_effects(ship)),
      port_(actuator_of(ship, Channel::delta_p, maneuver)),
      starboard_(actuator_of(ship, Channel::delta_s, maneuver)),
      thruster_(actuator_of(ship, Channel::n_bt, maneuver)) {}

Actuators<double> Joystick::each_alone(const Vec3<double>& nu, const Vec3<double>& wanted, bool sway, bool thruster,
                                       const Steps& steps, const Actuators<double>& current) const {
  const Vec3<double> weights(1.0, sway ? 1.5 : 0.0, 0.5 * L_);
  const auto cost = [&](const Actuators<double>& orders) {
    const Vec3<double> miss = acceleration(nu, orders) - wanted;
    const double p = orders[Channel::delta_p], s = orders[Channel::delta_s];
    const double thrust = orders[Channel::n_bt] / thruster_.max;
    return (weights.cwiseProduct(miss) / kMatters_mps2).squaredNorm() + 0.02 * change(current, orders) +
           0.01 * (p + s) * (p + s) + 0.02 * thrust * thrust;
  };
  Actuators<double> at_first = current;
  if (!thruster) at_first[Channel::n_bt] = 0.0;
  Choice choice(at_first);
  const double rudder = steps.rudder_rad, rps = steps.thruster_rps;
  // The thruster acts beside the rudders: after two rounds both have converged.
  for (int round = 0; round < 2; ++round) {
    Actuators<double> orders = choice.orders();
    for (int i = first_step(port_.min, rudder); i <= last_step(port_.max, rudder); ++i)
      for (int k = first_step(starboard_.min, rudder); k <= last_step(starboard_.max, rudder); ++k) {
        orders[Channel::delta_p] = i * rudder;
        orders[Channel::delta_s] = k * rudder;
        choice.consider(orders, cost(orders));
      }
    if (!thruster) break;
    orders = choice.orders();
    for (int i = first_step(thruster_.min, rps); i <= last_step(thruster_.max, rps); ++i) {
      orders[Channel::n_bt] = i * rps;
      choice.consider(orders, cost(orders));
    }
  }
  return choice.orders();
}

Actuators<double> Joystick::together(const Vec3<double>& nu, const Vec3<double>& wanted, double most_rad,
                                     bool keep_opening, const Steps& steps, const Actuators<double>& current) const {
  const double step = steps.rudder_rad;
  const double opened = 0.5 * (current[Channel::delta_s] - current[Channel::delta_p]);
  const int widest = last_step(starboard_.max, step);
  const int kept = std::clamp(static_cast<int>(std::lround(opened / step)), 0, widest);
  Choice choice(current);
  Actuators<double> orders = current;
  orders[Channel::n_bt] = 0.0;
  for (int i = keep_opening ? kept : 0; i <= (keep_opening ? kept : widest); ++i)
    for (int k = -last_step(most_rad, step); k <= last_step(most_rad, step); ++k) {
      orders[Channel::delta_p] = port_.clip((k - i) * step);
      orders[Channel::delta_s] = starboard_.clip((k + i) * step);
      const Vec3<double> miss = acceleration(nu, orders) - wanted;
      const double surge = keep_opening ? 0.0 : miss(0) / kMatters_mps2, turn = 0.5 * L_ * miss(2) / kMatters_mps2;
      choice.consider(orders, surge * surge + turn * turn + 0.02 * change(current, orders) + 0.02 * i * step);
    }
  return choice.orders();
}

}  // namespace leeway
