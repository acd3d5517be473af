#include "effects/catalogue.hpp"

#include <fmt/format.h>

#include "core/errors.hpp"
#include "effects/registry.hpp"

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

}  // namespace

std::string catalogue_text(const std::string& name) {
  std::string text;
  for (const EffectDescription& effect : effect_catalogue()) {
    const EffectInfo& i = effect.info;
    if (!name.empty() && i.name != name) continue;
    if (!text.empty()) text += '\n';
    text += fmt::format("{} ({})\n  {}\n  formula     {}\n", i.name, i.number, i.sentence, i.formula);
    for (const EffectParameter& p : effect.parameters) {
      const std::string off = off_text(effect, p), otherwise = default_text(p);
      text += fmt::format("  {:<22}  {}; {}{}; prior {}\n", p.name, p.meaning,
                          otherwise == "required" ? "required" : "default " + otherwise,
                          off.empty() ? "" : ", off at " + off, priors_text(p));
    }
    text += fmt::format("  source      {}\n  looks like  {}\n  told apart  {}\n", i.source, i.look_alikes,
                        i.separating_maneuver);
  }
  if (text.empty()) {
    std::string known;
    for (const EffectDescription& effect : effect_catalogue())
      known += (known.empty() ? "" : ", ") + std::string(effect.info.name);
    throw UsageError(fmt::format("no effect '{}'; known: {}", name, known));
  }
  return text;
}

std::string catalogue_page() {
  std::string text =
      "# Effects: physics that a model can lack\n"
      "\n"
      "Written by `mmg-sim effects --page`, from the same place that the simulator reads. An effect is added to a ship "
      "by an entry in\n"
      "the `effects` array of its JSON, or for one run by `--effect E.json` (one such object, or an array of them):\n"
      "\n"
      "```\n"
      "{\"type\": \"steady-current\", \"current_speed_mps\": 0.05, \"current_set_deg\": 90}\n"
      "```\n"
      "\n"
      "`description` and `source` may stand in an entry. Several effects add up; those that change coefficients do so "
      "in the order of\n"
      "the array. At its neutral value (\"off at\") an effect changes nothing, to the last bit. The equations of "
      "motion in moving water and all\n"
      "signs are those of [conventions.md](conventions.md).\n"
      "\n"
      "Priors: what is known before any recording was seen, for ships of about 3 m and, where it differs, of about 150 "
      "m. N(median; sd), LN(median; sd\n"
      "of the logarithm), Rayleigh(sd of each component of the vector); bounds are hard. They are working values for "
      "the gap tools, chosen here; the\n"
      "simulator takes any value that makes sense.\n";
  for (const EffectDescription& effect : effect_catalogue()) {
    const EffectInfo& i = effect.info;
    text += fmt::format("\n## {} ({})\n\n{}\n\nFormula: `{}`.\n\n", i.name, i.number, i.sentence, i.formula);
    text += "| parameter | meaning | default | off at | prior |\n|---|---|---|---|---|\n";
    for (const EffectParameter& p : effect.parameters)
      text += fmt::format("| `{}` | {} | {} | {} | {} |\n", p.name, p.meaning, default_text(p), off_text(effect, p),
                          priors_text(p));
    text += fmt::format("\nSource: {}. Looks like: {}. Told apart by: {}.\n", i.source, i.look_alikes,
                        i.separating_maneuver);
  }
  return text;
}

}  // namespace leeway
