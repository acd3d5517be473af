#include "gap/decide/ship_file.hpp"

#include <cmath>

#include <catch2/catch.hpp>

using namespace leeway::gap;

TEST_CASE("ship file: a coefficient is off where it is likelier off by far more than stated than not",
          "[gap][decide]") {
  FittedCoefficient c;
  c.stated_sd = 0.1;
  c.may_be_far = true;
  c.shift = std::log(1.5);  // wherever it is
  c.shift_sd = 0.02;
  c.far_off = 0.49;
  CHECK_FALSE(is_off(c));
  c.far_off = 0.51;
  CHECK(is_off(c));
}

TEST_CASE(
    "ship file: what has no such probability is off where its interval lies beyond two stated standard deviations",
    "[gap][decide]") {
  FittedCoefficient c;
  c.stated_sd = 0.1;
  c.shift = std::log(1.3);
  c.shift_sd = 0.02;
  CHECK(is_off(c));
  c.shift = -c.shift;
  CHECK(is_off(c));
  c.shift_sd = 0.05;  // 0.26 - 2 x 0.05 is within 0.2
  CHECK_FALSE(is_off(c));
  c.shift = std::log(1.15);
  c.shift_sd = 0.001;
  CHECK_FALSE(is_off(c));
}

TEST_CASE("ship file: a module is off where it predicts better than any of them would by chance, and free runs follow",
          "[gap][decide]") {
  CalibratedModule module;
  module.helps_free_runs = true;
  module.gain = 7.0;  // nats; ln(5/0.01) is 6.2
  CHECK(is_off(module, 5, 0.01));
  CHECK_FALSE(is_off(module, 50, 0.01));
  module.helps_free_runs = false;
  CHECK_FALSE(is_off(module, 5, 0.01));
}

TEST_CASE("ship file: what is not known is not called as stated", "[gap][decide]") {
  ShipFileFound found;
  found.samples = 5000;
  found.determined = 8.0;
  CHECK(decide_ship_file(found) == ShipFileState::as_stated);
  found.is_off = true;
  CHECK(decide_ship_file(found) == ShipFileState::off);
  found.is_spoiled = true;
  CHECK(decide_ship_file(found) == ShipFileState::cannot_tell);
  found = {};
  found.samples = 5000;
  CHECK(decide_ship_file(found) == ShipFileState::cannot_tell);  // no coefficient is known better than before
  found.determined = 8.0;
  found.samples = 100;
  CHECK(decide_ship_file(found) == ShipFileState::cannot_tell);
  found.samples = 5000;
  found.keeps_course = true;
  CHECK(decide_ship_file(found) == ShipFileState::cannot_tell);
  found.keeps_course = false;
  found.converged = false;
  CHECK(decide_ship_file(found) == ShipFileState::cannot_tell);
}
