#include "gap/show/before_after.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "gap/compare/terms.hpp"
#include "gap/locate/residuals.hpp"
#include "gap/policy/policy.hpp"
#include "gap/result/numbers.hpp"
#include "gap/sensors/audit.hpp"
#include "gap/sensors/conventions.hpp"
#include "gap/show/free_runs.hpp"
#include "gap/show/learned_residual.hpp"
#include "gap/show/left_out.hpp"
#include "ship/joint_uncertainty.hpp"

namespace leeway::gap {
namespace {

// A fit whose effects stand in the ship now.
FittedNull with_effects_in_ship(FittedNull fit) {
  fit.theta = without_effects(fit.theta, fit.effects);
  fit.stated = fit.stated.without(fit.theta.size() - 1, fit.effects);
  fit.prior = fit.prior.without(fit.theta.size() - 1, fit.effects);
  fit.parameters.erase(fit.parameters.end() - 1 - fit.effects, fit.parameters.end() - 1);
  fit.effects = 0;
  return fit;
}

std::vector<EffectEntry> added(const Ship& with, const Ship& to) {
  return {with.effects.begin() + static_cast<std::ptrdiff_t>(to.effects.size()), with.effects.end()};
}

void add_likelihood(Scores& scores, const FittedNull& fit, const std::vector<Run>& runs) {
  scores.log_likelihood_per_sample =
      fit.total.log_likelihood / static_cast<double>(std::max<std::size_t>(1, fit.total.measurements));
  scores.coverage = coverage(fit.smoothed, runs);
}

// Innovations of some runs with other parameters.
void cover(const FittedNull& fit, const Eigen::VectorXd& theta, const std::vector<Run>& runs,
           std::vector<Smoothed>& innovations) {
  for (const Run& run : runs) {
    const Smoothed there = smooth(fit.stretches[run.stretch], fit.noise, theta - fit.theta);
    std::copy(there.innovations.begin() + static_cast<std::ptrdiff_t>(run.begin),
              there.innovations.begin() + static_cast<std::ptrdiff_t>(run.end),
              innovations[run.stretch].innovations.begin() + static_cast<std::ptrdiff_t>(run.begin));
  }
}

class BeforeAfterRuns {
 public:
  BeforeAfterRuns(const Answered& answered, Explanation& explanation)
      : of_(answered),
        explanation_(explanation),
        jobs_(answered.options.locate.jobs),
        fit_(answered.answer.fit),
        starts_(answered.null.smoothed),
        z_(coordinates_of(fit_).mean),
        with_(answered.answer.hypothesis.applied_to(answered.campaign.ship, z_)),
        left_out_(leave_out_in_turn(answered.campaign, answered.answer.hypothesis, fit_, answered.comparison.folds(),
                                    jobs_)) {
    leave_out();
    if (has_terms(explanation.chosen)) learn_what_is_left();
    write_ship();
  }

  /// Of what was fitted.
  void show_fitted() {
    const std::vector<Run> whole = whole_runs(of_.campaign);
    explanation_.train.before = free_runs(of_.campaign, starts_, {{of_.ship, whole}}, jobs_);
    std::vector<ShipOnRuns> ships = by_recording(of_.answer.hypothesis, z_, of_.campaign, whole);
    for (ShipOnRuns& one : ships) {
      one.ship.multiply(explanation_.coefficient_factors);
      one.ship.residual_network = with_.residual_network;
    }
    explanation_.train.after = free_runs(of_.campaign, starts_, ships, jobs_);
    add_likelihood(explanation_.train.before, none(), whole);
    add_likelihood(explanation_.train.after, fit_, whole);
    explanation_.residuals_after = residuals(of_.campaign, fit_);
  }

  /// Of recordings that nothing was fitted to. What makes them worse is not written down: comes before show_fitted().
  void show_given(const std::vector<Trajectory>& heldout) {
    Campaign before = prepare(of_.ship, heldout, {of_.campaign.step_s, 0.0});
    const FittedNull followed_before = follow(before, none(), {}, jobs_);
    take_back_what_fails(before, followed_before.smoothed);
    Campaign after = prepare(without_factors(with_), heldout, {of_.campaign.step_s, 0.0});
    const FittedNull followed_after = follow(after, with_effects_in_ship(fit_), {}, jobs_);
    const std::vector<Run> runs = whole_runs(before);
    const std::vector<Smoothed>& starts = followed_before.smoothed;
    explanation_.heldout.before = free_runs(before, starts, {{of_.ship, runs}}, jobs_);
    explanation_.heldout.after = free_runs(before, starts, {{with_, runs}}, jobs_);
    add_likelihood(explanation_.heldout.before, followed_before, runs);
    add_likelihood(explanation_.heldout.after, followed_after, runs);
    explanation_.tracks_before = free_tracks(before, starts, {{of_.ship, runs}});
    explanation_.tracks_after = free_tracks(before, starts, {{with_, runs}});
    const double inside = explanation_.heldout.after.coverage.at(kPolicy.show.judged_interval);
    explanation_.heldout_is_followed = !(inside < kPolicy.show.least_inside);
    if (!explanation_.heldout_is_followed)
      explanation_.notices.push_back(fmt::format(
          "the held-out recordings are not followed: {} of what they measure lies within the interval of {} % of what "
          "the filter expects with ship.json",
          percent(inside), kPolicy.show.judged_interval));
  }

  /// Of each part, with what was fitted to the others.
  void show_left_out() {
    const std::vector<std::vector<std::size_t>>& folds = of_.comparison.folds();
    std::vector<ShipOnRuns>& after = takes_coefficients_ ? left_out_.with_coefficients : left_out_.alone;
    double likelihood_before = 0.0, likelihood_after = 0.0;
    const Evidence of_none = of_.comparison.blocks().total();
    std::vector<Smoothed> innovations_before = none().smoothed, innovations_after = fit_.smoothed;
    for (std::size_t f = 0; f < folds.size(); ++f) {
      const std::vector<Run>& runs = left_out_.runs[f];
      cover(none(), refitted(none(), without(of_none, of_.comparison.blocks(), folds[f])), runs, innovations_before);
      likelihood_before += of_.comparison.none().fold_evidence[f];
      if (!learned_.network) {
        cover(fit_, left_out_.theta[f], runs, innovations_after);
        likelihood_after += of_.answer.fold_evidence[f];
        continue;
      }
      after[f].ship.residual_network = learned_.by_fold[f];  // what differs between recordings has none
      Ship there = without_factors(with_);
      there.residual_network = learned_.by_fold[f];
      Campaign with_network = prepare(there, of_.campaign.recordings, {of_.campaign.step_s, 0.0});
      const FittedNull followed = follow(with_network, with_effects_in_ship(fit_), {}, jobs_);
      cover(followed, followed.theta, runs, innovations_after);
      const Blocks of_network = blocks_of(with_network, followed, followed.noise, {0, nullptr}, jobs_);
      for (const std::size_t block : folds[f]) likelihood_after += of_network.evidence[block].log_likelihood;
    }
    BeforeAfter& heldout = explanation_.heldout;
    heldout.before = free_runs(of_.campaign, starts_, as_stated_, jobs_);
    heldout.after = learned_.network      ? free_runs(of_.campaign, starts_, after, jobs_)
                    : takes_coefficients_ ? of_coefficients_
                                          : of_alone_;
    const std::vector<Run> whole = whole_runs(of_.campaign);
    heldout.before.coverage = coverage(innovations_before, whole);
    heldout.after.coverage = coverage(innovations_after, whole);
    explanation_.tracks_before = free_tracks(of_.campaign, starts_, as_stated_);
    explanation_.tracks_after = free_tracks(of_.campaign, starts_, after);
    const auto n = static_cast<double>(std::max<std::size_t>(1, left_out_.total.measurements));
    heldout.before.log_likelihood_per_sample = likelihood_before / n;
    heldout.after.log_likelihood_per_sample = likelihood_after / n;
  }

 private:
  const FittedNull& none() const { return of_.comparison.none().fit; }

  // A ship whose coefficients are fitted anew, or stand in theta.
  Ship without_factors(Ship ship) const {
    ship.coefficient_factors = of_.ship.coefficient_factors;
    return ship;
  }

  // Effects alone, or with the coefficients: which of them are better goes into ship.json.
  void leave_out() {
    for (const std::vector<Run>& runs : left_out_.runs) as_stated_.push_back({of_.ship, runs});
    of_alone_ = free_runs(of_.campaign, starts_, left_out_.alone, jobs_);
    of_coefficients_ = free_runs(of_.campaign, starts_, left_out_.with_coefficients, jobs_);
    const bool are_better =
        log_error(of_coefficients_) < log_error(of_alone_) - kPolicy.show.worthwhile_fall &&
        are_likelier(left_out_.total) &&
        is_beyond_chance(of_.campaign, starts_, left_out_.alone, left_out_.with_coefficients, jobs_);
    std::optional<Calibration>& calibration = explanation_.calibration;
    takes_coefficients_ = are_better || calibration;
    if (takes_coefficients_)
      explanation_.coefficient_factors =
          coefficient_changes(fit_, fit_.theta, calibration ? 0.0 : kPolicy.show.same_log_factor);
    leave_out_what_no_ship_has();
    if (calibration) *calibration = {are_better && takes_coefficients_, fit_.scale, covariance_of_coefficients()};
    if (calibration && takes_coefficients_ && !are_better)
      explanation_.notices.emplace_back(
          "what was left out in turn is not followed better with the fitted coefficients, beyond chance: ship.json has "
          "them, since they were asked for");
    with_.multiply(explanation_.coefficient_factors);
  }

  // Coefficients beyond what a ship file may hold: such recordings are of something else.
  void leave_out_what_no_ship_has() {
    std::vector<CoefficientFactor>& factors = explanation_.coefficient_factors;
    const auto beyond = std::ranges::find_if(factors, [](const CoefficientFactor& by) {
      return by.shift == 0.0 && (by.factor < kFactorRange.low || by.factor > kFactorRange.high);
    });
    if (beyond == factors.end()) return;
    explanation_.notices.push_back(fmt::format(
        "ship.json has no coefficients fitted anew: {} would be {:.3g} times what the file has, a factor from {:g} to "
        "{:g} is possible; are these recordings of this ship, in the stated units?",
        beyond->name, beyond->factor, kFactorRange.low, kFactorRange.high));
    factors.clear();
    takes_coefficients_ = false;
  }

  Ship::JointUncertainty covariance_of_coefficients() const {
    const Eigen::Index n = fit_.coefficients();
    Ship::JointUncertainty joint{{}, posterior_covariance(fit_).topLeftCorner(n, n)};
    for (Eigen::Index i = 0; i < n; ++i) {
      const UncertainParameter& p = fit_.parameters[static_cast<std::size_t>(i)];
      joint.names.push_back(p.name);
      if (!p.is_absolute) joint.matrix(i, i) += kPolicy.show.least_direction_sd * kPolicy.show.least_direction_sd;
    }
    return statable(std::move(joint), of_.ship);
  }

  // Whether the recordings speak for coefficients other than those of the ship file, after what their freedom costs.
  bool are_likelier(const Evidence& total) const {
    Eigen::VectorXd as_stated = fit_.prior.sd();
    as_stated.head(fit_.coefficients()).setConstant(kPolicy.show.as_stated_log_sd);
    return marginal(total, fit_.theta, fit_.prior) >
           marginal(total, fit_.theta, ThetaPrior(as_stated)) + kPolicy.show.likelier_nats;
  }

  void learn_what_is_left() {
    if (of_.options.locate.progress) of_.options.locate.progress(0.89, "a network for what is left");
    if (of_.answer.hypothesis.differs())
      learned_.problem = "what is named differs between recordings";
    else if (of_.ship.residual_network)
      learned_.problem = "the ship has one already";
    else
      learned_ =
          learn_residual(of_.campaign, starts_, with_, left_out_.runs, fit_.noise, of_.options.locate.seed, jobs_);
    if (!learned_.problem.empty())
      explanation_.notices.push_back("no network learned what is left: " + learned_.problem);
    if (learned_.network) explanation_.residual_network = with_.residual_network = learned_.network;
    explanation_.log_error_without_network = learned_.log_error_without;
    explanation_.log_error_with_network = learned_.log_error_with;
  }

  // A network, coefficients and effects, where the given recordings get worse with them than with the ship as it was.
  void take_back_what_fails(const Campaign& given, const std::vector<Smoothed>& starts) {
    const auto error = [&](const Ship& ship) {
      return log_error(free_runs(given, starts, {{ship, whole_runs(given)}}, jobs_));
    };
    const double before = error(of_.ship);
    const auto rise = [&] { return error(with_) - before; };
    const auto notice = [&](std::string_view what, double by) {
      explanation_.notices.push_back(fmt::format(
          "{}with {} the errors of free runs over the held-out recordings grow by {:.0f} %",
          explanation_.calibration ? "" : fmt::format("ship.json has no {}: ", what), what, 100.0 * std::expm1(by)));
    };
    if (double by = 0.0; learned_.network && (by = rise()) > 0.0) {
      learned_.network = explanation_.residual_network = with_.residual_network = nullptr;
      notice("network", by);
    }
    if (double by = 0.0; takes_coefficients_ && (by = rise()) > 0.0) {
      notice("coefficients fitted anew", by);
      if (explanation_.calibration) {
        explanation_.calibration->helps = false;
        return;
      }
      takes_coefficients_ = false;
      explanation_.coefficient_factors.clear();
      with_ = without_factors(with_);
    }
    // That without which they err least goes first.
    for (double by = 0.0; changes_effects() && (by = rise()) > kPolicy.show.worthwhile_fall;) {
      const std::size_t first = of_.ship.effects.size();
      std::vector<double> without;
      for (std::size_t i = first; i < with_.effects.size(); ++i) without.push_back(error(without_effect(with_, i)));
      const auto place = first + static_cast<std::size_t>(std::ranges::min_element(without) - without.begin());
      const std::string name = with_.effects[place].type;
      explanation_.withheld.push_back(name);
      notice(name, by);
      with_ = without_effect(with_, place);
    }
    explanation_.effects = added(with_, of_.campaign.ship);
  }

  bool changes_effects() const { return with_.effects.size() > of_.ship.effects.size(); }
  static Ship without_effect(Ship ship, std::size_t place) {
    ship.effects.erase(ship.effects.begin() + static_cast<std::ptrdiff_t>(place));
    return ship;
  }

  void write_ship() {
    const Hypothesis& hypothesis = of_.answer.hypothesis;
    explanation_.effects = added(with_, of_.campaign.ship);
    if (!hypothesis.differs()) return;
    for (std::size_t r = 0; r < of_.campaign.recordings.size(); ++r)
      explanation_.effects_in[of_.campaign.recordings[r].name] =
          added(hypothesis.applied_to(of_.campaign.ship, z_, r), of_.campaign.ship);
  }

  const Answered& of_;
  Explanation& explanation_;
  const std::size_t jobs_;
  const FittedNull& fit_;
  const std::vector<Smoothed>& starts_;
  const Eigen::VectorXd z_;
  Ship with_;  // as ship.json has it
  LeftOut left_out_;
  std::vector<ShipOnRuns> as_stated_;  // by part that is left out
  Scores of_alone_, of_coefficients_;
  bool takes_coefficients_ = false;
  LearnedResidual learned_;
};

}  // namespace

void show_before_after(const Answered& answered, std::vector<Trajectory>& heldout, Explanation& explanation) {
  BeforeAfterRuns runs(answered, explanation);
  if (answered.options.locate.progress) answered.options.locate.progress(0.9, "free runs before and after");
  explanation.heldout_gain = answered.answer.gain;
  explanation.heldout_gain_sd = answered.answer.gain_sd;
  for (const Explained& hypothesis : explanation.hypotheses)
    if (hypothesis.is_chosen && std::isfinite(hypothesis.heldout_gain)) {
      explanation.heldout_gain = hypothesis.heldout_gain;
      explanation.heldout_gain_sd = hypothesis.heldout_gain_sd;
    }
  explanation.heldout_is_given = !heldout.empty();
  if (heldout.empty()) {
    runs.show_fitted();
    return runs.show_left_out();
  }
  const Findings& findings = answered.findings;
  const FroudeScale scale(findings.L_pp);
  if (findings.corrected)
    for (Trajectory& recording : heldout)
      recording = corrected(reread(recording, findings.conventions.contradicted), findings.audit.faults, scale);
  runs.show_given(heldout);
  runs.show_fitted();
}

}  // namespace leeway::gap
