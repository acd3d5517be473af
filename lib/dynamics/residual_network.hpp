#pragma once

#include <cmath>

#include "core/types.hpp"
#include "forces/actuators.hpp"
#include "ship/residual_network.hpp"

namespace leeway {

/// The network's (du/dt, dv_m/dt [m/s^2], dr/dt [rad/s^2]), whole inside the box of its domain, nothing a tenth of the
/// box's width outside of it, smooth in between.
///   nu             (u, v_m [m/s], r [rad/s]) over ground
///   apparent_wind  in ship axes [m/s], pointing to where it comes from
template <typename T>
Vec3<T> acceleration(const ResidualNetwork& network, const Vec3<T>& nu, const Actuators<T>& actuators,
                     const Vec2<T>& apparent_wind) {
  using std::tanh;
  using Vector = Eigen::Matrix<T, Eigen::Dynamic, 1>;
  Vector x(static_cast<Eigen::Index>(network.inputs.size()));
  x.template head<3>() = nu;
  for (std::size_t i = 0; i < network.actuators.size(); ++i)
    x(static_cast<Eigen::Index>(3 + i)) = actuators[network.actuators[i]];
  if (network.wind) x.template tail<2>() = apparent_wind;

  T inside(1.0);
  for (std::size_t i = 0; i < network.inputs.size(); ++i) {
    const ResidualNetwork::Input& input = network.inputs[i];
    T& value = x(static_cast<Eigen::Index>(i));
    const double margin = 0.1 * (input.high - input.low);
    const T beyond = value < input.low ? T((input.low - value) / margin) : T((value - input.high) / margin);
    if (!(beyond < T(1.0))) return Vec3<T>::Zero();
    if (beyond > T(0.0)) inside *= 1.0 - beyond * beyond * (3.0 - 2.0 * beyond);
    value = (value - input.mean) / input.sd;
  }
  for (const ResidualNetwork::Layer& layer : network.layers) {
    Vector y = layer.biases.template cast<T>();
    for (Eigen::Index row = 0; row < y.size(); ++row)
      for (Eigen::Index column = 0; column < x.size(); ++column) y(row) += layer.weights(row, column) * x(column);
    if (&layer != &network.layers.back())
      for (T& unit : y) unit = tanh(unit);
    x = y;
  }
  return inside * Vec3<T>(x);
}

}  // namespace leeway
