#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/units.hpp"
#include "dynamics/simulation.hpp"
#include "ensemble/prediction.hpp"

namespace leeway::control {

/// Gains of the heading controller delta = -K_P (psi - psi_bar) - K_D r, the same command to every rudder, clipped to
/// each rudder's own range. The command is in degrees of rudder: see docs/pd-sweep.md for why.
struct PdGains {
  double kp = 0.0;  ///< [deg of rudder per rad of heading]
  double kd = 0.0;  ///< [deg of rudder per rad/s of yaw rate]

  /// The command [rad] before clipping, for a heading error [rad] and a yaw rate [rad/s].
  double command(double heading_error, double r) const { return -deg_to_rad(kp * heading_error + kd * r); }
};

/// The heading-keeping task of the ensemble paper: from psi = 0 and straight ahead at u0 to psi_bar, calm air,
/// thrusters off, propeller as the ship starts.
struct HeadingTask {
  double psi_bar = 0.5 * kPi;  ///< [rad]
  double u0_mps = 0.5;
  double duration_s = 100.0, dt_s = 0.1;
};

/// One closed-loop run on the samples of 1 s, for trajectories.
struct ControlledRun {
  std::vector<Vec3<double>> eta, nu;
  std::vector<double> rudder;  ///< [rad], one per rudder and sample
};

/// A gain pair and what it does.
struct SweepResult {
  PdGains gains;
  double score_true = 0.0;                                       ///< L_PD of the true ship [rad s], larger is worse
  std::vector<double> score_members;                             ///< of each member
  double score_mean = 0.0, score_worst = 0.0, score_best = 0.0;  ///< over the particles
  ControlledRun run_true;                                        ///< empty unless asked for
  std::vector<ControlledRun> runs;                               ///< one per member; empty unless asked for
};

/// Judges heading controllers by the true ship and by the particles of an ensemble (TS-infinity: each particle keeps
/// its member; the same particles for all gains). With a disturbance each particle has a path of its own, the same for
/// all gains; a member's score and run are then those of its first particle, or of a run without one where it has no
/// particle.
///   L_PD = integral over the task of |psi - psi_bar| + |r| dt, psi and r in rad and rad/s (trapezoidal)
///   progress  told the share of the runs that is done, by any thread
/// Throws UsageError if the ensemble's actuators are not those of the ship or if the duration (and, where runs are
/// kept, 1 s) is no multiple of the time step; NumericalError if a run is no finite number.
std::vector<SweepResult> pd_sweep(const Ship& ship, const ensemble::Ensemble& ensemble,
                                  const std::vector<PdGains>& gains, const HeadingTask& task, int particles,
                                  std::uint64_t seed, std::size_t jobs, bool keep_runs,
                                  const ensemble::Disturbance& disturbance = {},
                                  const std::function<void(double)>& progress = nullptr);

/// "5:100:5": from 5 to 100 in steps of 5, both ends included; "60": one value; "20,40": a list. Throws UsageError.
std::vector<double> parse_gain_range(const std::string& option, const std::string& text);

/// kp_deg_per_rad, kd_deg_per_radps, score_true, score_mean, score_worst, score_best, score_member_00, ...
std::string sweep_csv(const std::vector<SweepResult>& results);

/// model (true, 00, 01, ...), t_s, x0_m, y0_m, psi_deg, u_mps, vm_mps, r_degps and the ship's rudders.
std::string runs_csv(const SweepResult& result, const Ship& ship);

}  // namespace leeway::control
