#pragma once

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "gap/gap_explain.hpp"
#include "gap/synthetic_findings.hpp"

namespace leeway::test {

/// Names that come from outside: files, directories, what a user calls a ship.
struct Names {
  std::string ship = "esso-osaka-3m", ensemble = "five-members";
  std::array<std::string, 3> recordings{"zigzag-1", "zigzag-2", "zigzag-3"};
};

/// The findings under other names, everywhere where a name of a ship or a recording may stand.
inline gap::Findings renamed(gap::Findings f, const Names& names) {
  f.ship = names.ship;
  for (std::size_t k = 0; k < f.residuals.size(); ++k) {
    for (gap::Interval& interval : f.located.intervals)
      if (interval.file == f.residuals[k].file) {
        interval.recording = names.recordings.at(k);
        interval.file = "data/" + names.recordings.at(k) + ".csv";
      }
    f.residuals[k].recording = names.recordings.at(k);
    f.residuals[k].file = "data/" + names.recordings.at(k) + ".csv";
  }
  f.notices.push_back("data/" + names.recordings[0] + ".csv: the first 3 s are not used");
  return f;
}

/// The same, compared with an ensemble that was not trained for the first interval.
inline gap::Findings with_ensemble(gap::Findings f, const std::string& name) {
  f.ensemble = gap::EnsembleUsed{name, 5, 0.5, "", 0.043, {0.00031, 0.00072, deg_to_rad(0.021)}};
  for (gap::Interval& interval : f.located.intervals)
    interval.training = gap::Training{.is_untrained = interval.axis == 1,
                                      .outside_share = interval.axis == 1 ? 0.82 : 0.0,
                                      .outside = {},
                                      .spread = 0.001,
                                      .mismatch_by_spread = interval.axis == 1 ? 3.1 : 14.6};
  return f;
}

/// Where the recorded track of recording k ends (x0, y0 [m]).
inline Vec2<double> planted_end(std::size_t k) { return {40.0 + 10.0 * static_cast<double>(k), 25.5}; }

inline gap::FreeTrack free_track(const std::string& recording, std::size_t k, double astray) {
  gap::FreeTrack track;
  track.recording = recording;
  constexpr int points = 120;
  for (int i = 0; i <= points; ++i) {
    const double share = static_cast<double>(i) / points;
    const Vec2<double> measured{planted_end(k)(0) * std::sin(0.5 * 3.14159265358979 * share),
                                planted_end(k)(1) * share * share};
    // A hole between two runs.
    const Vec2<double> run = i == points / 2 ? Vec2<double>{kMissing, kMissing}
                                             : Vec2<double>{measured(0) + astray * share, measured(1) - astray * share};
    track.t_s.push_back(static_cast<double>(i));
    track.measured.push_back(measured);
    track.run.push_back(run);
    track.measured_nu.emplace_back(0.4, 0.05 * share, deg_to_rad(1.0));
    track.run_nu.emplace_back(0.4 + 0.01 * astray, 0.05 * share, i == points / 2 ? kMissing : deg_to_rad(1.2));
  }
  return track;
}

inline gap::Scores scores(const Names& names, double factor) {
  gap::Scores result;
  for (const int horizon_s : {30, 100, 300})
    result.free_runs[horizon_s] = {.points = 900,
                                   .rmse_u_mps = 0.0305 * factor,
                                   .rmse_vm_mps = 0.0772 * factor,
                                   .rmse_r_degps = 0.891 * factor,
                                   .rmse_position_m = 0.105 * factor * horizon_s};
  for (std::size_t k = 0; k < names.recordings.size(); ++k)
    result.by_recording[names.recordings[k]] = {.points = 300,
                                                .rmse_position_m = factor * (8.0 + static_cast<double>(k))};
  return result;
}

/// A steady current that gap-explain names in the recordings of mismatch_findings(), and a wind that is possible too.
inline gap::Explanation current_explanation(const Names& names = {}) {
  gap::Explanation e;
  e.findings = renamed(mismatch_findings(), names);
  e.findings.detection.compared = {"steady-current", "unmeasured-wind", "rudder-stall"};
  e.findings.detection.imitated = Eigen::MatrixXd{{1.0, 0.62, 0.0}, {0.55, 1.0, 0.004}, {0.0, 0.01, 1.0}};
  e.findings.detection.untested = {"thruster-gain: no recording moves the thruster"};
  e.verdict = gap::Verdict::mismatch;
  e.p_value = 0.00002;

  gap::Explained current{.name = "steady-current",
                         .effects = {"steady-current"},
                         .probability = 0.857,
                         .log_evidence = 477.4,
                         .heldout_gain = 480.3,
                         .heldout_gain_sd = 83.1,
                         .converged = true,
                         .parameters = {},
                         .confusable_with = {"unmeasured-wind"},
                         .separating_maneuver = "a turning circle",
                         .sentence = "The water moves as a whole, steadily and everywhere alike."};
  current.parameters = {
      {"steady-current", "current_speed_mps", "", 0.0999, 0.0012, 0.0975, 0.1023, 0.0, 0.4},
      {"steady-current", "current_set_deg", "", -89.78, 0.26, -90.29, -89.27, -180.0, 180.0},
  };
  gap::Explained wind = current;
  wind.name = "unmeasured-wind";
  wind.effects = {"unmeasured-wind"};
  wind.probability = 0.1429;
  wind.log_evidence = 475.6;
  wind.heldout_gain = 12.4;
  wind.heldout_gain_sd = 4.0;
  wind.parameters = {{"unmeasured-wind", "wind_speed_mps", "", 2.71, 0.5, 1.7, 3.7, kMissing, kMissing}};
  wind.sentence = "A wind blows that was not recorded.";
  gap::Explained nothing{.name = "none",
                         .effects = {},
                         .probability = 1e-9,
                         .parameters = {},
                         .confusable_with = {},
                         .separating_maneuver = "",
                         .sentence = "Nothing is missing."};
  current.is_chosen = true;
  e.hypotheses = {current, wind, nothing};
  e.chosen = {"steady-current"};
  e.effects = {{"steady-current", {{"current_speed_mps", 0.0999}, {"current_set_deg", -89.78}}, "", ""}};
  e.parameters = e.findings.fit.parameters;
  e.heldout_gain = 480.3;
  e.heldout_gain_sd = 83.1;
  e.train = e.heldout = {scores(names, 1.0), scores(names, 0.1)};
  e.p_right = 0.857;
  e.next.emplace().maneuvers = {{"turning circles, 35 deg to both sides", "turning --rudder-deg 35", 600.0, 0.987},
                                {"crash stop", "stop", 240.0, 0.91}};
  for (std::size_t k = 0; k < names.recordings.size(); ++k) {
    e.tracks_before.push_back(free_track(names.recordings[k], k, 9.0));
    e.tracks_after.push_back(free_track(names.recordings[k], k, 0.8));
  }
  e.residuals_after = e.findings.residuals;
  for (gap::Residual& residual : e.residuals_after)
    for (Vec3<double>& acceleration : residual.acceleration) acceleration *= 0.1;
  return e;
}

/// One recording without positions in which nothing is missing.
inline gap::Explanation nothing_explanation() {
  gap::Explanation e;
  e.findings = agreement_findings();
  e.verdict = gap::Verdict::no_mismatch;
  e.p_value = 0.41;
  gap::Explained nothing = current_explanation().hypotheses.back();
  nothing.probability = 1.0;
  e.hypotheses = {nothing};
  return e;
}

}  // namespace leeway::test
