#pragma once

#include <string>

#include "core/random.hpp"
#include "io/json.hpp"
#include "recording/trajectory.hpp"

namespace leeway {

/// Standard deviations of the white, normal noise on observed states; SI and radians.
struct ObservationNoise {
  double x0 = 0.0, y0 = 0.0, psi = 0.0, u = 0.0, vm = 0.0, r = 0.0;
};

/// Keys x0_m, y0_m, psi_deg, u_mps, vm_mps, r_degps, all optional and >= 0.
ObservationNoise parse_noise(const io::JsonObject& json);
/// A path, or the name of a shipped one such as "paper-model-scale".
ObservationNoise read_noise(const std::string& name_or_path);
/// The JSON that parse_noise reads.
io::Json to_json(const ObservationNoise& noise);

/// A copy with noise on the states; actuators and wind stay as they are.
Trajectory observed(const Trajectory& truth, const ObservationNoise& noise, RandomStream stream);

}  // namespace leeway
