#include "gap/locate/intervals.hpp"

#include <catch2/catch.hpp>

#include "gap/compare/tugs.hpp"
#include "gap/policy/policy.hpp"
#include "gap/simulated_campaign.hpp"

using namespace leeway;

namespace {

constexpr double kBegin_s = 90.0, kEnd_s = 130.0;

// A tug pulls in the first of three recordings.
std::vector<Trajectory> towed(const std::string& ship_name, double force_N = 1.0) {
  const test::SimulatedCampaign of{.ship = ship_name, .recordings = 3, .duration_s = 240.0, .wind_mps = 0.0};
  const Ship ship = read_ship(ship_name);
  Ship with_tug = ship;
  with_tug.effects.push_back({"tug",
                              {{"force_N", force_N},
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

TEST_CASE("intervals: the weaker a tug is, the less is known of when it pulled, and the less that costs", "[gap]") {
  struct Known {
    double begin_sd_s, end_sd_s, log_ways;
  };
  const auto known = [](double force_N) {
    const gap::Campaign campaign = gap::prepare(read_ship("esso-osaka-3m"), towed("esso-osaka-3m", force_N), {});
    gap::Fitted none, fitted;
    none.fit = gap::fit_null(campaign, {.jobs = 2});
    gap::Interval interval;
    interval.file = "run0";
    interval.t_start_s = kBegin_s + 3.0;
    interval.t_end_s = kEnd_s - 3.0;
    const gap::Start start = gap::starts_in_intervals(campaign, none, "tug", {interval}, 2).front();
    const double log_ways = start.hypothesis.effects.front().log_ways();
    fitted.hypothesis = start.hypothesis;
    fitted.fit = gap::fit_with(campaign, none.fit, start.hypothesis, start.theta, {.jobs = 2});
    fitted.log_evidence = gap::log_evidence(fitted.fit);
    gap::refine_tugs(campaign, {.jobs = 2}, fitted);
    const gap::FreeEffect& tug = fitted.hypothesis.effects.front();
    const std::vector<double> now = tug.values(Eigen::VectorXd::Zero(tug.size()));
    const Known result{tug.known_sd("t_start_s"), tug.known_sd("t_end_s"), tug.log_ways()};
    CAPTURE(force_N, result.begin_sd_s, result.end_sd_s, result.log_ways, log_ways);
    CHECK(std::abs(now[place_of(ParameterRole::begin, effect_named("tug"))] - kBegin_s) <
          3.0 * result.begin_sd_s + 1.0);
    CHECK(std::abs(now[place_of(ParameterRole::end, effect_named("tug"))] - kEnd_s) < 3.0 * result.end_sd_s + 1.0);
    CHECK(result.log_ways > 0.0);
    CHECK(result.log_ways < log_ways);  // which is that of times known to a second
    // All begins and ends in three recordings of 240 s, by what is known of both.
    CHECK(log_ways == Approx(std::log(3.0 * 0.5 * 230.0 * 230.0)).margin(0.2));
    return result;
  };
  const Known strong = known(0.25), weak = known(0.03);
  CHECK(weak.begin_sd_s > strong.begin_sd_s);
  CHECK(weak.end_sd_s > strong.end_sd_s);
  CHECK(weak.log_ways < strong.log_ways - 3.0);
}
