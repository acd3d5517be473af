#pragma once

#include <cstddef>
#include <cstdint>

#include "gap/policy/policy.hpp"

namespace leeway::gap {

struct LocateOptions {
  double false_alarm = kPolicy.detect.false_alarm;          ///< of any interval where there is none
  double false_discovery = kPolicy.locate.false_discovery;  ///< share of wrong ones among the regimes
  std::size_t jobs = 1;
  std::uint64_t seed = 1;
};

}  // namespace leeway::gap
