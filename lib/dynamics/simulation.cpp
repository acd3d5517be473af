#include "dynamics/simulation.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/errors.hpp"
#include "core/units.hpp"

namespace leeway {
namespace {

// A direction within [0, 2 pi).
double direction_of(const Vec2<double>& from) {
  const double angle = std::atan2(from(1), from(0));
  return angle < 0.0 ? angle + 2.0 * kPi : angle;
}

std::size_t whole_ratio(double long_s, double short_s, const char* long_name, const char* short_name) {
  const double ratio = long_s / short_s;
  if (ratio >= 1e9)
    throw UsageError(
        fmt::format("{} of {} s is more than 1e9 times {} of {} s", long_name, long_s, short_name, short_s));
  if (!(ratio > 0.5) || std::abs(ratio - std::round(ratio)) > 1e-6)
    throw UsageError(fmt::format("{} must be a multiple of {}, but {} s is not one of {} s", long_name, short_name,
                                 long_s, short_s));
  return static_cast<std::size_t>(std::llround(ratio));
}

}  // namespace

double respond(const Actuator& actuator, double actual, double command, double dt_s) {
  const double turn = 2.0 * kPi;  // the short way round, where it turns freely
  const double target =
      actuator.turns_freely() ? actual + std::remainder(command - actual, turn) : actuator.clip(command);
  const double gap = target - actual, K = actuator.rate, tau = actuator.time_constant_s;
  // At full rate until the gap is K tau, then exponentially.
  const double ramp_s = std::max(0.0, std::abs(gap) / K - tau);
  if (dt_s <= ramp_s) return actual + std::copysign(K * dt_s, gap);
  if (tau == 0.0) return target;
  const double gap_after_ramp = std::abs(gap) - K * ramp_s;
  return target - std::copysign(gap_after_ramp * std::exp(-(dt_s - ramp_s) / tau), gap);
}

StepInputs<double> respond(const Ship& ship, const Actuators<double>& actual, const Actuators<double>& command,
                           const Vec2<double>& true_wind, double dt_s) {
  StepInputs<double> inputs{{actual, true_wind, 0.0}, {actual, true_wind, 0.0}, {actual, true_wind, 0.0}};
  for (const Actuator& actuator : ship.actuators) {
    const Channel channel = actuator.channel;
    if (actuator.clip(command[channel]) == actual[channel]) continue;
    inputs.middle.actuators[channel] = respond(actuator, actual[channel], command[channel], dt_s / 2.0);
    inputs.end.actuators[channel] = respond(actuator, actual[channel], command[channel], dt_s);
  }
  return inputs;
}

void SimulatedShip::step(const Actuators<double>& command, const Vec2<double>& true_wind, double dt_s,
                         Integrator integrator) {
  advance(respond(ship, unrecorded_.value_or(actuators), command, true_wind, dt_s), dt_s, integrator);
}

void SimulatedShip::advance(StepInputs<double> inputs, double dt_s, Integrator integrator) {
  inputs.start.t_s = t_s;
  inputs.middle.t_s = t_s + dt_s / 2.0;
  inputs.end.t_s = t_s + dt_s;
  actuators = inputs.end.actuators;
  const RudderResponse& response = model.rudder_response();
  if (const double delay_s = std::abs(response.delay_s); delay_s > 0.0) {
    if (past_.empty()) past_.push_back(inputs.start);
    past_.push_back(inputs.middle);
    past_.push_back(inputs.end);
    if (response.delay_s > 0.0) {
      for (Inputs<double>* at : {&inputs.start, &inputs.middle, &inputs.end}) at->actuators = before(*at, delay_s);
    } else {
      unrecorded_ = inputs.end.actuators;
      actuators = before(inputs.end, delay_s);
    }
    while (past_.size() > 2 && past_[1].t_s < t_s - delay_s) past_.pop_front();
  }
  if (response.has_memory()) follow(response, inputs, dt_s);
  state = integrate(model, state, inputs, dt_s, integrator);
  t_s += dt_s;
}

Actuators<double> SimulatedShip::before(const Inputs<double>& inputs, double delay_s) const {
  Actuators<double> result = inputs.actuators;
  const double then = inputs.t_s - delay_s;
  const auto after = std::find_if(past_.begin(), past_.end(), [&](const auto& known) { return known.t_s > then; });
  const Inputs<double>& b = after == past_.end() ? past_.back() : *after;
  const Inputs<double>& a = after == past_.begin() ? past_.front() : *(after - 1);
  const double weight = b.t_s > a.t_s ? (then - a.t_s) / (b.t_s - a.t_s) : 0.0;
  for (const Actuator& actuator : ship.actuators)
    if (actuator.is_rudder()) {
      const double from = a.actuators[actuator.channel];
      result[actuator.channel] = from + weight * (b.actuators[actuator.channel] - from);
    }
  return result;
}

void SimulatedShip::follow(const RudderResponse& response, StepInputs<double>& inputs, double dt_s) {
  if (!acting_) acting_ = inputs.start.actuators;
  for (const Actuator& actuator : ship.actuators) {
    if (!actuator.is_rudder()) continue;
    double &start = inputs.start.actuators[actuator.channel], &middle = inputs.middle.actuators[actuator.channel],
           &end = inputs.end.actuators[actuator.channel];
    double& angle = (*acting_)[actuator.channel];
    const double halfway = response.follow(angle, 0.5 * (start + middle), middle, 0.5 * dt_s);
    const double after = response.follow(halfway, 0.5 * (middle + end), end, 0.5 * dt_s);
    start = angle;
    middle = halfway;
    end = angle = after;
  }
}

void append_sample(Trajectory& trajectory, const Ship& ship, double t_s, const ShipState<double>& state,
                   const Inputs<double>& inputs) {
  const Vec2<double> apparent = apparent_wind<double>(inputs.true_wind, state.eta(2), state.nu(0), state.nu(1));
  trajectory[Channel::t].push_back(t_s);
  trajectory[Channel::u].push_back(state.nu(0));
  trajectory[Channel::vm].push_back(state.nu(1));
  trajectory[Channel::r].push_back(state.nu(2));
  trajectory[Channel::x0].push_back(state.eta(0));
  trajectory[Channel::y0].push_back(state.eta(1));
  trajectory[Channel::psi].push_back(state.eta(2));
  for (const Actuator& actuator : ship.actuators)
    trajectory[actuator.channel].push_back(inputs.actuators[actuator.channel]);
  trajectory[Channel::wind_speed].push_back(inputs.true_wind.norm());
  trajectory[Channel::wind_dir].push_back(direction_of(inputs.true_wind));
  trajectory[Channel::app_wind_speed].push_back(apparent.norm());
  trajectory[Channel::app_wind_dir].push_back(direction_of(apparent));
}

void TimeGrid::check() const {
  whole_ratio(sample_s, dt_s, "the sampling time (--sample-s)", "the time step (--dt-s)");
  whole_ratio(duration_s, sample_s, "the duration", "the sampling time (--sample-s)");
}

std::size_t TimeGrid::steps_per_sample() const { return static_cast<std::size_t>(std::llround(sample_s / dt_s)); }

std::size_t TimeGrid::samples() const { return static_cast<std::size_t>(std::llround(duration_s / sample_s)); }

double grid_time(std::size_t k, double step_s) { return std::round(static_cast<double>(k) * step_s * 1e9) / 1e9; }

}  // namespace leeway
