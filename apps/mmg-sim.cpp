#include <nlohmann/json.hpp>

#include "cli/inputs.hpp"
#include "cli/progress.hpp"
#include "cli/simulator.hpp"
#include "core/errors.hpp"
#include "dynamics/dataset.hpp"
#include "dynamics/run_notices.hpp"
#include "dynamics/ship_report.hpp"
#include "effects/catalogue.hpp"
#include "io/files.hpp"

using namespace leeway;

int main(int argc, char** argv) try {
  cli::SimOptions opt;
  CLI::App app{"Simulate ship maneuvers with the MMG equations and write trajectories as CSV.", "mmg-sim"};
  cli::add_common_options(app, opt.common);
  app.require_subcommand(1);
  app.fallthrough();
  app.footer("The options above may also follow the subcommand. docs/mmg-sim.md has the formats and the models.");

  std::vector<cli::Command> commands = cli::add_maneuver_commands(app, opt);
  commands.push_back(cli::add_replay_command(app, opt));

  std::string spec;
  CLI::App* dataset = app.add_subcommand("dataset", "sets of runs with observation noise, and their truth");
  dataset
      ->add_option("spec", spec,
                   "specification (JSON), or the name of a shipped one: demo, paper-model-scale, paper-full-scale")
      ->required();
  cli::add_output(*dataset, opt, "folder for <set>/<name>.csv, <set>/truth/<name>.csv and dataset.json");
  commands.push_back({dataset, [&] {
                        if (opt.output == "-") throw UsageError("a dataset is a folder: give --output DIR");
                        const DatasetSpec dataset_spec = read_dataset_spec(spec);
                        cli::warn_all(dataset_notices(dataset_spec));
                        io::Json made_by = cli::provenance(app, opt.common, dataset_spec.input_files);
                        made_by["ship"] = {{"name", dataset_spec.ship.name}};
                        cli::Progress progress("mmg-sim: dataset", 1.0, opt.common, cli::Progress::Lines::of_long_work);
                        generate_dataset(dataset_spec, opt.output, opt.common.seed, opt.common.jobs, made_by,
                                         [&](double done) { progress.update(done, ""); });
                      }});

  CLI::App* ships = app.add_subcommand("ships", "list the shipped ships");
  cli::add_output(*ships, opt, "where the text goes, '-' for stdout");
  commands.push_back({ships, [&] { io::write_text(opt.output, ship_list()); }});

  CLI::App* show =
      app.add_subcommand("show", "particulars, modules, limits, coefficients, effects and straight runs of a ship");
  show->add_option("ship", opt.ship, "ship (JSON), or the name of a shipped one")->required();
  bool show_json = false;
  show->add_flag("--json", show_json, "the same as JSON, in place of text");
  cli::add_output(*show, opt, "where the text goes, '-' for stdout");
  commands.push_back({show, [&] {
                        cli::Inputs().config("ships", opt.ship).keep_from({opt.output});
                        const Ship ship = read_ship(opt.ship);
                        if (!show_json) return io::write_text(opt.output, ship_report(ship));
                        io::Json json = ship_json(ship);
                        json["provenance"] = cli::provenance(app, opt.common, {ship.file});
                        io::write_text(opt.output, io::to_text(json));
                      }});

  cli::DrawOptions draw_options;
  commands.push_back(cli::add_draws_command(app, opt, draw_options));

  cli::EstimateOptions estimate_options;
  commands.push_back(cli::add_estimate_command(app, opt, estimate_options));
  double length_m = 0.0;
  commands.push_back(cli::add_scale_command(app, opt, length_m));
  cli::RecordingIndexOptions index_options;
  commands.push_back(cli::add_import_command(app, opt));
  commands.push_back(cli::add_columns_command(app, opt));
  commands.push_back(cli::add_indices_command(app, opt, index_options));

  std::string effect;
  bool page = false;
  CLI::App* effects = app.add_subcommand("effects", "list the physics that can be added to a ship");
  effects->add_option("effect", effect, "only this one");
  effects->add_flag("--page", page, "as a page in Markdown: docs/effects.md");
  cli::add_output(*effects, opt, "where the text goes, '-' for stdout");
  commands.push_back({effects, [&] { io::write_text(opt.output, page ? catalogue_page() : catalogue_text(effect)); }});

  if (const auto exit_code = cli::parse(app, argc, argv, opt.common)) return *exit_code;
  for (const cli::Command& command : commands)
    if (*command.subcommand) command.run();
  return cli::kOk;
} catch (...) {
  return leeway::cli::report_current_exception("mmg-sim");
}
