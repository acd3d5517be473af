#include "gap/compare/latent_forces.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <catch2/catch.hpp>

#include "gap/compare/latent_bases.hpp"
#include "gap/policy/policy.hpp"
#include "gap/simulated_campaign.hpp"

using namespace leeway;
using gap::Dependence;
using gap::LatentForce;

namespace {

gap::Campaign campaign_with(const std::vector<EffectEntry>& planted, double sample_s = 1.0, double noise = 1.0) {
  const Ship ship = read_ship("esso-osaka-3m");
  const test::SimulatedCampaign of{
      .ship = "esso-osaka-3m", .recordings = 3, .duration_s = 240.0, .sample_s = sample_s, .wind_mps = 0.0};
  Ship true_ship = ship;
  true_ship.effects = planted;
  return gap::prepare(ship, test::recorded(of, true_ship, {}, noise), {});
}

std::vector<LatentForce> found_in(const std::vector<EffectEntry>& planted, double sample_s = 1.0, double noise = 1.0) {
  const gap::Campaign campaign = campaign_with(planted, sample_s, noise);
  return gap::latent_forces(campaign, gap::fit_null(campaign, {.jobs = 2}), 2);
}

EffectEntry effect(const std::string& type, std::vector<std::pair<std::string, std::optional<double>>> parameters) {
  return {type, std::move(parameters), "", ""};
}

// Pushes midship to one side and the other, in turn.
std::vector<EffectEntry> square_wave(double force_N, double period_s, double until_s) {
  std::vector<EffectEntry> pushes;
  for (int half = 0; half * 0.5 * period_s < until_s; ++half)
    pushes.push_back(effect("tug", {{"force_N", force_N},
                                    {"direction_deg", half % 2 == 0 ? 90.0 : -90.0},
                                    {"x_m", 0.0},
                                    {"y_m", 0.0},
                                    {"t_start_s", half * 0.5 * period_s},
                                    {"t_end_s", (half + 1) * 0.5 * period_s}}));
  return pushes;
}

}  // namespace

TEST_CASE("latent forces: where nothing is missing no kind gains what a claim needs", "[gap]") {
  // Also by sensors so good that the least model error is more than there is.
  for (const double noise : {1.0, 0.1})
    for (const LatentForce& kind : found_in({}, 1.0, noise)) {
      CAPTURE(gap::phrase(kind), noise);
      CHECK(kind.log_evidence < 4.6);  // a hundred to one
    }
}

TEST_CASE("latent forces: what large errors of the model make of her motion is not their cause", "[gap]") {
  const EffectEntry errors = effect(
      "model-error", {{"surge_mps2", 2e-3}, {"sway_mps2", 2e-3}, {"yaw_degps2", 0.15}, {"tau_s", 15.0}, {"seed", 3.0}});
  for (const LatentForce& kind : found_in({errors}, 3.0)) {
    CAPTURE(gap::phrase(kind), kind.log_evidence);
    CHECK(kind.log_evidence < 4.6);
  }
}

TEST_CASE("latent forces: a force that comes in turns has its period", "[gap]") {
  const std::vector<LatentForce> kinds = found_in(square_wave(0.15, 30.0, 240.0));
  REQUIRE(!kinds.empty());
  CAPTURE(gap::phrase(kinds.front()));
  CHECK(kinds.front().on == Dependence::period);
  CHECK(kinds.front().axes == std::vector<int>{1});
  CHECK(kinds.front().argument == Approx(30.0).epsilon(0.1));
  CHECK(kinds.front().log_evidence > 10.0);
}

TEST_CASE("latent forces: a line to an anchor is a force that depends on the place", "[gap]") {
  const std::vector<LatentForce> kinds = found_in({effect(
      "mooring", {{"anchor_x_m", 10.0}, {"anchor_y_m", 5.0}, {"stiffness_npm", 0.02}, {"slack_length_m", 0.0}})});
  REQUIRE(!kinds.empty());
  CAPTURE(gap::phrase(kinds.front()));
  CHECK(kinds.front().on == Dependence::place);
  CHECK(kinds.front().log_evidence > 10.0);
}

TEST_CASE("latent forces: about a place they fade with the distance, and push in earth axes or from it", "[gap]") {
  const gap::Campaign campaign = campaign_with({});
  const gap::FittedNull fit = gap::fit_null(campaign, {.jobs = 2});
  const gap::Moments moments = gap::moments_of(fit);
  std::size_t about_places = 0;
  for (const auto& make : gap::latent_bases(campaign, fit, moments)) {
    const gap::LatentBasis all = make();
    if (all.variants.empty() || !all.variants.front().about) continue;
    ++about_places;
    CHECK(all.on == Dependence::place);
    CHECK(std::ssize(all.variants) <= gap::kPolicy.compare.latent_places);
    const Vec2<double> place = *all.variants[all.variants.size() / 2].about;
    const gap::LatentBasis basis = all.of(all.variants[all.variants.size() / 2]);
    REQUIRE(basis.columns == 3);
    bool is_reached = false;
    for (std::size_t s = 0; s < moments.size(); ++s)
      for (std::size_t k = 0; k < moments[s].size(); ++k) {
        const gap::Moment& m = moments[s][k];
        const Eigen::Matrix3d here = basis.values[s].middleCols<3>(3 * static_cast<Eigen::Index>(k));
        Mat2<double> to_earth;
        to_earth << std::cos(m.psi), -std::sin(m.psi), std::sin(m.psi), std::cos(m.psi);
        const Vec2<double> from = (Vec2<double>(m.x0, m.y0) - place) / basis.argument;
        const double near = std::exp(-0.5 * from.squaredNorm());
        CHECK((to_earth * here.topLeftCorner<2, 2>() - near * Mat2<double>::Identity()).norm() < 1e-12);
        CHECK((to_earth * here.block<2, 1>(0, 2) - near * from).norm() < 1e-12);
        CHECK(here.row(2).norm() == 0.0);
        is_reached |= from.norm() == 0.0;
      }
    CHECK(is_reached);
  }
  CHECK(about_places == gap::kPolicy.compare.latent_lengths.size());
}

TEST_CASE("latent forces: rudders that lag are a memory", "[gap]") {
  const std::vector<LatentForce> kinds = found_in({effect("actuator-lag", {{"lag_s", 2.5}})});
  REQUIRE(!kinds.empty());
  CAPTURE(gap::phrase(kinds.front()));
  CHECK(kinds.front().on == Dependence::memory);
  CHECK(kinds.front().log_evidence > 5.0);
}

// Coefficients that stood in for a force, and were taken for badly known, are as stated beside it.
TEST_CASE("latent forces: how wrong the ship's file is, is averaged over beside each", "[gap]") {
  const gap::Campaign campaign = campaign_with({});
  gap::FittedNull fit = gap::fit_null(campaign, {.jobs = 2});
  const std::vector<LatentForce> before = gap::latent_forces(campaign, fit, 2);
  fit.prior = fit.stated.scaled(fit.theta.size() - 1, 3.0);  // as if the coefficients had come out badly known
  fit.scale = 3.0;
  const std::vector<LatentForce> after = gap::latent_forces(campaign, fit, 2);
  REQUIRE(!before.empty());
  REQUIRE(after.size() == before.size());
  for (std::size_t i = 0; i < before.size(); ++i) {
    CHECK(after[i].on == before[i].on);
    CHECK(after[i].log_evidence == Approx(before[i].log_evidence));
  }
}
