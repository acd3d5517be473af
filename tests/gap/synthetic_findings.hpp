#pragma once

#include <cmath>
#include <string>

#include "core/units.hpp"
#include "gap/result/findings.hpp"

namespace leeway::test {

/// Three zigzags of a 3 m model that a wind from abeam pushes from 120 s to 260 s in the second one; the fault, the
/// names and the sizes are as gap-locate finds them. One file's name holds what HTML and JSON have to escape.
inline gap::Findings mismatch_findings(std::size_t points = 400) {
  gap::Findings f;
  f.ship = "esso-osaka-3m";
  f.L_pp = 3.0;
  f.verdict = gap::Verdict::mismatch;
  f.corrected = true;
  f.conventions.tested = {
      {"wind_dir", "wind-to", "wind_dir_deg read as where the wind blows to fits worse", -42.5, 1.31},
      {"delta", "port-positive", "delta_deg read as positive to port fits far worse", -1830.0, 2.7}};
  f.conventions.unchecked = {"i_bt: no recording has it"};

  f.audit.is_checked = true;
  const gap::Fault bias{
      "heading-bias", {{"heading_bias_deg", 2.97, 0.21}},
      14.2,           2.6,
      0.0003,         "the heading is 2.97 deg (sd 0.21) too high, or the log is turned by as much to port"};
  const gap::Fault lever{
      "lever-arm", {{"lever_x_m", 0.11, 0.05}, {"lever_y_m", -0.02, 0.04}},
      0.4,         0.9,
      0.31,        "the position is that of a point 0.11 m (sd 0.05) ahead of the one that u and v_m belong to"};
  f.audit.faults = {bias};
  f.audit.hypotheses = {bias, lever};
  f.audit.channels = {{Channel::u, 0.0102, 0.0, 0.0, 0.0, 0.0, 0.001},
                      {Channel::vm, 0.0098, 0.0, 0.0, 0.002, 0.0, 0.001},
                      {Channel::r, deg_to_rad(0.104), 1.8, 0.9, 0.0, 0.013, 0.0},
                      {Channel::psi, deg_to_rad(0.05), 0.0, 0.0, 0.0, 0.0, deg_to_rad(0.1)}};
  f.audit.notices = {"not visible here: a lever arm that positions and velocities share"};
  f.audit.log_through_water = false;

  f.fit.parameters = {{"hull.Y_v", 1.38, 0.06, 0.15, std::log(1.38) / 0.15},
                      {"hull.N_v", 0.93, 0.05, 0.15, std::log(0.93) / 0.15},
                      {"propeller.K_T", 1.02, 0.03, 0.05, std::log(1.02) / 0.05},
                      {"rudder.F_N", 0.97, 0.04, 0.10, std::log(0.97) / 0.10},
                      {"inertia.m_y", 1.01, 0.14, 0.15, std::log(1.01) / 0.15},
                      {"wind.k_Y", 0.64, 0.08, 0.15, std::log(0.64) / 0.15}};
  f.fit.sigma_w = {0.00042, 0.0019, deg_to_rad(0.0113)};
  f.fit.sigma_w_sd = {0.00003, 0.00012, deg_to_rad(0.0009)};
  f.fit.typical = {0.0105, 0.0152, deg_to_rad(0.38)};
  f.fit.tau_s = 12.0;
  f.fit.noise = {{"u_mps", 0.0104, 0.0002}, {"r_degps", 0.102, 0.002}};
  f.fit.log_likelihood = 9123.4;
  f.fit.log_likelihood_per_sample = 2.534;
  f.fit.samples = 7200;
  f.fit.step_s = 1.0;
  f.fit.iterations = 9;
  f.fit.gradient = 0.0031;
  f.fit.noise_gradient = 0.0008;
  f.fit.converged = true;
  f.fit.outliers = 4;

  f.detection.p_value = 0.0002;
  f.detection.whiteness_p_value = 0.004;
  f.detection.heldout_gain = 21.3;
  f.detection.heldout_gain_sd = 3.9;
  f.detection.effects = {{"unmeasured-wind", 0.0002, 38.1, 21.3, 3.9},
                         {"wave-drift", 0.0006, 31.0, 17.2, 4.4},
                         {"earth-force", 0.0011, 26.4, 15.0, 4.9},
                         {"steady-current", 0.02, 9.7, 4.1, 3.0},
                         {"fouling", 0.6, -1.8, -0.7, 0.6},
                         {"thruster-gain", 0.9, -2.2, -1.1, 0.5}};
  f.detection.reason =
      "An effect of the catalogue improves recordings that it was not fitted to by more than five standard errors.";

  f.located.share = {0.06, 0.71, 0.23};
  f.located.line_of_action = gap::Estimate{"x_F_over_L_pp", -0.083, 0.021};
  const std::string awkward = "data/zigzag <2> & \"gust\".csv";
  f.located.intervals = {
      {awkward, "zigzag <2> & \"gust\"", 120.0, 260.0, 1, 0.0004, {0.0002, 0.0031, deg_to_rad(-0.012)}},
      {"data/zigzag-3.csv", "zigzag-3", 40.0, 75.0, 2, 0.008, {0.0, 0.0004, deg_to_rad(0.019)}}};
  f.located.frames = {{"apparent-wind", 41.0, 0.83},
                      {"earth", 36.2, 0.74},
                      {"body", 8.1, 0.22},
                      {"position", 3.0, 0.1},
                      {"actuator", -1.5, 0.01}};
  f.located.modules = {{"wind", 33.0, 0.45, 0.41}, {"hull", 12.0, 0.20, 0.77}, {"rudder", 2.1, 0.06, 0.97}};
  for (const int axis : {1, 2}) {
    gap::Regime regime{.variable = axis == 1 ? "U_A" : "psi",
                       .relation = axis == 1 ? "quadratic" : "linear",
                       .sentence = axis == 1 ? "the sway residual grows with the square of the apparent wind speed"
                                             : "the yaw residual turns with the heading",
                       .axis = axis,
                       .p_value = 0.0001 * axis,
                       .q_value = 0.002 * axis,
                       .share = 0.62 / axis,
                       .x = {},
                       .mean = {},
                       .mean_sd = {},
                       .x_label = axis == 1 ? "apparent wind speed U_A [m/s]" : "heading psi [deg]"};
    for (int bin = 0; bin < 9; ++bin) {
      regime.x.push_back(axis == 1 ? 0.4 + 0.35 * bin : -80.0 + 20.0 * bin);
      regime.mean.push_back(axis == 1 ? 0.0003 * regime.x.back() * regime.x.back()
                                      : deg_to_rad(1.5e-4 * regime.x.back()));
      regime.mean_sd.push_back(axis == 1 ? 0.00018 : deg_to_rad(0.0021));
    }
    f.located.regimes.push_back(regime);
  }

  const std::array<std::string, 3> files{"data/zigzag-1.csv", awkward, "data/zigzag-3.csv"};
  for (std::size_t k = 0; k < files.size(); ++k) {
    gap::Residual r;
    r.file = files[k];
    r.recording = r.file.substr(5, r.file.size() - 9);
    double x0 = 0.0, y0 = 0.0;
    for (std::size_t i = 0; i < points; ++i) {
      const double t = static_cast<double>(i), phase = 0.05 * t + static_cast<double>(k);
      const bool pushed = k == 1 && t >= 120.0 && t <= 260.0;
      const Vec3<double> a{0.0002 * std::sin(3.1 * phase) + 0.0001 * std::sin(17.0 * phase),
                           0.0005 * std::sin(2.3 * phase) + 0.0003 * std::sin(13.0 * phase) + (pushed ? 0.0031 : 0.0),
                           deg_to_rad(0.006 * std::sin(1.7 * phase) - (pushed ? 0.012 : 0.0))};
      const double psi = 0.35 * std::sin(phase) + 0.8 * static_cast<double>(k);
      x0 += 0.4 * std::cos(psi);
      y0 += 0.4 * std::sin(psi);
      r.t_s.push_back(t);
      r.acceleration.push_back(a);
      r.acceleration_sd.push_back({0.0002, 0.0005, deg_to_rad(0.004)});
      r.force.push_back({300.0 * a(0), 520.0 * a(1), 260.0 * a(2)});
      r.force_sd.push_back({0.06, 0.26, 0.018});
      r.eta.push_back({x0, y0, psi});
      r.nu.push_back({0.4, 0.02 * std::cos(phase), 0.0175 * std::cos(phase)});
      r.measured_nu.push_back({kMissing, 0.0, 0.0});
    }
    f.residuals.push_back(r);
  }
  f.notices = {"13 samples of r_degps repeat one value: they are left out"};
  return f;
}

/// One recording without positions that the simulator explains: nothing is located, all lists are empty.
inline gap::Findings agreement_findings() {
  gap::Findings f = mismatch_findings();
  f.verdict = gap::Verdict::no_mismatch;
  f.corrected = false;
  f.audit = {};
  f.audit.is_checked = true;
  f.conventions = {};
  f.fit.parameters = {{"hull.Y_v", 1.04, 0.09, 0.15, std::log(1.04) / 0.15}};
  f.detection = {};
  f.detection.p_value = 0.41;
  f.detection.reason = "No effect of the catalogue improves recordings that it was not fitted to.";
  f.located = {};
  f.residuals.resize(1);
  f.residuals[0].has_position = false;
  f.notices = {};
  return f;
}

}  // namespace leeway::test
