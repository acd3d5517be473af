#include "estimate/ship_scaling.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/errors.hpp"
#include "core/units.hpp"
#include "dynamics/coefficient_law.hpp"
#include "dynamics/straight_run.hpp"
#include "estimate/holtrop.hpp"
#include "estimate/statistics.hpp"

namespace leeway::estimate {
namespace {

using io::Json;

constexpr double kSame = 1e-9;  // of two lengths by each other: nothing to scale

// Powers of length by which Froude's law scales the numbers whose key ends so; others are nondimensional.
const std::map<std::string, double, std::less<>> kPowers{
    {"_m", 1.0}, {"_m2", 2.0}, {"_mps", 0.5}, {"_rps", -0.5}, {"_degps", -0.5}, {"_rpsps", -1.0}, {"_s", 0.5}};
// Revolutions without that end.
constexpr const char* kRevolutionsAtOne = "n_rps_at_1";

double power_of(const std::string& key) {
  if (key == kRevolutionsAtOne) return -0.5;
  if (key == "J_s") return 0.0;  // an advance ratio
  const std::size_t at = key.rfind('_');
  if (at == std::string::npos) return 0.0;
  const auto found = kPowers.find(key.substr(at));
  return found == kPowers.end() ? 0.0 : found->second;
}

void scale_lengths(Json& json, double by) {
  if (json.is_array()) {
    for (Json& item : json) scale_lengths(item, by);
    return;
  }
  if (!json.is_object()) return;
  for (auto& item : json.items()) {
    if (item.value().is_number() && item.key() != "scale") {
      if (const double power = power_of(item.key()); power != 0.0)
        item.value() = item.value().get<double>() * std::pow(by, power);
    } else if (item.key() != "effects" && item.key() != "residual_network" && item.key() != "uncertainty") {
      scale_lengths(item.value(), by);
    }
  }
}

// Friction of a hull at its size.
struct Friction {
  double C_F, form_factor, roughness, S_by_Ld;
  double total() const { return form_factor * C_F + roughness; }
};

Friction friction_of(const Ship& ship, bool is_rough) {
  HullParticulars particulars;
  const Particulars& p = ship.particulars;
  particulars.L_pp = p.L_pp;
  particulars.B = p.B;
  particulars.d = particulars.d_aft = particulars.d_fore = p.d;
  particulars.C_b = ship.block_coefficient();
  particulars.x_G = ship.inertia.x_G * p.L_pp;
  particulars.scale = is_rough ? 1.0 : 10.0;
  const CompleteHull hull = fill(particulars);
  const double Re = ship.u0_mps * p.L_pp / hull.water.nu;
  const double roughness = is_rough ? roughness_allowance(p.L_pp, Re) : 0.0;
  return {ittc_57(Re), holtrop_form_factor(hull.holtrop), roughness, hull.holtrop.wetted_surface / (p.L_pp * p.d)};
}

class Scaling {
 public:
  Scaling(const Json& json, const Ship& ship, double length_m)
      : json_(json), from_(ship), by_(length_m / ship.particulars.L_pp) {}

  ScaledShip run() {
    if (!(from_.u0_mps > 0.0))
      throw InputError(from_.file, 0, "/u0_mps", "expected a speed > 0 to scale the friction at");
    froude();
    to_ = parse_ship(json_, from_.file);
    if (std::abs(by_ - 1.0) > kSame) {
      before_ = friction_of(from_, from_.scale <= kLargestShip);
      after_ = friction_of(to_, to_.scale <= kLargestShip);
      resistance();
      wake();
      doubt("rudder.epsilon", 0.05, "the wakes of propeller and rudder shrink nearly alike");
      for (const char* name : {"hull.Y_v", "hull.N_v", "hull.N_r"})
        doubt(name, 0.03, "scale effect of the derivatives, mostly of friction's share");
    }
    state_uncertainty();
    describe();
    const Ship scaled = revolutions();
    return {json_, scaled, corrections_};
  }

 private:
  static constexpr double kLargestShip =
      1.5;  // by the full-scale ship: up to here it is a ship, with roughness and sea water

  void froude() {
    scale_lengths(json_, by_);
    json_["name"] = fmt::format("{}-{:g}m", from_.name, from_.particulars.L_pp * by_);
    const double scale = from_.scale / by_;
    json_["scale"] = std::abs(scale - 1.0) < 0.05 ? 1.0 : scale;
    if (const double new_scale = json_["scale"]; (new_scale <= kLargestShip) != (from_.scale <= kLargestShip))
      json_["particulars"]["rho_kgpm3"] = new_scale <= kLargestShip ? 1025.0 : 1000.0;
  }

  void resistance() {
    Json& hull = json_["hull"];
    const std::string key = hull.contains("R_0") ? "R_0" : "X_0F";
    const double sign = key == "R_0" ? 1.0 : -1.0, R_0 = sign * hull[key].get<double>();
    // R_0 of 0.5 rho L d U^2; the friction of 0.5 rho S U^2.
    const double scaled = R_0 - before_.S_by_Ld * before_.total() + after_.S_by_Ld * after_.total();
    if (!(scaled > 0.0))
      throw InputError(from_.file, 0, "/hull/" + key,
                       fmt::format("of {:g} is less than the friction of this hull, {:.4g}", R_0,
                                   before_.S_by_Ld * before_.total()));
    hull[key] = sign * scaled;
    if (hull.contains("X_0A")) hull["X_0A"] = hull["X_0A"].get<double>() * scaled / R_0;
    // A form factor that is 0.1 off, and half the roughness.
    const double C = after_.S_by_Ld;
    const double sd =
        C * std::hypot(0.1 * (before_.C_F - after_.C_F), 0.5 * (after_.roughness + before_.roughness)) / scaled;
    corrections_.push_back(
        {"hull.resistance", R_0, scaled, sd,
         fmt::format(
             "ITTC 1957 line, C_F {:.3g} to {:.3g} by 1000, form factor {:.3f}, roughness {:.3g} to {:.3g} by 1000; "
             "the rest stays",
             1000.0 * before_.C_F, 1000.0 * after_.C_F, after_.form_factor, 1000.0 * before_.roughness,
             1000.0 * after_.roughness)});
  }

  void wake() {
    if (!json_.contains("propeller")) return;
    Json& p = json_["propeller"];
    double t_P = 0.0, w = 0.0;
    if (p.contains("w_P0")) {
      t_P = p["t_P"];
      w = p["w_P0"];
    } else if (p.contains("w_P")) {
      t_P = p["t_P"];
      w = p["w_P"][0];
    } else {
      return doubt("propeller.1-w_P", 0.10, "a wake over the advance ratio, which ITTC 1978 does not scale");
    }
    const double rudder = t_P + 0.04;  // the potential part, and the rudder's
    const double scaled = rudder + (w - rudder) * after_.total() / before_.total();
    const double most = std::clamp(scaled, 0.0, 0.9);
    if (p.contains("w_P0"))
      p["w_P0"] = most;
    else
      p["w_P"][0] = most;
    corrections_.push_back({"propeller.1-w_P", 1.0 - w, 1.0 - most,
                            0.3 * std::abs(std::log((1.0 - most) / (1.0 - w))) + 0.01,
                            fmt::format("ITTC 1978: t + 0.04 stays, the rest of w by the friction's ratio {:.3f}",
                                        after_.total() / before_.total())});
  }

  // A coefficient that keeps its value and is known less well.
  void doubt(const char* name, double added, const char* why) {
    const CoefficientLaw law = coefficient_law(from_);
    const auto found = std::ranges::find_if(law.coefficients, [&](const auto& c) { return c.name == name; });
    if (found == law.coefficients.end() || found->is_absolute) return;
    const double value = found->value.value_or(1.0);
    corrections_.push_back({name, value, value, added, why});
  }

  void state_uncertainty() {
    const CoefficientLaw law = coefficient_law(from_);
    for (const ScaleCorrection& c : corrections_) {
      const auto i = static_cast<Eigen::Index>(
          std::ranges::find_if(law.coefficients, [&](const auto& l) { return l.name == c.name; }) -
          law.coefficients.begin());
      if (i == static_cast<Eigen::Index>(law.coefficients.size())) continue;
      json_["uncertainty"][c.name] = std::hypot(std::sqrt(law.covariance(i, i)), c.added_log_sd);
    }
    if (!json_.contains("coefficient_covariance")) return;
    // Of names that a correction makes less certain the joint statement is widened along with them.
    Json& joint = json_["coefficient_covariance"];
    for (std::size_t k = 0; k < joint["names"].size(); ++k)
      for (const ScaleCorrection& c : corrections_)
        if (joint["names"][k] == c.name)
          joint["matrix"][k][k] = joint["matrix"][k][k].get<double>() + c.added_log_sd * c.added_log_sd;
  }

  void describe() {
    Json list = Json::array();
    for (const ScaleCorrection& c : corrections_)
      list.push_back({{"coefficient", c.name},
                      {"before", c.before},
                      {"after", c.after},
                      {"added_log_sd", c.added_log_sd},
                      {"source", c.why}});
    json_["scaling"] = {
        {"source", fmt::format("mmg-sim scale: '{}' of {:g} m by {:.6g}, Froude's law; ITTC 1957 and 1978", from_.name,
                               from_.particulars.L_pp, by_)},
        {"corrections", list}};
    json_["description"] = fmt::format("{} (scaled from {:g} m)", from_.description, from_.particulars.L_pp);
  }

  // Self-propulsion at the new size, in place of the old one's revolutions.
  Ship revolutions() {
    Ship ship = parse_ship(json_, from_.file);
    if (!ship.has_propeller()) return ship;
    for (Json& actuator : json_["actuators"]) {
      if (actuator["channel"] != "n_p") continue;
      const double n = self_propulsion_n(ship, ship.u0_mps), was = actuator["initial_rps"];
      const double old = self_propulsion_n(from_, from_.u0_mps) / std::sqrt(by_);
      if (std::abs(was - old) < 0.02 * old) actuator["initial_rps"] = n;
    }
    return parse_ship(json_, from_.file);
  }

  Json json_;
  const Ship& from_;
  double by_;
  Ship to_;
  Friction before_{}, after_{};
  std::vector<ScaleCorrection> corrections_;
};

}  // namespace

ScaledShip scale_ship(const io::Json& json, const Ship& ship, double length_m) {
  return Scaling(json, ship, length_m).run();
}

}  // namespace leeway::estimate
