#include "gap/show/learned_residual.hpp"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "core/errors.hpp"
#include "ensemble/residual_training.hpp"
#include "gap/fit/null_fit.hpp"
#include "gap/simulated_campaign.hpp"

using namespace leeway;

namespace {

// A drag that no module of the ship has.
Ship with_terms() {
  Ship ship = read_ship("esso-osaka-3m");
  ship.effects.push_back({"unknown", {{"X_uu", -0.03}, {"N_uv", 0.02}}, ship.file, "/effects/0"});
  return ship;
}

}  // namespace

TEST_CASE("learned residual: the same bits for any number of jobs, and about what was left out",
          "[gap][ensemble][long]") {
  const Ship stated = read_ship("esso-osaka-3m"), truth = with_terms();
  const std::vector<Trajectory> recordings = test::recorded({"esso-osaka-3m", 21, 3, 200.0, 1.0, 0.0}, truth);
  ensemble::ResidualTraining training;
  const auto network = ensemble::learn_residual(stated, recordings, training);
  training.jobs = 2;
  CHECK(to_json(*network) == to_json(*ensemble::learn_residual(stated, recordings, training)));

  // Along the recordings its accelerations are those that the stated ship lacks.
  const Model<double> lacks(stated), has(truth);
  Ship learned = stated;
  learned.residual_network = network;
  const Model<double> with(learned);
  double left = 0.0, missing = 0.0;
  for (const Trajectory& recording : recordings)
    for (std::size_t i = 0; i < recording.size(); ++i) {
      Inputs<double> inputs;
      for (const Channel channel : stated.actuator_channels())
        if (recording.has(channel)) inputs.actuators[channel] = recording[channel][i];
      const ShipState<double> state{
          Vec3<double>::Zero(),
          Vec3<double>(recording[Channel::u][i], recording[Channel::vm][i], recording[Channel::r][i])};
      const Vec3<double> wanted = rate_of_change(has, state, inputs).nu - rate_of_change(lacks, state, inputs).nu;
      const Vec3<double> got = rate_of_change(with, state, inputs).nu - rate_of_change(lacks, state, inputs).nu;
      left += (got - wanted).squaredNorm();
      missing += wanted.squaredNorm();
    }
  CHECK(left < 0.15 * missing);
}

TEST_CASE("learned residual: kept where it predicts what was left out better, not where nothing is missing",
          "[gap][long]") {
  const Ship stated = read_ship("esso-osaka-3m");
  const auto learned = [&](const Ship& truth) {
    gap::Campaign campaign = gap::prepare(stated, test::recorded({"esso-osaka-3m", 22, 3, 200.0, 1.0, 0.0}, truth), {});
    const gap::FittedNull fit = gap::fit_null(campaign, {2});
    std::vector<std::vector<gap::Run>> folds;
    for (const gap::Run& run : gap::whole_runs(campaign)) folds.push_back({run});
    return gap::learn_residual(campaign, fit.smoothed, stated, folds, fit.noise, 1, 2);
  };
  const gap::LearnedResidual some = learned(with_terms());
  CHECK(some.problem.empty());
  REQUIRE(some.network);
  CHECK(some.by_fold.size() == 3);
  CHECK(some.log_error_with < some.log_error_without - 0.3);
  const gap::LearnedResidual none = learned(stated);
  CHECK(none.problem.empty());
  CHECK(none.network == nullptr);
  CHECK(none.log_error_with > none.log_error_without - 0.05);
}

TEST_CASE("learned residual: a ship whose effects depend on the place has none, and says why", "[gap]") {
  Ship ship = read_ship("esso-osaka-3m");
  const std::vector<Trajectory> recordings = test::recorded({"esso-osaka-3m", 23, 1, 120.0, 1.0, 0.0}, ship);
  gap::Campaign campaign = gap::prepare(ship, recordings, {});
  const gap::FittedNull fit = gap::fit_null(campaign, {});
  ship.effects.push_back(
      {"bank", {{"wall_direction_deg", 0.0}, {"wall_distance_m", 60.0}, {"C_Y", 1.0}, {"C_N", 0.0}}, "s.json", "/e"});
  const gap::LearnedResidual learned =
      gap::learn_residual(campaign, fit.smoothed, ship, {gap::whole_runs(campaign)}, fit.noise, 1, 1);
  CHECK(learned.network == nullptr);
  CHECK_THAT(learned.problem, Catch::Matchers::Contains("depends on the place"));
}
