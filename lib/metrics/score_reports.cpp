#include <array>
#include <cmath>
#include <iterator>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/units.hpp"
#include "io/csv.hpp"
#include "io/trajectory_csv.hpp"
#include "metrics/scores.hpp"

/// What is said of an evaluation: JSON, CSV, a line per data set.
namespace leeway {
namespace {

constexpr std::array<const char*, 3> kVelocityNames{"u", "vm", "r"};

io::Json number_or_null(double x) { return !std::isfinite(x) ? io::Json(nullptr) : io::Json(x); }

io::Json units() {
  return {{"L_eucl", "(m/s)^2 + (rad/s)^2"},
          {"L_maha", "1"},
          {"maha_undefined_fraction", "1"},
          {"correlation_eucl_maha", "1"},
          {"rmse_u_mps", "m/s"},
          {"rmse_vm_mps", "m/s"},
          {"rmse_r_degps", "deg/s"},
          {"rmse_position_m", "m"},
          {"coverage", "1"},
          {"maha_honest", "1"},
          {"energy_score", "sqrt((m/s)^2 + (rad/s)^2)"},
          {"log_score", "-ln(1/((m/s)^2 rad/s))"},
          {"crps", "m/s, m/s, deg/s"},
          {"pit", "1"},
          {"L_fit", "1"}};
}

io::Json to_json(const Scores& s) {
  io::Json json{{"name", s.name},
                {"sequences", s.sequences},
                {"steps", s.steps},
                {"particles", s.particles ? io::Json(*s.particles) : io::Json(nullptr)},
                {"points", s.points},
                {"missing_truth", s.missing_truth},
                {"L_eucl", number_or_null(s.L_eucl)},
                {"L_maha", number_or_null(s.L_maha)},
                {"maha_undefined_fraction", number_or_null(s.maha_undefined_fraction)},
                {"correlation_eucl_maha", number_or_null(s.correlation)},
                {"members", s.members},
                {"sampling", s.sampling},
                {"against", s.against},
                {"initial_state", s.initial_state},
                {"rmse_u_mps", number_or_null(s.rmse(0))},
                {"rmse_vm_mps", number_or_null(s.rmse(1))},
                {"rmse_r_degps", number_or_null(rad_to_deg(s.rmse(2)))},
                {"rmse_position_m", number_or_null(s.rmse_position)}};
  io::Json coverage = io::Json::object();
  for (std::size_t i = 0; i < kCoverageLevels.size(); ++i)
    coverage[fmt::format("{:.0f}", 100.0 * kCoverageLevels[i])] = number_or_null(s.coverage[i]);
  json["coverage"] = coverage;
  json["maha_honest"] = number_or_null(s.maha_honest);
  json["energy_score"] = number_or_null(s.energy_score);
  json["log_score"] = number_or_null(s.log_score);
  json["crps"] = {{"u_mps", number_or_null(s.crps(0))},
                  {"vm_mps", number_or_null(s.crps(1))},
                  {"r_degps", number_or_null(rad_to_deg(s.crps(2)))}};
  io::Json pit = io::Json::object();
  for (std::size_t i = 0; i < s.pit.size(); ++i)
    for (const double share : s.pit[i]) pit[kVelocityNames[i]].push_back(number_or_null(share));
  json["pit"] = pit;
  json["L_fit"] = number_or_null(s.L_fit);
  json["units"] = units();
  return json;
}

}  // namespace

std::vector<std::string> notices(const Evaluation& evaluation) {
  std::vector<std::string> result;
  std::set<std::string> ignored, absent;
  for (const RecordingScores& recording : evaluation.recordings) {
    ignored.insert(recording.ignored_columns.begin(), recording.ignored_columns.end());
    if (!recording.ignored_columns.empty())
      absent.insert(recording.absent_columns.begin(), recording.absent_columns.end());
  }
  if (const auto notice = io::unread_columns(ignored, absent)) result.push_back(*notice);
  if (!evaluation.empty_files.empty())
    result.push_back(fmt::format("{} of the files of predictions have no row and are skipped: {}",
                                 evaluation.empty_files.size(), io::listed(evaluation.empty_files)));
  if (!evaluation.not_predicted.empty())
    result.push_back(fmt::format(
        "{} of {} recordings have no predicted sequence, as where they are shorter than one, and are in no figure: {}",
        evaluation.not_predicted.size(), evaluation.in_predicted_sets, io::listed(evaluation.not_predicted)));
  const Scores& all = evaluation.overall;
  if (all.missing_truth > 0)
    result.push_back(fmt::format("{} of {} points have no truth (missing samples) and are in no figure",
                                 all.missing_truth, all.missing_truth + all.points));
  return result;
}

io::Json to_json(const Evaluation& evaluation) {
  io::Json datasets = io::Json::array(), recordings = io::Json::array();
  for (const Scores& dataset : evaluation.datasets) datasets.push_back(to_json(dataset));
  for (std::size_t i = 0; i < evaluation.recordings.size(); ++i) {
    io::Json recording = to_json(evaluation.of_recording[i]);
    recording.erase("units");  // those of the data sets
    recording["set"] = evaluation.recordings[i].set;
    recordings.push_back(std::move(recording));
  }
  return {{"datasets", datasets}, {"overall", to_json(evaluation.overall)}, {"recordings", recordings}};
}

std::string per_step_text(const Evaluation& evaluation) {
  std::string text =
      "recording,sequence,step,t_s,u_mean_mps,vm_mean_mps,r_mean_degps,u_sd_mps,vm_sd_mps,r_sd_degps,u_truth_mps,"
      "vm_truth_mps,r_truth_degps,position_error_m,position_sd_m,eucl,maha,maha_honest,energy,log_score,crps_u_mps,"
      "crps_vm_mps,crps_r_degps,pit_u,pit_vm,pit_r\n";
  const auto append = [&](double value) {
    text += ',';
    io::append_number(text, value);
  };
  for (const RecordingScores& recording : evaluation.recordings) {
    const std::string name = io::csv_field(recording.name);
    for (const PointScore& point : recording.points) {
      fmt::format_to(std::back_inserter(text), "{},{},{},{}", name, point.sequence, point.step, point.t_s);
      for (const Vec3<double>* value : {&point.mean, &point.sd, &point.truth}) {
        append((*value)(0));
        append((*value)(1));
        append(rad_to_deg((*value)(2)));
      }
      append(std::sqrt(point.squared_position));
      append(point.position_sd);
      append(std::sqrt(point.squared_eucl));
      append(std::sqrt(point.squared_maha));
      append(point.honest_maha);
      append(point.energy);
      append(point.log_score);
      append(point.crps(0));
      append(point.crps(1));
      append(rad_to_deg(point.crps(2)));
      for (const double pit : point.pit) append(pit);
      text += '\n';
    }
  }
  return text;
}

std::string summary_text(const Evaluation& evaluation) {
  std::string text;
  std::size_t width = 8;
  const auto header = [&](const std::string& of, const std::vector<Scores>& scores) {
    width = 8;
    for (const Scores& s : scores) width = std::max(width, s.name.size());
    width = std::max(width, of.size());
    fmt::format_to(std::back_inserter(text),
                   "{:<{}} {:>9} {:>5} {:>9} {:>11} {:>11} {:>8} {:>13} {:>9} {:>11} {:>9} {:>9} {:>10} {:>8}\n", of,
                   width, "sequences", "K", "particles", "L_eucl", "L_maha", "(honest)", "50/90/99 % in", "undefined",
                   "correlation", "u [m/s]", "vm [m/s]", "r [deg/s]", "pos [m]");
  };
  const auto shown = [](double x, const char* format) {
    return !std::isfinite(x) ? std::string("-") : fmt::format(fmt::runtime(format), x);
  };
  const auto line = [&](const Scores& s) {
    fmt::format_to(
        std::back_inserter(text),
        "{:<{}} {:>9} {:>5} {:>9} {:>11} {:>11} {:>8} {:>13} {:>9} {:>11} {:>9} {:>9} {:>10} {:>8}\n", s.name, width,
        s.sequences, s.steps, s.particles ? fmt::format("{}", *s.particles) : "-", shown(s.L_eucl, "{:.4g}"),
        shown(s.L_maha, "{:.4g}"), shown(s.maha_honest, "{:.3g}"),
        std::isnan(s.coverage[0])
            ? "-"
            : fmt::format("{:.0f}/{:.0f}/{:.0f}", 100.0 * s.coverage[0], 100.0 * s.coverage[1], 100.0 * s.coverage[2]),
        shown(s.maha_undefined_fraction, "{:.3f}"), shown(s.correlation, "{:.3f}"), shown(s.rmse(0), "{:.4f}"),
        shown(s.rmse(1), "{:.4f}"), shown(rad_to_deg(s.rmse(2)), "{:.4f}"), shown(s.rmse_position, "{:.3f}"));
  };
  header("recording", evaluation.of_recording);
  for (const Scores& s : evaluation.of_recording) line(s);
  header("set", evaluation.datasets);
  for (const Scores& s : evaluation.datasets) line(s);
  line(evaluation.overall);
  fmt::format_to(std::back_inserter(text), "laid beside: {}; initial states: {}\n", evaluation.overall.against,
                 evaluation.overall.initial_state);
  return text;
}

}  // namespace leeway
