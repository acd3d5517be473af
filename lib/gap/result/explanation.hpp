#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "gap/policy/policy.hpp"
#include "gap/result/bootstrap.hpp"
#include "gap/result/findings.hpp"
#include "gap/result/latent_force.hpp"
#include "gap/result/next_plan.hpp"
#include "gap/result/ship_file.hpp"
#include "recording/trajectory.hpp"
#include "ship/ship.hpp"

/// What gap-explain finds: plain results, which the stages hand on and the reports write.
namespace leeway::gap {

/// One parameter of one effect or sensor fault, in the unit that its name carries.
struct ExplainedParameter {
  std::string effect, name;
  std::string recording;  ///< where it differs between recordings; the first stands for their mean, without one
  double estimate = 0.0, sd = 0.0, low = 0.0, high = 0.0;  ///< low, high: 95 % interval
  double prior_low = 0.0, prior_high = 0.0;                ///< the same before any recording was seen; NaN: unknown
  bool is_at_bound = false;                                ///< a bound of the catalogue is within its sd
};

/// What is said of one effect or fault.
struct Said {
  std::string name, sentence, separating_maneuver;
};

/// A set of effects that may be what is missing, fitted to the recordings beside the ship's uncertain parameters.
struct Explained {
  std::string name;                  ///< "steady-current + rudder-offset"; "none"
  std::vector<std::string> effects;  ///< none: nothing is missing
  double probability = 0.0;          ///< among all that were fitted
  double log_evidence = 0.0;         ///< against nothing missing [nats]
  double heldout_gain = 0.0;         ///< sum over what was left out in turn [nats], against nothing missing
  double heldout_gain_sd = 0.0;      ///< its standard error
  bool converged = false;
  bool is_chosen = false;  ///< whether it is what is claimed
  /// Odds of one effect more, of which too little was expected to fit it, against this hypothesis alone.
  std::map<std::string, double> unseen{};
  /// With this hypothesis, the probability that a coefficient is off by far more than the ship file states.
  std::map<std::string, double> coefficients_off{};
  std::vector<ExplainedParameter> parameters;
  /// With this hypothesis, how far a number of a sensor's fault is from that which was corrected, in units of what was
  /// left open of it; by the name of its first parameter.
  std::map<std::string, Estimate> of_faults{};
  std::vector<std::string> confusable_with;   ///< names of hypotheses that the recordings do not exclude against this
  std::vector<Said> said{};                   ///< of each effect and fault
  std::string separating_maneuver, sentence;  ///< the same in one
};

/// How well a simulator runs free from recorded states, and how likely it makes the recordings.
struct Score {
  std::size_t points = 0;
  double rmse_u_mps = kMissing, rmse_vm_mps = kMissing, rmse_r_degps = kMissing, rmse_position_m = kMissing;
};
struct Scores {
  std::map<int, Score> free_runs;               ///< by their length [s]: 30, 100, 300
  double log_likelihood_per_sample = kMissing;  ///< of the filter, parameters integrated out where they were fitted
  std::map<int, double> coverage;               ///< share of innovations within their interval of 50, 90, 95, 99 %
  std::map<std::string, Score> by_recording;    ///< free runs of kShownHorizon_s
};
inline constexpr int kShownHorizon_s = static_cast<int>(kPolicy.show.shown_horizon_s);
/// Positions [m] in earth axes and velocities (u, v_m [m/s], r [rad/s]), as measured and along runs; NaN between runs.
struct FreeTrack {
  std::string recording;
  std::vector<double> t_s;
  std::vector<Vec2<double>> measured, run;
  std::vector<Vec3<double>> measured_nu = {}, run_nu = {};
  void add(double t, const Eigen::Matrix<double, 6, 1>& seen, const Eigen::Matrix<double, 6, 1>& at) {
    t_s.push_back(t);
    measured.emplace_back(seen.head<2>());
    run.emplace_back(at.head<2>());
    measured_nu.emplace_back(seen.tail<3>());
    run_nu.emplace_back(at.tail<3>());
  }
};
struct BeforeAfter {
  Scores before, after;
};

/// The water's velocity in one recording, in earth axes.
struct CurrentPath {
  std::string recording;
  std::vector<double> t_s;
  std::vector<Vec2<double>> velocity_mps, sd_mps;  ///< to the north (x0) and to the east (y0)
};

/// A turning circle of ship.json with more rudder than was recorded.
struct BeyondRecorded {
  double recorded_deg = 0.0, rudder_deg = 0.0;
  double diameter_L = 0.0, low_L = 0.0, high_L = 0.0;  ///< tactical, by L_pp; 95 % interval of the posterior
};

/// Of coefficients that were fitted alone.
struct Calibration {
  bool helps = false;                 ///< whether free runs over what was not fitted follow better, beyond chance
  double scale = 1.0;                 ///< by which all coefficients are more uncertain than the file states
  Ship::JointUncertainty covariance;  ///< what the recordings leave open of them
};

struct Explanation {
  Findings findings;
  Verdict verdict = Verdict::undecided;
  double p_value = 1.0;
  std::string reason;                                  ///< why it is undecided, to a person; empty where it is not
  std::vector<Explained> hypotheses;                   ///< most probable first; "none" is one of them
  std::vector<std::string> chosen;                     ///< names; "unknown" where the catalogue does not hold it
  bool is_complete = true;                             ///< whether nothing significant is left beside what was chosen
  double left_p_value = 1.0;                           ///< of what is left then
  std::vector<LatentForce> unknown_kinds;              ///< what that may be by what it depends on, the likeliest first
  std::vector<ParameterShift> parameters;              ///< of the ship, with what was chosen
  std::vector<EffectEntry> effects;                    ///< that ship.json has more than the ship
  std::vector<std::string> withheld;                   ///< chosen effects that make the given held-out recordings worse
  std::vector<CoefficientFactor> coefficient_factors;  ///< and these, if it then follows what is left out better
  std::optional<Calibration> calibration;              ///< where coefficients alone were asked for
  /// By recording, where they differ: what acts there.
  std::map<std::string, std::vector<EffectEntry>> effects_in;
  std::vector<CurrentPath> current_paths;  ///< of a chosen current that varies, by recording
  BeforeAfter train, heldout;
  ShipFile ship_file;  ///< what is said of it beside that
  std::optional<BeyondRecorded> beyond_recorded;
  std::optional<double> n_rps;  ///< hold the usual speed of ship.json, where those of the file do not
  /// Where something is unknown: a small network on top of ship.json, if it predicts what is left out in turn better
  /// than the ship does without; mean logarithm of the errors of free runs there.
  std::shared_ptr<const ResidualNetwork> residual_network;
  double log_error_without_network = kMissing, log_error_with_network = kMissing;
  std::vector<FreeTrack> tracks_before, tracks_after;  ///< of what was held out
  std::vector<Residual> residuals_after;               ///< what is left of the residual with what was chosen
  bool heldout_is_given = false;                       ///< false: recordings, or blocks of a few, were left out in turn
  bool heldout_is_followed = true;                     ///< by ship.json, within the noise of the others; where given
  double heldout_gain = 0.0, heldout_gain_sd = 0.0;    ///< of what was chosen [nats]
  std::optional<Bootstrap> bootstrap;                  ///< where probabilities were made true of simulated campaigns
  /// Where several hypotheses are possible: how certain the best is, and what would distinguish them.
  double p_right = 1.0;
  std::optional<NextPlan> next;
  std::vector<std::string> notices;
};

}  // namespace leeway::gap
