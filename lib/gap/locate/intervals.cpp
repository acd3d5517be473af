#include "gap/locate/intervals.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/distributions.hpp"
#include "core/linear_algebra.hpp"
#include "core/parallel.hpp"
#include "core/random.hpp"
#include "gap/filter/reference_units.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {
namespace {

struct BlockRun {
  std::size_t begin, end;  // blocks, of one stretch
  int axis;
};

// All runs of blocks with the variance of their summed score, but those that the parameters may make almost whole.
struct BlockRuns {
  std::vector<BlockRun> runs;
  std::vector<double> variance;
};

BlockRuns all_runs(const BlockEvidence& evidence) {
  BlockRuns result;
  const std::size_t n = evidence.blocks.size();
  const auto longest = static_cast<std::size_t>(std::max(1.0, kPolicy.locate.longest_share * static_cast<double>(n)));
  for (int axis = 0; axis < 3; ++axis)
    for (std::size_t i = 0; i < n; ++i) {
      double variance = 0.0, given = 0.0;
      for (std::size_t j = i; j < n && j - i < longest && evidence.blocks[j].stretch == evidence.blocks[i].stretch;
           ++j) {
        const Eigen::Index c = evidence.column(j, axis);
        for (std::size_t q = i; q < j; ++q) {
          variance += 2.0 * evidence.F(c, evidence.column(q, axis));
          given += 2.0 * evidence.F_given(c, evidence.column(q, axis));
        }
        variance += evidence.F(c, c);
        given += evidence.F_given(c, c);
        if (variance < std::max(kPolicy.locate.least_variance, kPolicy.locate.least_unexplained * given)) continue;
        result.runs.push_back({i, j + 1, axis});
        result.variance.push_back(variance);
      }
    }
  return result;
}

// The largest s^2/variance over the runs, and which one.
std::pair<double, std::size_t> largest(const BlockEvidence& evidence, const BlockRuns& runs, const Eigen::VectorXd& b) {
  std::array<std::vector<double>, 3> sums;
  for (int axis = 0; axis < 3; ++axis) {
    sums[static_cast<std::size_t>(axis)].push_back(0.0);
    for (std::size_t i = 0; i < evidence.blocks.size(); ++i)
      sums[static_cast<std::size_t>(axis)].push_back(sums[static_cast<std::size_t>(axis)].back() +
                                                     b[evidence.column(i, axis)]);
  }
  double best = 0.0;
  std::size_t which = 0;
  for (std::size_t r = 0; r < runs.runs.size(); ++r) {
    const BlockRun& run = runs.runs[r];
    const std::vector<double>& sum = sums[static_cast<std::size_t>(run.axis)];
    const double s = sum[run.end] - sum[run.begin], statistic = s * s / runs.variance[r];
    if (statistic > best) best = statistic, which = r;
  }
  return {best, which};
}

// The largest statistic where there is nothing.
class NullStatistics {
 public:
  NullStatistics(const BlockEvidence& evidence, const BlockRuns& runs, const LocateOptions& options)
      : drawn_(kPolicy.locate.scan_draws) {
    Eigen::MatrixXd F = evidence.F;
    F.diagonal().array() += kPolicy.locate.ridge * F.diagonal().maxCoeff();
    const Eigen::MatrixXd root = F.llt().matrixL();
    parallel_for(kPolicy.locate.scan_draws, options.jobs, [&](std::size_t d) {
      RandomStream random(options.seed, "gap-scan", d);
      Eigen::VectorXd standard(evidence.b.size());
      for (double& x : standard) x = random.normal();
      const Eigen::VectorXd draw = root.triangularView<Eigen::Lower>() * standard;
      drawn_[d] = largest(evidence, runs, draw).first;
    });
    std::sort(drawn_.begin(), drawn_.end());
  }

  // Beyond what the draws resolve, in proportion to the tail of one run.
  double p_value(double statistic) const {
    constexpr double share =
        static_cast<double>(kPolicy.locate.tail_draws) / static_cast<double>(kPolicy.locate.scan_draws);
    const double level = drawn_[kPolicy.locate.scan_draws - kPolicy.locate.tail_draws];
    if (statistic < level) {
      const auto above = drawn_.end() - std::lower_bound(drawn_.begin(), drawn_.end(), statistic);
      return static_cast<double>(above + 1) / static_cast<double>(kPolicy.locate.scan_draws + 1);
    }
    return share * chi_squared_survival(statistic, 1.0) / chi_squared_survival(level, 1.0);
  }

 private:
  std::vector<double> drawn_;  // in ascending order
};

// Whether the ensemble knows what it does at the points [begin, end) of a stretch, and why not.
Training training_of(const EnsembleSimulator& ensemble, const LinearStretch& stretch, std::size_t begin,
                     std::size_t end, int axis, double mismatch) {
  Training training;
  const std::vector<ensemble::InputRange>& domain = ensemble.ensemble().header().inputs.domain;
  std::vector<double> outside(domain.size(), 0.0);
  end = std::min(end, stretch.steps.size());
  const auto n = static_cast<double>(std::max<std::size_t>(1, end - std::min(begin, end)));
  double variance = 0.0;
  for (std::size_t k = begin; k < end; ++k) {
    const StateVector& x = stretch.path[k];
    const std::vector<double> beyond = ensemble.beyond(x[2], x.segment<3>(3), stretch.data->inputs[k].front().start);
    for (std::size_t i = 0; i < beyond.size(); ++i) outside[i] += beyond[i] > 0.0 ? 1.0 / n : 0.0;
    training.outside_share += stretch.steps[k].beyond > 0.0 ? 1.0 / n : 0.0;
    variance += stretch.steps[k].spread(axis, axis) / n;
  }
  for (std::size_t i = 0; i < outside.size(); ++i)
    if (outside[i] > 0.0) training.outside.push_back({domain[i].name, outside[i]});
  std::sort(training.outside.begin(), training.outside.end(),
            [](const OutsideInput& a, const OutsideInput& b) { return a.share > b.share; });
  training.spread = std::sqrt(variance);
  training.mismatch_by_spread = training.spread > 0.0 ? std::abs(mismatch) / training.spread : kMissing;
  // Whether the truth may be one member more, by Student's t.
  const auto members = static_cast<double>(ensemble.ensemble().members());
  training.is_untrained = training.outside_share > kPolicy.locate.mostly_outside;
  if (training.spread > 0.0) {
    const double square = training.mismatch_by_spread * training.mismatch_by_spread * members / (members + 1.0);
    training.is_untrained =
        training.is_untrained || f_survival(square, 1.0, members - 1.0) > kPolicy.locate.one_member_more;
  }
  return training;
}

// Accelerations on all axes over a run, in units of the axes.
struct RunAccelerations {
  Vec3<double> size;
  Mat3<double> covariance;
};

// Estimates them, and subtracts what they explain from the evidence.
RunAccelerations subtract(const BlockRun& run, BlockEvidence& evidence) {
  Eigen::MatrixXd indicator = Eigen::MatrixXd::Zero(evidence.b.size(), 3);
  for (std::size_t i = run.begin; i < run.end; ++i)
    for (int axis = 0; axis < 3; ++axis) indicator(evidence.column(i, axis), axis) = 1.0;
  const Eigen::MatrixXd FI = evidence.F_given * indicator;
  Mat3<double> information = indicator.transpose() * FI;
  information.diagonal().array() += kPolicy.locate.ridge * information.trace();
  const Vec3<double> size = information.ldlt().solve(indicator.transpose() * evidence.b);
  const Mat3<double> inverse = information.inverse();
  const Mat3<double> of_parameters = indicator.transpose() * (FI - evidence.F * indicator);
  evidence.b -= FI * size;
  return {size, inverse + inverse * of_parameters * inverse};
}

Interval interval_of(const Campaign& campaign, const FittedNull& fit, const BlockEvidence& evidence,
                     const BlockRun& run, const RunAccelerations& accelerations) {
  const Vec3<double> unit = reference_acceleration(campaign.ship);
  const Block &first = evidence.blocks[run.begin], &last = evidence.blocks[run.end - 1];
  const Stretch& stretch = campaign.stretches[first.stretch];
  Interval interval;
  interval.file = campaign.recordings[stretch.recording].file;
  interval.recording = campaign.recordings[stretch.recording].name;
  interval.t_start_s = stretch.t_s[first.begin];
  interval.t_end_s = stretch.t_s[last.end - 1];
  interval.axis = run.axis;
  interval.acceleration = accelerations.size.cwiseProduct(unit);
  interval.covariance = unit.asDiagonal() * accelerations.covariance * unit.asDiagonal();
  if (campaign.ensemble)
    interval.training = training_of(*campaign.ensemble, fit.stretches[first.stretch], first.begin, last.end, run.axis,
                                    interval.acceleration[run.axis]);
  interval.is_small =
      std::abs(interval.acceleration[run.axis]) < kPolicy.locate.small_share * fit.report.typical[run.axis];
  return interval;
}

}  // namespace

FoundIntervals intervals_of(const Campaign& campaign, const FittedNull& fit, BlockEvidence evidence,
                            const LocateOptions& options) {
  FoundIntervals result;
  const BlockRuns runs = all_runs(evidence);
  if (runs.runs.empty()) return result;
  const NullStatistics nulls(evidence, runs, options);
  bool is_decided = false;  // strongest_p_value
  for (std::size_t found = 0, untrained = 0;
       found < kPolicy.locate.most_intervals && untrained < kPolicy.locate.most_untrained;) {
    const auto [statistic, which] = largest(evidence, runs, evidence.b);
    const double p = nulls.p_value(statistic);
    if (p > options.false_alarm) {
      if (!is_decided) result.strongest_p_value = p;
      break;
    }
    const BlockRun& run = runs.runs[which];
    Interval interval = interval_of(campaign, fit, evidence, run, subtract(run, evidence));
    interval.p_value = p;
    const bool is_untrained = interval.is_untrained();
    if (!is_untrained && !interval.is_small && !is_decided) result.strongest_p_value = p, is_decided = true;
    ++(is_untrained ? untrained : found);
    result.intervals.push_back(std::move(interval));
  }
  return result;
}

std::optional<Interval> likeliest_interval(const Campaign& campaign, const FittedNull& fit, std::size_t jobs) {
  BlockEvidence evidence = block_evidence(campaign, fit, {}, jobs);
  const std::size_t n = evidence.blocks.size();
  const auto columns_of = [&](std::size_t block) {
    return Eigen::Vector3<Eigen::Index>(evidence.column(block, 0), evidence.column(block, 1),
                                        evidence.column(block, 2));
  };
  std::optional<BlockRun> likeliest;
  double most = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    Vec3<double> b = Vec3<double>::Zero();
    Mat3<double> precision = Mat3<double>::Identity();
    for (std::size_t j = i; j < n && evidence.blocks[j].stretch == evidence.blocks[i].stretch; ++j) {
      b += evidence.b(columns_of(j));
      precision += evidence.F(columns_of(j), columns_of(j));
      for (std::size_t q = i; q < j; ++q) {
        const Mat3<double> cross = evidence.F(columns_of(j), columns_of(q));
        precision += cross + cross.transpose();
      }
      const Eigen::LLT<Mat3<double>> factor(precision);
      const double gain = 0.5 * b.dot(factor.solve(b)) - factor.matrixLLT().diagonal().array().log().sum();
      if (likeliest && gain <= most) continue;
      most = gain;
      int axis = 0;
      (b.array().square() / precision.diagonal().array()).maxCoeff(&axis);
      likeliest = BlockRun{i, j + 1, axis};
    }
  }
  if (!likeliest) return std::nullopt;
  return interval_of(campaign, fit, evidence, *likeliest, subtract(*likeliest, evidence));
}

Strongest strongest_interval(const Campaign& campaign, const FittedNull& fit, const LocateOptions& options) {
  FoundIntervals found = intervals_of(campaign, fit, block_evidence(campaign, fit, {}, options.jobs), options);
  Strongest result;
  result.p_value = found.strongest_p_value;
  for (Interval& interval : found.intervals)
    if (!result.interval && !interval.is_small && !interval.is_untrained()) result.interval = std::move(interval);
  return result;
}

}  // namespace leeway::gap
