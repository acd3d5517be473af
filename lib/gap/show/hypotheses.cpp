#include "gap/show/hypotheses.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <map>
#include <numeric>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/linear_algebra.hpp"
#include "gap/compare/current_course.hpp"
#include "gap/compare/selection.hpp"
#include "gap/compare/terms.hpp"
#include "gap/decide/found.hpp"
#include "gap/fit/coefficient_scale.hpp"
#include "gap/result/phrases.hpp"
#include "gap/sensors/audit.hpp"
#include "gap/sensors/sensor_faults.hpp"
#include "gap/show/next_maneuver.hpp"

namespace leeway::gap {
namespace {

// Intervals of 95 % reach as far as Student's with four degrees of freedom: errors on concealed cases have the median
// of a normal distribution, but its tails (docs/gap-explain-details.md).
constexpr double kTails = kPolicy.show.student95 / kPolicy.show.normal95;

// How well a delay can be known [s]: what actuators do between samples is not.
double timing_sd_s(const Campaign& campaign) {
  double sample_s = 0.0;
  for (const Stretch& stretch : campaign.stretches) sample_s = std::max(sample_s, stretch.sample_s);
  return kPolicy.filter.actuator_timing_sd * kPolicy.filter.timing_share * sample_s;
}

// Coordinates of one effect, with what was believed before and as the recordings alone say.
struct Known {
  Coordinates best, recorded;

  /// The same of linear combinations.
  Known of(const Eigen::MatrixXd& by) const {
    return {{by * best.mean, by * best.covariance * by.transpose()},
            {by * recorded.mean, by * recorded.covariance * by.transpose()}};
  }
};

// Parameters of effects of one name, as a fit has them.
class ParametersOf {
 public:
  ParametersOf(const Fitted& fitted, const Campaign& campaign, Explained& result)
      : fitted_(fitted), campaign_(campaign), result_(result), z_(coordinates_of(fitted.fit)) {}

  void add(const EffectSpan& span) const {
    const FreeEffect& effect = fitted_.hypothesis.effects[span.effect];
    const Eigen::VectorXd mean = z_.mean.segment(span.first, span.count);
    const Eigen::MatrixXd covariance = z_.covariance.block(span.first, span.first, span.count, span.count);
    Known z{{mean, covariance}, without_prior({mean, covariance})};
    z.best.covariance *= fitted_.kappa;
    z.recorded.covariance *= fitted_.kappa;
    if (search_start(effect.name()) == SearchStart::course) return add_process(span, z.recorded);
    if (span.effects == 1)
      return add(effect, effect.recording() ? campaign_.recordings[*effect.recording()].name : "", z);
    const Eigen::Index n = effect.size();
    const auto times = static_cast<Eigen::Index>(span.effects);
    add_values(effect, "", z.of(Eigen::MatrixXd::Identity(n, n).replicate(1, times) / static_cast<double>(times)));
    for (Eigen::Index i = 0; i < times; ++i) {
      const FreeEffect& there = fitted_.hypothesis.effects[span.effect + static_cast<std::size_t>(i)];
      const Eigen::MatrixXd its_own = Eigen::MatrixXd::Identity(span.count, span.count).middleRows(i * n, n);
      add(there, campaign_.recordings[*there.recording()].name, z.of(its_own));
    }
  }

 private:
  void add(const FreeEffect& effect, const std::string& recording, const Known& z) const {
    add_values(effect, recording, z);
    add_times(effect, recording, z.best.mean);
  }

  void add_values(const FreeEffect& effect, const std::string& recording, const Known& z) const {
    // What was believed before any recording was seen.
    const Eigen::Index n = effect.size();
    const std::vector<FreeEffect::Parameter> before =
        effect.parameters(Eigen::VectorXd::Zero(n), Eigen::MatrixXd::Identity(n, n));
    const Eigen::MatrixXd of_formula = effect.sd_of_formula(z.best.mean).cwiseAbs2().asDiagonal();
    const std::vector<FreeEffect::Parameter> after = effect.parameters(z.best.mean, z.best.covariance + of_formula);
    const std::vector<FreeEffect::Interval> recorded = effect.intervals(
        z.best.mean, z.recorded.mean - z.best.mean, kTails * kTails * (z.recorded.covariance + of_formula));
    const std::span<const EffectParameter> known = effect_named(effect.name()).parameters;
    for (std::size_t i = 0; i < after.size(); ++i) {
      const FreeEffect::Parameter& p = after[i];
      ExplainedParameter one{effect.name(),   p.name,           recording,     p.estimate,    p.sd,
                             recorded[i].low, recorded[i].high, before[i].low, before[i].high};
      one.is_at_bound = p.is_at_bound;
      const bool is_response_time = std::any_of(known.begin(), known.end(), [&](const EffectParameter& of) {
        return of.name == p.name && of.role == ParameterRole::response_time;
      });
      if (is_response_time) {
        one.sd = std::hypot(p.sd, timing_sd_s(campaign_));
        const double wider = one.sd / std::max(p.sd, kPolicy.show.least_sd);
        one.low = std::max(0.0, p.estimate - wider * (p.estimate - one.low));
        one.high = p.estimate + wider * (one.high - p.estimate);
      }
      result_.parameters.push_back(one);
    }
  }

  // When it begins and ends in the recording, which the filter knows to a time step.
  void add_times(const FreeEffect& effect, const std::string& recording, const Eigen::VectorXd& at) const {
    const EffectEntry entry = effect.entry(at);
    const std::vector<double>& t_s = campaign_.recordings[effect.recording().value_or(0)][Channel::t];
    for (const EffectParameter& known : effect_named(effect.name()).parameters) {
      if (known.role != ParameterRole::begin && known.role != ParameterRole::end) continue;
      for (const auto& [name, value] : entry.parameters)
        if (name == known.name && value && std::isfinite(*value)) {
          const double sd = std::hypot(campaign_.step_s, effect.known_sd(name)), reach = kPolicy.show.normal95 * sd;
          result_.parameters.push_back({effect.name(), name, recording, *value, sd,
                                        std::max(*value - reach, t_s.front()), std::min(*value + reach, t_s.back()),
                                        kMissing, kMissing});
        }
    }
  }

  void add_process(const EffectSpan& span, const Coordinates& recorded) const {
    const auto first = fitted_.hypothesis.effects.begin() + static_cast<std::ptrdiff_t>(span.effect);
    const std::vector<FreeEffect> courses(first, first + static_cast<std::ptrdiff_t>(span.effects));
    const auto before = current_process(campaign_.ship, {}, {}, {}),
               after = current_process(campaign_.ship, courses, recorded.mean, recorded.covariance);
    for (std::size_t i = 0; i < after.size(); ++i)
      result_.parameters.push_back({first->name(), after[i].name, "", after[i].estimate, after[i].sd, after[i].low,
                                    after[i].high, before[i].low, before[i].high});
  }

  const Fitted& fitted_;
  const Campaign& campaign_;
  Explained& result_;
  const Coordinates z_;
};

Explained explained(const Fitted& fitted, const Fitted& none, const Campaign& campaign) {
  Explained result;
  result.name = fitted.hypothesis.name();
  result.log_evidence = fitted.log_evidence - none.log_evidence;
  result.heldout_gain = fitted.gain;
  result.heldout_gain_sd = fitted.gain_sd;
  result.converged = fitted.fit.report.converged;
  const ParametersOf parameters(fitted, campaign, result);
  for (const EffectSpan& span : spans_of(fitted.hypothesis)) {
    const std::string& name = fitted.hypothesis.effects[span.effect].name();
    const EffectInfo& info = effect_named(name).info;
    result.effects.push_back(name);
    parameters.add(span);
    result.said.push_back({name, sentence_of(name, result.parameters), std::string(info.separating_maneuver)});
  }
  return result;
}

// Terms of the unknown are no more probable, against named effects, than that these do not act in another form.
void limit_unknown(Explanation& explanation) {
  double named = 0.0, unknown = 0.0;
  for (const Explained& hypothesis : explanation.hypotheses)
    if (!hypothesis.effects.empty()) (has_terms(hypothesis.effects) ? unknown : named) += hypothesis.probability;
  const double both = named + unknown;
  if (!(named > 0.0) || unknown <= (1.0 - kPolicy.show.other_form) * both) return;
  for (Explained& hypothesis : explanation.hypotheses)
    if (!hypothesis.effects.empty())
      hypothesis.probability *= has_terms(hypothesis.effects) ? (1.0 - kPolicy.show.other_form) * both / unknown
                                                              : kPolicy.show.other_form * both / named;
}

// A fault with the numbers that a hypothesis has.
//   moved  as Explained has it
Fault as_moved(Fault fault, const std::map<std::string, Estimate>& moved) {
  const FaultCandidate* candidate = candidate_of(fault);
  if (candidate == nullptr || fault.left_open.empty() || moved.empty()) return fault;
  std::size_t i = 0;
  for (const std::vector<FaultParameter>& number : candidate->numbers) {
    const Estimate& by = moved.at(fault.parameters[i].name);
    for (const std::size_t end = i + number.size(); i < end; ++i) {
      fault.parameters[i].value += by.value * fault.left_open[i];
      fault.parameters[i].sd = by.sd * fault.left_open[i];
    }
  }
  rephrase(fault);
  return fault;
}

std::vector<ExplainedParameter> estimates_of(const Fault& fault) {
  std::vector<ExplainedParameter> result;
  for (const Estimate& e : fault.parameters)
    result.push_back({fault.name, e.name, "", e.value, e.sd, e.value - kPolicy.show.student95 * e.sd,
                      e.value + kPolicy.show.student95 * e.sd, kMissing, kMissing});
  return result;
}

// The numbers of faults that are free in a fit, as Explained has them.
std::map<std::string, Estimate> moved_faults(const Fitted& fitted) {
  const FittedNull& fit = fitted.fit;
  std::map<std::string, Estimate> result;
  if (fit.faults == 0) return result;
  const Eigen::MatrixXd covariance = fitted.kappa * posterior_covariance(fit);
  for (Eigen::Index i = fit.coefficients(); i < fit.coefficients() + fit.faults; ++i) {
    const std::string& name = fit.parameters[static_cast<std::size_t>(i)].name;
    result[name] = {name, fit.theta[i], std::sqrt(covariance(i, i))};
  }
  return result;
}

// What was found of sensors and conventions, as one hypothesis that the others have as well.
struct SensorHypothesis {
  Explained sensors;
  double all_chance = 0.0;  // that one of them is none
};

SensorHypothesis sensor_hypothesis(const Findings& findings) {
  SensorHypothesis found;
  Explained& sensors = found.sensors;
  sensors.effects = sensors_claimed(findings);
  const auto add = [&](Said said, double p_value) {
    sensors.said.push_back(std::move(said));
    const double odds = least_odds_of_nothing(p_value);
    found.all_chance = 1.0 - (1.0 - found.all_chance) / (1.0 + odds);
  };
  for (const Reading& reading : findings.conventions.contradicted) {
    add({"convention", capitalized(reading.claim()) + ".", ""}, 0.0);
    // Nothing is fitted to tell a reading, so that its likelihood is that of unseen data.
    sensors.log_evidence += reading.log_odds;
    sensors.heldout_gain += reading.log_odds;
  }
  for (const Fault& fault : findings.audit.faults) {
    add({fault.name, fault.sentence, fault.separating_maneuver}, fault.p_value);
    sensors.log_evidence += fault.heldout_gain;
    sensors.heldout_gain += fault.heldout_gain;
    sensors.heldout_gain_sd = std::hypot(sensors.heldout_gain_sd, fault.heldout_gain_sd);
  }
  return found;
}

// Whether all effects of a fit are within a standard deviation of doing nothing.
bool does_nothing(const Fitted& fitted) {
  const Coordinates z = coordinates_of(fitted.fit);
  const std::vector<EffectSpan> spans = spans_of(fitted.hypothesis);
  return !spans.empty() && std::all_of(spans.begin(), spans.end(), [&](const EffectSpan& span) {
    const auto neutral = fitted.hypothesis.effects[span.effect].neutral();
    if (!neutral) return false;
    const Eigen::VectorXd away =
        z.mean.segment(span.first, span.count) - neutral->replicate(static_cast<Eigen::Index>(span.effects), 1);
    const Eigen::MatrixXd covariance = z.covariance.block(span.first, span.first, span.count, span.count);
    return away.dot(covariance.llt().solve(away)) < static_cast<double>(span.count);
  });
}

// An effect that does nothing cannot make the recordings likelier: then the fit without it has stopped too early.
void note_unconverged_none(Explanation& explanation, const std::vector<Fitted>& all) {
  for (std::size_t i = 1; i < all.size(); ++i) {
    const double gained = explanation.hypotheses[i].log_evidence;
    if (gained < kPolicy.decide.strong_odds || !does_nothing(all[i])) continue;
    explanation.hypotheses.front().converged = false;
    explanation.notices.push_back(fmt::format(
        "the fit with nothing missing has not converged ({} does nothing where it fits best, and gains {:.0f} "
        "in log-likelihood): how likely each effect is, and what it gains, is known badly",
        explanation.hypotheses[i].name, gained));
    return;
  }
}

// The hypothesis with the most effects of those that are claimed, and no others.
void mark_chosen(Explanation& explanation) {
  const auto is_claimed = [&](const std::string& name) {
    return std::find(explanation.chosen.begin(), explanation.chosen.end(), name) != explanation.chosen.end();
  };
  Explained* what = nullptr;
  for (Explained& hypothesis : explanation.hypotheses)
    if (!hypothesis.effects.empty() && std::all_of(hypothesis.effects.begin(), hypothesis.effects.end(), is_claimed) &&
        (what == nullptr || hypothesis.effects.size() > what->effects.size()))
      what = &hypothesis;
  if (what != nullptr) what->is_chosen = true;
}

std::map<std::string, double> coefficients_off(const FittedNull& fit) {
  const Eigen::VectorXd off =
      file_evidence(fit.total, fit.theta, widths_by_scale(fit.stated, fit.parameters, fit.effects)).off;
  std::map<std::string, double> result;
  for (Eigen::Index i = 0; i < off.size(); ++i)
    if (off[i] > 0.0) result[fit.parameters[static_cast<std::size_t>(i)].name] = off[i];
  return result;
}

// Where the simulator errs by no more than forms of forces do, and no terms are chosen, terms are other forms of the
// ship's own forces, and nothing that is missing: what they have belongs to the same without them.
std::vector<double> without_other_forms(std::vector<double> probabilities, const std::vector<Fitted>& all,
                                        std::size_t chosen) {
  if (error_share(all.front().fit.report) >= kPolicy.decide.error_of_forms || has_terms(all[chosen].hypothesis.names()))
    return probabilities;
  for (std::size_t i = 1; i < all.size(); ++i) {
    std::set<std::string> names = name_set(all[i].hypothesis);
    if (names.erase(name_of_terms()) == 0) continue;
    const auto bare = std::ranges::find_if(all, [&](const Fitted& one) { return name_set(one.hypothesis) == names; });
    probabilities[static_cast<std::size_t>((bare == all.end() ? all.begin() : bare) - all.begin())] += probabilities[i];
    probabilities[i] = 0.0;
  }
  return probabilities;
}

}  // namespace

void report_hypotheses(Explanation& explanation, const Comparison& comparison, std::size_t chosen,
                       const Campaign& campaign) {
  const std::vector<Fitted>& all = comparison.all();
  for (const Fitted& fitted : all) explanation.hypotheses.push_back(explained(fitted, all.front(), campaign));
  const std::vector<double> probabilities = without_other_forms(comparison.probabilities(), all, chosen);
  const std::vector<Unseen> unseen = comparison.unseen_effects();
  for (std::size_t i = 0; i < all.size(); ++i) {
    Explained& hypothesis = explanation.hypotheses[i];
    hypothesis.probability = probabilities[i];
    hypothesis.unseen = unseen[i];
    hypothesis.coefficients_off = coefficients_off(all[i].fit);
    hypothesis.of_faults = moved_faults(all[i]);
  }
  limit_unknown(explanation);
  note_unconverged_none(explanation, all);
  explanation.p_right = *std::ranges::max_element(probabilities);
}

void plan_next(Explanation& explanation, const Comparison& comparison, const std::vector<double>& probabilities,
               const Campaign& campaign, const GapExplainOptions& options) {
  const std::vector<Fitted>& all = comparison.all();
  // The likeliest ones that hold nearly all of the probability.
  std::vector<std::size_t> order(all.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, std::greater(), [&](std::size_t i) { return probabilities[i]; });
  std::vector<const Fitted*> possible;
  std::vector<double> weight;
  const double most_of_all = kPolicy.show.decisive * std::accumulate(probabilities.begin(), probabilities.end(), 0.0);
  const double with_sensors = explanation.p_right / probabilities[order.front()];  // faults that may be others
  double sum = 0.0;
  for (const std::size_t i : order) {
    if (sum >= most_of_all || probabilities[i] < kPolicy.show.possible) break;
    sum += probabilities[i];
    possible.push_back(&all[i]);
    weight.push_back(probabilities[i] * with_sensors);
  }
  if (possible.size() < 2) return;
  if (options.locate.progress) options.locate.progress(0.88, "which maneuver would distinguish");
  explanation.next = plan_maneuvers(campaign, possible, weight, options.next, options.locate.jobs, options.locate.seed);
}

void add_unknown(Explanation& explanation, const std::vector<std::string>& beside, double odds_of_nothing) {
  double named = 0.0;
  for (const Explained& hypothesis : explanation.hypotheses)
    if (!hypothesis.effects.empty() && hypothesis.effects != beside) named += hypothesis.probability;
  const double left = named > 0.0 ? 1.0 - kPolicy.show.other_form : 1.0;
  for (Explained& hypothesis : explanation.hypotheses)
    hypothesis.probability *= hypothesis.effects.empty() || hypothesis.effects == beside
                                  ? left * odds_of_nothing / (1.0 + odds_of_nothing)
                                  : kPolicy.show.other_form / named;
  const auto without = std::ranges::find(explanation.hypotheses, beside, &Explained::effects);
  Explained unknown;
  if (without != explanation.hypotheses.end()) {
    unknown.parameters = without->parameters;
    unknown.of_faults = without->of_faults;
    unknown.said = without->said;
  }
  unknown.effects = beside;
  unknown.effects.push_back(name_of_terms());
  unknown.name = fmt::format("{}", fmt::join(unknown.effects, " + "));
  unknown.log_evidence = unknown.heldout_gain = unknown.heldout_gain_sd = kMissing;  // nothing was fitted
  unknown.converged = true;
  unknown.probability = left / (1.0 + odds_of_nothing);
  unknown.said.push_back({name_of_terms(), "Something acts that the catalogue does not hold.",
                          "the maneuvers in which what is left is largest"});
  // Terms for it may have been fitted that are not claimed: they are in this one.
  for (const Explained& one : explanation.hypotheses)
    if (one.effects == unknown.effects) unknown.probability += one.probability;
  std::erase_if(explanation.hypotheses, [&](const Explained& one) { return one.effects == unknown.effects; });
  explanation.hypotheses.push_back(std::move(unknown));
}

void say_kind_of_unknown(Explanation& explanation) {
  if (explanation.unknown_kinds.empty()) return;
  for (Explained& hypothesis : explanation.hypotheses)
    for (Said& said : hypothesis.said)
      if (said.name == name_of_terms() && hypothesis.effects == explanation.chosen)
        said.sentence += fmt::format(" It is likeliest {}.", phrase(explanation.unknown_kinds.front()));
}

void add_sensors(Explanation& explanation, const Findings& findings) {
  const auto [sensors, all_chance] = sensor_hypothesis(findings);
  if (sensors.effects.empty()) return;
  Explained nothing = *std::find_if(explanation.hypotheses.begin(), explanation.hypotheses.end(),
                                    [](const Explained& hypothesis) { return hypothesis.effects.empty(); });
  nothing.probability = all_chance;
  explanation.p_right *= 1.0 - all_chance;
  for (Explained& hypothesis : explanation.hypotheses) {
    hypothesis.probability *= 1.0 - all_chance;
    hypothesis.said.insert(hypothesis.said.begin(), sensors.said.begin(), sensors.said.end());
    hypothesis.effects.insert(hypothesis.effects.begin(), sensors.effects.begin(), sensors.effects.end());
    hypothesis.name = fmt::format("{}", fmt::join(hypothesis.effects, " + "));
    hypothesis.log_evidence += sensors.log_evidence;
    hypothesis.heldout_gain += sensors.heldout_gain;
    hypothesis.heldout_gain_sd = std::hypot(hypothesis.heldout_gain_sd, sensors.heldout_gain_sd);
    std::vector<ExplainedParameter> parameters;
    for (const Fault& found : findings.audit.faults) {
      const Fault fault = as_moved(found, hypothesis.of_faults);
      std::ranges::move(estimates_of(fault), std::back_inserter(parameters));
      std::ranges::find(hypothesis.said, fault.name, &Said::name)->sentence = fault.sentence;
    }
    hypothesis.parameters.insert(hypothesis.parameters.begin(), parameters.begin(), parameters.end());
  }
  explanation.hypotheses.push_back(std::move(nothing));
}

void add_rivals(Explanation& explanation, const Findings& findings) {
  for (const Fault& fault : findings.audit.faults) {
    std::map<std::string, const Fault*> rivals;  // the best of each name
    for (const Fault& rival : fault.rivals)
      if (std::exp(rival.log_odds) > kPolicy.show.possible) rivals.emplace(rival.name, &rival);
    double largest_share = 0.0;
    for (std::size_t h = 0, n = explanation.hypotheses.size(); h < n; ++h) {
      const Explained with = explanation.hypotheses[h];
      const auto has = [&](const std::string& name) {
        return std::find(with.effects.begin(), with.effects.end(), name) != with.effects.end();
      };
      if (!has(fault.name) || with.probability < kPolicy.show.possible) continue;
      double weights = 1.0;
      for (const auto& [name, rival] : rivals)
        if (!has(name)) weights += std::exp(std::min(rival->log_odds, 0.0));
      explanation.hypotheses[h].probability /= weights;
      largest_share = std::max(largest_share, 1.0 / weights);
      for (const auto& [name, rival] : rivals) {
        if (has(name)) continue;
        Explained other = with;
        other.probability *= std::exp(std::min(rival->log_odds, 0.0)) / weights;
        std::replace(other.effects.begin(), other.effects.end(), fault.name, name);
        other.name = fmt::format("{}", fmt::join(other.effects, " + "));
        other.log_evidence += rival->log_odds;
        other.heldout_gain += rival->heldout_gain - fault.heldout_gain;
        std::erase_if(other.parameters, [&](const ExplainedParameter& p) { return p.effect == fault.name; });
        const std::vector<ExplainedParameter> of_rival = estimates_of(*rival);
        other.parameters.insert(other.parameters.begin(), of_rival.begin(), of_rival.end());
        for (Said& said : other.said)
          if (said.name == fault.name) said = {name, rival->sentence, rival->separating_maneuver};
        explanation.hypotheses.push_back(std::move(other));
      }
    }
    if (largest_share > 0.0) explanation.p_right *= largest_share;
  }
}

void sort_hypotheses(Explanation& explanation) {
  std::stable_sort(explanation.hypotheses.begin(), explanation.hypotheses.end(),
                   [](const Explained& a, const Explained& b) { return a.probability > b.probability; });
  for (Explained& hypothesis : explanation.hypotheses)
    for (const Explained& other : explanation.hypotheses)
      if (&other != &hypothesis &&
          other.probability > std::max(kPolicy.show.not_excluded * hypothesis.probability, kPolicy.show.possible))
        hypothesis.confusable_with.push_back(other.name);
  for (Explained& hypothesis : explanation.hypotheses) {
    std::vector<std::string> sentences, maneuvers;
    for (const Said& said : hypothesis.said) {
      sentences.push_back(said.sentence + (said.sentence.ends_with('.') ? "" : "."));
      if (!said.separating_maneuver.empty()) maneuvers.push_back(said.separating_maneuver);
    }
    hypothesis.sentence = sentences.empty() ? "Nothing is missing." : fmt::format("{}", fmt::join(sentences, " "));
    hypothesis.separating_maneuver = fmt::format("{}", fmt::join(maneuvers, "; "));
  }
  mark_chosen(explanation);
}

}  // namespace leeway::gap
