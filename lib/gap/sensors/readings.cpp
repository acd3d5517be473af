#include "gap/sensors/readings.hpp"

#include <algorithm>
#include <array>

#include "core/units.hpp"

namespace leeway::gap {
namespace {

using R = Trajectory&;
using Readings = std::vector<ReadingEntry>;

constexpr double kToDegrees = 1.0 / kDegree;
constexpr std::initializer_list<Channel> kRudders{Channel::delta, Channel::delta_p, Channel::delta_s};

void scale(Trajectory& recording, std::initializer_list<Channel> channels, double factor) {
  for (const Channel channel : channels) scale_channel(recording, channel, factor);
}
void unwrap_scaled(Trajectory& recording, Channel channel, double factor) {
  scale_channel(recording, channel, factor);
  unwrap(recording[channel]);
}

Readings of_the_motion() {
  return {
      {"psi", "counter-clockwise", "psi is positive counter-clockwise", Channel::psi,
       [](R t) { scale(t, {Channel::psi}, -1.0); }},
      {"psi", "radians", "psi_deg holds radians", Channel::psi,
       [](R t) { unwrap_scaled(t, Channel::psi, kToDegrees); }},
      {"psi", "degrees", "psi_rad holds degrees", Channel::psi, [](R t) { unwrap_scaled(t, Channel::psi, kDegree); }},
      {"x0", "east", "x0 is east and y0 north", Channel::x0, [](R t) { std::swap(t[Channel::x0], t[Channel::y0]); }},
      {"x0", "km", "x0 and y0 are in kilometers", Channel::x0,
       [](R t) {
         scale(t, {Channel::x0, Channel::y0}, 1000.0);
       }},
      {"x0", "ft", "x0 and y0 are in feet", Channel::x0,
       [](R t) {
         scale(t, {Channel::x0, Channel::y0}, kFoot_m);
       }},
      {"y0", "west", "y0 is positive to the west", Channel::y0, [](R t) { scale(t, {Channel::y0}, -1.0); }},
      {"u", "knots", "u and vm are in knots", Channel::u,
       [](R t) {
         scale(t, {Channel::u, Channel::vm}, kKnot);
       }},
      {"u", "kmh", "u and vm are in km/h", Channel::u,
       [](R t) {
         scale(t, {Channel::u, Channel::vm}, kKilometerPerHour);
       }},
      {"vm", "port-positive", "vm is positive to port", Channel::vm, [](R t) { scale(t, {Channel::vm}, -1.0); }},
      {"r", "counter-clockwise", "r is positive to port", Channel::r, [](R t) { scale(t, {Channel::r}, -1.0); }},
      {"r", "radians", "r_degps holds radians per second", Channel::r, [](R t) { scale(t, {Channel::r}, kToDegrees); }},
      {"r", "degrees", "r_radps holds degrees per second", Channel::r, [](R t) { scale(t, {Channel::r}, kDegree); }},
      {"r", "degpmin", "r_degps holds degrees per minute", Channel::r, [](R t) { scale(t, {Channel::r}, 1.0 / 60.0); }},
      {"wind", "apparent", "the true wind is the apparent one", Channel::wind_speed,
       [](R t) {
         std::swap(t[Channel::wind_speed], t[Channel::app_wind_speed]);
         std::swap(t[Channel::wind_dir], t[Channel::app_wind_dir]);
       },
       true, true},
  };
}

Readings of_the_actuators() {
  return {
      {"delta", "port-positive", "rudder angles are positive to port", Channel::delta,
       [](R t) { scale(t, kRudders, -1.0); }},
      {"delta_p", "port-positive", "delta_p is positive to port", Channel::delta_p,
       [](R t) { scale(t, {Channel::delta_p}, -1.0); }},
      {"delta_s", "port-positive", "delta_s is positive to port", Channel::delta_s,
       [](R t) { scale(t, {Channel::delta_s}, -1.0); }},
      {"delta", "radians", "rudder angles labeled deg are in radians", Channel::delta,
       [](R t) { scale(t, kRudders, kToDegrees); }, false, false, 0.0,
       kPi * kDegree},  // only angles that a rudder can have
      {"delta", "degrees", "rudder angles labeled rad are in degrees", Channel::delta,
       [](R t) { scale(t, kRudders, kDegree); }, false, false, kPi},  // only angles that no rudder has
      {"n_p", "rpm", "n_p is in revolutions per minute", Channel::n_p,
       [](R t) { scale(t, {Channel::n_p}, 1.0 / 60.0); }},
      {"n_p", "radians", "n_p is in radians per second", Channel::n_p,
       [](R t) { scale(t, {Channel::n_p}, 0.5 / kPi); }},
      {"n_bt", "port-positive", "n_bt is positive where the force goes to port", Channel::n_bt,
       [](R t) { scale(t, {Channel::n_bt}, -1.0); }},
      {"n_bt", "rpm", "n_bt is in revolutions per minute", Channel::n_bt,
       [](R t) { scale(t, {Channel::n_bt}, 1.0 / 60.0); }},
      {"n_st", "port-positive", "n_st is positive where the force goes to port", Channel::n_st,
       [](R t) { scale(t, {Channel::n_st}, -1.0); }},
  };
}

Readings of_the_winds() {
  Readings list;
  struct Wind {
    std::string_view direction, speed, word;
    Channel direction_channel, speed_channel;
  };
  for (const Wind& wind :
       {Wind{"wind_dir", "wind_speed", "true", Channel::wind_dir, Channel::wind_speed},
        Wind{"app_wind_dir", "app_wind_speed", "apparent", Channel::app_wind_dir, Channel::app_wind_speed}}) {
    const bool is_true = wind.word == "true";
    const Channel direction = wind.direction_channel, speed = wind.speed_channel;
    list.push_back({wind.direction, "wind-to",
                    is_true ? "wind_dir is where the wind blows to" : "app_wind_dir is where the wind blows to",
                    direction,
                    [direction](R t) {
                      for (double& x : t[direction]) x += kPi;
                    },
                    true});
    list.push_back({wind.direction, "radians",
                    is_true ? "wind_dir_deg holds radians" : "app_wind_dir_deg holds radians", direction,
                    [direction](R t) { scale(t, {direction}, kToDegrees); }});
    list.push_back({wind.speed, "knots", is_true ? "wind_speed is in knots" : "app_wind_speed is in knots", speed,
                    [speed](R t) { scale(t, {speed}, kKnot); }});
  }
  return list;
}

}  // namespace

const std::vector<ReadingEntry>& readings() {
  static const Readings all = [] {
    Readings list = of_the_motion();
    for (const Readings& more : {of_the_actuators(), of_the_winds()}) list.insert(list.end(), more.begin(), more.end());
    return list;
  }();
  return all;
}

const ReadingEntry* find_reading(std::string_view channel, std::string_view name) {
  for (const ReadingEntry& entry : readings())
    if (entry.channel == channel && entry.name == name) return &entry;
  return nullptr;
}

bool is_of_motion(Channel channel) {
  constexpr std::array kMotion{Channel::psi, Channel::x0, Channel::y0, Channel::u, Channel::vm, Channel::r};
  return std::find(kMotion.begin(), kMotion.end(), channel) != kMotion.end();
}

bool is_of_wind(Channel channel) {
  constexpr std::array kWinds{Channel::wind_speed, Channel::wind_dir, Channel::app_wind_speed, Channel::app_wind_dir};
  return std::find(kWinds.begin(), kWinds.end(), channel) != kWinds.end();
}

std::optional<Channel> channel_of_reading(std::string_view channel) {
  for (const ReadingEntry& entry : readings())
    if (entry.channel == channel) return entry.of;
  return std::nullopt;
}

std::vector<const ReadingEntry*> pick_readings(
    std::initializer_list<std::pair<std::string_view, std::string_view>> names) {
  std::vector<const ReadingEntry*> result;
  for (const auto& [channel, name] : names) result.push_back(find_reading(channel, name));
  return result;
}

std::vector<Trajectory> applied(std::vector<Trajectory> recordings, const std::vector<const ReadingEntry*>& which) {
  for (Trajectory& recording : recordings)
    for (const ReadingEntry& entry : readings())
      if (std::find(which.begin(), which.end(), &entry) != which.end()) entry.apply(recording);
  return recordings;
}

void scale_channel(Trajectory& recording, Channel channel, double factor) {
  for (double& x : recording[channel]) x *= factor;
}

}  // namespace leeway::gap
