#include "estimate/statistics.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/units.hpp"

namespace leeway::estimate {
namespace {

constexpr double kFullForm = 0.75;  // C_b, from which on a ship is taken for a tanker or bulk carrier

// The stated value, or the other one with a note of it.
class Filling {
 public:
  explicit Filling(CompleteHull& hull) : hull_(hull) {}
  double operator()(const std::optional<double>& stated, const char* key, double otherwise, std::string source,
                    double unit = 1.0) const {
    if (stated) return *stated;
    hull_.assumptions.push_back({key, otherwise / unit, std::move(source)});
    return otherwise;
  }
  // The same where a formula's value is limited to what makes sense, which is said.
  double operator()(const std::optional<double>& stated, const char* key, double otherwise, double low, double high,
                    const std::string& source, double unit = 1.0) const {
    if (stated) return *stated;
    const double held = std::clamp(otherwise, low, high);
    std::string why = source;
    if (held != otherwise) {
      why += fmt::format("; limited to {:.4g} from {:.4g}", held / unit, otherwise / unit);
      hull_.warnings.push_back(fmt::format("/{} is {:.4g} by {}: limited to {:.4g} to {:.4g}", key, otherwise / unit,
                                           source, low / unit, high / unit));
    }
    hull_.assumptions.push_back({key, held / unit, why});
    return held;
  }

 private:
  CompleteHull& hull_;
};

void fill_hull(CompleteHull& h, const Filling& stated) {
  const HullParticulars& p = h.given;
  h.water = water_of(p);
  h.x_G = stated(p.x_G, "x_G_m", 0.2 * (p.C_b - 0.675) * p.L_pp, kSchneekluth.cited());
  h.form = {p.C_b, p.L_pp / p.B, p.B / p.d, p.L_pp / p.d, h.x_G / p.L_pp, p.m()};
  const double wave = std::sqrt(kGravity_mps2 * p.L_pp);
  h.service_speed = stated(p.service_speed, "service_speed_mps", (1.08 - p.C_b) / 1.68 * wave, 0.12 * wave, 0.35 * wave,
                           kAlexander.cited() + ", Froude number 0.12 to 0.35");
  HoltropHull& w = h.holtrop;
  w.L = p.L_pp;
  w.B = p.B;
  w.T_F = p.d_fore;
  w.T_A = p.d_aft;
  w.volume = p.volume();
  w.lcb = std::clamp(100.0 * h.x_G / p.L_pp, -5.0, 5.0);
  // Kerlen's falls to nothing below a C_b of 0.3; Jensen's agrees with it at 0.4.
  w.C_M = p.C_b < 0.4 ? 1.0 / (1.0 + std::pow(1.0 - p.C_b, 3.5)) : 1.006 - 0.0056 * std::pow(p.C_b, -3.56);
  w.C_WP = (1.0 + 2.0 * p.C_b) / 3.0;
  w.A_BT = 0.08 * p.B * p.d * w.C_M;
  w.h_B = 0.4 * p.d_fore;
  w.rho = h.water.rho;
  w.nu = h.water.nu;
  w.has_allowance = !p.is_model();
  w.wetted_surface =
      stated(p.wetted_surface, "wetted_surface_m2", holtrop_wetted_surface(w),
             "Holtrop & Mennen (1982), with C_M by Kerlen (1970), below a C_b of 0.4 by Jensen (1994), both as in "
             "Schneekluth & Bertram (1998), C_WP = (1 + 2 C_b)/3 and a bulb of 8 % "
             "of the midship section");
}

// The pitch that gives the thrust at the stated revolutions; nothing where none of the series does.
std::optional<double> pitch_for(const CompleteHull& h, double n) {
  constexpr double kLeast = 0.5, kMost = 1.4, kStep = 0.005;  // of the series
  const double t = holtrop_thrust_deduction(h.holtrop, h.D_P);
  const double w = 0.5 * (wake_by_holtrop(h) + w_P0_by_yoshimura(h.form));
  const double T = holtrop_resistance(h.holtrop, h.service_speed).total / (1.0 - t);
  const double K_T = T / (h.water.rho * n * n * std::pow(h.D_P, 4.0)), J = h.service_speed * (1.0 - w) / (n * h.D_P);
  SeriesPropeller screw = h.screw;
  for (screw.pitch_ratio = kLeast; screw.pitch_ratio <= kMost; screw.pitch_ratio += kStep)
    if (wageningen_K_T(screw, J) >= K_T) {
      if (screw.pitch_ratio == kLeast) return std::nullopt;  // it gives more than that
      return screw.pitch_ratio;
    }
  return std::nullopt;
}

void fill_pitch(CompleteHull& h, const PropellerParticulars& given, const Filling& stated) {
  std::optional<double> by_n;
  if (!given.pitch_ratio && given.n_service) {
    by_n = pitch_for(h, *given.n_service);
    if (!by_n)
      h.warnings.push_back(
          fmt::format("/propeller/rps_at_service_speed is {:g}: no pitch ratio of the B series, 0.5 to 1.4, gives the "
                      "thrust at it with a diameter of {:.4g} m; the pitch is by C_b",
                      *given.n_service, h.D_P));
  }
  if (by_n)
    h.screw.pitch_ratio = stated(std::nullopt, "propeller/pitch_ratio", *by_n,
                                 "from the revolutions at service speed: the B series gives the thrust");
  else
    h.screw.pitch_ratio = stated(given.pitch_ratio, "propeller/pitch_ratio", 1.6 - 1.1 * h.given.C_b, 0.65, 1.1,
                                 "1.6 - 1.1 C_b, through usual pitches of container ships and tankers (ours)");
}

void fill_screw(CompleteHull& h, const Filling& stated) {
  const HullParticulars& p = h.given;
  const PropellerParticulars given = p.propeller.value_or(PropellerParticulars{});
  const double ship_draft = p.d * p.scale;
  const bool is_full = p.C_b >= kFullForm;
  const double D = is_full ? 0.395 * ship_draft + 1.30 : 0.623 * ship_draft - 0.16;
  h.D_P = stated(given.diameter, "propeller/diameter_m", D / p.scale, 0.3 * p.d, 0.75 * p.d,
                 (is_full ? kTankerPropeller : kContainerPropeller).cited() + ", 0.3 to 0.75 of the draft");
  h.screw.blades = stated(given.blades, "propeller/blades", 4.0, "the usual number");
  h.screw.area_ratio =
      stated(given.area_ratio, "propeller/area_ratio", is_full ? 0.45 : 0.65, "usual of this form (ours)");
  fill_pitch(h, given, stated);
  h.x_P = stated(given.x, "propeller/x_m", -0.48 * p.L_pp, "0.48 L behind midship");
}

void fill_rudder(CompleteHull& h, const Filling& stated) {
  const HullParticulars& p = h.given;
  const RudderParticulars given = p.rudder.value_or(RudderParticulars{});
  const double B_by_L = p.B / p.L_pp;
  h.A_R =
      stated(given.area, "rudder/area_m2", 0.01 * p.L_pp * p.d * (1.0 + 25.0 * B_by_L * B_by_L), kRudderArea.cited());
  h.H_R = stated(given.height, "rudder/height_m", std::sqrt(1.8 * h.A_R), 0.0, 0.95 * p.d_aft,
                 "an aspect ratio of 1.8, within 0.95 of the draft aft (ours)");
  h.x_R = stated(given.x, "rudder/x_m", -0.5 * p.L_pp, "at the aft perpendicular");
  h.max_angle = stated(given.max_angle, "rudder/max_angle_deg", 35.0 * kDegree, "the usual stop", kDegree);
  h.rate = stated(given.rate, "rudder/rate_degps", 65.0 / 28.0 * kDegree * std::sqrt(p.scale),
                  "SOLAS: 35 to -30 deg in 28 s, by Froude's law", kDegree);
}

// By the proportions of the Esso Osaka model's public wind geometry.
void fill_superstructure(CompleteHull& h, const Filling& stated) {
  constexpr const char* kSource = "proportions of the Esso Osaka's wind geometry (NAOE-5thLab/mmg-1p1r-simulator)";
  const HullParticulars& p = h.given;
  const SuperstructureParticulars& s = p.superstructure;
  h.has_stated_areas = s.frontal_area && s.lateral_area;
  h.A_T = stated(s.frontal_area, "superstructure/frontal_area_m2", 0.566 * p.B * p.B, kSource);
  h.A_L = stated(s.lateral_area, "superstructure/lateral_area_m2", 0.0578 * p.L_pp * p.L_pp, kSource);
  h.C = stated(s.lateral_centroid_x, "superstructure/lateral_centroid_x_m", -0.0043 * p.L_pp, kSource);
  h.H_BR = stated(s.height, "superstructure/height_m", 0.098 * p.L_pp, kSource);
}

}  // namespace

double roughness_allowance(double L, double Re) {
  constexpr double kRoughness_m = 150e-6;
  return std::max(0.0, 0.044 * (std::cbrt(kRoughness_m / L) - 10.0 / std::cbrt(Re)) + 0.000125);
}

double wake_by_holtrop(const CompleteHull& hull) {
  const HullParticulars& p = hull.given;
  if (!p.is_model()) return holtrop_wake(hull.holtrop, hull.service_speed, hull.D_P);
  HoltropHull ship = hull.holtrop;
  for (double* length : {&ship.L, &ship.B, &ship.T_F, &ship.T_A, &ship.h_B}) *length *= p.scale;
  ship.volume *= p.scale * p.scale * p.scale;
  ship.A_BT *= p.scale * p.scale;
  ship.wetted_surface *= p.scale * p.scale;
  const Water sea = water_of(HullParticulars{});
  ship.rho = sea.rho;
  ship.nu = sea.nu;
  ship.has_allowance = true;
  const double U = hull.service_speed * std::sqrt(p.scale), D = hull.D_P * p.scale, Re = U * ship.L / ship.nu;
  const double w_s = holtrop_wake(ship, U, D), rest = holtrop_thrust_deduction(ship, D) + 0.04;
  const double k = holtrop_form_factor(ship);
  const double of_model = k * ittc_57(hull.service_speed * p.L_pp / hull.water.nu);
  const double of_ship = k * ittc_57(Re) + roughness_allowance(ship.L, Re);
  return rest + (w_s - rest) * of_model / of_ship;
}

double CompleteHull::Froude() const { return service_speed / std::sqrt(kGravity_mps2 * given.L_pp); }

CompleteHull fill(const HullParticulars& given) {
  CompleteHull hull;
  hull.given = given;
  const Filling stated(hull);
  fill_hull(hull, stated);
  hull.has_screw = given.azimuth_thrusters.empty() || given.propeller || given.rudder;
  if (hull.has_screw) {
    fill_screw(hull, stated);
    fill_rudder(hull, stated);
  }
  fill_superstructure(hull, stated);
  return hull;
}

}  // namespace leeway::estimate
