#include "dynamics/indices.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/units.hpp"
#include "dynamics/imo_criteria.hpp"

namespace leeway {
namespace {

using io::Json;
using Moment = Track::Moment;
using Maybe = std::optional<double>;

constexpr double kSteadyTurn = 0.01;  // relative scatter of the yaw rate over a turn
constexpr double kSameYaw = 0.01;     // of U/L_pp: two yaw rates that count as one
constexpr double kSameAngle = 1e-6;   // [rad], between orders

Json or_null(Maybe x) { return x ? Json(*x) : Json(); }
Json deg_or_null(Maybe x) { return x ? Json(rad_to_deg(*x)) : Json(); }

void put_length(Json& json, const std::string& name, Maybe length_m, double L_pp) {
  json[name + "_m"] = or_null(length_m);
  if (!std::isnan(L_pp)) json[name + "_over_L"] = or_null(length_m ? Maybe(*length_m / L_pp) : length_m);
}

// Distances along and across the course at one moment; `side` is +1 for starboard, -1 for port.
struct Course {
  Moment origin;
  double side, heading, track;  // that before the order [rad]
  Course(const Moment& moment, double sign) : origin(moment), side(sign), heading(moment.psi), track(moment.psi) {}
  Course(const Track& run, const Approach& approach, double sign)
      : origin(run.at(approach.t_s)), side(sign), heading(approach.heading), track(approach.course) {}
  Vec2<double> ahead() const { return {std::cos(track), std::sin(track)}; }
  Vec2<double> abeam() const { return side * Vec2<double>(-std::sin(track), std::cos(track)); }
  double advance(const Moment& m) const { return ahead().dot(m.position - origin.position); }
  double transfer(const Moment& m) const { return abeam().dot(m.position - origin.position); }
  double change(const Moment& m) const { return side * (m.psi - heading); }
};

// From a time on.
Maybe length_at(const Track& track, Maybe t_s, double from_s) {
  return t_s ? Maybe(track.length(*t_s) - track.length(from_s)) : t_s;
}

Approach start_of(const Track& track) {
  const double psi = track.at(track.start_s()).psi;
  return {track.start_s(), psi, psi};
}

double drift(const Moment& m) { return std::atan2(-m.nu(1), m.nu(0)); }

double side_of(double angle) { return angle < 0.0 ? -1.0 : 1.0; }

const char* side_name(double order) { return order < 0.0 ? "port" : "starboard"; }

bool all_fulfilled(const std::vector<Phase>& phases) {
  return std::all_of(phases.begin(), phases.end(), [](const Phase& p) { return p.is_complete && p.is_fulfilled; });
}

// The rudder angle at which the yaw rate of a leg changes sign, linear between two angles.
Maybe zero_of(const std::vector<double>& rudder, const std::vector<double>& r) {
  for (std::size_t i = 1; i < r.size(); ++i)
    if ((r[i - 1] > 0.0) != (r[i] > 0.0))
      return rudder[i - 1] + (rudder[i] - rudder[i - 1]) * r[i - 1] / (r[i - 1] - r[i]);
  return std::nullopt;
}

Json extremes(const std::vector<double>& values, double per_unit) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  return {*low / per_unit, *high / per_unit};
}

}  // namespace

Json turning_indices(const Track& track, double rudder, double L_pp) {
  return turning_indices(track, start_of(track), rudder, L_pp);
}

Json turning_indices(const Track& track, const Approach& approach, double rudder, double L_pp) {
  const double t0 = approach.t_s, end = track.end_s();
  const Course course(track, approach, side_of(rudder));
  const auto time_of_change = [&](double change) {
    return track.first_rise(t0, [&](const Moment& m) { return course.change(m) - change; });
  };
  const Maybe t_10 = time_of_change(10.0 * kDegree), t_90 = time_of_change(90.0 * kDegree),
              t_180 = time_of_change(180.0 * kDegree), t_360 = time_of_change(360.0 * kDegree);
  const auto advance = [&](Maybe t) { return t ? Maybe(course.advance(track.at(*t))) : t; };
  const auto transfer = [&](Maybe t) { return t ? Maybe(course.transfer(track.at(*t))) : t; };

  Json json;
  put_length(json, "advance", advance(t_90), L_pp);
  put_length(json, "transfer", transfer(t_90), L_pp);
  put_length(json, "tactical_diameter", transfer(t_180), L_pp);
  // The first time that the ship moves neither further ahead nor further to the side.
  put_length(json, "max_advance",
             advance(track.first_rise(t0, [&](const Moment& m) { return -course.ahead().dot(m.velocity); })), L_pp);
  put_length(json, "max_transfer",
             transfer(track.first_rise(t0, [&](const Moment& m) { return -course.abeam().dot(m.velocity); })), L_pp);
  put_length(json, "track_to_10_deg", length_at(track, t_10, t0), L_pp);
  json["time_to_90_deg_s"] = or_null(t_90 ? Maybe(*t_90 - t0) : t_90);
  json["time_to_180_deg_s"] = or_null(t_180 ? Maybe(*t_180 - t0) : t_180);
  json["time_to_360_deg_s"] = or_null(t_360 ? Maybe(*t_360 - t0) : t_360);

  // Means over the last full turn, where at least half a turn came before it.
  const double total = course.change(track.at(end));
  Json& steady = json["steady"];
  if (total < 540.0 * kDegree) return json;
  const double from = time_of_change(total - 360.0 * kDegree).value_or(t0);
  const double duration = end - from, r = course.side * 2.0 * kPi / duration;
  const double U = (track.length(end) - track.length(from)) / duration;
  const double u = track.mean(from, end, [](const Moment& m) { return m.nu(0); });
  const double v_m = track.mean(from, end, [](const Moment& m) { return m.nu(1); });
  double scatter = 0.0;
  for (const double t : track.times())
    if (t >= from) scatter = std::max(scatter, std::abs(track.at(t).nu(2) / r - 1.0));
  steady["is_steady"] = scatter < kSteadyTurn;
  steady["u_mps"] = u;
  steady["vm_mps"] = v_m;
  steady["speed_mps"] = U;
  steady["r_degps"] = rad_to_deg(r);
  if (!std::isnan(L_pp)) steady["r_nondimensional"] = r * L_pp / U;
  steady["drift_deg"] = rad_to_deg(std::atan2(-v_m, u));
  put_length(steady, "radius", U / std::abs(r), L_pp);
  put_length(steady, "diameter", 2.0 * U / std::abs(r), L_pp);
  steady["speed_loss"] = 1.0 - U / course.origin.speed();
  return json;
}

Json zigzag_indices(const Track& track, double rudder, double heading, double L_pp) {
  return zigzag_indices(track, start_of(track), rudder, heading, L_pp);
}

Json zigzag_indices(const Track& track, const Approach& approach, double rudder, double heading, double L_pp) {
  const double t0 = approach.t_s;
  const Course course(track, approach, side_of(rudder));
  Json executes = Json::array({{{"number", 1}, {"t_s", t0}, {"rudder_deg", rad_to_deg(rudder)}}});
  Json overshoots = Json::array();
  std::vector<double> times;  // of the second execute and those after it
  double first_check_s = 0.0;
  for (double side = 1.0, from = t0;; side = -side) {
    const auto beyond = [&](const Moment& m) { return side * course.change(m) - heading; };
    const Maybe execute = track.first_rise(from, beyond);
    if (!execute) break;
    from = *execute;
    times.push_back(from);
    executes.push_back({{"number", times.size() + 1}, {"t_s", from}, {"rudder_deg", -side * rad_to_deg(rudder)}});
    // The overshoot is known once the ship has begun to turn back.
    const Maybe turned = track.first_rise(from, [&](const Moment& m) { return -side * course.side * m.nu(2); });
    if (!turned) break;
    if (times.size() == 1) first_check_s = *turned - from;
    const Maybe next = track.first_rise(from, [&](const Moment& m) { return -side * course.change(m) - heading; });
    double overshoot = beyond(track.at(*turned)), at_s = *turned;
    const std::vector<double>& sampled = track.times();
    const double until = next.value_or(track.end_s());
    for (auto t = std::upper_bound(sampled.begin(), sampled.end(), from); t != sampled.end() && *t < until; ++t) {
      const double value = beyond(track.at(*t));
      if (value <= overshoot) continue;
      overshoot = value;
      at_s = *t;
    }
    overshoots.push_back({{"number", times.size()},
                          {"side", side_name(side * course.side)},
                          {"t_s", at_s},
                          {"overshoot_deg", rad_to_deg(overshoot)}});
  }

  Json json;
  const auto overshoot = [&](std::size_t i) { return i < overshoots.size() ? overshoots[i]["overshoot_deg"] : Json(); };
  json["first_overshoot_deg"] = overshoot(0);
  json["second_overshoot_deg"] = overshoot(1);
  json["initial_turning_time_s"] = times.empty() ? Json() : Json(times[0] - t0);
  json["time_to_check_yaw_s"] = overshoots.empty() ? Json() : Json(first_check_s);
  json["period_s"] = times.size() < 3 ? Json() : Json(times[2] - times[0]);
  put_length(
      json, "track_to_10_deg",
      length_at(track, track.first_rise(t0, [&](const Moment& m) { return course.change(m) - 10.0 * kDegree; }), t0),
      L_pp);
  json["executes"] = executes;
  json["overshoots"] = overshoots;
  return json;
}

Json pull_out_indices(const Track& track, const std::vector<Phase>& phases, double L_pp) {
  const auto yaw_rate = [&](std::size_t i) {
    return i < phases.size() && phases[i].is_complete ? Maybe(track.at(phases[i].end_s).nu(2)) : std::nullopt;
  };
  Json json;
  json["r_starboard_turn_degps"] = deg_or_null(yaw_rate(0));
  json["r_residual_from_starboard_degps"] = deg_or_null(yaw_rate(1));
  json["r_port_turn_degps"] = deg_or_null(yaw_rate(2));
  json["r_residual_from_port_degps"] = deg_or_null(yaw_rate(3));
  json["is_straight_line_stable"] = nullptr;
  if (phases.size() == 4 && all_fulfilled(phases)) {
    const double L_by_U = L_pp / track.at(phases[3].end_s).speed();
    const double from_starboard = *yaw_rate(1) * L_by_U, from_port = *yaw_rate(3) * L_by_U;
    if (std::abs(from_starboard - from_port) >= kSameYaw)
      json["is_straight_line_stable"] = false;
    else if (std::abs(from_starboard + from_port) < 2.0 * kSameYaw)
      json["is_straight_line_stable"] = true;
    // Otherwise one common yaw rate remains: amidships is not the neutral angle, and a loop there stays unseen.
  }
  json["phases"] = Json::array();
  for (std::size_t i = 0; i < phases.size(); ++i)
    json["phases"].push_back({{"rudder_deg", rad_to_deg(phases[i].order)},
                              {"t_start_s", phases[i].start_s},
                              {"t_end_s", phases[i].end_s},
                              {"is_steady", phases[i].is_fulfilled}});
  return json;
}

Json spiral_indices(const Track& track, const std::vector<Phase>& phases, double L_pp) {
  Json rows = Json::array();
  std::vector<double> rudder[2], yaw[2];
  std::vector<bool> is_steady[2];
  double speed = 0.0;
  double lowest = phases.empty() ? 0.0 : phases[0].order;
  for (const Phase& phase : phases) lowest = std::min(lowest, phase.order);
  std::size_t leg = 0;
  for (const Phase& phase : phases) {
    if (!phase.is_complete) break;
    const Moment m = track.at(phase.end_s);
    rows.push_back({{"leg", leg + 1},
                    {"rudder_deg", rad_to_deg(phase.order)},
                    {"r_degps", rad_to_deg(m.nu(2))},
                    {"r_nondimensional", m.nu(2) * L_pp / m.speed()},
                    {"speed_mps", m.speed()},
                    {"drift_deg", rad_to_deg(drift(m))},
                    {"hold_s", phase.end_s - phase.start_s},
                    {"is_steady", phase.is_fulfilled}});
    const auto add = [&](std::size_t to) {
      rudder[to].push_back(phase.order);
      yaw[to].push_back(m.nu(2));
      is_steady[to].push_back(phase.is_fulfilled);
    };
    add(leg);
    if (leg == 0 && phase.order == lowest) {  // both legs share their turning point
      leg = 1;
      add(leg);
    }
    if (std::abs(phase.order) < kSameAngle) speed = m.speed();
  }
  Json json;
  json["loop_height_degps"] = json["loop_width_deg"] = json["is_straight_line_stable"] = nullptr;
  const std::size_t n = rudder[0].size();
  if (leg == 1 && rudder[1].size() == n) {
    // Yaw rates that had not become steady tell nothing about a loop.
    double height = 0.0;
    for (std::size_t i = 0; i < n; ++i)
      if (is_steady[0][i] && is_steady[1][n - 1 - i]) height = std::max(height, yaw[0][i] - yaw[1][n - 1 - i]);
    const Maybe first = zero_of(rudder[0], yaw[0]), second = zero_of(rudder[1], yaw[1]);
    json["loop_height_degps"] = rad_to_deg(height);
    json["loop_width_deg"] = deg_or_null(first && second ? Maybe(*second - *first) : std::nullopt);
    const bool has_loop = height * L_pp / speed >= kSameYaw;
    if (has_loop || all_fulfilled(phases)) json["is_straight_line_stable"] = !has_loop;
  }
  json["curve"] = rows;
  return json;
}

Json crash_stop_indices(const Track& track, const std::vector<Phase>& phases, double L_pp) {
  Json json;
  const bool is_executed = phases.size() > 1;
  const double t0 = is_executed ? phases[1].start_s : track.end_s();
  const Course course(track.at(t0), 1.0);
  const Maybe stop = is_executed ? track.first_rise(t0, [](const Moment& m) { return -m.nu(0); }) : std::nullopt;
  json["execute_s"] = is_executed ? Json(t0) : Json();
  json["speed_at_execute_mps"] = is_executed ? Json(course.origin.speed()) : Json();
  json["time_to_stop_s"] = or_null(stop ? Maybe(*stop - t0) : stop);
  put_length(json, "track_reach", stop ? Maybe(track.length(*stop) - track.length(t0)) : stop, L_pp);
  put_length(json, "head_reach", stop ? Maybe(course.advance(track.at(*stop))) : stop, L_pp);
  put_length(json, "lateral_deviation", stop ? Maybe(course.transfer(track.at(*stop))) : stop, L_pp);
  json["heading_change_deg"] = deg_or_null(stop ? Maybe(course.change(track.at(*stop))) : stop);
  return json;
}

Json coast_down_indices(const Track& track, double L_pp) {
  const double t0 = track.start_s();
  const Course course(track.at(t0), 1.0);
  Json json, speeds = Json::array();
  for (const double fraction : {0.5, 0.25, 0.125, 0.1}) {
    const double speed = fraction * course.origin.speed();
    const Maybe t = track.first_rise(t0, [&](const Moment& m) { return speed - m.speed(); });
    Json& row = speeds.emplace_back();
    row["speed_fraction"] = fraction;
    row["speed_mps"] = speed;
    row["time_s"] = or_null(t ? Maybe(*t - t0) : t);
    put_length(row, "track", length_at(track, t, t0), L_pp);
    row["heading_change_deg"] = deg_or_null(t ? Maybe(course.change(track.at(*t))) : t);
  }
  json["initial_speed_mps"] = course.origin.speed();
  json["speeds"] = speeds;
  return json;
}

Json thruster_pulse_indices(const Track& track, const std::vector<Phase>& phases) {
  Json pulses = Json::array();
  const std::vector<double>& times = track.times();
  for (std::size_t i = 0; i < phases.size(); i += 2) {
    const Phase& pulse = phases[i];
    const bool has_rest = i + 1 < phases.size();
    const double until = has_rest ? phases[i + 1].end_s : pulse.end_s;
    // The bow follows a bow thruster and goes against a stern thruster: the side is that of the change.
    const Vec3<double> gained = track.at(pulse.end_s).nu - track.at(pulse.start_s).nu;
    const double yaw_side = side_of(gained(2)), sway_side = side_of(gained(1));
    double r = 0.0, yaw_acceleration = 0.0, sway_acceleration = 0.0;
    for (std::size_t k = 1; k < times.size(); ++k) {
      if (times[k] <= pulse.start_s || times[k] > until) continue;
      const Moment a = track.at(times[k - 1]), b = track.at(times[k]);
      const double h = b.t_s - a.t_s;
      r = std::max(r, yaw_side * b.nu(2));
      if (b.t_s > pulse.end_s) continue;
      yaw_acceleration = std::max(yaw_acceleration, yaw_side * (b.nu(2) - a.nu(2)) / h);
      sway_acceleration = std::max(sway_acceleration, sway_side * (b.nu(1) - a.nu(1)) / h);
    }
    const auto change = [&](double t) { return track.at(t).psi - track.at(pulse.start_s).psi; };
    Json& row = pulses.emplace_back();
    row["side"] = side_name(pulse.order);
    row["rps"] = pulse.order;
    row["t_start_s"] = pulse.start_s;
    const auto if_complete = [&](bool is_complete, double value) { return is_complete ? Json(value) : Json(); };
    const bool is_rested = has_rest && phases[i + 1].is_complete;
    row["pulse_s"] = if_complete(pulse.is_complete, pulse.end_s - pulse.start_s);
    row["initial_yaw_acceleration_degps2"] = if_complete(pulse.is_complete, yaw_side * rad_to_deg(yaw_acceleration));
    row["initial_sway_acceleration_mps2"] = if_complete(pulse.is_complete, sway_side * sway_acceleration);
    row["max_r_degps"] = if_complete(pulse.is_complete, yaw_side * rad_to_deg(r));
    row["r_change_in_pulse_degps"] =
        if_complete(pulse.is_complete, rad_to_deg(track.at(pulse.end_s).nu(2) - track.at(pulse.start_s).nu(2)));
    row["heading_change_in_pulse_deg"] = if_complete(pulse.is_complete, rad_to_deg(change(pulse.end_s)));
    row["heading_change_with_rest_deg"] = if_complete(is_rested, rad_to_deg(change(until)));
  }
  return {{"pulses", pulses}};
}

Json straight_indices(const Track& track, const Trajectory& trajectory, double L_pp) {
  const double t0 = track.start_s(), end = track.end_s(), half = 0.5 * (t0 + end);
  const Course course(track.at(t0), 1.0);
  const auto speed = [](const Moment& m) { return m.speed(); };
  double farthest = 0.0;
  for (const double t : track.times()) {
    const double y = course.transfer(track.at(t));
    if (std::abs(y) > std::abs(farthest)) farthest = y;
  }
  Json json;
  json["mean_speed_mps"] = track.mean(t0, end, speed);
  json["mean_speed_second_half_mps"] = track.mean(half, end, speed);
  json["mean_heading_error_deg"] = rad_to_deg(track.mean(t0, end, [&](const Moment& m) { return course.change(m); }));
  json["rms_heading_error_deg"] =
      rad_to_deg(std::sqrt(track.mean(t0, end, [&](const Moment& m) { return std::pow(course.change(m), 2); })));
  put_length(json, "largest_lateral_deviation", farthest, L_pp);
  for (const Channel channel : {Channel::delta, Channel::delta_p, Channel::delta_s}) {
    if (!trajectory.has(channel)) continue;
    double sum = 0.0, squares = 0.0;
    for (const double delta : trajectory[channel]) {
      sum += delta;
      squares += delta * delta;
    }
    const auto n = static_cast<double>(trajectory.size());
    json["mean_" + column_name(channel)] = rad_to_deg(sum / n);
    json["rms_" + column_name(channel)] = rad_to_deg(std::sqrt(squares / n));
  }
  return json;
}

Json berthing_indices(const Track& track, double quay_heading, double L_pp) {
  const Moment last = track.at(track.end_s());
  double closest = std::numeric_limits<double>::infinity(), astern = 0.0;
  for (const double t : track.times()) {
    closest = std::min(closest, track.at(t).position.norm());
    astern = std::max(astern, -track.at(t).nu(0));
  }
  const double within = 0.25 * L_pp;
  Json json;
  json["time_to_quarter_L_s"] =
      or_null(track.first_rise(track.start_s(), [&](const Moment& m) { return within - m.position.norm(); }));
  put_length(json, "closest_to_berth", closest, L_pp);
  put_length(json, "distance_to_berth_at_end", last.position.norm(), L_pp);
  json["heading_error_at_end_deg"] = rad_to_deg(wrap_angle(last.psi - quay_heading));
  json["speed_at_end_mps"] = last.speed();
  json["share_of_time_astern"] =
      track.mean(track.start_s(), track.end_s(), [](const Moment& m) { return m.nu(0) < 0.0 ? 1.0 : 0.0; });
  json["most_astern_mps"] = astern;
  return json;
}

Json run_indices(const Track& track, const Trajectory& trajectory, double L_pp) {
  Json json;
  const Moment first = track.at(track.start_s()), last = track.at(track.end_s());
  json["duration_s"] = track.end_s() - track.start_s();
  put_length(json, "track_length", track.length(track.end_s()), L_pp);
  put_length(json, "distance_made_good", (last.position - first.position).norm(), L_pp);
  json["heading_change_deg"] = rad_to_deg(last.psi - first.psi);
  Json& range = json["min_max"];
  std::vector<double> speed;
  for (std::size_t i = 0; i < trajectory.size(); ++i)
    speed.push_back(std::hypot(trajectory[Channel::u][i], trajectory[Channel::vm][i]));
  range["speed_mps"] = extremes(speed, 1.0);
  for (const ChannelInfo& channel : kChannels) {
    const bool is_direction = channel.channel == Channel::wind_dir || channel.channel == Channel::app_wind_dir;
    if (channel.channel == Channel::t || is_direction || !trajectory.has(channel.channel)) continue;
    range[column_name(channel.channel)] = extremes(trajectory[channel.channel], column_unit(channel.channel));
  }
  return json;
}

Json maneuver_indices(const Trajectory& trajectory, const Ship& ship, const ManeuverFacts& facts) {
  const Track track(trajectory);
  const double L_pp = ship.particulars.L_pp;
  Json indices;
  if (facts.maneuver == "turning") indices = turning_indices(track, facts.rudder, L_pp);
  if (facts.maneuver == "zigzag") indices = zigzag_indices(track, facts.rudder, facts.heading, L_pp);
  if (facts.maneuver == "pull-out") indices = pull_out_indices(track, facts.phases, L_pp);
  if (facts.maneuver == "spiral") indices = spiral_indices(track, facts.phases, L_pp);
  if (facts.maneuver == "crash-stop") indices = crash_stop_indices(track, facts.phases, L_pp);
  if (facts.maneuver == "coast-down") indices = coast_down_indices(track, L_pp);
  if (facts.maneuver == "thruster-pulses") indices = thruster_pulse_indices(track, facts.phases);
  if (facts.maneuver == "berthing" || facts.maneuver == "port-navigation")
    indices = berthing_indices(track, facts.heading, L_pp);
  if (facts.maneuver == "straight") indices = straight_indices(track, trajectory, L_pp);
  Json json;
  if (!indices.is_null()) {
    // The speed of the approach: that at the order, which a crash stop gives later than at the start.
    const bool is_stop = facts.maneuver == "crash-stop" && facts.phases.size() > 1;
    const double speed = track.at(is_stop ? facts.phases[1].start_s : track.start_s()).nu(0);
    json["imo_msc_137_76"] = imo_criteria(indices, facts, ship, speed);
    json["indices"] = indices;
  }
  json["run"] = run_indices(track, trajectory, L_pp);
  return json;
}

std::vector<std::string> not_reached(const Json& indices) {
  std::vector<std::string> names;
  for (const auto& [name, value] : indices.items()) {
    const bool is_repeated = name.size() > 7 && name.substr(name.size() - 7) == "_over_L";
    if (value.is_null() && !is_repeated) names.push_back(name);
    if (value.is_structured())
      for (const std::string& inner : not_reached(value)) names.push_back(fmt::format("{}/{}", name, inner));
  }
  return names;
}

}  // namespace leeway
