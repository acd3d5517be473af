#pragma once

namespace leeway {

/// The classical Runge-Kutta method of fourth order, or Euler's method.
enum class Integrator { rk4, euler };

}  // namespace leeway
