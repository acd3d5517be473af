#include "dynamics/indices.hpp"

#include <functional>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "core/units.hpp"
#include "dynamics/phased_maneuvers.hpp"

using namespace leeway;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;
using io::Json;

namespace {

// A trajectory from closed forms; `state` gives x0, y0, psi, u, v_m, r at a time.
Trajectory planted(double duration_s, double dt_s, const std::function<std::array<double, 6>(double)>& state) {
  Trajectory trajectory;
  const auto n = static_cast<int>(std::lround(duration_s / dt_s));
  for (int i = 0; i <= n; ++i) {
    const double t = i * dt_s;
    const auto [x0, y0, psi, u, v_m, r] = state(t);
    const std::pair<Channel, double> values[] = {{Channel::t, t},     {Channel::x0, x0}, {Channel::y0, y0},
                                                 {Channel::psi, psi}, {Channel::u, u},   {Channel::vm, v_m},
                                                 {Channel::r, r}};
    for (const auto& [channel, value] : values) trajectory[channel].push_back(value);
  }
  return trajectory;
}

double number(const Json& json, const std::string& key) {
  CAPTURE(key);
  REQUIRE(json.contains(key));
  REQUIRE(json[key].is_number());
  return json[key].get<double>();
}

// A circle at constant speed, drift and yaw rate from any pose; `side` +1 to starboard.
struct Circle {
  double U = 0.47, radius = 6.3, drift = 0.21, psi = 0.8, x = 3.0, y = -5.0, side = 1.0;
  double r() const { return U / radius; }
  std::array<double, 6> operator()(double t) const {
    // In the axes of the start, to starboard: the course is the heading less the drift angle.
    const double course = r() * t - drift;
    const double ahead = radius * (std::sin(course) + std::sin(drift));
    const double abeam = side * radius * (std::cos(drift) - std::cos(course));
    const double c = std::cos(psi), s = std::sin(psi);
    return {x + c * ahead - s * abeam, y + s * ahead + c * abeam,   psi + side * r() * t,
            U * std::cos(drift),       -side * U * std::sin(drift), side * r()};
  }
};

}  // namespace

TEST_CASE("turning indices: a circle with drift has those of its geometry, to both sides", "[dynamics][indices]") {
  for (const double side : {1.0, -1.0}) {
    CAPTURE(side);
    Circle circle;
    circle.side = side;
    const double R = circle.radius, b = circle.drift, L = 2.7, dt_s = 0.5, duration = 200.0;
    const Trajectory trajectory = planted(duration, dt_s, circle);
    const Json json = turning_indices(Track(trajectory), side * 0.5, L);
    // Hermite interpolation of a circle errs by R (r dt)^4 / 384 < 1e-7 m.
    const auto is = [&](const char* name, double length) {
      CHECK_THAT(number(json, std::string(name) + "_m"), WithinAbs(length, 2e-7));
      CHECK_THAT(number(json, std::string(name) + "_over_L"), WithinAbs(length / L, 1e-7));
    };
    is("advance", R * (std::cos(b) + std::sin(b)));
    is("transfer", R * (std::cos(b) - std::sin(b)));
    is("tactical_diameter", 2.0 * R * std::cos(b));
    is("max_advance", R * (1.0 + std::sin(b)));
    is("max_transfer", R * (1.0 + std::cos(b)));
    is("track_to_10_deg", R * 10.0 * kDegree);
    CHECK_THAT(number(json, "time_to_90_deg_s"), WithinRel(0.5 * kPi / circle.r(), 1e-9));
    CHECK_THAT(number(json, "time_to_180_deg_s"), WithinRel(kPi / circle.r(), 1e-9));
    CHECK_THAT(number(json, "time_to_360_deg_s"), WithinRel(2.0 * kPi / circle.r(), 1e-9));
    const Json& steady = json["steady"];
    CHECK(steady["is_steady"] == true);
    CHECK_THAT(number(steady, "speed_mps"), WithinRel(circle.U, 1e-9));
    CHECK_THAT(number(steady, "r_degps"), WithinRel(side * rad_to_deg(circle.r()), 1e-9));
    CHECK_THAT(number(steady, "r_nondimensional"), WithinRel(side * L / R, 1e-9));
    CHECK_THAT(number(steady, "drift_deg"), WithinRel(side * rad_to_deg(b), 1e-9));
    CHECK_THAT(number(steady, "radius_m"), WithinRel(R, 1e-9));
    CHECK_THAT(number(steady, "diameter_over_L"), WithinRel(2.0 * R / L, 1e-9));
    CHECK_THAT(number(steady, "speed_loss"), WithinAbs(0.0, 1e-9));
  }
}

TEST_CASE("turning indices: what the run did not reach is null", "[dynamics][indices]") {
  const Circle circle;
  const auto run_to = [&](double degrees) {
    const Trajectory trajectory = planted(std::round(10.0 * degrees * kDegree / circle.r()) / 10.0, 0.1, circle);
    return turning_indices(Track(trajectory), 0.5, 3.0);
  };
  const Json json = run_to(120.0);
  CHECK(json["advance_m"].is_number());
  CHECK(json["max_advance_m"].is_number());
  for (const char* name : {"tactical_diameter_m", "tactical_diameter_over_L", "max_transfer_m", "time_to_180_deg_s",
                           "time_to_360_deg_s", "steady"})
    CHECK(json[name].is_null());
  CHECK(not_reached(json) == std::vector<std::string>{"tactical_diameter_m", "max_transfer_m", "time_to_180_deg_s",
                                                      "time_to_360_deg_s", "steady"});
  CHECK(run_to(60.0)["advance_m"].is_null());
  CHECK(run_to(500.0)["steady"].is_null());
  CHECK(run_to(545.0)["steady"].is_object());
}

TEST_CASE("turning indices: they do not depend on the time step", "[dynamics][indices]") {
  const Ship ship = read_ship("esso-osaka-3m");
  const auto indices = [&](double dt_s) {
    const auto maneuver = turning(ship, -35.0 * kDegree);
    const Trajectory t = simulate(SimulatedShip(ship), *maneuver, {}, {dt_s, dt_s, 200.0});
    return turning_indices(Track(t), -35.0 * kDegree, 3.0);
  };
  const Json a = indices(0.2), b = indices(0.05);
  // RK4 at 0.2 s across the kinks of rudder and flow straightening.
  for (const char* name : {"advance_m", "transfer_m", "tactical_diameter_m", "max_advance_m", "max_transfer_m",
                           "track_to_10_deg_m", "time_to_90_deg_s", "time_to_360_deg_s"})
    CHECK_THAT(number(a, name), WithinRel(number(b, name), 2e-5));
}

TEST_CASE("zigzag indices: a growing sinusoid has the overshoots of its peaks, to both sides", "[dynamics][indices]") {
  const double A = 14.0 * kDegree, w = 0.15, growth = 0.004, U = 0.6, heading = 10.0 * kDegree, L = 3.3;
  for (const double side : {1.0, -1.0}) {
    CAPTURE(side);
    const auto psi = [&](double t) { return A * std::exp(growth * t) * std::sin(w * t); };
    const Trajectory trajectory = planted(140.0, 0.5, [&](double t) {
      const double r = A * std::exp(growth * t) * (growth * std::sin(w * t) + w * std::cos(w * t));
      return std::array<double, 6>{U * t, 0.0, 0.3 + side * psi(t), U, 0.0, side * r};
    });
    const Json json = zigzag_indices(Track(trajectory), side * 12.0 * kDegree, heading, L);
    const auto peak_s = [&](int k) { return (kPi - std::atan(w / growth) + k * kPi) / w; };
    // Cubic interpolation errs by A (w dt)^4 / 384, 1e-6 deg; at the peak, r is interpolated linearly: (w dt)^2 / 8 of
    // r over a hundredth of a period.
    CHECK_THAT(number(json, "first_overshoot_deg"), WithinAbs(rad_to_deg(psi(peak_s(0)) - heading), 1e-5));
    CHECK_THAT(number(json, "second_overshoot_deg"), WithinAbs(rad_to_deg(-psi(peak_s(1)) - heading), 1e-5));
    REQUIRE(json["overshoots"].size() == 7);  // a peak every half period of 20.9 s, from 10.6 s on
    CHECK(json["overshoots"][0]["side"] == (side > 0.0 ? "starboard" : "port"));
    CHECK(json["overshoots"][1]["side"] == (side > 0.0 ? "port" : "starboard"));
    CHECK_THAT(number(json["overshoots"][2], "t_s"), WithinAbs(peak_s(2), 1e-2));
    REQUIRE(json["executes"].size() >= 7);
    double sign = 1.0;
    for (std::size_t i = 1; i < 7; ++i, sign = -sign) {
      CHECK_THAT(psi(number(json["executes"][i], "t_s")), WithinAbs(sign * heading, 1e-7));
      CHECK_THAT(number(json["executes"][i], "rudder_deg"), WithinAbs(-sign * side * 12.0, 1e-12));
    }
    const double t_2 = number(json["executes"][1], "t_s");
    CHECK(number(json, "initial_turning_time_s") == t_2);
    CHECK_THAT(number(json, "time_to_check_yaw_s"), WithinAbs(peak_s(0) - t_2, 1e-2));
    CHECK(number(json, "period_s") == number(json["executes"][3], "t_s") - t_2);
    CHECK_THAT(number(json, "track_to_10_deg_m"), WithinRel(U * t_2, 1e-12));
    CHECK_THAT(number(json, "track_to_10_deg_over_L"), WithinRel(U * t_2 / L, 1e-12));
  }
}

TEST_CASE("zigzag indices: an overshoot counts only when the ship has begun to turn back", "[dynamics][indices]") {
  const double A = 14.0 * kDegree, w = 0.1;
  const auto run = [&](double duration_s) {
    const Trajectory t = planted(duration_s, 0.1, [&](double time) {
      return std::array<double, 6>{0.0, 0.0, A * std::sin(w * time), 0.5, 0.0, A * w * std::cos(w * time)};
    });
    return zigzag_indices(Track(t), 0.1, 10.0 * kDegree, 3.0);
  };
  CHECK(run(5.0)["initial_turning_time_s"].is_null());
  CHECK(run(15.0)["initial_turning_time_s"].is_number());
  CHECK(run(15.0)["first_overshoot_deg"].is_null());
  CHECK_THAT(number(run(16.0), "first_overshoot_deg"), WithinAbs(4.0, 1e-5));
  CHECK(run(16.0)["second_overshoot_deg"].is_null());
}

TEST_CASE("spiral indices: height and width of a planted loop", "[dynamics][indices]") {
  const double rudder_deg[] = {10.0, 0.0, -10.0, 0.0, 10.0}, r[] = {0.05, 0.02, -0.04, -0.03, 0.055};
  std::vector<Phase> phases;
  for (int i = 0; i < 5; ++i) phases.push_back({10.0 * i, 10.0 * (i + 1), rudder_deg[i] * kDegree, true, true});
  const Trajectory t = planted(50.0, 0.5, [&](double time) {
    const int i = time <= 10.0 ? 0 : static_cast<int>(std::ceil(time / 10.0)) - 1;
    return std::array<double, 6>{0.0, 0.0, 0.0, 0.4, -0.03, r[i]};
  });
  Json json = spiral_indices(Track(t), phases, 3.0);
  CHECK_THAT(number(json, "loop_height_degps"), WithinRel(rad_to_deg(0.05), 1e-12));  // at 0 deg, 0.02 and -0.03
  // r = 0 at -10/3 deg on the way to port, at 10 * 3/8.5 deg on the way back.
  CHECK_THAT(number(json, "loop_width_deg"), WithinRel(10.0 * 3.0 / 8.5 + 10.0 / 3.0, 1e-12));
  CHECK(json["is_straight_line_stable"] == false);
  REQUIRE(json["curve"].size() == 5);
  CHECK(json["curve"][2]["leg"] == 1);
  CHECK(json["curve"][3]["leg"] == 2);
  CHECK_THAT(number(json["curve"][1], "r_degps"), WithinRel(rad_to_deg(0.02), 1e-12));
  CHECK_THAT(number(json["curve"][1], "drift_deg"), WithinRel(rad_to_deg(std::atan2(0.03, 0.4)), 1e-12));
  // A yaw rate that had not settled says nothing.
  phases[3].is_fulfilled = false;
  json = spiral_indices(Track(t), phases, 3.0);
  CHECK(number(json, "loop_height_degps") == 0.0);
  CHECK(json["is_straight_line_stable"].is_null());
  phases[4].is_complete = false;
  CHECK(spiral_indices(Track(t), phases, 3.0)["loop_height_degps"].is_null());
}

TEST_CASE("pull-out indices: residual yaw rates tell stability where amidships is neutral", "[dynamics][indices]") {
  const auto stable = [](double from_starboard, double from_port, bool is_steady = true) {
    const double r[] = {0.06, from_starboard, -0.07, from_port};
    std::vector<Phase> phases;
    for (int i = 0; i < 4; ++i)
      phases.push_back({20.0 * i, 20.0 * (i + 1), i % 2 == 0 ? 0.3 : 0.0, is_steady || i < 3, true});
    const Trajectory t = planted(80.0, 1.0, [&](double time) {
      return std::array<double, 6>{0.0, 0.0, 0.0,
                                   0.5, 0.0, r[time <= 20.0 ? 0 : static_cast<int>(std::ceil(time / 20.0)) - 1]};
    });
    const Json json = pull_out_indices(Track(t), phases, 3.0);
    CHECK_THAT(number(json, "r_port_turn_degps"), WithinRel(rad_to_deg(-0.07), 1e-12));
    CHECK_THAT(number(json, "r_residual_from_starboard_degps"), WithinAbs(rad_to_deg(from_starboard), 1e-12));
    return json["is_straight_line_stable"];
  };
  CHECK(stable(0.0005, -0.0004) == true);
  CHECK(stable(0.02, -0.03) == false);
  CHECK(stable(0.02, 0.0201).is_null());  // amidships is not neutral
  CHECK(stable(0.0005, -0.0004, false).is_null());
}

TEST_CASE("crash stop indices: a uniform deceleration on a skewed course", "[dynamics][indices]") {
  const double u0 = 0.7, a = 0.011, execute = 20.0, k = 0.12, psi = -0.6, L = 2.9;
  const Trajectory t = planted(100.0, 0.5, [&](double time) {
    const double brake = std::max(0.0, time - execute), u = u0 - a * brake;
    const double way = u0 * time - 0.5 * a * brake * brake, c = std::cos(psi), s = std::sin(psi);
    return std::array<double, 6>{way * (c - k * s), way * (s + k * c), psi, u, k * u, 0.0};
  });
  const std::vector<Phase> phases{{0.0, execute, 10.0, false, true}, {execute, 84.0, -10.0, true, true}};
  const Json json = crash_stop_indices(Track(t), phases, L);
  const double reach = u0 * u0 / (2.0 * a);
  CHECK(number(json, "execute_s") == execute);
  CHECK_THAT(number(json, "speed_at_execute_mps"), WithinRel(u0 * std::sqrt(1.0 + k * k), 1e-12));
  CHECK_THAT(number(json, "time_to_stop_s"), WithinRel(u0 / a, 1e-9));
  CHECK_THAT(number(json, "track_reach_m"), WithinRel(reach * std::sqrt(1.0 + k * k), 1e-9));
  CHECK_THAT(number(json, "head_reach_m"), WithinRel(reach, 1e-9));
  CHECK_THAT(number(json, "lateral_deviation_over_L"), WithinRel(k * reach / L, 1e-9));
  CHECK(number(json, "heading_change_deg") == 0.0);
  CHECK(crash_stop_indices(Track(t), {phases[0]}, L)["track_reach_m"].is_null());
}

TEST_CASE("coast-down indices: quadratic resistance halves the speed over equal distances", "[dynamics][indices]") {
  const double U = 0.8, T = 30.0, L = 3.0;
  const Trajectory t = planted(250.0, 0.1, [&](double time) {
    return std::array<double, 6>{U * T * std::log(1.0 + time / T), 0.0, 0.0, U / (1.0 + time / T), 0.0, 0.0};
  });
  const Json json = coast_down_indices(Track(t), L);
  CHECK(number(json, "initial_speed_mps") == U);
  // The speed is linear between samples, 1e-6 of it.
  for (const auto& [row, factor] : {std::pair(0, 2.0), std::pair(1, 4.0), std::pair(2, 8.0)}) {
    const Json& speed = json["speeds"][static_cast<std::size_t>(row)];
    CHECK(number(speed, "speed_fraction") == 1.0 / factor);
    CHECK_THAT(number(speed, "time_s"), WithinRel((factor - 1.0) * T, 1e-5));
    CHECK_THAT(number(speed, "track_m"), WithinRel(U * T * std::log(factor), 1e-5));
  }
  CHECK(json["speeds"][3]["time_s"].is_null());  // a tenth comes after 270 s
  CHECK(not_reached(json) ==
        std::vector<std::string>{"speeds/3/time_s", "speeds/3/track_m", "speeds/3/heading_change_deg"});
}

TEST_CASE("thruster pulse indices: accelerations, yaw rates and headings of planted pulses", "[dynamics][indices]") {
  const double a = 0.002, b = -0.0007;  // yaw [rad/s^2] and sway [m/s^2] while the thruster pulls to starboard
  const Trajectory t = planted(40.0, 0.5, [&](double time) {
    const auto up = [](double x) { return std::clamp(x, 0.0, 10.0); };
    const double on = up(time), off = up(time - 20.0);
    const double psi =
        a * (on * on / 2.0 + on * (time - on) - 0.5 * (off * off / 2.0 + off * std::max(0.0, time - 20.0 - off)));
    return std::array<double, 6>{0.0, 0.0, psi, 0.0, b * (on - 0.5 * off), a * (on - 0.5 * off)};
  });
  std::vector<Phase> phases{{0, 10, 20.0, false, true},
                            {10, 20, 0.0, false, true},
                            {20, 30, -20.0, false, true},
                            {30, 39.5, 0.0, false, false}};
  const Json pulses = thruster_pulse_indices(Track(t), phases)["pulses"];
  REQUIRE(pulses.size() == 2);
  CHECK(pulses[0]["side"] == "starboard");
  CHECK(pulses[1]["side"] == "port");
  CHECK_THAT(number(pulses[0], "initial_yaw_acceleration_degps2"), WithinRel(rad_to_deg(a), 1e-9));
  CHECK_THAT(number(pulses[1], "initial_yaw_acceleration_degps2"), WithinRel(rad_to_deg(-0.5 * a), 1e-9));
  CHECK_THAT(number(pulses[0], "max_r_degps"), WithinRel(rad_to_deg(10.0 * a), 1e-9));
  CHECK_THAT(number(pulses[0], "initial_sway_acceleration_mps2"), WithinRel(b, 1e-9));
  CHECK_THAT(number(pulses[1], "r_change_in_pulse_degps"), WithinRel(rad_to_deg(-5.0 * a), 1e-9));
  CHECK_THAT(number(pulses[0], "heading_change_in_pulse_deg"), WithinRel(rad_to_deg(50.0 * a), 1e-9));
  CHECK_THAT(number(pulses[0], "heading_change_with_rest_deg"), WithinRel(rad_to_deg(150.0 * a), 1e-9));
  CHECK(pulses[1]["heading_change_with_rest_deg"].is_null());
}

TEST_CASE("straight indices: root mean squares and means over the run", "[dynamics][indices]") {
  const double A = 0.02, w = 2.0 * kPi / 20.0;
  Trajectory t = planted(100.0, 0.1, [&](double time) {
    return std::array<double, 6>{0.5 * time, -0.3 * std::sin(w * time), A * std::sin(w * time), 0.5,
                                 0.0,        A * w * std::cos(w * time)};
  });
  t[Channel::delta].assign(t.size(), -0.04);
  const Json json = straight_indices(Track(t), t, 3.0);
  CHECK_THAT(number(json, "mean_speed_mps"), WithinRel(0.5, 1e-12));
  CHECK_THAT(number(json, "rms_heading_error_deg"), WithinRel(rad_to_deg(A / std::sqrt(2.0)), 1e-4));
  CHECK_THAT(number(json, "mean_heading_error_deg"), WithinAbs(0.0, 1e-10));
  CHECK_THAT(std::abs(number(json, "largest_lateral_deviation_m")), WithinRel(0.3, 1e-9));
  CHECK_THAT(number(json, "mean_delta_deg"), WithinRel(rad_to_deg(-0.04), 1e-12));
  CHECK_THAT(number(json, "rms_delta_deg"), WithinRel(rad_to_deg(0.04), 1e-12));
}

TEST_CASE("IMO criteria: limits by the full-scale L/V, and only where they apply", "[dynamics][indices]") {
  Ship ship = read_ship("esso-osaka-3m");
  ship.scale = 100.0;  // 300 m; V is ten times the model's
  const ManeuverFacts zigzag_10{"zigzag", 10.0 * kDegree, -0.0 + 10.0 * kDegree, {}, 0.0};
  const Json zigzag{{"first_overshoot_deg", 14.9}, {"second_overshoot_deg", 33.0}, {"track_to_10_deg_over_L", nullptr}};
  // Initial turning needs the rudder until the heading has changed by 10 deg.
  const ManeuverFacts zigzag_5{"zigzag", 10.0 * kDegree, 5.0 * kDegree, {}, 0.0};
  CHECK(imo_criteria(zigzag, zigzag_5, ship, 1.0)["applies"] == false);
  const auto limits = [&](double L_over_V) {
    const Json json = imo_criteria(zigzag, zigzag_10, ship, 300.0 / L_over_V / 10.0);
    REQUIRE(json["applies"] == true);
    CHECK_THAT(number(json["full_scale"], "L_over_V_s"), WithinRel(L_over_V, 1e-12));
    REQUIRE(json["criteria"].size() == 3);
    CHECK(json["criteria"][0]["name"] == "track_to_10_deg");
    CHECK(json["criteria"][0]["fulfilled"].is_null());
    return std::pair(number(json["criteria"][1], "limit"), number(json["criteria"][2], "limit"));
  };
  for (const auto& [L_over_V, first, second] :
       {std::tuple(5.0, 10.0, 25.0), std::tuple(9.999999, 10.0, 25.0), std::tuple(20.0, 15.0, 32.5),
        std::tuple(24.0, 17.0, 35.5), std::tuple(30.0, 20.0, 40.0), std::tuple(50.0, 20.0, 40.0)}) {
    CHECK_THAT(limits(L_over_V).first, WithinAbs(first, 1e-6));
    CHECK_THAT(limits(L_over_V).second, WithinAbs(second, 1e-6));
  }
  const Json at_20 = imo_criteria(zigzag, zigzag_10, ship, 1.5);
  CHECK(at_20["criteria"][1]["fulfilled"] == true);   // 14.9 of 15 deg
  CHECK(at_20["criteria"][2]["fulfilled"] == false);  // 33 of 32.5 deg

  const Json turn{{"advance_over_L", 4.5}, {"tactical_diameter_over_L", 5.01}, {"track_to_10_deg_over_L", 2.6}};
  const auto turning_at = [&](double degrees) {
    return imo_criteria(turn, {"turning", degrees * kDegree, 0.0, {}, 0.0}, ship, 1.5);
  };
  for (const double degrees : {35.0, -35.0, 60.0}) {  // the last one stops at 35 deg
    CAPTURE(degrees);
    const Json json = turning_at(degrees);
    REQUIRE(json["applies"] == true);
    CHECK(json["criteria"][0]["fulfilled"] == true);
    CHECK(json["criteria"][1]["fulfilled"] == false);
  }
  CHECK(turning_at(20.0)["applies"] == false);
  REQUIRE(turning_at(-10.0)["applies"] == true);
  CHECK(turning_at(-10.0)["criteria"][0]["limit"] == 2.5);
  CHECK(turning_at(-10.0)["criteria"][0]["fulfilled"] == false);

  const Json zigzag_20 = imo_criteria(zigzag, {"zigzag", -20.0 * kDegree, 20.0 * kDegree, {}, 0.0}, ship, 1.5);
  REQUIRE(zigzag_20["criteria"].size() == 1);
  CHECK(zigzag_20["criteria"][0]["limit"] == 25.0);
  const Json stop = imo_criteria({{"track_reach_over_L", 15.2}}, {"crash-stop", 0.0, 0.0, {}, 0.0}, ship, 1.5);
  CHECK(stop["criteria"][0]["limit"] == 15.0);
  CHECK(stop["criteria"][0]["fulfilled"] == false);

  CHECK(imo_criteria(turn, {"turning", 35.0 * kDegree, 0.0, {}, 2.0}, ship, 1.5)["applies"] == false);  // wind
  ship.actuators[0].max = 30.0 * kDegree;
  CHECK(turning_at(30.0)["applies"] == true);  // the largest angle that the ship has
  CHECK(turning_at(-30.0)["applies"] == false);
  ship.scale = 1.0;
  CHECK(turning_at(35.0)["applies"] == false);  // 3 m
}

TEST_CASE("run indices: track, displacement and extremes", "[dynamics][indices]") {
  const Circle circle;
  const Trajectory t = planted(40.0, 0.5, circle);
  const Json json = run_indices(Track(t), t, 3.0);
  CHECK(number(json, "duration_s") == 40.0);
  CHECK_THAT(number(json, "track_length_m"), WithinRel(40.0 * circle.U, 1e-9));
  CHECK_THAT(number(json, "distance_made_good_m"),
             WithinRel(2.0 * circle.radius * std::sin(0.5 * 40.0 * circle.r()), 1e-9));
  CHECK_THAT(number(json, "heading_change_deg"), WithinRel(rad_to_deg(40.0 * circle.r()), 1e-9));
  CHECK_THAT(json["min_max"]["r_degps"][0].get<double>(), WithinRel(rad_to_deg(circle.r()), 1e-9));
  CHECK_THAT(json["min_max"]["psi_deg"][1].get<double>(), WithinRel(rad_to_deg(0.8 + 40.0 * circle.r()), 1e-9));
  CHECK_FALSE(json["min_max"].contains("delta_deg"));
}
