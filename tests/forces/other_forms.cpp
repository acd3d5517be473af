#include <array>
#include <cmath>

#include <catch2/catch.hpp>

#include "core/units.hpp"
#include "dynamics/coefficient_law.hpp"
#include "dynamics/model.hpp"
#include "forces/unified_hull.hpp"
#include "forces/wind_form.hpp"
#include "gap/filter/uncertainty.hpp"
#include "ship/ship.hpp"

using namespace leeway;

namespace {

Vec3<double> hull_force(const Ship& ship, const Vec3<double>& nu) {
  return Model<double>(ship).forces(nu, Actuators<double>(), Vec2<double>::Zero()).hull;
}

Vec3<double> wind_force(const Ship& ship, double speed, double from_deg) {
  const double at = from_deg * kDegree;
  return Model<double>(ship)
      .forces(Vec3<double>::Zero(), Actuators<double>(), speed * Vec2<double>(std::cos(at), std::sin(at)))
      .wind;
}

Ship with_factors(const char* name, const std::vector<CoefficientFactor>& factors) {
  Ship ship = read_ship(name);
  ship.multiply(factors);
  return ship;
}

}  // namespace

TEST_CASE("other forms: the drag of a hull's ends is the integral over its length", "[forces]") {
  for (const double v : {-0.7, -0.2, 0.0, 0.1, 0.499, 0.501, 0.9})
    for (const double b : {-0.5, -0.1, 0.0, 0.3, 0.5}) {
      double force = 0.0, moment = 0.0;
      const int n = 20000;
      for (int i = 0; i < n; ++i) {
        const double s = -1.0 + 2.0 * (i + 0.5) / n, w = v + b * s;
        force += (s * s - 1.0 / 3.0) * std::abs(w) * w / n;
        moment += 0.5 * s * (s * s - 1.0 / 3.0) * std::abs(w) * w / n;
      }
      CAPTURE(v, b);
      const Vec2<double> closed = cross_flow_integrals_of_ends(v, b);
      CHECK(closed(0) == Approx(force).margin(1e-8));
      CHECK(closed(1) == Approx(moment).margin(1e-8));
    }
}

TEST_CASE("other forms: a term of 1 changes nothing, others do what they say", "[forces]") {
  const double L = read_ship("vectwin-3m").particulars.L_pp;
  const Vec3<double> drifting(0.8 * std::cos(30.0 * kDegree), -0.8 * std::sin(30.0 * kDegree), 0.0);
  for (const char* name : {"vectwin-3m", "kvlcc2-l7"}) {
    CAPTURE(name);
    const Ship own = read_ship(name);
    const Vec3<double> before = hull_force(own, drifting);
    CHECK(hull_force(with_factors(name, {{"hull.Y_v_30deg", 1.0}, {"hull.N_v_30deg", 1.0}}), drifting) == before);
    // At 30 deg as much as Y_v itself by the same share.
    const double by_form = (hull_force(with_factors(name, {{"hull.Y_v_30deg", 1.1}}), drifting) - before)(1);
    const double by_Y_v = (hull_force(with_factors(name, {{"hull.Y_v", 1.0 + std::log(1.1)}}), drifting) - before)(1);
    CHECK(by_form == Approx(by_Y_v));
    CHECK(std::abs(by_form) > 1e-3 * std::abs(before(1)));
  }
  const Vec3<double> across(0.0, 0.5, 0.0), before = hull_force(read_ship("vectwin-3m"), across);
  const Vec3<double> forward = hull_force(with_factors("vectwin-3m", {{"hull.C_D_arm", std::exp(0.1)}}), across);
  CHECK(forward(1) == Approx(before(1)));
  CHECK(forward(2) - before(2) == Approx(0.1 * L * before(1)));

  const auto wind = [](const char* term, double by, double deg) {
    return Vec3<double>(wind_force(with_factors("vectwin-3m", {{term, std::exp(by)}}), 5.0, deg));
  };
  const Ship own = read_ship("vectwin-3m");
  for (const double deg : {0.0, 40.0, 90.0, 140.0, 180.0, 250.0}) {
    CAPTURE(deg);
    const Vec3<double> plain = wind_force(own, 5.0, deg);
    const double cosine = std::cos(deg * kDegree);
    CHECK(wind("wind.X_astern", 0.2, deg)(0) == Approx(plain(0) * (1.0 + 0.1 * (1.0 - cosine))));
    CHECK(wind("wind.Y_oblique", 0.2, deg)(1) == Approx(plain(1) * (1.0 + 0.2 * cosine * cosine)).margin(1e-12));
    CHECK(wind("wind.Y_ahead", 0.2, deg)(1) == Approx(plain(1) * (1.0 + 0.2 * cosine)).margin(1e-12));
    CHECK(wind("wind.arm", 0.05, deg)(2) == Approx(plain(2) + 0.05 * L * plain(1)).margin(1e-12));
    CHECK(wind("wind.arm_ahead", 0.05, deg)(2) == Approx(plain(2) + 0.05 * cosine * L * plain(1)).margin(1e-12));
  }
}

TEST_CASE("other forms: port and starboard are alike", "[forces]") {
  for (const char* name : {"vectwin-3m", "kvlcc2-l7"}) {
    std::vector<CoefficientFactor> factors;
    for (const Coefficient& c : Model<double>(read_ship(name)).coefficients())
      if (c.is_form) factors.push_back({c.name, 1.3});
    REQUIRE(factors.size() >= 4);
    const Ship ship = with_factors(name, factors);
    for (const Vec3<double>& nu :
         {Vec3<double>(0.5, 0.1, 0.1), Vec3<double>(0.1, -0.3, 0.4), Vec3<double>(-0.3, 0.1, 0.02)}) {
      const Vec3<double> one = hull_force(ship, nu), other = hull_force(ship, {nu(0), -nu(1), -nu(2)});
      CHECK(one(0) == Approx(other(0)));
      CHECK(one(1) == Approx(-other(1)));
      CHECK(one(2) == Approx(-other(2)));
    }
  }
}

TEST_CASE("other forms: they are uncertain, but never far off", "[forces][gap]") {
  std::size_t forms = 0;
  for (const gap::UncertainParameter& p : gap::uncertain_parameters(read_ship("vectwin-3m"))) {
    if (!p.is_form) continue;
    ++forms;
    CAPTURE(p.name);
    CHECK(p.sd > 0.0);
    CHECK_FALSE(p.may_be_far_more);
    CHECK_FALSE(p.may_be_far_less);
  }
  CHECK(forms == 10);  // five of the hull, five of the wind
}
