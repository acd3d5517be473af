#include "gap/locate.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <fmt/format.h>

#include "core/distributions.hpp"
#include "core/parallel.hpp"
#include "core/random.hpp"
#include "core/units.hpp"
#include "gap/detect.hpp"

namespace leeway::gap {
namespace {

constexpr std::size_t kMostBlocks = 250;
constexpr std::size_t kScanDraws = 2000;
constexpr std::size_t kMostIntervals = 8, kMostUntrained = 16;
constexpr double kMostlyOutside = 0.5;     // share of an interval's points beyond the training data
constexpr double kOneMemberMore = 1e-3;    // probability of a member that differs as much
constexpr double kLongestShare = 0.6;      // of all blocks: longer is no interval
constexpr double kLeastUnexplained = 0.1;  // of the variance of a run, when the parameters have taken what they can
constexpr double kSmall = 0.2;             // of the typical acceleration: see Interval::is_small
constexpr double kReference_mps2 = 5e-4;   // accelerations are counted in this, yaw at 0.25 L_pp from midship
constexpr int kActiveBlocks = 4;           // an acceleration is forgotten by then

double gyration(const Ship& ship) { return 0.25 * ship.particulars.L_pp; }

// Unit of the columns of each axis (m/s^2, m/s^2, rad/s^2).
Vec3<double> unit_acceleration(const Ship& ship) {
  return {kReference_mps2, kReference_mps2, kReference_mps2 / gyration(ship)};
}

Mat3<double> inertia_matrix(const Ship& ship) {
  const Inertia<double> i(ship.inertia, ship.particulars);
  const double S = i.x_G * i.m;
  Mat3<double> M;
  M << i.m + i.m_x, 0, 0, 0, i.m + i.m_y, S, 0, S, i.I_z + i.x_G * S;
  return M;
}

// ---- blocks of accelerations and of module gains -------------------------------------------------------------------

struct Block {
  std::size_t stretch, begin, end;  // points
};

struct Module {
  std::string name;
  Model<double> scaled;  // with a gain of 1 + kGainStep
};
constexpr double kGainStep = 0.1;

std::vector<Module> modules_of(const Campaign& campaign, const FittedNull& fit) {
  if (campaign.ensemble) return {};
  const Ship& ship = campaign.ship;
  Model<double> null(ship);
  apply_uncertainty(null, fit.theta);
  const double k = 1.0 + kGainStep;
  std::vector<Module> modules;
  const auto add = [&](const char* name, const auto& change) {
    modules.push_back({name, null});
    change(modules.back().scaled.modules);
  };
  add("hull", [&](auto& m) { std::visit([&](auto& h) { h.scale(k); }, m.hull); });
  add("propeller", [&](auto& m) { std::visit([&](auto& p) { p.scale_thrust(k); }, m.propeller); });
  add("rudder", [&](auto& m) { std::visit([&](auto& r) { r.scale_normal_force(k, k); }, m.rudder); });
  if (!ship.thrusters.empty())
    add("thruster", [&](auto& m) {
      for (auto& thruster : m.thrusters)
        std::visit([&](auto& t) { t.c.K_T_positive *= k, t.c.K_T_negative *= k; }, thruster);
    });
  if (ship.wind && campaign.has_wind)
    add("wind", [&](auto& m) { std::visit([&](auto& w) { w.scale(k, k, k); }, *m.wind); });
  return modules;
}

// Scores of all blocks: column = block * kinds + kind; kinds are the three axes and the modules.
struct BlockEvidence {
  std::vector<Block> blocks;
  int kinds = 0;
  Eigen::VectorXd b;
  Eigen::MatrixXd F;        ///< of b, when the parameters have taken what they can
  Eigen::MatrixXd F_given;  ///< about accelerations and gains, at the fitted parameters
  Eigen::Index column(std::size_t block, int kind) const { return static_cast<Eigen::Index>(block) * kinds + kind; }
};

// By the everyday model error, so that events stand out, and what an ensemble was not trained for.
BlockEvidence block_evidence(const Campaign& campaign, const FittedNull& fit, const std::vector<Module>& modules,
                             std::size_t jobs) {
  Noise noise = fit.noise;
  noise.knows_events = false;
  noise.knows_spread = !campaign.ensemble;
  BlockEvidence result;
  result.kinds = 3 + static_cast<int>(modules.size());
  const auto least = static_cast<std::size_t>(std::ceil(10.0 * campaign.time_scale() / campaign.step_s));
  const std::size_t size = std::max({std::size_t{5}, least, campaign.points() / kMostBlocks + 1});
  std::vector<std::size_t> first_block;
  for (std::size_t s = 0; s < fit.stretches.size(); ++s) {
    const std::size_t n = fit.stretches[s].path.size(), count = std::max<std::size_t>(1, n / size);
    first_block.push_back(result.blocks.size());
    for (std::size_t i = 0; i < count; ++i) result.blocks.push_back({s, i * n / count, (i + 1) * n / count});
  }
  const Eigen::Index p = fit.theta.size(), all = static_cast<Eigen::Index>(result.blocks.size()) * result.kinds;
  const Vec3<double> unit = unit_acceleration(campaign.ship);

  std::optional<Model<double>> null;
  if (!modules.empty()) apply_uncertainty(null.emplace(campaign.ship), fit.theta);
  struct Part {
    Eigen::VectorXd b;
    Eigen::MatrixXd F, cross;  // among blocks; with theta
    Evidence of_theta;
  };
  std::vector<Part> parts(fit.stretches.size());
  const int kinds = result.kinds, active = kActiveBlocks * kinds;
  parallel_for(parts.size(), jobs, [&](std::size_t s) {
    const LinearStretch& stretch = fit.stretches[s];
    const std::size_t blocks =
        (s + 1 < first_block.size() ? first_block[s + 1] : result.blocks.size()) - first_block[s];
    const auto columns = static_cast<Eigen::Index>(blocks) * kinds;
    Part& part = parts[s];
    part.b = Eigen::VectorXd::Zero(columns);
    part.F = Eigen::MatrixXd::Zero(columns, columns);
    part.cross = Eigen::MatrixXd::Zero(p, columns);
    part.of_theta = evidence(stretch, noise);
    Filter filter(stretch, noise, p + active);
    std::size_t block = 0;
    for (std::size_t k = 0; k < stretch.path.size(); ++k) {
      if (k > 0) {
        filter.predict(k - 1);
        filter.columns.topLeftCorner(kShipStates, p) += stretch.steps[k - 1].G;
        const Block* now = &result.blocks[first_block[s] + block];
        if (k - 1 >= now->end) {
          ++now, ++block;
          filter.columns.middleCols(p + static_cast<Eigen::Index>(block % kActiveBlocks) * kinds, kinds).setZero();
        }
        const Eigen::Index slot = p + static_cast<Eigen::Index>(block % kActiveBlocks) * kinds;
        for (int axis = 0; axis < 3; ++axis)
          filter.columns.col(slot + axis).head<kShipStates>() +=
              stretch.steps[k - 1].A.col(kErrorStart + axis) * unit[axis];
        const std::vector<StepInputs<double>>& inputs = stretch.data->inputs[k - 1];
        const double h = stretch.data->dt_s(k - 1) / static_cast<double>(inputs.size());
        const Vec6 without = null ? advance<double>(*null, stretch.path[k - 1], inputs, h) : Vec6::Zero();
        for (std::size_t m = 0; m < modules.size(); ++m)
          filter.columns.col(slot + 3 + static_cast<Eigen::Index>(m)).head<kShipStates>() +=
              (advance<double>(modules[m].scaled, stretch.path[k - 1], inputs, h) - without) / kGainStep;
      }
      filter.update(k, [&](int, double z, const auto& row, double) {
        const std::size_t oldest = block + 1 >= kActiveBlocks ? block + 1 - kActiveBlocks : 0;
        for (std::size_t i = oldest; i <= block; ++i) {
          const auto row_i = row.segment(p + static_cast<Eigen::Index>(i % kActiveBlocks) * kinds, kinds);
          const Eigen::Index at = static_cast<Eigen::Index>(i) * kinds;
          part.b.segment(at, kinds) += z * row_i.transpose();
          part.cross.middleCols(at, kinds).noalias() += row.head(p).transpose() * row_i;
          for (std::size_t j = oldest; j <= i; ++j)
            part.F.block(at, static_cast<Eigen::Index>(j) * kinds, kinds, kinds).noalias() +=
                row_i.transpose() * row.segment(p + static_cast<Eigen::Index>(j % kActiveBlocks) * kinds, kinds);
        }
      });
    }
  });

  // The parameters take what they can.
  const Eigen::VectorXd precision = fit.prior_sd.array().square().inverse();
  Evidence total(p);
  for (const Part& part : parts) total += part.of_theta;
  Eigen::MatrixXd M = total.F;
  M.diagonal() += precision;
  const Eigen::LLT<Eigen::MatrixXd> factor(M);
  Eigen::MatrixXd cross(p, all);
  result.b.resize(all);
  result.F = Eigen::MatrixXd::Zero(all, all);
  for (std::size_t s = 0; s < parts.size(); ++s) {
    const Eigen::Index at = static_cast<Eigen::Index>(first_block[s]) * kinds, n = parts[s].b.size();
    result.b.segment(at, n) = parts[s].b;
    result.F.block(at, at, n, n) = parts[s].F.selfadjointView<Eigen::Lower>();
    cross.middleCols(at, n) = parts[s].cross;
  }
  const Eigen::MatrixXd of_theta = factor.solve(cross);
  // Their pull is that of the fit, which events do not take part in: else they would bend the parameters and show all
  // over.
  result.b -= of_theta.transpose() * (fit.total.b - precision.cwiseProduct(fit.theta));
  result.F_given = result.F;
  result.F -= cross.transpose() * of_theta;
  return result;
}

// ---- intervals -----------------------------------------------------------------------------------------------------

struct Run {
  std::size_t begin, end;  // blocks, of one stretch
  int axis;
};

// All runs of blocks with the variance of their summed score, but those that the parameters may make almost whole.
struct Runs {
  std::vector<Run> runs;
  std::vector<double> variance;
};

Runs all_runs(const BlockEvidence& evidence) {
  Runs result;
  const std::size_t n = evidence.blocks.size();
  const auto longest = static_cast<std::size_t>(std::max(1.0, kLongestShare * static_cast<double>(n)));
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
        if (variance < std::max(1e-6, kLeastUnexplained * given)) continue;
        result.runs.push_back({i, j + 1, axis});
        result.variance.push_back(variance);
      }
    }
  return result;
}

// The largest s^2/variance over the runs, and which one.
std::pair<double, std::size_t> largest(const BlockEvidence& evidence, const Runs& runs, const Eigen::VectorXd& b) {
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
    const Run& run = runs.runs[r];
    const std::vector<double>& sum = sums[static_cast<std::size_t>(run.axis)];
    const double s = sum[run.end] - sum[run.begin], statistic = s * s / runs.variance[r];
    if (statistic > best) best = statistic, which = r;
  }
  return {best, which};
}

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
  training.is_untrained = training.outside_share > kMostlyOutside;
  if (training.spread > 0.0) {
    const double square = training.mismatch_by_spread * training.mismatch_by_spread * members / (members + 1.0);
    training.is_untrained = training.is_untrained || f_survival(square, 1.0, members - 1.0) > kOneMemberMore;
  }
  return training;
}

//   strongest_p  of the intervals that are neither small nor called untrained
std::vector<Interval> scan(const Campaign& campaign, const FittedNull& fit, BlockEvidence evidence,
                           const LocateOptions& options, double& strongest_p) {
  std::vector<Interval> intervals;
  const Runs runs = all_runs(evidence);
  strongest_p = 1.0;
  if (runs.runs.empty()) return intervals;

  // The largest statistic where there is nothing.
  Eigen::MatrixXd F = evidence.F;
  F.diagonal().array() += 1e-9 * F.diagonal().maxCoeff();
  const Eigen::MatrixXd root = F.llt().matrixL();
  std::vector<double> nulls(kScanDraws);
  parallel_for(kScanDraws, options.jobs, [&](std::size_t d) {
    RandomStream random(options.seed, "gap-scan", d);
    Eigen::VectorXd standard(evidence.b.size());
    for (double& x : standard) x = random.normal();
    const Eigen::VectorXd draw = root.triangularView<Eigen::Lower>() * standard;
    nulls[d] = largest(evidence, runs, draw).first;
  });
  std::sort(nulls.begin(), nulls.end());
  // Beyond what the draws resolve, in proportion to the tail of one run.
  const double level = nulls[kScanDraws - kScanDraws / 20], share = 0.05;
  const auto p_value = [&](double statistic) {
    if (statistic < level) {
      const auto above = nulls.end() - std::lower_bound(nulls.begin(), nulls.end(), statistic);
      return static_cast<double>(above + 1) / static_cast<double>(kScanDraws + 1);
    }
    return share * chi_squared_survival(statistic, 1.0) / chi_squared_survival(level, 1.0);
  };

  const Vec3<double> unit = unit_acceleration(campaign.ship);
  bool is_told = false;  // strongest_p
  for (std::size_t found = 0, untrained = 0; found < kMostIntervals && untrained < kMostUntrained;) {
    const auto [statistic, which] = largest(evidence, runs, evidence.b);
    const double p = p_value(statistic);
    if (p > options.false_alarm) {
      if (!is_told) strongest_p = p;
      break;
    }
    const Run& run = runs.runs[which];
    // Its accelerations on all axes, which are then taken out.
    Eigen::MatrixXd indicator = Eigen::MatrixXd::Zero(evidence.b.size(), 3);
    for (std::size_t i = run.begin; i < run.end; ++i)
      for (int axis = 0; axis < 3; ++axis) indicator(evidence.column(i, axis), axis) = 1.0;
    const Eigen::MatrixXd FI = evidence.F_given * indicator;
    Mat3<double> information = indicator.transpose() * FI;
    information.diagonal().array() += 1e-9 * information.trace();
    const Vec3<double> size = information.ldlt().solve(indicator.transpose() * evidence.b);
    const Mat3<double> inverse = information.inverse();
    const Mat3<double> of_parameters = indicator.transpose() * (FI - evidence.F * indicator);
    evidence.b -= FI * size;

    const Stretch& stretch = campaign.stretches[evidence.blocks[run.begin].stretch];
    Interval interval;
    interval.file = campaign.recordings[stretch.recording].file;
    interval.recording = campaign.recordings[stretch.recording].name;
    interval.t_start_s = stretch.t_s[evidence.blocks[run.begin].begin];
    interval.t_end_s = stretch.t_s[evidence.blocks[run.end - 1].end - 1];
    interval.axis = run.axis;
    interval.p_value = p;
    interval.searched = runs.runs.size() / 3;  // of one axis
    interval.acceleration = size.cwiseProduct(unit);
    interval.covariance = unit.asDiagonal() * (inverse + inverse * of_parameters * inverse) * unit.asDiagonal();
    if (campaign.ensemble)
      interval.training = training_of(*campaign.ensemble, fit.stretches[evidence.blocks[run.begin].stretch],
                                      evidence.blocks[run.begin].begin, evidence.blocks[run.end - 1].end, run.axis,
                                      interval.acceleration[run.axis]);
    const bool is_untrained = interval.is_untrained();
    interval.is_small = std::abs(interval.acceleration[run.axis]) < kSmall * fit.report.typical[run.axis];
    if (!is_untrained && !interval.is_small && !is_told) strongest_p = p, is_told = true;
    ++(is_untrained ? untrained : found);
    intervals.push_back(interval);
  }
  return intervals;
}

// ---- line of action ------------------------------------------------------------------------------------------------

// N against Y of the smoothed residual; the error from leaving out groups of blocks that are long enough to differ.
std::optional<Estimate> line_of_action(const Campaign& campaign, const FittedNull& fit,
                                       const std::vector<Block>& blocks,
                                       const std::vector<Eigen::Matrix3Xd>& residual) {
  const Mat3<double> M = inertia_matrix(campaign.ship);
  const Vec3<double> unit = unit_acceleration(campaign.ship);
  const auto group_points = static_cast<std::size_t>(4.0 * fit.noise.tau_s / campaign.step_s) + 1;
  std::vector<Vec2<double>> sums;  // (N Y, Y Y)
  std::size_t points = group_points;
  for (const Block& block : blocks) {
    if (points >= group_points) {
      sums.push_back(Vec2<double>::Zero());
      points = 0;
    }
    points += block.end - block.begin;
    const Eigen::Matrix3Xd& w = residual[block.stretch];
    for (auto k = static_cast<Eigen::Index>(block.begin); k < std::min<Eigen::Index>(block.end, w.cols()); ++k) {
      const Vec3<double> force = M * w.col(k).cwiseProduct(unit);
      sums.back() += Vec2<double>(force(2) * force(1), force(1) * force(1));
    }
  }
  const Vec2<double> total = std::accumulate(sums.begin(), sums.end(), Vec2<double>(0.0, 0.0));
  const double L = campaign.ship.particulars.L_pp, x_F = total(0) / total(1);
  double variance = 0.0;
  const auto n = static_cast<double>(sums.size());
  for (const Vec2<double>& sum : sums) {
    const double without = (total(0) - sum(0)) / (total(1) - sum(1));
    variance += (without - x_F) * (without - x_F) * (n - 1.0) / n;
  }
  if (sums.size() < 3 || !std::isfinite(x_F) || !std::isfinite(variance)) return std::nullopt;
  return Estimate{"x_F_over_L", x_F / L, std::sqrt(variance) / L};
}

// The same from the forces in located intervals, which are estimated without shrinking them.
std::optional<Estimate> line_of_action(const Campaign& campaign, const std::vector<Interval>& intervals) {
  const Mat3<double> M = inertia_matrix(campaign.ship);
  double NY = 0.0, YY = 0.0, variance = 0.0;
  for (const Interval& interval : intervals) {
    const Vec3<double> F = M * interval.acceleration;
    NY += F(2) * F(1);
    YY += F(1) * F(1);
  }
  const double x_F = NY / YY;
  for (const Interval& interval : intervals) {
    const Vec3<double> F = M * interval.acceleration;
    const Mat3<double> P = M * interval.covariance * M.transpose();
    variance += F(1) * F(1) * (P(2, 2) + x_F * x_F * P(1, 1) - 2.0 * x_F * P(1, 2)) / (YY * YY);
  }
  const double L = campaign.ship.particulars.L_pp;
  // A side force that is hardly there has no line.
  if (!std::isfinite(x_F) || !(std::sqrt(variance) < 0.2 * L)) return std::nullopt;
  return Estimate{"x_F_over_L", x_F / L, std::sqrt(variance) / L};
}

// ---- module gains --------------------------------------------------------------------------------------------------

std::vector<WalkingGain> walking_gains(const Campaign& campaign, const FittedNull& fit, const BlockEvidence& evidence,
                                       const std::vector<Module>& modules, std::size_t jobs) {
  const std::size_t n = evidence.blocks.size();
  std::vector<WalkingGain> result;
  if (modules.empty()) return result;
  Model<double> null(campaign.ship);
  apply_uncertainty(null, fit.theta);
  for (std::size_t m = 0; m < modules.size(); ++m) {
    Eigen::VectorXd b(n);
    Eigen::MatrixXd F(n, n), walk(n, n);
    for (std::size_t i = 0; i < n; ++i) {
      b[static_cast<Eigen::Index>(i)] = evidence.b[evidence.column(i, 3 + static_cast<int>(m))];
      for (std::size_t j = 0; j < n; ++j) {
        F(i, j) = evidence.F(evidence.column(i, 3 + static_cast<int>(m)), evidence.column(j, 3 + static_cast<int>(m)));
        // Each stretch walks for itself, from an offset of its own.
        const Block &x = evidence.blocks[i], &y = evidence.blocks[j];
        std::size_t first = i;
        while (first > 0 && evidence.blocks[first - 1].stretch == x.stretch) --first;
        walk(i, j) = x.stretch == y.stretch ? 1.0 + static_cast<double>(std::min(i, j) - first) : 0.0;
      }
    }
    if (F.trace() < 1.0) continue;  // a module at rest
    WalkingGain best{modules[m].name, 0.0, 0.0, 1.0};
    Eigen::VectorXd gain = Eigen::VectorXd::Zero(n);
    for (const double q : {0.01, 0.02, 0.04, 0.08, 0.16, 0.32}) {
      const Eigen::MatrixXd L = (q * q * walk).llt().matrixL();
      Eigen::MatrixXd H = L.transpose() * F * L;
      H.diagonal().array() += 1.0;
      const Eigen::LLT<Eigen::MatrixXd> factor(H);
      const Eigen::VectorXd g = L.transpose() * b, solved = factor.solve(g);
      const double gained = 0.5 * g.dot(solved) - factor.matrixLLT().diagonal().array().log().sum();
      if (gained > best.log_likelihood_gain) {
        best.log_likelihood_gain = gained;
        gain = L * solved;
      }
    }
    if (best.log_likelihood_gain > 0.0) {
      best.gain_sd = std::sqrt(gain.squaredNorm() / static_cast<double>(n));
      // What is left of the residual when the gain has walked.
      std::vector<Vec3<double>> before(fit.stretches.size()), after(fit.stretches.size());
      const Vec3<double> weight = unit_acceleration(campaign.ship).cwiseInverse();
      parallel_for(fit.stretches.size(), jobs, [&](std::size_t s) {
        LinearStretch moved = fit.stretches[s];
        for (std::size_t i = 0; i < n; ++i) {
          if (evidence.blocks[i].stretch != s) continue;
          for (std::size_t k = evidence.blocks[i].begin; k < evidence.blocks[i].end && k < moved.steps.size(); ++k) {
            const std::vector<StepInputs<double>>& inputs = moved.data->inputs[k];
            const double h = moved.data->dt_s(k) / static_cast<double>(inputs.size());
            moved.steps[k].offset += gain[static_cast<Eigen::Index>(i)] / kGainStep *
                                     (advance<double>(modules[m].scaled, moved.path[k], inputs, h) -
                                      advance<double>(null, moved.path[k], inputs, h));
          }
        }
        const Smoothed smoothed = smooth(moved, fit.noise, Eigen::VectorXd::Zero(fit.theta.size()));
        before[s] = after[s] = Vec3<double>::Zero();
        for (std::size_t k = 0; k < smoothed.state.size(); ++k) {
          before[s] += fit.smoothed[s].state[k].segment<3>(kErrorStart).cwiseProduct(weight).cwiseAbs2();
          after[s] += smoothed.state[k].segment<3>(kErrorStart).cwiseProduct(weight).cwiseAbs2();
        }
      });
      double was = 0.0, is = 0.0;
      for (std::size_t s = 0; s < before.size(); ++s) was += before[s].sum(), is += after[s].sum();
      best.sigma_w_factor = was > 0.0 ? std::sqrt(is / was) : 1.0;
    }
    // Otherwise it moves the error, and whitens nothing.
    if (best.log_likelihood_gain > 0.0 && best.sigma_w_factor < 1.0) result.push_back(best);
  }
  std::sort(result.begin(), result.end(),
            [](const WalkingGain& a, const WalkingGain& b) { return a.log_likelihood_gain > b.log_likelihood_gain; });
  return result;
}

// ---- frames and regimes --------------------------------------------------------------------------------------------

// What the ship does and feels in the middle of a step.
struct Moment {
  double t_s = 0.0, u = 0.0, v = 0.0, r = 0.0, U = 0.0, psi = 0.0, x0 = 0.0, y0 = 0.0;
  Vec2<double> apparent = Vec2<double>::Zero();
  Actuators<double> actuators;
};

Moment moment_of(const LinearStretch& stretch, std::size_t k) {
  Moment at;
  const StateVector x = 0.5 * (stretch.path[k] + stretch.path[k + 1]);
  const std::vector<StepInputs<double>>& inputs = stretch.data->inputs[k];
  const Inputs<double>& middle =
      inputs.size() % 2 == 1 ? inputs[inputs.size() / 2].middle : inputs[inputs.size() / 2].start;
  at.t_s = 0.5 * (stretch.data->t_s[k] + stretch.data->t_s[k + 1]);
  at.x0 = x[0], at.y0 = x[1], at.psi = x[2], at.u = x[3], at.v = x[4], at.r = x[5];
  at.U = std::hypot(at.u, at.v);
  at.apparent = apparent_wind<double>(middle.true_wind, at.psi, at.u, at.v);
  at.actuators = middle.actuators;
  return at;
}

using Pattern = std::function<Vec3<double>(const Moment&)>;  // an acceleration in units of the axes, up to a factor

// A group of acceleration patterns and what the recordings say about it.
struct Group {
  std::vector<Pattern> patterns;
  Eigen::Index first = 0;
};

// The patterns' evidence, projected; columns are scaled to a root mean square of one unit.
struct PatternEvidence {
  Projected projected;
  Eigen::VectorXd scale;
  std::vector<Eigen::MatrixXd> values;  // per stretch: 3 x (steps * columns), scaled, in units of the axes
};

PatternEvidence pattern_evidence(const Campaign& campaign, const FittedNull& fit, const std::vector<Pattern>& patterns,
                                 std::size_t jobs) {
  const auto count = static_cast<Eigen::Index>(patterns.size());
  const std::size_t n = fit.stretches.size();
  PatternEvidence result;
  result.values.resize(n);
  parallel_for(n, jobs, [&](std::size_t s) {
    const LinearStretch& stretch = fit.stretches[s];
    result.values[s].resize(3, static_cast<Eigen::Index>(stretch.steps.size()) * count);
    for (std::size_t k = 0; k < stretch.steps.size(); ++k) {
      const Moment at = moment_of(stretch, k);
      for (Eigen::Index c = 0; c < count; ++c)
        result.values[s].col(static_cast<Eigen::Index>(k) * count + c) = patterns[static_cast<std::size_t>(c)](at);
    }
  });
  Eigen::VectorXd square = Eigen::VectorXd::Zero(count);
  double steps = 0.0;
  for (const Eigen::MatrixXd& values : result.values)
    for (Eigen::Index i = 0; i < values.cols(); ++i) square[i % count] += values.col(i).squaredNorm();
  for (const LinearStretch& stretch : fit.stretches) steps += static_cast<double>(stretch.steps.size());
  result.scale = (square / steps).cwiseSqrt();
  for (double& x : result.scale) x = x > 1e-9 ? 1.0 / x : 0.0;
  for (Eigen::MatrixXd& values : result.values)
    for (Eigen::Index i = 0; i < values.cols(); ++i) values.col(i) *= result.scale[i % count];

  const Vec3<double> unit = unit_acceleration(campaign.ship);
  std::vector<Evidence> parts(n);
  parallel_for(n, jobs, [&](std::size_t s) {
    const LinearStretch& stretch = fit.stretches[s];
    parts[s] = evidence(stretch, fit.noise, count, [&](std::size_t k, Eigen::Ref<Eigen::MatrixXd> out) {
      out.noalias() = stretch.steps[k].A.middleCols<3>(kErrorStart) *
                      (unit.asDiagonal() * result.values[s].middleCols(static_cast<Eigen::Index>(k) * count, count));
    });
  });
  Evidence total(fit.theta.size() + count);
  for (const Evidence& part : parts) total += part;
  result.projected = project(total, fit.theta, fit.prior_sd);
  return result;
}

// The smoothed residual at each step, in units of the axes.
std::vector<Eigen::Matrix3Xd> smoothed_residual(const Campaign& campaign, const FittedNull& fit) {
  const Vec3<double> per_unit = unit_acceleration(campaign.ship).cwiseInverse();
  std::vector<Eigen::Matrix3Xd> result;
  for (const Smoothed& smoothed : fit.smoothed) {
    Eigen::Matrix3Xd w(3, static_cast<Eigen::Index>(smoothed.state.size()) - 1);
    for (Eigen::Index k = 0; k < w.cols(); ++k)
      w.col(k) = smoothed.state[static_cast<std::size_t>(k)].segment<3>(kErrorStart).cwiseProduct(per_unit);
    result.push_back(std::move(w));
  }
  return result;
}

// Share of the residual's energy that a least-squares combination of some columns takes.
double share_of(const PatternEvidence& evidence, const std::vector<Eigen::Matrix3Xd>& residual, Eigen::Index first,
                Eigen::Index count, Eigen::Index all, int axis) {
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(count, count);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(count);
  double energy = 0.0;
  for (std::size_t s = 0; s < residual.size(); ++s)
    for (Eigen::Index k = 0; k < residual[s].cols(); ++k)
      for (int i = axis < 0 ? 0 : axis; i <= (axis < 0 ? 2 : axis); ++i) {
        const auto x = evidence.values[s].row(i).segment(k * all + first, count);
        A.noalias() += x.transpose() * x;
        b.noalias() += x.transpose() * residual[s](i, k);
        energy += residual[s](i, k) * residual[s](i, k);
      }
  if (!(energy > 0.0)) return 0.0;
  A.diagonal().array() += 1e-9 * A.trace() + 1e-300;
  return std::clamp(b.dot(A.ldlt().solve(b)) / energy, 0.0, 1.0);
}

std::vector<Frame> frames_of(const Campaign& campaign, const FittedNull& fit,
                             const std::vector<Eigen::Matrix3Xd>& residual, std::size_t jobs) {
  const auto along = [](int axis, auto value) -> Pattern {
    return [axis, value](const Moment& m) -> Vec3<double> { return Vec3<double>::Unit(axis) * value(m); };
  };
  std::vector<std::pair<std::string, std::vector<Pattern>>> groups;
  groups.push_back({"body", {}});
  for (int axis = 0; axis < 3; ++axis) groups.back().second.push_back(along(axis, [](const Moment&) { return 1.0; }));
  if (campaign.has_heading) {
    // A pull along x0 or y0, at a place of its own: surge, sway and the moment of the sway.
    groups.push_back({"earth", {}});
    for (const bool is_east : {false, true}) {
      const auto surge = [is_east](const Moment& m) { return is_east ? std::sin(m.psi) : std::cos(m.psi); };
      const auto sway = [is_east](const Moment& m) { return is_east ? std::cos(m.psi) : -std::sin(m.psi); };
      groups.back().second.push_back([=](const Moment& m) { return Vec3<double>(surge(m), sway(m), 0.0); });
      groups.back().second.push_back(along(2, sway));
    }
  }
  if (campaign.has_wind) {
    const auto q = [](const Moment& m) { return m.apparent.norm(); };
    groups.push_back({"apparent-wind",
                      {along(0, [=](const Moment& m) { return q(m) * m.apparent(0); }),
                       along(1, [=](const Moment& m) { return q(m) * m.apparent(1); }),
                       along(2, [=](const Moment& m) { return q(m) * m.apparent(1); }),
                       along(2, [](const Moment& m) { return m.apparent(0) * m.apparent(1); })}});
  }
  groups.push_back(
      {"water-speed",
       {along(0, [](const Moment& m) { return m.u * std::abs(m.u); }),
        along(0, [](const Moment& m) { return m.v * m.r; }), along(1, [](const Moment& m) { return m.v * m.U; }),
        along(1, [](const Moment& m) { return m.u * m.r; }), along(2, [](const Moment& m) { return m.v * m.u; }),
        along(2, [](const Moment& m) { return m.r * m.U; })}});
  if (campaign.has_position) {
    groups.push_back({"position", {}});
    for (int axis = 0; axis < 3; ++axis) {
      groups.back().second.push_back(along(axis, [](const Moment& m) { return m.x0; }));
      groups.back().second.push_back(along(axis, [](const Moment& m) { return m.y0; }));
    }
  }
  groups.push_back({"actuator", {}});
  for (const Actuator& actuator : campaign.ship.actuators) {
    const Channel c = actuator.channel;
    if (actuator.is_rudder()) {
      for (int axis = 0; axis < 3; ++axis)
        groups.back().second.push_back(along(axis, [c, axis](const Moment& m) {
          const double delta = m.actuators[c];
          return m.actuators[Channel::n_p] * m.actuators[Channel::n_p] *
                 (axis == 0 ? std::sin(delta) * std::sin(delta) : std::sin(delta) * std::cos(delta));
        }));
    } else {
      const bool is_propeller = c == Channel::n_p;
      for (int axis = is_propeller ? 0 : 1; axis < 3; ++axis)
        groups.back().second.push_back(
            along(axis, [c](const Moment& m) { return m.actuators[c] * std::abs(m.actuators[c]); }));
    }
  }

  std::vector<Pattern> patterns;
  for (const auto& [name, members] : groups) patterns.insert(patterns.end(), members.begin(), members.end());
  const PatternEvidence evidence = pattern_evidence(campaign, fit, patterns, jobs);
  const auto all = static_cast<Eigen::Index>(patterns.size());
  std::vector<Frame> frames;
  Eigen::Index first = 0;
  for (const auto& [name, members] : groups) {
    const auto count = static_cast<Eigen::Index>(members.size());
    const Eigen::VectorXd b = evidence.projected.b.segment(first, count);
    Eigen::MatrixXd M = evidence.projected.F.block(first, first, count, count);
    M.diagonal().array() += 1.0;  // strengths ~ N(0, reference acceleration^2)
    const Eigen::LLT<Eigen::MatrixXd> factor(M);
    frames.push_back({name, 0.5 * b.dot(factor.solve(b)) - factor.matrixLLT().diagonal().array().log().sum(),
                      share_of(evidence, residual, first, count, all, -1)});
    first += count;
  }
  std::sort(frames.begin(), frames.end(),
            [](const Frame& a, const Frame& b) { return a.log_evidence > b.log_evidence; });
  return frames;
}

// A variable that the residual may depend on.
struct Variable {
  std::string name, label, words;  // "u", "u [m/s]", "surge"
  double per_unit;                 // from SI to the label's unit
  bool is_angle;                   // all around: by its cosine and sine
  std::function<double(const Moment&)> value;
  int first_axis = 0, last_axis = 2;  // of the residuals that it is tried on
};

std::vector<Variable> variables_of(const Campaign& campaign) {
  const double L = campaign.ship.particulars.L_pp, deg = 1.0 / kDegree;
  std::vector<Variable> variables{
      {"u", "u [m/s]", "surge", 1.0, false, [](const Moment& m) { return m.u; }},
      {"beta", "drift angle [deg]", "drift angle", deg, false, [](const Moment& m) { return std::atan2(-m.v, m.u); }},
      {"r_prime", "r L/U [-]", "yaw rate r L/U", 1.0, false, [L](const Moment& m) {
         return std::clamp(m.r * L / std::max(m.U, 0.02 * std::sqrt(kGravity_mps2 * L)), -5.0, 5.0);
       }}};
  for (const Actuator& actuator : campaign.ship.actuators) {
    const Channel c = actuator.channel;
    const std::string name(info(c).name);
    variables.push_back({name, fmt::format("{} [{}]", name, actuator.is_rudder() ? "deg" : "1/s"),
                         actuator.is_rudder() ? "rudder angle " + name : "revolutions " + name,
                         actuator.is_rudder() ? deg : 1.0, false, [c](const Moment& m) { return m.actuators[c]; }});
  }
  if (campaign.has_wind) {
    // Pressure, with the sign of where it comes from.
    variables.push_back({"U_A", "U_A^2 from ahead [m^2/s^2]", "square of the apparent wind from ahead", 1.0, false,
                         [](const Moment& m) { return m.apparent.norm() * m.apparent(0); }, 0, 0});
    variables.push_back({"U_A", "U_A^2 from starboard [m^2/s^2]", "square of the apparent wind from starboard", 1.0,
                         false, [](const Moment& m) { return m.apparent.norm() * m.apparent(1); }, 1, 2});
    variables.push_back({"gamma_A", "apparent wind from [deg]", "direction of the apparent wind", deg, true,
                         [](const Moment& m) { return std::atan2(m.apparent(1), m.apparent(0)); }});
  }
  if (campaign.has_heading)
    variables.push_back(
        {"psi", "heading [deg]", "heading", deg, true, [](const Moment& m) { return wrap_angle(m.psi); }});
  if (campaign.has_position) {
    variables.push_back({"x0", "x0 [m]", "position x0", 1.0, false, [](const Moment& m) { return m.x0; }});
    variables.push_back({"y0", "y0 [m]", "position y0", 1.0, false, [](const Moment& m) { return m.y0; }});
  }
  variables.push_back({"t", "time [s]", "time", 1.0, false, [](const Moment& m) { return m.t_s; }});
  return variables;
}

// Binned means of the residual over a variable.
void bin(Regime& regime, const Campaign& campaign, const FittedNull& fit, const Variable& variable,
         const std::vector<Eigen::Matrix3Xd>& residual) {
  std::vector<std::pair<double, double>> points;
  const double unit = unit_acceleration(campaign.ship)[regime.axis];
  for (std::size_t s = 0; s < residual.size(); ++s)
    for (Eigen::Index k = 0; k < residual[s].cols(); ++k)
      points.push_back({variable.value(moment_of(fit.stretches[s], static_cast<std::size_t>(k))) * variable.per_unit,
                        residual[s](regime.axis, k) * unit});
  std::sort(points.begin(), points.end());
  constexpr std::size_t kBins = 8;
  // Neighbors in time say nearly the same.
  const double per_independent = std::max(1.0, 2.0 * fit.noise.tau_s / campaign.step_s);
  for (std::size_t i = 0; i < kBins; ++i) {
    const std::size_t begin = i * points.size() / kBins, end = (i + 1) * points.size() / kBins;
    if (end <= begin) continue;
    double x = 0.0, sum = 0.0, square = 0.0;
    const auto n = static_cast<double>(end - begin);
    for (std::size_t k = begin; k < end; ++k) {
      x += points[k].first / n;
      sum += points[k].second / n;
      square += points[k].second * points[k].second / n;
    }
    regime.x.push_back(x);
    regime.mean.push_back(sum);
    regime.mean_sd.push_back(std::sqrt(std::max(square - sum * sum, 0.0) * per_independent / n));
  }
}

// " m/s" of "u [m/s]"; nothing for a ratio.
std::string unit_in(const std::string& label) {
  const std::size_t open = label.find('[');
  if (open == std::string::npos || label.substr(open) == "[-]") return "";
  return " " + label.substr(open + 1, label.size() - open - 2);
}

std::vector<Regime> regimes_of(const Campaign& campaign, const FittedNull& fit,
                               const std::vector<Eigen::Matrix3Xd>& residual, const LocateOptions& options) {
  const std::vector<Variable> variables = variables_of(campaign);
  // Mean and spread of each variable, so that its functions are about centered.
  std::vector<double> mean(variables.size(), 0.0), spread(variables.size(), 0.0);
  double n = 0.0;
  for (const LinearStretch& stretch : fit.stretches)
    for (std::size_t k = 0; k < stretch.steps.size(); ++k, n += 1.0) {
      const Moment at = moment_of(stretch, k);
      for (std::size_t i = 0; i < variables.size(); ++i) {
        const double x = variables[i].value(at);
        mean[i] += x;
        spread[i] += x * x;
      }
    }
  for (std::size_t i = 0; i < variables.size(); ++i) {
    mean[i] /= n;
    spread[i] = std::sqrt(std::max(spread[i] / n - mean[i] * mean[i], 0.0));
  }
  std::vector<Pattern> patterns;
  struct Test {
    std::size_t variable;
    int axis;
    Eigen::Index first;
  };
  std::vector<Test> tests;
  for (std::size_t i = 0; i < variables.size(); ++i) {
    if (!(spread[i] > 1e-6 * (std::abs(mean[i]) + 1e-3))) continue;
    const Variable& variable = variables[i];
    const auto odd = [&variable, m = mean[i], s = spread[i]](const Moment& at) {
      return variable.is_angle ? std::cos(variable.value(at)) : (variable.value(at) - m) / s;
    };
    const auto even = [&variable, m = mean[i], s = spread[i]](const Moment& at) {
      if (variable.is_angle) return std::sin(variable.value(at));
      const double x = (variable.value(at) - m) / s;
      return x * x - 1.0;
    };
    for (int axis = variable.first_axis; axis <= variable.last_axis; ++axis) {
      tests.push_back({i, axis, static_cast<Eigen::Index>(patterns.size())});
      patterns.push_back([odd, axis](const Moment& at) -> Vec3<double> { return Vec3<double>::Unit(axis) * odd(at); });
      patterns.push_back(
          [even, axis](const Moment& at) -> Vec3<double> { return Vec3<double>::Unit(axis) * even(at); });
    }
  }
  const PatternEvidence evidence = pattern_evidence(campaign, fit, patterns, options.jobs);
  const auto all = static_cast<Eigen::Index>(patterns.size());
  std::vector<Regime> regimes;
  for (const Test& test : tests) {
    const Eigen::VectorXd b = evidence.projected.b.segment<2>(test.first);
    const Eigen::MatrixXd F = evidence.projected.F.block<2, 2>(test.first, test.first);
    const ScoreTest score = score_test(b, F);
    if (score.rank == 0) continue;
    const Variable& variable = variables[test.variable];
    Regime regime;
    regime.variable = variable.name;
    regime.axis = test.axis;
    regime.x_label = variable.label;
    regime.p_value = chi_squared_survival(score.statistic, score.rank);
    regime.share = share_of(evidence, residual, test.first, 2, all, test.axis);
    const double linear = F(0, 0) > 0.0 ? b[0] * b[0] / F(0, 0) : 0.0;
    const double quadratic = F(1, 1) > 0.0 ? b[1] * b[1] / F(1, 1) : 0.0;
    const char* const axis_name = kAxisNames[static_cast<std::size_t>(test.axis)];
    const double percent = 100.0 * regime.share;
    if (variable.is_angle) {
      regime.relation = "harmonic";
      double largest_deg =
          std::atan2(score.beta[1] * evidence.scale[test.first + 1], score.beta[0] * evidence.scale[test.first]) /
          kDegree;
      if (largest_deg < 0.0) largest_deg += 360.0;
      regime.sentence = fmt::format("{} residual turns with the {}, largest at {:.0f} deg, {:.0f} % of its variance",
                                    axis_name, variable.words, largest_deg, percent);
    } else if (linear >= quadratic) {
      regime.relation = "linear";
      regime.sentence = fmt::format("{} residual {} with the {}, {:.0f} % of its variance", axis_name,
                                    score.beta[0] > 0.0 ? "grows" : "falls", variable.words, percent);
    } else {
      regime.relation = "quadratic";
      regime.sentence = fmt::format("{} residual is {} where the {} is far from {:.2g}{}, {:.0f} % of its variance",
                                    axis_name, score.beta[1] > 0.0 ? "larger" : "smaller", variable.words,
                                    mean[test.variable] * variable.per_unit, unit_in(variable.label), percent);
    }
    regimes.push_back(std::move(regime));
  }
  // Benjamini & Hochberg (1995).
  std::sort(regimes.begin(), regimes.end(), [](const Regime& a, const Regime& b) { return a.p_value < b.p_value; });
  const auto count = static_cast<double>(regimes.size());
  double q = 1.0;
  for (std::size_t i = regimes.size(); i-- > 0;) {
    q = std::min(q, regimes[i].p_value * count / static_cast<double>(i + 1));
    regimes[i].q_value = q;
  }
  regimes.erase(std::remove_if(regimes.begin(), regimes.end(),
                               [&](const Regime& r) { return r.q_value > options.false_discovery; }),
                regimes.end());
  for (Regime& regime : regimes)
    for (const Variable& variable : variables)
      if (variable.name == regime.variable && regime.axis >= variable.first_axis && regime.axis <= variable.last_axis)
        bin(regime, campaign, fit, variable, residual);
  return regimes;
}

}  // namespace

std::vector<Residual> residuals(const Campaign& campaign, const FittedNull& fit) {
  const bool knows_inertia = campaign.knows_inertia();
  const Mat3<double> M = inertia_matrix(campaign.ship);
  std::vector<Residual> result(campaign.recordings.size());
  for (std::size_t i = 0; i < result.size(); ++i) {
    result[i].recording = campaign.recordings[i].name;
    result[i].file = campaign.recordings[i].file;
    result[i].has_position = campaign.recordings[i].has(Channel::x0) && campaign.recordings[i].has(Channel::y0);
  }
  for (std::size_t s = 0; s < fit.smoothed.size(); ++s) {
    const Stretch& stretch = campaign.stretches[s];
    Residual& residual = result[stretch.recording];
    for (std::size_t k = 0; k < stretch.size(); ++k) {
      const StateVector& x = fit.smoothed[s].state[k];
      const Mat3<double> P = fit.smoothed[s].covariance[k].block<3, 3>(kErrorStart, kErrorStart);
      residual.t_s.push_back(stretch.t_s[k]);
      residual.acceleration.push_back(x.segment<3>(kErrorStart));
      residual.acceleration_sd.push_back(P.diagonal().cwiseMax(0.0).cwiseSqrt());
      residual.eta.push_back(x.head<3>());
      residual.nu.push_back(x.segment<3>(3));
      residual.measured_nu.push_back(stretch.measured[k].tail<3>());
      if (!knows_inertia) continue;
      residual.force.push_back(M * x.segment<3>(kErrorStart));
      residual.force_sd.push_back((M * P * M.transpose()).diagonal().cwiseMax(0.0).cwiseSqrt());
    }
  }
  result.erase(std::remove_if(result.begin(), result.end(), [](const Residual& r) { return r.t_s.empty(); }),
               result.end());
  return result;
}

Strongest strongest_interval(const Campaign& campaign, const FittedNull& fit, const LocateOptions& options) {
  Strongest result;
  for (Interval& interval :
       scan(campaign, fit, block_evidence(campaign, fit, {}, options.jobs), options, result.p_value))
    if (!result.interval && !interval.is_small && !interval.is_untrained()) result.interval = std::move(interval);
  return result;
}

Location locate(const Campaign& campaign, const FittedNull& fit, const LocateOptions& options) {
  Location result;
  const std::vector<Module> modules = modules_of(campaign, fit);
  const BlockEvidence blocks = block_evidence(campaign, fit, modules, options.jobs);
  result.located.intervals = scan(campaign, fit, blocks, options, result.scan_p_value);
  result.located.modules = walking_gains(campaign, fit, blocks, modules, options.jobs);

  const std::vector<Eigen::Matrix3Xd> residual = smoothed_residual(campaign, fit);
  Vec3<double> energy = Vec3<double>::Zero();
  for (std::size_t s = 0; s < residual.size(); ++s)  // events, which have their intervals, would hide all else
    for (Eigen::Index k = 0; k < residual[s].cols(); ++k) {
      const std::vector<Vec3<double>>& scale = fit.event_scale[s];
      energy += residual[s].col(k).cwiseAbs2().cwiseQuotient(
          (scale.empty() ? Vec3<double>::Ones() : scale[static_cast<std::size_t>(k)]).cwiseAbs2());
    }
  if (energy.sum() > 0.0) result.located.share = energy / energy.sum();
  result.located.frames = frames_of(campaign, fit, residual, options.jobs);
  result.located.regimes = regimes_of(campaign, fit, residual, options);

  if (!campaign.knows_inertia()) return result;
  if (result.located.share[1] > 0.05)
    result.located.line_of_action = line_of_action(campaign, fit, blocks.blocks, residual);
  if (const auto sharper = line_of_action(campaign, result.located.intervals)) result.located.line_of_action = sharper;
  return result;
}

}  // namespace leeway::gap
