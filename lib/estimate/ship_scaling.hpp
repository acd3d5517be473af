#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "ship/ship.hpp"

namespace leeway::estimate {

/// One correction on the way to another size.
struct ScaleCorrection {
  std::string name;      ///< of the coefficient, as in coefficient_factors, or of what else is corrected
  double before, after;  ///< its value, with factor; of what has a unit both at the new size
  double added_log_sd;   ///< what the correction adds to its uncertainty
  std::string why;
};

struct ScaledShip {
  io::Json json;
  Ship ship;
  std::vector<ScaleCorrection> corrections;
  std::vector<std::string> warnings;
};

/// A ship of another size [m]: lengths, areas and times by Froude's law, nondimensional coefficients as they are, then
///   resistance  R_0 split into friction with form factor, by the ITTC 1957 line, and a rest that stays; a ship has the
///               roughness allowance of ITTC 1978 (k_s = 150e-6 m) besides, a model is smooth;
///   wake        w_P0 by ITTC 1978, w_s = t + 0.04 + (w_m - t - 0.04) ((1 + k) C_Fs + dC_F)/((1 + k) C_Fm), and back;
///   rudder      epsilon keeps its value: the wakes of propeller and rudder shrink alike; its uncertainty grows;
///   derivatives their values; friction is a small share of them; their uncertainty grows;
///   water       of a ship or a model, where one becomes the other; forces of effects go with its density;
///   revolutions those of self-propulsion at u0 are that again.
/// Resistance and wake are corrected with the ship's coefficient_factors in them. Effects take no part in any
/// correction and scale by the units of their parameters; a residual network is dropped with a warning. Each correction
/// is named in the ship's JSON (`scaling`), with all that it replaced: a ship that was scaled before is first put back,
/// so that its uncertainty does not grow twice and the way back ends at the ship itself. Throws InputError where the
/// ship has a module that none of this is known for.
ScaledShip scale_ship(const io::Json& json, const Ship& ship, double length_m);

}  // namespace leeway::estimate
