#include "recording/local_plane.hpp"

#include <GeographicLib/LocalCartesian.hpp>
#include <cmath>

#include "core/units.hpp"

namespace leeway {

void lay_on_plane(std::vector<double>& latitude, std::vector<double>& longitude) {
  GeographicLib::LocalCartesian plane;
  bool has_origin = false;
  for (std::size_t i = 0; i < latitude.size(); ++i) {
    const double lat_deg = rad_to_deg(latitude[i]), lon_deg = rad_to_deg(longitude[i]);
    if (std::isnan(lat_deg) || std::isnan(lon_deg)) {
      latitude[i] = longitude[i] = std::nan("");
      continue;
    }
    if (!has_origin) plane.Reset(lat_deg, lon_deg);
    has_origin = true;
    double east = 0.0, north = 0.0, up = 0.0;
    plane.Forward(lat_deg, lon_deg, 0.0, east, north, up);
    latitude[i] = north;
    longitude[i] = east;
  }
}

}  // namespace leeway
