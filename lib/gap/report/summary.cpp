#include "gap/report/summary.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/units.hpp"
#include "gap/compare/terms.hpp"
#include "gap/policy/policy.hpp"
#include "gap/report/steps.hpp"
#include "gap/report/words.hpp"

namespace leeway::gap {
namespace {

constexpr std::size_t kLineWidth = kPolicy.report.line_width, kLabel = kPolicy.report.label_width;

// Characters, not bytes: UTF-8 continuation bytes do not count.
std::size_t length(std::string_view text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

// The first characters of a text, whole ones.
std::string_view head(std::string_view text, std::size_t characters) {
  std::size_t end = 0;
  while (end < text.size() && (characters > 0 || (text[end] & 0xC0) == 0x80)) {
    if ((text[end] & 0xC0) != 0x80) --characters;
    ++end;
  }
  return text.substr(0, end);
}

// Lines that leave room for the label; words longer than a line are cut.
std::vector<std::string> wrapped(std::string_view words) {
  constexpr std::size_t room = kLineWidth - kLabel;
  std::vector<std::string> lines(1);
  for (std::size_t begin = 0; begin < words.size();) {
    const std::size_t end = std::min(words.find_first_of(" \t\r\n", begin), words.size());
    const std::string_view one = words.substr(begin, end - begin);
    begin = end + 1;
    if (one.empty()) continue;
    if (!lines.back().empty() && length(lines.back()) + 1 + length(one) > room) lines.emplace_back();
    if (!lines.back().empty()) lines.back() += ' ';
    lines.back() += length(one) > room ? std::string(head(one, room - 3)) + "..." : std::string(one);
  }
  return lines;
}

/// Labeled paragraphs, wrapped and cut to their share of the screen.
class Screen {
 public:
  void item(std::string_view label, std::string_view words, std::size_t max_lines) {
    std::vector<std::string> lines = wrapped(words);
    if (lines.size() > max_lines) {
      lines.resize(max_lines);
      std::string& last = lines.back();
      if (length(last) > kLineWidth - kLabel - 4) {
        last = head(last, kLineWidth - kLabel - 4);
        last.resize(std::min(last.rfind(' '), last.size()));
      }
      last += " ...";
    }
    for (const std::string& line : lines) {
      text_ += fmt::format("{:<{}}{}\n", label, kLabel, line);
      label = "";
    }
  }
  /// A command, which stays on one line however long it is, so that it can be copied.
  void command(const std::string& line) { text_ += fmt::format("{:<{}}{}\n", "", kLabel, line); }
  std::string text() && { return std::move(text_); }

 private:
  std::string text_;
};

// As many of a list, up to n, as go into some lines together with what follows them, and how many more there are.
template <typename Items, typename Say>
std::string first_of(const Items& items, std::size_t n, std::size_t max_lines, const Say& say,
                     const std::string& after = "") {
  for (n = std::min(n, items.size());; --n) {
    std::string text;
    for (std::size_t i = 0; i < n; ++i) text += (i > 0 ? "; " : "") + std::string(say(items[i]));
    if (items.size() > n) text += fmt::format("; {} more", items.size() - n);
    text += after;
    if (n <= 1 || wrapped(text).size() <= max_lines) return text;
  }
}

std::string sensors(const Findings& findings) {
  const Audit& audit = findings.audit;
  if (!audit.faults.empty())
    return first_of(
        audit.faults, 3, 4, [](const Fault& f) { return f.sentence; },
        findings.corrected ? ". Taken out before what follows." : ". Still in the data: it spoils what follows.");
  if (audit.verdict() == Audit::Verdict::consistent)
    return "no sensor fault found: the recordings agree with themselves";
  return "not checked" + (audit.notices.empty() ? "" : ": " + audit.notices.front());
}

std::string model_error(const NullFit& fit, int axis) {
  const double scale = axis < 2 ? 1e3 : 1.0 / kDegree;
  return fmt::format("{} {} {}, {} of the typical acceleration", kAxisNames[static_cast<std::size_t>(axis)],
                     with_sd(fit.sigma_w(axis) * scale, fit.sigma_w_sd(axis) * scale), axis < 2 ? "mm/s^2" : "deg/s^2",
                     percent(fit.sigma_w(axis) / fit.typical(axis)));
}

// Where what is missing acts; with a name for it, what else goes with it says no more.
void add_where(Screen& screen, const Findings& findings, bool is_named) {
  const Located& located = findings.located;
  if (located.share.sum() > 0.0 && findings.verdict != Verdict::no_mismatch) {
    std::array<int, 3> axes{0, 1, 2};
    std::sort(axes.begin(), axes.end(), [&](int a, int b) { return located.share(a) > located.share(b); });
    std::vector<int> shown(axes.begin(), axes.end());
    std::erase_if(shown, [&](int a) { return located.share(a) < kPolicy.report.least_share; });
    screen.item("Direction",
                first_of(
                    shown, 3, 1,
                    [&](int a) {
                      return fmt::format("{} {}", kAxisNames[static_cast<std::size_t>(a)], percent(located.share(a)));
                    },
                    " of what is missing"),
                1);
  }
  if (const auto& line = located.line_of_action)
    screen.item("Acts at",
                fmt::format("{} ship lengths {} of midship{}", with_sd(std::abs(line->value), line->sd),
                            line->value < 0.0 ? "astern" : "ahead",
                            std::abs(line->value) > kPolicy.report.beyond_hull_L
                                ? " (beyond the hull: a turning moment more than a force)"
                                : ""),
                1);
  if (!located.intervals.empty())
    screen.item("When",
                first_of(located.intervals, 3, 3,
                         [](const Interval& i) {
                           return fmt::format("{} {:.4g} to {:.4g} s, {} ({}{})", i.recording, i.t_start_s, i.t_end_s,
                                              kAxisNames.at(static_cast<std::size_t>(i.axis)), p_value(i.p_value),
                                              i.is_untrained() ? fmt::format("; {}", kUntrained) : "");
                         }),
                3);
  if (is_named) return;
  if (!located.frames.empty() && located.frames.front().log_evidence > kPolicy.report.least_evidence)
    screen.item("Frame",
                fmt::format("what acts {}{}: this explains {} of it",
                            frame_meaning(located.frames.front().name).starts_with("fixed") ? "is " : "",
                            frame_meaning(located.frames.front().name), percent(located.frames.front().share)),
                1);
  std::vector<Regime> regimes = located.regimes;
  std::erase_if(regimes, [](const Regime& r) { return r.share < kPolicy.report.least_share; });
  if (!regimes.empty())
    screen.item("Goes with", first_of(regimes, 2, 3, [](const Regime& r) { return r.sentence; }), 3);
  if (!located.modules.empty() && located.modules.front().log_likelihood_gain > kPolicy.report.least_evidence)
    screen.item("Module",
                fmt::format("a {} force that may vary leaves {} of the model error", located.modules.front().module,
                            percent(located.modules.front().sigma_w_factor)),
                1);
}

std::string capitals(Verdict verdict) {
  std::string text{word(verdict)};
  std::transform(text.begin(), text.end(), text.begin(),
                 [](char c) { return c == '-' ? ' ' : static_cast<char>(c >= 'a' && c <= 'z' ? c - 'a' + 'A' : c); });
  return text;
}

void add_sensors(Screen& screen, const Findings& findings) {
  if (!findings.conventions.contradicted.empty())
    screen.item("Conventions",
                first_of(
                    findings.conventions.contradicted, 2, 3, [](const Reading& r) { return r.sentence; },
                    findings.corrected ? ". Read so in what follows." : ". Not read so: it spoils what follows."),
                3);
  else if (!findings.conventions.tested.empty())
    screen.item("Conventions", "no unit or sign error found", 1);
  screen.item("Sensors", sensors(findings), 4);
}

void add_parameters(Screen& screen, const std::vector<ParameterShift>& parameters) {
  std::vector<ParameterShift> moved;
  for (const ParameterShift& p : parameters) {
    const double by_sd = p.difference ? std::abs(p.difference->estimate) / p.difference->sd
                                      : std::abs(std::log(p.factor)) * p.factor / p.factor_sd;
    if (std::abs(p.shift_sd) > kPolicy.report.shifted_sd && by_sd > kPolicy.report.shifted_sd) moved.push_back(p);
  }
  std::stable_sort(moved.begin(), moved.end(), [](const ParameterShift& a, const ParameterShift& b) {
    return std::abs(a.shift_sd) > std::abs(b.shift_sd);
  });
  if (!moved.empty())
    screen.item("Parameters",
                first_of(
                    moved, 4, 2,
                    [](const ParameterShift& p) {
                      if (p.difference)
                        return fmt::format("{} {:+.2g} ({:+.1f} sd)", p.name, p.difference->estimate, p.shift_sd);
                      return fmt::format("{} x {:.2f} ({:+.1f} sd)", p.name, p.factor, p.shift_sd);
                    },
                    " off: they may stand in for missing physics"),
                2);
}

void add_steps(Screen& screen, const std::vector<Step>& steps) {
  for (const Step& step : steps) {
    if (!step.text.empty()) screen.item(step.label, step.text, 5);
    if (!step.command.empty()) screen.command(step.command);
  }
}

void add_ship_file(Screen& screen, const Explanation& explanation) {
  const ShipFile& file = explanation.ship_file;
  screen.item("Ship file", file.sentence, 10);
  if (file.state == ShipFileState::off && file.heldout_gain > 0.0)
    screen.item(
        "", fmt::format("With all coefficients fitted it {}", gain_words(file.heldout_gain, file.heldout_gain_sd)), 2);
  if (const auto& beyond = explanation.beyond_recorded)
    screen.item(
        "",
        fmt::format(
            "Warning: fitted to rudder angles up to {:.0f} deg. At {:.0f} deg in still water ship.json turns with "
            "a tactical diameter of {} ship lengths (95 %, if the forms of its forces hold there)",
            beyond->recorded_deg, beyond->rudder_deg, between(beyond->low_L, beyond->high_L)),
        3);
}

// "0.91 +- 0.05 (0.81 to 1.01 with 95 %)"; where it differs between recordings, of each of them in one line. Empty for
// what another one tells: the mean of those, or a further one.
std::string value_of(const ExplainedParameter& p, const Explained& what) {
  const auto told = [](const ExplainedParameter& one) {
    return fmt::format("{} ({} with 95 %){}", with_sd(one.estimate, one.sd), between(one.low, one.high),
                       one.is_at_bound ? ": at the bound of what is possible" : "");
  };
  std::vector<const ExplainedParameter*> differing;
  for (const ExplainedParameter& other : what.parameters)
    if (!other.recording.empty() && other.effect == p.effect && other.name == p.name) differing.push_back(&other);
  if (differing.empty()) return told(p);
  if (differing.front() != &p) return "";
  std::vector<std::string> values;
  values.reserve(differing.size());
  for (const ExplainedParameter* one : differing) values.push_back(told(*one) + " in " + one->recording);
  return fmt::format("{}", fmt::join(values, "; "));
}

void add_answer(Screen& screen, const Explanation& explanation, const Explained* what) {
  if (what != nullptr) {
    screen.item("What",
                fmt::format("{} (probability {:.2f}{})", what->sentence, what->probability,
                            what->converged ? "" : "; its fit has not converged"),
                6);
    for (const ExplainedParameter& p : what->parameters)
      if (const std::string value = value_of(p, *what); !value.empty())
        screen.item("", fmt::format("{} = {}", p.name, value), 4);
    if (!what->confusable_with.empty())
      screen.item("Confusable",
                  fmt::format("{}; what would distinguish them: {}", fmt::join(what->confusable_with, ", "),
                              what->separating_maneuver),
                  3);
  }
  // The next likely one, and all others together.
  const Explained *nothing = nullptr, *second = nullptr;
  double others = 1.0;  // effects that were not fitted have their share
  for (const Explained& other : explanation.hypotheses) {
    if (what == nullptr && other.effects.empty()) nothing = &other;
    if (&other == what || &other == nothing)
      others -= other.probability;
    else if (second == nullptr)
      second = &other;
  }
  if (second == nullptr || others < kPolicy.show.possible) return;
  const Explained* best = nothing != nullptr ? nothing : what;
  const bool is_apart = best == nullptr || second->probability > kPolicy.show.not_excluded * best->probability;
  const double rest = is_apart ? others - second->probability : others;
  std::vector<std::string> told;
  if (nothing != nullptr) told.push_back(fmt::format("nothing missing {:.2f}", nothing->probability));
  if (is_apart)
    told.push_back(fmt::format("{} {:.2f}{}", second->effects.empty() ? "nothing missing" : second->name,
                               second->probability, second->converged ? "" : " (its fit has not converged)"));
  if (rest > kPolicy.show.possible)
    told.push_back(
        fmt::format("all {} {:.2f}, none of them likely by itself", is_apart ? "others" : "other effects", rest));
  screen.item(what == nullptr ? "Probability" : "Or else", fmt::format("{}", fmt::join(told, "; ")), 2);
}

// What probabilities are worth, by campaigns whose truth is known.
void add_bootstrap(Screen& screen, const Bootstrap& bootstrap) {
  std::size_t right = 0;
  double stated = 0.0;
  for (const SimulatedAnswer& one : bootstrap.campaigns) {
    right += one.truth_is_first ? 1 : 0;
    stated += one.stated_of_first / static_cast<double>(bootstrap.campaigns.size());
  }
  screen.item("Thorough",
              fmt::format("of {} campaigns simulated like this one and analyzed again the likeliest was right in {}, "
                          "stated at {:.2f} on average: the probabilities above are corrected by that{}",
                          bootstrap.campaigns.size(), right, stated,
                          bootstrap.failed > 0 ? fmt::format(" ({} more failed)", bootstrap.failed) : ""),
              3);
}

void add_learned(Screen& screen, const Explanation& explanation) {
  if (std::isnan(explanation.log_error_with_network)) return;
  const double fall = 1.0 - std::exp(explanation.log_error_with_network - explanation.log_error_without_network);
  screen.item("Learned",
              explanation.residual_network != nullptr
                  ? fmt::format("what is left, by a network in ship.json that is zero beyond what was recorded: errors "
                                "fall by {}",
                                percent(fall))
                  : "a network for what is left predicts unseen data no better: none is in ship.json",
              2);
}

void add_errors(Screen& screen, const Explanation& explanation) {
  if (!changes_ship(explanation)) return;
  const auto runs = [](const Scores& scores) {
    const auto found = scores.free_runs.find(kShownHorizon_s);
    return found == scores.free_runs.end() ? Score{} : found->second;
  };
  const Score before = runs(explanation.heldout.before), after = runs(explanation.heldout.after);
  std::vector<std::string> told;
  const auto add = [&](const char* what, double from, double to, const char* unit) {
    if (!std::isnan(from) && !std::isnan(to))
      told.push_back(fmt::format("{} {:.2g} -> {:.2g} {}", what, from, to, unit));
  };
  add("u", before.rmse_u_mps, after.rmse_u_mps, "m/s");
  add("v_m", before.rmse_vm_mps, after.rmse_vm_mps, "m/s");
  add("r", before.rmse_r_degps, after.rmse_r_degps, "deg/s");
  add("position", before.rmse_position_m, after.rmse_position_m, "m");
  const std::string fall = fall_of_errors(explanation.heldout);
  screen.item("Held out",
              fmt::format("errors of free runs over {} s {}: {}", kShownHorizon_s,
                          fall.empty() ? "do not all fall" : "fall " + fall, fmt::join(told, ", ")),
              3);
  if (!explanation.effects.empty())
    screen.item("",
                fmt::format("what was named {}{}", gain_words(explanation.heldout_gain, explanation.heldout_gain_sd),
                            explanation.heldout_is_given ? ", of the fitted recordings in turn" : ""),
                2);
}

}  // namespace

std::string summary(const Findings& findings) {
  const Detection& detection = findings.detection;
  Screen screen;
  screen.item("Verdict",
              fmt::format("{} ({}). {} {}", capitals(findings.verdict), p_value(detection.p_value), headline(findings),
                          detection.reason),
              4);
  add_sensors(screen, findings);

  for (int axis = 0; axis < 3; ++axis) screen.item(axis == 0 ? "Model error" : "", model_error(findings.fit, axis), 1);

  add_where(screen, findings, false);
  add_parameters(screen, findings.fit.parameters);

  const auto same = [](const std::string& s) -> const std::string& { return s; };
  std::vector<std::string> unknown;
  if (!findings.fit.converged) unknown.push_back("the fit has not converged");
  unknown.insert(unknown.end(), findings.notices.begin(), findings.notices.end());
  unknown.insert(unknown.end(), findings.conventions.unchecked.begin(), findings.conventions.unchecked.end());
  if (findings.audit.verdict() != Audit::Verdict::unchecked)
    unknown.insert(unknown.end(), findings.audit.notices.begin(), findings.audit.notices.end());
  if (!unknown.empty()) screen.item("Note", first_of(unknown, 3, 3, same), 3);
  add_steps(screen, steps(findings));
  return std::move(screen).text();
}

std::string summary(const Explanation& explanation) {
  const Findings& findings = explanation.findings;
  Screen screen;
  screen.item(
      "Verdict",
      fmt::format("{} ({}). {}",
                  explanation.verdict == Verdict::no_mismatch && explanation.ship_file.state == ShipFileState::off
                      ? "SHIP FILE OFF"
                      : capitals(explanation.verdict),
                  p_value(explanation.p_value), headline(explanation)),
      8);
  add_sensors(screen, findings);
  if (explanation.verdict == Verdict::mismatch)
    add_where(screen, findings, explanation.is_complete && !has_terms(explanation.chosen));
  const Explained* what = chosen_of(explanation);
  add_answer(screen, explanation, what);
  if (explanation.bootstrap) add_bootstrap(screen, *explanation.bootstrap);
  add_learned(screen, explanation);
  add_ship_file(screen, explanation);
  add_errors(screen, explanation);
  if (!explanation.notices.empty())
    screen.item("Note",
                first_of(explanation.notices, 3, 3, [](const std::string& s) -> const std::string& { return s; }), 3);
  add_steps(screen, steps(explanation));
  return std::move(screen).text();
}

}  // namespace leeway::gap
