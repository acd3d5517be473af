#include "gap/compare/fit_search.hpp"

#include <algorithm>
#include <cmath>

#include "core/errors.hpp"
#include "gap/compare/tugs.hpp"
#include "gap/fit/coefficient_scale.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {
namespace {

// The start of what was added to a fit from where it is nothing; none where that is infinitely far.
std::optional<Start> at_neutral(const Fitted& from, const Start& added) {
  Start start{added.hypothesis, added.theta, from.log_evidence};
  const Eigen::Index known = from.fit.theta.size() - 1;
  start.theta.head(known) = from.fit.theta.head(known);
  start.theta[start.theta.size() - 1] = from.fit.theta[known];
  Eigen::Index at = known;
  for (std::size_t i = from.hypothesis.effects.size(); i < added.hypothesis.effects.size(); ++i) {
    const std::optional<Eigen::VectorXd> neutral = added.hypothesis.effects[i].neutral();
    if (!neutral) return std::nullopt;
    start.theta.segment(at, neutral->size()) = *neutral;
    at += neutral->size();
  }
  return start;
}

// Whether an effect is nothing at no finite strength, as little water under the keel.
bool is_never_nothing(const FreeEffect& effect) {
  return bound_to(effect.name()) == BoundTo::nothing && !effect.neutral() && effect.log_strengths().empty();
}

// The start of what was added to a fit with coefficients as stated: those that have moved for what multiplies them hold
// a fit where it is nothing. An effect that is nothing at no finite strength starts from the middle of its prior.
Start as_stated(const Fitted& from, const Start& added) {
  Start start{added.hypothesis, Eigen::VectorXd::Zero(added.theta.size()), added.log_evidence};
  const Eigen::Index known = from.fit.theta.size() - 1;
  start.theta.segment(known - from.fit.effects, from.fit.effects) = coordinates_of(from.fit).mean;
  Eigen::Index at = known;
  for (std::size_t i = from.hypothesis.effects.size(); i < added.hypothesis.effects.size(); ++i) {
    const FreeEffect& effect = added.hypothesis.effects[i];
    if (!is_never_nothing(effect)) start.theta.segment(at, effect.size()) = added.theta.segment(at, effect.size());
    at += effect.size();
  }
  start.theta[start.theta.size() - 1] = from.fit.theta[known];
  return start;
}

// The same fit with coefficients that are no more uncertain than stated.
Fitted with_stated_widths(Fitted fitted) {
  fitted.fit.prior = fitted.fit.stated;
  fitted.fit.scale = 1.0;
  return fitted;
}

bool begins_and_ends(const Hypothesis& hypothesis) {
  return std::ranges::any_of(hypothesis.effects,
                             [](const FreeEffect& effect) { return bound_to(effect.name()) == BoundTo::time; });
}

}  // namespace

bool may_begin_as_stated(const Fitted& from, const Start& added) {
  const auto& effects = added.hypothesis.effects;
  return is_shifted(from.fit) &&
         std::all_of(effects.begin() + static_cast<std::ptrdiff_t>(from.hypothesis.effects.size()), effects.end(),
                     is_never_nothing);
}

FitSearch::FitSearch(const Campaign& campaign, const FitOptions& options) : campaign_(campaign), options_(options) {
  options_.most_iterations = static_cast<int>(kPolicy.compare.refit_iterations);
}

// Nothing where the simulator runs away, which is no explanation.
std::optional<FittedNull> FitSearch::refit(const FittedNull& from, const Hypothesis& hypothesis,
                                           const Eigen::VectorXd& theta) const {
  try {
    return fit_with(campaign_, from, hypothesis, theta, options_);
  } catch (const NumericalError&) {
    return std::nullopt;
  }
}

std::optional<Fitted> FitSearch::fitted_from(const Fitted& from, const Start& start) const {
  std::optional<FittedNull> fit = refit(from.fit, start.hypothesis, start.theta);
  if (!fit) return std::nullopt;
  Fitted fitted;
  fitted.hypothesis = start.hypothesis;
  fitted.fit = std::move(*fit);
  fitted.log_evidence = gap::log_evidence(fitted.fit);
  if (!std::isfinite(fitted.log_evidence)) return std::nullopt;
  return fitted;
}

std::optional<Fitted> FitSearch::likeliest(const Fitted& from, const std::vector<Start>& starts,
                                           std::size_t most_starts) const {
  std::optional<Fitted> best;
  double reached = starts.front().log_evidence;
  const auto keep = [&](std::optional<Fitted> fitted) {
    if (!fitted) return;
    reached = std::max(reached, fitted->log_evidence);
    if (!best || fitted->log_evidence > best->log_evidence) best = std::move(fitted);
  };
  const auto try_from = [&](const Start& start) { keep(fitted_from(from, start)); };
  // First, since where coefficients stand in for an effect a fit is far from it, and the others are behind then.
  if (from.fit.scale > 1.0 || may_begin_as_stated(from, starts.front()))
    keep(fitted_from(with_stated_widths(from), as_stated(from, starts.front())));
  auto next = starts.begin();
  for (; next != starts.end() && next - starts.begin() < static_cast<std::ptrdiff_t>(most_starts); ++next) {
    if (next->log_evidence < reached - kPolicy.compare.far_behind_best_start) break;
    try_from(*next);
  }
  // What is the same in all recordings has less to choose, however far behind a linear step leaves it.
  if (best && best->hypothesis.differs()) {
    const auto is_same = [](const Start& start) { return !start.hypothesis.differs(); };
    const auto same = std::find_if(starts.begin(), starts.end(), is_same);
    if (same != starts.end() && same >= next) try_from(*same);
  }
  return best;
}

std::optional<Fitted> FitSearch::fit(const Fitted& from, const std::vector<Start>& starts,
                                     std::size_t most_starts) const {
  std::optional<Fitted> best = likeliest(from, starts, most_starts);
  if (best) choose_scale(*best);
  if (best && begins_and_ends(best->hypothesis) && !begins_and_ends(from.hypothesis))
    refine_tugs(campaign_, options_, *best);
  // Where the effect is nothing it is as likely as without it.
  if (!best || best->log_evidence < from.log_evidence - kPolicy.compare.worse_than_without)
    if (const std::optional<Start> nothing = at_neutral(from, starts.front()))
      if (auto fitted = fitted_from(from, *nothing)) {
        choose_scale(*fitted);
        if (!best || fitted->log_evidence > best->log_evidence) best = std::move(fitted);
      }
  if (best && !best->fit.report.converged) continue_fit(*best);
  return best;
}

// Fits again from where a fit stands, with so much of its model error at first, as long as that gains.
void FitSearch::climb(Fitted& fitted, double model_error) const {
  for (int i = 0; i < kPolicy.compare.most_continuations; ++i) {
    FittedNull from = fitted.fit;
    if (i == 0) from.noise.sigma_w *= model_error;
    std::optional<FittedNull> next = refit(from, fitted.hypothesis, from.theta);
    if (!next) break;
    const double gained = gap::log_evidence(*next) - fitted.log_evidence;
    if (gained > 0.0) {
      fitted.fit = std::move(*next);
      fitted.log_evidence += gained;
    }
    if (gained < kPolicy.compare.converged_gain) break;
  }
}

bool FitSearch::continue_fit(Fitted& fitted) const {
  const double before = fitted.log_evidence = gap::log_evidence(fitted.fit);
  climb(fitted, 1.0);
  // Also from far below: where an effect has taken most of the model error away, its levels may have stopped halfway.
  climb(fitted, kPolicy.compare.far_below);
  return fitted.log_evidence > before + kPolicy.compare.converged_gain;
}

bool FitSearch::fit_as_stated(Fitted& fitted) const {
  const double before = fitted.log_evidence;
  if (!(fitted.fit.scale > 1.0)) return false;
  Fitted other = with_stated_widths(fitted);
  Eigen::VectorXd theta = fitted.fit.theta;
  theta.head(theta.size() - 1 - fitted.fit.effects).setZero();
  std::optional<FittedNull> fit = refit(other.fit, other.hypothesis, theta);
  if (!fit) return false;
  other.fit = std::move(*fit);
  choose_scale(other);
  if (other.log_evidence < before + kPolicy.compare.converged_gain) return false;
  fitted = std::move(other);
  return true;
}

std::optional<Fitted> FitSearch::better_none(Fitted none, const Fitted& other) const {
  const double before = none.log_evidence;
  none.fit.noise = other.fit.noise;
  none.fit.event_scale = other.fit.event_scale;
  none.fit.log_prior_of_events = other.fit.log_prior_of_events;
  const Eigen::Index coefficients = none.fit.theta.size() - 1;
  Eigen::VectorXd theta = none.fit.theta;
  theta.head(coefficients) = other.fit.theta.head(coefficients);
  theta[coefficients] = other.fit.theta[other.fit.theta.size() - 1];
  std::optional<FittedNull> fit = refit(none.fit, none.hypothesis, theta);
  if (!fit) return std::nullopt;
  none.fit = std::move(*fit);
  choose_scale(none);
  if (none.log_evidence < before + kPolicy.compare.better_optimum) return std::nullopt;
  return none;
}

void FitSearch::choose_scale(Fitted& fitted) const {
  FittedNull& fit = fitted.fit;
  for (int i = 0; i < kPolicy.compare.most_scales; ++i) {
    const PriorWidths best =
        file_evidence(fit.total, fit.theta, widths_by_scale(fit.stated, fit.parameters, fit.effects)).likeliest;
    if ((best.prior.sd().array() / fit.prior.sd().array()).log().abs().maxCoeff() < kPolicy.compare.same_width) break;
    FittedNull from = fit;
    from.prior = best.prior;
    from.scale = best.scale;
    std::optional<FittedNull> other = refit(from, fitted.hypothesis, from.theta);
    if (!other) break;
    // The levels of the noise move with it, and may converge to a worse place. The evidence is averaged over the scale,
    // so that it hardly moves where they do not; what the effects' coordinates are known to does.
    if ((!other->report.converged && fit.report.converged) ||
        gap::log_evidence(*other) < gap::log_evidence(fit) - kPolicy.compare.worse_than_without)
      break;
    fit = std::move(*other);
  }
  fitted.log_evidence = gap::log_evidence(fit);
}

}  // namespace leeway::gap
