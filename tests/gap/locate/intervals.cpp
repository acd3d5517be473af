#include "gap/locate/intervals.hpp"

#include <catch2/catch.hpp>

#include "gap/compare/tugs.hpp"
#include "gap/policy/policy.hpp"
#include "gap/simulated_campaign.hpp"

using namespace leeway;

namespace {

constexpr double kBegin_s = 90.0, kEnd_s = 130.0;

// A tug pulls in the first of three recordings.
std::vector<Trajectory> towed(const std::string& ship_name) {
  const test::SimulatedCampaign of{.ship = ship_name, .recordings = 3, .duration_s = 240.0, .wind_mps = 0.0};
  const Ship ship = read_ship(ship_name);
  Ship with_tug = ship;
  with_tug.effects.push_back({"tug",
                              {{"force_N", 1.0},
                               {"direction_deg", 70.0},
                               {"x_m", 1.0},
                               {"y_m", 0.0},
                               {"t_start_s", kBegin_s},
                               {"t_end_s", kEnd_s}},
                              "",
                              ""});
  std::vector<Trajectory> recordings = test::recorded(of, ship);
  recordings.front() = test::recorded(of, with_tug).front();
  return recordings;
}

}  // namespace

TEST_CASE("intervals: the likeliest is the one in which a tug pulls", "[gap]") {
  const gap::Campaign campaign = gap::prepare(read_ship("esso-osaka-3m"), towed("esso-osaka-3m"), {});
  const auto interval = gap::likeliest_interval(campaign, gap::fit_null(campaign, {.jobs = 2}), 2);
  REQUIRE(interval);
  CHECK(interval->file == "run0");
  CHECK(interval->t_start_s == Approx(kBegin_s).margin(10.0));
  CHECK(interval->t_end_s == Approx(kEnd_s).margin(10.0));
  CHECK(interval->searched > 100);
}

TEST_CASE("intervals: a tug begins and ends where it does, and pulls no shorter than a block", "[gap]") {
  const gap::Campaign campaign = gap::prepare(read_ship("esso-osaka-3m"), towed("esso-osaka-3m"), {});
  gap::Fitted none;
  none.fit = gap::fit_null(campaign, {.jobs = 2});
  for (const double long_s : {30.0, 4.0}) {
    gap::Interval interval;
    interval.file = "run0";
    interval.t_start_s = kBegin_s;
    interval.t_end_s = kBegin_s + long_s;
    const std::vector<gap::Start> starts = gap::starts_in_intervals(campaign, none, "tug", {interval}, 2);
    REQUIRE(!starts.empty());
    const gap::FreeEffect& tug = starts.front().hypothesis.effects.front();
    const std::vector<double> now = tug.values(Eigen::VectorXd::Zero(tug.size()));
    const EffectDescription& description = effect_named("tug");
    const double begin_s = now[place_of(ParameterRole::begin, description)],
                 end_s = now[place_of(ParameterRole::end, description)];
    CAPTURE(long_s, begin_s, end_s);
    CHECK(end_s - begin_s >= gap::kPolicy.locate.block_s * campaign.time_scale());
    CHECK(begin_s == Approx(kBegin_s).margin(5.0));
    if (long_s > 10.0) CHECK(end_s == Approx(kEnd_s).margin(5.0));  // from there it is found
  }
}
