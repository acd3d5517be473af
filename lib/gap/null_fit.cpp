#include "gap/null_fit.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <ceres/gradient_problem.h>
#include <ceres/gradient_problem_solver.h>
#include <fmt/format.h>

#include "core/errors.hpp"
#include "core/parallel.hpp"
#include "core/units.hpp"
#include "gap/effect_columns.hpp"

namespace leeway::gap {
namespace {

constexpr double kOutlier = 6.0;        // sd of what the other measurements predict
constexpr double kLeastLeft = 0.01;     // of a measurement's variance that the smoothed state does not share
constexpr double kLeastRobustSd = 0.5;  // by which outliers are judged, of the one with them
constexpr double kThetaAtRest = 0.02, kThetaNearRest = 0.1;  // of a prior sd
constexpr double kNear = 0.3, kFar = 3.0;                    // distance from the best parameters in their posterior sd
constexpr double kNoiseAtRest = 0.03;                        // of ln level
constexpr double kLargestStep = 0.3;                         // of theta in one iteration
constexpr double kLargestTimingStep = 3.0;                   // of the timing, which is no logarithm
constexpr double kLargestEffectStep = 1.0;                   // of a coordinate
constexpr double kLeastDamping = 0.3, kMostDamping = 20.0, kDampingFactor = 4.0;
constexpr double kLeastGain = 0.01;        // of the log posterior by a step
constexpr double kTellingGain = 0.1;       // of the log posterior, by which steps are judged
constexpr double kNearer = 0.8;            // or so much nearer to where its slope vanishes
constexpr double kLevelDifference = 0.02;  // for derivatives by ln level
constexpr double kLeastError = 0.005;      // of the typical acceleration: steps, means and inputs are no better
constexpr double kEventBlock_s = 10.0;     // at 3 m
constexpr double kEvent = 16.0, kStillEvent = 4.0;  // mean square of the model error in a block by the usual one
constexpr double kMedianSquare = 0.6;               // median of the mean square of about two independent values
constexpr int kFreeSteps = 8;                       // iterations in which steps need not make the recordings likelier
constexpr int kEventsSettled = 14;                  // iterations after which events stay what they are
constexpr double kLevelReach = 1.5;                 // of ln level: the paths are renewed before one goes farther

double robust_sd(std::vector<double> x) {
  if (x.empty()) return 0.0;
  for (double& v : x) v = std::abs(v);
  std::nth_element(x.begin(), x.begin() + static_cast<std::ptrdiff_t>(x.size() / 2), x.end());
  return 1.4826 * x[x.size() / 2];
}

// From second differences, which leave little of the ship's motion.
Noise first_noise(const Campaign& campaign) {
  Noise noise;
  const double L = campaign.ship.particulars.L_pp, scale = campaign.time_scale();
  noise.sigma_w << 1e-3, 1e-3, 1e-3 / (0.25 * L);
  noise.tau_s = 12.0 * scale;
  // Shorter is noise of the sensors, longer a force that has a cause.
  noise.least_tau_s = 4.0 * scale;
  noise.longest_tau_s = 40.0 * scale;
  noise.wind_tau_s = 15.0 * scale;
  // Sensors show more than this, sampled inputs leave more.
  noise.least_measurement_sd << 1e-3 * std::sqrt(scale), 1e-3 * std::sqrt(scale), 0.02 * kDegree, 4e-4 * scale,
      4e-4 * scale, 0.01 * kDegree / scale;
  const Vec6 least = (Vec6() << 1e-3, 1e-3, 1e-4, 1e-4, 1e-4, 1e-5).finished();
  for (int i = 0; i < kShipStates; ++i) {
    std::vector<double> differences;
    for (const Stretch& stretch : campaign.stretches) {
      std::vector<std::size_t> known;
      for (std::size_t k = 0; k < stretch.size(); ++k) {
        if (std::isnan(stretch.measured[k][i])) continue;
        known.push_back(k);
        const std::size_t n = known.size();
        if (n < 3 || known[n - 1] - known[n - 2] != known[n - 2] - known[n - 3]) continue;
        differences.push_back(stretch.measured[k][i] - 2.0 * stretch.measured[known[n - 2]][i] +
                              stretch.measured[known[n - 3]][i]);
      }
    }
    noise.measurement_sd[i] = std::max(robust_sd(differences) / std::sqrt(6.0), least[i]);
  }
  noise.measurement_sd.head<2>().setConstant(noise.measurement_sd.head<2>().maxCoeff());
  return noise;
}

// A LevelProblem as Ceres sees it: steps of the free levels from `at`, in units in which the curvature is about 1,
// since BFGS begins with the unit matrix.
class LevelCost final : public ceres::FirstOrderFunction {
 public:
  LevelCost(const LevelProblem& problem, const Levels& at, const Levels& unit)
      : problem_(problem), at_(at), unit_(unit) {}

  int NumParameters() const override { return static_cast<int>(problem_.free.size()); }

  Levels levels(const double* parameters) const {
    Levels h = at_;
    for (std::size_t i = 0; i < problem_.free.size(); ++i)
      h[problem_.free[i]] += unit_[problem_.free[i]] * parameters[i];
    return h;
  }
  /// The units that the curvature at the last point suggests.
  const Levels& next_unit() const { return next_unit_; }

  bool Evaluate(const double* parameters, double* cost, double* gradient) const override {
    const Levels h = levels(parameters);
    if (!h.allFinite() || (h - at_).cwiseAbs().maxCoeff() > kLevelReach) return false;
    std::vector<Levels> points{h};
    if (gradient != nullptr)
      for (const int i : problem_.free)
        for (const double sign : {1.0, -1.0}) points.push_back(h + sign * kLevelDifference * Levels::Unit(i));
    const std::vector<double> costs = problem_.costs(points);
    if (!std::all_of(costs.begin(), costs.end(), [](double c) { return std::isfinite(c); })) return false;
    *cost = costs[0];
    if (gradient != nullptr)
      for (std::size_t i = 0; i < problem_.free.size(); ++i) {
        const int level = problem_.free[i];
        gradient[i] = unit_[level] * (costs[1 + 2 * i] - costs[2 + 2 * i]) / (2.0 * kLevelDifference);
        const double curvature =
            (costs[1 + 2 * i] + costs[2 + 2 * i] - 2.0 * costs[0]) / (kLevelDifference * kLevelDifference);
        next_unit_[level] = 1.0 / std::sqrt(std::clamp(curvature, 1.0, 1e6));
      }
    return true;
  }

 private:
  const LevelProblem& problem_;
  const Levels at_, unit_;
  mutable Levels next_unit_ = Levels::Ones();
};

Vec3<double> typical_acceleration(const std::vector<LinearStretch>& stretches) {
  Vec3<double> sum = Vec3<double>::Zero();
  double n = 0.0;
  for (const LinearStretch& stretch : stretches)
    for (std::size_t k = 0; k + 1 < stretch.path.size(); ++k) {
      const Vec3<double> rate = (stretch.path[k + 1] - stretch.path[k]).segment<3>(3) / stretch.data->dt_s(k);
      sum += rate.cwiseAbs2();
      n += 1.0;
    }
  return (sum / n).cwiseSqrt();
}

// Renews the scales of the model error: blocks whose mean square is far above that of most. The median knows what most
// blocks are, also where a few have made sigma_w large.
void find_events(FittedNull& fit, const Campaign& campaign) {
  fit.log_prior_of_events = 0.0;
  const double block_s = kEventBlock_s * campaign.time_scale();
  struct Piece {
    std::size_t stretch, begin, end;
    Vec3<double> mean_square;
  };
  std::vector<Piece> blocks;
  for (std::size_t s = 0; s < campaign.stretches.size(); ++s) {
    const Stretch& stretch = campaign.stretches[s];
    const Smoothed& smoothed = fit.smoothed[s];
    fit.event_scale[s].resize(stretch.size(), Vec3<double>::Ones());
    for (std::size_t begin = 0, end = 0; begin < stretch.size(); begin = end) {
      Vec3<double> square = Vec3<double>::Zero();
      for (; end < stretch.size() && stretch.t_s[end] - stretch.t_s[begin] < block_s; ++end)
        square += smoothed.state[end].segment<3>(kErrorStart).cwiseAbs2() +
                  smoothed.covariance[end].diagonal().segment<3>(kErrorStart);
      blocks.push_back({s, begin, end, square / static_cast<double>(end - begin)});
    }
  }
  std::vector<double> squares(blocks.size());
  for (int i = 0; i < 3; ++i) {
    std::transform(blocks.begin(), blocks.end(), squares.begin(), [i](const Piece& b) { return b.mean_square[i]; });
    std::nth_element(squares.begin(), squares.begin() + static_cast<std::ptrdiff_t>(squares.size() / 2), squares.end());
    const double usual = squares[squares.size() / 2] / kMedianSquare;
    for (const Piece& block : blocks) {
      const double ratio = block.mean_square[i] / usual;
      const bool was_event = fit.event_scale[block.stretch][block.begin][i] > 1.0;
      const double scale = ratio > (was_event ? kStillEvent : kEvent) ? std::sqrt(ratio) : 1.0;
      if (scale > 1.0) fit.log_prior_of_events -= std::log(3.0 * static_cast<double>(blocks.size()));
      for (std::size_t k = block.begin; k < block.end; ++k) fit.event_scale[block.stretch][k][i] = scale;
    }
  }
}

std::vector<EffectColumns> columns_by_recording(const Campaign& campaign, const Hypothesis& hypothesis,
                                                const Eigen::VectorXd& z, const Eigen::VectorXd& plain_theta) {
  std::vector<EffectColumns> result;
  for (std::size_t r = 0; r < campaign.recordings.size(); ++r)
    result.emplace_back(campaign, hypothesis, z, plain_theta, r);
  return result;
}

enum class Judged { nothing, events, all };  // all: outliers as well

// The way to the best parameters and noise levels, by Gauss-Newton steps along paths that are renewed.
class Climb {
 public:
  ///   knows_sensors  false: the noise of the measurements stays what it is
  Climb(Campaign& campaign, FittedNull& fit, const Hypothesis& hypothesis, const FitOptions& options,
        bool knows_sensors)
      : campaign_(campaign), fit_(fit), hypothesis_(hypothesis), options_(options) {
    fit.stretches.resize(campaign.stretches.size());
    fit.smoothed.resize(campaign.stretches.size());
    fit.event_scale.resize(campaign.stretches.size());
    if (knows_sensors)
      for (int level = kTauLevel + 1; level < kWindLevel; ++level) free_levels_.push_back(level);
    if (campaign.has_wind) free_levels_.push_back(kWindLevel);
  }

  Eigen::VectorXd prior(double UncertainParameter::*sd) const {
    Eigen::VectorXd result(fit_.theta.size());
    for (Eigen::Index i = 0; i < result.size(); ++i) result[i] = fit_.parameters[static_cast<std::size_t>(i)].*sd;
    return result;
  }

  LevelProblem levels() const {
    return {fit_.stretches,           fit_.theta,   fit_.prior_sd,
            ExtraColumns{0, nullptr}, fit_.noise,   fit_.level_prior_mean,
            fit_.level_prior_sd,      free_levels_, options_.jobs};
  }

  /// Renews stretches and total at theta, from stretches near by.
  void linearize_all(const std::vector<LinearStretch>& before) {
    const Eigen::Index effects = fit_.effects;
    const Eigen::VectorXd plain = without_effects(fit_.theta, effects);
    if (campaign_.ensemble) return linearize_ensemble(before);
    const std::vector<EffectColumns> by_recording =
        columns_by_recording(campaign_, hypothesis_, fit_.theta.segment(plain.size() - 1, effects), plain);
    parallel_for(fit_.stretches.size(), options_.jobs, [&](std::size_t s) {
      Stretch& stretch = campaign_.stretches[s];
      const EffectColumns& columns = by_recording[stretch.recording];
      if (columns.response() != responses_[s]) columns.set_inputs_of(stretch);
      responses_[s] = columns.response();
      if (before[s].data == nullptr)
        fit_.stretches[s] = linearize(columns.ship(), stretch, measured_path(stretch), plain);
      else
        fit_.stretches[s] = linearize_filtered(columns.ship(), before[s], fit_.noise, fit_.event_scale[s], plain);
      if (effects > 0) columns.add_to(fit_.stretches[s]);
    });
    judge_all();
  }

  /// Goes on until the steps rest or are too many; returns whether they rest.
  /// Outliers are judged on the way for nothing missing alone, so that hypotheses are compared on the same data.
  bool to_rest(int most_iterations, Judged judged) {
    const bool judges = judged == Judged::all;
    double moved = 1.0, noise_moved = 1.0, damping = 0.0;
    for (int iteration = 0;; ++iteration, ++fit_.report.iterations) {
      const bool is_free = judges && iteration < kFreeSteps;
      if (iteration == 0 || judges) linearize_all(fit_.stretches);
      if (!std::isfinite(fit_.total.log_likelihood)) throw NumericalError(diverged());
      const Eigen::VectorXd slope = slope_now();
      double& distance = fit_.report.distance;
      fit_.report.gradient = slope.cwiseProduct(fit_.prior_sd).cwiseAbs().maxCoeff();
      distance = distance_now();
      const bool stands = iteration > 1 && moved < kThetaAtRest && noise_moved < kNoiseAtRest;
      if ((stands && (distance < kNear || moved == 0.0)) || iteration == most_iterations)
        return stands && distance < kFar;

      // Noise levels, once the path has been smoothed for the first time; later few steps, since parameters follow.
      if ((!judges || iteration > 0) && (noise_moved > kNoiseAtRest || moved > kThetaNearRest)) {
        const Levels before = levels_of(fit_.noise);
        fit_.noise = noise_of(levels().minimize(before, is_free ? 5 : 2, fit_.level_unit), fit_.noise);
        noise_moved = (levels_of(fit_.noise) - before).cwiseAbs().maxCoeff();
        fit_.total = levels().total(fit_.noise);
      }
      // Far from the best noise levels likelihoods say little, and about the measurements' path nothing.
      moved = step(damping, is_free).cwiseQuotient(fit_.prior_sd).cwiseAbs().maxCoeff();
      parallel_for(fit_.stretches.size(), options_.jobs, [&](std::size_t s) {
        fit_.smoothed[s] = smooth(fit_.stretches[s], fit_.noise, Eigen::VectorXd::Zero(fit_.theta.size()));
        if (!judges) return;
        const std::size_t settling = std::min(kSettling, fit_.smoothed[s].state.size());
        std::copy_n(fit_.smoothed[s].state.begin(), settling, fit_.stretches[s].path.begin());
      });
      if (judged != Judged::nothing && iteration > 1 && iteration < kEventsSettled) {
        find_events(fit_, campaign_);
        if (!judges) take_events();
      }
      // Once more when events no longer hide them.
      if (judges && (iteration == 2 || iteration == 6)) leave_out_outliers();
      if (options_.progress)
        options_.progress(1.0 - 1.0 / (1.0 + 0.3 * fit_.report.iterations),
                          fmt::format("parameters still move by {:.2g} sd", moved));
    }
  }

  /// Judges the linearized stretches by the events that were found.
  void take_events() {
    for (std::size_t s = 0; s < fit_.stretches.size(); ++s) fit_.stretches[s].event_scale = fit_.event_scale[s];
    fit_.total = levels().total(fit_.noise);
  }

  /// Takes a response of the rudders that was tried out of the campaign.
  void restore_inputs() {
    const RudderResponse own = Effects<double>(campaign_.ship).rudder_response();
    for (std::size_t s = 0; s < responses_.size(); ++s) {
      Stretch& stretch = campaign_.stretches[s];
      if (responses_[s] != own)
        set_inputs(stretch, campaign_.recorded_inputs[stretch.recording].through(own), campaign_.ship);
      responses_[s] = own;
    }
  }

 private:
  // Which recording the simulator cannot follow at all.
  std::string diverged() const {
    std::string text =
        "the simulator runs away along the recordings, whose inputs or states are far from what it knows";
    for (std::size_t s = 0; s < fit_.stretches.size(); ++s)
      if (!std::isfinite(evidence(fit_.stretches[s], fit_.noise).log_likelihood)) {
        const Stretch& stretch = campaign_.stretches[s];
        text = fmt::format("{}: {} between {:.4g} and {:.4g} s", campaign_.recordings[stretch.recording].file, text,
                           stretch.t_s.front(), stretch.t_s.back());
        break;
      }
    for (const std::string& notice : campaign_.notices) text += "; " + notice;
    return text;
  }

  void linearize_ensemble(const std::vector<LinearStretch>& before) {
    const EnsembleSimulator& ensemble = *campaign_.ensemble;
    parallel_for(fit_.stretches.size(), options_.jobs, [&](std::size_t s) {
      const Stretch& stretch = campaign_.stretches[s];
      fit_.stretches[s] = before[s].data == nullptr
                              ? linearize(ensemble, stretch, measured_path(stretch), fit_.theta)
                              : linearize_filtered(ensemble, before[s], fit_.noise, fit_.event_scale[s], fit_.theta);
    });
    judge_all();
  }

  void judge_all() {
    fit_.noise.least_sigma_w = kLeastError * typical_acceleration(fit_.stretches);
    fit_.total = levels().total(fit_.noise);
  }

  Eigen::VectorXd precision() const { return fit_.prior_sd.array().square().inverse(); }
  Eigen::VectorXd slope_now() const { return fit_.total.b - precision().cwiseProduct(fit_.theta); }
  Eigen::MatrixXd curvature_now() const {
    Eigen::MatrixXd M = fit_.total.F;
    M.diagonal() += precision();
    return M;
  }
  // From where the slope vanishes, in posterior standard deviations.
  double distance_now() const {
    const Eigen::VectorXd slope = slope_now();
    return std::sqrt(std::max(0.0, slope.dot(curvature_now().llt().solve(slope))));
  }
  double log_posterior() const {
    return fit_.total.log_likelihood - 0.5 * fit_.theta.dot(precision().cwiseProduct(fit_.theta));
  }

  // A Gauss-Newton step of theta, shortened by 1 + damping, until it makes what was recorded more likely, unless
  // `anyhow`; zero where none does. Kinks of the model, and a filter that gets to know other paths, let full steps lead
  // away.
  Eigen::VectorXd step(double& damping, bool anyhow) {
    const Eigen::VectorXd theta = fit_.theta, slope = slope_now();
    const Eigen::MatrixXd M = curvature_now();
    const Evidence total = fit_.total;
    const double before = log_posterior(), distance = distance_now();
    const Eigen::VectorXd newton = M.llt().solve(slope);
    if (!newton.allFinite()) return Eigen::VectorXd::Zero(theta.size());
    std::vector<LinearStretch> stretches(fit_.stretches.size());
    std::swap(stretches, fit_.stretches);
    const Eigen::Index effects = fit_.effects, coefficients = theta.size() - 1 - effects;
    for (;;) {
      Eigen::VectorXd step = newton;
      double too_long = std::max({1.0 + damping, step.head(coefficients).lpNorm<Eigen::Infinity>() / kLargestStep,
                                  std::abs(step[step.size() - 1]) / kLargestTimingStep});
      if (effects > 0)
        too_long = std::max(too_long, step.segment(coefficients, effects).cwiseAbs().maxCoeff() / kLargestEffectStep);
      step /= too_long;
      fit_.theta = theta + step;
      linearize_all(stretches);
      // Neither, where the simulator runs away.
      const bool is_better = log_posterior() > before + kLeastGain || distance_now() < kNearer * distance;
      if (is_better || (anyhow && std::isfinite(fit_.total.log_likelihood))) {
        const double promised = slope.dot(step) - 0.5 * step.dot(M * step), gained = log_posterior() - before;
        if (promised > kTellingGain && gained < 0.25 * promised)
          damping = std::max(kDampingFactor * damping, kLeastDamping);
        else if (promised <= kTellingGain || gained > 0.75 * promised)
          damping = damping > kLeastDamping ? damping / kDampingFactor : 0.0;
        return step;
      }
      damping = std::max(kDampingFactor * damping, kLeastDamping);
      if (damping > kMostDamping) break;
    }
    damping = kLeastDamping;
    fit_.theta = theta;
    fit_.total = total;
    std::swap(stretches, fit_.stretches);
    return Eigen::VectorXd::Zero(theta.size());
  }

  // Judged by what all other measurements say, before and after: e of the smoothed state has the variance R - P, which
  // is e of the prediction without this measurement, in its own sd (de Jong 1988). Outliers make that sd too large; the
  // median knows better.
  void leave_out_outliers() {
    struct Judgment {
      double* y;
      double z;
    };
    for (int i = 0; i < kShipStates; ++i) {
      const double R = std::pow(fit_.noise.measurement_sd[i], 2);
      std::vector<Judgment> judgments;
      std::vector<double> scores;
      for (std::size_t s = 0; s < fit_.stretches.size(); ++s) {
        const LinearStretch& stretch = fit_.stretches[s];
        for (std::size_t k = 1; k < stretch.path.size(); ++k) {
          double& y = campaign_.stretches[s].measured[k][i];
          const double left = R - fit_.smoothed[s].covariance[k](i, i);
          // Where others say little about it, left is rounding.
          if (std::isnan(y) || left < kLeastLeft * R) continue;
          const double e = y - stretch.mean_offset[k][i] - fit_.smoothed[s].state[k][i];
          judgments.push_back({&y, e / std::sqrt(left)});
          scores.push_back(judgments.back().z);
        }
      }
      const double sd = std::clamp(robust_sd(std::move(scores)), kLeastRobustSd, 1.0);
      for (const Judgment& judgment : judgments)
        if (std::abs(judgment.z) > kOutlier * sd) {
          *judgment.y = kMissing;
          ++fit_.report.outliers;
        }
    }
  }

  Campaign& campaign_;
  FittedNull& fit_;
  const Hypothesis& hypothesis_;
  const FitOptions& options_;
  // Of the rudders, in the inputs of each stretch.
  std::vector<RudderResponse> responses_ =
      std::vector<RudderResponse>(campaign_.stretches.size(), Effects<double>(campaign_.ship).rudder_response());
  std::vector<int> free_levels_{0, 1, 2, 3};
};

}  // namespace

double marginal(const Evidence& evidence, const Eigen::VectorXd& theta, const Eigen::VectorXd& prior_sd) {
  const Eigen::VectorXd precision = prior_sd.array().square().inverse();
  const Eigen::VectorXd g = evidence.b - precision.cwiseProduct(theta);
  Eigen::MatrixXd M = evidence.F;
  M.diagonal() += precision;
  const Eigen::LLT<Eigen::MatrixXd> factor(M);
  const double log_det = 2.0 * factor.matrixLLT().diagonal().array().log().sum();
  return evidence.log_likelihood - 0.5 * theta.dot(precision.cwiseProduct(theta)) + 0.5 * g.dot(factor.solve(g)) -
         0.5 * log_det - prior_sd.array().log().sum();
}

Levels levels_of(const Noise& noise) {
  Levels h;
  h << noise.sigma_w, noise.tau_s, noise.measurement_sd[0], noise.measurement_sd.tail<4>(), noise.wind_share;
  return h.array().log();
}

Noise noise_of(const Levels& levels, const Noise& like) {
  const Levels x = levels.array().exp();
  Noise noise = like;
  noise.sigma_w = x.head<3>().cwiseMax(like.least_sigma_w);
  noise.tau_s = std::clamp(x[kTauLevel], like.least_tau_s, like.longest_tau_s);
  noise.measurement_sd << x[4], x[4], x.segment<4>(5);
  noise.measurement_sd = noise.measurement_sd.cwiseMax(like.least_measurement_sd);
  noise.wind_share = x[kWindLevel];
  return noise;
}

std::vector<std::size_t> sample_of(const std::vector<LinearStretch>& stretches, std::size_t most_points) {
  std::size_t points = 0;
  for (const LinearStretch& stretch : stretches) points += stretch.path.size();
  const std::size_t every = std::max<std::size_t>(1, points / most_points);
  std::vector<std::size_t> sample;
  for (std::size_t s = 0; s < stretches.size(); s += every) sample.push_back(s);
  return sample;
}

std::vector<double> LevelProblem::costs(const std::vector<Levels>& points) const {
  const std::vector<std::size_t> sample = sample_of(stretches, most_points);
  const std::size_t n = sample.size();
  std::vector<Evidence> parts(points.size() * n);
  parallel_for(parts.size(), jobs, [&](std::size_t i) {
    const std::size_t s = sample[i % n];
    parts[i] =
        evidence(stretches[s], noise_of(points[i / n], like), extra.count, extra.of ? extra.of(s) : MoreColumns());
  });
  std::vector<double> costs;
  for (std::size_t i = 0; i < points.size(); ++i) {
    Evidence total(theta.size());
    for (std::size_t s = 0; s < n; ++s) total += parts[i * n + s];
    costs.push_back(-marginal(total, theta, prior_sd) +
                    0.5 * ((points[i] - prior_mean).array() / prior_sd_of_levels.array()).square().sum());
  }
  return costs;
}

Evidence LevelProblem::total(const Noise& noise) const {
  std::vector<Evidence> parts(stretches.size());
  parallel_for(parts.size(), jobs, [&](std::size_t i) {
    parts[i] = evidence(stretches[i], noise, extra.count, extra.of ? extra.of(i) : MoreColumns());
  });
  Evidence sum(theta.size());
  for (const Evidence& part : parts) sum += part;
  return sum;
}

Levels LevelProblem::minimize(const Levels& start, int most_iterations, Levels& unit) const {
  std::vector<double> x(free.size(), 0.0);
  LevelCost* const cost = new LevelCost(*this, start, unit);
  const ceres::GradientProblem problem(cost);  // takes the cost
  ceres::GradientProblemSolver::Options solver;
  solver.line_search_direction_type = ceres::BFGS;
  solver.max_num_iterations = most_iterations;
  solver.gradient_tolerance = 0.05;  // standard errors from the best level
  solver.function_tolerance = 1e-9;
  solver.logging_type = ceres::SILENT;
  ceres::GradientProblemSolver::Summary summary;
  ceres::Solve(solver, problem, x.data(), &summary);
  unit = cost->next_unit();
  return cost->levels(x.data());
}

double LevelProblem::gradient(const Levels& at) const {
  const std::vector<double> x(free.size(), 0.0);
  std::vector<double> slope(free.size());
  double value = 0.0;
  LevelCost(*this, at, Levels::Ones()).Evaluate(x.data(), &value, slope.data());
  double largest = 0.0;
  for (std::size_t i = 0; i < free.size(); ++i) {
    const double level = std::exp(at[free[i]]);
    const bool is_at_bound =
        (free[i] == kTauLevel && (level < 1.01 * like.least_tau_s || level > 0.99 * like.longest_tau_s)) ||
        (free[i] < 3 && level < 1.01 * like.least_sigma_w[free[i]]);
    if (!is_at_bound) largest = std::max(largest, std::abs(slope[i]));
  }
  return largest;
}

namespace {

// Standard errors of the levels from the curvature.
void judge_levels(const LevelProblem& problem, FittedNull& fit) {
  NullFit& report = fit.report;
  const Levels h = levels_of(fit.noise);
  constexpr double kWide = 0.2;
  std::vector<Levels> points{h};
  for (int i = 0; i < 3; ++i)
    for (const double sign : {1.0, -1.0}) points.push_back(h + sign * kWide * Levels::Unit(i));
  const std::vector<double> costs = problem.costs(points);
  for (int i = 0; i < 3; ++i) {
    const std::size_t up = 1 + 2 * static_cast<std::size_t>(i);
    const double curvature = (costs[up] + costs[up + 1] - 2.0 * costs[0]) / (kWide * kWide);
    report.sigma_w_sd[i] = fit.noise.sigma_w[i] / std::sqrt(std::max(curvature, 0.1));
  }
  report.noise_gradient = problem.gradient(h);
}

// What is told of a fit: smoothed paths, shifts, and where asked for how well the noise levels are known.
void finish(const Campaign& campaign, const Climb& climb, std::size_t jobs, bool judges_levels, FittedNull& fit) {
  const Eigen::Index p = fit.theta.size();
  parallel_for(fit.stretches.size(), jobs,
               [&](std::size_t s) { fit.smoothed[s] = smooth(fit.stretches[s], fit.noise, Eigen::VectorXd::Zero(p)); });

  NullFit& report = fit.report;
  if (judges_levels) judge_levels(climb.levels(), fit);
  report.sigma_w = fit.noise.sigma_w;
  report.is_noise_free =
      (fit.noise.measurement_sd.array() <= 1.01 * fit.noise.least_measurement_sd.array()).tail<3>().all();
  report.tau_s = fit.noise.tau_s;
  if (campaign.has_wind) report.wind_share = fit.noise.wind_share;
  report.typical = typical_acceleration(fit.stretches);
  report.step_s = campaign.step_s;
  report.samples = fit.total.measurements;
  report.log_likelihood = marginal(fit.total, fit.theta, fit.prior_sd);
  report.log_likelihood_per_sample =
      report.log_likelihood / static_cast<double>(std::max<std::size_t>(1, report.samples));
  constexpr const char* kNames[] = {"x0_m", "y0_m", "psi_deg", "u_mps", "vm_mps", "r_degps"};
  for (int i = 0; i < kShipStates; ++i) {
    const bool measured =
        std::any_of(campaign.stretches.begin(), campaign.stretches.end(), [&](const Stretch& stretch) {
          return std::any_of(stretch.measured.begin(), stretch.measured.end(),
                             [&](const Vec6& y) { return !std::isnan(y[i]); });
        });
    if (measured)
      report.noise.push_back(
          {kNames[i], fit.noise.measurement_sd[i] * (i == 2 || i == 5 ? 1.0 / kDegree : 1.0), kMissing});
  }
  Eigen::MatrixXd M = fit.total.F;
  M.diagonal() += fit.prior_sd.array().square().inverse().matrix();
  const Eigen::MatrixXd covariance = M.llt().solve(Eigen::MatrixXd::Identity(p, p));
  for (Eigen::Index i = 0; i + 1 + fit.effects < p; ++i) {
    const double factor = std::exp(fit.theta[i]), sd = std::sqrt(covariance(i, i));
    const UncertainParameter& parameter = fit.parameters[static_cast<std::size_t>(i)];
    report.parameters.push_back(
        {parameter.name, factor, factor * sd, parameter.log_sd, fit.theta[i] / parameter.log_sd});
  }
  report.actuator_lag = {"actuator_lag", kTimingShare * fit.theta[p - 1],
                         kTimingShare * std::sqrt(covariance(p - 1, p - 1))};
}

// To what is tolerated by way of what is stated.
void fit_from_stated(Climb& climb, const FitOptions& options, FittedNull& fit) {
  fit.prior_sd = climb.prior(&UncertainParameter::log_sd);
  const bool rests_as_stated = climb.to_rest(options.most_iterations, Judged::all);
  const NullFit as_stated = fit.report;
  const Eigen::VectorXd theta = fit.theta;
  const Noise noise = fit.noise;
  std::vector<std::vector<StateVector>> paths;
  for (const LinearStretch& stretch : fit.stretches) paths.push_back(stretch.path);
  // From there to what is tolerated: twice as wide, where data that fit badly can lead anywhere. Then the parameters
  // stay where the stated uncertainty holds them, and only the tests know what is tolerated.
  fit.prior_sd = climb.prior(&UncertainParameter::tolerated_sd);
  fit.report.converged = climb.to_rest(options.most_iterations / 2, Judged::nothing);
  if (!fit.report.converged) {
    const int iterations = fit.report.iterations;
    fit.report = as_stated;
    fit.report.iterations = iterations;
    fit.report.converged = rests_as_stated;
    fit.theta = theta;
    fit.noise = noise;
    for (std::size_t s = 0; s < paths.size(); ++s) fit.stretches[s].path = std::move(paths[s]);
    climb.linearize_all(fit.stretches);
  }
}

}  // namespace

FittedNull fit_null(Campaign& campaign, const FitOptions& options, const FittedNull* near_by) {
  FittedNull fit;
  if (campaign.ensemble)
    fit.parameters = {timing_parameter()};  // what the ensemble may err by is its members' spread
  else
    fit.parameters = uncertain_parameters(campaign.ship);
  const auto p = static_cast<Eigen::Index>(fit.parameters.size());
  fit.theta = Eigen::VectorXd::Zero(p);
  fit.noise = first_noise(campaign);
  // Weak knowledge that keeps levels finite where the recordings say nothing. Model errors of model ships are around
  // 5e-4 m/s^2, and accelerations are the same at any scale; within a factor of 20.
  fit.level_prior_mean = levels_of(fit.noise);
  fit.level_prior_mean.head<3>().setConstant(std::log(5e-4));
  fit.level_prior_mean[2] -= std::log(0.25 * campaign.ship.particulars.L_pp);
  fit.level_prior_sd.setConstant(3.0);
  fit.level_prior_sd[kTauLevel] = 0.5;
  fit.level_prior_sd[kWindLevel] = 1.0;
  if (near_by) {
    fit.theta = near_by->theta;
    fit.noise = near_by->noise;
  }

  const Hypothesis nothing;
  Climb climb(campaign, fit, nothing, options, true);
  if (near_by) {
    fit.prior_sd = climb.prior(&UncertainParameter::tolerated_sd);
    fit.report.converged = climb.to_rest(options.most_iterations / 2, Judged::all);
  }
  if (!fit.report.converged) fit_from_stated(climb, options, fit);
  finish(campaign, climb, options.jobs, true, fit);
  return fit;
}

FittedNull fit_with(Campaign& campaign, const FittedNull& from, const Hypothesis& hypothesis,
                    const Eigen::VectorXd& theta0, const FitOptions& options) {
  FittedNull fit = from;
  const Eigen::Index effects = hypothesis.size(), coefficients = from.theta.size() - 1 - from.effects;
  fit.effects = effects;
  fit.theta = theta0;
  fit.prior_sd.resize(fit.theta.size());
  fit.prior_sd << from.prior_sd.head(coefficients), Eigen::VectorXd::Ones(effects), from.prior_sd.tail(1);
  fit.parameters.erase(fit.parameters.begin() + coefficients, fit.parameters.end() - 1);
  for (const FreeEffect& effect : hypothesis.effects)
    for (Eigen::Index i = 0; i < effect.size(); ++i)
      fit.parameters.insert(fit.parameters.end() - 1, {fmt::format("{}.z{}", effect.name(), i + 1), 1.0, 1.0});
  fit.report = NullFit();
  fit.report.outliers = from.report.outliers;
  Climb climb(campaign, fit, hypothesis, options, false);
  fit.report.converged = climb.to_rest(options.most_iterations, Judged::events);
  finish(campaign, climb, options.jobs, false, fit);
  climb.restore_inputs();
  return fit;
}

FittedNull follow(Campaign& campaign, const FittedNull& fit, const Hypothesis& hypothesis, std::size_t jobs) {
  FittedNull result = fit;
  result.stretches.clear();
  result.smoothed.clear();
  result.event_scale.clear();
  FitOptions options;
  options.jobs = jobs;
  Climb climb(campaign, result, hypothesis, options, false);
  climb.linearize_all(result.stretches);  // along the measurements
  climb.linearize_all(result.stretches);
  const Eigen::VectorXd there = Eigen::VectorXd::Zero(fit.theta.size());
  parallel_for(result.stretches.size(), jobs,
               [&](std::size_t s) { result.smoothed[s] = smooth(result.stretches[s], result.noise, there); });
  climb.restore_inputs();
  return result;
}

double log_evidence(const FittedNull& fit) {
  const Levels off = (levels_of(fit.noise) - fit.level_prior_mean).cwiseQuotient(fit.level_prior_sd);
  return marginal(fit.total, fit.theta, fit.prior_sd) - 0.5 * off.squaredNorm() + fit.log_prior_of_events;
}

Coordinates coordinates_of(const FittedNull& fit) {
  const Eigen::Index effects = fit.effects, first = fit.theta.size() - 1 - effects;
  Eigen::MatrixXd M = fit.total.F;
  M.diagonal() += fit.prior_sd.array().square().inverse().matrix();
  const Eigen::MatrixXd covariance = M.llt().solve(Eigen::MatrixXd::Identity(M.rows(), M.cols()));
  return {fit.theta.segment(first, effects), covariance.block(first, first, effects, effects)};
}

}  // namespace leeway::gap
