#include "dynamics/recording_indices.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/errors.hpp"
#include "core/units.hpp"

namespace leeway {
namespace {

using io::Json;

// The integral of a rate from the first sample on, trapezoidal; a missing rate is passed over.
std::vector<double> integral(const std::vector<double>& t, const std::vector<double>& rate) {
  std::vector<double> result(t.size(), 0.0);
  double last = 0.0;
  for (std::size_t i = 0; i < t.size(); ++i) {
    const double now = std::isnan(rate[i]) ? last : rate[i];
    if (i > 0) result[i] = result[i - 1] + 0.5 * (last + now) * (t[i] - t[i - 1]);
    last = now;
  }
  return result;
}

void integrate_pose(Trajectory& run, std::vector<std::string>& notices) {
  const std::vector<double>& t = run[Channel::t];
  if (!run.has(Channel::psi)) {
    run[Channel::psi] = integral(t, run[Channel::r]);
    notices.push_back(fmt::format("{}: no psi_deg; the heading is integrated from r_degps", run.file));
  }
  if (run.has(Channel::x0) && run.has(Channel::y0)) return;
  std::vector<double> north(t.size()), east(t.size());
  for (std::size_t i = 0; i < t.size(); ++i) {
    const double c = std::cos(run[Channel::psi][i]), s = std::sin(run[Channel::psi][i]);
    north[i] = run[Channel::u][i] * c - run[Channel::vm][i] * s;
    east[i] = run[Channel::u][i] * s + run[Channel::vm][i] * c;
  }
  run[Channel::x0] = integral(t, north);
  run[Channel::y0] = integral(t, east);
  notices.push_back(
      fmt::format("{}: no x0_m, y0_m; positions are integrated from u_mps, vm_mps and psi_deg", run.file));
}

bool is_rudder(Channel channel) { return info(channel).role == Role::rudder; }

double mean_wind(const Trajectory& run) {
  double sum = 0.0, count = 0.0;
  for (const double speed : run[Channel::wind_speed])
    if (!std::isnan(speed)) {
      sum += speed;
      count += 1.0;
    }
  return count > 0.0 ? sum / count : 0.0;
}

// What the recording leaves open, and the indices depend on.
void say_what_is_assumed(const std::string& file, const RecordedManeuver& maneuver, double speed,
                         std::vector<std::string>& notices) {
  constexpr double kApart = 0.01 * kDegree;
  const bool is_coarse = maneuver.resolution > maneuver.noise;
  if (maneuver.order_doubt_s > 0.0)
    notices.push_back(fmt::format(
        "{}: the recorded rudder {} {:.2g} deg: the order may be {:.2g} s earlier or later, and distances from it "
        "{:.2g} m "
        "longer or shorter",
        file, is_coarse ? "has steps of" : "scatters by", rad_to_deg(is_coarse ? maneuver.resolution : maneuver.noise),
        maneuver.order_doubt_s, maneuver.order_doubt_s * speed));
  if (maneuver.heading < maneuver.least_heading - kApart || maneuver.heading > maneuver.most_heading + kApart)
    notices.push_back(fmt::format(
        "{}: a zigzag at {:.4g} deg of heading is assumed; the rudder is put over at {:.4g} to {:.4g} deg", file,
        rad_to_deg(maneuver.heading), rad_to_deg(maneuver.least_heading), rad_to_deg(maneuver.most_heading)));
}

Json imo_of(const Json& indices, const RecordedManeuver& maneuver, const RecordedShip& ship, double speed,
            double wind) {
  if (!ship.L_pp_m) return {{"applies", false}, {"reason", "the ship's length is not given"}};
  const double root = std::sqrt(ship.scale);
  return imo_criteria(
      indices, {maneuver.name, maneuver.rudder, maneuver.heading, {}, wind},
      RecordedTest{*ship.L_pp_m * ship.scale, speed * root, ship.hardest_rudder.value_or(35.0 * kDegree), wind * root});
}

}  // namespace

RecordedShip recorded_ship(const Ship& ship) {
  RecordedShip recorded{ship.particulars.L_pp, ship.scale, 35.0 * kDegree};
  for (const Actuator& actuator : ship.actuators)
    if (actuator.is_rudder())
      recorded.hardest_rudder = std::min({*recorded.hardest_rudder, actuator.max, -actuator.min});
  return recorded;
}

Trajectory complete_states(const Trajectory& recording, std::vector<std::string>& notices) {
  Trajectory run = recording;
  integrate_pose(run, notices);
  std::vector<Channel> needed{Channel::u, Channel::vm, Channel::r, Channel::x0, Channel::y0, Channel::psi};
  for (const Channel channel : kActuatorChannels)
    if (is_rudder(channel) && run.has(channel)) needed.push_back(channel);
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < run.size(); ++i)
    if (std::none_of(needed.begin(), needed.end(), [&](Channel c) { return std::isnan(run[c][i]); })) rows.push_back(i);
  if (rows.size() < 2)
    throw InputError(recording.file, fmt::format("{} samples have all states; expected at least 2", rows.size()));
  if (rows.size() == run.size()) return run;
  notices.push_back(fmt::format("{}: {} of {} samples lack a state and are passed over", recording.file,
                                run.size() - rows.size(), run.size()));
  for (std::vector<double>& column : run.columns) {
    if (column.empty()) continue;
    for (std::size_t k = 0; k < rows.size(); ++k) column[k] = column[rows[k]];
    column.resize(rows.size());
  }
  return run;
}

Json recording_indices(const Trajectory& recording, const RecordedShip& ship, std::vector<std::string>& notices) {
  Trajectory run = complete_states(recording, notices);
  const RecordedManeuver maneuver = recognize_maneuver(run);
  const double L_pp = ship.L_pp_m.value_or(std::numeric_limits<double>::quiet_NaN());
  Json json{{"recording", recording.name}, {"file", recording.file}};
  json["maneuver"] = maneuver.name.empty() ? Json() : Json(maneuver.name);
  if (!maneuver.name.empty()) {
    const bool is_turning = maneuver.name == "turning";
    Trajectory turn;
    if (is_turning) {  // what comes behind the turn is none of it
      turn = run;
      const auto end = static_cast<std::size_t>(
          std::upper_bound(run[Channel::t].begin(), run[Channel::t].end(), maneuver.end_s) - run[Channel::t].begin());
      for (std::vector<double>& column : turn.columns)
        if (!column.empty()) column.resize(end);
    }
    const Track track(is_turning ? turn : run);
    const Json indices = is_turning ? turning_indices(track, maneuver.approach, maneuver.rudder, L_pp)
                                    : zigzag_indices(track, maneuver.approach, maneuver.rudder, maneuver.heading, L_pp);
    const double speed = track.at(maneuver.approach.t_s).speed();
    json["side"] = maneuver.rudder < 0.0 ? "port" : "starboard";
    json["order_s"] = maneuver.approach.t_s;
    json["order_doubt_s"] = maneuver.order_doubt_s;
    json["speed_mps"] = speed;
    json["rudder_deg"] = rad_to_deg(maneuver.rudder);
    json["measured_rudder_deg"] = rad_to_deg(maneuver.measured_rudder);
    if (!is_turning) json["heading_deg"] = rad_to_deg(maneuver.heading);
    say_what_is_assumed(recording.file, maneuver, speed, notices);
    json["approach_heading_deg"] = rad_to_deg(maneuver.approach.heading);
    json["approach_course_deg"] = rad_to_deg(maneuver.approach.course);
    json["indices"] = indices;
    json["imo_msc_137_76"] = imo_of(indices, maneuver, ship, speed, mean_wind(recording));
  }
  Trajectory states = std::move(run);  // extremes of what is known in each sample alone
  for (const ChannelInfo& channel : kChannels) {
    std::vector<double>& column = states[channel.channel];
    if (std::any_of(column.begin(), column.end(), [](double x) { return std::isnan(x); })) column.clear();
  }
  json["run"] = run_indices(Track(states), states, L_pp);
  return json;
}

std::string recording_indices_text(const Json& json) {
  std::string text = json["recording"].get<std::string>() + ": ";
  if (json["maneuver"].is_null()) return text + "neither a turning circle nor a zigzag is recognized\n";
  const Json& indices = json["indices"];
  const bool is_turning = json["maneuver"] == "turning";
  const double rudder = std::abs(json["rudder_deg"].get<double>());
  text += is_turning ? fmt::format("turning, {:.4g} deg", rudder)
                     : fmt::format("zigzag {:.4g}/{:.4g}", rudder, json["heading_deg"].get<double>());
  text += fmt::format(" to {}, order at {:.4g} s, {:.4g} m/s\n", json["side"].get<std::string>(),
                      json["order_s"].get<double>(), json["speed_mps"].get<double>());
  const auto line = [&](const std::string& name, const std::string& value) {
    text += fmt::format("  {:<28}{}\n", name, value);
  };
  const auto number = [](const Json& value, const char* unit) {
    return value.is_null() ? std::string("not reached") : fmt::format("{:.4g} {}", value.get<double>(), unit);
  };
  const auto length = [&](const std::string& name, const std::string& key) {
    std::string value = number(indices[key + "_m"], "m");
    if (indices.contains(key + "_over_L") && !indices[key + "_over_L"].is_null())
      value += fmt::format("  {:.2f} L", indices[key + "_over_L"].get<double>());
    line(name, value);
  };
  if (is_turning) {
    length("advance", "advance");
    length("transfer", "transfer");
    length("tactical diameter", "tactical_diameter");
  } else {
    line("first overshoot", number(indices["first_overshoot_deg"], "deg"));
    line("second overshoot", number(indices["second_overshoot_deg"], "deg"));
  }
  length("track to 10 deg", "track_to_10_deg");
  const Json& imo = json["imo_msc_137_76"];
  if (!imo["applies"].get<bool>()) {
    line("IMO MSC.137(76)", "not applied: " + imo["reason"].get<std::string>());
    return text;
  }
  for (const Json& criterion : imo["criteria"]) {
    const char* verdict = criterion["fulfilled"].is_null()     ? "not reached"
                          : criterion["fulfilled"].get<bool>() ? "fulfilled"
                                                               : "not fulfilled";
    line("IMO " + criterion["name"].get<std::string>(),
         fmt::format("{}, limit {:.4g}: {}", number(criterion["value"], criterion["unit"].get<std::string>().c_str()),
                     criterion["limit"].get<double>(), verdict));
  }
  return text;
}

}  // namespace leeway
