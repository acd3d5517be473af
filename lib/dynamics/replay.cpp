#include "dynamics/replay.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/errors.hpp"
#include "core/units.hpp"
#include "recording/samples.hpp"

namespace leeway {
namespace {

constexpr double kSameStep = 1e-6;         // of a step
constexpr double kLimitSlack = 0.02;       // of an actuator's range: measured values overshoot a little
constexpr double kHoleSteps = 1.5;         // sampling times without a sample, as in resample()
constexpr double kMostSamplesApart = 1e5;  // between two samples, our choice: a file of two rows may drive for a day
constexpr double kMostSamples = 1e7;       // of a replay in all, our choice: four months at one a second
constexpr int kSlowParts = 10;             // of a sampling time: rudders with a memory are followed, moves placed

void hold_last(std::vector<double>& values) {
  for (std::size_t i = 1; i < values.size(); ++i)
    if (std::isnan(values[i])) values[i] = values[i - 1];
}

const std::vector<double>& require(const Trajectory& recording, Channel channel, const Ship& ship) {
  if (!recording.has(channel))
    throw InputError(recording.file, 1, "",
                     fmt::format("no column '{}', which the ship '{}' needs; found actuators: {}", column_name(channel),
                                 ship.name, found_actuators(recording)));
  return recording[channel];
}

// Place of the first of ascending times above t_s. Recordings are mostly sampled regularly: it is sought first where it
// would be then.
std::size_t first_above(const std::vector<double>& t, double t_s) {
  const std::size_t n = t.size();
  const double share = n > 1 ? (t_s - t.front()) / (t.back() - t.front()) : 0.0;
  if (share > 0.0 && share < 1.0) {
    const auto guess = static_cast<std::size_t>(share * static_cast<double>(n - 1));
    for (std::size_t i = std::max<std::size_t>(guess, 1); i <= std::min(guess + 2, n - 1); ++i)
      if (t[i - 1] <= t_s && t_s < t[i]) return i;
  }
  return static_cast<std::size_t>(std::upper_bound(t.begin(), t.end(), t_s) - t.begin());
}

// Integrates over one sampling time.
void advance(const Model<double>& model, ShipState<double>& state, const RecordedInputs& inputs, double t_s,
             const TimeGrid& grid, const Trajectory& recording) {
  for (std::size_t i = 0; i < grid.steps_per_sample(); ++i) {
    const double now = t_s + static_cast<double>(i) * grid.dt_s;
    state = integrate(model, state, inputs.step(now, grid.dt_s), grid.dt_s);
    if (!state.nu.allFinite() || !state.eta.allFinite())
      throw NumericalError(fmt::format("{}: the simulation diverged at {} s; reduce the time step (now {} s)",
                                       recording.file, now + grid.dt_s, grid.dt_s));
  }
}

}  // namespace

RecordedInputs::RecordedInputs(const Trajectory& recording, const Ship& ship, InputInterpolation interpolation)
    : t_(recording[Channel::t]), interpolation_(interpolation) {
  const std::size_t n = t_.size();
  for (const Actuator& actuator : ship.actuators) {
    if (actuator.is_optional && !recording.has(actuator.channel)) continue;
    const std::vector<double>& values = require(recording, actuator.channel, ship);
    const double slack = kLimitSlack * actuator.range();
    std::size_t outside = 0, farthest = 0;
    double most = slack;
    for (std::size_t i = 0; i < n; ++i) {
      const double beyond = std::max(actuator.min - values[i], values[i] - actuator.max);
      if (beyond > slack) ++outside;
      if (beyond > most) most = beyond, farthest = i;
    }
    if (outside > 0) {
      const double unit = column_unit(actuator.channel);
      notices_.push_back(fmt::format(
          "{}: column '{}': {} sample{} outside the limits {:g} to {:g} of the ship '{}', {:g} at {:g} s the "
          "farthest, used as recorded",
          recording.file, column_name(actuator.channel), outside, outside == 1 ? "" : "s", actuator.min / unit,
          actuator.max / unit, ship.name, values[farthest] / unit, t_[farthest]));
    }
    channels_.push_back(actuator.channel);
    actuators_.push_back(values);
    rates_.push_back(actuator.rate);
    tails_.push_back(actuator.rate * actuator.time_constant_s);
  }

  wind_x_.assign(n, 0.0);
  wind_y_.assign(n, 0.0);
  has_wind_ = recording.has_wind() && ship.has_wind();
  if (has_wind_) {
    const bool is_true = recording.has(Channel::wind_speed) && recording.has(Channel::wind_dir);
    if (!recording.has(Channel::psi))
      throw InputError(recording.file, 1, "",
                       "no column 'psi_deg': without the heading the recorded wind cannot be used");
    const Channel speed = is_true ? Channel::wind_speed : Channel::app_wind_speed;
    if (const auto least =
            std::ranges::min_element(recording[speed], {}, [](double x) { return std::isnan(x) ? 0.0 : x; });
        least != recording[speed].end() && *least < 0.0)
      notices_.push_back(
          fmt::format("{}: column '{}': {:g} at {:g} s, a speed below 0, is read as a wind from the other side",
                      recording.file, column_name(speed), *least / column_unit(speed),
                      t_[static_cast<std::size_t>(least - recording[speed].begin())]));
    for (std::size_t i = 0; i < n; ++i) {
      const Vec2<double> wind =
          is_true ? wind_from_vector(recording[Channel::wind_speed][i], recording[Channel::wind_dir][i])
                  : true_wind_from_apparent<double>(
                        wind_from_vector(recording[Channel::app_wind_speed][i], recording[Channel::app_wind_dir][i]),
                        recording[Channel::psi][i], recording[Channel::u][i], recording[Channel::vm][i]);
      wind_x_[i] = wind(0);
      wind_y_[i] = wind(1);
    }
  } else if (ship.has_wind()) {
    notices_.push_back(fmt::format("{}: has no wind; calm air is assumed", recording.file));
  }

  hold_last(wind_x_);
  hold_last(wind_y_);
  for (std::vector<double>& values : actuators_) hold_last(values);
  for (std::size_t i = 0; i < n && !first_known_; ++i) {
    const bool known =
        !std::isnan(wind_x_[i]) && !std::isnan(wind_y_[i]) &&
        std::none_of(actuators_.begin(), actuators_.end(), [i](const auto& v) { return std::isnan(v[i]); });
    if (known) first_known_ = i;
  }
}

RecordedInputs::Place RecordedInputs::place(double t_s) const {
  const std::size_t above = first_above(t_, t_s), after = std::min(above, t_.size() - 1),
                    before = above == 0 ? 0 : above - 1;
  const bool is_between = interpolation_ != InputInterpolation::hold && after > before;
  return {before, after, is_between ? (t_s - t_[before]) / (t_[after] - t_[before]) : 0.0};
}

double RecordedInputs::angle_or_speed(std::size_t actuator, const Place& at) const {
  const std::vector<double>& values = actuators_[actuator];
  if (interpolation_ != InputInterpolation::at_actuator_rate || at.weight == 0.0) return at.value(values);
  const double change = values[at.after] - values[at.before];
  const double moving = std::abs(change) / (rates_[actuator] * (t_[at.after] - t_[at.before]));  // share of the time
  const double tail = std::max(tails_[actuator], rates_[actuator] * (t_[at.after] - t_[at.before]) / kSlowParts);
  const auto moves_on = [&](std::size_t from) {
    const double here = values[from + 1] - values[from];
    return here * change > 0.0 && std::abs(here) > tail;
  };
  const bool before = at.before > 0 && moves_on(at.before - 1), after = at.after + 1 < t_.size() && moves_on(at.after);
  if (!(moving > 0.0 && moving < 1.0) || (before && after) || (!before && !after && !rate_limit_follows_))
    return at.value(values);
  const double rest = 1.0 - moving, begin = before ? 0.0 : after ? rest : 0.5 * rest;
  return values[at.before] + change * std::clamp((at.weight - begin) / moving, 0.0, 1.0);
}

Inputs<double> RecordedInputs::at(double t_s) const {
  const Place now = place(t_s);
  Inputs<double> inputs;
  inputs.t_s = t_s;
  for (std::size_t a = 0; a < channels_.size(); ++a) inputs.actuators[channels_[a]] = angle_or_speed(a, now);
  inputs.true_wind = {now.value(wind_x_), now.value(wind_y_)};
  if (response_ != RudderResponse()) let_rudders_act(inputs);
  return inputs;
}

void RecordedInputs::let_rudders_act(Inputs<double>& inputs) const {
  const Place then = place(std::max(inputs.t_s - response_.delay_s, t_[first_known_.value_or(0)]));
  const std::size_t above = first_above(slow_t_, inputs.t_s);
  for (std::size_t a = 0; a < channels_.size(); ++a) {
    if (info(channels_[a]).role != Role::rudder) continue;
    double& angle = inputs.actuators[channels_[a]];
    if (slow_t_.empty()) {
      angle = angle_or_speed(a, then);
      continue;
    }
    const std::vector<double>& slow = slow_angles_[a];
    const auto after = std::min(above, slow.size() - 1), before = after > 0 ? after - 1 : 0;
    const double gap_s = slow_t_[after] - slow_t_[before];
    const double share = gap_s > 0.0 ? std::clamp((inputs.t_s - slow_t_[before]) / gap_s, 0.0, 1.0) : 0.0;
    angle = slow[before] + share * (slow[after] - slow[before]);
  }
}

RecordedInputs RecordedInputs::through(const RudderResponse& response) const {
  RecordedInputs result = *this;
  result.rate_limit_follows_ = std::isfinite(response.rate_radps);
  result.response_ = {response.delay_s};  // at() gives the delayed angles, which are then followed
  result.slow_t_.clear();
  result.slow_angles_.assign(channels_.size(), {});
  if (response.has_memory() && first_known_) {
    std::vector<double> t{t_[*first_known_]};
    std::vector<std::vector<double>> angles(channels_.size());
    const Inputs<double> first = result.at(t.front());
    for (std::size_t a = 0; a < channels_.size(); ++a) angles[a].push_back(first.actuators[channels_[a]]);
    for (std::size_t i = *first_known_; i + 1 < t_.size(); ++i) {
      const double dt_s = (t_[i + 1] - t_[i]) / kSlowParts;
      for (int part = 0; part < kSlowParts; ++part) {
        const StepInputs<double> step = result.step(t_[i] + part * dt_s, dt_s);
        t.push_back(t_[i] + (part + 1) * dt_s);
        for (std::size_t a = 0; a < channels_.size(); ++a)
          angles[a].push_back(response.follow(angles[a].back(), step.middle.actuators[channels_[a]],
                                              step.end.actuators[channels_[a]], dt_s));
      }
    }
    result.slow_t_ = std::move(t);
    result.slow_angles_ = std::move(angles);
  }
  result.response_ = response;
  return result;
}

StepInputs<double> RecordedInputs::step(double t_s, double dt_s) const {
  // A held value that changes at the end of the step belongs to the next one.
  const double inside = interpolation_ == InputInterpolation::hold ? kSameStep * dt_s : 0.0;
  return {at(t_s + inside), at(t_s + 0.5 * dt_s), at(t_s + dt_s - inside)};
}

std::vector<std::string> holes_to_drive_through(const Trajectory& recording, const TimeGrid& grid) {
  const LongestStep& longest = recording.longest_step;
  if (clock_jumps(recording))
    throw InputError(recording.file, longest.line, "column 't_s'",
                     jump_text(recording) +
                         ": a replay does not drive through such a hole; cut the recording in two, or "
                         "use --prediction, which restarts behind it");
  if (longest.length_s() > kMostSamplesApart * grid.sample_s)
    throw InputError(
        recording.file, longest.line, "column 't_s'",
        fmt::format("{} s after the sample before; expected at most {} times the {} s of --sample-s: is it "
                    "in seconds?",
                    longest.length_s(), kMostSamplesApart, grid.sample_s));
  const std::vector<double>& t = recording[Channel::t];
  if (t.back() - t.front() > kMostSamples * grid.sample_s)
    throw InputError(recording.file, 0, "column 't_s'",
                     fmt::format("lasts {} s; expected at most {} times the {} s of --sample-s: is it in seconds?",
                                 t.back() - t.front(), kMostSamples, grid.sample_s));
  const double hole_s = kHoleSteps * std::max(grid.sample_s, sampling_time_s(recording));
  std::size_t holes = 0;
  for (std::size_t i = 1; i < t.size(); ++i)
    if (t[i] - t[i - 1] > hole_s) ++holes;
  if (holes == 0) return {};
  return {fmt::format("{}:{}: no sample from {} s to {} s{}; the simulation drives on through {}", recording.file,
                      longest.line, longest.from_s, longest.to_s,
                      holes > 1 ? fmt::format(", the longest of {} holes", holes) : "",
                      holes > 1 ? "them" : "the hole")};
}

Trajectory replay(const Ship& ship, const Trajectory& recording, const RecordedInputs& inputs, const TimeGrid& grid) {
  const bool has_heading = recording.has(Channel::psi);
  const bool has_position = has_heading && recording.has(Channel::x0) && recording.has(Channel::y0);
  const auto known = [&](std::size_t i) {
    const auto finite = [&](Channel channel) { return std::isfinite(recording[channel][i]); };
    return finite(Channel::u) && finite(Channel::vm) && finite(Channel::r) && (!has_heading || finite(Channel::psi)) &&
           (!has_position || (finite(Channel::x0) && finite(Channel::y0)));
  };
  std::size_t first = inputs.first_known().value_or(recording.size());
  while (first < recording.size() && !known(first)) ++first;
  if (first == recording.size())
    throw InputError(recording.file, "no sample has state, actuators and wind; a replay cannot start");

  ShipState<double> state;
  state.nu = {recording[Channel::u][first], recording[Channel::vm][first], recording[Channel::r][first]};
  if (has_heading) state.eta(2) = recording[Channel::psi][first];
  if (has_position) state.eta.head<2>() << recording[Channel::x0][first], recording[Channel::y0][first];

  const Model<double> model(ship);
  const RecordedInputs acting = inputs.through(model.rudder_response());
  const double t0 = recording[Channel::t][first], duration = recording[Channel::t].back() - t0;
  const auto samples = static_cast<std::size_t>(duration / grid.sample_s + kSameStep);
  Trajectory result;
  for (std::size_t k = 0;; ++k) {
    const double t_s = t0 + grid_time(k, grid.sample_s);
    append_sample(result, ship, t_s, state, inputs.at(t_s));
    if (k == samples) break;
    advance(model, state, acting, t_s, grid, recording);
  }
  for (const Actuator& actuator : ship.actuators)  // an idle thruster that was not recorded is not invented
    if (!recording.has(actuator.channel)) result[actuator.channel].clear();
  return result;
}

std::size_t replay_sequences(const Ship& ship, const Trajectory& recording, const RecordedInputs& inputs,
                             const TimeGrid& grid, std::size_t K, io::PredictionWriter& writer) {
  const Model<double> model(ship);
  const RecordedInputs acting = inputs.through(model.rudder_response());
  io::PredictionRow row;
  row.recording = recording.name;
  for (const Samples& samples : resample(recording, inputs.channels(), inputs.has_wind(), grid.sample_s))
    for (const Range& range : test_sequences(samples.size(), static_cast<Eigen::Index>(K))) {
      ShipState<double> state{samples.eta.col(range.begin), samples.nu.col(range.begin)};
      for (row.step = 0; row.step < K; ++row.step) {
        row.t_s = samples.t_s(range.begin + static_cast<Eigen::Index>(row.step));
        row.eta = state.eta;
        row.nu = state.nu;
        writer.write(row);
        if (row.step + 1 < K) advance(model, state, acting, row.t_s, grid, recording);
      }
      ++row.sequence;
    }
  return row.sequence;
}

}  // namespace leeway
