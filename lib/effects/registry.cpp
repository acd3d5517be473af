#include "effects/registry.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "core/errors.hpp"

namespace leeway {
namespace {

template <std::size_t... i>
std::vector<EffectDescription> describe(std::index_sequence<i...>) {
  return {EffectDescription{std::variant_alternative_t<i, Effect<double>>::info,
                            std::variant_alternative_t<i, Effect<double>>::parameters}...};
}

template <typename Range, typename Name>
std::string names(const Range& range, const Name& name) {
  std::string text;
  for (const auto& item : range) text += (text.empty() ? "" : ", ") + std::string(name(item));
  return text;
}

std::string expected_range(const EffectParameter& p) {
  const bool has_low = std::isfinite(p.low), has_high = std::isfinite(p.high);
  if (has_low && has_high) return fmt::format("a number from {} to {}", p.low, p.high);
  if (has_low) return fmt::format("a number >= {}", p.low);
  if (has_high) return fmt::format("a number <= {}", p.high);
  return "a number";
}

}  // namespace

const std::vector<EffectDescription>& effect_catalogue() {
  static const std::vector<EffectDescription> catalogue =
      describe(std::make_index_sequence<std::variant_size_v<Effect<double>>>());
  return catalogue;
}

std::optional<std::size_t> find_effect(std::string_view name) {
  const std::vector<EffectDescription>& catalogue = effect_catalogue();
  const auto found =
      std::find_if(catalogue.begin(), catalogue.end(), [&](const auto& e) { return e.info.name == name; });
  if (found == catalogue.end()) return std::nullopt;
  return static_cast<std::size_t>(found - catalogue.begin());
}

const EffectDescription& effect_named(std::string_view name) {
  const std::optional<std::size_t> place = find_effect(name);
  if (!place) throw UsageError(fmt::format("no effect '{}' in the catalogue", name));
  return effect_catalogue()[*place];
}

bool is_switch(const EffectDescription& effect, const EffectParameter& parameter) {
  return &parameter == &effect.parameters.front() && std::all_of(effect.parameters.begin(), effect.parameters.end(),
                                                                 [](const auto& p) { return std::isnan(p.off); });
}

std::optional<EffectValues> effect_values(const EffectEntry& entry) {
  const std::vector<EffectDescription>& catalogue = effect_catalogue();
  const std::optional<std::size_t> type = find_effect(entry.type);
  if (!type)
    throw InputError(entry.file, 0, entry.pointer + "/type",
                     fmt::format("unknown effect '{}'; known: {}", entry.type,
                                 names(catalogue, [](const auto& e) { return e.info.name; })));
  const EffectDescription& found = catalogue[*type];
  for (const auto& [name, value] : entry.parameters)
    if (std::none_of(found.parameters.begin(), found.parameters.end(), [&](const auto& p) { return p.name == name; }))
      throw InputError(entry.file, 0, entry.pointer + "/" + name,
                       fmt::format("unknown key; the effect '{}' has {}", entry.type,
                                   names(found.parameters, [](const auto& p) { return p.name; })));

  EffectValues result{*type, {}};
  bool is_off = false;
  for (const EffectParameter& p : found.parameters) {
    const std::string pointer = entry.pointer + "/" + std::string(p.name);
    const auto given = std::find_if(entry.parameters.begin(), entry.parameters.end(),
                                    [&](const auto& g) { return g.first == p.name; });
    if (given == entry.parameters.end()) {
      if (std::isnan(p.otherwise))
        throw InputError(entry.file, 0, pointer,
                         fmt::format("expected {} ({}), got nothing", expected_range(p), p.meaning));
      result.values.push_back(p.otherwise);
    } else if (given->second) {
      const double value = *given->second;
      if (!(value >= p.low && value <= p.high))
        throw InputError(entry.file, 0, pointer,
                         fmt::format("expected {} ({}), got {}", expected_range(p), p.meaning, value));
      result.values.push_back(value);
    } else if (is_switch(found, p)) {
      is_off = true;
    } else {
      throw InputError(entry.file, 0, pointer, fmt::format("expected {} ({}), got null", expected_range(p), p.meaning));
    }
  }
  if (is_off) return std::nullopt;
  return result;
}

}  // namespace leeway
