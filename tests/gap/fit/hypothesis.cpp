#include "gap/fit/hypothesis.hpp"

#include <catch2/catch.hpp>

#include "core/errors.hpp"
#include "core/units.hpp"
#include "gap/detect/effect_library.hpp"
#include "gap/detect/screen.hpp"
#include "gap/fit/null_fit.hpp"
#include "gap/perturbed_ship.hpp"
#include "gap/policy/policy.hpp"
#include "gap/simulated_campaign.hpp"

using namespace leeway;
using Catch::Matchers::WithinAbs;

namespace {

Eigen::VectorXd at(std::initializer_list<double> z) {
  return Eigen::Map<const Eigen::VectorXd>(z.begin(), static_cast<Eigen::Index>(z.size()));
}

gap::FitOptions two_fit_jobs() {
  gap::FitOptions options;
  options.jobs = 2;
  return options;
}

}  // namespace

TEST_CASE("hypothesis: coordinates stand for parameters in the units of their priors", "[gap]") {
  const Ship ship = read_ship("esso-osaka-3m");
  const gap::FreeEffect current("steady-current", ship);
  REQUIRE(current.size() == 2);
  CHECK(current.neutral() == at({0.0, 0.0}));
  CHECK(current.values(at({1.0, 0.0}))[0] == Approx(0.04).epsilon(1e-3));
  CHECK(current.values(at({0.0, 2.0}))[0] == Approx(0.08).epsilon(3e-3));
  CHECK(current.values(at({0.0, 2.0}))[1] == Approx(90.0));
  CHECK(current.values(at({0.0, -1.0}))[1] == Approx(270.0));
  CHECK(current.values(at({9.0, 0.0}))[0] == Approx(0.15));  // bounds are hard

  const gap::FreeEffect thrust("thrust-loss", ship);
  CHECK(thrust.values(at({-9.0}))[0] == Approx(gap::kPolicy.fit.least_factor));
  CHECK(thrust.values(at({9.0}))[0] == Approx(1.1));
  CHECK(thrust.values(*thrust.neutral())[0] == Approx(1.0));

  const gap::FreeEffect delay("actuator-delay", ship);
  CHECK(delay.values(at({0.0}))[0] == Approx(1.5));
  CHECK_FALSE(delay.neutral());

  const gap::FreeEffect waves("wave-drift", ship, 350.0);
  CHECK(waves.has_bare_direction());
  CHECK(waves.values(at({0.0, 0.0}))[1] == Approx(350.0));
  CHECK(waves.values(at({0.0, 0.2}))[1] == Approx(350.0 + 0.2 * 143.6195 - 360.0));

  CHECK(gap::FreeEffect("propeller-walk", ship).size() == 2);

  // Four gradients and the velocity at the origin as a vector: nothing at z = 0.
  const gap::FreeEffect shear("sheared-current", ship);
  REQUIRE(shear.size() == 6);
  CHECK(shear.neutral() == Eigen::VectorXd(Eigen::VectorXd::Zero(6)));
  CHECK(shear.values(at({0.0, 2.0, 0.0, 0.0, 0.0, -1.0}))[1] == Approx(0.01));
  CHECK(shear.values(at({0.0, 2.0, 0.0, 0.0, 0.0, -1.0}))[4] == Approx(0.04).epsilon(1e-3));
  CHECK(shear.values(at({0.0, 2.0, 0.0, 0.0, 0.0, -1.0}))[5] == Approx(270.0));

  // A reading that is right is neutral, a rudder that does not stall has no finite angle.
  const gap::FreeEffect anemometer("anemometer", ship);
  REQUIRE(anemometer.neutral());
  CHECK(anemometer.values(*anemometer.neutral())[0] == Approx(1.0).epsilon(1e-12));
  CHECK_THAT(anemometer.values(*anemometer.neutral())[1], WithinAbs(0.0, 1e-12));
  const gap::FreeEffect stall("rudder-stall", ship);
  CHECK(stall.size() == 1);
  CHECK_FALSE(stall.neutral());

  // Bound to a place, which is given: the strengths are free. No column of the screen stands for them.
  gap::FreeEffect::Choice quay;
  quay.fixed = {{"wall_distance_m", 4.0}, {"wall_direction_deg", 90.0}};
  const gap::FreeEffect bank("bank", ship, quay);
  CHECK(bank.size() == 2);
  CHECK_FALSE(bank.has_bare_direction());
  CHECK(bank.values(at({0.0, 1.0}))[0] == 4.0);
  CHECK(bank.values(at({0.0, 1.0}))[3] == Approx(0.01 * std::exp(0.8)).epsilon(1e-3));
  CHECK(bank.log_strengths() == std::vector<Eigen::Index>{0, 1});
  CHECK(gap::FreeEffect("wave-drift", ship).log_strengths() == std::vector<Eigen::Index>{0});  // not its direction
  CHECK(stall.log_strengths().empty());
  for (const char* name : {"bank", "fender", "mooring", "tug"}) CHECK_FALSE(is_screened(search_start(name)));
  for (const char* name : {"sheared-current", "anemometer", "rudder-stall"}) CHECK(is_screened(search_start(name)));

  // At full scale the priors are others.
  CHECK(gap::FreeEffect("steady-current", read_ship("vectwin-150m")).values(at({1.0, 0.0}))[0] == Approx(0.3));
  // A single rudder has one strength, two have their own.
  CHECK(gap::FreeEffect("rudder-effectiveness", ship).size() == 1);
  CHECK(gap::FreeEffect("rudder-effectiveness", read_ship("vectwin-3m")).size() == 3);
  CHECK_THROWS_AS(gap::FreeEffect("sea-monster", ship), UsageError);
  CHECK_THROWS_AS(gap::FreeEffect("thruster-gain", read_ship("kvlcc2-l7")), EffectNotApplicable);
}

TEST_CASE("hypothesis: no value is likelier than its prior says, also at its bounds", "[gap]") {
  const Ship ship = read_ship("esso-osaka-3m");
  // A log-normal factor on the thrust, cut off on both sides.
  const gap::FreeEffect thrust("thrust-loss", ship);
  const auto below = [](double x) {
    return 0.5 * std::erfc(-std::log(x / 0.95) / gap::kPolicy.fit.factor_log_sd / std::sqrt(2.0));
  };
  const double low = below(gap::kPolicy.fit.least_factor), high = below(1.1);
  for (double z = -3.0; z < 3.1; z += 0.5) {
    CAPTURE(z);
    const double share = 0.5 * std::erfc(-z / std::sqrt(2.0));
    CHECK((below(thrust.values(at({z}))[0]) - low) / (high - low) == Approx(share).epsilon(1e-6));
  }
  // A current's speed.
  const gap::FreeEffect current("steady-current", ship);
  const auto slower = [](double speed) { return 1.0 - std::exp(-0.5 * std::pow(speed / 0.04, 2)); };
  for (const double length : {0.1, 1.0, 2.5, 4.0}) {
    CAPTURE(length);
    const double share = 1.0 - std::exp(-0.5 * length * length);
    CHECK(slower(current.values(at({0.6 * length, -0.8 * length}))[0]) / slower(0.15) == Approx(share).epsilon(1e-6));
  }
}

TEST_CASE("hypothesis: effects are added to the ship as its JSON would have them", "[gap]") {
  const Ship ship = read_ship("esso-osaka-3m");
  const gap::Hypothesis both{{gap::FreeEffect("steady-current", ship), gap::FreeEffect("rudder-offset", ship)}};
  CHECK(both.size() == 3);
  CHECK(both.name() == "steady-current + rudder-offset");
  CHECK(gap::Hypothesis{}.name() == "none");
  const Ship with = both.applied_to(ship, at({0.0, 1.0, -2.0}));
  REQUIRE(with.effects.size() == ship.effects.size() + 2);
  CHECK(with.effects.back().type == "rudder-offset");
  CHECK(*with.effects.back().parameters[0].second == Approx(-2.0));
  CHECK_NOTHROW(Model<double>(with));
}

TEST_CASE("hypothesis: intervals of a speed and its direction", "[gap]") {
  const gap::FreeEffect current("steady-current", read_ship("esso-osaka-3m"));
  const auto parameters = current.parameters(at({1.0, 0.0}), 0.01 * Eigen::MatrixXd::Identity(2, 2));
  REQUIRE(parameters.size() == 2);
  CHECK(parameters[0].estimate == Approx(0.04).epsilon(1e-3));
  CHECK_FALSE(parameters[0].is_at_bound);
  CHECK(parameters[0].sd == Approx(0.004).epsilon(0.1));
  CHECK(parameters[0].low == Approx(0.04 - 1.96 * 0.004).epsilon(0.03));
  CHECK(parameters[1].name == "current_set_deg");
  CHECK(parameters[1].estimate == Approx(0.0));
  CHECK(parameters[1].low < 0.0);  // about the estimate: -11 deg, and not 349
  CHECK(parameters[1].high == Approx(1.96 * 0.1 / kDegree).epsilon(0.06));
}

TEST_CASE("hypothesis: an interval says what the recordings do, whatever was believed before", "[gap]") {
  const Ship ship = read_ship("esso-osaka-3m");
  const gap::FreeEffect offset("rudder-offset", ship);  // z: deg, standard normal before
  const double recorded = -5.5, variance = 0.25, believed = 1.0;
  const double after = 1.0 / (1.0 / variance + believed);
  const gap::Coordinates posterior{at({after * recorded / variance}), after * Eigen::MatrixXd::Identity(1, 1)};
  const gap::Coordinates alone = gap::without_prior(posterior);
  CHECK(alone.mean[0] == Approx(recorded));
  CHECK(alone.covariance(0, 0) == Approx(variance));
  const auto interval = offset.intervals(posterior.mean, alone.mean - posterior.mean, alone.covariance).front();
  CHECK(interval.low == -6.0);                                    // the catalogue's bound, not the normal's -6.5
  CHECK(interval.high == offset.values(posterior.mean).front());  // the estimate belongs to it
  CHECK(offset.parameters(posterior.mean, posterior.covariance).front().low > recorded);
  // What was not measured is anything.
  const gap::Coordinates nothing = gap::without_prior({at({0.0}), Eigen::MatrixXd::Identity(1, 1)});
  CHECK(std::sqrt(nothing.covariance(0, 0)) == Approx(gap::kPolicy.fit.farthest));
}

TEST_CASE("hypothesis: an interval of a vector goes on about its direction", "[gap]") {
  const gap::FreeEffect current("steady-current", read_ship("esso-osaka-3m"));
  const Eigen::VectorXd best = at({1.0, 0.0});
  const auto plain = current.parameters(best, 0.01 * Eigen::MatrixXd::Identity(2, 2));
  const auto same = current.intervals(best, at({0.0, 0.0}), 0.01 * Eigen::MatrixXd::Identity(2, 2));
  REQUIRE(same.size() == plain.size());
  for (std::size_t i = 0; i < plain.size(); ++i) {
    CHECK(same[i].low == Approx(plain[i].low));
    CHECK(same[i].high == Approx(plain[i].high));
  }
}

TEST_CASE("hypothesis: a formula that is a tenth off moves strengths and directions by as much", "[gap]") {
  const Ship ship = read_ship("esso-osaka-3m");
  const gap::FreeEffect waves("wave-drift", ship);  // (hs, wave_from)
  const Eigen::VectorXd z = at({0.5, 0.2}), sd = waves.sd_of_formula(z);
  REQUIRE(sd.size() == 2);
  CHECK(waves.values(z + at({sd[0], 0.0}))[0] == Approx(std::exp(0.1) * waves.values(z)[0]).epsilon(1e-4));
  CHECK(waves.values(z + at({0.0, sd[1]}))[1] - waves.values(z)[1] == Approx(0.1 / kDegree));
  const gap::FreeEffect wind("unmeasured-wind", ship);
  CHECK(wind.sd_of_formula(at({3.0, 4.0})) == at({0.5, 0.5}));
  CHECK(gap::FreeEffect("steady-current", ship).sd_of_formula(at({3.0, 4.0})).isZero());
}

TEST_CASE("hypothesis: planted effects are fitted beside wrong coefficients", "[gap][long]") {
  struct Planted {
    std::string effect;
    std::vector<std::pair<std::string, std::optional<double>>> parameters;
  };
  const Planted all[] = {
      {"steady-current", {{"current_speed_mps", 0.05}, {"current_set_deg", 140.0}}},
      {"rudder-offset", {{"rudder_offset_deg", 2.0}}},
      {"actuator-delay", {{"delay_s", 1.2}}},
      {"wave-drift", {{"hs_m", 0.02}, {"wave_from_deg", 250.0}}},
      {"earth-force", {{"force_N", 0.3}, {"direction_deg", 20.0}}},
  };
  const Ship stated = read_ship("esso-osaka-3m");
  std::uint64_t seed = 0;
  for (const Planted& planted : all) {
    CAPTURE(planted.effect);
    Ship truth = test::perturbed_ship("esso-osaka-3m", 0.05, ++seed);
    truth.effects.push_back({planted.effect, planted.parameters, "ship.json", "/effects/0"});
    gap::Campaign campaign =
        gap::prepare(stated, test::recorded({"esso-osaka-3m", seed, 4, 200.0, 1.0, 0.5}, truth), {});
    const gap::FittedNull null = gap::fit_null(campaign, two_fit_jobs());
    const std::vector<gap::Start> starts = gap::starts_of(planted.effect, campaign, null, 2);
    const gap::FittedNull fit =
        gap::fit_with(campaign, null, starts.front().hypothesis, starts.front().theta, two_fit_jobs());
    CHECK((fit.report.converged || fit.report.distance < 0.3));  // kinks of the model let the last steps go to and fro
    CHECK(gap::log_evidence(fit) > gap::log_evidence(null) + 5.0);
    const gap::Coordinates z = gap::coordinates_of(fit);
    const auto found = starts.front().hypothesis.effects[0].parameters(z.mean, z.covariance);
    for (const auto& [name, value] : planted.parameters)
      for (const auto& parameter : found)
        if (parameter.name == name) {
          CAPTURE(name, parameter.estimate, parameter.sd);
          double error = parameter.estimate - *value;
          if (name.ends_with("_deg") && name != "rudder_offset_deg") error = std::remainder(error, 360.0);
          CHECK_THAT(error, WithinAbs(0.0, 3.5 * parameter.sd));
        }
  }
}

TEST_CASE("hypothesis: a fit that throws leaves nothing behind", "[gap]") {
  const Ship stated = read_ship("esso-osaka-3m");
  const gap::Campaign campaign =
      gap::prepare(stated, test::recorded({"esso-osaka-3m", 5, 2, 120.0, 1.0, 0.5}, stated), {});
  const gap::FittedNull null = gap::fit_null(campaign, two_fit_jobs());
  const std::vector<gap::Start> late = gap::starts_of("actuator-delay", campaign, null, 2);
  const std::vector<gap::Start> current = gap::starts_of("steady-current", campaign, null, 2);
  const auto with_current = [&] {
    return gap::fit_with(campaign, null, current.front().hypothesis, current.front().theta, two_fit_jobs());
  };
  const gap::FittedNull before = with_current();
  // The rudders follow late, and a resistance that pushes sends the simulator to infinity.
  Eigen::VectorXd runaway = late.front().theta;
  runaway[runaway.size() - 2] = 1.0;
  runaway.head(runaway.size() - 2).setConstant(400.0);
  CHECK_THROWS_AS(gap::fit_with(campaign, null, late.front().hypothesis, runaway, two_fit_jobs()), NumericalError);
  const gap::FittedNull after = with_current();
  CHECK(after.theta == before.theta);
  CHECK(gap::log_evidence(after) == gap::log_evidence(before));
  for (std::size_t s = 0; s < campaign.stretches.size(); ++s)
    CHECK(null.stretches[s].data->measured.size() == campaign.stretches[s].measured.size());
}

TEST_CASE("hypothesis: a fit outlives its campaign, and so do copies of it", "[gap]") {
  const Ship stated = read_ship("esso-osaka-3m");
  std::vector<gap::FittedNull> copies;
  double evidence = 0.0;
  {
    const gap::Campaign campaign =
        gap::prepare(stated, test::recorded({"esso-osaka-3m", 6, 2, 120.0, 1.0, 0.5}, stated), {});
    const gap::FittedNull fit = gap::fit_null(campaign, two_fit_jobs());
    evidence = gap::log_evidence(fit);
    copies.assign(2, fit);
  }
  const gap::FittedNull moved = std::move(copies.front());
  copies.clear();
  gap::Evidence total(moved.theta.size());
  for (const gap::LinearStretch& stretch : moved.stretches) total += gap::evidence(stretch, moved.noise);
  CHECK(total.log_likelihood == Approx(moved.total.log_likelihood).epsilon(1e-12));
  CHECK(gap::log_evidence(moved) == evidence);
}

TEST_CASE("hypothesis: where nothing is missing, no effect gains evidence worth telling", "[gap][long]") {
  const Ship stated = read_ship("esso-osaka-3m");
  gap::Campaign campaign = gap::prepare(
      stated, test::recorded({"esso-osaka-3m", 3, 4, 200.0, 1.0, 0.5}, test::perturbed_ship("esso-osaka-3m", 0.1, 9)),
      {});
  const gap::FittedNull null = gap::fit_null(campaign, two_fit_jobs());
  for (const char* const effect : {"steady-current", "rudder-offset", "thrust-loss", "earth-force"}) {
    CAPTURE(effect);
    const std::vector<gap::Start> starts = gap::starts_of(effect, campaign, null, 2);
    const gap::FittedNull fit =
        gap::fit_with(campaign, null, starts.front().hypothesis, starts.front().theta, two_fit_jobs());
    CHECK(gap::log_evidence(fit) < gap::log_evidence(null) + 3.0);
  }
}
