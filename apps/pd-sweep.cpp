#include <filesystem>
#include <memory>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include "cli/inputs.hpp"
#include "cli/options.hpp"
#include "cli/progress.hpp"
#include "control/pd_sweep.hpp"
#include "core/errors.hpp"
#include "ensemble/calibration.hpp"
#include "io/described_file.hpp"
#include "io/result_folder.hpp"

using namespace leeway;

namespace {

struct Options {
  std::string model, ship, output = "-", trajectories, kp = "5:100:5", kd = "5:100:5", kernel = "auto";
  int particles = 100, use_members = 0;
  control::HeadingTask task;
  double psi_bar_deg = 90.0;
  bool no_disturbance = false, no_initial_error = false, no_calibration = false;
  cli::CommonOptions common;
};

void add_options(CLI::App& app, Options& o) {
  app.add_option("model", o.model, "model directory of ens-train")->required();
  app.add_option("--ship", o.ship, "the true ship: a JSON file or a shipped name")->required();
  app.add_option("--kp", o.kp, "K_P as LOW:HIGH:STEP or a list [deg of rudder per rad of heading]")
      ->capture_default_str();
  app.add_option("--kd", o.kd, "K_D as LOW:HIGH:STEP or a list [deg of rudder per rad/s of yaw rate]")
      ->capture_default_str();
  app.add_option("--particles", o.particles, "particles; each keeps its member")
      ->check(cli::at_least(1))
      ->capture_default_str();
  app.add_option("--use-members", o.use_members, "use the first M members only (default: all)")
      ->check(cli::at_least(1));
  app.add_option("--heading-deg", o.psi_bar_deg, "heading to reach from 0 [deg]")
      ->check(cli::in_range(-180.0, 180.0))
      ->capture_default_str();
  app.add_option("--u0-mps", o.task.u0_mps, "surge at the start [m/s]")->check(cli::positive())->capture_default_str();
  app.add_option("--duration-s", o.task.duration_s, "length of a run [s]")
      ->check(cli::positive())
      ->capture_default_str();
  app.add_option("--dt-s", o.task.dt_s, "time step of control and of Runge-Kutta [s]")
      ->check(cli::in_range(1e-3, 1.0))
      ->capture_default_str();
  app.add_flag("--no-disturbance", o.no_disturbance, "particles without the disturbance of the model's calibration");
  app.add_flag("--no-calibration", o.no_calibration, "leave the model's calibration.json unread");
  app.add_flag("--no-initial-error", o.no_initial_error,
               "as it always is here: the runs start from a state that is known");
  app.add_option("--trajectories", o.trajectories, "folder for the runs of each gain pair, sampled at 1 s");
  app.add_option("-o,--output", o.output, "scores (CSV), '-' for stdout")->capture_default_str();
  app.add_option("--kernel", o.kernel, "auto, avx512, avx2 or portable")->capture_default_str();
  cli::add_common_options(app, o.common);
}

std::string trajectories_file(const control::PdGains& gains) {
  return fmt::format("kp{}_kd{}.csv", gains.kp, gains.kd);
}

// The folder of --trajectories, if they are wanted.
std::unique_ptr<io::ResultFolder> trajectories_folder(const Options& o, const std::vector<control::PdGains>& gains) {
  std::vector<std::string> outputs{o.output, io::provenance_path(o.output)}, files;
  std::unique_ptr<io::ResultFolder> folder;
  if (!o.trajectories.empty()) {
    for (const control::PdGains& pair : gains) files.push_back(trajectories_file(pair));
    folder = std::make_unique<io::ResultFolder>(o.trajectories, "trajectories.json", files);
    const std::vector<std::string> more = folder->outputs();
    outputs.insert(outputs.end(), more.begin(), more.end());
  }
  cli::Inputs().config("ships", o.ship).folder(o.model).keep_from(outputs);
  return folder;
}

}  // namespace

int main(int argc, char** argv) try {
  Options o;
  CLI::App app{"Score heading PD controllers on a ship and on the particles of an ensemble; judge by the worst one.",
               "pd-sweep"};
  add_options(app, o);
  if (const auto exit_code = cli::parse(app, argc, argv, o.common)) return *exit_code;

  o.task.psi_bar = deg_to_rad(o.psi_bar_deg);
  std::vector<control::PdGains> gains;
  for (const double kp : control::parse_gain_range("--kp", o.kp))
    for (const double kd : control::parse_gain_range("--kd", o.kd)) gains.push_back({kp, kd});
  const auto trajectories = trajectories_folder(o, gains);
  const Ship ship = read_ship(o.ship);
  const ensemble::Ensemble model(o.model, o.use_members, nn::kernels(o.kernel));
  cli::warn_all(model.notices());
  const auto calibration = o.no_calibration ? std::nullopt : ensemble::read_calibration(o.model, model.header());
  std::vector<control::SweepResult> results;
  {
    cli::Progress progress("pd-sweep", 1.0, o.common, cli::Progress::Lines::of_long_work);
    results = control::pd_sweep(ship, model, gains, o.task, o.particles, o.common.seed, o.common.jobs,
                                !o.trajectories.empty(),
                                calibration && !o.no_disturbance ? calibration->disturbance : ensemble::Disturbance(),
                                [&](double done) { progress.update(done, ""); });
  }
  const std::vector<std::string> inputs{(std::filesystem::path(o.model) / "ensemble.json").string(), ship.file};
  io::Json made_by = cli::provenance(app, o.common, inputs, {"--trajectories"});
  made_by["ship"] = {{"name", ship.name}};
  if (trajectories) {
    io::remove_described(o.output);  // it comes last: where it lies, the trajectories are of its run
    trajectories->begin();
    for (const control::SweepResult& r : results)
      trajectories->write(trajectories_file(r.gains), control::runs_csv(r, ship));
    trajectories->commit({{"provenance", made_by}});
  }
  io::write_described(o.output, control::sweep_csv(results), made_by);

  const auto best = [&](auto score) {
    return *std::min_element(results.begin(), results.end(),
                             [&](const auto& a, const auto& b) { return score(a) < score(b); });
  };
  const control::SweepResult by_worst = best([](const auto& r) { return r.score_worst; });
  const control::SweepResult by_truth = best([](const auto& r) { return r.score_true; });
  spdlog::info("best by the worst of {} particles: kp {} kd {} ({:.4g} rad s; on the true ship {:.4g})", o.particles,
               by_worst.gains.kp, by_worst.gains.kd, by_worst.score_worst, by_worst.score_true);
  spdlog::info("best on the true ship: kp {} kd {} ({:.4g} rad s)", by_truth.gains.kp, by_truth.gains.kd,
               by_truth.score_true);
  return cli::kOk;
} catch (...) {
  return cli::report_current_exception("pd-sweep");
}
