#include "ensemble/disturbance.hpp"

#include <algorithm>
#include <cmath>

namespace leeway::ensemble {

bool Disturbance::is_zero() const {
  return std::ranges::all_of(axes, [](const auto& axis) { return axis.empty(); });
}

DisturbancePath::DisturbancePath(const Disturbance& disturbance, double dt_s, RandomStream& random) {
  for (int axis = 0; axis < 3; ++axis)
    for (const OrnsteinUhlenbeck& process : disturbance.axes[static_cast<std::size_t>(axis)]) {
      const double kept = std::exp(-dt_s / process.tau_s);
      components_.push_back({axis, process.sd * random.normal(), kept, process.sd * std::sqrt(1.0 - kept * kept)});
    }
}

Vec3<double> DisturbancePath::next(RandomStream& random) {
  Vec3<double> sum = Vec3<double>::Zero();
  for (Component& c : components_) {
    sum(c.axis) += c.value;
    c.value = c.kept * c.value + c.renewed * random.normal();
  }
  return sum;
}

}  // namespace leeway::ensemble
