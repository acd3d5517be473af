// Uncertainties of values, for coefficients whose sign is not certain: stated, drawn, written and fitted.
#include <cmath>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "core/errors.hpp"
#include "dynamics/ship_draws.hpp"
#include "gap/filter/uncertainty.hpp"
#include "io/files.hpp"

using namespace leeway;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

io::Json l7() { return io::read_json(io::find_config("ships", "kvlcc2-l7")); }

Ship l7_with(const io::Json& more) {
  io::Json json = l7();
  json.update(more);
  return parse_ship(json, "ship.json");
}

double value_of(const Ship& ship, const std::string& name) {
  for (const Coefficient& c : Model<double>(ship).coefficients())
    if (c.name == name) return c.value.value();
  throw std::out_of_range(name);
}

const io::Json kAbsolute{
    {"uncertainty", {{"hull.Y_r", {{"sd", 0.08}}}, {"hull.X_vr", {{"sd", 0.05}}}, {"hull.Y_v", 0.1}}}};

}  // namespace

TEST_CASE("absolute uncertainty: shifts are added after factors", "[dynamics][law]") {
  const Ship ship =
      l7_with({{"coefficient_factors", {{"hull.Y_r", 2.0}}}, {"coefficient_shifts", {{"hull.Y_r", -0.3}}}});
  CHECK_THAT(value_of(ship, "hull.Y_r"), WithinAbs(2.0 * 0.083 - 0.3, 1e-15));
  Ship more = ship;
  more.multiply({{"hull.Y_r", 0.5, 0.01}});
  CHECK_THAT(value_of(more, "hull.Y_r"), WithinAbs(0.5 * (2.0 * 0.083 - 0.3) + 0.01, 1e-15));
  // Written and read back it is the same.
  const io::Json written = multiplied(l7(), {{"hull.Y_r", 2.0, -0.3}}, "a test");
  CHECK_THAT(value_of(parse_ship(multiplied(written, {{"hull.Y_r", 0.5, 0.01}}, "a test"), "ship.json"), "hull.Y_r"),
             WithinAbs(value_of(more, "hull.Y_r"), 1e-15));
}

TEST_CASE("absolute uncertainty: draws have the stated mean, spread and both signs", "[dynamics][law]") {
  const Ship ship = l7_with(kAbsolute);
  const CoefficientLaw law = coefficient_law(ship);
  RandomStream random(5, "absolute");
  constexpr int kDraws = 4000;
  double sum = 0.0, squares = 0.0;
  int negative = 0;
  for (int i = 0; i < kDraws; ++i)
    for (const CoefficientFactor& by : draw_factors(law, 1.0, random)) {
      if (by.name != "hull.Y_r") continue;
      CHECK(by.factor == 1.0);
      sum += by.shift;
      squares += by.shift * by.shift;
      negative += 0.083 + by.shift < 0.0 ? 1 : 0;
    }
  CHECK_THAT(sum / kDraws, WithinAbs(0.0, 4.0 * 0.08 / std::sqrt(kDraws)));
  CHECK_THAT(std::sqrt(squares / kDraws), WithinRel(0.08, 0.05));
  CHECK_THAT(static_cast<double>(negative) / kDraws, WithinAbs(0.150, 0.025));  // a normal law below -0.083/0.08 sd
}

TEST_CASE("absolute uncertainty: a covariance is of values for such names", "[dynamics][law]") {
  io::Json more = kAbsolute;
  more["coefficient_covariance"] = {{"names", {"hull.Y_r", "hull.X_vr", "hull.Y_v"}},
                                    {"matrix", {{25e-10, 0, 0}, {0, 25e-4, -2e-3}, {0, -2e-3, 0.01}}}};
  const CoefficientLaw law = coefficient_law(l7_with(more));
  for (std::size_t i = 0; i < law.coefficients.size(); ++i)
    if (law.coefficients[i].name == "hull.Y_r") {
      CHECK(law.coefficients[i].is_absolute);
      CHECK_THAT(law.coefficients[i].sd, WithinRel(5e-5, 1e-12));  // a log-sd would have to be 1e-4 at least
    }
}

TEST_CASE("absolute uncertainty: a group cannot have it", "[dynamics][law]") {
  CHECK_THROWS_WITH(coefficient_law(l7_with({{"uncertainty", {{"propeller.K_T", {{"sd", 0.1}}}}}})),
                    Contains("/uncertainty/propeller.K_T") && Contains("no single number"));
  CHECK_THROWS_WITH(Model<double>(l7_with({{"coefficient_shifts", {{"propeller.K_T", 0.1}}}})),
                    Contains("/coefficient_shifts/propeller.K_T"));
  CHECK_THROWS_WITH(l7_with({{"uncertainty", {{"hull.Y_r", {{"log_sd", 0.1}}}}}}), Contains("/uncertainty/hull.Y_r"));
}

TEST_CASE("absolute uncertainty: a model moves by theta, and the gap tools read it so", "[dynamics][law]") {
  const Ship ship = l7_with(kAbsolute);
  const std::vector<gap::UncertainParameter> parameters = gap::uncertain_parameters(ship);
  Eigen::VectorXd theta = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(parameters.size()));
  std::vector<CoefficientFactor> changes;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    if (parameters[i].name == "hull.Y_r") {
      CHECK(parameters[i].is_absolute);
      CHECK(parameters[i].sd == 0.08);
      theta(static_cast<Eigen::Index>(i)) = -0.1;
    }
    if (parameters[i].name == "hull.Y_v") theta(static_cast<Eigen::Index>(i)) = 0.2;
    if (theta(static_cast<Eigen::Index>(i)) != 0.0)
      changes.push_back(gap::changed(parameters[i], theta(static_cast<Eigen::Index>(i))));
  }
  Model<double> moved(ship);
  gap::apply_uncertainty(moved, theta);
  Ship written = ship;
  written.multiply(changes);
  const Model<double> read(written);
  for (const Model<double>* model : {&static_cast<const Model<double>&>(moved), &read})
    for (const Coefficient& c : model->coefficients()) {
      if (c.name == "hull.Y_r") CHECK_THAT(c.value.value(), WithinAbs(0.083 - 0.1, 1e-15));
      if (c.name == "hull.Y_v") CHECK_THAT(c.value.value(), WithinRel(-0.315 * std::exp(0.2), 1e-12));
    }
}
