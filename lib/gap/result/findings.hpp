#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "core/types.hpp"
#include "gap/policy/policy.hpp"
#include "gap/result/sensor_findings.hpp"
#include "gap/result/verdict.hpp"

/// What gap-locate finds: plain results, which report.hpp writes and draws.
namespace leeway::gap {

inline constexpr std::array<const char*, 3> kAxisNames{"surge", "sway", "yaw"};

/// The residual along one recording, on the filter's time grid. Acceleration: what has to be added to the model's
/// (u', v_m' [m/s^2], r' [rad/s^2]); force: the same times the inertia matrix (X, Y [N], N [N m]) at midship.
struct Residual {
  std::string recording, file;
  std::vector<double> t_s;
  std::vector<Vec3<double>> acceleration, acceleration_sd, force, force_sd;
  std::vector<Vec3<double>> eta, nu;      ///< smoothed states, (x0, y0 [m], psi [rad]), (u, v_m [m/s], r [rad/s])
  std::vector<Vec3<double>> measured_nu;  ///< as used, NaN where missing
  bool has_position = true;
};

/// A parameter of the model that may move within its stated uncertainty.
struct ParameterShift {
  std::string name;        ///< "hull.Y_v", "wind.k_Y", ...
  double factor = 1.0;     ///< on the value of the ship's JSON
  double factor_sd = 0.0;  ///< what is left of the uncertainty
  double prior_log_sd = 0.0;
  double shift_sd =
      0.0;  ///< ln(factor)/prior_log_sd, or of a parameter with an absolute uncertainty its difference by that
  /// Of a parameter with an absolute uncertainty, in its own unit; prior_log_sd is 0 then.
  struct Difference {
    double estimate = 0.0, sd = 0.0, prior_sd = 0.0;
  };
  std::optional<Difference> difference = std::nullopt;
};

/// An error that positions and velocities share, of one receiver: a velocity of each component.
struct ReceiverError {
  double sd_mps = 0.0, tau_s = 0.0;  ///< standard deviation, correlation time
};

struct NullFit {
  std::vector<ParameterShift> parameters;
  Estimate actuator_lag;  ///< how much later than recorded the actuators moved, by the recordings' sampling time
  Vec3<double> sigma_w = Vec3<double>::Zero();     ///< sd of the model error (m/s^2, m/s^2, rad/s^2)
  Vec3<double> sigma_w_sd = Vec3<double>::Zero();  ///< its standard error
  Vec3<double> typical = Vec3<double>::Zero();  ///< rms of the recorded accelerations, at least what is worth finding
  double tau_s = 0.0;                           ///< correlation time of the model error
  std::optional<double> wind_share;       ///< sd of the recorded wind's error by its mean speed, where wind is recorded
  std::optional<ReceiverError> receiver;  ///< where positions and velocities err together
  std::vector<Estimate> noise;            ///< of one sample of the filter's grid: "u_mps", "r_degps", ...
  double coefficient_scale = 1.0;         ///< by which the coefficients are more uncertain than stated: likeliest
  double log_likelihood = 0.0, log_likelihood_per_sample = 0.0;
  std::size_t samples = 0;  ///< scalar measurements
  double step_s = 0.0;      ///< the filter's time grid
  int iterations = 0;
  double gradient = 0.0;        ///< largest, of -ln posterior by parameters in prior sd
  double distance = 0.0;        ///< of the parameters from where the gradient vanishes, in posterior sd
  double noise_gradient = 0.0;  ///< largest, of -ln likelihood by ln of the noise levels
  bool converged = false;
  std::size_t outliers = 0;
  bool is_noise_free = false;  ///< u, v_m and r show no more noise than inputs between samples leave: simulated?
};

/// One member of the library of effects, screened.
struct Screened {
  std::string name;
  double p_value = 1.0;  ///< alone
  double log_bayes_factor = 0.0;
  /// Over left-out recordings, or blocks of a single one [nats]; NaN for effects that lie too far behind to be
  /// refitted.
  double heldout_gain = std::numeric_limits<double>::quiet_NaN();
  double heldout_gain_sd = std::numeric_limits<double>::quiet_NaN();
};

struct Detection {
  double p_value = 1.0;                              ///< family-wise
  double whiteness_p_value = 1.0;                    ///< of the innovations
  double largest_autocorrelation = 0.0;              ///< of the innovations, in absolute value
  double false_alarm = kPolicy.detect.false_alarm;   ///< the rate that the verdict keeps
  double heldout_gain = 0.0, heldout_gain_sd = 0.0;  ///< of the best effect
  std::vector<Screened> effects;                     ///< best first
  std::string reason;                                ///< why this verdict, to a person
  std::vector<std::string> untested;                 ///< effects that these recordings cannot show, and why
  /// How far effects look alike in these recordings: the share of the signature of one (row) that another (column)
  /// imitates, after the ship's own parameters. Of the effects that the recordings excite, in the catalogue's order.
  std::vector<std::string> compared;
  Eigen::MatrixXd imitated;
};

/// An input of the networks that lies beyond its range in the training data, in a share of the points.
struct OutsideInput {
  std::string name;
  double share = 0.0;
};

/// How well an ensemble knows what it does in an interval.
struct Training {
  bool is_untrained = false;
  double outside_share = 0.0;         ///< of the points: an input lies beyond the training data
  std::vector<OutsideInput> outside;  ///< which, most often first
  double spread = 0.0;                ///< sd of the members' accelerations on the interval's axis
  double mismatch_by_spread = 0.0;    ///< mean acceleration that is missing on that axis, by the spread
};

struct Interval {
  std::string file, recording;
  double t_start_s = 0.0, t_end_s = 0.0;
  int axis = 0;                                      ///< 0 surge, 1 sway, 2 yaw: the one where it shows most
  double p_value = 1.0;                              ///< family-wise over all intervals
  Vec3<double> acceleration = Vec3<double>::Zero();  ///< mean over the interval
  Mat3<double> covariance = Mat3<double>::Zero();    ///< of the mean
  std::optional<Training> training = std::nullopt;   ///< where the simulator is an ensemble
  /// Less than a fifth of the typical acceleration of its axis: as much as the forms of a simulator's forces may err.
  bool is_small = false;
  bool is_untrained() const { return training && training->is_untrained; }
};

/// How the residual of one axis depends on one variable.
struct Regime {
  std::string variable;  ///< "u", "beta", "r_prime", "delta", "n_p", "n_bt", "U_A", "gamma_A", "psi", "x0", "y0", "t"
  std::string relation;  ///< "linear", "quadratic", ...
  std::string sentence;
  int axis = 0;
  double p_value = 1.0, q_value = 1.0;   ///< alone; with false-discovery control over all regimes
  double share = 0.0;                    ///< of the axis's residual variance
  std::vector<double> x, mean, mean_sd;  ///< binned, for the plot: variable, residual acceleration, its sd
  std::string x_label;                   ///< with unit
};

/// In which frame the residual is constant.
struct Frame {
  std::string name;           ///< "body", "earth", "apparent-wind", "water-speed", "position", "actuator"
  double log_evidence = 0.0;  ///< against no residual at all [nats]
  double share = 0.0;         ///< of the residual's energy
  bool is_of_place = false;   ///< whether it belongs to the place: walls and lines are tried
};

/// A module whose gain may walk: how much that whitens the rest.
struct WalkingGain {
  std::string module;  ///< "hull", "propeller", "rudder", "thruster", "wind"
  double log_likelihood_gain = 0.0;
  double gain_sd = 0.0;         ///< of the walking gain about 1
  double sigma_w_factor = 1.0;  ///< what is left of the model error (root mean square over the axes)
};

struct Located {
  Vec3<double> share = Vec3<double>::Zero();  ///< of the residual's energy; yaw by a radius of gyration of 0.25 L_pp
  std::optional<Estimate> line_of_action;     ///< x_F/L_pp, + forward; nothing where there is no side force
  std::vector<Interval> intervals;
  std::vector<Frame> frames;         ///< best first
  std::vector<Regime> regimes;       ///< those that hold, most certain first
  std::vector<WalkingGain> modules;  ///< best first
};

/// The ensemble that recordings were compared with.
struct EnsembleUsed {
  std::string name;
  int members = 0;
  double time_step_s = 0.0;
  std::string base;                            ///< name of the base ship; empty: none
  double outside_share = 0.0;                  ///< of all points: an input lies beyond the training data
  Vec3<double> spread = Vec3<double>::Zero();  ///< rms over all points of the members' sd (m/s^2, m/s^2, rad/s^2)
};

/// How the tool was called, for commands that run as they stand.
struct Called {
  std::string ship, recordings;  ///< as a shell takes them; recordings: with their columns map
  std::string output;            ///< folder
};

struct Findings {
  std::string ship;
  Called called = {};
  std::optional<EnsembleUsed> ensemble = std::nullopt;  ///< nothing: the ship's equations of motion
  Verdict verdict = Verdict::undecided;
  Conventions conventions;
  Audit audit;
  bool corrected = false;  ///< whether the faults found were corrected before the fit
  NullFit fit;
  Detection detection;
  TestsFound tests;  ///< that the verdict is based on
  Located located;
  std::vector<Residual> residuals;
  bool grossly_inconsistent = false;  ///< many parameters far off, much unexplained: another ship's recordings?
  std::vector<std::string> notices;   ///< weightiest first
  double L_pp = 0.0;
};

}  // namespace leeway::gap
