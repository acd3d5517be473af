#include "gap/gap_locate.hpp"

#include <catch2/catch.hpp>

#include "gap/perturbed_ship.hpp"
#include "gap/sensors/audit.hpp"
#include "gap/simulated_campaign.hpp"

using namespace leeway;

// The full study is scripts/gap-rates-table; this one knows gross failure.
TEST_CASE("gap-locate: wrong coefficients, large noise and random model error raise no alarm", "[gap][long]") {
  int mismatches = 0, faults = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const char* const name = seed % 2 == 0 ? "esso-osaka-3m" : "vectwin-3m";
    Ship truth = test::perturbed_ship(name, seed <= 2 ? 0.1 : 0.0, seed);
    if (seed == 3)
      truth.effects.push_back({"model-error",
                               {{"surge_mps2", 5e-4},
                                {"sway_mps2", 5e-4},
                                {"yaw_degps2", 0.04},
                                {"tau_s", 12.0},
                                {"seed", static_cast<double>(seed)}},
                               "ship.json",
                               "/effects/0"});
    std::vector<Trajectory> recordings =
        test::recorded({name, seed, 3, 150.0, 1.0, 0.5}, truth, {}, seed == 4 ? 3.0 : 1.0);
    const gap::Findings findings = gap::gap_locate(read_ship(name), recordings, {});
    CAPTURE(seed, findings.detection.reason);
    CHECK(findings.fit.converged);
    mismatches += findings.verdict == gap::Verdict::mismatch ? 1 : 0;
    faults += findings.audit.faults.empty() ? 0 : 1;
  }
  CHECK(mismatches == 0);
  CHECK(faults == 0);
}

TEST_CASE("gap-locate: a large ship sampled faster than it moves is fitted to a percent", "[gap][long]") {
  // Means over 8 s bend with the state, and the rudders move within them.
  const char* const name = "vectwin-150m";
  const Ship ship = read_ship(name);
  std::vector<Trajectory> recordings = test::recorded({name, 5, 3, 900.0, 1.0, 4.0}, ship);
  const gap::Findings findings = gap::gap_locate(ship, recordings, {});
  CAPTURE(findings.detection.reason);
  CHECK(findings.fit.step_s > 7.0);
  CHECK(findings.verdict == gap::Verdict::no_mismatch);
  for (int axis = 0; axis < 3; ++axis) CHECK(findings.fit.sigma_w[axis] < 0.01 * findings.fit.typical[axis]);
}

TEST_CASE("gap-locate: a wind that reads the wrong way round is found by short times or by the fit", "[gap][slow]") {
  const double wind_mps = GENERATE(0.7, 0.9, 1.2);
  CAPTURE(wind_mps);
  const Ship truth = test::perturbed_ship("vectwin-3m", 0.1, 2);
  std::vector<Trajectory> sound = test::recorded({"vectwin-3m", 6, 4, 200.0, 1.0, wind_mps}, truth);
  for (Trajectory& recording : sound) {
    recording[Channel::app_wind_speed].clear();  // which would tell at once
    recording[Channel::app_wind_dir].clear();
  }
  std::vector<Trajectory> recordings = sound;
  for (Trajectory& recording : recordings)
    for (double& from : recording[Channel::wind_dir]) from += kPi;
  const gap::Findings findings = gap::gap_locate(read_ship("vectwin-3m"), recordings, {});
  REQUIRE(findings.conventions.contradicted.size() == 1);
  CHECK(findings.conventions.contradicted[0].name == "wind-to");
  CHECK(findings.conventions.contradicted[0].log_odds > 10.0);
  // Read so, it is as if nothing had been turned round, but for where fits end.
  CHECK(findings.corrected);
  CHECK(findings.detection.p_value ==
        Approx(gap::gap_locate(read_ship("vectwin-3m"), sound, {}).detection.p_value).epsilon(0.2));
}

// The fit has events there, which its evidence without them does not.
TEST_CASE("gap-locate: a wind that reads the wrong way round is found where a tug pulls for a while", "[gap][slow]") {
  const double wind_mps = GENERATE(1.2, 1.8);
  CAPTURE(wind_mps);
  Ship truth = test::perturbed_ship("esso-osaka-3m", 0.1, 3);
  truth.effects.push_back(
      {"tug",
       {{"force_N", 2.0}, {"direction_deg", 290.0}, {"x_m", 1.0}, {"t_start_s", 80.0}, {"t_end_s", 130.0}},
       "ship.json",
       "/effects/0"});
  std::vector<Trajectory> recordings = test::recorded({"esso-osaka-3m", 7, 4, 200.0, 1.0, wind_mps}, truth);
  for (Trajectory& recording : recordings) {
    recording[Channel::app_wind_speed].clear();
    recording[Channel::app_wind_dir].clear();
    for (double& from : recording[Channel::wind_dir]) from += kPi;
  }
  gap::GapLocateOptions options;
  options.jobs = 2;
  const gap::Findings findings = gap::gap_locate(read_ship("esso-osaka-3m"), recordings, options);
  CHECK(findings.verdict == gap::Verdict::mismatch);
  REQUIRE(findings.conventions.contradicted.size() == 1);
  CHECK(findings.conventions.contradicted[0].name == "wind-to");
}

// What is left of a bias after it was taken out by the audit's estimate had p-values down to 1e-19.
TEST_CASE("gap-locate: a heading bias is found with the simulator's help, and leaves no missing physics",
          "[gap][slow]") {
  std::size_t told_by_audit = 0;
  for (const std::uint64_t seed : {2, 3}) {
    std::vector<Trajectory> recordings =
        test::recorded({"esso-osaka-3m", seed, 3, 240.0, 1.0, 0.5}, test::perturbed_ship("esso-osaka-3m", 0.05, 2));
    for (Trajectory& recording : recordings)
      for (double& psi : recording[Channel::psi]) psi += 0.4 * kDegree;
    gap::AuditOptions audit_options;
    audit_options.false_alarm = 0.01 / 7.5;
    told_by_audit += gap::audit(recordings, audit_options).faults.size();
    gap::GapLocateOptions options;
    options.jobs = 2;
    const gap::Findings findings = gap::gap_locate(read_ship("esso-osaka-3m"), recordings, options);
    CAPTURE(seed);
    REQUIRE(findings.audit.faults.size() == 1);
    CHECK(findings.audit.faults[0].name == "heading-bias");
    CHECK(findings.audit.faults[0].parameters[0].value == Approx(0.4).margin(0.03));
    CHECK(findings.audit.faults[0].p_value < 0.01);
    CHECK_THAT(findings.audit.faults[0].sentence, Catch::Matchers::Contains("the heading is 0.4"));
    CHECK(findings.detection.p_value > 0.1);
  }
  CHECK(told_by_audit == 1);  // the other is left open by the kinematics
}
