#include <optional>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "cli/options.hpp"
#include "core/errors.hpp"
#include "core/units.hpp"
#include "dynamics/dataset.hpp"
#include "dynamics/replay.hpp"
#include "dynamics/ship_report.hpp"
#include "effects/catalogue.hpp"
#include "io/dataset_json.hpp"
#include "io/files.hpp"

using namespace leeway;

namespace {

struct SimOptions {
  cli::CommonOptions common;
  std::string ship, output = "-", noise, truth, columns, spec, effect;
  std::vector<std::string> recordings, effects;
  TimeGrid grid;
  std::optional<double> u0_mps, n_p_rps;
  double zigzag_rudder_deg = 10.0, turning_rudder_deg = 35.0, heading_deg = 0.0, wind_speed_mps = 0.0,
         wind_dir_deg = 0.0;
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

// What zigzag, turning and random share.
void add_maneuver_options(CLI::App& sub, SimOptions& opt) {
  add_ship_and_steps(sub, opt);
  sub.add_option("--duration-s", opt.grid.duration_s, "length of the run, a multiple of --sample-s [s]")
      ->check(cli::positive())
      ->capture_default_str();
  sub.add_option("--u0-mps", opt.u0_mps, "surge at the start, through the water [m/s]")
      ->check(cli::in_range(-50.0, 50.0))
      ->default_str("the ship's u0_mps");
  sub.add_option("--n-p-rps", opt.n_p_rps, "propeller revolutions, at the start and ordered [1/s]")
      ->check(cli::in_range(-1000.0, 1000.0))
      ->default_str("the ship's initial_rps");
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

SimulatedShip ship_at_start(const Ship& ship, const SimOptions& opt) {
  SimulatedShip start(ship, opt.u0_mps.value_or(ship.u0_mps));
  if (!opt.n_p_rps) return start;
  const Actuator* propeller = ship.find_actuator(Channel::n_p);
  if (propeller == nullptr || propeller->clip(*opt.n_p_rps) != *opt.n_p_rps)
    throw UsageError(fmt::format("--n-p-rps {} is outside the limits of the ship '{}'", *opt.n_p_rps, ship.name));
  start.actuators[Channel::n_p] = *opt.n_p_rps;
  return start;
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

using MakeManeuver = std::unique_ptr<Maneuver> (*)(const Ship&, const SimOptions&);

void run_maneuver(const SimOptions& opt, MakeManeuver make) {
  opt.grid.check();
  if (opt.output == "-" && opt.truth == "-")
    throw UsageError("--output and --truth cannot both be the standard output");
  Ship ship = read_ship_with_effects(opt);
  if (opt.n_p_rps)
    for (Actuator& actuator : ship.actuators)  // ordered revolutions stay, also in a random run
      if (actuator.channel == Channel::n_p) actuator.is_random = false;
  const auto maneuver = make(ship, opt);
  write_result(opt, simulate(ship_at_start(ship, opt), *maneuver, wind_of(opt), opt.grid));
}

void run_replay(const SimOptions& opt) {
  TimeGrid grid = opt.grid;
  grid.duration_s = grid.sample_s;
  grid.check();
  if (opt.prediction != (opt.restart_steps > 0)) throw UsageError("--prediction and --restart-steps belong together");
  if (opt.prediction && !(opt.noise.empty() && opt.truth.empty()))
    throw UsageError("--noise and --truth do not apply to --prediction");
  std::vector<std::string> paths;
  for (const io::RecordingFile& file : io::expand_recordings(opt.recordings)) paths.push_back(file.path);
  if (!opt.prediction && paths.size() != 1)
    throw UsageError("one recording at a time, except with --restart-steps and --prediction");
  if (!opt.prediction && opt.output == "-" && opt.truth == "-")
    throw UsageError("--output and --truth cannot both be the standard output");

  const Ship ship = read_ship_with_effects(opt);
  const std::vector<Trajectory> recordings = cli::read_recordings(paths, opt.columns, opt.common.jobs);
  std::vector<RecordedInputs> inputs;
  for (const Trajectory& recording : recordings) {
    inputs.emplace_back(recording, ship, opt.hold ? InputInterpolation::hold : InputInterpolation::linear);
    cli::warn_all(inputs.back().notices());
  }
  if (!opt.prediction) return write_result(opt, replay(ship, recordings[0], inputs[0], grid));

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
  add_output(*replay_run, opt, "trajectory (CSV), with --prediction a folder; '-' for stdout");

  CLI::App* dataset = app.add_subcommand("dataset", "sets of runs with observation noise, and their truth");
  dataset->add_option("spec", opt.spec, "specification (JSON), or the name of a shipped one: demo")->required();
  add_output(*dataset, opt, "folder for <set>/<name>.csv, <set>/truth/<name>.csv and dataset.json");

  CLI::App* effects = app.add_subcommand("effects", "list the physics that can be added to a ship");
  effects->add_option("effect", opt.effect, "only this one");
  effects->add_flag("--page", opt.page, "as a page in Markdown: docs/effects.md");
  add_output(*effects, opt, "text, '-' for stdout");
  CLI::App* ships = app.add_subcommand("ships", "list the shipped ships");
  add_output(*ships, opt, "where the text goes, '-' for stdout");

  CLI::App* show =
      app.add_subcommand("show", "particulars, modules, limits, straight run and self-propulsion of a ship");
  show->add_option("ship", opt.ship, "ship (JSON), or the name of a shipped one")->required();
  add_output(*show, opt, "where the text goes, '-' for stdout");

  if (const auto exit_code = cli::parse(app, argc, argv, opt.common)) return *exit_code;

  if (*zigzag_test) {
    run_maneuver(opt, [](const Ship& ship, const SimOptions& o) {
      const double heading_deg = o.heading_deg > 0.0 ? o.heading_deg : std::abs(o.zigzag_rudder_deg);
      return zigzag(ship, deg_to_rad(o.zigzag_rudder_deg), deg_to_rad(heading_deg));
    });
  } else if (*turning_circle) {
    run_maneuver(opt,
                 [](const Ship& ship, const SimOptions& o) { return turning(ship, deg_to_rad(o.turning_rudder_deg)); });
  } else if (*random) {
    run_maneuver(opt, [](const Ship& ship, const SimOptions& o) {
      return random_orders(ship, {o.common.seed, "random orders"});
    });
  } else if (*replay_run) {
    run_replay(opt);
  } else if (*effects) {
    io::write_text(opt.output, opt.page ? catalogue_page() : catalogue_text(opt.effect));
  } else if (*ships) {
    io::write_text(opt.output, ship_list());
  } else if (*show) {
    io::write_text(opt.output, ship_report(read_ship(opt.ship)));
  } else {
    run_dataset(app, opt);
  }
  return cli::kOk;
} catch (...) {
  return leeway::cli::report_current_exception("mmg-sim");
}
