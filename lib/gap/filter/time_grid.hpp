#pragma once

#include <vector>

#include "dynamics/replay.hpp"
#include "recording/trajectory.hpp"
#include "ship/ship.hpp"

namespace leeway::gap {

/// A recording and what drove the ship in it.
struct Driven {
  const Trajectory* recording;
  RecordedInputs inputs;
};

/// The time step of the filter's grid [s]: two time units sqrt(L/g) of the ship, or a half or a quarter of that where
/// recordings are sampled so fast, and by sensors so good, that means over it would not be what the filter takes them
/// for. It takes the mean of a velocity over a bin for that of a parabola; where an actuator moves within the bin the
/// velocity has a corner, by which the mean is off. How far is told by the ship's own accelerations, as what drives her
/// changes within each bin; all errors together should not stand out of the noise of the means. Recordings without
/// noise, as simulated ones, keep the step: what is told of them has a tolerance of its own.
///   usual_s  the step that would be taken otherwise
double grid_step_s(const Ship& ship, const std::vector<Driven>& recordings, double usual_s);

}  // namespace leeway::gap
