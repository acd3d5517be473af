#include "gap/report/reasons.hpp"

#include <algorithm>
#include <cctype>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace leeway::gap {
namespace {

// What is likelier than all else, how often chance alone makes it so, and why it is not claimed where that is rare.
std::string likeliest_of(const std::vector<Explained>& hypotheses, const Decision& decision, double false_alarm) {
  const Explained& likeliest = *std::ranges::max_element(hypotheses, {}, &Explained::probability);
  const bool is_rare = decision.p_value < false_alarm;
  const std::string_view but = decision.reason == Reason::likelier_but_not_heldout
                                   ? "; but it does not predict better what was left out"
                               : decision.reason == Reason::likelier_but_not_told_from_none
                                   ? "; but the strength of an effect is not told from none"
                                   : "";
  return fmt::format(
      "{} is likelier than all else together ({:.2f}), {} chance alone shows as much in {:.3g} % of campaigns in which "
      "nothing is missing{}; more recordings would decide",
      fmt::join(likeliest.effects, " + "), likeliest.probability, is_rare ? "and" : "but", 100.0 * decision.p_value,
      but);
}

std::string sentence_of(const Decision& decision, const TestsFound& found, const Findings& findings,
                        const std::vector<Explained>& hypotheses) {
  const Detection& d = findings.detection;
  const std::string simulator = findings.ensemble ? "ensemble" : "simulator";
  const std::string rate = fmt::format("{:.3g} %", 100.0 * d.false_alarm);
  const auto plural = [](std::size_t count) { return count > 1 ? "s" : ""; };
  switch (decision.reason) {
    case Reason::not_converged:
      return "the fit of the simulator's parameters did not converge, so nothing can be concluded from it";
    case Reason::error_of_inputs:
      return fmt::format(
          "the recordings show no noise, as simulated ones, and the simulator errs by {:.1f} % of the typical "
          "acceleration: so much comes from inputs that are known at the samples alone",
          100.0 * found.error_share);
    case Reason::interval:
      return fmt::format(
          "something acts in an interval that the {} does not know; by chance this would be seen in fewer than {} of "
          "campaigns",
          simulator, rate);
    case Reason::effect:
      return fmt::format(
          "accelerations as of '{}' remain that {} explains, and adding them predicts what was held out better",
          d.effects.front().name,
          findings.ensemble ? "neither the members' spread nor random model error"
                            : "no parameter within its uncertainty");
    case Reason::effect_not_heldout:
      return fmt::format(
          "accelerations as of '{}' remain, but adding them does not predict held-out parts better; more recordings "
          "would decide",
          d.effects.front().name);
    case Reason::close_to_rate:
      return fmt::format("the evidence is close to the stated rate of false alarms ({}); more recordings would decide",
                         rate);
    case Reason::small_intervals:
      return fmt::format(
          "what acts in {} interval{} is less than {:.0f} % of the typical acceleration: so much the form of the {}'s "
          "forces may make",
          found.small_intervals, plural(found.small_intervals), 100.0 * kPolicy.locate.small_share, simulator);
    case Reason::untrained_intervals:
      return fmt::format(
          "all significant mismatch lies in {} interval{} for which the ensemble was not trained; what it misses there "
          "may be nothing but that",
          found.untrained_intervals, plural(found.untrained_intervals));
    case Reason::too_few_samples:
      return fmt::format("{} measurements are too few to exclude anything; longer recordings would decide",
                         found.samples);
    case Reason::nothing_excited:
      return "the recordings excite none of the effects of the catalogue; longer or livelier maneuvers would";
    case Reason::far_parameters:
      return "coefficients had to move far beyond what is stated, and may hide something";
    case Reason::nothing_left:
      return fmt::format(
          "what remains is what {} and random model error leave, which is {:.0f} % of the typical acceleration",
          findings.ensemble ? "the members' spread" : "parameters within their uncertainty", 100.0 * found.error_share);
    case Reason::odds_not_rare:
      return "the tests see something, but no explanation has odds that are rare where nothing is missing; more "
             "recordings would decide";
    case Reason::likelier_than_not:
    case Reason::likelier_but_not_told_from_none:
    case Reason::likelier_but_not_heldout:
      return likeliest_of(hypotheses, decision, d.false_alarm);
  }
  return "";
}

}  // namespace

std::string reason_text(const Decision& decision, const TestsFound& found, const Findings& findings,
                        const std::vector<Explained>& hypotheses) {
  std::string text = sentence_of(decision, found, findings, hypotheses);
  text.front() = static_cast<char>(std::toupper(text.front()));
  return text + '.';
}

}  // namespace leeway::gap
