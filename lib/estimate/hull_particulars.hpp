#pragma once

#include <optional>
#include <string>
#include <vector>

#include "io/json.hpp"

/// A ship from its principal particulars: regressions, series and statistics, each with its source, range and
/// uncertainty.
namespace leeway::estimate {

struct PropellerParticulars {
  std::optional<double> diameter, pitch_ratio, area_ratio;  ///< [m], -, -
  std::optional<double> n_service;                          ///< [1/s] at the service speed
  std::optional<double> x;                                  ///< [m], + forward of midship
  std::optional<double> blades;
};

struct RudderParticulars {
  std::optional<double> area, height, x;  ///< [m^2, m, m]
  std::optional<double> max_angle, rate;  ///< [rad, rad/s]
  bool is_vectwin = false;
};

/// A tunnel thruster, or one that turns about the vertical (y: to starboard).
struct ThrusterParticulars {
  double x = 0.0, y = 0.0, diameter = 0.0;  ///< [m]
  double max_thrust = 0.0, max_n = 0.0;     ///< [N, 1/s]
};

struct SuperstructureParticulars {
  std::optional<double> frontal_area, lateral_area, lateral_centroid_x, height;  ///< [m^2, m^2, m, m]
};

/// Length of the full-scale ship by this one's, up to which a hull is a ship, rough and in sea water; beyond, a model.
inline constexpr double kLargestShipScale = 1.5;
/// Below this length [m] a file without a scale may be a model's.
inline constexpr double kUsualShipLength_m = 15.0;

/// What a data sheet says of a ship. SI and radians; what it leaves open is filled by fill() of statistics.hpp.
struct HullParticulars {
  std::string name, file;
  double scale = 1.0;                   ///< length of the full-scale ship by this one's
  bool has_scale = false;               ///< it is stated
  double L_pp = 0.0, B = 0.0, d = 0.0;  ///< [m]
  double d_aft = 0.0, d_fore = 0.0;     ///< [m]
  double C_b = 0.0;
  std::optional<double> x_G, wetted_surface, service_speed;  ///< [m, m^2, m/s]
  std::optional<PropellerParticulars> propeller;             ///< nothing: none is stated
  std::optional<RudderParticulars> rudder;
  std::optional<ThrusterParticulars> bow_thruster, stern_thruster;
  std::vector<ThrusterParticulars> azimuth_thrusters;
  SuperstructureParticulars superstructure;

  bool is_model() const { return scale > kLargestShipScale; }
  double volume() const { return C_b * L_pp * B * d; }
  /// m/(0.5 rho L^2 d).
  double m() const { return 2.0 * C_b * B / L_pp; }
};

/// Reads particulars ("-": standard input): a path, or the name of shipped ones such as "kvlcc2". docs/estimate.md
/// has the keys. Throws InputError with key, unit and range for what is missing (all of it at once), unknown or
/// impossible: a block coefficient of 8.1, a draft in feet, a propeller larger than the draft; and for what is not
/// supported, several propellers and pods.
HullParticulars read_particulars(const std::string& name_or_path);
HullParticulars read_particulars(io::JsonObject& json);

/// Density [kg/m^3] and kinematic viscosity [m^2/s] at 15 deg C by ITTC 7.5-02-01-03: sea water for a ship, fresh water
/// for a model.
struct Water {
  double rho, nu;
};
Water water_of(const HullParticulars& hull);

}  // namespace leeway::estimate
