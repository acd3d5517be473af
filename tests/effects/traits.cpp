#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include <catch2/catch.hpp>

#include "effects/description.hpp"

using namespace leeway;

TEST_CASE("traits: what an effect looks like are other effects of the catalogue, each once", "[effects]") {
  for (const EffectDescription& effect : effect_catalogue()) {
    const EffectNames& names = effect.info.looks_like;
    CAPTURE(effect.info.name);
    CHECK(std::set<std::string_view>(names.begin(), names.end()).size() ==
          static_cast<std::size_t>(names.end() - names.begin()));
    for (const std::string_view name : names) {
      CAPTURE(name);
      CHECK(find_effect(name).has_value());
      CHECK(name != effect.info.name);
    }
  }
}

TEST_CASE("traits: look-alikes are so both ways, whichever of the two says it", "[effects]") {
  for (const EffectDescription& a : effect_catalogue())
    for (const EffectDescription& b : effect_catalogue()) {
      CAPTURE(a.info.name, b.info.name);
      CHECK(are_look_alikes(a.info.name, b.info.name) == are_look_alikes(b.info.name, a.info.name));
    }
  // Thrust and resistance differ by their balance alone, a current and a wind by the speed of the ship.
  for (const auto& [a, b] : {std::pair{"fouling", "thrust-loss"},
                             {"steady-current", "unmeasured-wind"},
                             {"bank", "tug"},
                             {"rudder-effectiveness", "rudder-stall"},
                             {"varying-current", "steady-current"}})
    CHECK(are_look_alikes(a, b));
  // Other axes, other actuators, another frame.
  for (const auto& [a, b] : {std::pair{"fouling", "rudder-offset"},
                             {"steady-current", "thruster-gain"},
                             {"tug", "wake"},
                             {"body-force", "earth-force"},
                             {"fouling", "fouling"}})
    CHECK_FALSE(are_look_alikes(a, b));
}

TEST_CASE("traits: each way to search finds what it needs", "[effects]") {
  for (const EffectDescription& effect : effect_catalogue()) {
    CAPTURE(effect.info.name);
    const SearchStart search = effect.info.search;
    const bool is_at_place =
        search == SearchStart::wall || search == SearchStart::contact || search == SearchStart::anchor;
    CHECK((effect.info.bound_to == BoundTo::place) == is_at_place);
    CHECK((effect.info.bound_to == BoundTo::time) == (search == SearchStart::interval));
    if (search == SearchStart::wall || search == SearchStart::contact)
      CHECK_NOTHROW(place_of(ParameterRole::wall_distance, effect));
    if (search == SearchStart::anchor)
      for (const ParameterRole role : {ParameterRole::anchor_x, ParameterRole::anchor_y, ParameterRole::slack})
        CHECK_NOTHROW(place_of(role, effect));
    if (search == SearchStart::interval)
      for (const ParameterRole role :
           {ParameterRole::force, ParameterRole::lever, ParameterRole::begin, ParameterRole::end})
        CHECK_NOTHROW(place_of(role, effect));
    if (effect.info.to_ensemble != EnsembleForm::none) CHECK(is_screened(search));
  }
  CHECK(effects_searched_from(SearchStart::terms) == std::vector<std::string>{"unknown"});  // as reports call it
  CHECK(effects_searched_from(SearchStart::course) == std::vector<std::string>{"varying-current"});
  CHECK(name_of(ParameterRole::begin, effect_named("tug")) == "t_start_s");
  CHECK_THROWS_AS(place_of(ParameterRole::begin, effect_named("wake")), std::logic_error);
}

TEST_CASE("traits: vectors of water, wind and pull may differ between recordings, and one effect makes water shallow",
          "[effects]") {
  std::set<std::string_view> differ, shallow;
  for (const EffectDescription& effect : effect_catalogue()) {
    if (effect.info.differs_by_recording) differ.insert(effect.info.name);
    if (effect.info.changes_depth) shallow.insert(effect.info.name);
  }
  CHECK(differ == std::set<std::string_view>{"steady-current", "varying-current", "unmeasured-wind", "earth-force"});
  CHECK(shallow == std::set<std::string_view>{"shallow-water"});
}

TEST_CASE("priors: those of 3 m and of 150 m are as stated, and a power of the length goes through both", "[effects]") {
  const auto close = [](double a, double b) { return a == Approx(b).epsilon(1e-12).margin(1e-300); };
  for (const EffectDescription& effect : effect_catalogue())
    for (const EffectParameter& p : effect.parameters) {
      CAPTURE(effect.info.name, p.name);
      CHECK(p.at_3m.kind == p.at_150m.kind);
      for (const auto& [length, stated] : {std::pair{3.0, p.at_3m}, {150.0, p.at_150m}})
        for (const double beside : {length, length * (1.0 + 1e-13), length * (1.0 - 1e-13)}) {
          const Prior prior = p.prior(beside);
          CHECK(prior.kind == stated.kind);
          for (double Prior::*number : {&Prior::median, &Prior::sd, &Prior::low, &Prior::high}) {
            if (beside == length) CHECK(prior.*number == stated.*number);
            CHECK((prior.*number == stated.*number || close(prior.*number, stated.*number)));
          }
        }
      for (const double length : {0.5, 2.0, 7.0, 20.0, 40.0, 320.0}) {
        CAPTURE(length);
        const Prior prior = p.prior(length);
        CHECK(prior.low <= prior.median);
        CHECK(prior.median <= prior.high);
        CHECK(prior.sd > 0.0);
      }
    }
  const EffectDescription& current = effect_named("steady-current");
  CHECK(close(current.parameters[0].prior(std::sqrt(3.0 * 150.0)).sd, std::sqrt(0.04 * 0.3)));
  CHECK(close(current.parameters[0].prior(320.0).high, 0.15 * std::pow(10.0, std::log(320.0 / 3.0) / std::log(50.0))));
  CHECK(is_direction(current.parameters[1].prior(40.0)));
  // Both bounds of a range about 0; the lower one stays where it is 0.
  const EffectParameter lever = effect_named("tug").parameters[place_of(ParameterRole::lever, effect_named("tug"))];
  CHECK(lever.prior(40.0).low == -lever.prior(40.0).high);
  // No power goes through 0: linear in ln L, and held beyond.
  constexpr EffectParameter from_zero{
      "x", "", 0.0, 0.0, 0.0, 9.0, normal(0.0, 1.0, -2.0, 3.0), normal(1.0, 1.0, 2.0, 3.0)};
  const double middle = std::sqrt(3.0 * 150.0);
  CHECK(close(from_zero.prior(middle).median, 0.5));
  CHECK(std::abs(from_zero.prior(middle).low) < 1e-12);
  CHECK(from_zero.prior(320.0).median == 1.0);
  CHECK(from_zero.prior(1.0).low == -2.0);
  CHECK(from_zero.prior(320.0).sd == 1.0);
}

TEST_CASE("traits: a name that the catalogue does not hold is searched for nowhere", "[effects]") {
  CHECK(search_start("heading-bias") == SearchStart::none);
  CHECK(bound_to("heading-bias") == BoundTo::nothing);
}

TEST_CASE("traits: effects that the gap tools do not try have no share in the prior", "[effects]") {
  // Another number changes the prior of every effect, and so all probabilities.
  CHECK(count_of_tried_effects() == 35);
  CHECK(count_of_tried_effects() + effects_searched_from(SearchStart::none).size() == effect_catalogue().size());
}

TEST_CASE("traits: no file of lib/gap knows an effect by its name", "[effects]") {
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(LEEWAY_SOURCE_FOLDER "/lib/gap")) {
    const std::string path = entry.path().generic_string();
    if (entry.path().extension() != ".cpp" && entry.path().extension() != ".hpp") continue;
    if (path.find("/gap/sensors/") != std::string::npos) continue;  // a fault of the log may be called like a current
    std::stringstream text;
    text << std::ifstream(path).rdbuf();
    ++files;
    for (const EffectDescription& effect : effect_catalogue()) {
      // "unknown" is also what is written for a number that is not known.
      if (effect.info.search == SearchStart::terms) continue;
      CAPTURE(path, effect.info.name);
      CHECK(text.str().find('"' + std::string(effect.info.name) + '"') == std::string::npos);
    }
  }
  CHECK(files > 50);
}
