#pragma once

#include "gap/detect/blocks.hpp"
#include "gap/detect/effect_library.hpp"
#include "gap/detect/score_test.hpp"
#include "gap/detect/whiteness.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {

struct DetectOptions {
  double false_alarm = kPolicy.detect.false_alarm;
  std::size_t jobs = 1;
  std::uint64_t seed = 1;
  std::size_t refitted = kPolicy.detect.refitted;  ///< effects for which the noise levels are estimated anew
};

/// Tests every effect of the library against the null fit. Parameters may err by twice their stated uncertainty, so
/// that a wrong coefficient is not called missing physics. The most likely effects are tested anew with the noise
/// levels that fit them (refit.hpp). The p-value is that of the largest of all statistics, with their correlations.
Detection detect(const Campaign& campaign, const FittedNull& fit, const EffectLibrary& library,
                 const DetectOptions& options);

}  // namespace leeway::gap
