#include "gap/report/summary.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/units.hpp"
#include "gap/policy/policy.hpp"
#include "gap/report/words.hpp"
#include "gap/show/next_maneuver.hpp"

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
  if (audit.verdict() == Audit::Verdict::consistent) return "the recordings agree with themselves";
  return "not checked" + (audit.notices.empty() ? "" : ": " + audit.notices.front());
}

std::string model_error(const NullFit& fit, int axis) {
  const double scale = axis < 2 ? 1e3 : 1.0 / kDegree;
  return fmt::format("{} {} {}, {} of the typical acceleration", kAxisNames[static_cast<std::size_t>(axis)],
                     with_sd(fit.sigma_w(axis) * scale, fit.sigma_w_sd(axis) * scale), axis < 2 ? "mm/s^2" : "deg/s^2",
                     percent(fit.sigma_w(axis) / fit.typical(axis)));
}

void add_where(Screen& screen, const Findings& findings) {
  const Located& located = findings.located;
  if (located.share.sum() > 0.0 && findings.verdict != Verdict::no_mismatch) {
    std::array<int, 3> axes{0, 1, 2};
    std::sort(axes.begin(), axes.end(), [&](int a, int b) { return located.share(a) > located.share(b); });
    screen.item("Direction",
                first_of(
                    axes, 3, 1,
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
  if (!located.frames.empty() && located.frames.front().log_evidence > kPolicy.report.least_evidence)
    screen.item("Steady in",
                fmt::format("the force {}: this explains {} of it", frame_meaning(located.frames.front().name),
                            percent(located.frames.front().share)),
                1);
  if (!located.regimes.empty())
    screen.item("Goes with", first_of(located.regimes, 2, 3, [](const Regime& r) { return r.sentence; }), 3);
  if (!located.modules.empty() && located.modules.front().log_likelihood_gain > kPolicy.report.least_evidence)
    screen.item("Module",
                fmt::format("a {} force that may vary leaves {} of the model error", located.modules.front().module,
                            percent(located.modules.front().sigma_w_factor)),
                1);
}

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
      return "gap-explain, to name what is missing; report.html shows when and where";
    case Verdict::no_mismatch:
      return "nothing to add to the model on this evidence; the model error above is what remains";
    case Verdict::undecided:
      break;
  }
  return "more recordings: other headings, speeds and maneuvers than these";
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
    screen.item("Conventions", "signs, units and frames read as stated fit best", 1);
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

std::string next_step(const Explanation& explanation, const Explained* what) {
  const Findings& findings = explanation.findings;
  if (!findings.conventions.contradicted.empty()) return next_step(findings);
  if (!findings.audit.faults.empty())
    return findings.corrected && what != nullptr && !what->confusable_with.empty()
               ? "record " + what->separating_maneuver
               : next_step(findings);
  if (!explanation.next.empty()) {
    const Recommended which = recommended(explanation.next, explanation.p_right);
    const NextManeuver& best = explanation.next[which.place];
    if (which.is_worthwhile)
      return fmt::format("record {} ({:.0f} s; mmg-sim {}): probability of the right name {:.2f} -> {:.2f}", best.name,
                         best.duration_s, best.command, explanation.p_right, best.p_right);
    return fmt::format(
        "more recordings: no single maneuver of the menu would decide (probability of the right name {:.2f} -> {:.2f} "
        "at best, by {})",
        explanation.p_right, best.p_right, best.name);
  }
  if (explanation.verdict == Verdict::no_mismatch) return next_step(findings);
  if (what == nullptr)
    return explanation.verdict == Verdict::mismatch
               ? "report.html shows when and where; what is not in the catalogue has to be thought of"
               : "more recordings: other headings, speeds and maneuvers than these";
  return "mmg-sim --ship ship.json runs the simulator with what was missing";
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

  add_where(screen, findings);
  add_parameters(screen, findings.fit.parameters);

  const auto same = [](const std::string& s) -> const std::string& { return s; };
  std::vector<std::string> unknown;
  if (!findings.fit.converged) unknown.push_back("the fit has not converged");
  unknown.insert(unknown.end(), findings.notices.begin(), findings.notices.end());
  unknown.insert(unknown.end(), findings.conventions.unchecked.begin(), findings.conventions.unchecked.end());
  if (findings.audit.verdict() != Audit::Verdict::unchecked)
    unknown.insert(unknown.end(), findings.audit.notices.begin(), findings.audit.notices.end());
  if (!unknown.empty()) screen.item("Note", first_of(unknown, 3, 3, same), 3);
  screen.item("Next", next_step(findings), 2);
  return std::move(screen).text();
}

std::string summary(const Explanation& explanation) {
  const Findings& findings = explanation.findings;
  Screen screen;
  screen.item(
      "Verdict",
      fmt::format("{} ({}). {}", capitals(explanation.verdict), p_value(explanation.p_value), headline(explanation)),
      3);
  add_sensors(screen, findings);
  if (explanation.verdict != Verdict::no_mismatch) add_where(screen, findings);
  const auto chosen = std::find_if(explanation.hypotheses.begin(), explanation.hypotheses.end(),
                                   [](const Explained& hypothesis) { return hypothesis.is_chosen; });
  const Explained* what = chosen == explanation.hypotheses.end() ? nullptr : &*chosen;
  if (what != nullptr) {
    screen.item("What", fmt::format("{}, probability {:.2f}. {}", what->name, what->probability, what->sentence), 3);
    for (const ExplainedParameter& p : what->parameters)
      screen.item("", fmt::format("{} = {} ({} with 95 %)", p.name, with_sd(p.estimate, p.sd), between(p.low, p.high)),
                  1);
    if (!what->confusable_with.empty())
      screen.item("Or else",
                  fmt::format("{}; what would distinguish them: {}", fmt::join(what->confusable_with, ", "),
                              what->separating_maneuver),
                  3);
  }
  for (const Explained& other : explanation.hypotheses)
    if (&other != what && !other.effects.empty() && (what == nullptr || other.name != what->name)) {
      screen.item("Runner-up", fmt::format("{}, probability {:.2g}", other.name, other.probability), 1);
      break;
    }
  if (!std::isnan(explanation.log_error_with_network))
    screen.item(
        "Learned",
        explanation.residual_network != nullptr
            ? fmt::format("a network in ship.json, zero outside of what was recorded: free runs over what is "
                          "left out in turn err {} as much as without it",
                          percent(std::exp(explanation.log_error_with_network - explanation.log_error_without_network)))
            : "a network for what is left predicts what it has not seen no better: none is in ship.json",
        2);
  add_parameters(screen, explanation.parameters);
  if (!explanation.coefficient_factors.empty())
    screen.item(
        "", "ship.json has the coefficients that were fitted: free runs over what is left out err less with them", 2);
  const auto errors = [&](const BeforeAfter& fit) {
    const auto runs = [](const Scores& scores) {
      const auto found = scores.free_runs.find(kShownHorizon_s);
      return found == scores.free_runs.end() ? Score{} : found->second;
    };
    const Score before = runs(fit.before), after = runs(fit.after);
    return fmt::format(
        "u {:.3g} -> {:.3g} m/s, v_m {:.3g} -> {:.3g} m/s, r {:.3g} -> {:.3g} deg/s, position {:.3g} -> {:.3g} m; ln "
        "likelihood per sample {:.3f} -> {:.3f}",
        before.rmse_u_mps, after.rmse_u_mps, before.rmse_vm_mps, after.rmse_vm_mps, before.rmse_r_degps,
        after.rmse_r_degps, before.rmse_position_m, after.rmse_position_m, fit.before.log_likelihood_per_sample,
        fit.after.log_likelihood_per_sample);
  };
  if (!explanation.effects.empty() || !explanation.coefficient_factors.empty() || explanation.residual_network) {
    screen.item("Held out",
                fmt::format("free runs of {} s, root mean square errors before -> after: ", kShownHorizon_s) +
                    errors(explanation.heldout),
                3);
    screen.item("",
                fmt::format("gain {} nats where left out in turn",
                            with_sd(explanation.heldout_gain, explanation.heldout_gain_sd)),
                1);
  }
  if (!explanation.notices.empty())
    screen.item("Note",
                first_of(explanation.notices, 3, 3, [](const std::string& s) -> const std::string& { return s; }), 3);
  screen.item("Next", next_step(explanation, what), 3);
  return std::move(screen).text();
}

}  // namespace leeway::gap