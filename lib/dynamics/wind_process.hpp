#pragma once

#include <optional>

#include "core/random.hpp"
#include "core/types.hpp"

namespace leeway {

/// The stochastic wind speed: dU = -alpha (U - U_mean) dt + sigma dW, with the Hino spectrum at low frequencies and at
/// 0.5 Hz; stationary standard deviation sigma/sqrt(2 alpha).
struct WindSpeedProcess {
  double alpha = 0.0;  ///< [1/s]
  double sigma = 0.0;  ///< [m/s^1.5]
};

/// The stochastic wind direction: d gamma = -alpha sin(gamma - gamma_mean) dt + sigma dW, by the regression of
/// Kuwashima: standard deviation about 32 deg (U_mean / 1 m/s)^-0.75 where that is small.
struct WindDirectionProcess {
  double alpha = 0.0;  ///< [1/s]
  double sigma = 0.0;  ///< [rad/s^0.5]
};

/// Coefficients for a mean speed > 0 [m/s]. Source: the appendix on wind of the ensemble paper; its constants are those
/// of the authors' public code (NAOE-5thLab/py-ship-simulator, world/wind/random_wind.py). The paper writes
/// +alpha (U - U_mean) with a negative alpha.
WindSpeedProcess wind_speed_process(double mean_mps);
WindDirectionProcess wind_direction_process(double mean_mps);

/// The longest time step [s] at which Euler-Maruyama follows the processes of a mean speed: alpha dt <= 1. Beyond, the
/// scheme oscillates; from 2 on it diverges.
double longest_wind_step_s(double mean_mps);

/// True wind over time: steady, or a stochastic process about a mean speed and direction. A value: a copy continues on
/// its own, with the same numbers.
class WindProcess {
 public:
  /// Calm air.
  WindProcess() = default;
  /// Steady: a from-vector in earth axes [m/s], wind_from_vector() of core/wind.hpp.
  WindProcess(const Vec2<double>& steady) : value_(steady) {}
  /// Steady.
  ///   speed [m/s] >= 0;  direction [rad] that it comes from
  static WindProcess steady(double speed_mps, double direction_rad);
  /// Speed and direction vary independently. They start in the stationary distribution of the processes, normal and von
  /// Mises, so that no part of a run is special. A mean speed of 0 (below 1e-6 m/s) is
  /// steady.
  static WindProcess stochastic(double mean_speed_mps, double mean_direction_rad, RandomStream stream);

  /// True wind now: from-vector in earth axes [m/s].
  const Vec2<double>& value() const { return value_; }
  bool is_stochastic() const { return process_.has_value(); }

  /// One Euler-Maruyama step. A speed that falls below 0 is reflected: U becomes -U, direction unchanged. With the
  /// turbulence of the process (a tenth of the mean) this happens about never, and it leaves the mean speed alone.
  /// Throws UsageError for a step above longest_wind_step_s().
  void advance(double dt_s);

 private:
  struct Process {
    double mean_speed, mean_direction, speed, direction;
    WindSpeedProcess of_speed;
    WindDirectionProcess of_direction;
    RandomStream stream;
  };

  Vec2<double> value_ = Vec2<double>::Zero();
  std::optional<Process> process_;
};

}  // namespace leeway
