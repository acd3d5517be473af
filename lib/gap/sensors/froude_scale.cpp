#include "gap/sensors/froude_scale.hpp"

#include "gap/policy/policy.hpp"

namespace leeway::gap {

FroudeScale::FroudeScale(double L_pp) : leeway::FroudeLaw(L_pp / kPolicy.reference_length_m) {}

}  // namespace leeway::gap
