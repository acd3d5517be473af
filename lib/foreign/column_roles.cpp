#include "foreign/column_roles.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/units.hpp"
#include "foreign/anonymous_columns.hpp"
#include "foreign/motion_fit.hpp"
#include "recording/local_plane.hpp"

namespace leeway::foreign {
namespace {

constexpr double kDifferent = 1.5;       // between the misfits of two frames that can be told apart
constexpr double kRudderVote = 0.5;      // of other channels' signs
constexpr double kLargestRadians = 2.1;  // of a rudder angle

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

class RoleFinder {
 public:
  RoleFinder(const RawTable& table, const std::vector<NamedColumn>& meanings, const FoundClock& clock)
      : table_(table), clock_(clock), windows_(clock.t) {
    if (meanings.empty())
      assign_by_kinematics();
    else
      assign_by_names(meanings);
  }

  Roles run() {
    find_positions();
    if (has(Channel::psi) && has(Channel::x0) && has(Channel::y0)) fit_positions();
    find_yaw_rate();
    find_rudders();
    vote_on_handedness();
    find_units();
    state_what_is_unknowable();
    return std::move(roles_);
  }

 private:
  bool has(Channel channel) const { return roles_.channels.contains(channel); }
  const std::vector<double>& values(Channel channel) const {
    return table_.columns[roles_.channels.at(channel).column];
  }
  void take(Channel channel, std::size_t column, const std::string& unit) {
    if (!table_.is_text(column)) roles_.channels.emplace(channel, RoleColumn{column, unit, 1.0});  // the first one
  }

  void assign_by_names(const std::vector<NamedColumn>& meanings) {
    bool has_velocities = false;
    for (std::size_t c = 0; c < meanings.size(); ++c) {
      const NamedColumn& named = meanings[c];
      if (named.meaning == Meaning::latitude || named.meaning == Meaning::longitude) {
        roles_.position = io::PositionForm::latitude_longitude;
        roles_.channels.erase(named.meaning == Meaning::latitude ? Channel::x0 : Channel::y0);
        take(named.meaning == Meaning::latitude ? Channel::x0 : Channel::y0, c, named.unit);
      }
      if (named.meaning != Meaning::channel || named.channel == Channel::t) continue;
      if (named.channel == Channel::u || named.channel == Channel::vm) has_velocities = true;
      if (named.is_earth) roles_.frame = io::VelocityFrame::earth;
      const bool is_position = named.channel == Channel::x0 || named.channel == Channel::y0;
      if (is_position && roles_.position == io::PositionForm::latitude_longitude) continue;
      take(named.channel, c, named.unit);
    }
    if (has_velocities && has(Channel::u) && has(Channel::vm)) return;
    roles_.channels.erase(Channel::u);
    roles_.channels.erase(Channel::vm);
    for (std::size_t c = 0; c < meanings.size(); ++c) {
      if (meanings[c].meaning == Meaning::speed) take(Channel::u, c, meanings[c].unit);
      if (meanings[c].meaning == Meaning::course) take(Channel::vm, c, meanings[c].unit);
    }
    if (has(Channel::u) && has(Channel::vm)) roles_.frame = io::VelocityFrame::course_and_speed;
    if (has(Channel::u) == has(Channel::vm)) return;
    roles_.channels.erase(Channel::u);
    roles_.channels.erase(Channel::vm);
  }

  void assign_by_kinematics() {
    std::vector<bool> taken(table_.columns.size());
    for (const std::size_t c : clock_.columns) taken[c] = true;
    for (std::size_t c = 0; c < taken.size(); ++c) taken[c] = taken[c] || table_.is_text(c);
    const AnonymousColumns found = recognize_columns(table_.columns, taken, clock_.t);
    for (const auto& [channel, column] :
         {std::pair{Channel::x0, found.x0}, std::pair{Channel::y0, found.y0}, std::pair{Channel::psi, found.psi},
          std::pair{Channel::u, found.u}, std::pair{Channel::vm, found.vm}, std::pair{Channel::r, found.r},
          std::pair{Channel::delta, found.delta}, std::pair{Channel::n_p, found.n_p}})
      if (column) take(channel, *column, "");
    roles_.frame = found.frame;
    is_anonymous_ = true;
  }

  void find_positions() {
    if (!has(Channel::x0) || !has(Channel::y0)) return;
    x0_ = values(Channel::x0);
    y0_ = values(Channel::y0);
    if (roles_.position == io::PositionForm::plane) return;
    for (const auto& [channel, angle] : {std::pair{Channel::x0, &x0_}, std::pair{Channel::y0, &y0_}})
      if (roles_.channels.at(channel).unit != "rad")
        for (double& x : *angle) x *= kDegree;
    lay_on_plane(x0_, y0_);
  }

  void fit_positions() {
    RoleColumn& psi = roles_.channels.at(Channel::psi);
    if (!has(Channel::u)) {
      const DirectionFit fit = fit_direction(windows_, x0_, y0_, values(Channel::psi), psi.unit);
      set(psi, fit.psi);
      is_tied_ = fit.misfit < 0.7;
      return;
    }
    MotionColumns columns{x0_,
                          y0_,
                          values(Channel::psi),
                          values(Channel::u),
                          values(Channel::vm),
                          psi.unit,
                          roles_.channels.at(Channel::u).unit,
                          roles_.channels.at(Channel::vm).unit,
                          {roles_.frame}};
    if (is_anonymous_)
      columns.frames = {io::VelocityFrame::ship, io::VelocityFrame::earth, io::VelocityFrame::course_and_speed};
    else if (roles_.frame != io::VelocityFrame::course_and_speed)  // names as vx, velocity_x are used for both
      columns.frames = {io::VelocityFrame::ship, io::VelocityFrame::earth};
    const MotionFit fit = fit_motion(windows_, columns);
    if (fit.misfit > kFits) {
      roles_.unknowable.push_back(
          fmt::format("positions, heading and velocities do not fit each other (misfit {:.0f} %): "
                      "their axes and signs are not known",
                      100.0 * fit.misfit));
      return;
    }
    roles_.frame = fit.frame;
    set(psi, fit.psi);
    set(roles_.channels.at(Channel::u), fit.u);
    set(roles_.channels.at(Channel::vm), fit.vm);
    is_tied_ = true;
    const char* frame = fit.frame == io::VelocityFrame::ship    ? "along the ship's axes"
                        : fit.frame == io::VelocityFrame::earth ? "along x0 and y0"
                                                                : "speed and course over ground";
    roles_.findings.push_back(
        fmt::format("velocities are {}: positions follow from them to {:.1f} %{}", frame, 100.0 * fit.misfit,
                    fit.other_frame ? fmt::format(", otherwise to {:.1f} %", 100.0 * *fit.other_frame) : ""));
    if (fit.other_frame && *fit.other_frame < kDifferent * fit.misfit)
      roles_.unknowable.push_back(
          "the ship hardly turns: whether velocities are along its axes or the earth's does not show");
  }

  static void set(RoleColumn& role, const Reading& reading) {
    role.unit = reading.unit;
    role.sign = reading.factor < 0.0 ? -1.0 : 1.0;
  }

  void find_yaw_rate() {
    if (!has(Channel::r) || !has(Channel::psi)) return;
    RoleColumn &psi = roles_.channels.at(Channel::psi), &r = roles_.channels.at(Channel::r);
    const YawFit fit = fit_yaw(windows_, values(Channel::psi), psi.unit, values(Channel::r), r.unit);
    if (fit.misfit > kFits) {
      roles_.unknowable.push_back(
          fmt::format("the yaw rate is not the heading's derivative (misfit {:.0f} %)", 100.0 * fit.misfit));
      return;
    }
    const double sign = psi.sign;
    if (psi.unit.empty() && largest_of(values(Channel::psi)) > 2.0 * kPi + 0.1) psi.unit = "deg";
    const YawFit known = fit_yaw(windows_, values(Channel::psi), psi.unit, values(Channel::r), r.unit);
    set(psi, known.psi);
    set(r, known.r);
    psi.sign = sign;
    r.sign *= sign;
    roles_.findings.push_back(
        fmt::format("r is the derivative of psi to {:.1f} %, in {} and {}", 100.0 * known.misfit, r.unit, psi.unit));
  }

  std::vector<double> yaw_rate() const {
    std::vector<double> rate;
    if (has(Channel::r)) {
      rate = values(Channel::r);
      for (double& x : rate) x *= roles_.channels.at(Channel::r).sign;
    }
    return rate;
  }

  void find_rudders() {
    const std::vector<double> rate = yaw_rate();
    for (const Channel channel : {Channel::delta, Channel::delta_p, Channel::delta_s}) {
      if (!has(channel)) continue;
      const RudderResponse response = rate.empty() ? RudderResponse{} : fit_rudder(windows_, rate, values(channel));
      if (response.significance < kSignificant) {
        roles_.unknowable.push_back(
            fmt::format("to which side {} turns the ship does not show in the yaw rate", info(channel).name));
        continue;
      }
      roles_.channels.at(channel).sign = response.b < 0.0 ? -1.0 : 1.0;
      roles_.findings.push_back(fmt::format("the yaw rate answers to {} by {:.0f} standard deviations",
                                            info(channel).name, response.significance));
    }
  }

  // A motion and its mirror image fit equally well: the one that leaves more signs as they are is meant.
  void vote_on_handedness() {
    if (roles_.position == io::PositionForm::latitude_longitude) return;
    double turned = 0.0, kept = 0.0;
    const auto vote = [&](Channel channel, double weight) {
      if (has(channel)) (roles_.channels.at(channel).sign < 0.0 ? turned : kept) += weight;
    };
    for (const Channel channel : {Channel::psi, Channel::r, Channel::vm}) vote(channel, 1.0);
    if (is_tied_) vote(Channel::y0, 1.0);
    for (const Channel channel : {Channel::delta, Channel::delta_p, Channel::delta_s}) vote(channel, kRudderVote);
    const bool is_heading_turned = has(Channel::psi) && roles_.channels.at(Channel::psi).sign < 0.0;
    if (turned < kept || (turned == kept && !is_heading_turned)) return;
    for (const Channel channel :
         {Channel::psi, Channel::r, Channel::vm, Channel::y0, Channel::delta, Channel::delta_p, Channel::delta_s})
      if (has(channel)) roles_.channels.at(channel).sign *= -1.0;
  }

  void guess_unit(Channel channel, const std::string& unit) {
    if (!has(channel) || !roles_.channels.at(channel).unit.empty()) return;
    roles_.channels.at(channel).unit = unit;
    roles_.unknowable.push_back(fmt::format("the unit of {} is taken to be {}", info(channel).name, unit));
  }

  void find_units() {
    if (has(Channel::psi)) guess_unit(Channel::psi, largest_of(values(Channel::psi)) > 2.0 * kPi + 0.1 ? "deg" : "rad");
    for (const Channel channel : {Channel::u, Channel::vm, Channel::wind_speed, Channel::app_wind_speed})
      guess_unit(channel, "mps");
    if (has(Channel::r)) guess_unit(Channel::r, largest_of(values(Channel::r)) > 0.3 ? "degps" : "radps");
    for (const Channel channel : {Channel::delta, Channel::delta_p, Channel::delta_s, Channel::wind_dir,
                                  Channel::app_wind_dir, Channel::az1, Channel::az2}) {
      if (!has(channel)) continue;
      const bool is_wind = channel == Channel::wind_dir || channel == Channel::app_wind_dir;
      const double limit = is_wind ? 2.0 * kPi + 0.1 : kLargestRadians;
      const bool is_clear = largest_of(values(channel)) > limit;
      RoleColumn& role = roles_.channels.at(channel);
      if (role.unit.empty() && is_clear) role.unit = "deg";
      guess_unit(channel, "rad");
    }
    for (const Channel channel : {Channel::n_p, Channel::n_bt, Channel::n_st, Channel::n_az1, Channel::n_az2}) {
      if (!has(channel) || !roles_.channels.at(channel).unit.empty()) continue;
      const double u = has(Channel::u) ? mean_speed() : 0.0, n = mean_of(values(channel));
      guess_unit(channel, u > 0.0 && n > 0.0 ? likely_revolutions(n, u) : "rps");
    }
  }

  double mean_speed() const {
    const RoleColumn& u = roles_.channels.at(Channel::u);
    const double factor = io::unit_of(Quantity::speed, u.unit)->factor;
    std::vector<double> speeds;
    for (std::size_t i = 0; i < table_.rows(); ++i)
      speeds.push_back(factor * (roles_.frame == io::VelocityFrame::course_and_speed || !has(Channel::vm)
                                     ? std::abs(values(Channel::u)[i])
                                     : std::hypot(values(Channel::u)[i], values(Channel::vm)[i])));
    return mean_of(speeds);
  }

  void state_what_is_unknowable() {
    std::vector<std::string>& notes = roles_.unknowable;
    if (has(Channel::psi) && roles_.position == io::PositionForm::plane)
      notes.push_back(
          "that the heading counts clockwise (y0 to starboard of x0) is assumed: the mirror image, all of "
          "psi, r, y0, vm and rudders with the other sign, fits as well");
    if (!is_tied_ && has(Channel::u))
      notes.push_back(
          "no position to compare with: whether velocities are over ground, along which axes and with which "
          "signs");
    notes.push_back(
        "to which point positions and velocities belong: midship is assumed, not an antenna or the center "
        "of gravity");
    if (has(Channel::delta) || has(Channel::delta_p) || has(Channel::n_p))
      notes.push_back("whether rudder and revolutions are actual values or orders: actual ones are assumed");
    if (has(Channel::u))
      notes.push_back(
          fmt::format("whether units are those of a model or of the ship: the mean speed is {:.3g} m/s as "
                      "they stand; \"scale_factor\" changes that",
                      mean_speed()));
    if (has(Channel::wind_dir) || has(Channel::app_wind_dir))
      notes.push_back("whether wind directions are where it comes from: that is assumed");
  }

  const RawTable& table_;
  const FoundClock& clock_;
  Windows windows_;
  Roles roles_;
  std::vector<double> x0_, y0_;  // [m]
  bool is_anonymous_ = false, is_tied_ = false;
};

}  // namespace

Roles find_roles(const RawTable& table, const std::vector<NamedColumn>& meanings, const FoundClock& clock) {
  return RoleFinder(table, meanings, clock).run();
}

}  // namespace leeway::foreign
