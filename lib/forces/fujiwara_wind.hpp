#pragma once

#include <array>
#include <cmath>
#include <string_view>

#include "core/scalar.hpp"
#include "core/types.hpp"
#include "forces/coefficient_list.hpp"
#include "forces/concepts.hpp"
#include "forces/particulars.hpp"
#include "forces/wind_form.hpp"
#include "io/json.hpp"

namespace leeway {

/// Geometry above water for Fujiwara et al. (1998).
struct FujiwaraWindGeometry {
  double rho_air;         ///< [kg/m^3]
  double B;               ///< [m]
  double A_T, A_L, A_OD;  ///< front, side, side of superstructure and deck cargo [m^2]
  double C, C_BR;         ///< midship to the centroids of A_L and A_OD, + forward [m]
  double H_BR, H_C;       ///< waterline to top of bridge and to the centroid of A_L [m]

  /// Its keys in a ship's JSON, besides type and source.
  static FujiwaraWindGeometry read(const io::JsonObject& json) {
    return {json.number("rho_air_kgpm3", io::kPositive),
            json.number("B_m", io::kPositive),
            json.number("A_T_m2", io::kPositive),
            json.number("A_L_m2", io::kPositive),
            json.number("A_OD_m2", io::kPositive),
            json.number("C_m"),
            json.number("C_BR_m"),
            json.number("H_BR_m", io::kPositive),
            json.number("H_C_m", io::kPositive)};
  }
};

/// Wind force by regression from the geometry above water; the direction gamma_A is where the wind comes from, 0 from
/// the bow, positive from starboard.
///   wind     apparent wind U_A (cos gamma_A, sin gamma_A) in ship axes [m/s], as apparent_wind() gives it
///   returns  (X_A [N], Y_A [N], N_A [N m]) at midship
/// Source: Fujiwara, Ueno & Nimura (1998), J. SNAJ 183, 77-90; the length is L_pp where the paper has L_OA.
template <typename T>
struct FujiwaraWind {
  using Coefficients = FujiwaraWindGeometry;
  static constexpr std::string_view group = "wind", name = "fujiwara-1998";
  static constexpr std::string_view reference = "Fujiwara, Ueno & Nimura (1998), J. SNAJ 183, 77-90";
  FujiwaraWindGeometry g;
  double L;
  T A_front, A_side;                         ///< areas that make the force: A_T and A_L, unless changed [m^2]
  T X0, X1, X3, X5, Y1, Y3, Y5, N1, N2, N3;  ///< of cos and sin (k A), A = 2 pi - gamma_A
  WindForm<T> form;

  FujiwaraWind(const FujiwaraWindGeometry& geometry, const Particulars& particulars)
      : g(geometry), L(particulars.L_pp), A_front(geometry.A_T), A_side(geometry.A_L) {
    const auto& [rho, B, A_T, A_L, A_OD, C, C_BR, H_BR, H_C] = g;
    X0 = T(-0.330 + 0.293 * B * H_BR / A_T + 0.0193 * C / H_C + 0.682 * A_OD / (L * L));
    X1 = T(-1.353 + 1.700 * A_L / (L * B) + 2.870 * L * H_C / A_L - 0.463 * L * H_BR / A_L - 0.570 * A_OD / A_L -
           6.640 * A_T / (L * B) - 0.0123 * L * L / A_T + 0.0202 * L / H_C);
    X3 = T(0.830 - 0.413 * A_L / (L * H_BR) - 0.0827 * A_L / A_T - 0.563 * L * H_C / A_L + 0.804 * A_OD / A_L -
           5.670 * A_OD / (L * L) + 0.0401 * C / H_C - 0.132 * C_BR / L);
    X5 = T(0.0372 - 0.0075 * A_L / A_OD - 0.103 * C_BR / L + 0.0921 * A_L / (L * B));
    Y1 =
        T(0.684 + 0.717 * C_BR / L - 3.220 * C / L + 0.0281 * A_L / A_OD + 0.0661 * C / H_C + 0.298 * A_T / (B * H_BR));
    Y3 = T(-0.400 + 0.282 * A_L / (L * B) + 0.307 * L * H_C / A_L + 0.0519 * C_BR / L + 0.0526 * B / H_BR -
           0.0814 * A_OD / A_L + 0.0582 * A_T / (B * H_BR));
    Y5 = T(0.122 - 0.166 * A_L / (L * B) - 0.0054 * L / H_BR - 0.0481 * C_BR / L - 0.0136 * B * B / A_T +
           0.0864 * C / L - 0.0297 * C * H_C / A_L);
    N1 = T(0.299 + 1.710 * C / L + 0.183 * L * H_C / A_L - 1.09 * A_T / A_L - 0.0442 * C / H_C - 0.289 * A_L / (L * B) +
           4.24 * A_T / (L * L) - 0.0646 * B * B / A_T + 0.0306 * C_BR / L);
    N2 = T(0.117 + 0.123 * C_BR / L - 0.323 * C / L + 0.0041 * A_L / A_OD - 0.166 * A_T / (B * B) - 0.0109 * L / H_BR +
           0.174 * A_T / (B * H_BR) + 0.214 * A_L / (L * B) - 1.06 * A_L / (L * L));
    N3 = T(0.0230 + 0.0385 * C_BR / L - 0.0339 * A_T / (B * H_BR) + 0.0023 * A_L / A_T);
  }

  /// Gains of the three forces.
  void scale(const T& k_X, const T& k_Y, const T& k_N) {
    for (T* k : {&X0, &X1, &X3, &X5}) *k *= k_X;
    for (T* k : {&Y1, &Y3, &Y5}) *k *= k_Y;
    for (T* k : {&N1, &N2, &N3}) *k *= k_N;
  }
  /// More area above water with the same coefficients [m^2].
  void add_areas(const T& front, const T& side) {
    A_front += front;
    A_side += side;
  }
  /// All forces by this factor.
  void scale_force(const T& k) { scale(k, k, k); }
  /// What is known up to a factor: visit(name, log_sd, reference, scale), where scale(k) multiplies by k.
  template <typename Visit>
  void coefficients(const Visit& visit) {
    visit("wind.k_X", 0.2, reference, [&](const T& k) { scale(k, T(1.0), T(1.0)); });
    visit("wind.k_Y", 0.15, reference, [&](const T& k) { scale(T(1.0), k, T(1.0)); });
    visit("wind.k_N", 0.3, reference, [&](const T& k) { scale(T(1.0), T(1.0), k); });
    form.coefficients(visit);
  }

  /// (C_X, C_Y, C_N) for the direction given by its cosine and sine.
  Vec3<T> coefficients(const T& cos_gamma, const T& sin_gamma) const {
    // Multiple angles by recurrence: cos 2x, cos 3x, cos 5x and the same for sine.
    const T &c1 = cos_gamma, &s1 = sin_gamma;
    const T c2 = c1 * c1 - s1 * s1, s2 = 2.0 * s1 * c1;
    const T c3 = c2 * c1 - s2 * s1, s3 = s2 * c1 + c2 * s1;
    const T c5 = c3 * c2 - s3 * s2, s5 = s3 * c2 + c3 * s2;
    const Vec3<T> regressed(X0 + X1 * c1 + X3 * c3 + X5 * c5, -(Y1 * s1 + Y3 * s3 + Y5 * s5),
                            -(N1 * s1 + N2 * s2 + N3 * s3));
    return form.is_own ? regressed : form.other(regressed, c1);
  }

  Vec3<T> force(const Vec2<T>& wind) const {
    using std::sqrt;
    const T U2 = wind(0) * wind(0) + wind(1) * wind(1);
    if (!(U2 > T(kAtRest_m2ps2))) return Vec3<T>::Zero();
    const T per_U = 1.0 / sqrt(U2);
    const Vec3<T> k = coefficients(wind(0) * per_U, wind(1) * per_U);
    const T q = 0.5 * g.rho_air * U2;
    return {q * A_front * k(0), q * A_side * k(1), q * A_side * L * k(2)};
  }
};

static_assert(HasWindForce<FujiwaraWind<double>>);

}  // namespace leeway
