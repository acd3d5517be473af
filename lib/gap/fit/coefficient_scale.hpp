#pragma once

#include "gap/fit/null_fit.hpp"

/// How wrong a ship's file is about its coefficients, in a calibration: each is as uncertain as the file states, times
/// one scale c that is common to all, ln c ~ N(0, 0.5^2), which all coefficients together tell.
namespace leeway::gap {

/// Standard deviations of theta: of the coefficients what is stated times the scale, of the others as they are.
struct ScaledWidths {
  Eigen::VectorXd sd;
  double scale = 1.0;
};

/// At the scale, of nine from a fifth to four and a half, with which a fit's evidence is likeliest.
ScaledWidths likeliest_widths(const FittedNull& fit);

}  // namespace leeway::gap
