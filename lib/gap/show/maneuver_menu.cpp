#include "gap/show/maneuver_menu.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "core/errors.hpp"
#include "core/random.hpp"
#include "core/units.hpp"
#include "dynamics/straight_run.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {
namespace {

class Menu {
 public:
  Menu(const Ship& ship, double time_scale, const NextLimits& limits)
      : ship_(ship), time_scale_(time_scale), limits_(limits) {}

  std::vector<MenuItem> made() {
    under_way(1.0);
    under_way(policy.low_speed);
    u_mps_ = n_rps_ = 0.0;
    if (has_thruster()) add("thruster pulses at rest", "thruster-pulses", policy.orders_s, {pulses()});
    if (const double least = ship_.propulsion().empty() ? 0.0 : ship_.propulsion().front().min; least < 0.0) {
      const double astern = std::max(least, -ship_.propulsion().front().initial);
      u_mps_ = 0.0, n_rps_ = astern;
      add("astern from rest, rudders amidships",
          fmt::format("turning --rudder-deg 0 --u0-mps 0 --n-p-rps {:.4g}", astern), policy.stopping_s, {turn(0.0)});
    }
    return std::move(items_);
  }

 private:
  static constexpr const ShowPolicy& policy = kPolicy.show;

  // A rudder angle [deg] that the limits allow.
  double within(double deg) const { return std::min(deg, limits_.rudder_deg.value_or(deg)); }

  static ManeuverRun turn(double rudder_rad) {
    return {0.0, [=](const SimulatedShip& s) { return turning(s.ship, rudder_rad); }};
  }
  static ManeuverRun straight_at(double heading) {
    return {heading, [](const SimulatedShip& s) { return straight(s.ship, course_keeper(s)); }};
  }
  static ManeuverRun pulses() {
    return {0.0, [](const SimulatedShip& at) { return thruster_pulses(at, thruster_pulses_for(at.ship)); }};
  }
  bool has_thruster() const {
    return std::ranges::any_of(
        ship_.actuators, [](const Actuator& a) { return a.channel == Channel::n_bt || a.channel == Channel::n_st; });
  }

  void add(const std::string& name, const std::string& command, double each_s, std::vector<ManeuverRun> runs) {
    items_.push_back({name, command, u_mps_, n_rps_, each_s * time_scale_, std::move(runs)});
  }

  void add_zigzag(double deg, const std::string& at, const std::string& speed, double each_s) {
    add(fmt::format("a zigzag {0}/{0}{1}", deg, at),
        fmt::format("zigzag --rudder-deg {0} --heading-deg {0}{1}", deg, speed), each_s,
        {{0.0, [deg](const SimulatedShip& s) { return zigzag(s.ship, deg * kDegree, deg * kDegree); }}});
  }

  // Maneuvers that begin on a straight course.
  //   share  of the usual speed; at a lower one they last longer, and those that tell little more are left out
  void under_way(double share) {
    u_mps_ = share * ship_.u0_mps;
    try {
      n_rps_ = self_propulsion_n(ship_, u_mps_);
    } catch (const NumericalError&) {  // the propeller cannot hold it
      return;
    }
    const bool is_usual = share == 1.0;
    const std::string at = is_usual ? "" : fmt::format(", at {:.0f} % speed", 100.0 * share),
                      u0 = is_usual ? "" : fmt::format(" --u0-mps {:.4g}", u_mps_),
                      speed = is_usual ? "" : fmt::format("{} --n-p-rps {:.4g}", u0, n_rps_);
    const double turned_deg = within(policy.turning_rudder_deg);
    add("a straight run and its reciprocal" + at, "straight" + u0, policy.straight_s / share,
        {straight_at(0.0), straight_at(kPi)});
    add(fmt::format("turning circles, {} deg to both sides{}", turned_deg, at),
        fmt::format("turning --rudder-deg {}{}", turned_deg, speed), policy.turning_s / share,
        {turn(turned_deg * kDegree), turn(-turned_deg * kDegree)});
    const double small_deg = within(10.0), large_deg = within(20.0);
    if (is_usual) add_zigzag(small_deg, at, speed, policy.zigzag_s);
    if (!is_usual || large_deg > small_deg) add_zigzag(large_deg, at, speed, policy.zigzag_s / share);
    if (has_thruster())
      add("thruster pulses" + (is_usual ? " under way" : at), fmt::format("thruster-pulses --u0-mps {:.4g}", u_mps_),
          policy.orders_s, {pulses()});
    if (is_usual) add_of_usual_speed();
  }

  void add_of_usual_speed() {
    const double pulled_deg = within(policy.pull_out_rudder_deg);
    add("a coast-down with stopped propeller", "coast-down", policy.stopping_s,
        {{0.0, [](const SimulatedShip& s) { return coast_down(s); }}});
    add("a crash stop", "crash-stop", policy.stopping_s, {{0.0, [](const SimulatedShip& s) { return crash_stop(s); }}});
    add("a pull-out", fmt::format("pull-out --rudder-deg {}", pulled_deg), policy.pull_out_s,
        {{0.0, [=](const SimulatedShip& s) { return pull_out(s, pulled_deg * kDegree); }}});
    add("random orders to all actuators", "random", policy.orders_s,
        {{0.0, [](const SimulatedShip& s) { return random_orders(s.ship, RandomStream(1, "next-maneuver")); }}});
  }

  const Ship& ship_;
  const double time_scale_;
  const NextLimits& limits_;
  double u_mps_ = 0.0, n_rps_ = 0.0;  // at the start of what is added
  std::vector<MenuItem> items_;
};

}  // namespace

std::vector<MenuItem> maneuver_menu(const Ship& ship, double time_scale, const NextLimits& limits) {
  return Menu(ship, time_scale, limits).made();
}

}  // namespace leeway::gap
