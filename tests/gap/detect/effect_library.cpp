#include "gap/detect/effect_library.hpp"

#include <catch2/catch.hpp>

#include "core/random.hpp"
#include "gap/detect/helm.hpp"

using namespace leeway;

namespace {

// A ship at 0.5 m/s whose heading swings to and fro, and what a filter with a good heading knows of her.
struct Swinging {
  gap::Campaign campaign;
  gap::FittedNull fit;
};

constexpr double kRateSd = 0.05 * kDegree;  // of the filter

//   rudder  angle by time, heading and yaw rate [s, rad, rad/s]
Swinging swinging(const std::function<double(double, double, double)>& rudder, double thruster_rps = 0.0,
                  double swing_deg = 8.0) {
  Trajectory recording;
  recording.name = recording.file = "run";
  RandomStream random(1, "swinging");
  gap::Smoothed smoothed;
  double x = 0.0, y = 0.0;
  for (int k = 0; k <= 200; ++k) {
    const double t = k, phase = 2.0 * kPi * t / 40.0, psi = swing_deg * kDegree * std::sin(phase),
                 r = swing_deg * kDegree * 2.0 * kPi / 40.0 * std::cos(phase);
    x += 0.5 * std::cos(psi), y += 0.5 * std::sin(psi);
    const std::pair<Channel, double> row[] = {{Channel::t, t},
                                              {Channel::x0, x},
                                              {Channel::y0, y},
                                              {Channel::psi, psi},
                                              {Channel::u, 0.5},
                                              {Channel::vm, 0.0},
                                              {Channel::r, r},
                                              {Channel::delta_p, rudder(t, psi, r)},
                                              {Channel::delta_s, rudder(t, psi, r)},
                                              {Channel::n_p, 10.0},
                                              {Channel::n_bt, k % 40 < 20 ? thruster_rps : -thruster_rps}};
    for (const auto& [channel, value] : row) recording[channel].push_back(value);
    gap::StateVector known = gap::StateVector::Zero();
    known[2] = psi;
    known[3] = 0.5;
    known[5] = r - kRateSd * random.normal();
    smoothed.state.push_back(known);
    smoothed.covariance.push_back(gap::StateMatrix::Zero());
    smoothed.covariance.back()(5, 5) = kRateSd * kRateSd;
  }
  Swinging result;
  result.campaign = gap::prepare(read_ship("vectwin-3m"), {recording}, {});
  REQUIRE(result.campaign.stretches.front().size() == smoothed.state.size());
  result.fit.smoothed = {smoothed};
  return result;
}

// What an autopilot orders, and how well a rudder's angle follows it.
double by_autopilot(double t, double psi, double r) {
  return -1.2 * psi - 6.0 * r + 0.01 * kDegree * std::sin(17.0 * t);
}
// A square wave by the clock, as in a zigzag.
double by_clock(double t, double, double) { return 10.0 * kDegree * (std::fmod(t, 40.0) < 20.0 ? 1.0 : -1.0); }

double helm_ahead(const Swinging& of) {
  const auto helm = gap::helm_of(of.campaign, of.campaign.stretches.front(), of.fit.smoothed.front());
  return helm ? helm->ahead : 0.0;
}

}  // namespace

TEST_CASE("effects: rudders that follow the ship tell as much of her as the filter errs by", "[gap]") {
  // Beside its law the autopilot does nothing: what is left of its angles is the filter's error alone.
  CHECK(helm_ahead(swinging(by_autopilot)) == Approx(1.0).margin(0.3));
  CHECK(helm_ahead(swinging(by_clock)) < 0.01);
  CHECK(helm_ahead(swinging([](double, double, double) { return 0.0; })) == 0.0);
  // At its limit it follows nothing; what it does below tells as before.
  const auto limited = [](double t, double psi, double r) {
    return std::clamp(by_autopilot(t, psi, r), -12.0 * kDegree, 12.0 * kDegree);
  };
  CHECK(helm_ahead(swinging(limited)) == Approx(1.0).margin(0.4));
  // A helmsman who is as inaccurate as the sensors are leaves half.
  const auto helmsman = [](double t, double psi, double r) {
    return -1.2 * psi - 6.0 * (r + std::sqrt(2.0) * kRateSd * std::sin(17.0 * t));
  };
  CHECK(helm_ahead(swinging(helmsman)) == Approx(0.5).margin(0.15));
}

TEST_CASE("effects: a ship that an autopilot keeps on her course says nothing of how hull and rudder answer", "[gap]") {
  const Swinging kept = swinging(by_autopilot), turned = swinging(by_clock), pushed = swinging(by_autopilot, 20.0);
  const std::optional<gap::Campaign> by_law = gap::with_helms(kept.campaign, kept.fit.smoothed);
  REQUIRE(by_law);
  REQUIRE(by_law->stretches.front().helm);
  const gap::HelmLaw& law = *by_law->stretches.front().helm;
  CHECK(law.per_heading == Approx(-1.2).epsilon(0.01));
  CHECK(law.per_rate_s == Approx(-6.0).epsilon(0.01));
  CHECK(law.offset == Approx(0.0).margin(0.01 * kDegree));
  CHECK_FALSE(gap::with_helms(turned.campaign, turned.fit.smoothed));
  // A ship that follows her rudders is not steered by what she does.
  const Swinging led = swinging([](double, double, double r) { return 6.0 * r; });
  CHECK(helm_ahead(led) > 0.5);
  CHECK_FALSE(gap::with_helms(led.campaign, led.fit.smoothed));
  const gap::Identifiable course(*by_law, kept.fit), zigzag(turned.campaign, turned.fit),
      pulses(pushed.campaign, pushed.fit);
  for (const char* effect : {"shallow-water", "rudder-effectiveness", "actuator-delay"}) {
    CHECK_FALSE(course(effect));
    CHECK(zigzag(effect));
    CHECK(pulses(effect));
  }
  for (const char* effect : {"steady-current", "thrust-loss", "fouling", "unmeasured-wind", "propeller-walk"})
    CHECK(course(effect));
}

TEST_CASE("effects: a ship that goes straight with her rudders where they are says nothing of how they answer",
          "[gap]") {
  const auto amidships = [](double, double, double) { return 0.0; };
  const auto is_straight = [](const Swinging& of) {
    return gap::is_straight(of.campaign, of.campaign.stretches.front(), of.fit.smoothed.front());
  };
  const Swinging straight = swinging(amidships, 0.0, 0.1);  // 0.016 deg/s, where 0.05 deg/s are known
  CHECK(is_straight(straight));
  CHECK_FALSE(is_straight(swinging(amidships)));           // she turns
  CHECK_FALSE(is_straight(swinging(by_clock, 0.0, 0.1)));  // her rudders do
  CHECK_FALSE(gap::Identifiable(straight.campaign, straight.fit).has_answers());
  CHECK(gap::Identifiable(straight.campaign, straight.fit)("fouling"));
  const Swinging pushed = swinging(amidships, 20.0, 0.1);
  CHECK(gap::Identifiable(pushed.campaign, pushed.fit).has_answers());
}
