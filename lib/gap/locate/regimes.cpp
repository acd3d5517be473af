#include "gap/locate/regimes.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/distributions.hpp"
#include "core/units.hpp"
#include "gap/filter/reference_units.hpp"
#include "gap/locate/regime_variables.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {
namespace {

// A variable with its mean and spread over all steps, so that its functions are about centered.
struct Centered {
  RegimeVariable variable;
  double mean = 0.0, spread = 0.0;

  bool varies() const {
    return spread > kPolicy.locate.least_relative_spread * (std::abs(mean) + kPolicy.locate.least_mean);
  }
  double odd(const Moment& at) const {
    return variable.is_angle ? std::cos(variable.value(at)) : (variable.value(at) - mean) / spread;
  }
  double even(const Moment& at) const {
    if (variable.is_angle) return std::sin(variable.value(at));
    const double x = (variable.value(at) - mean) / spread;
    return x * x - 1.0;
  }
};

std::vector<Centered> centered_variables(const Campaign& campaign, const FittedNull& fit) {
  std::vector<Centered> variables;
  for (RegimeVariable& variable : regime_variables(campaign)) variables.push_back({std::move(variable)});
  double n = 0.0;
  for (const LinearStretch& stretch : fit.stretches)
    for (std::size_t k = 0; k < stretch.steps.size(); ++k, n += 1.0) {
      const Moment at = moment_of(stretch, k);
      for (Centered& one : variables) {
        const double x = one.variable.value(at);
        one.mean += x;
        one.spread += x * x;
      }
    }
  for (Centered& one : variables) {
    one.mean /= n;
    one.spread = std::sqrt(std::max(one.spread / n - one.mean * one.mean, 0.0));
  }
  return variables;
}

// One variable on one axis: columns `first` and the next, odd and even.
struct RegimeTest {
  const Centered* of;
  int axis;
  Eigen::Index first;
};

// What relation holds, to a person.
//   beta   strengths of the odd and the even column, in reference accelerations
//   scale  of these columns
void describe(Regime& regime, const Centered& of, const Eigen::Vector2d& b, const Eigen::Matrix2d& F,
              const Eigen::Vector2d& beta, const Eigen::Vector2d& scale) {
  const RegimeVariable& variable = of.variable;
  const double linear = F(0, 0) > 0.0 ? b[0] * b[0] / F(0, 0) : 0.0;
  const double quadratic = F(1, 1) > 0.0 ? b[1] * b[1] / F(1, 1) : 0.0;
  const char* const axis_name = kAxisNames[static_cast<std::size_t>(regime.axis)];
  const double percent = 100.0 * regime.share;
  if (variable.is_angle) {
    regime.relation = "harmonic";
    double largest_deg = std::atan2(beta[1] * scale[1], beta[0] * scale[0]) / kDegree;
    if (largest_deg < 0.0) largest_deg += 360.0;
    regime.sentence = fmt::format("what is missing in {} turns with the {}, largest at {:.0f} deg ({:.0f} % of it)",
                                  axis_name, variable.words, largest_deg, percent);
  } else if (linear >= quadratic) {
    regime.relation = "linear";
    regime.sentence = fmt::format("what is missing in {} {} with the {} ({:.0f} % of it)", axis_name,
                                  beta[0] > 0.0 ? "grows" : "falls", variable.words, percent);
  } else {
    regime.relation = "quadratic";
    regime.sentence =
        fmt::format("what is missing in {} is {} where the {} is far from {:.2g}{} ({:.0f} % of it)", axis_name,
                    beta[1] > 0.0 ? "larger" : "smaller", variable.words, of.mean * variable.per_unit,
                    variable.unit.empty() ? "" : " " + variable.unit, percent);
  }
}

// Binned means of the residual over a variable.
void bin(Regime& regime, const Campaign& campaign, const FittedNull& fit, const RegimeVariable& variable,
         const std::vector<Eigen::Matrix3Xd>& residual) {
  std::vector<std::pair<double, double>> points;
  const double unit = reference_acceleration(campaign.ship)[regime.axis];
  for (std::size_t s = 0; s < residual.size(); ++s)
    for (Eigen::Index k = 0; k < residual[s].cols(); ++k)
      points.push_back({variable.value(moment_of(fit.stretches[s], static_cast<std::size_t>(k))) * variable.per_unit,
                        residual[s](regime.axis, k) * unit});
  std::sort(points.begin(), points.end());
  constexpr std::size_t kBins = kPolicy.locate.bins;
  // Neighbors in time say nearly the same.
  const double per_independent = std::max(1.0, kPolicy.locate.taus_per_independent * fit.noise.tau_s / campaign.step_s);
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

// Keeps those that hold (Benjamini & Hochberg 1995), most certain first.
void control_false_discoveries(std::vector<Regime>& regimes, double false_discovery) {
  std::sort(regimes.begin(), regimes.end(), [](const Regime& a, const Regime& b) { return a.p_value < b.p_value; });
  const auto count = static_cast<double>(regimes.size());
  double q = 1.0;
  for (std::size_t i = regimes.size(); i-- > 0;) {
    q = std::min(q, regimes[i].p_value * count / static_cast<double>(i + 1));
    regimes[i].q_value = q;
  }
  std::erase_if(regimes, [&](const Regime& r) { return r.q_value > false_discovery; });
}

}  // namespace

std::vector<Regime> regimes_of(const Campaign& campaign, const FittedNull& fit,
                               const std::vector<Eigen::Matrix3Xd>& residual, const LocateOptions& options) {
  const std::vector<Centered> variables = centered_variables(campaign, fit);
  std::vector<Pattern> patterns;
  std::vector<RegimeTest> tests;
  for (const Centered& of : variables) {
    if (!of.varies()) continue;
    for (int axis = of.variable.first_axis; axis <= of.variable.last_axis; ++axis) {
      tests.push_back({&of, axis, static_cast<Eigen::Index>(patterns.size())});
      patterns.push_back(
          [&of, axis](const Moment& at) -> Vec3<double> { return Vec3<double>::Unit(axis) * of.odd(at); });
      patterns.push_back(
          [&of, axis](const Moment& at) -> Vec3<double> { return Vec3<double>::Unit(axis) * of.even(at); });
    }
  }
  const PatternEvidence evidence = pattern_evidence(campaign, fit, patterns, options.jobs);
  std::vector<Regime> regimes;
  for (const RegimeTest& test : tests) {
    const Eigen::VectorXd b = evidence.projected.b.segment<2>(test.first);
    const Eigen::MatrixXd F = evidence.projected.F.block<2, 2>(test.first, test.first);
    const ScoreTest score = score_test(b, F);
    if (score.rank == 0) continue;
    Regime regime;
    regime.variable = test.of->variable.name;
    regime.axis = test.axis;
    regime.x_label = test.of->variable.label();
    regime.p_value = chi_squared_survival(score.statistic, score.rank);
    regime.share = share_of(evidence, residual, test.first, 2, test.axis);
    describe(regime, *test.of, b, F, score.beta, evidence.scale.segment<2>(test.first));
    regimes.push_back(std::move(regime));
  }
  control_false_discoveries(regimes, options.false_discovery);
  for (Regime& regime : regimes)
    for (const auto& [variable, mean, spread] : variables)
      if (variable.name == regime.variable && regime.axis >= variable.first_axis && regime.axis <= variable.last_axis)
        bin(regime, campaign, fit, variable, residual);
  return regimes;
}

}  // namespace leeway::gap
