#include "gap/decide/sensors.hpp"

#include <cmath>

#include <catch2/catch.hpp>

#include "gap/decide/decide.hpp"

using namespace leeway;

TEST_CASE("decide: when a fault of a sensor is found", "[gap][decide]") {
  const double rate = 0.01;
  struct Row {
    const char* what;
    gap::FaultTest test;
    bool predicts_better, is_found;
  };
  const Row rows[] = {
      {"significant, two standard errors", {0.009, 2.1, 1.0}, true, true},
      {"significant, less than two", {0.009, 1.9, 1.0}, false, false},
      {"certain: one is enough", {0.0009, 1.1, 1.0}, true, true},
      {"certain, less than one", {0.0009, 0.9, 1.0}, false, false},
      {"predicts better, but not significant", {0.011, 5.0, 1.0}, true, false},
      {"no spread between units, no gain", {1e-9, 0.0, 0.0}, false, false},
  };
  for (const Row& row : rows) {
    CAPTURE(row.what);
    CHECK(gap::predicts_better(row.test, rate) == row.predicts_better);
    CHECK(gap::is_found(row.test, rate) == row.is_found);
  }
  gap::Policy policy;
  policy.sensors.heldout_sd = 1.5;
  CHECK(gap::is_found({0.009, 1.9, 1.0}, rate, policy));
}

TEST_CASE("decide: of which faults the simulator is asked, and which it identifies", "[gap][decide]") {
  const double rate = 0.01;
  CHECK(gap::is_faint(gap::kPolicy.decide.families * 1.01e-4, rate));
  CHECK_FALSE(gap::is_faint(gap::kPolicy.decide.families * 0.99e-4, rate));
  CHECK(gap::is_identified({6.0, 0.0, 0.009, 5.0, 2.0}, rate));
  CHECK_FALSE(gap::is_identified({6.0, 0.0, 0.011, 5.0, 2.0}, rate));  // no rarer than the rate where nothing is wrong
  CHECK_FALSE(gap::is_identified({6.0, 0.0, 0.009, 5.0, 3.0}, rate));  // in what was left out it may be chance
  CHECK(gap::is_identified({6.0, 0.0, 0.0009, 5.0, 3.0}, rate));
  CHECK(gap::is_identified({20.0, 16.9, 1e-6, 5.0, 2.0}, rate));
  CHECK_FALSE(gap::is_identified({20.0, 17.1, 1e-6, 5.0, 2.0}, rate));  // an effect does as well
}

TEST_CASE("decide: when another reading of a channel is claimed", "[gap][decide]") {
  CHECK(gap::holds_by_kinematics({10.0, 2.0, true}));
  CHECK_FALSE(gap::holds_by_kinematics({9.9, 2.0, true}));
  CHECK_FALSE(gap::holds_by_kinematics({10.0, 1.9, true}));
  CHECK_FALSE(gap::holds_by_kinematics({10.0, 2.0, false}));
  CHECK(gap::holds_by_forces({10.1, 1.31, true}));
  CHECK_FALSE(gap::holds_by_forces({10.0, 1.31, true}));
  CHECK_FALSE(gap::holds_by_forces({10.1, 1.3, true}));
  CHECK_FALSE(gap::holds_by_forces({10.1, 1.31, false}));
  // Against no force at all less is asked than against one that is wrong.
  CHECK(gap::beats_plain_error({5.1, 1.2, true}, 0.0));
  CHECK_FALSE(gap::beats_plain_error({5.1, 1.2, true}, 0.7));
  CHECK(gap::beats_plain_error({5.1, 1.31, true}, 0.7));
  CHECK_FALSE(gap::beats_plain_error({5.0, 1.31, true}, 0.7));
  CHECK_FALSE(gap::beats_plain_error({5.1, 1.31, false}, 0.0));
}
