#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include "cli/inputs.hpp"
#include "cli/simulator.hpp"
#include "core/errors.hpp"
#include "estimate/hull_comparison.hpp"
#include "estimate/ship_estimate.hpp"
#include "estimate/ship_scaling.hpp"
#include "io/files.hpp"
#include "ship/plausibility.hpp"

namespace leeway::cli {
namespace {

void run_comparison(const CLI::App& app, const SimOptions& opt) {
  io::Json result = estimate::compare_measured_hulls(estimate::measured_hulls());
  result["provenance"] = provenance(app, opt.common, {});
  io::write_text(opt.output, io::to_text(result));
}

void run_estimate(const CLI::App& app, const SimOptions& opt, const EstimateOptions& o) {
  if (o.compares) return run_comparison(app, opt);
  if (o.particulars.empty()) throw UsageError("estimate: give particulars (JSON)");
  const std::string file = io::find_config("particulars", o.particulars);
  Inputs().config("particulars", o.particulars).keep_from({opt.output});
  const estimate::HullParticulars particulars = estimate::read_particulars(o.particulars);
  const std::vector<estimate::MeasuredHull> hulls = estimate::measured_hulls();
  for (const std::string& name : o.without)
    if (std::ranges::none_of(hulls, [&](const auto& hull) { return hull.name == name; }))
      throw UsageError(fmt::format("--without: no measured hull '{}'", name));
  estimate::ShipEstimate result = estimate::estimate_ship(particulars, estimate::fit_widths(hulls, o.without));
  for (const estimate::Assumption& a : result.assumptions)
    spdlog::info("{}: {} is not stated, taken as {:.4g}: {}", file, a.key, a.value, a.source);
  for (const std::string& warning : result.warnings) spdlog::warn("{}: {}", file, warning);
  for (const std::string& warning : implausible(result.ship)) spdlog::warn("{}: {}", file, warning);
  result.json["provenance"] = provenance(app, opt.common, {file});
  io::write_text(opt.output, io::to_text(result.json));
}

void run_scale(const CLI::App& app, const SimOptions& opt, double length_m) {
  Inputs().config("ships", opt.ship).keep_from({opt.output});
  const Ship ship = read_ship(opt.ship);
  if (ship.file == "-") throw UsageError("--ship: expected a file or a shipped name, got '-'");
  estimate::ScaledShip scaled = estimate::scale_ship(io::read_json(ship.file), ship, length_m);
  for (const estimate::ScaleCorrection& c : scaled.corrections)
    spdlog::info("{}: {:.4g} to {:.4g}, log-sd {:.3f} more: {}", c.name, c.before, c.after, c.added_log_sd, c.why);
  for (const std::string& warning : scaled.warnings) spdlog::warn("{}: {}", ship.file, warning);
  scaled.json["provenance"] = provenance(app, opt.common, {ship.file});
  io::write_text(opt.output, io::to_text(scaled.json));
}

}  // namespace

Command add_estimate_command(CLI::App& app, SimOptions& opt, EstimateOptions& o) {
  CLI::App* sub = app.add_subcommand(
      "estimate", "a ship from its principal particulars: each coefficient with source, range and uncertainty");
  sub->add_option("particulars", o.particulars,
                  "particulars (JSON), or the name of shipped ones: kvlcc2, mariner, s175");
  sub->add_option(
      "--without", o.without,
      "leave a measured hull out of the fit of the uncertainties (repeatable); docs/estimate.md lists them");
  sub->add_flag(
      "--compare", o.compares,
      "in place of a ship: all measured hulls, estimated beside measured, each with uncertainties fitted without it");
  add_output(*sub, opt, "ship (JSON), '-' for stdout");
  return {sub, [&app, &opt, &o] { run_estimate(app, opt, o); }};
}

Command add_scale_command(CLI::App& app, SimOptions& opt, double& length_m) {
  CLI::App* sub = app.add_subcommand(
      "scale",
      "a ship of another size: Froude's law, friction and wake by the ITTC's procedures, each correction named");
  sub->add_option("--ship", opt.ship, "ship (JSON), or the name of a shipped one: 'mmg-sim ships' lists them")
      ->required();
  sub->add_option("--length-m", length_m, "length between perpendiculars of the ship that is wanted [m]")
      ->check(in_range(0.1, 1000.0))
      ->required();
  add_output(*sub, opt, "ship (JSON), '-' for stdout");
  return {sub, [&app, &opt, &length_m] { run_scale(app, opt, length_m); }};
}

}  // namespace leeway::cli
