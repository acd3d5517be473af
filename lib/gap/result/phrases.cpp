#include "gap/result/phrases.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <optional>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "effects/description.hpp"
#include "gap/policy/policy.hpp"
#include "gap/result/numbers.hpp"

namespace leeway::gap {
namespace {

// What fills the braces of a phrase; the rules stand at EffectInfo::phrase.
class Filled {
 public:
  Filled(const EffectDescription& effect, const std::vector<ExplainedParameter>& parameters)
      : effect_(effect), parameters_(parameters) {}

  // Nothing where a parameter is not known, or where the effect vanishes.
  std::optional<std::string> operator()(std::string_view part) const {
    std::string text;
    while (!part.empty()) {
      const std::size_t open = std::min(part.find('{'), part.size()), close = part.find('}', open);
      text += part.substr(0, open);
      if (open == part.size()) break;
      const std::optional<std::string> value = of(part.substr(open + 1, close - open - 1));
      if (!value) return std::nullopt;
      text += *value;
      part.remove_prefix(close + 1);
    }
    return text;
  }

 private:
  std::optional<std::string> of(std::string_view braces) const {
    const std::size_t end = std::min(braces.find_first_of("%!?"), braces.size());
    const std::string_view name = braces.substr(0, end);
    const auto value = std::find_if(parameters_.begin(), parameters_.end(), [&](const ExplainedParameter& p) {
      return p.effect == effect_.info.name && p.name == name;
    });
    const auto known = std::find_if(effect_.parameters.begin(), effect_.parameters.end(),
                                    [&](const EffectParameter& p) { return p.name == name; });
    if (value == parameters_.end() || known == effect_.parameters.end()) return std::nullopt;
    const double off = std::isnan(known->off) ? 0.0 : known->off, by = value->estimate - off;
    if (!std::isnan(known->off) && std::abs(by) < 0.5 * value->sd) return std::nullopt;
    const std::string unit = unit_of(name), with_unit = unit == "1" ? "" : ' ' + unit;
    if (end == braces.size()) return rounded(value->estimate, value->sd) + with_unit;
    if (braces[end] == '%') return rounded(100.0 * std::abs(by), 100.0 * value->sd) + " %";
    if (braces[end] == '!') return rounded(std::abs(by), value->sd) + with_unit;
    const std::string_view words = braces.substr(end + 1);
    const std::size_t bar = words.find('|');
    return std::string(by > 0.0 ? words.substr(0, bar) : words.substr(bar + 1));
  }

  const EffectDescription& effect_;
  const std::vector<ExplainedParameter>& parameters_;
};

// Of each recording by itself, where an effect is another one in each.
std::string phrase_by_recording(const std::string& effect, const std::vector<ExplainedParameter>& parameters,
                                const std::vector<std::string>& recordings) {
  const std::size_t most = kPolicy.report.most_recordings;
  std::vector<std::string> parts;
  for (const std::string& name : recordings) {
    if (parts.size() == most) break;
    std::vector<ExplainedParameter> there;
    for (const ExplainedParameter& p : parameters)
      if (p.effect == effect && p.recording == name) there.push_back(p), there.back().recording.clear();
    parts.push_back(fmt::format("{} in {}", phrase(effect, there), name));
  }
  if (recordings.size() > most) parts.push_back(fmt::format("others in {} more recordings", recordings.size() - most));
  return fmt::format("{}", fmt::join(parts, ", "));
}

}  // namespace

std::vector<std::string> recordings_with(const std::string& effect, const std::vector<ExplainedParameter>& parameters) {
  std::vector<std::string> result;
  for (const ExplainedParameter& p : parameters)
    if (p.effect == effect && !p.recording.empty() && std::ranges::find(result, p.recording) == result.end())
      result.push_back(p.recording);
  return result;
}

std::string capitalized(std::string text) {
  if (!text.empty()) text.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(text.front())));
  return text;
}

std::string phrase(const std::string& effect, const std::vector<ExplainedParameter>& parameters) {
  if (!find_effect(effect)) return effect;
  if (const auto recordings = recordings_with(effect, parameters); !recordings.empty())
    return phrase_by_recording(effect, parameters, recordings);
  const EffectDescription& described = effect_named(effect);
  std::string_view rest = described.info.phrase;
  std::string lead;
  if (const std::size_t colon = rest.find(": "); colon != std::string_view::npos) {
    lead = rest.substr(0, colon);
    rest.remove_prefix(colon + 2);
  }
  const Filled filled(described, parameters);
  std::vector<std::string> parts;
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find("; "), rest.size());
    if (const std::optional<std::string> part = filled(rest.substr(0, end))) parts.push_back(*part);
    rest.remove_prefix(std::min(end + 2, rest.size()));
  }
  if (parts.empty()) return lead.empty() ? effect : lead;
  const std::string said = fmt::format("{}", fmt::join(parts, ", "));
  return lead.empty() ? said : fmt::format("{} ({})", lead, said);
}

std::string sentence_of(const std::string& effect, const std::vector<ExplainedParameter>& parameters) {
  const EffectInfo& info = effect_named(effect).info;
  if (search_start(effect) == SearchStart::terms) return std::string(info.sentence);
  const std::string said = phrase(effect, parameters), what = capitalized(said);
  if (said == effect) return std::string(info.sentence);  // it is as good as off
  if (info.or_coefficient.empty()) return fmt::format("{}. {}", what, info.sentence);
  const std::string_view cause = what.find(" less ") != std::string::npos   ? info.cause_of_less
                                 : what.find(" more ") != std::string::npos ? info.cause_of_more
                                                                            : std::string_view();
  return fmt::format("{} than the ship file states. That is {}{}{}.", what, cause, cause.empty() ? "" : ", or ",
                     info.or_coefficient);
}

}  // namespace leeway::gap
