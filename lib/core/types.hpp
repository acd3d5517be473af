#pragma once

#include <Eigen/Core>

namespace leeway {

/// A planar vector: (x, y) in the frame that the name of the variable says.
template <typename T>
using Vec2 = Eigen::Matrix<T, 2, 1>;

/// (u [m/s], v_m [m/s], r [rad/s]), (X [N], Y [N], N [N m]) or (x0 [m], y0 [m], psi [rad]).
template <typename T>
using Vec3 = Eigen::Matrix<T, 3, 1>;

template <typename T>
using Mat2 = Eigen::Matrix<T, 2, 2>;

template <typename T>
using Mat3 = Eigen::Matrix<T, 3, 3>;

}  // namespace leeway
