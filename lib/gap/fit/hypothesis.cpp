#include "gap/fit/hypothesis.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/distributions.hpp"
#include "core/errors.hpp"
#include "core/linear_algebra.hpp"
#include "core/random.hpp"
#include "core/statistics.hpp"
#include "core/units.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {
namespace {

constexpr double kDirectionUnit_deg = 143.61952130254163;  // 360/sqrt(2 pi)

double in_circle_deg(double angle_deg) {
  const double turned = std::fmod(angle_deg, 360.0);
  return turned < 0.0 ? turned + 360.0 : turned;
}

// Angles about another, so that 359 and 1 deg are neighbors.
void turn_near(double angle_deg, std::vector<double>& angles_deg) {
  for (double& angle : angles_deg) angle = angle_deg + std::remainder(angle - angle_deg, 360.0);
}

// A value of a normal or log-normal prior from its median, in its sd.
double standard(const Prior& prior, double value) {
  return (prior.kind == Prior::Kind::log_normal ? std::log(value / prior.median) : value - prior.median) / prior.sd;
}

double bounded(const Prior& prior, double z) {
  const double x = within_bounds(z, standard(prior, prior.low), standard(prior, prior.high));
  return std::clamp(
      prior.kind == Prior::Kind::log_normal ? prior.median * std::exp(prior.sd * x) : prior.median + prior.sd * x,
      prior.low, prior.high);
}

// The length of a vector, at most the prior's.
double bounded_length(const Prior& prior, double components) {
  const double most = prior.high / prior.sd, share_below = -std::expm1(-0.5 * most * most);
  const double length = std::sqrt(-2.0 * std::log1p(share_below * std::expm1(-0.5 * components * components)));
  return std::min(prior.sd * length, prior.high);
}

}  // namespace

FreeEffect::FreeEffect(std::string_view name, const Ship& ship, const Choice& choice)
    : name_(name), recording_(choice.recording), log_ways_(choice.log_ways), towards_deg_(choice.towards_deg) {
  parameters_ = effect_named(name).parameters;
  type_ = *find_effect(name);
  const auto prior = [&](const EffectParameter& p) {
    const auto other = choice.priors.find(std::string(p.name));
    if (other != choice.priors.end()) return other->second;
    const Prior stated = p.prior(ship.particulars.L_pp);
    if (stated.kind != Prior::Kind::log_normal || p.off != 1.0) return stated;
    return log_normal(stated.median, std::max(stated.sd, kPolicy.fit.factor_log_sd),
                      std::max(p.low, kPolicy.fit.least_factor), stated.high);
  };
  base_sd_.resize(parameters_.size());
  for (std::size_t i = 0; i < parameters_.size(); ++i) {
    const EffectParameter& p = parameters_[i];
    const auto fixed = choice.fixed.find(std::string(p.name));
    if (fixed != choice.fixed.end())
      base_.push_back(fixed->second);
    else
      base_.push_back(std::isfinite(p.otherwise) ? p.otherwise : std::isfinite(p.off) ? p.off : prior(p).median);
    if (is_direction(prior(p)) && fixed == choice.fixed.end()) direction_ = i;
  }
  for (std::size_t i = 0; i < parameters_.size(); ++i) {
    const EffectParameter& p = parameters_[i];
    const bool is_free = std::isfinite(p.off) || std::isnan(p.otherwise) ||
                         std::find(choice.freed.begin(), choice.freed.end(), p.name) != choice.freed.end();
    if (direction_ == i || !is_free || choice.fixed.contains(std::string(p.name))) continue;
    coordinates_.push_back({i, prior(p)});
  }
  const bool has_vector =
      std::any_of(coordinates_.begin(), coordinates_.end(), [](const Coordinate& c) { return c.is_vector(); });
  if (direction_ && !has_vector) coordinates_.push_back({*direction_, prior(parameters_[*direction_])});
  // Strengths that this ship does not have (one rudder of two) stay as they are.
  std::erase_if(coordinates_, [&](const Coordinate& c) {
    if (is_direction(c.prior)) return false;
    std::vector<double> moved = base_;
    moved[c.parameter] = c.prior.median;
    try {
      require_applicable(type_, moved, ship);
      return false;
    } catch (const EffectNotApplicable&) {
      return coordinates_.size() > 1;
    }
  });
  const std::vector<double> at_median = values(Eigen::VectorXd::Zero(size()));
  require_applicable(type_, at_median, ship);
}

std::size_t FreeEffect::place_of(std::string_view parameter) const {
  return static_cast<std::size_t>(std::ranges::find(parameters_, parameter, &EffectParameter::name) -
                                  parameters_.begin());
}

void FreeEffect::fix(std::string_view parameter, double value) { base_[place_of(parameter)] = value; }
void FreeEffect::shift(std::string_view parameter, double by) { base_[place_of(parameter)] += by; }
void FreeEffect::know(std::string_view parameter, double sd) { base_sd_[place_of(parameter)] = sd; }
double FreeEffect::known_sd(std::string_view parameter) const { return base_sd_[place_of(parameter)]; }

void FreeEffect::count_from(double towards_deg, Eigen::VectorXd& z) {
  Eigen::Index at = 0;
  for (const Coordinate& c : coordinates_) {
    if (is_direction(c.prior)) z[at] += std::remainder(towards_deg_ - towards_deg, 360.0) / kDirectionUnit_deg;
    at += c.is_vector() ? 2 : 1;
  }
  towards_deg_ = towards_deg;
}

Eigen::Index FreeEffect::size() const {
  Eigen::Index n = 0;
  for (const Coordinate& c : coordinates_) n += c.is_vector() ? 2 : 1;
  return n;
}

bool FreeEffect::has_bare_direction() const {
  return std::any_of(coordinates_.begin(), coordinates_.end(),
                     [](const Coordinate& c) { return is_direction(c.prior); });
}

std::vector<Eigen::Index> FreeEffect::log_strengths() const {
  std::vector<Eigen::Index> places;
  Eigen::Index at = 0;
  for (const Coordinate& c : coordinates_) {
    if (c.prior.kind == Prior::Kind::log_normal && parameters_[c.parameter].off == 0.0) places.push_back(at);
    at += c.is_vector() ? 2 : 1;
  }
  return places;
}

std::vector<Eigen::Index> FreeEffect::beside_vector() const {
  std::vector<Eigen::Index> places;
  if (!direction_ || std::isnan(parameters_[*direction_].otherwise)) return places;
  Eigen::Index at = 0;
  for (const Coordinate& c : coordinates_) {
    if (!c.is_vector()) places.push_back(at);
    at += c.is_vector() ? 2 : 1;
  }
  return places;
}

std::optional<Eigen::VectorXd> FreeEffect::neutral() const {
  Eigen::VectorXd z = Eigen::VectorXd::Zero(size());
  Eigen::Index at = 0;
  for (const Coordinate& c : coordinates_) {
    const double off = parameters_[c.parameter].off;
    if (c.is_vector()) {
      at += 2;
      continue;
    }
    if (c.prior.kind != Prior::Kind::normal && c.prior.kind != Prior::Kind::log_normal) return std::nullopt;
    z[at] = without_bounds(standard(c.prior, off), standard(c.prior, c.prior.low), standard(c.prior, c.prior.high));
    if (!(std::abs(z[at]) < kPolicy.fit.farthest)) return std::nullopt;
    ++at;
  }
  return z;
}

double FreeEffect::value_of(const Coordinate& c, double z) const {
  if (is_direction(c.prior)) return in_circle_deg(towards_deg_ + kDirectionUnit_deg * z);
  switch (c.prior.kind) {
    case Prior::Kind::log_normal:
    case Prior::Kind::normal:
      return bounded(c.prior, z);
    case Prior::Kind::uniform:
      return c.prior.low + (c.prior.high - c.prior.low) * 0.5 * std::erfc(-z / std::sqrt(2.0));
    case Prior::Kind::rayleigh:
      break;
  }
  return 0.0;
}

std::vector<double> FreeEffect::values(const Eigen::Ref<const Eigen::VectorXd>& z) const {
  std::vector<double> result = base_;
  Eigen::Index at = 0;
  for (const Coordinate& c : coordinates_) {
    if (c.is_vector()) {
      result[c.parameter] = bounded_length(c.prior, std::hypot(z[at], z[at + 1]));
      result[*direction_] = in_circle_deg(std::atan2(z[at + 1], z[at]) / kDegree);
      at += 2;
    } else {
      result[c.parameter] = value_of(c, z[at++]);
    }
  }
  return result;
}

std::vector<double> FreeEffect::differences() const {
  std::vector<double> result;
  for (const Coordinate& c : coordinates_)
    result.insert(result.end(), c.is_vector() ? 2 : 1,
                  is_direction(c.prior) ? kPolicy.fit.direction_difference : kPolicy.fit.difference);
  return result;
}

EffectEntry FreeEffect::entry(const Eigen::Ref<const Eigen::VectorXd>& z) const {
  EffectEntry result{name_, {}, "ship.json", ""};
  const std::vector<double> all = values(z);
  for (std::size_t i = 0; i < all.size(); ++i) result.parameters.emplace_back(parameters_[i].name, all[i]);
  return result;
}

// As a straight step from z leads, in its unit or its logarithm.
double FreeEffect::value_beside(const Coordinate& c, double z, double step) const {
  if (is_direction(c.prior)) return value_of(c, z + step);
  const bool is_log = c.prior.kind == Prior::Kind::log_normal;
  const auto scale = [&](double at) { return is_log ? std::log(value_of(c, at)) : value_of(c, at); };
  const double h = kPolicy.fit.difference;
  const double there = scale(z) + step * (scale(z + h) - scale(z - h)) / (2.0 * h);
  return std::clamp(is_log ? std::exp(there) : there, c.prior.low, c.prior.high);
}

template <class ValuesAt>
std::vector<std::vector<double>> FreeEffect::draws(Eigen::Index size, const ValuesAt& values_at) const {
  RandomStream random(1, "effect parameters");
  std::vector<std::vector<double>> draws(parameters_.size());
  for (std::vector<double>& of : draws) of.reserve(kPolicy.fit.posterior_draws);
  Eigen::VectorXd standard(size);
  for (std::size_t d = 0; d < kPolicy.fit.posterior_draws; ++d) {
    for (Eigen::Index i = 0; i < size; ++i) standard[i] = random.normal();
    const std::vector<double> drawn = values_at(standard);
    for (std::size_t i = 0; i < drawn.size(); ++i) draws[i].push_back(drawn[i]);
  }
  return draws;
}

std::vector<FreeEffect::Parameter> FreeEffect::parameters(const Eigen::VectorXd& mean,
                                                          const Eigen::MatrixXd& covariance) const {
  // Quantiles of draws: a speed and a direction do not go straight with z.
  const Eigen::MatrixXd root = covariance.llt().matrixL();
  std::vector<std::vector<double>> drawn =
      draws(mean.size(), [&](const Eigen::VectorXd& standard) { return values(mean + root * standard); });
  const std::vector<double> best = values(mean);
  std::vector<Parameter> result;
  const auto add = [&](std::size_t i, const Prior& prior) {
    std::vector<double>& x = drawn[i];
    if (direction_ == i) turn_near(best[i], x);
    std::sort(x.begin(), x.end());
    double square = 0.0;
    for (const double value : x) square += (value - best[i]) * (value - best[i]);
    const double sd = std::sqrt(square / kPolicy.fit.posterior_draws);
    const auto is_near = [&](double bound) { return std::abs(best[i] - bound) < sd; };
    result.push_back({std::string(parameters_[i].name), best[i], sd, quantile(x, kPolicy.show.tail95),
                      quantile(x, 1.0 - kPolicy.show.tail95),
                      !is_direction(prior) && (is_near(prior.high) || (prior.low != 0.0 && is_near(prior.low)))});
  };
  for (const Coordinate& c : coordinates_) {
    add(c.parameter, c.prior);
    if (c.is_vector()) add(*direction_, kAnyDirection);
  }
  return result;
}

std::vector<FreeEffect::Interval> FreeEffect::intervals(const Eigen::VectorXd& best, const Eigen::VectorXd& step,
                                                        const Eigen::MatrixXd& covariance) const {
  const Eigen::MatrixXd root = covariance.llt().matrixL();
  std::vector<std::vector<double>> drawn = draws(best.size(), [&](const Eigen::VectorXd& standard) {
    const Eigen::VectorXd beside = step + root * standard;
    std::vector<double> result = values(best + beside);
    Eigen::Index at = 0;
    for (const Coordinate& c : coordinates_) {
      if (!c.is_vector()) result[c.parameter] = value_beside(c, best[at], beside[at]);
      at += c.is_vector() ? 2 : 1;
    }
    return result;
  });
  const std::vector<double> estimate = values(best);
  std::vector<Interval> result;
  const auto add = [&](std::size_t i) {
    std::vector<double>& x = drawn[i];
    if (direction_ == i) turn_near(estimate[i], x);
    std::sort(x.begin(), x.end());
    result.push_back({std::min(estimate[i], quantile(x, kPolicy.show.tail95)),
                      std::max(estimate[i], quantile(x, 1.0 - kPolicy.show.tail95))});
  };
  for (const Coordinate& c : coordinates_) {
    add(c.parameter);
    if (c.is_vector()) add(*direction_);
  }
  return result;
}

Eigen::VectorXd FreeEffect::sd_of_formula(const Eigen::VectorXd& z) const {
  const double share = effect_named(name_).info.formula_sd;
  Eigen::VectorXd sd = Eigen::VectorXd::Zero(size());
  if (share == 0.0) return sd;
  Eigen::Index at = 0;
  for (const Coordinate& c : coordinates_) {
    if (c.is_vector()) {
      sd.segment<2>(at).setConstant(share * z.segment<2>(at).norm());
      at += 2;
      continue;
    }
    if (is_direction(c.prior))
      sd[at] = share / kDegree / kDirectionUnit_deg;
    else if (c.prior.kind != Prior::Kind::uniform) {
      const double h = kPolicy.fit.difference;
      const double slope = (value_of(c, z[at] + h) - value_of(c, z[at] - h)) / (2.0 * h);
      sd[at] = std::min(share * std::abs(value_of(c, z[at])) / slope, 1.0);  // at a bound no wider than before
    }
    ++at;
  }
  return sd;
}

Eigen::Index Hypothesis::size() const {
  Eigen::Index n = 0;
  for (const FreeEffect& effect : effects) n += effect.size();
  return n;
}

std::string Hypothesis::name() const { return effects.empty() ? "none" : fmt::format("{}", fmt::join(names(), " + ")); }

std::vector<std::string> Hypothesis::names() const {
  std::vector<std::string> result;
  for (const FreeEffect& effect : effects)
    if (std::find(result.begin(), result.end(), effect.name()) == result.end()) result.push_back(effect.name());
  return result;
}

bool Hypothesis::differs() const {
  return std::any_of(effects.begin(), effects.end(), [](const FreeEffect& e) { return e.recording().has_value(); });
}

Ship Hypothesis::applied_to(const Ship& ship, const Eigen::VectorXd& z, std::size_t recording) const {
  Ship result = ship;
  Eigen::Index at = 0;
  for (const FreeEffect& effect : effects) {
    if (effect.recording().value_or(recording) == recording)
      result.effects.push_back(effect.entry(z.segment(at, effect.size())));
    at += effect.size();
  }
  return result;
}

Ship Hypothesis::applied_to(const Ship& ship, const Eigen::VectorXd& z) const {
  Ship result = ship;
  Eigen::Index at = 0;
  for (std::size_t i = 0; i < effects.size();) {
    const FreeEffect& effect = effects[i];
    Eigen::VectorXd mean = z.segment(at, effect.size());
    double n = 1.0;
    at += effect.size();
    for (++i; effect.recording() && i < effects.size() && effects[i].name() == effect.name(); ++i, ++n) {
      mean += z.segment(at, effect.size());
      at += effect.size();
    }
    if (!effect.recording() || n > 1.0) result.effects.push_back(effect.entry(mean / n));
  }
  return result;
}

}  // namespace leeway::gap
