#include "gap/fit/levels.hpp"

#include <algorithm>
#include <cmath>

#include "core/linear_algebra.hpp"
#include "core/parallel.hpp"
#include "gap/fit/minimizer.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {
namespace {

// A LevelProblem as the minimizer sees it: steps of the free levels from `at`, in units in which the curvature is about
// 1, since BFGS begins with the unit matrix.
class LevelCost {
 public:
  LevelCost(const LevelProblem& problem, const Levels& at, const Levels& unit)
      : problem_(problem), at_(at), unit_(unit) {}

  Levels levels(const double* parameters) const {
    Levels h = at_;
    for (std::size_t i = 0; i < problem_.free.size(); ++i)
      h[problem_.free[i]] += unit_[problem_.free[i]] * parameters[i];
    return h;
  }
  /// The units that the curvature at the last point suggests.
  const Levels& next_unit() const { return next_unit_; }

  bool evaluate(const double* parameters, double* cost, double* gradient) const {
    const Levels h = levels(parameters);
    if (!h.allFinite() || (h - at_).cwiseAbs().maxCoeff() > kPolicy.fit.level_reach) return false;
    std::vector<Levels> points{h};
    if (gradient != nullptr)
      for (const int i : problem_.free)
        for (const double sign : {1.0, -1.0})
          points.push_back(h + sign * kPolicy.fit.level_difference * Levels::Unit(i));
    const std::vector<double> costs = problem_.costs(points);
    if (!std::all_of(costs.begin(), costs.end(), [](double c) { return std::isfinite(c); })) return false;
    *cost = costs[0];
    if (gradient != nullptr)
      for (std::size_t i = 0; i < problem_.free.size(); ++i) {
        const int level = problem_.free[i];
        gradient[i] = unit_[level] * (costs[1 + 2 * i] - costs[2 + 2 * i]) / (2.0 * kPolicy.fit.level_difference);
        const double curvature = (costs[1 + 2 * i] + costs[2 + 2 * i] - 2.0 * costs[0]) /
                                 (kPolicy.fit.level_difference * kPolicy.fit.level_difference);
        next_unit_[level] = 1.0 / std::sqrt(std::clamp(curvature, 1.0, kPolicy.fit.most_level_curvature));
      }
    return true;
  }

 private:
  const LevelProblem& problem_;
  const Levels at_, unit_;
  mutable Levels next_unit_ = Levels::Ones();
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
  const LevelCost cost(*this, start, unit);
  leeway::gap::minimize([&](const double* parameters, double* value,
                            double* gradient) { return cost.evaluate(parameters, value, gradient); },
                        x, {most_iterations, kPolicy.fit.level_gradient, kPolicy.fit.level_gain});
  unit = cost.next_unit();
  return cost.levels(x.data());
}

double LevelProblem::gradient(const Levels& at) const {
  const std::vector<double> x(free.size(), 0.0);
  std::vector<double> slope(free.size());
  double value = 0.0;
  LevelCost(*this, at, Levels::Ones()).evaluate(x.data(), &value, slope.data());
  double largest = 0.0;
  constexpr double above = 1.0 + kPolicy.fit.at_bound, below = 1.0 - kPolicy.fit.at_bound;
  for (std::size_t i = 0; i < free.size(); ++i) {
    const double level = std::exp(at[free[i]]);
    const bool is_at_bound =
        (free[i] == kTauLevel && (level < above * like.least_tau_s || level > below * like.longest_tau_s)) ||
        (free[i] < 3 && level < above * like.least_sigma_w[free[i]]);
    if (!is_at_bound) largest = std::max(largest, std::abs(slope[i]));
  }
  return largest;
}

}  // namespace leeway::gap
