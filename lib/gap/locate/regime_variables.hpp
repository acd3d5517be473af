#pragma once

#include <functional>
#include <string>
#include <vector>

#include "gap/locate/patterns.hpp"

namespace leeway::gap {

/// A variable that the residual may depend on.
struct RegimeVariable {
  std::string name, symbol, unit, words;  ///< "u", "u", "m/s" (nothing for a ratio), "surge"
  double per_unit;                        ///< from SI to that unit
  bool is_angle;                          ///< all around: by its cosine and sine
  std::function<double(const Moment&)> value;
  int first_axis = 0, last_axis = 2;  ///< of the residuals that it is tried on

  std::string label() const { return symbol + " [" + (unit.empty() ? "-" : unit) + "]"; }
};

/// Those that the recordings have.
std::vector<RegimeVariable> regime_variables(const Campaign& campaign);

}  // namespace leeway::gap
