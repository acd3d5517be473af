#include "foreign/column_roles.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/units.hpp"
#include "foreign/anonymous_columns.hpp"
#include "foreign/motion_fit.hpp"
#include "foreign/rudder_fit.hpp"
#include "foreign/unit_guesses.hpp"
#include "recording/local_plane.hpp"

namespace leeway::foreign {
namespace {

constexpr double kDifferent = 1.5;    // between the misfits of two frames that can be told apart
constexpr double kRudderVote = 0.5;   // of other channels' signs
constexpr double kTwiceAsWell = 0.5;  // misfit of another reading that is meant, by that of the plain one
constexpr double kClearly = 0.1;      // misfit of a column whose name nobody understands
constexpr double kDirectionWeight = 0.3;
constexpr std::size_t kMostUnknown = 8, kMostRowsSearched = 20'000;

constexpr io::VelocityFrame kFrames[] = {io::VelocityFrame::ship, io::VelocityFrame::earth,
                                         io::VelocityFrame::course_and_speed};

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
    find_unnamed_heading();
    find_positions();
    find_unnamed_velocities();
    if (has(Channel::psi) && has(Channel::x0) && has(Channel::y0)) fit_positions();
    find_yaw_rate();
    find_rudders();
    vote_on_handedness();
    leave_own_names();
    const std::vector<double> speed = speeds();
    guess_units(roles_, values_, speed);
    if (has(Channel::u)) mean_speed_ = mean_of(speed) * io::unit_of(Quantity::speed, role(Channel::u).unit)->factor;
    state_what_is_unknowable();
    return std::move(roles_);
  }

 private:
  bool has(Channel channel) const { return roles_.channels.contains(channel); }
  const std::vector<double>& values(Channel channel) const { return values_.at(channel); }
  RoleColumn& role(Channel channel) { return roles_.channels.at(channel); }
  void take(Channel channel, std::size_t column, const NamedColumn& named) {
    if (table_.is_text(column) || has(channel)) return;  // the first one
    roles_.channels.emplace(channel, RoleColumn{column, named.unit, 1.0, named.scale, named.is_own});
    std::vector<double> scaled = table_.columns[column];
    for (double& x : scaled) x *= named.scale;
    values_[channel] = std::move(scaled);
  }
  void drop(Channel channel) {
    roles_.channels.erase(channel);
    values_.erase(channel);
  }
  void exchange(Channel a, Channel b) {
    std::swap(role(a), role(b));
    std::swap(values_.at(a), values_.at(b));
  }
  std::string name_of(std::size_t column) const {
    return column < table_.names.size() ? table_.names[column] : fmt::format("{}", column + 1);
  }

  void assign_by_names(const std::vector<NamedColumn>& meanings) {
    bool has_velocities = false;
    for (std::size_t c = 0; c < meanings.size(); ++c) {
      const NamedColumn& named = meanings[c];
      if (!named.foreign_unit.empty() && named.meaning != Meaning::other) note_unit(c, named);
      if (named.meaning == Meaning::unknown && !table_.is_text(c) && largest_of(table_.columns[c]) > 0.0)
        unknown_.push_back(c);
      if (named.meaning == Meaning::latitude || named.meaning == Meaning::longitude) {
        roles_.position = io::PositionForm::latitude_longitude;
        drop(named.meaning == Meaning::latitude ? Channel::x0 : Channel::y0);
        take(named.meaning == Meaning::latitude ? Channel::x0 : Channel::y0, c, named);
      }
      if (named.meaning != Meaning::channel || named.channel == Channel::t) continue;
      if (named.channel == Channel::u || named.channel == Channel::vm) has_velocities = true;
      if (named.is_earth) roles_.frame = io::VelocityFrame::earth;
      const bool is_position = named.channel == Channel::x0 || named.channel == Channel::y0;
      if (is_position && roles_.position == io::PositionForm::latitude_longitude) continue;
      take(named.channel, c, named);
    }
    if (has_velocities && has(Channel::u) && has(Channel::vm)) return;
    drop(Channel::u);
    drop(Channel::vm);
    for (std::size_t c = 0; c < meanings.size(); ++c) {
      if (meanings[c].meaning == Meaning::speed) take(Channel::u, c, meanings[c]);
      if (meanings[c].meaning == Meaning::course) take(Channel::vm, c, meanings[c]);
    }
    if (has(Channel::u) && has(Channel::vm)) roles_.frame = io::VelocityFrame::course_and_speed;
    if (has(Channel::u) == has(Channel::vm)) return;
    drop(Channel::u);
    drop(Channel::vm);
  }

  void note_unit(std::size_t column, const NamedColumn& named) {
    roles_.unknowable.push_back(named.meaning == Meaning::unknown && is_unit(named.foreign_unit)
                                    ? fmt::format("column '{}' is not what its name says: that is not measured in {}",
                                                  name_of(column), named.foreign_unit)
                                    : fmt::format("the unit '{}' of column '{}' is none that is known: give \"scale\"",
                                                  named.foreign_unit, name_of(column)));
  }

  // What is searched among columns whose names say nothing.
  std::vector<std::size_t> unknown() const {
    std::vector<std::size_t> left;
    for (const std::size_t c : unknown_)
      if (std::none_of(roles_.channels.begin(), roles_.channels.end(),
                       [&](const auto& taken) { return taken.second.column == c; }))
        left.push_back(c);
    return left.size() > kMostUnknown || table_.rows() > kMostRowsSearched ? std::vector<std::size_t>{} : left;
  }

  void take_by_kinematics(Channel channel, std::size_t column) {
    take(channel, column, {});
    roles_.findings.push_back(
        fmt::format("column '{}' is taken to be {} by the kinematics alone", name_of(column), info(channel).name));
  }

  // A heading and a yaw rate whose names say nothing: one is the derivative of the other.
  void find_unnamed_heading() {
    if (has(Channel::psi) && has(Channel::r)) return;
    const std::vector<std::size_t> left = unknown();
    double best = kClearly;
    std::optional<std::size_t> psi, r;
    const auto compare = [&](std::optional<std::size_t> p, std::optional<std::size_t> q) {
      if (p && q && *p == *q) return;
      const double misfit =
          fit_yaw(windows_, p ? table_.columns[*p] : values(Channel::psi), p ? "" : role(Channel::psi).unit,
                  q ? table_.columns[*q] : values(Channel::r), q ? "" : role(Channel::r).unit)
              .misfit;
      if (misfit >= best) return;
      best = misfit;
      psi = p;
      r = q;
    };
    for (const std::size_t p : left)
      if (has(Channel::psi))
        compare(std::nullopt, p);
      else if (has(Channel::r))
        compare(p, std::nullopt);
      else
        for (const std::size_t q : left) compare(p, q);
    if (psi) take_by_kinematics(Channel::psi, *psi);
    if (r) take_by_kinematics(Channel::r, *r);
  }

  void find_unnamed_velocities() {
    if (has(Channel::u) || !has(Channel::psi) || !has(Channel::x0) || !has(Channel::y0)) return;
    double best = kClearly;
    std::optional<std::size_t> u, vm;
    const std::vector<std::size_t> left = unknown();
    for (const std::size_t a : left)
      for (const std::size_t b : left) {
        if (a == b) continue;
        MotionColumns columns{x0_,
                              y0_,
                              values(Channel::psi),
                              table_.columns[a],
                              table_.columns[b],
                              role(Channel::psi).unit,
                              "",
                              "",
                              {kFrames[0], kFrames[1], kFrames[2]}};
        const MotionFit fit = fit_motion(windows_, columns);
        if (fit.misfit >= best) continue;
        best = fit.misfit;
        u = a;
        vm = b;
        roles_.frame = fit.frame;
      }
    if (!u) return;
    take_by_kinematics(Channel::u, *u);
    take_by_kinematics(Channel::vm, *vm);
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
      if (column) take(channel, *column, {});
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

  // A fit with x0 and y0 as they are named, or exchanged, and how far it is off.
  struct PlaneFit {
    MotionFit motion;
    DirectionFit direction;
    double misfit = 1e9;
  };
  PlaneFit fit_plane(bool is_exchanged) const {
    PlaneFit plane;
    const std::vector<double>&north = is_exchanged ? y0_ : x0_, &east = is_exchanged ? x0_ : y0_;
    const RoleColumn& psi = roles_.channels.at(Channel::psi);
    plane.direction = fit_direction(windows_, north, east, values(Channel::psi), psi.unit);
    plane.misfit = plane.direction.misfit;
    if (!has(Channel::u)) return plane;
    std::vector<io::VelocityFrame> frames{roles_.frame};
    if (is_anonymous_)
      frames.assign(std::begin(kFrames), std::end(kFrames));
    else if (roles_.channels.at(Channel::u).is_own)
      frames = {io::VelocityFrame::ship};
    else if (roles_.frame != io::VelocityFrame::course_and_speed)  // names as vx, velocity_x are used for both
      frames = {io::VelocityFrame::ship, io::VelocityFrame::earth};
    const auto fit = [&](const std::vector<io::VelocityFrame>& among, Channel u, Channel vm) {
      return fit_motion(windows_, {north, east, values(Channel::psi), values(u), values(vm), psi.unit,
                                   roles_.channels.at(u).unit, roles_.channels.at(vm).unit, among});
    };
    if (!is_exchanged) {
      plane.motion = fit(frames, Channel::u, Channel::vm);
    } else {  // velocities along the earth's axes are exchanged with these
      const auto earth = std::find(frames.begin(), frames.end(), io::VelocityFrame::earth);
      const bool has_earth = earth != frames.end();
      if (has_earth) frames.erase(earth);
      if (!frames.empty()) plane.motion = fit(frames, Channel::u, Channel::vm);
      if (has_earth)
        if (MotionFit other = fit({io::VelocityFrame::earth}, Channel::vm, Channel::u);
            other.misfit < plane.motion.misfit) {
          other.other_frame = plane.motion.misfit;
          plane.motion = std::move(other);
        }
    }
    const bool shows_heading = plane.motion.frame != io::VelocityFrame::earth;
    plane.misfit = plane.motion.misfit + (shows_heading ? 0.0 : kDirectionWeight * plane.direction.misfit);
    return plane;
  }

  void exchange_axes(const PlaneFit& plane) {
    std::swap(x0_, y0_);
    exchange(Channel::x0, Channel::y0);
    if (has(Channel::u) && plane.motion.frame == io::VelocityFrame::earth) exchange(Channel::u, Channel::vm);
    roles_.findings.push_back(
        fmt::format("x0 is column '{}' and y0 column '{}': the heading counts clockwise from the former",
                    name_of(role(Channel::x0).column), name_of(role(Channel::y0).column)));
  }

  void fit_positions() {
    RoleColumn& psi = role(Channel::psi);
    PlaneFit plane = fit_plane(false);
    if (roles_.position == io::PositionForm::plane && !role(Channel::x0).is_own && !is_anonymous_)
      if (PlaneFit other = fit_plane(true);
          other.misfit < kTwiceAsWell * plane.misfit && (!has(Channel::u) || other.motion.misfit < kFits)) {
        exchange_axes(other);
        plane = std::move(other);
      }
    if (!has(Channel::u)) {
      set(psi, plane.direction.psi);
      is_tied_ = plane.direction.misfit < 0.7;
      return;
    }
    const MotionFit& fit = plane.motion;
    roles_.misfit = fit.misfit;
    if (fit.misfit > kFits) {
      roles_.unknowable.push_back(
          fmt::format("positions, heading and velocities do not fit each other (misfit {:.0f} %): "
                      "their axes and signs are not known",
                      100.0 * fit.misfit));
      return;
    }
    roles_.frame = fit.frame;
    set(psi, fit.psi);
    set(role(Channel::u), fit.u);
    set(role(Channel::vm), fit.vm);
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
    if (!roles_.misfit) roles_.misfit = fit.misfit;
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

  // Positive to starboard: as recorded, or by differences of the heading.
  std::vector<double> yaw_rate() const {
    if (!has(Channel::r) && !has(Channel::psi)) return {};
    const RoleColumn& column = roles_.channels.at(has(Channel::r) ? Channel::r : Channel::psi);
    std::vector<double> rate = values(has(Channel::r) ? Channel::r : Channel::psi);
    for (double& x : rate) x *= column.sign;
    if (has(Channel::r)) return rate;
    const bool is_deg = column.unit == "deg" || (column.unit.empty() && largest_of(rate) > 2.0 * kPi + 0.1);
    const std::vector<double> heading = heading_in_rad(rate, {"", is_deg ? kDegree : 1.0});
    for (std::size_t i = 0; i < rate.size(); ++i) {
      const std::size_t a = i > 0 ? i - 1 : 0, b = std::min(i + 1, rate.size() - 1);
      rate[i] = (heading[b] - heading[a]) / (clock_.t[b] - clock_.t[a]);
    }
    return rate;
  }

  std::vector<double> speeds() const {
    if (!has(Channel::u)) return {};
    std::vector<double> all = values(Channel::u);
    if (roles_.frame != io::VelocityFrame::course_and_speed && has(Channel::vm))
      for (std::size_t i = 0; i < all.size(); ++i) all[i] = std::hypot(all[i], values(Channel::vm)[i]);
    return all;
  }

  void find_rudders() {
    const std::vector<double> rate = yaw_rate(), speed = speeds();
    std::vector<Channel> rudders;
    SteeringColumns steering{clock_.t, rate, speed, {}, {}};
    for (const Channel channel : {Channel::delta, Channel::delta_p, Channel::delta_s})
      if (has(channel)) {
        rudders.push_back(channel);
        steering.rudders.emplace_back(values(channel));
      }
    for (const Channel channel : {Channel::n_bt, Channel::n_st})
      if (has(channel)) steering.thrusters.emplace_back(values(channel));
    if (rudders.empty()) return;
    std::vector<RudderResponse> responses(rudders.size());
    if (!rate.empty()) responses = fit_rudders(windows_, steering);
    const bool is_alone = rudders.size() == 1 && steering.thrusters.empty();
    for (std::size_t k = 0; k < rudders.size(); ++k) {
      const RudderResponse& response = responses[k];
      const std::string_view name = info(rudders[k]).name;
      const double side = response.side(is_alone);
      if (response.is_contradictory())
        roles_.findings.push_back(
            fmt::format("{}: the yaw rate answers to it otherwise than the ship turns while it is held", name));
      if (side == 0.0) {
        roles_.unknowable.push_back(fmt::format("to which side {} turns the ship does not show in the yaw rate", name));
        continue;
      }
      role(rudders[k]).sign = side;
      if (response.significance >= kSignificant)
        roles_.findings.push_back(
            fmt::format("the yaw rate answers to {} by {:.0f} standard deviations", name, response.significance));
      if (std::abs(response.held) >= kClearSide)
        roles_.findings.push_back(fmt::format("{:.0f} % of the turning while {} is held goes to one side of it",
                                              50.0 * (1.0 + std::abs(response.held)), name));
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

  // Leeway's own names are never turned: a contradiction may as well be the file's.
  void leave_own_names() {
    for (auto& [channel, column] : roles_.channels) {
      if (!column.is_own || column.sign > 0.0) continue;
      column.sign = 1.0;
      roles_.unknowable.push_back(
          fmt::format("'{}' has leeway's own name and is left as it stands, but its sign contradicts the other columns",
                      name_of(column.column)));
    }
  }

  void state_what_is_unknowable() {
    std::vector<std::string>& notes = roles_.unknowable;
    if (has(Channel::psi) && roles_.position == io::PositionForm::plane)
      notes.push_back(
          "that the heading counts clockwise (y0 to starboard of x0) is assumed: the mirror image, all of "
          "psi, r, y0, vm and rudders with the other sign, fits as well");
    if (has(Channel::u) && (!has(Channel::x0) || !has(Channel::y0)))
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
                      mean_speed_));
    for (const Channel channel : {Channel::n_bt, Channel::n_st})
      if (has(channel))
        notes.push_back(
            fmt::format("to which side {} pushes: positive revolutions to starboard are assumed", info(channel).name));
    if (has(Channel::wind_dir) || has(Channel::app_wind_dir))
      notes.push_back("whether wind directions are where it comes from: that is assumed");
  }

  const RawTable& table_;
  const FoundClock& clock_;
  Windows windows_;
  Roles roles_;
  ChannelValues values_;              // in the unit, by the scale
  std::vector<std::size_t> unknown_;  // columns whose names say nothing
  std::vector<double> x0_, y0_;       // [m]
  double mean_speed_ = 0.0;           // [m/s]
  bool is_anonymous_ = false, is_tied_ = false;
};

}  // namespace

Roles find_roles(const RawTable& table, const std::vector<NamedColumn>& meanings, const FoundClock& clock) {
  return RoleFinder(table, meanings, clock).run();
}

}  // namespace leeway::foreign
