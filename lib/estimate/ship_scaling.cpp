#include "estimate/ship_scaling.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/errors.hpp"
#include "core/units.hpp"
#include "dynamics/coefficient_law.hpp"
#include "dynamics/straight_run.hpp"
#include "estimate/holtrop.hpp"
#include "estimate/statistics.hpp"
#include "recording/froude_units.hpp"

namespace leeway::estimate {
namespace {

using io::Json;

constexpr double kSame = 1e-9;  // of two lengths by each other: nothing to scale

void scale_numbers(Json& json, double length_ratio, double density_ratio) {
  if (json.is_array()) {
    for (Json& item : json) scale_numbers(item, length_ratio, density_ratio);
    return;
  }
  if (!json.is_object()) return;
  for (auto& item : json.items()) {
    if (!item.value().is_number()) {
      scale_numbers(item.value(), length_ratio, density_ratio);
    } else if (const double by = froude_factor(item.key(), length_ratio, density_ratio); by != 1.0) {
      item.value() = item.value().get<double>() * by;
    }
  }
}

// A ship's file: not what it says of coefficients, which have no unit.
void scale_ship_file(Json& ship, double length_ratio, double density_ratio) {
  for (auto& item : ship.items()) {
    const std::string& key = item.key();
    if (key == "uncertainty" || key == "scaling" || key == "provenance" || key.starts_with("coefficient_")) continue;
    if (item.value().is_number()) {
      item.value() = item.value().get<double>() * froude_factor(key, length_ratio, density_ratio);
    } else {
      scale_numbers(item.value(), length_ratio, density_ratio);
    }
  }
}

// One value that a scaling replaced, by what it was, or nothing. Where somebody has changed it since, a correction is
// taken off what it is now, and other things stay.
void put_back(Json& ship, const Json& entry) {
  const Json::json_pointer at(entry.at("pointer").get<std::string>());
  const Json &before = entry.at("before"), &after = entry.at("after");
  if (!ship.contains(at)) return;
  Json& value = ship.at(at);
  const std::string pointer = at.to_string();
  if (value == after) {
    if (before.is_null())
      ship.at(at.parent_pointer()).erase(at.back());
    else
      value = before;
  } else if (pointer.starts_with("/hull/")) {
    value = value.get<double>() * before.get<double>() / after.get<double>();
  } else if (pointer.starts_with("/propeller/")) {
    value = 1.0 - (1.0 - value.get<double>()) * (1.0 - before.get<double>()) / (1.0 - after.get<double>());
  }
}

// The ship as it was before a scaling that its file tells of.
Json put_back(Json ship, const std::string& file) {
  if (!ship.contains("scaling")) return ship;
  const Json scaling = ship["scaling"];
  if (!scaling.is_object() || !scaling.contains("replaced")) return ship;
  ship.erase("scaling");
  try {
    const double rho = ship.at("particulars").at("rho_kgpm3");
    for (auto entry = scaling.at("replaced").rbegin(); entry != scaling.at("replaced").rend(); ++entry)
      put_back(ship, *entry);
    for (const char* key : {"uncertainty", "coefficient_factors"})
      if (ship.contains(key) && ship.at(key).empty()) ship.erase(key);
    const double L = scaling.at("from_L_pp_m"), now = ship.at("particulars").at("L_pp_m");
    if (!(L > 0.0 && now > 0.0)) throw InputError(file, 0, "/scaling/from_L_pp_m", "expected a length > 0");
    scale_ship_file(ship, L / now, ship.at("particulars").at("rho_kgpm3").get<double>() / rho);
  } catch (const Json::exception&) {
    throw InputError(file, 0, "/scaling", "is not what mmg-sim scale writes: take it out of the file");
  }
  return ship;
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
  Scaling(const Json& json, const Ship& ship, double length_m) : json_(put_back(json, ship.file)), file_(ship.file) {
    from_ = without_effects(json_);
    by_ = length_m / from_.particulars.L_pp;
  }

  ScaledShip run() {
    if (!(from_.u0_mps > 0.0)) throw InputError(file_, 0, "/u0_mps", "expected a speed > 0 to scale the friction at");
    if (std::abs(by_ - 1.0) <= kSame) return {json_, parse_ship(json_, file_), {}, {}};
    if (from_.scale <= kLargestShipScale && from_.particulars.L_pp < kUsualShipLength_m)
      warnings_.push_back(
          fmt::format("a hull of {:g} m with scale {:g} is taken for a ship, rough and in sea water: for a model state "
                      "`scale`, the "
                      "length of its ship by its own",
                      from_.particulars.L_pp, from_.scale));
    froude();
    to_ = without_effects(json_);
    before_ = friction_of(from_, from_.scale <= kLargestShipScale);
    after_ = friction_of(to_, to_.scale <= kLargestShipScale);
    resistance();
    wake();
    doubt("rudder.epsilon", 0.05, "the wakes of propeller and rudder shrink nearly alike");
    for (const char* name : {"hull.Y_v", "hull.N_v", "hull.N_r"})
      doubt(name, 0.03, "scale effect of the derivatives, mostly of friction's share");
    state_uncertainty();
    revolutions();
    describe();
    return {json_, parse_ship(json_, file_), corrections_, warnings_};
  }

 private:
  // Effects are no part of the ship that is scaled: neither its coefficients nor its revolutions are with them.
  Ship without_effects(const Json& json) const {
    Ship ship = parse_ship(json, file_);
    ship.effects.clear();
    ship.residual_network = nullptr;
    return ship;
  }

  // Sets a value and remembers what stood there.
  void replace(const std::string& pointer, const Json& value) {
    const Json::json_pointer at(pointer);
    const Json before = json_.contains(at) ? json_.at(at) : Json(nullptr);
    if (before == value) return;
    json_[at] = value;
    replaced_.push_back({{"pointer", pointer}, {"before", before}, {"after", value}});
  }

  void froude() {
    HullParticulars water;
    water.scale = from_.scale / by_;
    if (std::abs(water.scale - 1.0) < 0.05) water.scale = 1.0;
    const double rho = from_.particulars.rho;
    const bool is_other_water = (water.scale <= kLargestShipScale) != (from_.scale <= kLargestShipScale);
    const double new_rho = is_other_water ? water_of(water).rho : rho;
    if (json_.contains("residual_network")) {
      warnings_.push_back(
          fmt::format("residual_network is learned from recordings of {:g} m, at its speeds: it is dropped",
                      from_.particulars.L_pp));
      json_.erase("residual_network");
    }
    scale_ship_file(json_, by_, new_rho / rho);
    replace("/name", fmt::format("{}-{:g}m", from_.name, from_.particulars.L_pp * by_));
    replace("/description", fmt::format("{} (scaled from {:g} m)", from_.description, from_.particulars.L_pp));
    replace("/scale", water.scale);
    replace("/particulars/rho_kgpm3", new_rho);
    if (is_other_water)
      corrections_.push_back({"particulars.rho_kgpm3", rho, new_rho, 0.0,
                              water.is_model() ? "a model is in fresh water of 15 deg C (ITTC 7.5-02-01-03)"
                                               : "a ship is in sea water of 15 deg C (ITTC 7.5-02-01-03)"});
  }

  double factor(const std::string& name) const {
    for (const CoefficientFactor& by : from_.coefficient_factors)
      if (by.name == name) return by.factor;
    return 1.0;
  }

  void resistance() {
    const Json& hull = json_["hull"];
    const std::string key = hull.contains("R_0") ? "R_0" : "X_0F";
    const double sign = key == "R_0" ? 1.0 : -1.0;
    const double R_0 = sign * hull[key].get<double>() * factor("hull.resistance");
    // R_0 of 0.5 rho L d U^2; the friction of 0.5 rho S U^2.
    const double scaled = R_0 - before_.S_by_Ld * before_.total() + after_.S_by_Ld * after_.total();
    if (!(scaled > 0.0))
      throw InputError(file_, 0, "/hull/" + key,
                       fmt::format("of {:g} with its factor is less than the friction of this hull, {:.4g}", R_0,
                                   before_.S_by_Ld * before_.total()));
    for (const std::string& one : {key, std::string("X_0A")})
      if (hull.contains(one)) replace("/hull/" + one, hull[one].get<double>() * scaled / R_0);
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
    constexpr const char *kWake = "propeller.1-w_P", *kFactor = "/coefficient_factors/propeller.1-w_P";
    if (!json_.contains("propeller")) return;
    const Json& p = json_["propeller"];
    if (!p.contains("w_P0") && !p.contains("w_P"))
      return doubt(kWake, 0.10, "a wake over the advance ratio, which ITTC 1978 does not scale");
    const std::string pointer = p.contains("w_P0") ? "/propeller/w_P0" : "/propeller/w_P/0";
    const double own = json_.at(Json::json_pointer(pointer)), by = factor(kWake), w = 1.0 - by * (1.0 - own);
    const double t_P = 1.0 - factor("propeller.1-t_P") * (1.0 - p["t_P"].get<double>());
    const double potential = t_P + 0.04;  // with the rudder's
    const double scaled = potential + (w - potential) * after_.total() / before_.total();
    const double held = std::clamp(scaled, 0.0, 0.9);
    // A wake of the file below 0 cannot stand there: the factor takes what remains.
    const double rest = std::min(1.0, (1.0 - held) / by);
    replace(pointer, 1.0 - rest);
    if (rest == 1.0 && by != 1.0) replace(kFactor, (1.0 - held) / rest);
    corrections_.push_back({kWake, 1.0 - w, 1.0 - held, 0.3 * std::abs(std::log((1.0 - held) / (1.0 - w))) + 0.01,
                            fmt::format("ITTC 1978: t + 0.04 stays, the rest of w by the friction's ratio {:.3f}{}",
                                        after_.total() / before_.total(),
                                        held == scaled ? "" : fmt::format("; w_P limited from {:.3g}", scaled))});
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
      const auto found = std::ranges::find_if(law.coefficients, [&](const auto& l) { return l.name == c.name; });
      if (found == law.coefficients.end()) continue;
      // Of a value, where the file states that, and not of its logarithm; no variance of a joint statement shrinks.
      const double ratio = found->is_absolute ? std::max(1.0, c.after / c.before) : 1.0,
                   added = found->is_absolute ? std::abs(c.after) * c.added_log_sd : c.added_log_sd;
      const auto i = static_cast<Eigen::Index>(found - law.coefficients.begin());
      const double sd = std::hypot(std::sqrt(law.covariance(i, i)) * ratio, added);
      if (!json_.contains("uncertainty")) json_["uncertainty"] = Json::object();
      replace("/uncertainty/" + c.name, found->is_absolute ? Json{{"sd", sd}} : Json(sd));
      if (!json_.contains("coefficient_covariance")) continue;
      // The joint statement is widened along with it.
      const Json& names = json_["coefficient_covariance"]["names"];
      for (std::size_t k = 0; k < names.size(); ++k)
        if (names[k] == c.name) replace(fmt::format("/coefficient_covariance/matrix/{}/{}", k, k), sd * sd);
    }
  }

  // Self-propulsion at the new size, in place of the old one's revolutions where these are that.
  void revolutions() {
    constexpr double kIsSelfPropulsion = 1e-3;
    if (!from_.has_propeller()) return;
    const Json& actuators = json_["actuators"];
    for (std::size_t i = 0; i < actuators.size(); ++i) {
      if (actuators[i]["channel"] != "n_p") continue;
      try {
        const double was = actuators[i]["initial_rps"], old = self_propulsion_n(from_, from_.u0_mps) / std::sqrt(by_);
        if (std::abs(was - old) > kIsSelfPropulsion * old) return;
        const Ship ship = without_effects(json_);
        const double n = self_propulsion_n(ship, ship.u0_mps);
        replace(fmt::format("/actuators/{}/initial_rps", i), n);
        corrections_.push_back(
            {"n_p, initial_rps", was, n, 0.0, "self-propulsion at u0 again; before: by Froude's law"});
      } catch (const NumericalError& e) {
        warnings_.push_back(fmt::format("{}: its revolutions are scaled by Froude's law alone", e.what()));
      }
    }
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
        {"corrections", list},
        {"from_L_pp_m", from_.particulars.L_pp},
        {"replaced", replaced_}};
  }

  Json json_;
  std::string file_;
  double by_ = 1.0;
  Ship from_, to_;
  Friction before_{}, after_{};
  std::vector<ScaleCorrection> corrections_;
  std::vector<std::string> warnings_;
  Json replaced_ = Json::array();
};

}  // namespace

ScaledShip scale_ship(const io::Json& json, const Ship& ship, double length_m) {
  return Scaling(json, ship, length_m).run();
}

}  // namespace leeway::estimate
