#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

namespace leeway {

/// What a trajectory can carry. Actuator channels are *actual* values; velocities belong to midship, over ground.
enum class Channel : std::size_t {
  t,
  u,
  vm,
  r,
  x0,
  y0,
  psi,
  delta,
  delta_p,
  delta_s,
  n_p,
  n_bt,
  n_st,
  i_bt,
  wind_speed,
  wind_dir,
  app_wind_speed,
  app_wind_dir,
};
inline constexpr std::size_t kChannelCount = 18;

enum class Quantity { time, length, speed, angle, angular_rate, revolutions, ratio };

struct ChannelInfo {
  Channel channel;
  std::string_view name;  ///< column name without its unit
  Quantity quantity;
  std::string_view unit;  ///< unit suffix that writers use; empty for a ratio
};

/// All channels in the order in which writers put the columns.
inline constexpr std::array<ChannelInfo, kChannelCount> kChannels{{
    {Channel::t, "t", Quantity::time, "s"},
    {Channel::u, "u", Quantity::speed, "mps"},
    {Channel::vm, "vm", Quantity::speed, "mps"},
    {Channel::r, "r", Quantity::angular_rate, "degps"},
    {Channel::x0, "x0", Quantity::length, "m"},
    {Channel::y0, "y0", Quantity::length, "m"},
    {Channel::psi, "psi", Quantity::angle, "deg"},
    {Channel::delta, "delta", Quantity::angle, "deg"},
    {Channel::delta_p, "delta_p", Quantity::angle, "deg"},
    {Channel::delta_s, "delta_s", Quantity::angle, "deg"},
    {Channel::n_p, "n_p", Quantity::revolutions, "rps"},
    {Channel::n_bt, "n_bt", Quantity::revolutions, "rps"},
    {Channel::n_st, "n_st", Quantity::revolutions, "rps"},
    {Channel::i_bt, "i_bt", Quantity::ratio, ""},
    {Channel::wind_speed, "wind_speed", Quantity::speed, "mps"},
    {Channel::wind_dir, "wind_dir", Quantity::angle, "deg"},
    {Channel::app_wind_speed, "app_wind_speed", Quantity::speed, "mps"},
    {Channel::app_wind_dir, "app_wind_dir", Quantity::angle, "deg"},
}};

/// The channels that move the ship, in column order.
inline constexpr std::array<Channel, 7> kActuatorChannels{
    Channel::delta, Channel::delta_p, Channel::delta_s, Channel::n_p, Channel::n_bt, Channel::n_st, Channel::i_bt};

constexpr const ChannelInfo& info(Channel channel) { return kChannels[static_cast<std::size_t>(channel)]; }

/// "u_mps", "i_bt": the column name that writers use and readers expect.
std::string column_name(Channel channel);
/// The same with the SI unit: "psi_rad", "r_radps".
std::string si_name(Channel channel);

inline constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

/// A recording, simulation or truth: one vector per channel, SI and radians, NaN where a sample is missing. All
/// present channels have the same length; an empty vector is an absent channel. Time increases strictly, the
/// heading is unwrapped.
struct Trajectory {
  std::string name;                                     ///< file name without folder and extension
  std::string file;                                     ///< as the user named it, for messages
  std::vector<std::string> ignored_columns;             ///< columns of the file that no tool knows
  std::vector<std::vector<std::string>> ignored_texts;  ///< what stands in them; empty unless the reader was to keep it
  std::array<std::vector<double>, kChannelCount> columns;

  std::vector<double>& operator[](Channel channel) { return columns[static_cast<std::size_t>(channel)]; }
  const std::vector<double>& operator[](Channel channel) const { return columns[static_cast<std::size_t>(channel)]; }
  bool has(Channel channel) const { return !(*this)[channel].empty(); }
  std::size_t size() const { return (*this)[Channel::t].size(); }
  bool has_wind() const {
    return (has(Channel::wind_speed) && has(Channel::wind_dir)) ||
           (has(Channel::app_wind_speed) && has(Channel::app_wind_dir));
  }
};

/// Makes an angle history continuous in place: neighbors differ by less than half a turn; NaN is passed over.
void unwrap(std::vector<double>& angle);

}  // namespace leeway
