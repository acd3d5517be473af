#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/types.hpp"
#include "core/units.hpp"
#include "io/dataset_json.hpp"
#include "io/json.hpp"
#include "io/trajectory_csv.hpp"
#include "metrics/particle_moments.hpp"
#include "recording/trajectory.hpp"

namespace leeway {

struct ScoreOptions {
  Vec3<double> sigma{0.01, 0.01, 0.1 * kDegree};  ///< of L_fit: [m/s], [m/s], [rad/s]
  const io::ColumnsMap* columns = nullptr;        ///< of the truth files
  /// Standard deviation of the sensors' noise, where predictions are laid beside observations: (u, v_m [m/s], r
  /// [rad/s]). It is part of what is predicted then: the recording's values are one more draw of it.
  Vec3<double> noise = Vec3<double>::Zero();
  std::size_t jobs = 1;
};

/// The truth at one time; NaN where it is missing.
struct TruthPoint {
  Vec3<double> nu{kMissing, kMissing, kMissing};  ///< (u, v_m [m/s], r [rad/s])
  Vec2<double> position{kMissing, kMissing};      ///< (x0, y0) [m]
};

/// The sample within 1e-6 s of `t_s`, else linear between the two around it. Throws InputError outside the recording.
TruthPoint truth_at(const Trajectory& truth, double t_s);

/// Squared Mahalanobis distance of `error` under the covariance `Sigma`; nothing where Sigma has no full rank, that
/// is, where the smallest eigenvalue of its correlation matrix is at most 1e-10.
std::optional<double> squared_mahalanobis(const Vec3<double>& error, const Eigen::Matrix3d& Sigma);

/// One step of one sequence against the truth. Everything that compares is NaN where the truth is missing.
struct PointScore {
  std::size_t sequence = 0, step = 0;
  bool has_truth = false;
  double t_s = 0.0;
  Vec3<double> mean = Vec3<double>::Zero(), sd = mean, truth = mean;  ///< (u, v_m [m/s], r [rad/s])
  double squared_eucl = kMissing;                                     ///< |truth - mean|^2 [(m/s)^2 + (rad/s)^2]
  double squared_maha = kMissing;                                     ///< NaN where undefined
  double squared_position = kMissing;  ///< of the mean position [m^2]; NaN where one of the two has none
  double position_sd = 0.0;            ///< root mean squared distance of the particles from their mean position [m]
  double fit = kMissing;               ///< mean over particles of the sum of squared errors over sigma^2
  double honest_maha = kMissing;       ///< mean of squared_maha of an honest law; NaN where that is not finite
  std::array<bool, 3> covered{};       ///< whether squared_maha is within the honest radii of kCoverageLevels
  double energy = kMissing;            ///< energy score [sqrt((m/s)^2 + (rad/s)^2)]
  double log_score = kMissing;         ///< -ln of the Gaussian density with the particles' moments [SI]
  Vec3<double> crps{kMissing, kMissing, kMissing};  ///< [m/s, m/s, rad/s]
  Vec3<double> pit{kMissing, kMissing, kMissing};   ///< share of the predicted law below the truth
};

struct RecordingScores {
  std::string name, set, file;  ///< file: of the truth
  std::size_t sequences = 0;
  std::vector<std::size_t> steps_of_sequence, particles_of_sequence;
  std::set<std::size_t> members;
  bool member_changes = false;
  std::string sampling;                       ///< what the prediction says of itself; may be empty
  io::States against = io::States::unstated;  ///< what it was laid beside
  std::string initial_state;                  ///< words as Scores has them
  std::vector<std::string> ignored_columns;   ///< of the truth file
  std::vector<std::string> absent_columns;    ///< likewise
  std::vector<PointScore> points;             ///< by sequence and step
};

/// Compares a prediction with the truth of the same recording.
///   against  what the states of `truth` are; to observations the noise of the options belongs
///   honest   shared by all recordings
RecordingScores score(const PredictedRecording& prediction, const Trajectory& truth, const ScoreOptions& options,
                      HonestDistances& honest, io::States against = io::States::unstated);

inline constexpr std::size_t kPitBins = 10;

/// The figures of one data set, by the definitions of docs/eval-metrics.md. NaN is an undefined figure.
struct Scores {
  std::string name;
  std::size_t sequences = 0;
  std::size_t steps = 0;                 ///< points K of a sequence, of the longest where they differ
  std::optional<std::size_t> particles;  ///< nothing where sequences differ
  std::size_t points = 0;                ///< k >= 1, with a truth
  std::size_t missing_truth = 0;         ///< k >= 1, left out because a truth sample is missing
  double L_eucl = kMissing, L_maha = kMissing, maha_undefined_fraction = kMissing, correlation = kMissing;
  std::size_t members = 0;
  std::string sampling;  ///< as all recordings declare it, else from the members: "ts-inf", "ts1" or "single"
  /// What the prediction was laid beside: "truth", "observations", "unstated"; "mixed" where recordings differ.
  std::string against;
  /// What the states at step 0 are: the same words, or "estimate" of the initial-state network. What the prediction
  /// says of itself, else that of `against` where the particles start from the very numbers that they are laid beside.
  std::string initial_state;
  Vec3<double> rmse{kMissing, kMissing, kMissing};
  double rmse_position = kMissing;
  std::array<double, 3> coverage{kMissing, kMissing, kMissing};  ///< of the regions of kCoverageLevels
  double maha_honest = kMissing;  ///< what L_maha would be in the mean if the truth came from the predicted law
  double energy_score = kMissing, log_score = kMissing;  ///< means of the points'
  Vec3<double> crps{kMissing, kMissing, kMissing};
  /// Share of the points whose PIT falls in each tenth, by channel; NaN without points.
  std::array<std::array<double, kPitBins>, 3> pit{};
  double L_fit = kMissing;
};

/// Figures over the given recordings, added in their order.
Scores summarize(const std::string& name, std::span<const RecordingScores> recordings);

struct Evaluation {
  std::vector<RecordingScores> recordings;  ///< by set and name
  std::vector<Scores> of_recording;         ///< the figures of each of them, in this order
  std::vector<Scores> datasets;             ///< by name
  Scores overall;
  std::vector<std::string> empty_files;  ///< predictions without a row: of recordings shorter than a sequence
  /// Recordings that nothing predicts, of sets of which others are predicted; and how many such sets have.
  std::vector<std::string> not_predicted;
  std::size_t in_predicted_sets = 0;
};

/// A file that predictions are laid beside: RecordingFile::truth, whatever its states are.
struct Reference : io::RecordingFile {};

/// Finds what predictions are laid beside by the names of the recordings: the truths where a data set lists them, else
/// the files as they are given.
///   against  nothing, or what is asked for: of a data set its truths or its recordings, of other files what they are
/// Throws InputError for two of one name and where a data set has no truth that is asked for, UsageError where a file
/// is a truth that is said to be observations.
std::map<std::string, Reference> truths_by_name(const std::vector<std::string>& arguments,
                                                std::optional<io::States> against = std::nullopt);

/// Where predictions come from.
struct PredictionSource {
  struct File {
    std::string path;
    std::string sampling, initial_state;  ///< what prediction.json beside it says; empty where there is none
  };
  std::vector<File> files;
  std::vector<std::string> descriptions;  ///< the prediction.json files found
  io::Json provenance;                    ///< array of theirs
};

/// Finds the prediction CSV files that the arguments name: a folder stands for all its *.csv, sorted, and may hold a
/// prediction.json. Throws InputError for a folder without any.
PredictionSource find_predictions(const std::vector<std::string>& arguments);

/// Reads predictions and those truths that they need, a file per thread at a time, and scores them. Files without a row
/// are passed over. Throws InputError for a recording without truth, for one that two files predict, and where no file
/// has a row.
Evaluation evaluate(const PredictionSource& source, const std::map<std::string, Reference>& truths,
                    const ScoreOptions& options);

/// All files that an evaluation read: predictions, descriptions, truths.
std::vector<std::string> input_files(const PredictionSource& source, const Evaluation& evaluation);

/// What a user should know about the figures.
std::vector<std::string> notices(const Evaluation& evaluation);

/// metrics.json without provenance.
io::Json to_json(const Evaluation& evaluation);

/// One CSV row per recording, sequence and step.
std::string per_step_text(const Evaluation& evaluation);

/// A line per recording, then one per data set and one for all, for people.
std::string summary_text(const Evaluation& evaluation);

}  // namespace leeway
