#include "estimate/hull_particulars.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/errors.hpp"
#include "core/units.hpp"
#include "io/files.hpp"

namespace leeway::estimate {
namespace {

using io::JsonObject;
using io::kPositive;

// What a hull can be: beyond these no displacement ship is. The drafts leave out feet for meters.
constexpr io::Bounds kLength_m{0.3, 600.0}, kScale{0.1, 500.0}, kBlock{0.25, 0.98}, kPitch{0.3, 2.0}, kArea{0.2, 1.3},
    kBlades{2.0, 7.0};
constexpr double kLeastLengthByBreadth = 2.0, kMostLengthByBreadth = 15.0;
constexpr double kLeastBreadthByDraft = 1.3, kMostBreadthByDraft = 15.0;
constexpr double kMostRudderShare = 0.15;  // of L d
// What is missing where none of several keys is there.
constexpr const char *kDraft = "d_m (or d_fore_m and d_aft_m)", *kBlockKeys = "C_b (or displacement_t)";
// All keys, so that of a file with missing ones the unknown are told and no others.
constexpr const char* kKeys[] = {"name",
                                 "description",
                                 "source",
                                 "scale",
                                 "L_pp_m",
                                 "B_m",
                                 "d_m",
                                 "d_fore_m",
                                 "d_aft_m",
                                 "C_b",
                                 "displacement_t",
                                 "x_G_m",
                                 "wetted_surface_m2",
                                 "service_speed_mps",
                                 "service_speed_kn",
                                 "propeller",
                                 "rudder",
                                 "bow_thruster",
                                 "stern_thruster",
                                 "azimuth_thrusters",
                                 "superstructure"};

std::optional<double> number_if(const JsonObject& json, const std::string& key, io::Bounds bounds = {}) {
  if (!json.has(key)) return std::nullopt;
  return json.number(key, bounds);
}

void refuse(const JsonObject& json, const std::string& key, const std::string& what) {
  if (json.has(key))
    json.fail(key, what +
                       " not supported: one propeller with a rudder or VecTwin rudders, or "
                       "azimuth thrusters (key 'azimuth_thrusters')");
}

// A number that another one bounds, with the unit in the message.
void check_within(const JsonObject& json, const std::string& key, double value, double low, double high,
                  const std::string& why) {
  if (value >= low && value <= high) return;
  json.fail(key, fmt::format("expected {:.4g} to {:.4g}, {}, got {:g}", low, high, why, value));
}

void read_draft(const JsonObject& json, HullParticulars& hull) {
  const bool has_ends = json.has("d_fore_m") || json.has("d_aft_m");
  if (json.has("d_m") || !has_ends) {
    for (const char* key : {"d_fore_m", "d_aft_m"})
      if (json.has(key)) json.fail(key, "stands beside d_m: give d_m, or d_fore_m and d_aft_m");
    hull.d = hull.d_fore = hull.d_aft = json.number(json.has("d_m") ? "d_m" : kDraft, kPositive);
  } else {
    hull.d_fore = json.number("d_fore_m", kPositive);
    hull.d_aft = json.number("d_aft_m", kPositive);
    hull.d = 0.5 * (hull.d_fore + hull.d_aft);
  }
}

void read_block(const JsonObject& json, HullParticulars& hull) {
  if (json.has("displacement_t") && !json.has("C_b")) {
    const double mass = 1000.0 * json.number("displacement_t", kPositive);
    hull.C_b = mass / (water_of(hull).rho * hull.L_pp * hull.B * hull.d);
    if (!(hull.C_b >= kBlock.low && hull.C_b <= kBlock.high))
      json.fail("displacement_t",
                fmt::format("is a C_b of {:.3g} with these dimensions, expected {:g} to {:g}: mass in "
                            "t, lengths in m",
                            hull.C_b, kBlock.low, kBlock.high));
    return;
  }
  hull.C_b = json.number(json.has("C_b") ? "C_b" : kBlockKeys, kBlock);
  if (json.has("displacement_t")) json.fail("displacement_t", "stands beside C_b: give one of them");
}

PropellerParticulars read_propeller(const JsonObject& json, const HullParticulars& hull) {
  for (const char* key : {"count", "number", "propellers"}) refuse(json, key, "several propellers are");
  for (const char* key : {"pod", "pods", "type"}) refuse(json, key, "pods and other propellers than a fixed screw are");
  PropellerParticulars p;
  p.diameter = number_if(json, "diameter_m", kPositive);
  if (p.diameter && *p.diameter > hull.d_aft)
    json.fail("diameter_m", fmt::format("expected at most the draft aft, {:g} m, got {:g}", hull.d_aft, *p.diameter));
  p.pitch_ratio = number_if(json, "pitch_ratio", kPitch);
  p.blades = number_if(json, "blades", kBlades);
  if (p.blades && *p.blades != std::round(*p.blades)) json.fail("blades", "expected a whole number");
  p.area_ratio = number_if(json, "area_ratio", kArea);
  p.n_service = number_if(json, "rps_at_service_speed", kPositive);
  if (p.n_service && *p.n_service > 30.0 * std::sqrt(hull.scale))
    json.fail("rps_at_service_speed",
              fmt::format("expected revolutions per second, got {:g} (are they per minute?)", *p.n_service));
  p.x = number_if(json, "x_m", {-0.6 * hull.L_pp, 0.0});
  json.check_all_known();
  return p;
}

RudderParticulars read_rudder(const JsonObject& json, const HullParticulars& hull) {
  refuse(json, "count", "several rudders but VecTwin are");
  RudderParticulars r;
  r.area = number_if(json, "area_m2", kPositive);
  if (r.area)
    check_within(json, "area_m2", *r.area, 0.0, kMostRudderShare * hull.L_pp * hull.d, "15 % of L_pp d [m^2]");
  r.height = number_if(json, "height_m", kPositive);
  if (r.height) check_within(json, "height_m", *r.height, 0.0, 1.5 * hull.d_aft, "1.5 times the draft aft [m]");
  r.x = number_if(json, "x_m", {-0.6 * hull.L_pp, 0.0});
  const double degree = kDegree;
  if (const auto angle = number_if(json, "max_angle_deg", {5.0, 105.0})) r.max_angle = *angle * degree;
  if (const auto rate = number_if(json, "rate_degps", {0.1, 200.0})) r.rate = *rate * degree;
  r.is_vectwin = json.has("type") && json.word("type", {"single", "vectwin"}) == "vectwin";
  if (r.is_vectwin && r.max_angle)
    json.fail("max_angle_deg", "is not taken with VecTwin rudders, which turn 105 deg outward and 35 deg inward");
  json.check_all_known();
  return r;
}

ThrusterParticulars read_thruster(const JsonObject& json, const HullParticulars& hull, bool turns) {
  const io::Bounds along{-0.6 * hull.L_pp, 0.6 * hull.L_pp};
  ThrusterParticulars t;
  t.x = json.number("x_m", along);
  if (turns) t.y = json.number("y_m", {-hull.B, hull.B});
  t.diameter = json.number("diameter_m", {0.0, hull.d, true});
  t.max_thrust = json.number("max_thrust_N", kPositive);
  t.max_n = json.number("max_rps", kPositive);
  json.check_all_known();
  return t;
}

SuperstructureParticulars read_superstructure(const JsonObject& json, const HullParticulars& hull) {
  SuperstructureParticulars s;
  s.frontal_area = number_if(json, "frontal_area_m2", {0.0, 10.0 * hull.B * hull.B, true});
  s.lateral_area = number_if(json, "lateral_area_m2", {0.0, hull.L_pp * hull.L_pp, true});
  s.lateral_centroid_x = number_if(json, "lateral_centroid_x_m", {-0.5 * hull.L_pp, 0.5 * hull.L_pp});
  s.height = number_if(json, "height_m", {0.0, hull.L_pp, true});
  json.check_all_known();
  return s;
}

void read_propulsion(const JsonObject& json, HullParticulars& hull) {
  for (const char* key : {"propellers", "pods", "pod"}) refuse(json, key, "several propellers and pods are");
  refuse(json, "rudders", "several rudders but VecTwin are");
  for (const char* key : {"propeller", "rudder"})
    if (json.has(key) && json.value(key).is_array()) refuse(json, key, "several propellers and rudders are");
  if (const auto propeller = json.object_if("propeller")) hull.propeller = read_propeller(*propeller, hull);
  if (const auto rudder = json.object_if("rudder")) hull.rudder = read_rudder(*rudder, hull);
  if (const auto t = json.object_if("bow_thruster")) hull.bow_thruster = read_thruster(*t, hull, false);
  if (const auto t = json.object_if("stern_thruster")) hull.stern_thruster = read_thruster(*t, hull, false);
  if (!json.has("azimuth_thrusters")) return;
  for (const JsonObject& t : json.objects("azimuth_thrusters"))
    hull.azimuth_thrusters.push_back(read_thruster(t, hull, true));
  if (hull.azimuth_thrusters.empty() || hull.azimuth_thrusters.size() > 2)
    json.fail("azimuth_thrusters", fmt::format("expected one or two, got {}", hull.azimuth_thrusters.size()));
}

HullParticulars read_whole(const JsonObject& json) {
  HullParticulars hull;
  for (const char* key : kKeys) json.has(key);
  hull.file = json.file();
  hull.name = json.text("name");
  json.text_or("description", "");
  json.text_or("source", "");
  hull.has_scale = json.has("scale");
  hull.scale = json.number_or("scale", 1.0, kScale);
  hull.L_pp = json.number("L_pp_m", kLength_m);
  hull.B = json.number("B_m", kPositive);
  read_draft(json, hull);
  read_block(json, hull);
  json.require_complete();
  check_within(json, "B_m", hull.B, hull.L_pp / kMostLengthByBreadth, hull.L_pp / kLeastLengthByBreadth,
               fmt::format("[m] for a length of {:g} m", hull.L_pp));
  check_within(json, json.has("d_m") ? "d_m" : "d_aft_m", hull.d, hull.B / kMostBreadthByDraft,
               hull.B / kLeastBreadthByDraft, fmt::format("[m] for a breadth of {:g} m (is it in feet?)", hull.B));
  hull.x_G = number_if(json, "x_G_m", {-0.15 * hull.L_pp, 0.15 * hull.L_pp});
  const double wetted = hull.L_pp * (2.0 * hull.d + hull.B);
  hull.wetted_surface = number_if(json, "wetted_surface_m2", {0.4 * wetted, 1.3 * wetted});
  hull.service_speed = number_if(json, "service_speed_mps", kPositive);
  if (const auto speed = number_if(json, "service_speed_kn", kPositive)) {
    if (hull.service_speed) json.fail("service_speed_kn", "stands beside service_speed_mps: give one of them");
    hull.service_speed = *speed * kKnot;
  }
  if (hull.service_speed) {
    const bool is_in_kn = json.has("service_speed_kn");
    const double unit = is_in_kn ? kKnot : 1.0, most = 0.6 * std::sqrt(kGravity_mps2 * hull.L_pp);
    check_within(json, is_in_kn ? "service_speed_kn" : "service_speed_mps", *hull.service_speed / unit, 0.0,
                 most / unit, fmt::format("a Froude number of 0.6 [{}]", is_in_kn ? "kn" : "m/s"));
  }
  read_propulsion(json, hull);
  if (const auto s = json.object_if("superstructure")) hull.superstructure = read_superstructure(*s, hull);
  json.check_all_known();
  return hull;
}

}  // namespace

Water water_of(const HullParticulars& hull) {
  if (hull.is_model()) return {999.1, 1.1386e-6};
  return {1026.0, 1.1892e-6};
}

HullParticulars read_particulars(JsonObject& json) {
  json.note_missing();
  HullParticulars hull;
  try {
    hull = read_whole(json);
  } catch (const InputError&) {
    json.require_complete();
    throw;
  }
  json.require_complete();
  return hull;
}

HullParticulars read_particulars(const std::string& name_or_path) {
  const std::string path = io::find_config("particulars", name_or_path);
  const io::Json text = io::read_json(path);
  JsonObject json(text, path);
  return read_particulars(json);
}

}  // namespace leeway::estimate
