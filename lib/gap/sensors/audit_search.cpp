#include "gap/sensors/audit_search.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/distributions.hpp"
#include "core/linear_algebra.hpp"
#include "core/parallel.hpp"
#include "core/units.hpp"
#include "gap/decide/sensors.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using enum FaultParameter;

// p-value of chi-squared with one or two degrees of freedom, as its logarithm.
double log_chi2_p(double value, Index freedom) {
  if (freedom == 2) return -0.5 * value;
  const double root = std::sqrt(0.5 * value);
  // Far out erfc underflows: its asymptote.
  return root < kPolicy.sensors.erfc_until ? std::log(std::erfc(root)) : -root * root - std::log(root * std::sqrt(kPi));
}

// What the units say of one candidate: the slopes of their log-likelihoods at the base, by its own numbers.
struct CandidateScore {
  MatrixXd of_unit;  // one column per unit
  MatrixXd inverse;  // of the information
  Index freedom;
  // With the sign of each unit's score as given.
  double log_p(const VectorXd& signs) const {
    const VectorXd sum = of_unit * signs;
    return log_chi2_p(sum.dot(inverse * sum), freedom);
  }
};

CandidateScore score_of(const FaultFitter& fitter, const FaultFit& base, const FaultFit& fit) {
  const Index old = base.numbers.size();
  // A long latency is judged by all that it does, not by its beginning.
  FaultFit at = fit;
  at.residuals = base.residuals;
  const Index count = fit.numbers.size() - old;
  at.sensitivities.rightCols(count) = fitter.actions_of_last(fit);
  // A constant fault looks like slow noise where it is not corrected: noise is that beside the candidate.
  const WhitenedRows of_base = fitter.whitened(base, fit.noise), rows = fitter.whitened(at, fit.noise);
  const VectorXd &z = of_base.z, &weights = of_base.weights;
  MatrixXd own = rows.J.rightCols(count);
  if (old > 0) {
    const MatrixXd known = rows.J.leftCols(old);
    const MatrixXd weighted = weights.asDiagonal() * known;
    MatrixXd A = known.transpose() * weighted;
    A.diagonal() += fitter.prior_precision(base.members);
    own -= known * A.ldlt().solve(weighted.transpose() * own);
  }
  CandidateScore score{MatrixXd::Zero(own.cols(), static_cast<Index>(fitter.windows().unit_count())), {}, own.cols()};
  MatrixXd information = own.transpose() * weights.asDiagonal() * own;
  information.diagonal() += fitter.prior_precision({fit.members.back()});
  score.inverse = information.inverse();
  for (Index k = 0; k < z.size(); ++k)
    score.of_unit.col(static_cast<Index>(fitter.unit(k))) += weights(k) * z(k) * own.row(k).transpose();
  return score;
}

// Under the base the scores of the units have signs that are as good as tossed; their flips, the same for all
// candidates, give the distribution of the smallest p-value of the whole library, however the residuals are correlated
// within a unit and distributed.
std::vector<double> family_wise(const std::vector<CandidateScore>& scores, Index units, RandomStream stream) {
  const VectorXd as_is = VectorXd::Ones(units);
  std::vector<double> observed;
  observed.reserve(scores.size());
  for (const CandidateScore& score : scores) observed.push_back(score.log_p(as_is));
  std::vector<std::size_t> as_small(scores.size(), 0);
  for (std::size_t draw = 0; draw < kPolicy.sensors.sign_flips; ++draw) {
    VectorXd signs(units);
    for (Index g = 0; g < signs.size(); ++g) signs(g) = stream.uniform() < 0.5 ? -1.0 : 1.0;
    double least = 0.0;
    for (const CandidateScore& score : scores) least = std::min(least, score.log_p(signs));
    for (std::size_t c = 0; c < scores.size(); ++c)
      if (least <= observed[c]) ++as_small[c];
  }
  std::vector<double> result;
  result.reserve(as_small.size());
  for (const std::size_t count : as_small)
    result.push_back(static_cast<double>(1 + count) / static_cast<double>(1 + kPolicy.sensors.sign_flips));
  return result;
}

// Where the same parameter would stand twice, or what two members do is the same.
bool exclude_each_other(std::size_t a, std::size_t b) {
  if (fault_library()[a].name == fault_library()[b].name) return true;
  // To first order a lag of first order is a latency. One of all channels but the positions is another matter: some of
  // them may come late on top of it.
  const auto effect = [](FaultParameter parameter) {
    return parameter == velocity_filter ? velocity_latency : parameter == rate_filter ? rate_latency : parameter;
  };
  for (const std::size_t member : {a, b})
    for (const FaultParameter parameter : fault_library()[member].numbers[0])
      if (parameter == heading_filter) return false;
  for (const std::vector<FaultParameter>& of_a : fault_library()[a].numbers)
    for (const std::vector<FaultParameter>& of_b : fault_library()[b].numbers)
      for (const FaultParameter in_a : of_a)
        for (const FaultParameter in_b : of_b)
          if (effect(in_a) == effect(in_b)) return true;
  return false;
}

// The tried in the order of preference.
class Ranking {
 public:
  Ranking(const std::vector<FaultFit>& tried, const std::vector<double>& p, double false_alarm)
      : tried_(tried), p_(p), false_alarm_(false_alarm) {}

  std::size_t first() const {
    std::size_t best = 0;
    for (std::size_t c = 1; c < tried_.size(); ++c)
      if (worth(c) > worth(best)) best = c;
    return best;
  }

  // Clocks are relative, so that one late channel can be read as the others being early: sensors are late. Early
  // positions stand for all others being late.
  std::size_t late_rather_than_early(std::size_t best) const {
    if (!(latency(best) < 0.0)) return best;
    std::optional<std::size_t> late;
    for (std::size_t c = 0; c < tried_.size(); ++c)
      if (latency(c) > 0.0 && is_as_good(c, best) && (!late || tried_[c].heldout.sum() > tried_[*late].heldout.sum()))
        late = c;
    return late.value_or(best);
  }

  // A factor of the log, one number, stands before offsets, two, unless they are clearly better.
  std::size_t simpler_fault(std::size_t best) const {
    const std::string_view name = last_of(tried_[best]).traits.simpler;
    std::optional<std::size_t> simpler;
    for (std::size_t c = 0; c < tried_.size() && !name.empty(); ++c)
      if (last_of(tried_[c]).name == name && is_as_good(c, best) && (!simpler || worth(c) > worth(*simpler)))
        simpler = c;
    return simpler.value_or(best);
  }

  std::size_t simplest_of_its_name(std::size_t best) const {
    for (std::size_t c = 0; c < best; ++c)
      if (last_of(tried_[c]).name == last_of(tried_[best]).name && is_as_good(c, best)) return c;
    return best;
  }

 private:
  std::pair<bool, double> worth(std::size_t c) const { return {p_[c] < false_alarm_, tried_[c].heldout.sum()}; }
  // Whether the best is not clearly better than another that is significant where it is.
  bool is_as_good(std::size_t other, std::size_t best) const {
    if (worth(other).first != worth(best).first) return false;
    const HeldoutGain gain = heldout_gain(tried_[best], tried_[other]);
    return !(gain.is_certain() && gain.sum > kPolicy.sensors.better_nats);
  }
  double latency(std::size_t c) const {
    const FaultParameter first = last_of(tried_[c]).numbers[0][0];
    const bool is_latency = first == velocity_latency || first == heading_latency || first == rate_latency;
    return is_latency ? tried_[c].numbers(tried_[c].numbers.size() - 1) : 0.0;
  }

  const std::vector<FaultFit>& tried_;
  const std::vector<double>& p_;
  double false_alarm_;
};

}  // namespace

HeldoutGain heldout_gain(const FaultFit& better, const FaultFit& worse) {
  const VectorXd difference = better.heldout - worse.heldout;
  const double n = static_cast<double>(difference.size());
  HeldoutGain gain;
  gain.sum = difference.sum();
  gain.sd = std::sqrt((difference.array() - gain.sum / n).square().sum() * n / (n - 1.0));
  return gain;
}

double chance_of(const HeldoutGain& gain, std::size_t units) {
  if (!(gain.sum > 0.0) || !(gain.sd > 0.0)) return 1.0;
  return f_survival(std::pow(gain.sum / gain.sd, 2), 1.0, static_cast<double>(units) - 1.0);
}

bool has_enough(const KinematicWindows& windows, Kinematics kind) {
  return windows.windows(kind) >= kPolicy.sensors.fewest_windows;
}

const FaultCandidate& last_of(const FaultFit& fit) { return fault_library()[fit.members.back()]; }

FaultSearch::FaultSearch(const FaultFitter& fitter, const AuditOptions& options) : fitter_(fitter), options_(options) {}

std::vector<FaultFit> FaultSearch::tried(const FaultFit& base) const {
  std::vector<std::size_t> candidates;
  for (std::size_t c = 0; c < fault_library().size(); ++c) {
    bool is_open = is_testable(c);
    for (const std::size_t member : base.members) is_open = is_open && !exclude_each_other(c, member);
    if (is_open) candidates.push_back(c);
  }
  std::vector<FaultFit> result(candidates.size());
  parallel_for(candidates.size(), options_.jobs, [&](std::size_t i) { result[i] = fitter_.with(base, candidates[i]); });
  return result;
}

bool FaultSearch::is_testable(std::size_t candidate) const {
  // A factor on an r that is mostly noise shrinks the noise: its estimate is off by noise^2/signal^2.
  const KinematicWindows& windows = fitter_.windows();
  if (fault_library()[candidate].numbers[0][0] == rate_scale &&
      windows.rate_noise() > kPolicy.sensors.rate_noise * windows.rms_turned())
    return false;
  bool in_track = false, in_heading = false;
  for (const std::vector<FaultParameter>& number : fault_library()[candidate].numbers)
    for (const FaultParameter parameter : number) {
      in_track = in_track || info(parameter).in_track;
      in_heading = in_heading || info(parameter).in_heading;
    }
  const bool has_track = has_enough(windows, Kinematics::track);
  const bool has_heading = has_enough(windows, Kinematics::heading);
  // A candidate that shows in both is distinguished from its rivals only where both are there.
  if (in_track && in_heading && fault_library()[candidate].numbers[0].size() > 1) return has_track && has_heading;
  return (in_track && has_track) || (in_heading && has_heading);
}

std::vector<double> FaultSearch::p_values(const FaultFit& base, const std::vector<FaultFit>& tried,
                                          std::size_t stream) const {
  std::vector<CandidateScore> scores;
  scores.reserve(tried.size());
  for (const FaultFit& fit : tried) scores.push_back(score_of(fitter_, base, fit));
  return family_wise(scores, static_cast<Index>(fitter_.windows().unit_count()),
                     RandomStream(options_.seed, "audit sign flips", stream));
}

std::size_t FaultSearch::best(const std::vector<FaultFit>& tried, const std::vector<double>& p) const {
  const Ranking ranking(tried, p, options_.false_alarm);
  std::size_t best = ranking.first();
  best = ranking.late_rather_than_early(best);
  best = ranking.simpler_fault(best);
  return ranking.simplest_of_its_name(best);
}

bool FaultSearch::predicts_better(const FaultFit& with, const FaultFit& base, double p) const {
  const HeldoutGain gain = heldout_gain(with, base);
  return gap::predicts_better({p, gain.sum, gain.sd}, options_.false_alarm);
}

bool FaultSearch::is_found(const FaultFit& with, const FaultFit& base, double p) const {
  const HeldoutGain gain = heldout_gain(with, base);
  return gap::is_found({p, gain.sum, gain.sd}, options_.false_alarm);
}

std::optional<FaultFit> FaultSearch::pair_with(const FaultFit& first, std::size_t stage) const {
  const std::vector<FaultFit> pairs = tried(first);
  if (pairs.empty()) return std::nullopt;
  const std::vector<double> p = p_values(first, pairs, 100 + stage);
  const std::size_t second = best(pairs, p);
  const FaultFit& pair = pairs[second];
  if (!is_found(pair, first, p[second])) return std::nullopt;
  const FaultFit other = fitter_.without(pair, first.members.size() - 1);
  const std::vector<FaultFit> back = tried(other);
  const std::vector<double> p_back = p_values(other, back, 200 + stage);
  for (std::size_t c = 0; c < back.size(); ++c)
    if (back[c].members.back() == first.members.back() && is_found(back[c], other, p_back[c])) return pair;
  return std::nullopt;
}

}  // namespace leeway::gap
