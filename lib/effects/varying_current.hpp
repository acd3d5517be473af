#pragma once

#include "core/units.hpp"
#include "effects/effect.hpp"
#include "effects/ou_waves.hpp"

namespace leeway {

template <typename T>
struct VaryingCurrent {
  static constexpr EffectInfo info{
      .name = "varying-current",
      .number = "E2",
      .sentence = "The water moves as a whole, and its motion changes slowly with time, alike on all headings.",
      .phrase = "a current that changes slowly, by about {current_sd_mps}",
      .formula =
          "each earth component of V is a sum of 64 cosines with the variance current_sd^2 and the spectrum of an "
          "Ornstein-Uhlenbeck process of time constant tau, cut off at omega tau = 20; phases and frequencies from the "
          "seed. Where its course is known: + sum of (north_k, east_k) cos(k pi s), s = (t - course_start)/course in "
          "[0, 1], held outside",
      .source =
          "spectral form of the process (ours): smooth, so that dV/dt exists; equations of motion as steady-current",
      .look_alikes = "steady-current, sheared-current, unmeasured-wind, a drifting sensor bias",
      .looks_like = {"steady-current", "sheared-current", "unmeasured-wind"},
      .separating_maneuver = "the same maneuver at another time",
      .formula_sd = 0.0,
      .differs_by_recording = true,
      .is_of_surroundings = true,
      .to_record = "the current, or the speed through the water beside that over ground",
      .search = SearchStart::course,
  };
  static constexpr std::size_t kCosines = 4;  ///< of the course, with the constant
  static constexpr std::size_t kSd = 0, kTau = 1, kSeed = 2, kStart = 3, kLength = 4, kCourse = 5;  ///< of parameters

  static constexpr EffectParameter cosine(std::string_view name, std::string_view meaning) {
    return {
        name, meaning, 0.0, 0.0, -kUnbounded, kUnbounded, normal(0.0, 0.04, -0.3, 0.3), normal(0.0, 0.3, -3.0, 3.0)};
  }
  static constexpr std::array<EffectParameter, kCourse + 2 * kCosines> parameters{{
      {"current_sd_mps", "standard deviation of each component of the velocity", 0.0, kNone, 0.0, kUnbounded,
       rayleigh(0.04, 0.15), rayleigh(0.3, 1.5)},
      {"tau_s", "time constant", kNone, kNone, 1e-3, kUnbounded, log_normal(450.0, 0.75, 10.0, 1e4),
       log_normal(3200.0, 0.75, 70.0, 7e4)},
      {"seed", "selects the realization", kNone, 1.0, 0.0, 1e9, uniform(0.0, 1e9), uniform(0.0, 1e9)},
      {"course_start_s", "begin of the known course, in the run's time", kNone, 0.0, -kUnbounded, kUnbounded,
       uniform(0.0, 1e5), uniform(0.0, 1e5)},
      {"course_s", "its length", kNone, 600.0, 1e-3, kUnbounded, uniform(0.0, 1e5), uniform(0.0, 1e5)},
      cosine("north_0_mps", "mean of the known course to the north"),
      cosine("east_0_mps", "the same to the east"),
      cosine("north_1_mps", "its half wave"),
      cosine("east_1_mps", "the same to the east"),
      cosine("north_2_mps", "its whole wave"),
      cosine("east_2_mps", "the same to the east"),
      cosine("north_3_mps", "its wave and a half"),
      cosine("east_3_mps", "the same to the east"),
  }};

  T sd;  ///< of each component [m/s]
  std::array<OuWaves<T>, 2> waves;
  T start_s, course_s;
  std::array<Vec2<T>, kCosines> course;

  VaryingCurrent(const std::array<T, parameters.size()>& value, const Ship&)
      : sd(value[0]),
        waves{OuWaves<T>(value[1], value[2], "varying current", 0),
              OuWaves<T>(value[1], value[2], "varying current", 1)},
        start_s(value[kStart]),
        course_s(value[kLength]) {
    for (std::size_t k = 0; k < kCosines; ++k) course[k] = Vec2<T>(value[kCourse + 2 * k], value[kCourse + 2 * k + 1]);
  }

  WaterMotion<T> water(const Situation<T>& at) const {
    WaterMotion<T> result;
    for (std::size_t axis = 0; axis < 2 && OuWaves<T>::value_of(sd) != 0.0; ++axis) {
      result.velocity(static_cast<Eigen::Index>(axis)) = sd * waves[axis].value(at.t_s);
      result.rate(static_cast<Eigen::Index>(axis)) = sd * waves[axis].rate(at.t_s);
    }
    using std::cos, std::sin;
    const T share = (at.t_s - start_s) / course_s, within = share < 0.0 ? T(0.0) : share > 1.0 ? T(1.0) : share;
    for (std::size_t k = 0; k < kCosines; ++k) {
      const double waves_of = kPi * static_cast<double>(k);
      result.velocity += cos(waves_of * within) * course[k];
      result.rate -= waves_of / course_s * sin(waves_of * within) * course[k];
    }
    return result;
  }
};

}  // namespace leeway
