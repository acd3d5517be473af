#include <cmath>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include "cli/options.hpp"
#include "core/errors.hpp"
#include "core/units.hpp"
#include "dynamics/dataset.hpp"
#include "dynamics/indices.hpp"
#include "dynamics/phased_maneuvers.hpp"
#include "dynamics/replay.hpp"
#include "dynamics/schedule.hpp"
#include "dynamics/ship_report.hpp"
#include "effects/catalogue.hpp"
#include "io/dataset_json.hpp"
#include "io/files.hpp"

using namespace leeway;

namespace {

constexpr double kDuration_s = 200.0;  // of maneuvers that do not end by themselves

struct SimOptions {
  cli::CommonOptions common;
  std::string ship, output = "-", noise, truth, indices, columns, spec, schedule, thruster, effect;
  std::vector<std::string> recordings, effects;
  TimeGrid grid;
  std::optional<double> duration_s, u0_mps, n_p_rps, hold_s, approach_s, astern_rps, thruster_rps, pulse_s, rest_s, kp,
      kd;
  double zigzag_rudder_deg = 10.0, turning_rudder_deg = 35.0, pull_out_rudder_deg = 20.0, spiral_rudder_deg = 25.0,
         amidships_deg = 0.0, step_deg = 5.0, fine_step_deg = 0.5, heading_deg = 0.0, wind_speed_mps = 0.0,
         wind_dir_deg = 0.0;
  std::size_t pulses = 2;
  std::string wind = "steady";
  std::size_t restart_steps = 0;
  bool hold = false, prediction = false, page = false;
};

void add_output(CLI::App& sub, SimOptions& opt, const std::string& what) {
  sub.add_option("-o,--output", opt.output, what)->capture_default_str();
}

void add_ship_and_steps(CLI::App& sub, SimOptions& opt) {
  sub.add_option("--ship", opt.ship, "ship (JSON), or the name of a shipped one: 'mmg-sim ships' lists them")
      ->required();
  sub.add_option("--effect", opt.effects,
                 "physics to add to the ship's effects (JSON, see 'mmg-sim effects'); may be given several times")
      ->type_name("TEXT")
      ->expected(1)
      ->take_all();
  sub.add_option("--dt-s", opt.grid.dt_s, "time step of the integration [s]")
      ->check(cli::positive())
      ->capture_default_str();
  sub.add_option("--sample-s", opt.grid.sample_s, "time between rows, a multiple of the time step [s]")
      ->check(cli::positive())
      ->capture_default_str();
}

void add_noise(CLI::App& sub, SimOptions& opt) {
  sub.add_option("--noise", opt.noise,
                 "observation noise (JSON), or the name of a shipped one: paper-model-scale [default: none]");
  sub.add_option("--truth", opt.truth, "also write the noise-free states here (CSV)");
}

void add_indices(CLI::App& sub, SimOptions& opt) {
  sub.add_option("--indices", opt.indices,
                 "write what is read off the maneuver, from the noise-free states of every time step, here (JSON)");
}

// What all maneuvers share; the defaults as --help shows them.
struct Defaults {
  const char *duration_s = "200", *u0_mps = "the ship's u0_mps", *n_p_rps = "the ship's initial_rps";
};
void add_maneuver_options(CLI::App& sub, SimOptions& opt, const Defaults& defaults = {}) {
  add_ship_and_steps(sub, opt);
  sub.add_option("--duration-s", opt.duration_s, "length of the run, a multiple of --sample-s [s]")
      ->check(cli::positive())
      ->default_str(defaults.duration_s);
  sub.add_option("--u0-mps", opt.u0_mps, "surge at the start, through the water [m/s]")
      ->check(cli::in_range(-50.0, 50.0))
      ->default_str(defaults.u0_mps);
  sub.add_option("--n-p-rps", opt.n_p_rps, "propeller revolutions, at the start and ordered [1/s]")
      ->check(cli::in_range(-1000.0, 1000.0))
      ->default_str(defaults.n_p_rps);
  sub.add_option("--wind-speed-mps", opt.wind_speed_mps, "true wind speed [m/s]")
      ->check(cli::in_range(0.0, 200.0))
      ->capture_default_str();
  sub.add_option("--wind-dir-deg", opt.wind_dir_deg, "direction that the true wind comes from, 0: from +x0 [deg]")
      ->check(cli::in_range(-360.0, 360.0))
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
      ->check(cli::in_range(-180.0, 180.0))
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
      ->check(cli::in_range(0.1, 180.0))
      ->capture_default_str();
}

void add_hold(CLI::App& sub, SimOptions& opt) {
  sub.add_option("--hold-s", opt.hold_s, "longest time at one rudder angle; it is left when the turn is steady [s]")
      ->check(cli::positive())
      ->default_str("60 L_pp/u0");
}

double u0_of(const Ship& ship, const SimOptions& opt) { return opt.u0_mps.value_or(ship.u0_mps); }

// A maneuver that is to begin steadily where the user has not given the revolutions.
SimulatedShip balanced_start(const Ship& ship, const SimOptions& opt, double u_mps) {
  if (opt.n_p_rps || u_mps <= 0.0) {
    SimulatedShip start(ship, u_mps);
    start.actuators[Channel::n_p] = 0.0;
    return start;
  }
  return steady_ahead(ship, u_mps);
}

SimulatedShip ship_at_start(const Ship& ship, const SimOptions& opt, const std::string& maneuver) {
  SimulatedShip start = maneuver == "straight"          ? balanced_start(ship, opt, u0_of(ship, opt))
                        : maneuver == "thruster-pulses" ? balanced_start(ship, opt, opt.u0_mps.value_or(0.0))
                                                        : SimulatedShip(ship, u0_of(ship, opt));
  if (!opt.n_p_rps) return start;
  const Actuator* propeller = ship.find_actuator(Channel::n_p);
  if (propeller == nullptr || propeller->clip(*opt.n_p_rps) != *opt.n_p_rps)
    throw UsageError(fmt::format("--n-p-rps {} is outside the limits of the ship '{}'", *opt.n_p_rps, ship.name));
  start.actuators[Channel::n_p] = *opt.n_p_rps;
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

void write_indices(const CLI::App& app, const SimOptions& opt, const Ship& ship, const Trajectory& every_step,
                   const ManeuverFacts& facts, io::Json conditions) {
  io::Json json{{"maneuver", facts.maneuver},
                {"ship", {{"name", ship.name}, {"L_pp_m", ship.particulars.L_pp}, {"scale", ship.scale}}},
                {"conditions", std::move(conditions)}};
  json.update(maneuver_indices(every_step, ship, facts));
  std::vector<std::string> inputs{ship.file};
  if (!opt.schedule.empty()) inputs.push_back(opt.schedule);
  inputs.insert(inputs.end(), opt.effects.begin(), opt.effects.end());
  inputs.insert(inputs.end(), opt.recordings.begin(), opt.recordings.end());
  json["provenance"] = cli::provenance(app, opt.common, inputs, {"--truth", "--indices", "--noise"});
  io::write_text(opt.indices, io::to_text(json));
  if (!json.contains("indices")) return;
  if (const std::vector<std::string> missing = not_reached(json["indices"]); !missing.empty())
    spdlog::warn("null in the indices, since this run of {} s did not reach or did not tell it: {}",
                 every_step[Channel::t].back() - every_step[Channel::t].front(), fmt::join(missing, ", "));
}

void check_streams(const SimOptions& opt) {
  if ((opt.output == "-") + (opt.truth == "-") + (opt.indices == "-") > 1)
    throw UsageError("only one of --output, --truth and --indices can be the standard output");
}

void write_result(const SimOptions& opt, const Trajectory& truth) {
  const ObservationNoise noise = opt.noise.empty() ? ObservationNoise{} : read_noise(opt.noise);
  if (!opt.truth.empty()) io::write_trajectory(opt.truth, truth);
  io::write_trajectory(opt.output, observed(truth, noise, {opt.common.seed, "observation noise"}));
}

Ship read_ship_with_effects(const SimOptions& opt) {
  Ship ship = read_ship(opt.ship);
  for (const std::string& file : opt.effects)
    for (EffectEntry& effect : read_effects(file)) ship.effects.push_back(std::move(effect));
  return ship;
}

// The ship at the start outlives the maneuver.
using MakeManeuver = std::unique_ptr<Maneuver> (*)(const SimulatedShip& start, const SimOptions&);

void run_maneuver(const CLI::App& app, const std::string& name, const SimOptions& opt, MakeManeuver make) {
  TimeGrid grid = opt.grid;
  grid.duration_s = opt.duration_s.value_or(grid.sample_s);
  grid.check();
  check_streams(opt);
  Ship ship = read_ship_with_effects(opt);
  if (opt.n_p_rps)
    for (Actuator& actuator : ship.actuators)  // ordered revolutions stay, also in a random run
      if (actuator.channel == Channel::n_p) actuator.is_random = false;
  const SimulatedShip start = ship_at_start(ship, opt, name);
  const auto maneuver = make(start, opt);
  const double longest_s = maneuver->longest_s().value_or(kDuration_s);
  if (!opt.duration_s) grid.duration_s = grid.sample_s * std::ceil(longest_s / grid.sample_s - 1e-9);
  Trajectory every_step;
  const Trajectory truth =
      simulate(start, *maneuver, wind_of(opt), grid, Integrator::rk4, opt.indices.empty() ? nullptr : &every_step);
  if (!opt.indices.empty()) {
    ManeuverFacts facts = facts_of(opt, name);
    facts.phases = maneuver->phases();
    io::Json conditions{{"u0_mps", start.surge_through_water()}, {"n_p_rps", start.actuators[Channel::n_p]}};
    if (facts.rudder != 0.0) conditions["rudder_deg"] = rad_to_deg(facts.rudder);
    if (facts.heading != 0.0) conditions["heading_deg"] = rad_to_deg(facts.heading);
    conditions["wind"] = {{"kind", opt.wind}, {"speed_mps", opt.wind_speed_mps}, {"dir_deg", opt.wind_dir_deg}};
    conditions["dt_s"] = grid.dt_s;
    write_indices(app, opt, ship, every_step, facts, std::move(conditions));
  }
  write_result(opt, truth);
}

void run_replay(const CLI::App& app, const SimOptions& opt) {
  TimeGrid grid = opt.grid;
  grid.duration_s = grid.sample_s;
  grid.check();
  if (opt.prediction != (opt.restart_steps > 0)) throw UsageError("--prediction and --restart-steps belong together");
  if (opt.prediction && !(opt.noise.empty() && opt.truth.empty() && opt.indices.empty()))
    throw UsageError("--noise, --truth and --indices do not apply to --prediction");
  std::vector<std::string> paths;
  for (const io::RecordingFile& file : io::expand_recordings(opt.recordings)) paths.push_back(file.path);
  if (!opt.prediction && paths.size() != 1)
    throw UsageError("one recording at a time, except with --restart-steps and --prediction");
  if (!opt.prediction) check_streams(opt);

  const Ship ship = read_ship_with_effects(opt);
  const std::vector<Trajectory> recordings = cli::read_recordings(paths, opt.columns, opt.common.jobs);
  std::vector<RecordedInputs> inputs;
  for (const Trajectory& recording : recordings) {
    inputs.emplace_back(recording, ship, opt.hold ? InputInterpolation::hold : InputInterpolation::linear);
    cli::warn_all(inputs.back().notices());
  }
  if (!opt.prediction) {
    if (!opt.indices.empty()) {
      const Trajectory every_step = replay(ship, recordings[0], inputs[0], {grid.dt_s, grid.dt_s, grid.dt_s});
      write_indices(app, opt, ship, every_step, facts_of(opt, "replay"), {{"dt_s", grid.dt_s}});
    }
    return write_result(opt, replay(ship, recordings[0], inputs[0], grid));
  }

  const auto predict = [&](std::size_t i, io::PredictionWriter& writer) {
    if (replay_sequences(ship, recordings[i], inputs[i], grid, opt.restart_steps, writer) == 0)
      spdlog::warn("{}: shorter than {} points without a gap; it gives no sequence", recordings[i].file,
                   opt.restart_steps);
  };
  if (opt.output == "-") {
    io::PredictionWriter writer("-");
    for (std::size_t i = 0; i < recordings.size(); ++i) predict(i, writer);
    return writer.commit();
  }
  io::make_directories(opt.output);
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    io::PredictionWriter writer(fmt::format("{}/{}.csv", opt.output, recordings[i].name));
    predict(i, writer);
    writer.commit();
  }
}

void run_dataset(const CLI::App& app, const SimOptions& opt) {
  if (opt.output == "-") throw UsageError("a dataset is a folder: give --output DIR");
  const DatasetSpec spec = read_dataset_spec(opt.spec);
  generate_dataset(spec, opt.output, opt.common.seed, opt.common.jobs,
                   cli::provenance(app, opt.common, spec.input_files));
}

}  // namespace

int main(int argc, char** argv) try {
  SimOptions opt;
  CLI::App app{"Simulate ship maneuvers with the MMG equations and write trajectories as CSV.", "mmg-sim"};
  cli::add_common_options(app, opt.common);
  app.require_subcommand(1);
  app.fallthrough();
  app.footer("The options above may also follow the subcommand. docs/mmg-sim.md has the formats and the models.");

  CLI::App* zigzag_test = app.add_subcommand("zigzag", "zigzag test");
  add_maneuver_options(*zigzag_test, opt);
  add_rudder(*zigzag_test, opt.zigzag_rudder_deg);
  zigzag_test->add_option("--heading-deg", opt.heading_deg, "change of heading at which the rudder is put over [deg]")
      ->check(cli::in_range(0.01, 180.0))
      ->default_str("|rudder-deg|");

  CLI::App* turning_circle = app.add_subcommand("turning", "turning circle");
  add_maneuver_options(*turning_circle, opt);
  add_rudder(*turning_circle, opt.turning_rudder_deg);

  CLI::App* random = app.add_subcommand("random", "random orders, distributed as the ship's JSON says");
  add_maneuver_options(*random, opt);

  const char* until_done = "until it is done";
  CLI::App* pull_out_test =
      app.add_subcommand("pull-out", "turn to starboard, amidships, turn to port, amidships: which yaw rates remain?");
  add_maneuver_options(*pull_out_test, opt, {.duration_s = until_done});
  add_rudder_to_both_sides(*pull_out_test, opt.pull_out_rudder_deg);
  pull_out_test
      ->add_option("--amidships-deg", opt.amidships_deg,
                   "rudder angle that counts as amidships: the neutral one, where the ship is not symmetric [deg]")
      ->check(cli::in_range(-180.0, 180.0))
      ->capture_default_str();
  add_hold(*pull_out_test, opt);

  CLI::App* spiral_test =
      app.add_subcommand("spiral", "Dieudonne's spiral: rudder from starboard stepwise to port and back");
  add_maneuver_options(*spiral_test, opt, {.duration_s = until_done});
  add_rudder_to_both_sides(*spiral_test, opt.spiral_rudder_deg);
  spiral_test
      ->add_option("--step-deg", opt.step_deg, "step between rudder angles; --rudder-deg is a multiple of it [deg]")
      ->check(cli::in_range(0.1, 180.0))
      ->capture_default_str();
  spiral_test
      ->add_option("--fine-step-deg", opt.fine_step_deg,
                   "step within +- --step-deg, which is a multiple of it; a narrower loop can be missed [deg]")
      ->check(cli::in_range(0.01, 180.0))
      ->capture_default_str();
  add_hold(*spiral_test, opt);

  CLI::App* stop = app.add_subcommand(
      "crash-stop", "steady ahead, then full astern; by the rudders (clamshell) where the propeller does not reverse");
  add_maneuver_options(*stop, opt, {.duration_s = until_done});
  stop->add_option("--approach-s", opt.approach_s, "time on a straight course before the order [s]")
      ->check(cli::not_negative())
      ->default_str("5 L_pp/u0");
  stop->add_option("--astern-rps", opt.astern_rps, "revolutions astern, negative [1/s]")
      ->check(cli::in_range(-1000.0, 0.0))
      ->default_str("those ahead, reversed");

  CLI::App* coasting =
      app.add_subcommand("coast-down", "propeller stopped, rudders amidships, to a tenth of the speed");
  add_maneuver_options(*coasting, opt, {.duration_s = until_done});

  CLI::App* pulse_test =
      app.add_subcommand("thruster-pulses", "pulses of a side thruster to starboard, to port, and so on");
  add_maneuver_options(
      *pulse_test, opt,
      {.duration_s = until_done, .u0_mps = "0", .n_p_rps = "0 at rest, else those that hold the speed"});
  pulse_test->add_option("--thruster", opt.thruster, "bow or stern")
      ->check(CLI::IsMember({"bow", "stern"}))
      ->default_str("the bow thruster, or else the stern thruster");
  pulse_test->add_option("--thruster-rps", opt.thruster_rps, "revolutions of a pulse [1/s]")
      ->check(cli::positive())
      ->default_str("the most that both sides have");
  pulse_test->add_option("--pulse-s", opt.pulse_s, "length of a pulse [s]")
      ->check(cli::positive())
      ->default_str("40 sqrt(L_pp/g)");
  pulse_test->add_option("--rest-s", opt.rest_s, "time after each pulse [s]")
      ->check(cli::positive())
      ->default_str("120 sqrt(L_pp/g)");
  pulse_test->add_option("--pulses", opt.pulses, "number of pulses")
      ->check(cli::in_range(1.0, 10000.0))
      ->capture_default_str();

  CLI::App* straight_run =
      app.add_subcommand("straight", "straight ahead at --u0-mps, the heading kept by a controller");
  add_maneuver_options(*straight_run, opt, {.n_p_rps = "those that hold the speed in calm air"});
  straight_run->add_option("--kp", opt.kp, "gain on the heading error [deg/rad]")
      ->check(cli::not_negative())
      ->default_str("57.3");
  straight_run->add_option("--kd", opt.kd, "gain on the yaw rate [deg/(rad/s)]")
      ->check(cli::not_negative())
      ->default_str("114.6 L_pp/u0");

  CLI::App* scheduled = app.add_subcommand("schedule", "orders by the clock, from a file");
  add_maneuver_options(*scheduled, opt, {.duration_s = "200 s beyond the last row"});
  scheduled
      ->add_option(
          "schedule", opt.schedule,
          "orders (CSV): t_s and columns such as delta_deg, n_p_rps; an empty field keeps the order; '-' for stdin")
      ->required();

  CLI::App* replay_run = app.add_subcommand("replay", "drive the ship with a recording's actuators and wind");
  add_ship_and_steps(*replay_run, opt);
  replay_run
      ->add_option("recordings", opt.recordings, "recordings (CSV), dataset.json or dataset.json#SET; '-' for stdin")
      ->required();
  replay_run->add_option("--columns", opt.columns,
                         "columns map (JSON) of foreign recordings, or its name: frt-ds-esso");
  replay_run->add_flag("--hold", opt.hold, "hold inputs between samples [default: linear]");
  replay_run
      ->add_option("--restart-steps", opt.restart_steps, "restart from the recorded state every so many points [1]")
      ->check(cli::in_range(2.0, 1e9));
  replay_run->add_flag("--prediction", opt.prediction, "write prediction CSV, one file per recording");
  add_noise(*replay_run, opt);
  add_indices(*replay_run, opt);
  add_output(*replay_run, opt, "trajectory (CSV), with --prediction a folder; '-' for stdout");

  CLI::App* dataset = app.add_subcommand("dataset", "sets of runs with observation noise, and their truth");
  dataset->add_option("spec", opt.spec, "specification (JSON), or the name of a shipped one: demo")->required();
  add_output(*dataset, opt, "folder for <set>/<name>.csv, <set>/truth/<name>.csv and dataset.json");

  CLI::App* ships = app.add_subcommand("ships", "list the shipped ships");
  add_output(*ships, opt, "where the text goes, '-' for stdout");

  CLI::App* show =
      app.add_subcommand("show", "particulars, modules, limits, straight run and self-propulsion of a ship");
  show->add_option("ship", opt.ship, "ship (JSON), or the name of a shipped one")->required();
  add_output(*show, opt, "where the text goes, '-' for stdout");

  CLI::App* effects = app.add_subcommand("effects", "list the physics that can be added to a ship");
  effects->add_option("effect", opt.effect, "only this one");
  effects->add_flag("--page", opt.page, "as a page in Markdown: docs/effects.md");
  add_output(*effects, opt, "where the text goes, '-' for stdout");

  if (const auto exit_code = cli::parse(app, argc, argv, opt.common)) return *exit_code;

  using Start = const SimulatedShip&;
  using Options = const SimOptions&;
  const auto run = [&](const char* name, MakeManeuver make) { run_maneuver(app, name, opt, make); };
  if (*zigzag_test) {
    run("zigzag", [](Start start, Options o) {
      const ManeuverFacts facts = facts_of(o, "zigzag");
      return zigzag(start.ship, facts.rudder, facts.heading);
    });
  } else if (*turning_circle) {
    run("turning", [](Start start, Options o) { return turning(start.ship, deg_to_rad(o.turning_rudder_deg)); });
  } else if (*random) {
    run("random", [](Start start, Options o) { return random_orders(start.ship, {o.common.seed, "random orders"}); });
  } else if (*pull_out_test) {
    run("pull-out", [](Start start, Options o) {
      return pull_out(start, deg_to_rad(o.pull_out_rudder_deg), deg_to_rad(o.amidships_deg), o.hold_s);
    });
  } else if (*spiral_test) {
    run("spiral", [](Start start, Options o) {
      return spiral(start, deg_to_rad(o.spiral_rudder_deg), deg_to_rad(o.step_deg), deg_to_rad(o.fine_step_deg),
                    o.hold_s);
    });
  } else if (*stop) {
    run("crash-stop", [](Start start, Options o) { return crash_stop(start, o.approach_s, o.astern_rps); });
  } else if (*coasting) {
    run("coast-down", [](Start start, Options) { return coast_down(start); });
  } else if (*pulse_test) {
    run("thruster-pulses", [](Start start, Options o) {
      std::optional<Channel> thruster;
      if (!o.thruster.empty()) thruster = o.thruster == "bow" ? Channel::n_bt : Channel::n_st;
      ThrusterPulses pulses = thruster_pulses_for(start.ship, thruster);
      pulses.rps = o.thruster_rps.value_or(pulses.rps);
      pulses.pulse_s = o.pulse_s.value_or(pulses.pulse_s);
      pulses.rest_s = o.rest_s.value_or(pulses.rest_s);
      pulses.pulses = o.pulses;
      return thruster_pulses(start, pulses);
    });
  } else if (*straight_run) {
    run("straight", [](Start start, Options o) {
      CourseKeeper keeper = course_keeper(start);
      if (o.kp) keeper.kp = deg_to_rad(*o.kp);
      if (o.kd) keeper.kd_s = deg_to_rad(*o.kd);
      return straight(start.ship, keeper);
    });
  } else if (*scheduled) {
    run("schedule", [](Start start, Options o) {
      Schedule schedule = read_schedule(o.schedule, start.ship);
      cli::warn_all(schedule.notices);
      return scheduled_orders(std::move(schedule));
    });
  } else if (*replay_run) {
    run_replay(app, opt);
  } else if (*ships) {
    io::write_text(opt.output, ship_list());
  } else if (*show) {
    io::write_text(opt.output, ship_report(read_ship(opt.ship)));
  } else if (*effects) {
    io::write_text(opt.output, opt.page ? catalogue_page() : catalogue_text(opt.effect));
  } else {
    run_dataset(app, opt);
  }
  return cli::kOk;
} catch (...) {
  return leeway::cli::report_current_exception("mmg-sim");
}
