#pragma once

#include <array>
#include <cmath>
#include <string_view>

#include "core/scalar.hpp"
#include "core/units.hpp"
#include "forces/actuators.hpp"
#include "forces/coefficient_list.hpp"
#include "forces/concepts.hpp"
#include "forces/motion.hpp"
#include "forces/particulars.hpp"
#include "io/json.hpp"

namespace leeway {

/// Azimuth thruster.
template <typename T>
struct AzimuthThrusterCoefficients {
  Channel channel;       ///< n_az1 or n_az2; its angle is az1 or az2
  double D, x, y;        ///< diameter; place, + forward and to starboard [m]
  std::array<T, 3> K_T;  ///< constant, J, J^2
  T w, t;                ///< wake fraction and thrust deduction along the ship, ahead as astern
  T k_turned;            ///< share of the cross flow that leaves with the race, along the axis

  template <typename U>
  AzimuthThrusterCoefficients<U> cast() const {
    return {channel, D, x, y, cast_all<U>(K_T), U(w), U(t), U(k_turned)};
  }

  Channel angle() const { return channel == Channel::n_az1 ? Channel::az1 : Channel::az2; }
  /// The actuators that act on it.
  std::array<Channel, 2> channels() const { return {channel, angle()}; }
  /// Its keys in a ship's JSON, besides type and source.
  static AzimuthThrusterCoefficients read(const io::JsonObject& json) {
    const Channel channel = json.word("channel", {"n_az1", "n_az2"}) == "n_az1" ? Channel::n_az1 : Channel::n_az2;
    return {channel,
            json.number("D_m", io::kPositive),
            json.number("x_m"),
            json.number("y_m"),
            json.array<3>("K_T"),
            json.number("w", {0.0, 1.0}),
            json.number("t", {0.0, 1.0}),
            json.number("k_turned", {0.0, 2.0})};
  }
  /// What a rudder angle means to it [rad], positive to starboard: forward of midship it pushes the bow, aft the stern.
  void steer(double rudder_rad, Actuators<double>& command) const {
    command[angle()] = x > 0.0 ? rudder_rad : -rudder_rad;
  }
};

/// Propeller that turns about the vertical, az: angle of its thrust on the ship, 0 ahead, positive to starboard, as
/// many turns as one likes. Defined for n >= 0; negative revolutions act as n = 0.
///   motion   (u, v_m [m/s], r [rad/s]) at midship, through the water
///   returns  (X [N], Y [N], N [N m]) at midship
/// Inflow along the axis and across it, of the water at the thruster's place:
///   u_P = (1 - w)(u - y r) cos az + (v_m + x r) sin az,  v_P = (v_m + x r) cos az - (1 - w)(u - y r) sin az
/// Thrust over the advance ratio u_P/(n D) as of the standard propeller, without dividing by n:
///   T = rho D^4 (k0 n^2 + k1 n w_D + k2 w_D |w_D|), w_D = u_P/D,
/// with K_T of an open-water series, e.g. Oosterveld & van Oossanen (1975), Int. Shipbuilding Progress 22 (251).
/// Oblique inflow: the race leaves along the axis, so that the flow through the disk loses its cross flow,
///   F = -k_turned rho (pi/4) D^2 u_D v_P across the axis, u_D = (|u_P| + sqrt(u_P^2 + 8 max(T, 0)/(pi rho D^2)))/2,
/// u_D by the axial momentum theory of the actuator disk. The trajectory of an azimuth thruster's race comes from the
/// same momentum in Brandner & Renilson (1998), J. Ship Research 42 (1), 15-32. Ours: the closed form, for which u_D
/// leaves out v_P; the factor k_turned; w and t along the ship alone; K_T at J < 0 by the same polynomial.
/// Left out: that one thruster works in another's race, Coanda effect at the hull, drag of housing and strut.
template <typename T>
struct AzimuthThruster {
  using Coefficients = AzimuthThrusterCoefficients<double>;
  static constexpr bool drives_ship = true;
  static constexpr std::string_view group = "azimuth", name = "azimuth";
  static constexpr std::string_view reference = "Oosterveld & van Oossanen (1975), Int. Shipbuilding Progress 22 (251)";
  static constexpr std::string_view reference_of_wake = "wake and thrust deduction along the ship alone (ours)";
  static constexpr std::string_view reference_of_flow = "momentum of the flow through an actuator disk (ours)";
  AzimuthThrusterCoefficients<T> c;
  Particulars p;

  AzimuthThruster(const AzimuthThrusterCoefficients<double>& coefficients, const Particulars& particulars)
      : c(coefficients.cast<T>()), p(particulars) {}

  void scale_thrust(const T& k) { factor_on(c.K_T)(k); }
  /// w plus this much.
  void increase_wake(const T& dw) { c.w += dw; }
  /// w by this factor.
  void scale_wake(const T& k) { c.w *= k; }
  /// All forces by this factor.
  void scale_force(const T& k) {
    scale_thrust(k);
    c.k_turned *= k;
  }
  /// What is known up to a factor: visit(name, log_sd, reference, scale), where scale(k) multiplies by k.
  template <typename Visit>
  void coefficients(const Visit& visit) {
    const bool is_first = c.channel == Channel::n_az1;
    visit(is_first ? "azimuth.K_T_1" : "azimuth.K_T_2", 0.05, reference, factor_on(c.K_T));
    visit(is_first ? "azimuth.K_T_J_1" : "azimuth.K_T_J_2", 0.10, reference, factor_on(c.K_T[1]));
    visit(is_first ? "azimuth.K_T_JJ_1" : "azimuth.K_T_JJ_2", 0.10, reference, factor_on(c.K_T[2]));
    visit(is_first ? "azimuth.1-w_1" : "azimuth.1-w_2", 0.05, reference_of_wake, factor_on_rest(c.w));
    visit(is_first ? "azimuth.1-t_1" : "azimuth.1-t_2", 0.05, reference_of_wake, factor_on_rest(c.t));
    visit(is_first ? "azimuth.k_turned_1" : "azimuth.k_turned_2", 0.3, reference_of_flow, factor_on(c.k_turned));
  }

  Vec3<T> force(const Motion<T>& motion, const ActingActuators<T>& actuators) const {
    using std::abs, std::cos, std::sin, std::sqrt;
    const T &n_az = actuators[c.channel], &az = actuators[c.angle()];
    const T n = n_az > T(0.0) ? n_az : T(0.0);
    const T cos_az = cos(az), sin_az = sin(az);
    const T along_ship = (1.0 - c.w) * (motion.u - c.y * motion.r), across_ship = motion.v + c.x * motion.r;
    const T u_P = along_ship * cos_az + across_ship * sin_az, v_P = across_ship * cos_az - along_ship * sin_az;

    const double D2 = c.D * c.D;
    const T w_D = u_P / c.D;
    const T n2_K_T = c.K_T[0] * n * n + c.K_T[1] * n * w_D + c.K_T[2] * w_D * abs(w_D);
    const T thrust = p.rho * D2 * D2 * n2_K_T;

    T race2 = u_P * u_P;  // squared speed far behind the disk
    if (n2_K_T > T(0.0)) race2 += (8.0 / kPi) * D2 * n2_K_T;
    const T race = race2 > T(kAtRest_m2ps2) ? T(sqrt(race2)) : T(0.0);
    const T turned = c.k_turned * (p.rho * kPi / 8.0 * D2) * (abs(u_P) + race) * v_P;

    const T X = (1.0 - c.t) * thrust * cos_az + turned * sin_az;
    const T Y = thrust * sin_az - turned * cos_az;
    return {X, Y, c.x * Y - c.y * X};
  }
};

static_assert(HasThrust<AzimuthThruster<double>> && HasWake<AzimuthThruster<double>>);

}  // namespace leeway
