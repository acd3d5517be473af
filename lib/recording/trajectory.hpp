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
  n_az1,
  az1,
  n_az2,
  az2,
  wind_speed,
  wind_dir,
  app_wind_speed,
  app_wind_dir,
};
inline constexpr std::size_t kChannelCount = 22;

/// What an actuator does: it steers, it drives the ship, it pushes sideways, it turns a thrust round and round.
enum class Role { none, rudder, propulsion, thruster, azimuth };

enum class Quantity { time, length, speed, angle, angular_rate, revolutions, ratio };

struct ChannelInfo {
  Channel channel;
  std::string_view name;  ///< column name without its unit
  Quantity quantity;
  std::string_view unit;  ///< unit suffix that writers use; empty for a ratio
  Role role = Role::none;
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
    {Channel::delta, "delta", Quantity::angle, "deg", Role::rudder},
    {Channel::delta_p, "delta_p", Quantity::angle, "deg", Role::rudder},
    {Channel::delta_s, "delta_s", Quantity::angle, "deg", Role::rudder},
    {Channel::n_p, "n_p", Quantity::revolutions, "rps", Role::propulsion},
    {Channel::n_bt, "n_bt", Quantity::revolutions, "rps", Role::thruster},
    {Channel::n_st, "n_st", Quantity::revolutions, "rps", Role::thruster},
    {Channel::i_bt, "i_bt", Quantity::ratio, "", Role::thruster},
    {Channel::n_az1, "n_az1", Quantity::revolutions, "rps", Role::propulsion},
    {Channel::az1, "az1", Quantity::angle, "deg", Role::azimuth},
    {Channel::n_az2, "n_az2", Quantity::revolutions, "rps", Role::propulsion},
    {Channel::az2, "az2", Quantity::angle, "deg", Role::azimuth},
    {Channel::wind_speed, "wind_speed", Quantity::speed, "mps"},
    {Channel::wind_dir, "wind_dir", Quantity::angle, "deg"},
    {Channel::app_wind_speed, "app_wind_speed", Quantity::speed, "mps"},
    {Channel::app_wind_dir, "app_wind_dir", Quantity::angle, "deg"},
}};

/// The channels that may be derived, each by differentiation of another one: over ground, (u, v_m) with the heading.
struct DerivableChannel {
  Channel channel, of;
  std::string_view flag;  ///< the column that says so: 1
};
inline constexpr std::array<DerivableChannel, 3> kDerivableChannels{{{Channel::u, Channel::x0, "u_derived"},
                                                                     {Channel::vm, Channel::y0, "vm_derived"},
                                                                     {Channel::r, Channel::psi, "r_derived"}}};

/// The channels that move the ship, in column order.
inline constexpr std::array<Channel, 11> kActuatorChannels{
    Channel::delta, Channel::delta_p, Channel::delta_s, Channel::n_p,   Channel::n_bt, Channel::n_st,
    Channel::i_bt,  Channel::n_az1,   Channel::az1,     Channel::n_az2, Channel::az2};

constexpr const ChannelInfo& info(Channel channel) { return kChannels[static_cast<std::size_t>(channel)]; }

/// "u_mps", "i_bt": the column name that writers use and readers expect.
std::string column_name(Channel channel);
/// The same with the SI unit: "psi_rad", "r_radps".
std::string si_name(Channel channel);
/// One unit of that column in SI: a degree in rad for "psi_deg".
double column_unit(Channel channel);

inline constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

/// The longest time between two samples that follow one another; `line` is that of the second, 0 where no file was
/// read.
struct LongestStep {
  std::size_t line = 0;
  double from_s = 0.0, to_s = 0.0;
  double length_s() const { return to_s - from_s; }
};

/// A recording, simulation or truth: one vector per channel, SI and radians, NaN where a sample is missing. All
/// present channels have the same length; an empty vector is an absent channel. Time increases strictly, the
/// heading is unwrapped.
struct Trajectory {
  std::string name;                                     ///< file name without folder and extension
  std::string file;                                     ///< as the user named it, for messages
  std::vector<std::string> ignored_columns;             ///< columns of the file that no tool knows
  std::vector<std::string> absent_columns;              ///< that the columns map names and the file does not have
  std::vector<std::vector<std::string>> ignored_texts;  ///< what stands in them; empty unless the reader was to keep it
  LongestStep longest_step;
  std::array<std::vector<double>, kChannelCount> columns;
  std::array<bool, kChannelCount> derived{};  ///< computed from other channels by differentiation, not measured

  std::vector<double>& operator[](Channel channel) { return columns[static_cast<std::size_t>(channel)]; }
  const std::vector<double>& operator[](Channel channel) const { return columns[static_cast<std::size_t>(channel)]; }
  bool& is_derived(Channel channel) { return derived[static_cast<std::size_t>(channel)]; }
  bool is_derived(Channel channel) const { return derived[static_cast<std::size_t>(channel)]; }
  bool has(Channel channel) const { return !(*this)[channel].empty(); }
  std::size_t size() const { return (*this)[Channel::t].size(); }
  bool has_wind() const {
    return (has(Channel::wind_speed) && has(Channel::wind_dir)) ||
           (has(Channel::app_wind_speed) && has(Channel::app_wind_dir));
  }
};

/// Names of the actuators' columns that it has, "delta_deg, n_p_rps", or "none".
std::string found_actuators(const Trajectory& trajectory);

/// The usual time between two samples: the median; 0 for fewer than two.
double sampling_time_s(const Trajectory& trajectory);

/// Whether the clock of a recording jumps: one step is longer than all others together, and than ten usual ones.
bool clock_jumps(const Trajectory& trajectory);
/// "from 30 s to 1.7e+09 s in one step, while all others last 59 s": where clock_jumps().
std::string jump_text(const Trajectory& trajectory);

/// A piece of time.
struct TimeSpan {
  double from_s = 0.0, to_s = 0.0;
};
/// What is made per second of a recording is not made of so long a pause [s]: our choice, a day.
inline constexpr double kLongestPause_s = 86400.0;
/// A recording's time without pauses beyond kLongestPause_s, so that what is made per second of a recording is not made
/// of these; mostly one span. None for an empty recording.
std::vector<TimeSpan> spans_between_jumps(const Trajectory& trajectory);
/// The mean time between two samples of one span; 0 for fewer than two.
double mean_sampling_time_s(const Trajectory& trajectory);

/// Whether two recordings have the same channels with the same samples.
bool same_contents(const Trajectory& a, const Trajectory& b);

/// Makes an angle history continuous in place: neighbors differ by less than half a turn; NaN is passed over.
void unwrap(std::vector<double>& angle);

}  // namespace leeway
