#pragma once

#include <string>
#include <vector>

#include "estimate/holtrop.hpp"
#include "estimate/hull_particulars.hpp"
#include "estimate/regressions.hpp"
#include "estimate/wageningen.hpp"

namespace leeway::estimate {

/// What was filled in for a particular that was not stated.
struct Assumption {
  std::string key;  ///< as in the particulars' JSON, with its unit
  double value;     ///< in that unit
  std::string source;
};

/// Particulars without holes. SI and radians.
struct CompleteHull {
  HullParticulars given;
  HullForm form{};
  Water water{};
  double x_G = 0.0, service_speed = 0.0;
  HoltropHull holtrop;
  bool has_screw = true;  ///< a propeller and a rudder; else azimuth thrusters alone
  double D_P = 0.0, x_P = 0.0;
  SeriesPropeller screw;
  double A_R = 0.0, H_R = 0.0, x_R = 0.0, max_angle = 0.0, rate = 0.0;
  double A_T = 0.0, A_L = 0.0, C = 0.0, H_BR = 0.0;  ///< above water: front, side [m^2], centroid, height [m]
  bool has_stated_areas = false;
  std::vector<Assumption> assumptions;
  std::vector<std::string> warnings;  ///< values that statistics gave and what makes sense limits

  double Froude() const;
};

/// Wake fraction by Holtrop & Mennen (1982). A model's friction is far outside of their data: its wake is that of the
/// ship by ITTC 1978, w_m = t + 0.04 + (w_s - t - 0.04) ((1 + k) C_Fm)/((1 + k) C_Fs + dC_F).
double wake_by_holtrop(const CompleteHull& hull);

/// Roughness allowance of ITTC 1978: 0.044 ((k_s/L)^(1/3) - 10 Re^(-1/3)) + 0.000125, not below 0.
double roughness_allowance(double L, double Re);

/// Fills what is not stated by statistics of ships, each named in `assumptions`.
CompleteHull fill(const HullParticulars& given);

}  // namespace leeway::estimate
