#pragma once

#include "gap/fit/null_fit.hpp"

namespace leeway::gap {

/// Ljung & Box (1978), over all channels and lags up to 10; `largest` is the largest autocorrelation in absolute value.
struct Whiteness {
  double p_value = 1.0, largest = 0.0;
};
Whiteness whiteness(const FittedNull& fit);

}  // namespace leeway::gap
