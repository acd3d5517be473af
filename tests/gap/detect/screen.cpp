#include "gap/detect/screen.hpp"

#include <algorithm>
#include <cmath>

#include <catch2/catch.hpp>

#include "core/units.hpp"
#include "effects/description.hpp"
#include "gap/compare/places.hpp"
#include "gap/detect/effect_library.hpp"
#include "gap/simulated_campaign.hpp"

using namespace leeway;

TEST_CASE("screen: where nothing is missing, an effect gains much no more often than Markov allows", "[gap]") {
  const Ship ship = read_ship("esso-osaka-3m");
  const test::SimulatedCampaign of{.ship = "esso-osaka-3m", .recordings = 2, .duration_s = 150.0, .wind_mps = 0.0};
  const gap::Campaign campaign = gap::prepare(ship, test::recorded(of, ship), {});
  const gap::FittedNull fit = gap::fit_null(campaign, {.jobs = 2});
  const auto gains_of = [&](const std::vector<std::string>& effects) {
    std::vector<gap::Candidate> candidates;
    for (const std::string& effect : effects)
      for (gap::Candidate& candidate : gap::candidates_of(effect, ship)) candidates.push_back(std::move(candidate));
    const gap::EffectScreen screen(campaign, fit, {}, candidates, 1.0, {{.prior = fit.prior}}, {2});
    return screen.gains_of_nothing(4000, 1);
  };
  const auto share_above = [](const std::vector<double>& gains, double limit) {
    return static_cast<double>(std::ranges::count_if(gains, [&](double gain) { return gain > limit; })) /
           static_cast<double>(gains.size());
  };
  const std::vector<double> one = gains_of({"steady-current"}), two = gains_of({"steady-current", "rudder-offset"});
  CHECK(std::ranges::is_sorted(one));
  for (const double odds : {5.0, 20.0, 100.0}) {
    CAPTURE(odds);
    // The mean of exp(gain) is 1 for each; three standard errors of a share.
    const double limit = std::log(odds), chance = 3.0 / std::sqrt(4000.0 * odds);
    CHECK(share_above(one, limit) <= 1.0 / odds + chance);
    CHECK(share_above(two, limit) <= 2.0 / odds + 2.0 * chance);
  }
  CHECK(one.front() < one.back());
  CHECK(share_above(two, std::log(5.0)) >= share_above(one, std::log(5.0)));
  CHECK(gains_of({"steady-current"}) == one);
}

namespace {

// What each candidate would gain alone, with columns by whole steps or without.
std::vector<double> gains_of(const std::vector<gap::Candidate>& candidates, const gap::Campaign& campaign,
                             const gap::FittedNull& fit, bool whole_steps) {
  const gap::ScreenOptions options{.jobs = 2, .whole_steps = whole_steps};
  const gap::EffectScreen screen(campaign, fit, {}, candidates, 1.0, {{.prior = fit.prior}}, options);
  std::vector<double> result;
  for (std::size_t c = 0; c < candidates.size(); ++c)
    result.push_back(screen.log_evidence({c}) - screen.log_evidence({}));
  return result;
}

}  // namespace

TEST_CASE("screen: what an effect would gain hardly depends on whether whole steps are taken with it", "[gap]") {
  const char* const name = GENERATE("esso-osaka-3m", "vectwin-3m");
  const Ship ship = read_ship(name);
  Ship truth = ship;
  truth.effects.push_back({"mooring",
                           {{"anchor_x_m", 10.0},
                            {"anchor_y_m", 8.0},
                            {"stiffness_npm", 0.05},
                            {"slack_length_m", 6.0},
                            {"attach_x_m", 0.0},
                            {"attach_y_m", 0.0}},
                           "ship.json",
                           "/effects/0"});
  const test::SimulatedCampaign of{.ship = name, .recordings = 2, .duration_s = 150.0, .wind_mps = 0.5};
  const gap::Campaign campaign = gap::prepare(ship, test::recorded(of, truth), {});
  const gap::FittedNull fit = gap::fit_null(campaign, {.jobs = 2});
  std::vector<std::string> effects{"mooring", "bank"};
  const gap::EffectLibrary library(campaign, fit);
  for (const gap::EffectLibrary::Entry& entry : library.entries()) effects.push_back(entry.name);
  std::size_t gaining = 0;
  bool differ = false;
  for (const std::string& effect : effects) {
    std::vector<gap::Candidate> candidates;
    if (effect_named(effect).info.bound_to != BoundTo::place) {
      candidates = gap::candidates_of(effect, ship);
    } else {
      for (const gap::FreeEffect::Choice& choice : gap::places_of(effect, campaign, {})) {
        // A line without slack pulls so hard at its start that the water answers within a step.
        if (effect == "mooring" && choice.freed.empty()) continue;
        for (gap::Candidate& candidate : gap::candidates_of(effect, ship, {choice}))
          candidates.push_back(std::move(candidate));
      }
    }
    const std::vector<double> by_steps = gains_of(candidates, campaign, fit, true),
                              by_push = gains_of(candidates, campaign, fit, false);
    differ |= by_push != by_steps;
    if (effect == "mooring") CHECK(*std::ranges::max_element(by_push) > 3.0);
    for (std::size_t c = 0; c < candidates.size(); ++c) {
      CAPTURE(name, effect, c, by_steps[c], by_push[c]);
      CHECK(by_push[c] == Approx(by_steps[c]).margin(1.0).epsilon(0.2));
      gaining += by_steps[c] > 3.0 ? 1 : 0;
    }
  }
  CHECK(differ);
  CHECK(gaining > 3);
}

TEST_CASE("screen: one linear step finds a high sea as well as a low one", "[gap]") {
  const Ship ship = read_ship("esso-osaka-3m");
  const test::SimulatedCampaign of{.ship = "esso-osaka-3m", .recordings = 2, .duration_s = 150.0, .wind_mps = 0.0};
  for (const double hs_m : {0.02, 0.09}) {
    CAPTURE(hs_m);
    Ship truth = ship;
    truth.effects.push_back({"wave-drift", {{"hs_m", hs_m}, {"wave_from_deg", 125.0}}, "ship.json", "/effects/0"});
    const gap::Campaign campaign = gap::prepare(ship, test::recorded(of, truth), {});
    const gap::FittedNull fit = gap::fit_null(campaign, {.jobs = 2});
    const gap::Start best = gap::starts_of("wave-drift", campaign, fit, 2).front();
    const gap::FreeEffect& waves = best.hypothesis.effects.front();
    const std::vector<double> values = waves.values(best.theta.segment(fit.theta.size() - 1, waves.size()));
    CHECK(std::abs(std::log(values[0] / hs_m)) < std::log(2.0));
    CHECK(std::abs(wrap_angle((values[1] - 125.0) * kDegree)) < 45.0 * kDegree);
  }
}
