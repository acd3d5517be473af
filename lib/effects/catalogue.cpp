#include "effects/catalogue.hpp"

#include <cctype>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/errors.hpp"
#include "core/similar_words.hpp"
#include "effects/description.hpp"

namespace leeway {
namespace {

std::string prior_text(const Prior& p) {
  switch (p.kind) {
    case Prior::Kind::normal:
      return fmt::format("N({}; {}) in [{}, {}]", p.median, p.sd, p.low, p.high);
    case Prior::Kind::log_normal:
      return fmt::format("LN({}; {}) in [{}, {}]", p.median, p.sd, p.low, p.high);
    case Prior::Kind::rayleigh:
      return fmt::format("Rayleigh({}) up to {}", p.sd, p.high);
    case Prior::Kind::uniform:
      return fmt::format("uniform in [{}, {}]", p.low, p.high);
  }
  return "";
}

// One prior, or both where the scales differ.
std::string priors_text(const EffectParameter& p) {
  const std::string small = prior_text(p.at_3m), large = prior_text(p.at_150m);
  return small == large ? small : small + "; at 150 m " + large;
}

std::string default_text(const EffectParameter& p) {
  if (std::isnan(p.otherwise)) return "required";
  return std::isfinite(p.otherwise) ? fmt::format("{}", p.otherwise) : "none";
}

std::string off_text(const EffectDescription& effect, const EffectParameter& p) {
  if (!std::isnan(p.off)) return fmt::format("{}", p.off);
  return is_switch(effect, p) ? "null" : "";
}

// A paragraph of Markdown in lines of at most 160 columns. A line begins with a letter, a bracket or code: with a sign
// or a number it could begin a list.
std::string paragraph(std::string_view text) {
  constexpr std::size_t kColumns = 160;
  const auto may_begin = [](char c) { return std::isalpha(static_cast<unsigned char>(c)) || c == '(' || c == '`'; };
  std::string result;
  while (text.size() > kColumns) {
    std::size_t end = text.rfind(' ', kColumns);
    while (end != std::string_view::npos && end > 0 && !may_begin(text[end + 1])) end = text.rfind(' ', end - 1);
    if (end == std::string_view::npos || end == 0) break;
    result.append(text.substr(0, end)) += '\n';
    text.remove_prefix(end + 1);
  }
  return result.append(text) += '\n';
}

}  // namespace

std::vector<std::string> effect_names() {
  std::vector<std::string> names;
  for (const EffectDescription& effect : effect_catalogue()) names.emplace_back(effect.info.name);
  return names;
}

std::string catalogue_text(const std::string& name) {
  std::string text;
  for (const EffectDescription& effect : effect_catalogue()) {
    const EffectInfo& i = effect.info;
    if (!name.empty() && i.name != name) continue;
    if (!text.empty()) text += '\n';
    text += fmt::format("{} ({})\n  {}\n  formula                 {}\n", i.name, i.number, i.sentence, i.formula);
    for (const EffectParameter& p : effect.parameters) {
      const std::string off = off_text(effect, p), otherwise = default_text(p);
      text += fmt::format("  {:<22}  {}; {}{}; prior {}\n", p.name, p.meaning,
                          otherwise == "required" ? "required" : "default " + otherwise,
                          off.empty() ? "" : ", off at " + off, priors_text(p));
    }
    text += fmt::format("  source                  {}\n  looks like              {}\n  distinguished by        {}\n{}",
                        i.source, i.look_alikes, i.separating_maneuver,
                        i.search == SearchStart::none ? "  gap tools               do not try it\n" : "");
  }
  if (text.empty()) {
    const std::vector<std::string> known = effect_names();
    throw UsageError(
        fmt::format("no effect '{}'; known: {}{}", name, fmt::join(known, ", "), did_you_mean(name, known)));
  }
  return text;
}

std::string catalogue_page() {
  std::string text = "# Effects: physics that a model can lack\n\n";
  text += paragraph(
      "Written by `mmg-sim effects --page`, from the same place that the simulator reads. An effect is added to a ship "
      "by an entry in the `effects` array of its JSON, or for one run by `--effect E.json` (one such object, or an "
      "array "
      "of them):");
  text += "\n```\n{\"type\": \"steady-current\", \"current_speed_mps\": 0.05, \"current_set_deg\": 90}\n```\n\n";
  text += paragraph(
      "`description` and `source` may stand in an entry. Several effects add up; those that change coefficients do so "
      "in "
      "the order of the array. At its neutral value (\"off at\") an effect changes nothing, to the last bit. The "
      "equations of motion in moving water and all signs are those of [conventions.md](conventions.md).");
  text +=
      '\n' +
      paragraph(
          "Priors: what is known before any recording was seen, for ships of about 3 m and, where it differs, "
          "of about 150 m; for others each number is on the power of L_pp through both, also beyond 150 m (linear in "
          "the logarithm of L_pp where one is 0, and held beyond). N(median; sd), LN(median; sd of the logarithm), "
          "Rayleigh(sd of each component of "
          "the vector); bounds are hard. They are working values for the gap tools, chosen here; the "
          "simulator takes any value that makes sense.");
  for (const EffectDescription& effect : effect_catalogue()) {
    const EffectInfo& i = effect.info;
    text += fmt::format("\n## {} ({})\n\n", i.name, i.number);
    text += paragraph(i.sentence) + '\n' + paragraph(fmt::format("Formula: `{}`.", i.formula));
    text += "\n| parameter | meaning | default | off at | prior |\n|---|---|---|---|---|\n";
    for (const EffectParameter& p : effect.parameters)
      text += fmt::format("| `{}` | {} | {} | {} | {} |\n", p.name, p.meaning, default_text(p), off_text(effect, p),
                          priors_text(p));
    text += '\n' + paragraph(fmt::format("Source: {}.", i.source));
    text +=
        '\n' + paragraph(fmt::format("Looks like: {}. Distinguished by: {}.{}", i.look_alikes, i.separating_maneuver,
                                     i.search == SearchStart::none ? " The gap tools do not try it." : ""));
  }
  return text;
}

}  // namespace leeway
