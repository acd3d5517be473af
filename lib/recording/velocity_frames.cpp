#include "recording/velocity_frames.hpp"

#include <cmath>

namespace leeway {

void turn_into_ship_axes(std::vector<double>& u, std::vector<double>& vm, const std::vector<double>& psi) {
  for (std::size_t i = 0; i < u.size(); ++i) {
    const double north = u[i], east = vm[i], c = std::cos(psi[i]), s = std::sin(psi[i]);
    u[i] = north * c + east * s;
    vm[i] = east * c - north * s;
  }
}

void resolve_course(std::vector<double>& u, std::vector<double>& vm, const std::vector<double>& psi) {
  for (std::size_t i = 0; i < u.size(); ++i) {
    const double speed = u[i], drift = vm[i] - psi[i];
    u[i] = speed * std::cos(drift);
    vm[i] = speed * std::sin(drift);
  }
}

}  // namespace leeway
