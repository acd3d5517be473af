#include "gap/decide/ship_file.hpp"

#include <algorithm>
#include <cmath>

namespace leeway::gap {

bool is_off(const CalibratedModule& module, std::size_t modules, double false_alarm) {
  const double certain = std::log(static_cast<double>(std::max<std::size_t>(1, modules)) / false_alarm);
  return module.helps_free_runs && module.gain > certain;
}

bool is_off(const FittedCoefficient& c, const Policy& policy) {
  if (c.may_be_far) return c.far_off > policy.compare.likelier_than_not;
  const double nearest = std::abs(c.shift) - policy.show.normal95 * c.shift_sd;
  return nearest > policy.decide.stated_sds * c.stated_sd;
}

ShipFileState decide_ship_file(const ShipFileFound& found, const Policy& policy) {
  if (found.is_spoiled || !found.converged) return ShipFileState::cannot_tell;
  if (found.is_off) return ShipFileState::off;
  const bool is_little = found.keeps_course || found.samples < policy.decide.fewest_samples ||
                         found.determined < policy.decide.least_determined;
  return is_little ? ShipFileState::cannot_tell : ShipFileState::as_stated;
}

}  // namespace leeway::gap
