#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "dynamics/replay.hpp"
#include "dynamics/simulation.hpp"
#include "gap/filter/ensemble_simulator.hpp"
#include "gap/filter/uncertainty.hpp"
#include "gap/policy/policy.hpp"
#include "gap/sensors/froude_scale.hpp"

namespace leeway::gap {

using Vec6 = Eigen::Matrix<double, 6, 1>;  ///< (x0, y0 [m], psi [rad], u, v_m [m/s], r [rad/s])

/// The measured channels in the order of Vec6.
inline constexpr std::array<Channel, 6> kMeasured{Channel::x0, Channel::y0, Channel::psi,
                                                  Channel::u,  Channel::vm, Channel::r};

/// Of how many actuators a stretch may have errors.
inline constexpr std::size_t kActuatorErrors = 4;
/// How far what acts may be from what is recorded (ActuatorErrors): one standard deviation, and whether the next step
/// has the same error.
struct ActuatorError {
  std::array<double, kActuatorErrors> sd{};  ///< [rad, 1/s]
  std::array<bool, kActuatorErrors> goes_on{};
};

/// How a helmsman who sees the ship herself moves the rudders: their mean angle is offset + per_heading psi + per_rate
/// r, within sd. Heading as in the recordings, counted through full turns.
struct HelmLaw {
  double offset = 0.0, per_heading = 0.0, per_rate_s = 0.0, sd = 0.0;  ///< [rad, -, s, rad]
  std::vector<Channel> rudders;
  /// The recorded mean angle at each point [rad]; NaN where the rudders are at a limit, and follow nothing.
  std::vector<double> angle;

  double at(double psi, double r) const { return offset + per_heading * psi + per_rate_s * r; }
};

/// Numbers of sensors' faults that recordings were corrected for and that are free beside the coefficients, each in
/// units of what is left open of it: what they add to the measured values at each point, 6 x count.
struct FaultColumns {
  Eigen::Index first = 0;  ///< place of the first number in theta, behind the coefficients
  std::vector<Eigen::Matrix<double, 6, Eigen::Dynamic>> at;  ///< none: no number is free

  Eigen::Index count() const { return at.empty() ? 0 : at.front().cols(); }
  /// Of point k, the numbers being those of theta.
  Vec6 of(std::size_t k, const Eigen::VectorXd& theta) const {
    return at.empty() ? Vec6::Zero() : Vec6(at[k] * theta.segment(first, count()));
  }
};

/// A part of a recording without a long gap, on the filter's time grid; it has an initial state of its own.
struct Stretch {
  std::size_t recording = 0;
  std::vector<double> t_s;
  std::vector<Vec6> measured;                           ///< at t_s; NaN where missing
  std::vector<double> spread_s2;                        ///< variance of the sample times that a point is the mean of
  std::vector<std::vector<StepInputs<double>>> inputs;  ///< from t_s[k] to t_s[k+1], in substeps of equal length
  /// The same with the actuators later by a tenth of the recording's sampling time: how well their motion between
  /// samples is known.
  std::vector<std::vector<StepInputs<double>>> late_inputs;
  std::vector<Channel> uncertain;              ///< actuators that have errors
  std::vector<ActuatorError> actuator_errors;  ///< of each step, in this order; empty: none has
  double wind_speed_mps = 0.0;                 ///< mean of the recorded true wind; 0: no wind is recorded
  double sample_s = 0.0;                       ///< of the recording
  std::optional<HelmLaw> helm;  ///< the law by which a course is kept in it, where the rudders tell more of the ship
                                ///< than the sensors do: they are no inputs then, but follow her
  FaultColumns by_faults;
  std::size_t size() const { return t_s.size(); }
  double dt_s(std::size_t k) const { return t_s[k + 1] - t_s[k]; }
};

/// The recordings as the filter sees them.
struct Campaign {
  Ship ship;
  /// The simulator in place of the ship's equations of motion, of which `ship` is what is known; nullptr: none.
  std::shared_ptr<const EnsembleSimulator> ensemble;
  std::vector<Trajectory> recordings;
  std::vector<std::vector<EffectEntry>> own_effects;  ///< of each recording: of the ship there, and nowhere else
  std::vector<RecordedInputs> recorded_inputs;        ///< one per recording
  std::vector<Stretch> stretches;
  std::vector<UncertainParameter> free_faults;  ///< the numbers in the columns of the stretches
  double step_s = 0.0;                          ///< typical time step of the grid
  bool has_position = false, has_heading = false, has_wind = false;
  std::vector<std::string> notices;

  std::size_t points() const;
  /// The ship as it sails in one recording.
  Ship ship_in(std::size_t recording) const;
  /// Whether accelerations can be stated as forces.
  bool knows_inertia() const { return !ensemble || ensemble->knows_inertia(); }
  /// Times of this ship by those of one of 3 m.
  double time_scale() const { return FroudeScale(ship.particulars.L_pp).time; }
};

/// What acts from t_s to t_s + dt_s: the mean of the recorded inputs over the step, also where they moved in corners
/// that three points do not show, is what Simpson's rule, and so Runge-Kutta's, makes of the result.
StepInputs<double> averaged_step(const RecordedInputs& inputs, double t_s, double dt_s);

/// Puts a recording's inputs on a stretch's grid, in substeps of at most `longest_s`, or sqrt(L/g) of the ship.
void set_inputs(Stretch& stretch, const RecordedInputs& inputs, double longest_s);
void set_inputs(Stretch& stretch, const RecordedInputs& inputs, const Ship& ship);

struct CampaignOptions {
  double step_s = 0.0;  ///< of the grid; 0: 2 sqrt(L/g), or the ensemble's time step; at least the recordings' own
  double gap_s = 0.0;   ///< a longer hole ends a stretch; 0: 30 s at 3 m, scaled by sqrt(L)
  std::shared_ptr<const EnsembleSimulator> ensemble = nullptr;  ///< the simulator; `ship` is then its ship()
};

/// Puts recordings on the filter's grid. Fast recordings are thinned: a point is the mean of the samples in its time
/// bin, at their mean time, so that nothing is interpolated; a missing sample stays missing. Of a channel whose noise
/// is correlated, measurements stay that are about two correlation times apart. Actuators and wind are linear between
/// their samples. Throws InputError for a recording that lacks a column the simulator needs, for two recordings with
/// the same contents, and if nothing is long enough.
Campaign prepare(const Ship& ship, std::vector<Trajectory> recordings, const CampaignOptions& options);

}  // namespace leeway::gap
