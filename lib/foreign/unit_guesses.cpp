#include "foreign/unit_guesses.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/units.hpp"

namespace leeway::foreign {
namespace {

constexpr double kLargestRadians = 2.1, kWholeTurn = 2.0 * kPi + 0.1;  // of a rudder, of a direction
constexpr double kFastestTurn_radps = 0.3;

// 1/s or 1/min: that which makes the ship that has this propeller run at a usual Froude number, with an advance ratio
// of 0.65 and a diameter of 3 % of the length.
std::string likely_revolutions(double n, double u_mps) {
  constexpr double kAdvanceRatio = 0.65, kDiameterByLength = 0.03, kUsualFroude = 0.15;
  std::string best;
  double nearest = 1e300;
  for (const std::string_view unit : {"rps", "rpm"}) {
    const double rps = n * io::unit_of(Quantity::revolutions, unit)->factor;
    const double length = u_mps / (kAdvanceRatio * rps) / kDiameterByLength;
    const double off = std::abs(std::log(u_mps / std::sqrt(kGravity_mps2 * length) / kUsualFroude));
    if (off >= nearest) continue;
    nearest = off;
    best = unit;
  }
  return best;
}

class Guesses {
 public:
  Guesses(Roles& roles, const ChannelValues& values) : roles_(roles), values_(values) {}

  void guess(Channel channel, const std::string& unit) {
    if (!lacks(channel)) return;
    roles_.channels.at(channel).unit = unit;
    roles_.unknowable.push_back(fmt::format("the unit of {} is taken to be {}", info(channel).name, unit));
  }
  void guess_angle(Channel channel, double largest) {
    if (lacks(channel)) guess(channel, largest_of(values_.at(channel)) > largest ? "deg" : "rad");
  }
  // What is too large for radians is in degrees.
  void find_angle(Channel channel, double largest) {
    if (!lacks(channel)) return;
    if (largest_of(values_.at(channel)) > largest)
      roles_.channels.at(channel).unit = "deg";
    else
      guess(channel, "rad");
  }
  bool lacks(Channel channel) const {
    const auto role = roles_.channels.find(channel);
    return role != roles_.channels.end() && role->second.unit.empty();
  }

 private:
  Roles& roles_;
  const ChannelValues& values_;
};

}  // namespace

double mean_of(const std::vector<double>& values) {
  double sum = 0.0, count = 0.0;
  for (const double x : values)
    if (!std::isnan(x)) {
      sum += x;
      count += 1.0;
    }
  return count > 0.0 ? sum / count : 0.0;
}

double largest_of(const std::vector<double>& values) {
  double largest = 0.0;
  for (const double x : values)
    if (!std::isnan(x)) largest = std::max(largest, std::abs(x));
  return largest;
}

void guess_units(Roles& roles, const ChannelValues& values, const std::vector<double>& speed) {
  Guesses guesses(roles, values);
  guesses.guess_angle(Channel::psi, kWholeTurn);
  if (roles.frame == io::VelocityFrame::course_and_speed) guesses.guess_angle(Channel::vm, kWholeTurn);
  for (const Channel channel : {Channel::u, Channel::vm, Channel::wind_speed, Channel::app_wind_speed})
    guesses.guess(channel, "mps");
  if (guesses.lacks(Channel::r))
    guesses.guess(Channel::r, largest_of(values.at(Channel::r)) > kFastestTurn_radps ? "degps" : "radps");
  for (const Channel channel : {Channel::delta, Channel::delta_p, Channel::delta_s, Channel::az1, Channel::az2})
    guesses.find_angle(channel, kLargestRadians);
  for (const Channel channel : {Channel::wind_dir, Channel::app_wind_dir}) guesses.find_angle(channel, kWholeTurn);
  const auto u = roles.channels.find(Channel::u);
  const double u_mps =
      u == roles.channels.end() ? 0.0 : mean_of(speed) * io::unit_of(Quantity::speed, u->second.unit)->factor;
  for (const Channel channel : {Channel::n_p, Channel::n_bt, Channel::n_st, Channel::n_az1, Channel::n_az2}) {
    if (!guesses.lacks(channel)) continue;
    const double n = mean_of(values.at(channel));
    guesses.guess(channel, u_mps > 0.0 && n > 0.0 ? likely_revolutions(n, u_mps) : "rps");
  }
}

}  // namespace leeway::foreign
