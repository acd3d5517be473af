#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cli/simulator.hpp"
#include "core/errors.hpp"
#include "core/units.hpp"
#include "dynamics/berthing.hpp"
#include "dynamics/phased_maneuvers.hpp"
#include "dynamics/port_navigation.hpp"
#include "dynamics/run_notices.hpp"
#include "dynamics/schedule.hpp"
#include "dynamics/straight_run.hpp"

namespace leeway::cli {
namespace {

// Of maneuvers that do not end by themselves: 200 s of a 3 m ship, and no less.
double usual_duration_s(const Ship& ship) {
  return std::max(200.0, 360.0 * std::sqrt(ship.particulars.L_pp / kGravity_mps2));
}

// What all maneuvers share; the defaults as --help shows them.
struct Defaults {
  const char *duration_s = "200, or 360 sqrt(L_pp/g) where that is longer", *u0_mps = "the ship's u0_mps",
             *n_p_rps = "the ship's initial_rps";
};
void add_maneuver_options(CLI::App& sub, SimOptions& opt, const Defaults& defaults = {}) {
  add_ship_and_steps(sub, opt);
  sub.add_option("--duration-s", opt.duration_s, "length of the run, a multiple of --sample-s [s]")
      ->check(positive())
      ->default_str(defaults.duration_s);
  sub.add_option("--u0-mps", opt.u0_mps, "surge at the start, through the water [m/s]")
      ->check(in_range(-50.0, 50.0))
      ->default_str(defaults.u0_mps);
  sub.add_option("--n-p-rps", opt.n_p_rps, "propeller revolutions, at the start and ordered [1/s]")
      ->check(in_range(-1000.0, 1000.0))
      ->default_str(defaults.n_p_rps);
  sub.add_option("--wind-speed-mps", opt.wind_speed_mps, "true wind speed [m/s]")
      ->check(in_range(0.0, 200.0))
      ->capture_default_str();
  sub.add_option("--wind-dir-deg", opt.wind_dir_deg, "direction that the true wind comes from, 0: from +x0 [deg]")
      ->check(in_range(-360.0, 360.0))
      ->capture_default_str();
  sub.add_option("--wind", opt.wind,
                 "steady, or stochastic about the given speed and direction, by a process that follows --seed")
      ->check(CLI::IsMember({"steady", "stochastic"}))
      ->capture_default_str();
  add_noise(sub, opt);
  add_indices(sub, opt);
  add_output(sub, opt, "trajectory (CSV), '-' for stdout");
}

void add_rudder(CLI::App& sub, double& rudder_deg) {
  sub.add_option("--rudder-deg", rudder_deg,
                 "rudder angle, both rudders where there are two; negative: to port first [deg]")
      ->check(in_range(-180.0, 180.0))
      ->capture_default_str();
}

WindProcess wind_of(const SimOptions& opt) {
  const double direction = deg_to_rad(opt.wind_dir_deg);
  if (opt.wind == "stochastic")
    return WindProcess::stochastic(opt.wind_speed_mps, direction, {opt.common.seed, "stochastic wind"});
  return WindProcess::steady(opt.wind_speed_mps, direction);
}

// A positive rudder angle, for maneuvers that turn to both sides.
void add_rudder_to_both_sides(CLI::App& sub, double& rudder_deg) {
  sub.add_option("--rudder-deg", rudder_deg, "largest rudder angle, both rudders where there are two [deg]")
      ->check(in_range(0.1, 180.0))
      ->capture_default_str();
}

void add_hold(CLI::App& sub, SimOptions& opt) {
  sub.add_option("--hold-s", opt.hold_s, "longest time at one rudder angle; it is left when the turn is steady [s]")
      ->check(positive())
      ->default_str("60 L_pp/u0");
}

double u0_of(const Ship& ship, const SimOptions& opt) { return opt.u0_mps.value_or(ship.u0_mps); }

// A maneuver that is to begin steadily where the user has not given the revolutions.
SimulatedShip balanced_start(const Ship& ship, const SimOptions& opt, double u_mps) {
  if (opt.n_p_rps || u_mps <= 0.0) {
    SimulatedShip start(ship, u_mps);
    ship.order_propulsion(0.0, start.actuators);
    return start;
  }
  return steady_ahead(ship, u_mps);
}

// A berthing starts on its plan, and with the user's speed and revolutions where they are given.
BerthingPlan berthing_plan(const Ship& ship, const SimOptions& opt) {
  BerthingPlan plan = draw_berthing(ship, {opt.common.seed, "berthing plan"});
  if (opt.u0_mps) plan.steering.u0_mps = *opt.u0_mps;
  return plan;
}

double port_navigation_s(const Ship& ship, const SimOptions& opt) {
  return opt.duration_s.value_or(usual_port_navigation_s(ship));
}

PortPlan port_plan(const Ship& ship, const SimOptions& opt) {
  PortPlan plan = draw_port_navigation(ship, port_navigation_s(ship, opt), {opt.common.seed, "port navigation plan"});
  if (opt.u0_mps) plan.steering.u0_mps = *opt.u0_mps;
  return plan;
}

// The wind of a pilot's run is drawn unless the command line says something of it.
SimOptions with_wind(const SimOptions& opt, const CLI::App& sub) {
  SimOptions result = opt;
  if (sub.count("--wind") + sub.count("--wind-speed-mps") + sub.count("--wind-dir-deg") > 0) return result;
  const MeanWind mean = draw_mean_wind(read_ship_with_effects(opt), {opt.common.seed, "mean wind"});
  result.wind = "stochastic";
  result.wind_speed_mps = mean.speed_mps;
  result.wind_dir_deg = rad_to_deg(mean.direction);
  return result;
}

SimulatedShip start_of(const Ship& ship, const SimOptions& opt, const std::string& maneuver) {
  SimulatedShip start = maneuver == "straight"          ? balanced_start(ship, opt, u0_of(ship, opt))
                        : maneuver == "thruster-pulses" ? balanced_start(ship, opt, opt.u0_mps.value_or(0.0))
                        : maneuver == "berthing"        ? ship_at_start(ship, berthing_plan(ship, opt).steering)
                        : maneuver == "port-navigation" ? ship_at_start(ship, port_plan(ship, opt).steering)
                                                        : SimulatedShip(ship, u0_of(ship, opt));
  if (!opt.n_p_rps) return start;
  if (ship.propulsion().front().clip(*opt.n_p_rps) != *opt.n_p_rps)
    throw UsageError(fmt::format("--n-p-rps {} is outside the limits of the ship '{}'", *opt.n_p_rps, ship.name));
  ship.order_propulsion(*opt.n_p_rps, start.actuators);
  return start;
}

// What a maneuver's subcommand adds to the indices' facts.
ManeuverFacts facts_of(const SimOptions& opt, const std::string& maneuver) {
  ManeuverFacts facts{maneuver, 0.0, 0.0, {}, opt.wind_speed_mps};
  if (maneuver == "turning") facts.rudder = deg_to_rad(opt.turning_rudder_deg);
  if (maneuver == "zigzag") {
    facts.rudder = deg_to_rad(opt.zigzag_rudder_deg);
    facts.heading = opt.heading_deg > 0.0 ? deg_to_rad(opt.heading_deg) : std::abs(facts.rudder);
  }
  return facts;
}

// The plan of a maneuver that a pilot steers, null for another one; with it the facts have the heading of the quay.
io::Json plan_of(const Ship& ship, const SimOptions& opt, ManeuverFacts& facts) {
  if (facts.maneuver == "berthing") {
    const BerthingPlan plan = berthing_plan(ship, opt);
    facts.heading = plan.quay_heading;
    return to_json(plan);
  }
  if (facts.maneuver == "port-navigation") {
    const PortPlan plan = port_plan(ship, opt);
    facts.heading = plan.quay_heading;
    return to_json(plan);
  }
  return {};
}

// What the run does not do although it was asked for, or hardly as it was meant.
void warn_of_run(const SimulatedShip& start, const SimOptions& opt, const std::string& maneuver) {
  const Ship& ship = start.ship;
  const std::vector<Actuator> propulsion = ship.propulsion();
  const bool is_piloted = maneuver == "berthing" || maneuver == "port-navigation";
  // Revolutions that the maneuver orders anew hold nothing.
  const bool orders_revolutions = maneuver == "schedule" || maneuver == "coast-down" ||
                                  (maneuver == "random" && std::ranges::any_of(propulsion, &Actuator::is_random));
  if (!propulsion.empty() && !orders_revolutions)
    if (const auto notice =
            speed_notice(ship, start.surge_through_water(), start.actuators[propulsion.front().channel], is_piloted))
      warn_all({*notice});
  if (const auto notice = wind_notice(ship, opt.wind_speed_mps)) warn_all({*notice});
  if (opt.wind_speed_mps == 0.0 && (opt.wind_dir_deg != 0.0 || opt.wind == "stochastic"))
    warn_all({"there is no wind: its speed (--wind-speed-mps) is 0"});
  const double turning = deg_to_rad(opt.turning_rudder_deg), zigzag = deg_to_rad(opt.zigzag_rudder_deg);
  if (maneuver == "turning") warn_all(rudder_notices(ship, {turning}));
  if (maneuver == "zigzag") warn_all(rudder_notices(ship, {zigzag, -zigzag}));
}

// The ship at the start outlives the maneuver.
using MakeManeuver = std::unique_ptr<Maneuver> (*)(const SimulatedShip& start, const SimOptions&);

void run_maneuver(const CLI::App& app, const std::string& name, const SimOptions& opt, MakeManeuver make) {
  TimeGrid grid = opt.grid;
  grid.duration_s = opt.duration_s.value_or(grid.sample_s);
  grid.check();
  check_outputs(opt);
  Ship ship = read_ship_with_effects(opt);
  if (opt.n_p_rps)
    for (Actuator& actuator : ship.actuators)  // ordered revolutions stay, also in a random run
      if (actuator.is_propulsion()) actuator.is_random = false;
  const SimulatedShip start = start_of(ship, opt, name);
  const auto maneuver = make(start, opt);
  warn_of_run(start, opt, name);
  const double longest_s = maneuver->longest_s().value_or(usual_duration_s(ship));
  if (!opt.duration_s) grid.duration_s = grid.sample_s * std::ceil(longest_s / grid.sample_s - 1e-9);
  grid.check();
  Trajectory every_step;
  const Trajectory truth =
      simulate(start, *maneuver, wind_of(opt), grid, Integrator::rk4, opt.indices.empty() ? nullptr : &every_step);
  begin_outputs(opt);
  if (!opt.indices.empty()) {
    ManeuverFacts facts = facts_of(opt, name);
    facts.phases = maneuver->phases();
    const io::Json plan = plan_of(ship, opt, facts);
    io::Json conditions{{"u0_mps", start.surge_through_water()},
                        {"n_p_rps", start.actuators[ship.propulsion().front().channel]}};
    if (facts.rudder != 0.0) conditions["rudder_deg"] = rad_to_deg(facts.rudder);
    if (facts.heading != 0.0 && plan.is_null()) conditions["heading_deg"] = rad_to_deg(facts.heading);
    if (!plan.is_null()) conditions["plan"] = plan;
    conditions["wind"] = {{"kind", opt.wind}, {"speed_mps", opt.wind_speed_mps}, {"dir_deg", opt.wind_dir_deg}};
    if (!ship.effects.empty()) {
      conditions["effects"] = io::Json::array();
      for (const EffectEntry& effect : ship.effects) conditions["effects"].push_back(effect.type);
    }
    conditions["dt_s"] = grid.dt_s;
    write_indices(app, opt, ship, every_step, facts, std::move(conditions));
  }
  write_result(app, opt, ship, truth);
}

using Start = const SimulatedShip&;
using Options = const SimOptions&;
constexpr const char* kUntilDone = "until it is done";

// The subcommands that are there so far.
struct Commands {
  CLI::App& app;
  SimOptions& opt;
  std::vector<Command> all;

  CLI::App* add(const char* name, const char* description, const Defaults& defaults, MakeManeuver make) {
    CLI::App* sub = app.add_subcommand(name, description);
    add_maneuver_options(*sub, opt, defaults);
    all.push_back({sub, [&app = app, &opt = opt, name, make] { run_maneuver(app, name, opt, make); }});
    return sub;
  }

  // The last one's wind is drawn where the command line says nothing of it.
  void draw_wind(const CLI::App& sub) {
    all.back().run = [&sub, run = all.back().run, &opt = opt] {
      opt = with_wind(opt, sub);
      run();
    };
  }
};

void add_zigzag(Commands& commands, SimOptions& opt) {
  CLI::App* sub = commands.add("zigzag", "zigzag test", {}, [](Start start, Options o) {
    const ManeuverFacts facts = facts_of(o, "zigzag");
    return zigzag(start.ship, facts.rudder, facts.heading);
  });
  add_rudder(*sub, opt.zigzag_rudder_deg);
  sub->add_option("--heading-deg", opt.heading_deg, "change of heading at which the rudder is put over [deg]")
      ->check(in_range(0.01, 180.0))
      ->default_str("|rudder-deg|");
}

void add_turning(Commands& commands, SimOptions& opt) {
  CLI::App* sub = commands.add("turning", "turning circle", {}, [](Start start, Options o) {
    return turning(start.ship, deg_to_rad(o.turning_rudder_deg));
  });
  add_rudder(*sub, opt.turning_rudder_deg);
}

void add_random(Commands& commands) {
  commands.add("random", "random orders, distributed as the ship's JSON says", {}, [](Start start, Options o) {
    return random_orders(start.ship, {o.common.seed, "random orders"});
  });
}

void add_berthing(Commands& commands) {
  CLI::App* sub =
      commands.add("berthing",
                   "a berthing as a pilot steers it with VecTwin rudders and bow thruster, by --seed; "
                   "so is the wind, unless one of its options is given",
                   {.duration_s = "450 sqrt(L_pp/g)", .u0_mps = "drawn, 0.2 to 0.4 at 3 m; 0 at a quay"},
                   [](Start start, Options o) {
                     return berthing(start.ship, berthing_plan(start.ship, o), {o.common.seed, "berthing pilot"});
                   });
  commands.draw_wind(*sub);
}

void add_port_navigation(Commands& commands) {
  CLI::App* sub = commands.add(
      "port-navigation",
      "from entering a port to the berth, as a pilot steers it with VecTwin rudders together and bow thruster, by "
      "--seed; so is the wind, unless one of its options is given",
      {.duration_s = "320 sqrt(L_pp/g)", .u0_mps = "drawn, 0.39 to 0.51 at 3 m"}, [](Start start, Options o) {
        return port_navigation(start.ship, port_plan(start.ship, o), port_navigation_s(start.ship, o),
                               {o.common.seed, "port navigation pilot"});
      });
  commands.draw_wind(*sub);
}

void add_pull_out(Commands& commands, SimOptions& opt) {
  CLI::App* sub =
      commands.add("pull-out", "turn to starboard, amidships, turn to port, amidships: which yaw rates remain?",
                   {.duration_s = kUntilDone}, [](Start start, Options o) {
                     return pull_out(start, deg_to_rad(o.pull_out_rudder_deg), deg_to_rad(o.amidships_deg), o.hold_s);
                   });
  add_rudder_to_both_sides(*sub, opt.pull_out_rudder_deg);
  sub->add_option("--amidships-deg", opt.amidships_deg,
                  "rudder angle that counts as amidships: the neutral one, where the ship is not symmetric [deg]")
      ->check(in_range(-180.0, 180.0))
      ->capture_default_str();
  add_hold(*sub, opt);
}

void add_spiral(Commands& commands, SimOptions& opt) {
  CLI::App* sub = commands.add("spiral", "Dieudonne's spiral: rudder from starboard stepwise to port and back",
                               {.duration_s = kUntilDone}, [](Start start, Options o) {
                                 return spiral(start, deg_to_rad(o.spiral_rudder_deg), deg_to_rad(o.step_deg),
                                               deg_to_rad(o.fine_step_deg), o.hold_s);
                               });
  add_rudder_to_both_sides(*sub, opt.spiral_rudder_deg);
  sub->add_option("--step-deg", opt.step_deg, "step between rudder angles; --rudder-deg is a multiple of it [deg]")
      ->check(in_range(0.1, 180.0))
      ->capture_default_str();
  sub->add_option("--fine-step-deg", opt.fine_step_deg,
                  "step within +- --step-deg, which is a multiple of it; a narrower loop can be missed [deg]")
      ->check(in_range(0.01, 180.0))
      ->capture_default_str();
  add_hold(*sub, opt);
}

void add_crash_stop(Commands& commands, SimOptions& opt) {
  CLI::App* sub = commands.add(
      "crash-stop", "steady ahead, then full astern; by the rudders (clamshell) where the propeller does not reverse",
      {.duration_s = kUntilDone}, [](Start start, Options o) { return crash_stop(start, o.approach_s, o.astern_rps); });
  sub->add_option("--approach-s", opt.approach_s, "time on a straight course before the order [s]")
      ->check(not_negative())
      ->default_str("5 L_pp/u0");
  sub->add_option("--astern-rps", opt.astern_rps, "revolutions astern, negative [1/s]")
      ->check(in_range(-1000.0, 0.0))
      ->default_str("those ahead, reversed");
}

void add_coast_down(Commands& commands) {
  commands.add("coast-down", "propeller stopped, rudders amidships, to a tenth of the speed",
               {.duration_s = kUntilDone}, [](Start start, Options) { return coast_down(start); });
}

void add_thruster_pulses(Commands& commands, SimOptions& opt) {
  CLI::App* sub =
      commands.add("thruster-pulses", "pulses of a side thruster to starboard, to port, and so on",
                   {.duration_s = kUntilDone, .u0_mps = "0", .n_p_rps = "0 at rest, else those that hold the speed"},
                   [](Start start, Options o) {
                     std::optional<Channel> thruster;
                     if (!o.thruster.empty()) thruster = o.thruster == "bow" ? Channel::n_bt : Channel::n_st;
                     ThrusterPulses pulses = thruster_pulses_for(start.ship, thruster);
                     pulses.rps = o.thruster_rps.value_or(pulses.rps);
                     pulses.pulse_s = o.pulse_s.value_or(pulses.pulse_s);
                     pulses.rest_s = o.rest_s.value_or(pulses.rest_s);
                     pulses.pulses = o.pulses;
                     return thruster_pulses(start, pulses);
                   });
  sub->add_option("--thruster", opt.thruster, "bow or stern")
      ->check(CLI::IsMember({"bow", "stern"}))
      ->default_str("the bow thruster, or else the stern thruster");
  sub->add_option("--thruster-rps", opt.thruster_rps, "revolutions of a pulse [1/s]")
      ->check(positive())
      ->default_str("the most that both sides have");
  sub->add_option("--pulse-s", opt.pulse_s, "length of a pulse [s]")->check(positive())->default_str("40 sqrt(L_pp/g)");
  sub->add_option("--rest-s", opt.rest_s, "time after each pulse [s]")
      ->check(positive())
      ->default_str("120 sqrt(L_pp/g)");
  sub->add_option("--pulses", opt.pulses, "number of pulses")->check(in_range(1.0, 10000.0))->capture_default_str();
}

void add_straight(Commands& commands, SimOptions& opt) {
  CLI::App* sub = commands.add("straight", "straight ahead at --u0-mps, the heading kept by a controller",
                               {.n_p_rps = "those that hold the speed in calm air"}, [](Start start, Options o) {
                                 CourseKeeper keeper = course_keeper(start);
                                 if (o.kp) keeper.kp = deg_to_rad(*o.kp);
                                 if (o.kd) keeper.kd_s = deg_to_rad(*o.kd);
                                 return straight(start.ship, keeper);
                               });
  sub->add_option("--kp", opt.kp, "gain on the heading error [deg/rad]")->check(not_negative())->default_str("57.3");
  sub->add_option("--kd", opt.kd, "gain on the yaw rate [deg/(rad/s)]")
      ->check(not_negative())
      ->default_str("114.6 L_pp/u0");
}

void add_schedule(Commands& commands, SimOptions& opt) {
  CLI::App* sub = commands.add("schedule", "orders by the clock, from a file",
                               {.duration_s = "200 s beyond the last row"}, [](Start start, Options o) {
                                 Schedule schedule = read_schedule(o.schedule, start.ship);
                                 warn_all(schedule.notices);
                                 return scheduled_orders(std::move(schedule));
                               });
  sub->add_option(
         "schedule", opt.schedule,
         "orders (CSV): t_s and columns such as delta_deg, n_p_rps; an empty field keeps the order; '-' for stdin")
      ->required();
}

}  // namespace

std::vector<Command> add_maneuver_commands(CLI::App& app, SimOptions& opt) {
  Commands commands{app, opt, {}};
  add_zigzag(commands, opt);
  add_turning(commands, opt);
  add_random(commands);
  add_berthing(commands);
  add_port_navigation(commands);
  add_pull_out(commands, opt);
  add_spiral(commands, opt);
  add_crash_stop(commands, opt);
  add_coast_down(commands);
  add_thruster_pulses(commands, opt);
  add_straight(commands, opt);
  add_schedule(commands, opt);
  return std::move(commands.all);
}

}  // namespace leeway::cli
