#include "dynamics/scaled_replay.hpp"

#include <algorithm>
#include <cmath>

#include "core/units.hpp"

namespace leeway {
namespace {

double largest_speed(const Trajectory& run) {
  double most = 0.0;
  for (std::size_t i = 0; i < run.size(); ++i)
    most = std::max(most, std::hypot(run[Channel::u][i], run[Channel::vm][i]));
  return most;
}

double largest_yaw_rate(const Trajectory& run) {
  double most = 0.0;
  for (const double r : run[Channel::r]) most = std::max(most, std::abs(r));
  return most;
}

}  // namespace

Trajectory replay_to_scale(const Ship& ship, const Trajectory& recording, const FroudeLaw& law, WindProcess wind,
                           const TimeGrid& grid) {
  Trajectory inputs = scaled_down(recording, law);
  for (const Channel channel : {Channel::app_wind_speed, Channel::app_wind_dir}) inputs[channel].clear();
  std::vector<double>&speed = inputs[Channel::wind_speed], &direction = inputs[Channel::wind_dir];
  speed.resize(inputs.size());
  direction.resize(inputs.size());
  const std::vector<double>& t = inputs[Channel::t];
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    if (i > 0) wind.advance(t[i] - t[i - 1]);
    const Vec2<double>& from = wind.value();
    speed[i] = from.norm();
    direction[i] = std::atan2(from(1), from(0));
  }
  Trajectory run = replay(ship, inputs, RecordedInputs(inputs, ship, InputInterpolation::linear), grid);
  for (std::vector<double>& column : run.columns)
    if (!column.empty()) column.resize(std::min(column.size(), grid.samples() + 1));
  return run;
}

bool is_like(const Trajectory& replay, const Trajectory& scaled, const ReplayRule& rule) {
  const std::vector<double>& u = replay[Channel::u];
  const auto astern = static_cast<double>(std::count_if(u.begin(), u.end(), [](double x) { return x < 0.0; }));
  return astern <= rule.most_astern * static_cast<double>(u.size()) &&
         largest_speed(replay) <= rule.most_beyond * largest_speed(scaled) &&
         largest_yaw_rate(replay) <= rule.most_beyond * largest_yaw_rate(scaled);
}

}  // namespace leeway
