#include "ensemble/prediction_run.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "core/parallel.hpp"

namespace leeway::ensemble {
namespace {

constexpr std::size_t kStatesTogether = 1'000'000;  // of all particles at all points, for each thread

void write_sequence(const SequenceTask& task, const SequencePrediction& prediction, io::PredictionWriter& writer) {
  io::PredictionRow row;
  row.recording = task.samples->recording;
  row.sequence = task.sequence;
  for (std::size_t k = 0; k < prediction.eta.size(); ++k) {
    row.step = k;
    row.t_s = task.samples->t_s(task.range.begin + static_cast<Eigen::Index>(k));
    for (std::size_t p = 0; p < prediction.state[k].size(); ++p) {
      row.particle = p;
      row.member = static_cast<std::size_t>(prediction.member[k][p]);
      row.eta = prediction.eta[k].col(prediction.state[k][p]);
      row.nu = prediction.nu[k].col(prediction.state[k][p]);
      writer.write(row);
    }
  }
}

}  // namespace

std::vector<SequenceTask> sequences_of(const std::vector<Samples>& stretches, Eigen::Index K, bool training) {
  std::vector<SequenceTask> tasks;
  for (const Samples& samples : stretches)
    for (const Range range : training ? training_windows(samples.size(), K) : test_sequences(samples.size(), K))
      tasks.push_back({&samples, range, tasks.size()});
  return tasks;
}

void write_predictions(const std::vector<SequenceTask>& tasks, std::size_t particles, std::size_t jobs,
                       const std::function<SequencePredictor()>& make_predictor, io::PredictionWriter& writer,
                       PredictionReport& report, const std::function<void(std::size_t)>& progress) {
  const std::size_t threads = std::max<std::size_t>(1, std::min(jobs, tasks.size()));
  std::size_t longest = 1;
  for (const SequenceTask& task : tasks) longest = std::max(longest, static_cast<std::size_t>(task.range.size));
  // Sequences that a thread predicts together: the more, the better the members' networks are used.
  const std::size_t together = std::clamp<std::size_t>(
      kStatesTogether / (particles * longest), 1, std::max<std::size_t>(1, (tasks.size() + threads - 1) / threads));
  std::vector<SequencePredictor> predictors;
  for (std::size_t i = 0; i < threads; ++i) predictors.push_back(make_predictor());
  for (std::size_t begin = 0; begin < tasks.size(); begin += threads * together) {
    const std::span<const SequenceTask> left = std::span(tasks).subspan(begin);
    const std::size_t n = std::min(threads, (left.size() + together - 1) / together);
    std::vector<std::vector<SequencePrediction>> block(n);
    const auto part = [&](std::size_t i) {
      return left.subspan(i * together, std::min(together, left.size() - i * together));
    };
    parallel_for(n, n, [&](std::size_t i) { block[i] = predictors[i](part(i)); });
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < block[i].size(); ++j) {
        const SequenceTask& task = part(i)[j];
        const SequencePrediction& prediction = block[i][j];
        write_sequence(task, prediction, writer);
        if (prediction.out_of_bounds == 0) continue;
        report.out_of_bounds += prediction.out_of_bounds;
        report.notices.push_back(fmt::format(
            "{}: sequence {}: {} particles left ten times the range of the training data, the first at t = {} s; they "
            "stay in the prediction",
            task.samples->recording, task.sequence, prediction.out_of_bounds, prediction.first_out_of_bounds_s));
      }
    if (progress) progress(std::min(threads * together, left.size()));
  }
  report.sequences += tasks.size();
}

}  // namespace leeway::ensemble
