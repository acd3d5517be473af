#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "gap/filter/campaign.hpp"
#include "gap/filter/uncertainty.hpp"
#include "gap/policy/policy.hpp"

/// The simulator with model error, as a state-space model that is linear around a path:
///   x = (eta, nu, w, e): pose, velocity, error of the acceleration, error of the recorded true wind;
///   (eta, nu)(k+1) = simulator's step from (eta, nu)(k) with the accelerations w(k) added and the wind e(k);
///   w and e are first-order Gauss-Markov (Ornstein-Uhlenbeck) processes, held over a step.
/// Measured are eta and nu with white noise. Where positions and velocities are of one receiver they share an error
/// beside it, n, a velocity in earth axes that is an Ornstein-Uhlenbeck process as well: u and v_m are measured with it
/// on top, and the position goes where it leads. The filter has its two components as states. Where actuators are not
/// recorded well (ActuatorErrors), it has their errors as states, each in its standard deviation, which stay for as
/// long as an error goes on and are others afterwards. Around a path and parameters theta,
///   dx(k+1) = offset + A dx(k) + G dtheta + noise.
/// Forces would be the wrong place for the error: a lighter ship would make it cheaper (docs/gap-locate.md).
/// Where the simulator is an ensemble, the stationary covariance of w grows by that of its members' accelerations;
/// where a ship's model switches, by what nobody knows who does not know exactly when.
namespace leeway::gap {

inline constexpr int kStates = 11, kShipStates = 6, kErrorStart = 6, kWindStart = 9;
/// With the error of a receiver, which acts on no ship, and with those of the inputs: states of the filter alone.
inline constexpr int kReceiverStart = kStates, kReceiverStates = kStates + 2, kActuatorStart = kReceiverStates,
                     kFilterStates = kActuatorStart + static_cast<int>(kActuatorErrors);
using StateVector = Eigen::Matrix<double, kStates, 1>;
using StateMatrix = Eigen::Matrix<double, kStates, kStates>;
/// Derivatives of `rows` quantities by many columns, one row after another: what the filter does to rows goes along
/// them.
template <int rows>
using ByRow = Eigen::Matrix<double, rows, Eigen::Dynamic, Eigen::RowMajor>;

/// What acts in a step where the true wind errs by `wind_error` (from-vector in earth axes [m/s]).
template <typename T>
StepInputs<T> with_error(const StepInputs<double>& inputs, const Vec2<T>& wind_error) {
  const auto at = [&](const Inputs<double>& in) {
    return Inputs<T>{in.actuators.template cast<T>(), Vec2<T>(in.true_wind.template cast<T>() + wind_error), in.t_s};
  };
  return {at(inputs.start), at(inputs.middle), at(inputs.end)};
}

/// One step of the simulator over a grid interval.
///   x       (x0, y0, psi, u, v_m, r, w_u, w_v, w_r, e_x, e_y): see above; e as a from-vector in earth axes [m/s]
///   inputs  what acts, in substeps of h_s
/// Returns (eta, nu) at its end. w acts as half a kick before and after each substep.
template <typename T>
Eigen::Matrix<T, kShipStates, 1> advance(const Model<T>& model, const Eigen::Matrix<T, kStates, 1>& x,
                                         const std::vector<StepInputs<double>>& inputs, double h_s) {
  ShipState<T> state{x.template segment<3>(0), x.template segment<3>(3)};
  const Vec3<T> kick = 0.5 * h_s * x.template segment<3>(kErrorStart);
  const Vec2<T> wind_error = x.template segment<2>(kWindStart);
  for (const StepInputs<double>& in : inputs) {
    state.nu += kick;
    state = integrate(model, state, with_error(in, wind_error), h_s);
    state.nu += kick;
  }
  Eigen::Matrix<T, kShipStates, 1> result;
  result << state.eta, state.nu;
  return result;
}

struct LinearStep {
  Vec6 offset;                                    ///< simulator's step from the path, less the path's next point
  Eigen::Matrix<double, kShipStates, kStates> A;  ///< by x(k)
  ByRow<kShipStates> G;                           ///< by theta
  ByRow<kShipStates> by_actuators;                ///< by the inputs' errors, in their sd; empty: they have none
  /// Covariance of the accelerations of an ensemble's members; of a ship: of those that derivatives miss, where its
  /// model switches.
  Mat3<double> spread = Mat3<double>::Zero();
  /// Where a course is kept (Stretch::helm): what the rudders' answer before the end makes of a change of the step, in
  /// A, G and offset already; and what they do beside their law.
  std::optional<Eigen::Matrix<double, kShipStates, kShipStates>> answer;
  Vec6 by_helm = Vec6::Zero();
  double beyond = 0.0;  ///< farthest that an input lies beyond the training data, see EnsembleSimulator::beyond()

  /// A change of where the step with the recorded inputs leads, as it is with the answer.
  Vec6 answered(const Vec6& change) const { return answer ? Vec6(*answer * change) : change; }
};

/// A stretch with the model linearized along a path.
struct LinearStretch {
  std::shared_ptr<const Stretch> data;  ///< owned with others, so that fits can be copied and outlive campaigns
  std::vector<StateVector> path;        ///< one per point
  std::vector<LinearStep> steps;        ///< one less
  /// Of what is measured about a point, a mean by a sensor with theta's faults, from the path's value there.
  std::vector<Vec6> mean_offset;
  std::vector<Vec3<double>> event_scale;             ///< factors on sigma_w at each point: above 1 in events; empty: 1
  Vec6 initial_sd = Vec6::Zero();                    ///< of the first point around the path: wide
  Vec3<double> untrained_sd = Vec3<double>::Zero();  ///< of the acceleration error where an ensemble was not trained
};

/// Levels of the noise.
struct Noise {
  Vec3<double> sigma_w;                               ///< of the acceleration error [m/s^2, m/s^2, rad/s^2]
  Vec3<double> least_sigma_w = Vec3<double>::Zero();  ///< below which it is not estimated
  double tau_s = 0.0;                                 ///< its correlation time
  double least_tau_s = 0.0, longest_tau_s = 1e9;      ///< between which it is estimated
  Vec6 measurement_sd;                                ///< of one point of the grid
  Vec6 least_measurement_sd = Vec6::Zero();           ///< below which it is not estimated
  double wind_share =
      kPolicy.filter
          .first_wind_share;  ///< sd of each component of the wind's error, by the mean wind speed of the stretch
  double wind_tau_s = 0.0;
  /// Of each step's own timing of the actuators, in tenths of the sampling time: where they moved between two samples
  /// is not known, and a straight line is wrong by up to a third of the time between.
  double timing_sd = kPolicy.filter.timing_sd;
  /// Whether positions and velocities are of one receiver, and share an error: a velocity [m/s] of each component.
  bool one_receiver = false;
  double receiver_sd = kPolicy.filter.first_receiver_sd_mps, receiver_tau_s = kPolicy.filter.first_receiver_tau_s;
  bool knows_events = true;  ///< whether LinearStretch::event_scale counts
  bool knows_spread = true;  ///< whether LinearStep::spread and beyond count
};

/// The measurements as a path to start from: holes are bridged linearly and what is not recorded is zero (the heading:
/// the integral of the yaw rate), without error states.
///   neighbors  to each side of a measurement of which the median is taken, so that single ones that are far off move
///              nothing; 0: each as it is
std::vector<StateVector> measured_path(const Stretch& stretch, std::size_t neighbors = 0);

/// Derivatives along a given path, by automatic differentiation: by the state exactly, by theta within about a
/// hundredth, and slopes of chords where the model switches; those of an ensemble by differences, with theta the timing
/// alone.
LinearStretch linearize(const EnsembleSimulator& simulator, std::shared_ptr<const Stretch> stretch,
                        std::vector<StateVector> path, const Eigen::VectorXd& theta);
LinearStretch linearize(const Ship& ship, std::shared_ptr<const Stretch> stretch, std::vector<StateVector> path,
                        const Eigen::VectorXd& theta);
/// The same along the path that the filter itself takes from the measurements up to each point (extended Kalman
/// filter). Columns must not know the measurements that they explain: along a smoothed path they would, and noise alone
/// would look like an effect. The first kPolicy.filter.first_points points, where the filter converges, stay as they
/// are.
///   before  the stretch about a path near by: its path and mean_offset are used
///   data    the stretch, with the inputs as they act
LinearStretch linearize_filtered(const EnsembleSimulator& simulator, const LinearStretch& before,
                                 std::shared_ptr<const Stretch> data, const Noise& noise,
                                 std::vector<Vec3<double>> event_scale, const Eigen::VectorXd& theta);
LinearStretch linearize_filtered(const Ship& ship, const LinearStretch& before, std::shared_ptr<const Stretch> data,
                                 const Noise& noise, std::vector<Vec3<double>> event_scale,
                                 const Eigen::VectorXd& theta);

/// What the measurements say about columns c_j, each an addition beta_j c_j(k) to the six ship states of every step:
/// innovations are white under the model, so that ln p(y | beta) = log_likelihood + b' beta - beta' F beta/2.
struct Evidence {
  double log_likelihood = 0.0;
  Eigen::VectorXd b;
  Eigen::MatrixXd F;
  std::size_t measurements = 0;

  explicit Evidence(Eigen::Index columns = 0)
      : b(Eigen::VectorXd::Zero(columns)), F(Eigen::MatrixXd::Zero(columns, columns)) {}
  Evidence& operator+=(const Evidence& other);
};

/// Calls what depends on how many states the filter has: those of the model alone, with the error of a receiver, or
/// with that and the errors of the inputs.
template <typename Call>
auto with_states(const LinearStretch& stretch, const Noise& noise, const Call& call) {
  if (!stretch.data->uncertain.empty()) return call.template operator()<kFilterStates>();
  if (noise.one_receiver) return call.template operator()<kReceiverStates>();
  return call.template operator()<kStates>();
}

/// The Kalman filter along a stretch, step by step; white innovations come out one by one.
class Filter {
 public:
  using Columns = ByRow<kFilterStates>;
  using Vector = Eigen::Matrix<double, kFilterStates, 1>;
  using Matrix = Eigen::Matrix<double, kFilterStates, kFilterStates>;

  Filter(const LinearStretch& stretch, const Noise& noise, Eigen::Index columns);

  /// Goes from point k to k+1; the caller then adds its columns to the top six rows of `columns`.
  void predict(std::size_t k) {
    with_states(stretch_, noise_, [&]<int states>() { predict<states>(k); });
  }
  /// Takes the measurements of point k one by one: innovation(taken, row), row = dz/dbeta
  /// with the sign that makes b = sum z row. Numbers of sensors' faults move what is measured, and no ship.
  template <typename Innovation>
  void update(std::size_t k, const Innovation& innovation) {
    // To a measurement, what its sensor adds is as if the ship were there.
    const FaultColumns& faults = stretch_.data->by_faults;
    const bool has_faults = columns.cols() > 0 && faults.count() > 0;
    if (has_faults) columns.block(0, faults.first, kShipStates, faults.count()) += faults.at[k];
    const int count = with_states(stretch_, noise_, [&]<int states>() { return take<states>(k); });
    if (has_faults) columns.block(0, faults.first, kShipStates, faults.count()) -= faults.at[k];
    for (int t = 0; t < count; ++t) innovation(taken_[t], rows_.row(t));
  }

  Vector mean;  ///< of dx and the receiver's error, given what was taken so far
  Matrix covariance;
  Columns columns;  ///< d mean/d beta
  Matrix transition(std::size_t k) const;
  /// Of the acceleration error at point k: sd, and the stationary covariance beside them from step k.
  Vec3<double> sigma_w(std::size_t k) const;
  Mat3<double> spread(std::size_t k) const;

  /// A measurement that update() took.
  struct Taken {
    int channel;
    double z, S, per_root;     ///< innovation with variance 1; its variance before, and one by the root of that
    Vector gain;               ///< of z
    Vec2<double> of_receiver;  ///< derivative of what is measured by the receiver's error
  };

 private:
  // All below is with as many states as there are errors (with_states()).
  template <int states>
  void predict(std::size_t k);
  template <int states>
  int take(std::size_t k);
  /// What measurements do to the columns: a few columns at a time, which stay in registers.
  template <int states, int width>
  void take_columns(int count, Eigen::Index first);
  template <int states, int width>
  void move_columns(const Eigen::Matrix<double, kShipStates, states>& A, Eigen::Index first);

  const LinearStretch& stretch_;
  const Noise& noise_;
  double wind_sd_;
  std::array<Taken, kShipStates> taken_;
  ByRow<kShipStates> rows_;
};

/// Evidence about the parameters theta (columns G), and about more columns: `more(k, out)` writes the additions of step
/// k into the 6 x count matrix `out`.
using MoreColumns = std::function<void(std::size_t k, Eigen::Ref<Eigen::MatrixXd> out)>;
/// Columns of sensors: `of(k, out)` writes what they add to the six measured values at point k, which moves no ship.
struct MeasuredColumns {
  Eigen::Index count = 0;
  MoreColumns of = nullptr;
};
Evidence evidence(const LinearStretch& stretch, const Noise& noise, Eigen::Index count = 0,
                  const MoreColumns& more = nullptr, const MeasuredColumns& measured = {});
/// The same without columns of sensors; what the way back of noise_slope() needs is kept in `passage`.
struct Passage;
Evidence evidence(const LinearStretch& stretch, const Noise& noise, Eigen::Index count, const MoreColumns& more,
                  Passage& passage);
/// The same by blocks of points; their sum is that of the stretch.
std::vector<Evidence> evidence_by_blocks(const LinearStretch& stretch, const Noise& noise, std::size_t block_points,
                                         Eigen::Index count = 0, const MoreColumns& more = nullptr,
                                         const MeasuredColumns& measured = {});

/// Smoothed states (path + dx) and their covariances, with theta moved by dtheta; innovations if asked for.
struct Smoothed {
  std::vector<StateVector> state;
  std::vector<StateMatrix> covariance;
  std::vector<Vec6> innovations;  ///< white, NaN where nothing was measured
};
Smoothed smooth(const LinearStretch& stretch, const Noise& noise, const Eigen::VectorXd& dtheta);

}  // namespace leeway::gap
