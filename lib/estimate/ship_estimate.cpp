#include "estimate/ship_estimate.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "core/errors.hpp"
#include "core/random.hpp"
#include "core/statistics.hpp"
#include "core/units.hpp"
#include "dynamics/coefficient_law.hpp"
#include "dynamics/maneuvers.hpp"
#include "dynamics/straight_run.hpp"
#include "io/files.hpp"
#include "ship/joint_uncertainty.hpp"

namespace leeway::estimate {
namespace {

using io::Json;

constexpr double kMostRevolutions = 1.35;  // by those at service speed
constexpr double kStartRange = 50.0;       // of the revolutions tried for self-propulsion, by the service speed over D
constexpr double kAirDensity_kgpm3 = 1.225;

class Building {
 public:
  Building(const HullParticulars& particulars, const std::vector<Width>& widths)
      : h_(fill(particulars)), p_(h_.given), e_(estimate_coefficients(h_)), widths_(widths) {}

  ShipEstimate run() {
    head();
    forces();
    above_water();
    uncertainty();
    actuators();
    const Ship ship = parse_ship(json_, p_.name);
    name_sources(ship);
    if (h_.has_screw)
      set_revolutions(self_propulsion_n(ship, h_.service_speed));
    else
      check_thrusters(ship);
    if (!p_.has_scale && p_.L_pp < kUsualShipLength_m)
      e_.warnings.push_back(fmt::format(
          "/scale is not stated: this hull of {:g} m is taken for a ship in sea water; for a model state the "
          "length of its ship by its own",
          p_.L_pp));
    return {json_, parse_ship(json_, p_.name), h_.assumptions, e_.warnings};
  }

 private:
  std::string filled(std::string_view prefix) const {
    std::vector<std::string> texts;
    for (const Assumption& a : h_.assumptions)
      if (a.key.starts_with(prefix) && (!prefix.empty() || a.key.find('/') == std::string::npos))
        texts.push_back(fmt::format("{} {:.4g}: {}", a.key, a.value, a.source));
    return texts.empty() ? "" : fmt::format("; filled in: {}", fmt::join(texts, "; "));
  }

  void head() {
    json_["name"] = p_.name;
    json_["description"] = "estimated from principal particulars by mmg-sim estimate";
    json_["scale"] = p_.scale;
    json_["particulars"] = {{"source", "the particulars that were given; water of 15 deg C" + filled("")},
                            {"L_pp_m", p_.L_pp},
                            {"B_m", p_.B},
                            {"d_m", p_.d},
                            {"rho_kgpm3", h_.water.rho}};
    json_["inertia"] = {{"source", "m from C_b; added mass: coefficient_sources"},
                        {"m", h_.form.m},
                        {"x_G", h_.form.x_G},
                        {"m_x", e_["inertia.m_x"]},
                        {"m_y", e_["inertia.m_y"]},
                        {"I_zG_plus_J_z", e_["inertia.I_z"]}};
  }

  void forces() {
    Json& hull = json_["hull"];
    hull = {{"type", "mmg-standard"}, {"source", "each coefficient by its own formula: coefficient_sources"}};
    hull["R_0"] = e_["hull.resistance"];
    for (const char* name : {"X_vv", "X_vr", "X_rr", "X_vvvv", "Y_v", "Y_r", "Y_vvv", "Y_vvr", "Y_vrr", "Y_rrr", "N_v",
                             "N_r", "N_vvv", "N_vvr", "N_vrr", "N_rrr"})
      hull[name] = e_["hull." + std::string(name)];
    if (h_.has_screw) {
      propeller();
      rudder();
    }
    Json thrusters = Json::array();
    if (p_.bow_thruster) thrusters.push_back(side_thruster(*p_.bow_thruster, "n_bt"));
    if (p_.stern_thruster) thrusters.push_back(side_thruster(*p_.stern_thruster, "n_st"));
    for (std::size_t i = 0; i < p_.azimuth_thrusters.size(); ++i)
      thrusters.push_back(azimuth(p_.azimuth_thrusters[i], i == 0 ? "n_az1" : "n_az2"));
    if (!thrusters.empty()) json_["thrusters"] = thrusters;
  }

  void propeller() {
    json_["propeller"] = {
        {"type", "mmg-standard"},
        {"source", "Wageningen B series; wake and thrust deduction: coefficient_sources" + filled("propeller/")},
        {"D_P_m", h_.D_P},
        {"x_P", h_.x_P / p_.L_pp},
        {"pitch_ratio", h_.screw.pitch_ratio},
        {"K_T", e_.K_T},
        {"t_P", 1.0 - e_["propeller.1-t_P"]},
        {"w_P0", 1.0 - e_["propeller.1-w_P"]},
        {"C_1", e_["propeller.C_1"]},
        {"C_2_positive", e_["propeller.C_2_positive"]},
        {"C_2_negative", e_["propeller.C_2_negative"]},
        {"reversed",
         {{"source",
           "borrowed from the Esso Osaka model (NAOE-5thLab/mmg-1p1r-simulator, there attributed to Hachii): not this "
           "ship's"},
          {"K_T", {-0.175, 0.33}},
          {"K_T_low", -0.251},
          {"J_s", -0.233}}}};
  }

  void rudder() {
    Json& r = json_["rudder"];
    if (p_.rudder && p_.rudder->is_vectwin) {
      const Json like = io::read_json(io::find_config("ships", "vectwin-3m")).at("rudder");
      r = {{"type", like.at("type")},
           {"source", like.at("source").get<std::string>() + "; here with this ship's dimensions" + filled("rudder/")},
           {"A_R_m2", h_.A_R},
           {"aspect_ratio", h_.H_R * h_.H_R / h_.A_R},
           {"x_R_m", h_.x_R},
           {"t_R", like.at("t_R")},
           {"k_x", like.at("k_x")}};
      return;
    }
    r = {{"type", "mmg-standard"},
         {"source",
          "each coefficient by its own formula: coefficient_sources; k_reversed is borrowed from the Esso Osaka "
          "model" +
              filled("rudder/")},
         {"A_R_m2", h_.A_R},
         {"H_R_m", h_.H_R},
         {"x_R_m", h_.x_R},
         {"t_R", 1.0 - e_["rudder.1-t_R"]}};
    for (const char* name : {"a_H", "x_H", "l_R", "epsilon", "kappa", "gamma_R_negative", "gamma_R_positive"})
      r[name] = e_["rudder." + std::string(name)];
    r["f_alpha"] = e_["rudder.gain"];
    r["k_reversed"] = 0.144;
  }

  Json side_thruster(const ThrusterParticulars& t, const char* channel) const {
    const double K_T = t.max_thrust / (h_.water.rho * std::pow(t.diameter, 4.0) * t.max_n * t.max_n);
    return {{"type", "kobayashi-1988"},
            {"source",
             "K_T from the largest thrust and revolutions; loss with speed: captive tests at Osaka University in "
             "the form of Kobayashi (1988), those of vectwin-3m, up to a Froude number of 0.12"},
            {"channel", channel},
            {"D_m", t.diameter},
            {"x_m", t.x},
            {"K_T_positive", K_T},
            {"K_T_negative", -K_T},
            {"a_Y", {0.0, -12.701, 67.116}},
            {"a_N", {0.0, -6.5716, 79.614}},
            {"u_max_mps", 0.12 * std::sqrt(kGravity_mps2 * p_.L_pp)}};
  }

  Json azimuth(const ThrusterParticulars& t, const char* channel) const {
    const QuadraticThrust series = fit_quadratic({4.0, 0.55, 1.0});
    const double K_T = t.max_thrust / (h_.water.rho * std::pow(t.diameter, 4.0) * t.max_n * t.max_n);
    Json k = Json::array();
    for (const double x : series.K_T) k.push_back(x * K_T / series.K_T[0]);
    return {{"type", "azimuth"},
            {"source",
             "K_T from the largest thrust and revolutions, over J as the B4-55 of P/D 1.0 (Oosterveld & van Oossanen "
             "1975); w, t and k_turned are those of ferry-40m, estimated"},
            {"channel", channel},
            {"D_m", t.diameter},
            {"x_m", t.x},
            {"y_m", t.y},
            {"K_T", k},
            {"w", 0.08},
            {"t", 0.12},
            {"k_turned", 0.6}};
  }

  void above_water() {
    json_["wind"] = {{"type", "fujiwara-1998"},
                     {"source", kFujiwara.cited() +
                                    "; deck areas and centroids that no key "
                                    "holds by the proportions of the Esso Osaka" +
                                    filled("superstructure/")},
                     {"rho_air_kgpm3", kAirDensity_kgpm3},
                     {"B_m", p_.B},
                     {"A_T_m2", h_.A_T},
                     {"A_L_m2", h_.A_L},
                     {"A_OD_m2", 0.273 * h_.A_L},
                     {"C_m", h_.C},
                     {"C_BR_m", -0.0207 * p_.L_pp},
                     {"H_BR_m", h_.H_BR},
                     {"H_C_m", 0.6 * h_.A_L / p_.L_pp}};
  }

  void uncertainty() {
    Json& all = json_["uncertainty"];
    Json& sources = json_["coefficient_sources"];
    all = {{"source",
            "standard deviations of the errors over the hulls with public captive tests (docs/estimate.md), with "
            "Student's t for their number; {\"sd\"}: of the value, since the sign is not certain"}};
    for (const CoefficientEstimate& estimate : e_.all) {
      const ErrorKind& kind = *find_error_kind(estimate.name);
      const Spread spread = uncertainty_of(estimate, kind, widths_);
      all[estimate.name] = spread.is_absolute ? Json{{"sd", spread.sd}} : Json(std::min(spread.sd, kLogSdRange.high));
      sources[estimate.name] = estimate.source();
      if (spread.is_absolute && !kind.is_absolute)
        e_.warnings.push_back(fmt::format("{} is {:.3g}, and its sign is not known: {}", estimate.name, estimate.value,
                                          estimate.source()));
    }
    all["hull.resistance_slow"] = 0.10;
    if (h_.has_screw) {
      all["propeller.K_T_J"] = 0.05;
      all["propeller.K_T_JJ"] = 0.10;
      all["propeller.K_T_reversed"] = 0.30;
      if (!p_.rudder || !p_.rudder->is_vectwin) all["rudder.gain_35deg"] = 0.08;
    }
    all["wind.k_X"] = h_.has_stated_areas ? 0.20 : 0.35;
    all["wind.k_Y"] = h_.has_stated_areas ? 0.15 : 0.30;
    all["wind.k_N"] = h_.has_stated_areas ? 0.30 : 0.45;
  }

  // Where those coefficients come from that no formula of particulars gives; their uncertainties are ours.
  void name_sources(const Ship& ship) {
    Json& sources = json_["coefficient_sources"];
    const std::string width = "; its uncertainty is ours";
    for (const Coefficient& c : Model<double>(ship).coefficients()) {
      if (sources.contains(c.name)) continue;
      const std::string part = c.name.substr(0, c.name.find('.'));
      std::string source(c.reference);  // of resistance_slow, gain_35deg and gain_90deg: what the module has built in
      if (c.name == "propeller.K_T_J" || c.name == "propeller.K_T_JJ")
        source = sources["propeller.K_T"].get<std::string>() + ": the quadratic's";
      else if (c.name == "propeller.K_T_reversed")
        source = json_["propeller"]["reversed"]["source"].get<std::string>();
      else if (part == "wind" || (part == "rudder" && !c.name.starts_with("rudder.gain_") && ship.has_twin_rudders()))
        source = json_[part]["source"].get<std::string>();
      else if (part == "thruster" || part == "azimuth")
        source = thruster_source(c.name);
      sources[c.name] = source + width;
    }
  }

  // Of "thruster.K_T_bow_positive", "thruster.a_Y_stern", "azimuth.K_T_J_2".
  std::string thruster_source(const std::string& name) const {
    const std::string channel = name.find("_bow") != std::string::npos     ? "n_bt"
                                : name.find("_stern") != std::string::npos ? "n_st"
                                                                           : "n_az" + name.substr(name.size() - 1);
    const auto found =
        std::ranges::find_if(json_.at("thrusters"), [&](const Json& t) { return t["channel"] == channel; });
    return found->at("source").get<std::string>();
  }

  void check_thrusters(const Ship& ship) {
    try {
      self_propulsion_n(ship, ship.u0_mps);
    } catch (const NumericalError& e) {
      e_.warnings.push_back(fmt::format("{}: max_thrust_N is in N, max_rps in 1/s", e.what()));
    }
  }

  void actuators() {
    json_["actuators_source"] =
        "rudder: angle and rate as given or by statistics; revolutions: self-propulsion at the service "
        "speed by the estimate, limits 1.35 times that; random orders are ours" +
        filled("rudder/");
    json_["actuators"] = Json::array();
    Json& all = json_["actuators"];
    const double degree = 1.0 / kDegree, rate = degree * h_.rate, angle = degree * h_.max_angle;
    const double root = std::sqrt(p_.scale), per_s2 = 0.2 * root;
    const auto revolutions = [&](const char* channel, double low, double high, double initial) {
      return Json{{"channel", channel},   {"min_rps", low},
                  {"max_rps", high},      {"rate_rpsps", per_s2 * std::max(1.0, 0.1 * high)},
                  {"time_constant_s", 0}, {"initial_rps", initial}};
    };
    const auto rudder = [&](const char* channel, double low, double high) {
      return Json{{"channel", channel},   {"min_deg", low},   {"max_deg", high},      {"rate_degps", rate},
                  {"time_constant_s", 0}, {"initial_deg", 0}, {"random_mean_deg", 0}, {"random_sd_deg", 20}};
    };
    if (h_.has_screw) {
      if (p_.rudder && p_.rudder->is_vectwin) {
        all.push_back(rudder("delta_p", -105, 35));
        all.push_back(rudder("delta_s", -35, 105));
      } else {
        all.push_back(rudder("delta", -angle, angle));
      }
      const double wide = kStartRange * h_.service_speed / h_.D_P;
      all.push_back(revolutions("n_p", -wide, wide, 0.0));
    }
    for (const auto& [t, channel] : {std::pair{p_.bow_thruster, "n_bt"}, std::pair{p_.stern_thruster, "n_st"}})
      if (t) {
        all.push_back(revolutions(channel, -t->max_n, t->max_n, 0.0));
        all.back()["optional"] = true;
      }
    for (std::size_t i = 0; i < p_.azimuth_thrusters.size(); ++i) {
      const double n = p_.azimuth_thrusters[i].max_n;
      all.push_back(revolutions(i == 0 ? "n_az1" : "n_az2", 0.0, n, 0.75 * n));
      all.push_back({{"channel", i == 0 ? "az1" : "az2"},
                     {"rate_degps", 15.0 * std::sqrt(40.0 / p_.L_pp)},
                     {"time_constant_s", 0},
                     {"initial_deg", 0}});
    }
    json_["u0_mps"] = h_.service_speed;
    json_["random_interval_s"] = 30.0 * std::sqrt(p_.L_pp / 7.0);
  }

  void set_revolutions(double n) {
    for (Json& actuator : json_["actuators"]) {
      if (actuator["channel"] != "n_p") continue;
      actuator["min_rps"] = -kMostRevolutions * n;
      actuator["max_rps"] = kMostRevolutions * n;
      actuator["rate_rpsps"] = n * 0.5 / std::sqrt(p_.L_pp / 7.0);
      actuator["initial_rps"] = n;
    }
    if (!p_.propeller || !p_.propeller->n_service) return;
    const double stated = *p_.propeller->n_service;
    if (std::abs(std::log(n / stated)) > 0.15)
      e_.warnings.push_back(
          fmt::format("/propeller/rps_at_service_speed is {:g}, where the estimate needs {:.3g} 1/s: "
                      "resistance, wake or pitch are off by as much",
                      stated, n));
  }

  CompleteHull h_;
  const HullParticulars& p_;
  CoefficientEstimates e_;
  const std::vector<Width>& widths_;
  Json json_;
};

}  // namespace

ShipEstimate estimate_unconditioned(const HullParticulars& particulars, const std::vector<Width>& widths) {
  return Building(particulars, widths).run();
}

namespace {

std::optional<double> one_sided_diameter(const Ship& ship, double rudder) {
  constexpr double kMostLengths = 40.0, kStepsPerLength = 20.0;
  const double u = ship.u0_mps, dt_s = ship.particulars.L_pp / u / kStepsPerLength, side = std::copysign(1.0, rudder);
  SimulatedShip turning(ship, u);
  Actuators<double> command = ship.initial_actuators();
  order_rudders(ship, rudder, command);
  double psi = 0.0, y0 = 0.0;
  for (int k = 0; k < static_cast<int>(kMostLengths * kStepsPerLength); ++k) {
    turning.step(command, Vec2<double>::Zero(), dt_s);
    if (!turning.is_finite()) return std::nullopt;
    const double now = side * turning.state.eta(2), across = side * turning.state.eta(1);
    if (now >= kPi) return (y0 + (across - y0) * (kPi - psi) / (now - psi)) / ship.particulars.L_pp;
    psi = now;
    y0 = across;
  }
  return std::nullopt;
}

// d ln D_T/d theta of each coefficient: a chord over its standard deviation to both sides, or to one of them.
Eigen::VectorXd turning_gradient(const Ship& ship, const CoefficientLaw& law, double nominal) {
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(law.coefficients.size()));
  for (std::size_t i = 0; i < law.coefficients.size(); ++i) {
    double difference = 0.0, width = 0.0;
    for (const double side : {1.0, -1.0}) {
      Ship moved = ship;
      moved.multiply({changed(law.coefficients[i], side * law.coefficients[i].sd)});
      const std::optional<double> D_T = tactical_diameter(moved);
      if (!D_T || !(*D_T > 0.1 * nominal)) continue;  // it does not come round, or no longer swings out
      difference += side * std::log(*D_T / nominal);
      width += law.coefficients[i].sd;
    }
    if (width > 0.0) gradient(static_cast<Eigen::Index>(i)) = difference / width;
  }
  return gradient;
}

// The law given that ln D_T, linear in theta, has the standard deviation tau: a measurement of it as good as that
// takes.
Eigen::MatrixXd conditioned(const CoefficientLaw& law, const Eigen::VectorXd& gradient, double tau) {
  const Eigen::VectorXd gain = law.covariance * gradient;
  const double variance = gradient.dot(gain);
  if (!(variance > tau * tau)) return law.covariance;
  const double noise = 1.0 / (1.0 / (tau * tau) - 1.0 / variance);
  const Eigen::MatrixXd result = law.covariance - gain * gain.transpose() / (variance + noise);
  return 0.5 * (result + result.transpose());
}

// What ln D_T of draws from the law has as standard deviation: the 95 % interval's, since both tails are bent.
double drawn_sd(const Ship& ship, const CoefficientLaw& law) {
  constexpr int kDraws = 100;
  constexpr double kWidthOf95 = 2.0 * 1.959963985;
  RandomStream random(1, "tactical diameters of an estimate");
  std::vector<double> logs;
  for (int i = 0; i < kDraws; ++i) {
    Ship drawn = ship;
    drawn.multiply(draw_factors(law, 1.0, random));
    if (const std::optional<double> D_T = tactical_diameter(drawn)) logs.push_back(std::log(*D_T));
  }
  std::ranges::sort(logs);
  return logs.size() < 2 ? 0.0 : (quantile(logs, 0.975) - quantile(logs, 0.025)) / kWidthOf95;
}

// The law conditioned on ln D_T having the standard deviation tau in draws: what D_T is not linear in, the linear part
// has to leave room for, and where that is not enough the law as a whole.
Eigen::MatrixXd conditioned_on_turning(const Ship& ship, const CoefficientLaw& independent, double D_T, double tau) {
  constexpr double kLeastLinear = 0.4, kLeastWhole = 0.8;  // of tau, of the standard deviations
  const Eigen::VectorXd gradient = turning_gradient(ship, independent, D_T);
  CoefficientLaw law = independent;
  law.covariance = conditioned(independent, gradient, tau);
  const double drawn = drawn_sd(ship, law), bent2 = std::max(0.0, drawn * drawn - tau * tau);
  law.covariance =
      conditioned(independent, gradient, std::sqrt(std::max(tau * tau - bent2, std::pow(kLeastLinear * tau, 2.0))));
  const double whole = std::clamp(tau / std::max(drawn_sd(ship, law), 1e-6), kLeastWhole, 1.0);
  return whole * whole * law.covariance;
}

}  // namespace

std::optional<double> tactical_diameter(const Ship& ship) {
  try {
    const auto starboard = one_sided_diameter(ship, 35.0 * kDegree), port = one_sided_diameter(ship, -35.0 * kDegree);
    if (!starboard || !port || !(*starboard > 0.0) || !(*port > 0.0)) return std::nullopt;
    return std::sqrt(*starboard * *port);
  } catch (const NumericalError&) {
    return std::nullopt;
  }
}

ShipEstimate estimate_ship(const HullParticulars& particulars, const std::vector<Width>& widths) {
  ShipEstimate result = estimate_unconditioned(particulars, widths);
  const auto width = std::ranges::find_if(widths, [](const Width& w) { return w.name == kTacticalDiameter; });
  const std::optional<double> D_T = tactical_diameter(result.ship);
  if (width == widths.end() || !D_T || result.ship.has_twin_rudders() || !result.ship.has_rudders()) return result;
  const CoefficientLaw law = coefficient_law(result.ship);
  const Eigen::MatrixXd covariance = conditioned_on_turning(result.ship, law, *D_T, width->sd);
  Ship::JointUncertainty joint{{}, covariance};
  for (const UncertainCoefficient& coefficient : law.coefficients) joint.names.push_back(coefficient.name);
  result.json["coefficient_covariance"] =
      to_json(joint, fmt::format("uncertainty, both sides correlated by {:g}; conditioned on the tactical "
                                 "diameter, which such estimates have met with a log-sd of {:.3f} (docs/estimate.md)",
                                 kSidesCorrelation, width->sd));
  result.ship = parse_ship(result.json, particulars.name);
  return result;
}

}  // namespace leeway::estimate
