#include "metrics/scores.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "core/errors.hpp"
#include "core/linear_algebra.hpp"
#include "core/parallel.hpp"
#include "core/units.hpp"
#include "io/csv.hpp"
#include "io/files.hpp"
#include "io/result_folder.hpp"
#include "metrics/proper_scores.hpp"

namespace leeway {
namespace fs = std::filesystem;
namespace {

constexpr double kFullRank = 1e-10;   // smallest eigenvalue of the correlation matrix
constexpr double kSameState = 1e-12;  // squared: velocities that were read from one file differ by rounding alone

// Mean of numbers that come one by one; NaN while there is none.
struct Mean {
  std::size_t count = 0;
  double sum = 0.0;
  void add(double x) {
    ++count;
    sum += x;
  }
  double value() const { return count > 0 ? sum / static_cast<double>(count) : kMissing; }
};

// Pearson's correlation in two passes; NaN for fewer than two points or a constant.
double correlation(const std::vector<double>& x, const std::vector<double>& y) {
  Mean mean_x, mean_y;
  for (std::size_t i = 0; i < x.size(); ++i) {
    mean_x.add(x[i]);
    mean_y.add(y[i]);
  }
  double xx = 0.0, yy = 0.0, xy = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double dx = x[i] - mean_x.value(), dy = y[i] - mean_y.value();
    xx += dx * dx;
    yy += dy * dy;
    xy += dx * dy;
  }
  return xx > 0.0 && yy > 0.0 ? std::clamp(xy / std::sqrt(xx * yy), -1.0, 1.0) : kMissing;
}

std::string inferred_sampling(bool member_changes, std::size_t members, std::size_t most_particles) {
  if (member_changes) return "ts1";
  return members <= 1 || most_particles <= 1 ? "single" : "ts-inf";
}

// Whether all particles start from the very states that they are laid beside.
bool starts_where_laid(const std::vector<PointScore>& points) {
  return std::ranges::all_of(points, [](const PointScore& p) {
    return p.step > 0 || (p.squared_eucl <= kSameState && p.sd.squaredNorm() <= kSameState);
  });
}

// The word that all have, or "mixed".
std::string common(const std::set<std::string>& words) {
  return words.size() == 1 ? *words.begin() : words.empty() ? std::string(io::word(io::States::unstated)) : "mixed";
}

}  // namespace

TruthPoint truth_at(const Trajectory& truth, double t_s) {
  const std::vector<double>& t = truth[Channel::t];
  const auto outside = [&] {
    return InputError(truth.file, fmt::format("the prediction has a point at {} s, but the truth lasts from {} to {} s",
                                              t_s, t.front(), t.back()));
  };
  const auto after = static_cast<std::size_t>(std::lower_bound(t.begin(), t.end(), t_s - kSameTime_s) - t.begin());
  if (after == t.size()) throw outside();
  // Neighbors a and b with weight w on b; an exact hit needs no neighbor, which may be missing.
  std::size_t a = after, b = after;
  double w = 0.0;
  if (t[after] - t_s > kSameTime_s) {
    if (after == 0) throw outside();
    a = after - 1;
    w = (t_s - t[a]) / (t[b] - t[a]);
  }
  const auto at = [&](Channel channel) {
    if (!truth.has(channel)) return kMissing;
    const std::vector<double>& values = truth[channel];
    return a == b ? values[a] : values[a] + w * (values[b] - values[a]);
  };
  return {{at(Channel::u), at(Channel::vm), at(Channel::r)}, {at(Channel::x0), at(Channel::y0)}};
}

std::optional<double> squared_mahalanobis(const Vec3<double>& error, const Eigen::Matrix3d& Sigma) {
  const Vec3<double> sd = Sigma.diagonal().cwiseSqrt();
  if (!(sd.minCoeff() > 0.0)) return std::nullopt;
  const Eigen::Matrix3d correlation = sd.cwiseInverse().asDiagonal() * Sigma * sd.cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(correlation);
  if (!(eigen.eigenvalues()(0) > kFullRank)) return std::nullopt;
  const Vec3<double> along = eigen.eigenvectors().transpose() * error.cwiseQuotient(sd);
  return along.cwiseAbs2().cwiseQuotient(eigen.eigenvalues()).sum();
}

RecordingScores score(const PredictedRecording& prediction, const Trajectory& truth, const ScoreOptions& options,
                      HonestDistances& honest, io::States against) {
  const Vec3<double> noise = against == io::States::observations ? options.noise : Vec3<double>::Zero();
  RecordingScores result;
  result.name = prediction.name;
  result.file = truth.file;
  result.sequences = prediction.sequences.size();
  result.members = prediction.members;
  result.sampling = prediction.sampling;
  result.ignored_columns = truth.ignored_columns;
  result.absent_columns = truth.absent_columns;
  result.against = against;
  for (const auto& [number, sequence] : prediction.sequences) {
    result.steps_of_sequence.push_back(sequence.steps.size());
    result.particles_of_sequence.push_back(sequence.steps.front().moments.count());
    result.member_changes = result.member_changes || sequence.member_changes;
    for (std::size_t k = 0; k < sequence.steps.size(); ++k) {
      const PredictedSequence::Step& step = sequence.steps[k];
      const Eigen::Matrix3d Sigma = step.moments.covariance();
      const TruthPoint there = truth_at(truth, step.t_s);
      PointScore point;
      point.sequence = number;
      point.step = k;
      point.t_s = step.t_s;
      point.mean = step.moments.mean();
      point.sd = Sigma.diagonal().cwiseSqrt();
      point.position_sd = std::sqrt(step.moments.position_variance());
      point.truth = there.nu;
      const Vec3<double> error = there.nu - point.mean;
      point.has_truth = !there.nu.hasNaN();
      if (point.has_truth) {
        point.squared_eucl = error.squaredNorm();
        const Eigen::Matrix3d with_noise = Sigma + Eigen::Matrix3d(noise.cwiseAbs2().asDiagonal());
        if (const auto maha = squared_mahalanobis(error, with_noise)) {
          point.squared_maha = *maha;
          point.log_score = gaussian_log_score(*maha, with_noise);
        }
        if (k > 0) add_proper_scores(step.particles, noise, {prediction.name, number, k}, honest, point);
        point.squared_position = (there.position - step.moments.mean_position()).squaredNorm();
        // Mean over particles of (truth - particle)^2 = error of the mean squared + variance.
        point.fit = (error.cwiseAbs2() + Sigma.diagonal()).cwiseQuotient(options.sigma.cwiseAbs2()).sum();
      }
      result.points.push_back(point);
    }
  }
  result.initial_state = !prediction.initial_state.empty()  ? prediction.initial_state
                         : starts_where_laid(result.points) ? io::word(against)
                                                            : io::word(io::States::unstated);
  return result;
}

Scores summarize(const std::string& name, std::span<const RecordingScores> recordings) {
  Scores s;
  s.name = name;
  Mean eucl, maha, position, fit, honest, energy, log_score;
  std::array<Mean, 3> squared, crps;
  std::array<std::array<std::size_t, kPitBins>, 3> in_bin{};
  bool honest_is_finite = true;
  std::array<std::size_t, 3> covered{};
  std::vector<double> eucl_distances, maha_distances;
  std::set<std::size_t> members;
  std::set<std::size_t> particles;
  std::set<std::string> declared, against, initial_states;
  bool member_changes = false;
  for (const RecordingScores& recording : recordings) {
    s.sequences += recording.sequences;
    for (const std::size_t steps : recording.steps_of_sequence) s.steps = std::max(s.steps, steps);
    particles.insert(recording.particles_of_sequence.begin(), recording.particles_of_sequence.end());
    members.insert(recording.members.begin(), recording.members.end());
    member_changes = member_changes || recording.member_changes;
    declared.insert(recording.sampling);
    against.emplace(io::word(recording.against));
    initial_states.insert(recording.initial_state);
    for (const PointScore& point : recording.points) {
      if (point.has_truth) fit.add(point.fit);
      if (point.step == 0) continue;
      if (!point.has_truth) {
        ++s.missing_truth;
        continue;
      }
      eucl.add(point.squared_eucl);
      for (int i = 0; i < 3; ++i) squared[i].add((point.truth(i) - point.mean(i)) * (point.truth(i) - point.mean(i)));
      if (!std::isnan(point.squared_position)) position.add(point.squared_position);
      energy.add(point.energy);
      for (std::size_t i = 0; i < 3; ++i) {
        crps[i].add(point.crps(i));
        ++in_bin[i][std::min(kPitBins - 1, static_cast<std::size_t>(point.pit(i) * kPitBins))];
      }
      if (std::isnan(point.squared_maha)) continue;
      maha.add(point.squared_maha);
      eucl_distances.push_back(std::sqrt(point.squared_eucl));
      maha_distances.push_back(std::sqrt(point.squared_maha));
      log_score.add(point.log_score);
      honest.add(point.honest_maha);
      honest_is_finite = honest_is_finite && !std::isnan(point.honest_maha);
      for (std::size_t i = 0; i < covered.size(); ++i) covered[i] += point.covered[i] ? 1 : 0;
    }
  }
  s.points = eucl.count;
  s.L_eucl = eucl.value();
  s.L_maha = maha.value();
  if (eucl.count > 0)
    s.maha_undefined_fraction = static_cast<double>(eucl.count - maha.count) / static_cast<double>(eucl.count);
  s.correlation = correlation(eucl_distances, maha_distances);
  s.members = members.size();
  if (particles.size() == 1) s.particles = *particles.begin();
  s.sampling = declared.size() == 1 && !declared.contains("")
                   ? *declared.begin()
                   : inferred_sampling(member_changes, members.size(), particles.empty() ? 0 : *particles.rbegin());
  s.against = common(against);
  s.initial_state = common(initial_states);
  for (int i = 0; i < 3; ++i) s.rmse(i) = std::sqrt(squared[i].value());
  s.rmse_position = std::sqrt(position.value());
  if (maha.count > 0)
    for (std::size_t i = 0; i < covered.size(); ++i)
      s.coverage[i] = static_cast<double>(covered[i]) / static_cast<double>(maha.count);
  s.L_fit = fit.value();
  s.maha_honest = honest_is_finite ? honest.value() : kMissing;
  s.energy_score = energy.value();
  s.log_score = log_score.value();
  for (std::size_t i = 0; i < 3; ++i) {
    s.crps(i) = crps[i].value();
    for (std::size_t bin = 0; bin < kPitBins; ++bin)
      s.pit[i][bin] = eucl.count > 0 ? static_cast<double>(in_bin[i][bin]) / static_cast<double>(eucl.count) : kMissing;
  }
  return s;
}

std::map<std::string, Reference> truths_by_name(const std::vector<std::string>& arguments,
                                                std::optional<io::States> against) {
  std::map<std::string, Reference> result;
  for (const io::RecordingFile& recording : io::expand_recordings(arguments)) {
    Reference reference{recording};
    const bool of_dataset = !recording.dataset.empty(), has_truth = !recording.truth.empty();
    if (of_dataset && !has_truth && against == io::States::truth)
      throw InputError(recording.dataset, fmt::format("lists no truth of {}", recording.path));
    if (!of_dataset && recording.states == io::States::truth && against == io::States::observations)
      throw UsageError(fmt::format("{} lies in a folder of truths; observations were asked for", recording.path));
    if (has_truth && against != io::States::observations) {
      reference.states = io::States::truth;
    } else {
      reference.truth = recording.path;
      if (!of_dataset && against) reference.states = *against;
    }
    const auto [other, is_new] = result.emplace(io::stem(recording.path), reference);
    if (!is_new)
      throw InputError(reference.truth,
                       fmt::format("is the truth of recording '{}', and so is {}; recordings are distinguished by "
                                   "their name",
                                   other->first, other->second.truth));
  }
  return result;
}

PredictionSource find_predictions(const std::vector<std::string>& arguments) {
  PredictionSource source;
  source.provenance = io::Json::array();
  for (const std::string& argument : arguments) {
    std::error_code error;
    if (argument == "-" || !fs::is_directory(argument, error)) {
      source.files.push_back({argument, "", ""});
      continue;
    }
    std::vector<std::string> files;
    for (const auto& entry : fs::directory_iterator(argument, error))
      if (entry.path().extension() == ".csv") files.push_back(entry.path().string());
    if (error) throw IoError(argument, fmt::format("cannot be read: {}", error.message()));
    if (files.empty()) throw InputError(argument, "no CSV file in this folder; expected a prediction");
    std::sort(files.begin(), files.end());
    std::string sampling, initial_state;
    std::map<std::string, std::string> parts;
    const std::string description = (fs::path(argument) / "prediction.json").string();
    io::require_finished(description);
    if (fs::exists(description, error)) {
      const io::Json json = io::read_json(description);
      const io::JsonObject prediction(json, description);
      sampling = prediction.text_or("sampling", "");
      initial_state = prediction.text_or("initial_state", "");
      if (prediction.has("provenance")) source.provenance.push_back(prediction.value("provenance"));
      parts = io::parts_of(prediction);
      for (const char* known : {"members", "particles", "steps", "time_step_s", "disturbance", "initial_error", "radii",
                                "particles_out_of_bounds", "generation"})
        prediction.has(known);
      prediction.check_all_known();
      source.descriptions.push_back(description);
    }
    for (const std::string& file : files) {
      const auto part = parts.find(fs::path(file).filename().string());
      if (part != parts.end()) io::require_unchanged(file, part->second, description);
      if (part == parts.end() && !parts.empty())
        throw InputError(
            file,
            fmt::format("is not of the run that {} tells of; name the files one by one, or move it away", description));
      source.files.push_back({file, sampling, initial_state});
    }
  }
  return source;
}

Evaluation evaluate(const PredictionSource& source, const std::map<std::string, Reference>& truths,
                    const ScoreOptions& options) {
  std::set<std::string> known;
  for (const auto& [name, truth] : truths) known.insert(name);
  std::vector<std::vector<PredictedRecording>> of_file(source.files.size());
  parallel_for(of_file.size(), options.jobs, [&](std::size_t i) {
    of_file[i] = read_prediction(source.files[i].path, known, source.files.size() > 1);
    for (PredictedRecording& recording : of_file[i]) {
      recording.sampling = source.files[i].sampling;
      recording.initial_state = source.files[i].initial_state;
    }
  });

  Evaluation evaluation;
  for (std::size_t i = 0; i < of_file.size(); ++i)
    if (of_file[i].empty()) evaluation.empty_files.push_back(source.files[i].path);
  if (evaluation.empty_files.size() == of_file.size())
    throw InputError(evaluation.empty_files.front(),
                     fmt::format("no data row below the header, and so in all {} files of predictions: no recording "
                                 "holds a sequence",
                                 of_file.size()));

  // By set, then by name: the order of all sums, whatever the order of the arguments.
  std::map<std::pair<std::string, std::string>, const PredictedRecording*> sorted;
  for (const auto& recordings : of_file)
    for (const PredictedRecording& recording : recordings) {
      const auto [other, is_new] = sorted.emplace(std::pair(truths.at(recording.name).set, recording.name), &recording);
      if (!is_new)
        throw InputError(recording.file,
                         fmt::format("predicts recording '{}', and so does {}", recording.name, other->second->file));
    }
  std::vector<const PredictedRecording*> predictions;
  predictions.reserve(sorted.size());
  for (const auto& [key, recording] : sorted) predictions.push_back(recording);

  HonestDistances honest;
  evaluation.recordings.resize(predictions.size());
  parallel_for(predictions.size(), options.jobs, [&](std::size_t i) {
    const Reference& truth = truths.at(predictions[i]->name);
    evaluation.recordings[i] =
        score(*predictions[i], io::read_trajectory(truth.truth, options.columns), options, honest, truth.states);
    evaluation.recordings[i].set = truth.set;
  });

  const std::span<const RecordingScores> all(evaluation.recordings);
  std::set<std::string> predicted, sets;
  for (std::size_t i = 0; i < all.size(); ++i) {
    predicted.insert(all[i].name);
    sets.insert(all[i].set);
    evaluation.of_recording.push_back(summarize(all[i].name, all.subspan(i, 1)));
  }
  for (const auto& [name, truth] : truths) {
    if (!sets.contains(truth.set)) continue;
    ++evaluation.in_predicted_sets;
    if (!predicted.contains(name)) evaluation.not_predicted.push_back(name);
  }
  for (std::size_t begin = 0; begin < all.size();) {
    std::size_t end = begin;
    while (end < all.size() && all[end].set == all[begin].set) ++end;
    evaluation.datasets.push_back(summarize(all[begin].set, all.subspan(begin, end - begin)));
    begin = end;
  }
  evaluation.overall = summarize("overall", all);
  return evaluation;
}

std::vector<std::string> input_files(const PredictionSource& source, const Evaluation& evaluation) {
  std::vector<std::string> files;
  for (const PredictionSource::File& file : source.files) files.push_back(file.path);
  files.insert(files.end(), source.descriptions.begin(), source.descriptions.end());
  for (const RecordingScores& recording : evaluation.recordings) files.push_back(recording.file);
  return files;
}

}  // namespace leeway
