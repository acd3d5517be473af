#include "gap/fit/levels.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/linear_algebra.hpp"
#include "core/parallel.hpp"
#include "gap/filter/noise_slope.hpp"
#include "gap/fit/minimizer.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {
namespace {

// A LevelProblem as the minimizer sees it: steps of the free levels from `at`, in coordinates in which the curvature is
// about 1, since BFGS begins with the unit matrix. Each slope tells more about the curvature (the update of BFGS).
class LevelCost {
 public:
  ///   cost, slope  at `at`
  LevelCost(const LevelProblem& problem, const Levels& at, const LevelCurvature& curvature, double cost,
            const Levels& slope)
      : problem_(problem),
        at_(at),
        curvature_(curvature),
        count_(static_cast<Eigen::Index>(problem.free.size())),
        last_(at),
        last_slope_(slope),
        last_cost_(cost) {
    const Eigen::MatrixXd of_free = curvature(problem.free, problem.free);
    root_ = Eigen::LLT<Eigen::MatrixXd>(of_free).matrixU().solve(Eigen::MatrixXd::Identity(count_, count_));
  }

  Levels levels(const double* parameters) const {
    Levels h = at_;
    h(problem_.free) += root_ * Eigen::Map<const Eigen::VectorXd>(parameters, count_);
    return h;
  }
  /// As known after the last slope.
  const LevelCurvature& curvature() const { return curvature_; }

  bool evaluate(const double* parameters, double* cost, double* gradient) const {
    const Levels h = levels(parameters);
    if (!h.allFinite() || (h - at_).cwiseAbs().maxCoeff() > kPolicy.fit.level_reach) return false;
    if (gradient == nullptr) {
      *cost = problem_.costs({h}).front();
      return std::isfinite(*cost);
    }
    if (h != last_) {
      Levels slope;
      last_cost_ = problem_.cost(h, slope);
      if (!std::isfinite(last_cost_) || !slope.allFinite()) return false;
      learn(h, slope);
      last_ = h;
      last_slope_ = slope;
    }
    *cost = last_cost_;
    Eigen::Map<Eigen::VectorXd>(gradient, count_) = root_.transpose() * last_slope_(problem_.free);
    return true;
  }

 private:
  void learn(const Levels& h, const Levels& slope) const {
    Levels change = Levels::Zero();
    change(problem_.free) = (slope - last_slope_)(problem_.free);
    const Levels step = h - last_;
    const double along = step.dot(change);
    if (along <= 0.0 || change.squaredNorm() > kPolicy.fit.most_level_curvature * along) return;
    const Levels expected = curvature_ * step;
    curvature_ += change * change.transpose() / along - expected * expected.transpose() / step.dot(expected);
  }

  const LevelProblem& problem_;
  const Levels at_;
  mutable LevelCurvature curvature_;
  const Eigen::Index count_;
  Eigen::MatrixXd root_;  // of the inverse curvature, among the free levels
  mutable Levels last_, last_slope_;
  mutable double last_cost_;
};

// Places of stretches with about `most_points` points that stand for all; of all where they have fewer.
std::vector<std::size_t> sample_of(const std::vector<LinearStretch>& stretches, std::size_t most_points) {
  std::size_t points = 0;
  for (const LinearStretch& stretch : stretches) points += stretch.path.size();
  const std::size_t every = std::max<std::size_t>(1, points / most_points);
  std::vector<std::size_t> sample;
  for (std::size_t s = 0; s < stretches.size(); s += every) sample.push_back(s);
  return sample;
}

// The step of theta that an evidence around theta and the prior ask for: Gaussian, of this precision, with its mean
// where precision * mean = slope.
struct Posterior {
  Eigen::LLT<Eigen::MatrixXd> precision;
  Eigen::VectorXd slope;
};
Posterior posterior_of(const Evidence& evidence, const Eigen::VectorXd& theta, const ThetaPrior& prior) {
  return {Eigen::LLT<Eigen::MatrixXd>(evidence.F + prior.precision()), evidence.b - prior.pull(theta)};
}

}  // namespace

std::vector<int> free_levels(bool of_sensors, bool of_wind, bool one_receiver) {
  std::vector<int> free;
  free.reserve(kLevels);
  for (int level = 0; level <= (of_sensors ? kWindLevel - 1 : kTauLevel); ++level) free.push_back(level);
  if (of_wind) free.push_back(kWindLevel);
  if (of_sensors && one_receiver)
    for (const int level : {kReceiverLevel, kReceiverLevel + 1}) free.push_back(level);
  return free;
}

double marginal(const Evidence& evidence, const Eigen::VectorXd& theta, const ThetaPrior& prior) {
  const Posterior step = posterior_of(evidence, theta, prior);
  const double log_det = 2.0 * step.precision.matrixLLT().diagonal().array().log().sum();
  return evidence.log_likelihood + prior.log_density(theta) + 0.5 * step.slope.dot(step.precision.solve(step.slope)) -
         0.5 * log_det;
}

Levels levels_of(const Noise& noise) {
  Levels h;
  h << noise.sigma_w, noise.tau_s, noise.measurement_sd[0], noise.measurement_sd.tail<4>(), noise.wind_share,
      noise.receiver_sd, noise.receiver_tau_s;
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
  noise.receiver_sd = x[kReceiverLevel];
  // Slower is a force that has a cause, as faster errors of the ship are noise of the sensors.
  noise.receiver_tau_s = std::min(x[kReceiverLevel + 1], like.least_tau_s);
  return noise;
}

namespace {

// Beyond these the noise stays what it is there.
struct Bounds {
  Levels low, high;
};
Bounds bounds_of(const Noise& like) {
  Bounds bounds{Levels::Constant(-std::numeric_limits<double>::infinity()),
                Levels::Constant(std::numeric_limits<double>::infinity())};
  bounds.low.head<3>() = like.least_sigma_w.array().log();
  bounds.low[kTauLevel] = std::log(like.least_tau_s);
  bounds.high[kTauLevel] = std::log(like.longest_tau_s);
  // Positions have one level; none is below its bound where both are.
  bounds.low[kTauLevel + 1] = std::log(like.least_measurement_sd.head<2>().minCoeff());
  bounds.low.segment<4>(kTauLevel + 2) = like.least_measurement_sd.tail<4>().array().log();
  bounds.high[kReceiverLevel + 1] = std::log(like.least_tau_s);
  return bounds;
}

Levels by_levels(const NoiseSlope& slope) {
  Levels result;
  result << slope.sigma_w, slope.tau, slope.measurement_sd.head<2>().sum(), slope.measurement_sd.tail<4>(),
      slope.wind_share, slope.receiver_sd, slope.receiver_tau;
  return result;
}

// The free levels that the slope of the cost does not hold at a bound.
std::vector<int> within_bounds(const LevelProblem& problem, const Levels& at, const Levels& slope) {
  const Bounds bounds = bounds_of(problem.like);
  std::vector<int> result;
  for (const int i : problem.free)
    if ((at[i] > bounds.low[i] + kPolicy.fit.at_bound || slope[i] < 0.0) &&
        (at[i] < bounds.high[i] - kPolicy.fit.at_bound || slope[i] > 0.0))
      result.push_back(i);
  return result;
}

}  // namespace

double LevelProblem::cost(const Levels& at, Levels& slope) const {
  const std::vector<std::size_t> sample = sample_of(stretches, most_points);
  const Noise noise = noise_of(at, like);
  std::vector<Evidence> parts(sample.size());
  std::vector<Passage> passages(sample.size());
  parallel_for(sample.size(), jobs, [&](std::size_t i) {
    parts[i] =
        evidence(stretches[sample[i]], noise, extra.count, extra.of ? extra.of(sample[i]) : MoreColumns(), passages[i]);
  });
  Evidence total(theta.size());
  for (const Evidence& part : parts) total += part;

  const Posterior step = posterior_of(total, theta, prior);
  const Eigen::VectorXd mean = step.precision.solve(step.slope);
  const Eigen::MatrixXd root = step.precision.matrixU().solve(Eigen::MatrixXd::Identity(mean.size(), mean.size()));
  std::vector<NoiseSlope> slopes(sample.size());
  parallel_for(sample.size(), jobs,
               [&](std::size_t i) { slopes[i] = noise_slope(stretches[sample[i]], noise, passages[i], mean, root); });
  NoiseSlope sum;
  for (const NoiseSlope& part : slopes) sum += part;
  const Levels off = (at - prior_mean).cwiseQuotient(prior_sd_of_levels);
  slope.setZero();
  const Bounds bounds = bounds_of(like);
  const Levels data = by_levels(sum);
  for (const int i : free) {
    const bool is_beyond =
        at[i] < bounds.low[i] - kPolicy.fit.at_bound || at[i] > bounds.high[i] + kPolicy.fit.at_bound;
    slope[i] = off[i] / prior_sd_of_levels[i] - (is_beyond ? 0.0 : data[i]);
  }
  return -marginal(total, theta, prior) + 0.5 * off.squaredNorm();
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
    costs.push_back(-marginal(total, theta, prior) +
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

Levels LevelProblem::minimize(const Levels& start, int most_iterations, LevelCurvature& curvature) const {
  Levels slope;
  const double at_start = cost(start, slope);
  LevelProblem problem = *this;
  problem.free = within_bounds(*this, start, slope);
  if (problem.free.empty() || !std::isfinite(at_start) || !slope.allFinite()) return start;
  std::vector<double> x(problem.free.size(), 0.0);
  const LevelCost cost(problem, start, curvature, at_start, slope);
  leeway::gap::minimize([&](const double* parameters, double* value,
                            double* gradient) { return cost.evaluate(parameters, value, gradient); },
                        x, {most_iterations, kPolicy.fit.level_gradient, kPolicy.fit.level_gain});
  curvature = cost.curvature();
  return cost.levels(x.data());
}

double LevelProblem::gradient(const Levels& at) const {
  Levels slope;
  cost(at, slope);
  double largest = 0.0;
  for (const int i : within_bounds(*this, at, slope)) largest = std::max(largest, std::abs(slope[i]));
  return largest;
}

}  // namespace leeway::gap
