#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/random.hpp"
#include "ensemble/disturbance.hpp"
#include "ensemble/evaluator.hpp"

namespace leeway::ensemble {

enum class Sampling {
  ts_infinity,  ///< a particle keeps its member
  ts1           ///< each particle draws a member at every step; at each, the members share them evenly
};

struct PredictionOptions {
  int particles = 100;
  Sampling sampling = Sampling::ts_infinity;
  Integrator integrator = Integrator::rk4;
  std::uint64_t seed = 1;
  /// Each particle has a path of the disturbance of its own, and starts from a velocity of its own: the recorded one
  /// and a normal error with these standard deviations (u, v_m [m/s], r [rad/s]).
  Disturbance disturbance = {};
  Vec3<double> initial_sd = Vec3<double>::Zero();
  /// Each particle draws where its inputs are between two samples (Samples::actuators_open): a share of their changes
  /// from -0.5 to 0.5 for each input, the same all the way.
  bool draws_inputs = false;

  bool particles_differ() const { return !disturbance.is_zero() || !initial_sd.isZero(0.0) || draws_inputs; }
};

/// All particles of a sequence: at step k, particle p has the state `state[k][p]` (a column of eta[k], nu[k]) and was
/// moved there by member[k][p] (at k = 0: the member that moves it first). Particles of equal history share a column.
struct SequencePrediction {
  std::vector<Eigen::Matrix3Xd> eta, nu;
  std::vector<std::vector<int>> state, member;
  /// Particles whose speed or rate of turn left ten times the range of the training data, and when first.
  int out_of_bounds = 0;
  double first_out_of_bounds_s = 0.0;
};

/// A sequence of a recording that is to be predicted.
struct SequenceTask {
  const Samples* samples;
  Range range;
  std::size_t sequence;  ///< number within the recording
};

/// A member for each particle: every member gets as many as any other, or one more, in an order that is drawn. Drawn
/// with replacement, 100 particles of 24 members would vary as those of 20.
std::vector<int> shared_out(std::size_t particles, std::size_t members, RandomStream& random);

/// Propagates particles through sequences from their recorded states at the first points. A member is evaluated for all
/// sequences together: TS-infinity by member through time, TS1 by member at each step. The result for a sequence does
/// not depend on the others; its random numbers depend on the seed, the recording's name and the sequence number alone.
/// Throws NumericalError if a state is no finite number.
///   tasks  with the same time step
std::vector<SequencePrediction> predict_sequences(EnsembleEvaluator& evaluator, const Ensemble& ensemble,
                                                  std::span<const SequenceTask> tasks,
                                                  const PredictionOptions& options);

/// The same for one sequence.
SequencePrediction predict_sequence(EnsembleEvaluator& evaluator, const Ensemble& ensemble, const Samples& samples,
                                    Range range, std::size_t sequence, const PredictionOptions& options);

/// The fitted rollout of a training window: every member from its own estimate of the initial state, by Euler as in
/// training; particle m is member m.
SequencePrediction fitted_rollout(EnsembleEvaluator& evaluator, const Ensemble& ensemble, const Samples& samples,
                                  Range range);

/// The baseline that holds the initial velocity: one particle, member 0.
SequencePrediction hold_velocity(const Samples& samples, Range range);

}  // namespace leeway::ensemble
