#include "gap/report/steps.hpp"

#include <algorithm>
#include <iterator>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "effects/description.hpp"
#include "gap/compare/terms.hpp"
#include "gap/report/words.hpp"
#include "gap/show/next_maneuver.hpp"

namespace leeway::gap {

bool changes_ship(const Explanation& explanation) {
  return !explanation.effects.empty() || !explanation.coefficient_factors.empty() ||
         explanation.residual_network != nullptr;
}

namespace {

std::string next_step(const Findings& findings) {
  if (!findings.conventions.contradicted.empty())
    return "correct signs, units and frames first (a columns map, or the recorder's manual), then run again";
  if (!findings.audit.faults.empty() && !findings.corrected) return "repair or correct the sensors, then run again";
  if (findings.grossly_inconsistent && findings.verdict != Verdict::no_mismatch)
    return "check that these are recordings of this ship, at this scale and draft; then gap-explain";
  if (!findings.fit.converged)
    return "the fit has not converged: do not rely on the above; check the ship's particulars and the recordings";
  if (findings.verdict == Verdict::undecided && !findings.located.intervals.empty() &&
      findings.located.intervals.front().is_untrained())
    return "train the ensemble with maneuvers like those of the intervals above; locate.json says which inputs";
  switch (findings.verdict) {
    case Verdict::mismatch:
      return "name what is missing with gap-explain; report.html shows when and where";
    case Verdict::no_mismatch:
      return "nothing is missing on this evidence; gap-explain says whether the ship file's coefficients are right";
    case Verdict::undecided:
      break;
  }
  return "more recordings: other headings, speeds and maneuvers than these";
}

std::string without_slash(std::string folder) {
  while (folder.size() > 1 && folder.ends_with('/')) folder.pop_back();
  return folder;
}

// What names what is missing, with the recordings of this call.
std::string gap_explain_command(const Findings& findings) {
  const Called& called = findings.called;
  if (called.ship.empty() || findings.verdict != Verdict::mismatch || findings.ensemble) return "";
  return fmt::format("gap-explain --ship {} {} -o {}", called.ship, called.recordings,
                     shell_word(without_slash(called.output) + "-explained"));
}

// What to record next.
std::string next_recording(const Explanation& explanation) {
  const Recommended which = recommended(explanation.next, explanation.p_right);
  const NextManeuver& best = explanation.next[which.place];
  const std::string now = fmt::format("{:.2f}", explanation.p_right), then = fmt::format("{:.2f}", best.p_right);
  if (which.is_worthwhile)
    return fmt::format("record {} ({:.0f} s): the probability of the right name rises from {} to {}", best.name,
                       best.duration_s, now, then);
  return fmt::format(
      "more recordings: no single maneuver of the menu would decide (probability of the right name {}; {} after {})",
      now, then, best.name);
}

// What would have told effects of the surroundings, each once.
std::string to_record(const std::vector<std::string>& names) {
  std::vector<std::string_view> told;
  for (const std::string& name : names)
    if (const std::string_view what = effect_named(name).info.to_record;
        !what.empty() && std::find(told.begin(), told.end(), what) == told.end())
      told.push_back(what);
  return told.empty() ? "" : fmt::format(". In later runs record {}", fmt::join(told, ", and "));
}

// Of effects that were named: what came from outside is apart from what happened to the ship.
std::string advice_on(const std::vector<std::string>& named, const Explanation& explanation) {
  std::vector<std::string> outside;
  std::copy_if(named.begin(), named.end(), std::back_inserter(outside),
               [](const std::string& name) { return find_effect(name) && effect_named(name).info.is_of_surroundings; });
  const bool is_once = std::all_of(named.begin(), named.end(), [](const std::string& name) {
    return find_effect(name) && effect_named(name).info.bound_to == BoundTo::time;
  });
  if (outside.size() == named.size() && is_once)
    return "the ship file can stay: what acted came from outside. Leave that time out, or find out what it was" +
           to_record(outside);
  if (outside.size() == named.size())
    return fmt::format("the ship file can stay: what acted came from outside{}{}",
                       explanation.effects.empty() ? "" : ", and ship.json has it for such conditions",
                       to_record(outside));
  if (outside.empty()) return "use ship.json as long as the ship is so; with the cause mended, the ship file";
  return "use ship.json as long as the ship is so and where the same comes from outside: it has both. With the cause "
         "mended, or elsewhere, take that effect out of ship.json" +
         to_record(outside);
}

// Whether the fitted coefficients can be used as they are.
bool is_usable_calibration(const Explanation& explanation) {
  return explanation.calibration->helps && explanation.verdict != Verdict::mismatch &&
         explanation.ship_file.state != ShipFileState::cannot_tell;
}

std::string advice_on_calibration(const Explanation& explanation) {
  if (explanation.verdict == Verdict::mismatch)
    return "ask first what else is missing: gap-explain without --calibrate, with the same recordings";
  if (!explanation.calibration->helps)
    return "keep the ship file: with ship.json what was not fitted is not followed better, beyond chance";
  return is_usable_calibration(explanation)
             ? "use ship.json within the speeds, revolutions and rudder angles that were recorded"
             : "record more before ship.json is used: other headings, speeds and maneuvers than these";
}

// What somebody who has read no more than this should do.
std::string advice(const Explanation& explanation) {
  const Findings& findings = explanation.findings;
  if (!findings.conventions.contradicted.empty())
    return "correct signs, units and frames as said above (a columns map, or the recorder's manual), then run again";
  if (!findings.audit.faults.empty())
    return findings.corrected ? "repair the sensor, or correct its recordings as said above, and run again; the ship "
                                "file was compared with them corrected"
                              : "repair or correct the sensors, then run again";
  if (explanation.calibration) return advice_on_calibration(explanation);
  std::vector<std::string> named = explanation.chosen;
  std::erase(named, name_of_terms());
  const bool is_unknown = has_terms(explanation.chosen);
  if (!named.empty() && !is_unknown) return advice_on(named, explanation);
  const bool is_off = explanation.ship_file.state == ShipFileState::off;
  const bool is_better = !fall_of_errors(explanation.heldout).empty();
  if (is_unknown)
    return fmt::format(
        "{}, and do not trust it where this acts: report.html shows when and with what it goes. Record "
        "the same maneuvers again, and look there for what the catalogue does not hold",
        changes_ship(explanation) && is_better ? "use ship.json, which errs less, in place of the ship "
                                                 "file"
                                               : "keep the ship file");
  const bool has_cause = std::any_of(explanation.ship_file.findings.begin(), explanation.ship_file.findings.end(),
                                     [](const ShipFileFinding& f) { return !f.cause.empty(); });
  if (is_off && !explanation.coefficient_factors.empty())
    return fmt::format("use ship.json, whose coefficients were fitted, in place of the ship file{}",
                       has_cause ? "; and look at the ship: what is said to do the same would be a cause to mend" : "");
  if (is_off) return "check the coefficients named above in the ship file";
  if (explanation.verdict == Verdict::no_mismatch && explanation.ship_file.state == ShipFileState::as_stated)
    return "use the ship file as it is";
  return "record more before anything is changed: other headings, speeds and maneuvers than these";
}

// That a single recording has nobody to check it.
std::string check_of_one(const Explanation& explanation) {
  const bool is_one = explanation.findings.residuals.size() == 1 && !explanation.heldout_is_given;
  return is_one && (explanation.verdict == Verdict::mismatch || explanation.calibration)
             ? ". First record another run on another heading: one recording alone checks nothing of this"
             : "";
}

// What to record next; empty where nothing would tell more.
std::string next_step(const Explanation& explanation, const Explained* what) {
  const Findings& findings = explanation.findings;
  if (!findings.conventions.contradicted.empty()) return "";
  if (!findings.audit.faults.empty())
    return findings.corrected && what != nullptr && !what->confusable_with.empty() && !what->separating_maneuver.empty()
               ? "record " + what->separating_maneuver
               : "";
  return explanation.next.empty() ? "" : next_recording(explanation);
}

// ship.json, where it differs from the ship as it was and errs less, in a command that runs as it stands.
std::string use_of_ship(const Explanation& explanation) {
  const Called& called = explanation.findings.called;
  if (called.ship.empty() || !changes_ship(explanation)) return "";
  if (explanation.calibration && !is_usable_calibration(explanation)) return "";
  if (has_terms(explanation.chosen) && fall_of_errors(explanation.heldout).empty()) return "";
  return fmt::format("mmg-sim zigzag --ship {} --rudder-deg 10 --heading-deg 10{} -o zigzag.csv",
                     shell_word(without_slash(called.output) + "/ship.json"),
                     explanation.n_rps ? fmt::format(" --n-p-rps {:.4g}", *explanation.n_rps) : "");
}

// The maneuver to record, likewise.
std::string plan(const Explanation& explanation) {
  const Called& called = explanation.findings.called;
  if (called.ship.empty() || explanation.next.empty()) return "";
  const Recommended which = recommended(explanation.next, explanation.p_right);
  return which.is_worthwhile ? fmt::format("mmg-sim {} --ship {} -o planned.csv   # what to expect of it",
                                           explanation.next[which.place].command, called.ship)
                             : "";
}

}  // namespace

std::vector<Step> steps(const Findings& findings) {
  return {{"Next", next_step(findings), gap_explain_command(findings)}};
}

std::vector<Step> steps(const Explanation& explanation) {
  const std::string next = next_step(explanation, chosen_of(explanation));
  return {{"Do", advice(explanation) + check_of_one(explanation), use_of_ship(explanation)},
          {"Next", next, next.empty() ? "" : plan(explanation)}};
}

}  // namespace leeway::gap
