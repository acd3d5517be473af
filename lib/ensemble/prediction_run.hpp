#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "ensemble/prediction.hpp"
#include "io/prediction_csv.hpp"

namespace leeway::ensemble {

/// The K-point test sequences of a recording's stretches, numbered through; or its training windows.
std::vector<SequenceTask> sequences_of(const std::vector<Samples>& stretches, Eigen::Index K, bool training_windows);

/// What the user should know about a prediction.
struct PredictionReport {
  std::size_t sequences = 0;
  long out_of_bounds = 0;  ///< particles that left ten times the range of the training data
  std::vector<std::string> notices;
};

/// Predicts sequences together, for a thread of its own.
using SequencePredictor = std::function<std::vector<SequencePrediction>(std::span<const SequenceTask>)>;

/// Predicts all tasks on `jobs` threads and writes the rows in order; memory holds a few sequences at a time, for each
/// thread a million states of particles or one sequence.
///   particles       of a sequence
///   make_predictor  called once for each thread
///   progress        told how many sequences more are done
void write_predictions(const std::vector<SequenceTask>& tasks, std::size_t particles, std::size_t jobs,
                       const std::function<SequencePredictor()>& make_predictor, io::PredictionWriter& writer,
                       PredictionReport& report, const std::function<void(std::size_t)>& progress = nullptr);

}  // namespace leeway::ensemble
