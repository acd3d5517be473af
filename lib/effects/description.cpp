#include "effects/description.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/errors.hpp"
#include "core/similar_words.hpp"

namespace leeway {
namespace {

template <typename Range, typename Name>
std::vector<std::string> names(const Range& range, const Name& name) {
  std::vector<std::string> result;
  result.reserve(std::size(range));
  for (const auto& item : range) result.emplace_back(name(item));
  return result;
}

// The known words, and the one that may have been meant.
std::string listed(const std::vector<std::string>& known, const std::string& found) {
  return fmt::format("{}{}", fmt::join(known, ", "), did_you_mean(found, known));
}

std::string expected_range(const EffectParameter& p) {
  const bool has_low = std::isfinite(p.low), has_high = std::isfinite(p.high);
  if (has_low && has_high) return fmt::format("a number from {} to {}", p.low, p.high);
  if (has_low) return fmt::format("a number >= {}", p.low);
  if (has_high) return fmt::format("a number <= {}", p.high);
  return "a number";
}

}  // namespace

Prior EffectParameter::prior(double L_pp) const {
  constexpr double short_m = 3.0, long_m = 150.0;
  if (L_pp == short_m) return at_3m;
  if (L_pp == long_m) return at_150m;
  const double share = std::log(L_pp / short_m) / std::log(long_m / short_m);
  if (at_3m.kind != at_150m.kind) return share < 0.5 ? at_3m : at_150m;
  const auto between = [&](double a, double b) {
    if (a == b) return a;
    if (a * b > 0.0) return a * std::pow(b / a, share);
    return a + std::clamp(share, 0.0, 1.0) * (b - a);
  };
  const auto of = [&](double Prior::*number) { return between(at_3m.*number, at_150m.*number); };
  if (at_3m.kind == Prior::Kind::uniform) return uniform(of(&Prior::low), of(&Prior::high));
  return {at_3m.kind, of(&Prior::median), of(&Prior::sd), of(&Prior::low), of(&Prior::high)};
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

SearchStart search_start(std::string_view name) {
  const std::optional<std::size_t> place = find_effect(name);
  return place ? effect_catalogue()[*place].info.search : SearchStart::none;
}

BoundTo bound_to(std::string_view name) {
  const std::optional<std::size_t> place = find_effect(name);
  return place ? effect_catalogue()[*place].info.bound_to : BoundTo::nothing;
}

std::vector<std::string> effects_searched_from(SearchStart start) {
  std::vector<std::string> result;
  for (const EffectDescription& effect : effect_catalogue())
    if (effect.info.search == start) result.emplace_back(effect.info.name);
  return result;
}

std::size_t count_of_tried_effects() {
  return static_cast<std::size_t>(
      std::count_if(effect_catalogue().begin(), effect_catalogue().end(),
                    [](const EffectDescription& effect) { return effect.info.search != SearchStart::none; }));
}

bool are_look_alikes(std::string_view a, std::string_view b) {
  const auto says = [](std::string_view effect, std::string_view other) {
    const EffectNames& names = effect_named(effect).info.looks_like;
    return std::find(names.begin(), names.end(), other) != names.end();
  };
  return says(a, b) || says(b, a);
}

std::size_t place_of(ParameterRole role, const EffectDescription& effect) {
  const auto found = std::find_if(effect.parameters.begin(), effect.parameters.end(),
                                  [&](const EffectParameter& p) { return p.role == role; });
  if (found == effect.parameters.end())
    throw std::logic_error(fmt::format("effect '{}' has no parameter for how it is searched for", effect.info.name));
  return static_cast<std::size_t>(found - effect.parameters.begin());
}

std::string name_of(ParameterRole role, const EffectDescription& effect) {
  return std::string(effect.parameters[place_of(role, effect)].name);
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
                                 listed(names(catalogue, [](const auto& e) { return e.info.name; }), entry.type)));
  const EffectDescription& found = catalogue[*type];
  for (const auto& given : entry.parameters)
    if (std::none_of(found.parameters.begin(), found.parameters.end(),
                     [&](const auto& p) { return p.name == given.first; }))
      throw InputError(entry.file, 0, entry.pointer + "/" + given.first,
                       fmt::format("unknown key; the effect '{}' has {}", entry.type,
                                   listed(names(found.parameters, [](const auto& p) { return p.name; }), given.first)));

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
  const auto place = [&](ParameterRole role) {
    return std::ranges::find(found.parameters, role, &EffectParameter::role) - found.parameters.begin();
  };
  const auto n = std::ssize(found.parameters), begin = place(ParameterRole::begin), end = place(ParameterRole::end);
  const auto value = [&](std::ptrdiff_t i) { return result.values[static_cast<std::size_t>(i)]; };
  if (begin < n && end < n && !(value(end) > value(begin)))
    throw InputError(entry.file, 0,
                     entry.pointer + "/" + std::string(found.parameters[static_cast<std::size_t>(end)].name),
                     fmt::format("expected more than {} = {}, got {}",
                                 found.parameters[static_cast<std::size_t>(begin)].name, value(begin), value(end)));
  return result;
}

}  // namespace leeway
