#include "gap/report/words.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "effects/description.hpp"
#include "gap/compare/terms.hpp"
#include "gap/decide/found.hpp"
#include "gap/result/phrases.hpp"

namespace leeway::gap {

bool differ_by_recording(const std::vector<std::string>& effects, const Explanation& explanation) {
  const Explained* what = chosen_of(explanation);
  return what != nullptr && std::ranges::any_of(effects, [&](const std::string& name) {
           return recordings_with(name, what->parameters).size() > 1;
         });
}

const Explained* chosen_of(const Explanation& explanation) {
  for (const Explained& hypothesis : explanation.hypotheses)
    if (hypothesis.is_chosen) return &hypothesis;
  return nullptr;
}

const LatentForce* unknown_kind(const Explanation& explanation) {
  return has_terms(explanation.chosen) && !explanation.unknown_kinds.empty() ? &explanation.unknown_kinds.front()
                                                                             : nullptr;
}

std::string_view word(Verdict verdict) {
  switch (verdict) {
    case Verdict::mismatch:
      return "mismatch";
    case Verdict::no_mismatch:
      return "no-mismatch";
    case Verdict::undecided:
      break;
  }
  return "undecided";
}

std::string headline(const Findings& findings) {
  const std::string ship = findings.ship.empty() ? "the ship" : findings.ship;
  const std::string simulator = findings.ensemble ? "ensemble " + findings.ensemble->name : "simulator of " + ship;
  if (findings.grossly_inconsistent && findings.verdict != Verdict::no_mismatch)
    return fmt::format(
        "The recordings are far from the simulator of {}: another ship, scale or draft, or several things left out at "
        "once.",
        ship);
  switch (findings.verdict) {
    case Verdict::mismatch:
      return fmt::format("The {} and the recordings differ by more than noise and {}.", simulator,
                         findings.ensemble ? "the members' spread" : "stated uncertainty");
    case Verdict::no_mismatch:
      return fmt::format("The recordings agree with the {} within noise and {}.", simulator,
                         findings.ensemble ? "the members' spread" : "stated uncertainty");
    case Verdict::undecided:
      break;
  }
  return fmt::format("These recordings do not decide whether the {} lacks something.", simulator);
}

namespace {

// What was named of sensors and readings, then of the forces, each as a clause.
std::vector<std::string> clauses_of(const Explanation& explanation) {
  std::vector<std::string> clauses;
  for (const Reading& reading : explanation.findings.conventions.contradicted)
    clauses.push_back(fmt::format("a wrong reading ({})", reading.claim()));
  const Explained* what = chosen_of(explanation);
  // With the numbers that it has beside what is named.
  const auto fault_of = [&](const std::string& name) -> std::optional<std::string> {
    const auto fault = std::ranges::find(explanation.findings.audit.faults, name, &Fault::name);
    if (fault == explanation.findings.audit.faults.end()) return std::nullopt;
    if (what != nullptr)
      if (const auto said = std::ranges::find(what->said, name, &Said::name); said != what->said.end())
        return said->sentence;
    return fault->sentence;
  };
  for (const std::string& name : explanation.chosen) {
    if (name == "convention" || name == name_of_terms()) continue;
    const std::optional<std::string> fault = fault_of(name);
    clauses.push_back(fault             ? "a sensor fault (" + *fault + ")"
                      : what != nullptr ? phrase(name, what->parameters)
                                        : name);
  }
  return clauses;
}

// ": a turning moment ...", where the catalogue does not hold what acts.
std::string kind_of_unknown(const Explanation& explanation) {
  const LatentForce* kind = unknown_kind(explanation);
  return kind != nullptr ? ": " + phrase(*kind) : "";
}

// A sentence as the end of another one.
std::string as_clause(std::string sentence) {
  if (sentence.ends_with('.')) sentence.pop_back();
  if (sentence.size() > 1 && std::islower(static_cast<unsigned char>(sentence[1])) != 0)
    sentence.front() = static_cast<char>(std::tolower(static_cast<unsigned char>(sentence.front())));
  return sentence;
}

std::string physics_of(const Explanation& explanation) {
  switch (explanation.verdict) {
    case Verdict::no_mismatch:
      return "No missing physics";
    case Verdict::undecided:
      return "Cannot tell whether physics is missing" +
             (explanation.reason.empty() ? "" : ": " + as_clause(explanation.reason));
    case Verdict::mismatch:
      break;
  }
  const std::vector<std::string> clauses = clauses_of(explanation);
  if (clauses.empty()) return "Something acts that the catalogue does not hold" + kind_of_unknown(explanation);
  const bool are_many = clauses.size() > 1 || differ_by_recording(explanation.chosen, explanation);
  return fmt::format(
      "{} explain{} the difference{}", capitalized(fmt::format("{}", fmt::join(clauses, " and "))), are_many ? "" : "s",
      has_terms(explanation.chosen) ? " in part; the rest is not in the catalogue" + kind_of_unknown(explanation) : "");
}

// The findings on the ship file that matter most.
std::string findings_of(const Explanation& explanation) {
  const std::vector<ShipFileFinding>& findings = explanation.ship_file.findings;
  if (findings.empty()) return "several coefficients, none of them by itself";
  std::vector<std::string> told;
  for (const ShipFileFinding& finding : findings)
    if (told.size() < kPolicy.report.most_findings) told.push_back(finding.sentence);
  return fmt::format("{}{}", fmt::join(told, "; "),
                     findings.size() > told.size() ? fmt::format("; {} more", findings.size() - told.size()) : "");
}

std::string file_is_off(const Explanation& explanation) {
  std::string text = "the ship file is off: " + findings_of(explanation);
  const std::string fall = fall_of_errors(explanation.heldout);
  if (!explanation.coefficient_factors.empty() && !fall.empty())
    text += fmt::format("; with ship.json errors fall {}", fall);
  return text;
}

}  // namespace

std::string fall_of_errors(const BeforeAfter& fit) {
  const auto runs = [](const Scores& scores) {
    const auto found = scores.free_runs.find(kShownHorizon_s);
    return found == scores.free_runs.end() ? Score{} : found->second;
  };
  const Score before = runs(fit.before), after = runs(fit.after);
  double least = kMissing, most = kMissing;
  for (const double Score::*of :
       {&Score::rmse_u_mps, &Score::rmse_vm_mps, &Score::rmse_r_degps, &Score::rmse_position_m}) {
    const double times = before.*of / after.*of;
    if (!std::isfinite(times)) continue;
    least = std::fmin(least, times);
    most = std::fmax(most, times);
  }
  if (!(least > 1.0)) return "";
  if (least < kPolicy.report.told_as_times && most >= kPolicy.report.told_as_times)
    return fmt::format("up to {:.0f} times", most);
  if (least < kPolicy.report.told_as_times) {
    const double low = std::round(100.0 * (1.0 - 1.0 / least)), high = std::round(100.0 * (1.0 - 1.0 / most));
    if (high < 1.0) return "";
    return low == high ? fmt::format("by {:.0f} %", low) : fmt::format("by {:.0f} to {:.0f} %", low, high);
  }
  const double low = std::round(least), high = std::round(most);
  return low == high ? fmt::format("{:.0f} times", low) : fmt::format("{:.0f} to {:.0f} times", low, high);
}

std::string gain_words(double gain, double sd) {
  return fmt::format("predicts unseen data {} by {} (log-likelihood)", gain < 0.0 ? "worse" : "better",
                     with_sd(std::abs(gain), sd));
}

namespace {

// Of coefficients alone that were asked for.
std::string headline_of_calibration(const Explanation& explanation) {
  const std::string fall = fall_of_errors(explanation.heldout);
  const char* what = explanation.heldout_is_given ? "held out" : "left out in turn";
  std::string text = fmt::format("The coefficients were fitted: what was {} is ", what);
  if (!explanation.calibration->helps)
    text += "not followed better with them, beyond chance";
  else
    text += fall.empty() ? "followed better with them" : "followed better with them: errors of free runs fall " + fall;
  const std::vector<std::string> clauses = clauses_of(explanation);
  if (!clauses.empty()) return fmt::format("{}. Besides, there is {}.", text, fmt::join(clauses, " and "));
  switch (explanation.verdict) {
    case Verdict::mismatch:
      return "Something other than the coefficients is missing: gap-explain without --calibrate asks what. " + text +
             '.';
    case Verdict::no_mismatch:
      return text + ". Nothing else is missing that these recordings could show.";
    case Verdict::undecided:
      break;
  }
  return text + ". Whether something else is missing these recordings do not decide.";
}

}  // namespace

std::string headline(const Explanation& explanation) {
  if (explanation.calibration) return headline_of_calibration(explanation);
  const bool is_off = explanation.ship_file.state == ShipFileState::off;
  const std::string physics = physics_of(explanation);
  const bool is_from_one = explanation.findings.residuals.size() == 1 && !explanation.heldout_is_given &&
                           explanation.verdict == Verdict::mismatch;
  const char* unchecked = is_from_one ? " From one recording alone: nothing else checks this." : "";
  if (explanation.verdict == Verdict::mismatch && clauses_of(explanation).empty() && is_off &&
      !fall_of_errors(explanation.heldout).empty())
    return fmt::format(
        "{}. Beside that, {} of the typical acceleration is left, which no effect of the catalogue explains.{}",
        capitalized(file_is_off(explanation)), percent(error_share(explanation.findings.fit)), unchecked);
  if (explanation.verdict == Verdict::mismatch && clauses_of(explanation).empty() && is_off)
    return fmt::format("{}; what the fit changed of the ship file may stand for it ({}).{}", physics,
                       findings_of(explanation), unchecked);
  if (is_off)
    return fmt::format("{}{} {}.{}", physics, explanation.verdict == Verdict::mismatch ? ". Besides," : ";",
                       file_is_off(explanation), unchecked);
  if (explanation.verdict == Verdict::mismatch) return physics + '.' + unchecked;
  if (explanation.verdict == Verdict::undecided) return physics + '.';
  return explanation.ship_file.state == ShipFileState::as_stated
             ? physics + "; the ship file agrees with the recordings."
             : physics + " that these recordings could show; they are too little to judge the ship file.";
}

std::string frame_meaning(const std::string& name) {
  static constexpr std::pair<std::string_view, std::string_view> kMeanings[] = {
      {"body", "fixed to the ship"},
      {"earth", "fixed to the earth"},
      {"apparent-wind", "follows the apparent wind"},
      {"water-speed", "follows the speed through the water"},
      {"position", "belongs to the place"},
      {"actuator", "follows rudder, propeller or thruster"},
  };
  for (const auto& [known, meaning] : kMeanings)
    if (name == known) return std::string(meaning);
  return name;
}

}  // namespace leeway::gap
