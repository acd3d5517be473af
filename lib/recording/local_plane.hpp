#pragma once

#include <vector>

namespace leeway {

/// Positions on the earth as positions on a plane, in place: the plane touches the WGS84 ellipsoid at the first
/// sample that is known, x0 points to the north there. At 10 km from it lengths are short by a millionth and the north
/// has turned by 0.1 deg times the tangent of the latitude.
///   latitude   in: [rad], to the north; out: x0 [m]
///   longitude  in: [rad], to the east; out: y0 [m]
void lay_on_plane(std::vector<double>& latitude, std::vector<double>& longitude);

}  // namespace leeway
