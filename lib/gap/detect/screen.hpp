#pragma once

#include <cstdint>
#include <optional>

#include "gap/fit/coefficient_scale.hpp"
#include "gap/fit/effect_columns.hpp"
#include "gap/fit/null_fit.hpp"

namespace leeway::gap {

/// Coordinates from which a fit with more effects may reach the best ones.
struct Start {
  Hypothesis hypothesis;
  Eigen::VectorXd theta;      ///< (coefficients, z, timing) after one linear step
  double log_evidence = 0.0;  ///< after the step, as expected
};

/// An effect, or one that is another in each recording, at coordinates to start from.
struct Candidate {
  std::vector<FreeEffect> effects;
  Eigen::VectorXd z;
};

/// Where an effect may start: at the neutral place, or at the median, below and above it and around the compass; with
/// priors of its own: at the median.
///   choices  one, or one for each recording in which the effect is another
/// Throws EffectNotApplicable if the ship lacks what the effect needs.
std::vector<Candidate> candidates_of(const std::string& effect, const Ship& ship,
                                     std::vector<FreeEffect::Choice> choices = {FreeEffect::Choice()});

/// How candidates are screened.
struct ScreenOptions {
  std::size_t jobs = 1;
  bool knows_events = true;  ///< false: what acts for a while is not taken for an event
  bool whole_steps = false;  ///< true: columns as exact as in fits; else by the acceleration in the middle of each step
};

/// The expected gain of candidates beside a fit, alone or together, from one linear step in closed form: all their
/// columns go through the filter once. A candidate has the columns of its coordinates, and one for what it does at its
/// start.
class EffectScreen {
 public:
  ///   so_far  the hypothesis of `from`
  ///   share   of the fit's coefficients, from which the step begins: 1, or 0 for the ship's own, which an effect that
  ///           is missing may have shifted
  ///   widths  of the fit's theta: one, or several over which is averaged
  EffectScreen(const Campaign& campaign, const FittedNull& from, const Hypothesis& so_far,
               std::vector<Candidate> candidates, double share, std::vector<PriorWidths> widths,
               const ScreenOptions& options);

  const std::vector<Candidate>& candidates() const { return candidates_; }
  /// ln of the evidence of a set of candidates (places in the list); minus infinity where the simulator runs away.
  double log_evidence(const std::vector<std::size_t>& set) const;
  /// How much evidence candidates gain, each alone, where nothing is missing: the largest gain of each of so many
  /// campaigns that are drawn from the linear model, in ascending order [nats]; none where no candidate can be
  /// screened.
  std::vector<double> gains_of_nothing(std::size_t draws, std::uint64_t seed) const;
  /// The step; its length is limited.
  Start start(const std::vector<std::size_t>& set) const;

 private:
  // A set of candidates at their starts.
  struct Judged {
    std::vector<Eigen::Index> columns;  // of its coordinates
    Eigen::VectorXd score;              // of all columns
    MoreCoordinates more;
    FileEvidence file;
  };
  Judged judge(const std::vector<std::size_t>& set) const;

  Hypothesis so_far_;
  std::vector<Candidate> candidates_;
  std::vector<Eigen::Index> first_;  // column of each candidate; the last of its columns is what it does at its start
  Eigen::VectorXd theta_;
  Eigen::Index effects_ = 0;  // known ones
  Evidence total_;
  std::optional<FileEvidenceBeside> file_;  // once there is a total
};

/// Whether the coefficients of a fit lie so far off that an effect may have shifted them.
bool is_shifted(const FittedNull& fit);

/// Starts of one effect, most likely first, from the fit's coefficients and, where these are shifted, from the ship's.
std::vector<Start> starts_of(const std::string& effect, const Campaign& campaign, const FittedNull& from,
                             std::size_t jobs, const Hypothesis& so_far = {},
                             std::vector<FreeEffect::Choice> choices = {FreeEffect::Choice()});

}  // namespace leeway::gap
