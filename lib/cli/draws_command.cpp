#include <filesystem>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include "cli/inputs.hpp"
#include "cli/progress.hpp"
#include "cli/simulator.hpp"
#include "core/errors.hpp"
#include "dynamics/ship_draws.hpp"
#include "io/files.hpp"
#include "io/result_folder.hpp"

namespace leeway::cli {
namespace {

constexpr double kMostDraws = 100'000.0;

void run_draws(const CLI::App& app, const SimOptions& opt, const DrawOptions& draws) {
  if (opt.output == "-") throw UsageError("draws are a folder: give --output DIR");
  const Ship ship = read_ship(opt.ship);
  if (ship.file == "-") throw UsageError("--ship: expected a file or a shipped name, got '-'");
  const io::Json json = io::read_json(ship.file);
  const ShipDraws drawn(ship, draws.spread, opt.common.seed);
  std::vector<std::string> files;
  for (std::size_t i = 0; i < draws.count; ++i) files.push_back(fmt::format("draw-{:02}.json", i));
  const io::Json generation{{"version", LEEWAY_VERSION},
                            {"ship", input_sha256(ship.file)},
                            {"spread", draws.spread},
                            {"seed", opt.common.seed},
                            {"count", draws.count}};
  io::ResultFolder folder(opt.output, "draws.json", files, generation.dump());
  Inputs().config("ships", opt.ship).keep_from(folder.outputs());
  folder.begin();
  io::Json all = io::Json::array();
  int refused = 0;
  Progress progress("mmg-sim: draws", static_cast<double>(draws.count), opt.common, Progress::Lines::of_long_work);
  for (std::size_t i = 0; i < draws.count; ++i) {
    const int number = static_cast<int>(i);
    const ShipDraw draw = drawn.draw(number);
    refused += draw.refused;
    io::write_text(folder.path(files[i]), io::to_text(drawn.json(json, draw, number)));
    folder.add(files[i]);
    io::Json factors, shifts;
    for (const CoefficientFactor& by : draw.factors)
      if (by.shift != 0.0)
        shifts[by.name] = by.shift;
      else
        factors[by.name] = by.factor;
    all.push_back({{"file", files[i]}, {"refused_before", draw.refused}, {"coefficient_factors", factors}});
    if (!shifts.is_null()) all.back()["coefficient_shifts"] = shifts;
    progress.advance();
  }
  folder.commit({{"ship", ship.name},
                 {"spread", draws.spread},
                 {"draws", all},
                 {"provenance", provenance(app, opt.common, {ship.file})}});
  if (refused > 0)
    spdlog::info("{}: {} of {} draws made no ship (too slow, or no steady turn) and were drawn anew", opt.output,
                 refused, draws.count + static_cast<std::size_t>(refused));
}

}  // namespace

Command add_draws_command(CLI::App& app, SimOptions& opt, DrawOptions& draws) {
  CLI::App* sub = app.add_subcommand("draws", "ships drawn from what a ship's file states of its coefficients");
  sub->add_option("--ship", opt.ship, "ship (JSON), or the name of a shipped one: 'mmg-sim ships' lists them")
      ->required();
  sub->add_option("--count", draws.count, "number of draws")->check(in_range(1.0, kMostDraws))->required();
  sub->add_option("--spread", draws.spread, "what the stated standard deviations are multiplied by")
      ->check(positive())
      ->capture_default_str();
  add_output(*sub, opt, "folder for draw-00.json, draw-01.json, ... and draws.json, which lists their factors");
  return {sub, [&app, &opt, &draws] { run_draws(app, opt, draws); }};
}

}  // namespace leeway::cli
