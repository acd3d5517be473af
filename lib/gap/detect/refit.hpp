#pragma once

#include "gap/detect/effect_library.hpp"

namespace leeway::gap {

/// One effect with the noise levels that fit it best.
struct Refit {
  double p_value = 1.0;
  double gain = 0.0,
         gain_sd = 0.0;  ///< sum over what was left out in turn [nats], see folds_of(), and its standard error
};

/// The model error is estimated anew with the effect, the degrees of freedom of this estimate are counted
/// (Satterthwaite 1946), and correlation left between blocks widens the errors.
///   effect  its place in the library
Refit refit(const Campaign& campaign, const FittedNull& fit, const EffectLibrary& library, std::size_t effect,
            std::size_t jobs);

}  // namespace leeway::gap
