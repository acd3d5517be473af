#include "estimate/hull_particulars.hpp"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "core/errors.hpp"
#include "core/units.hpp"
#include "estimate/statistics.hpp"
#include "io/files.hpp"
#include "temporary_folder.hpp"

using namespace leeway;
using namespace leeway::estimate;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

io::Json tanker() { return {{"name", "t"}, {"L_pp_m", 320.0}, {"B_m", 58.0}, {"d_m", 20.8}, {"C_b", 0.81}}; }

HullParticulars particulars_with(const io::Json& more) {
  io::Json json = tanker();
  json.update(more);
  io::JsonObject object(json, "t.json");
  return read_particulars(object);
}

}  // namespace

TEST_CASE("particulars: what is missing is said all at once", "[estimate][particulars]") {
  const io::Json none{{"name", "t"}, {"B_m", 58.0}};
  io::JsonObject object(none, "t.json");
  CHECK_THROWS_WITH(read_particulars(object), Contains("/L_pp_m") && Contains("/d_m (or d_fore_m and d_aft_m)") &&
                                                  Contains("/C_b (or displacement_t)"));
}

TEST_CASE("particulars: beside what is missing the unknown keys are told, and which one is meant",
          "[estimate][particulars]") {
  const io::Json slip{{"name", "t"}, {"B_m", 58.0}, {"d_m", 20.8}, {"C_b", 0.81}, {"Lpp_m", 320.0}, {"rubbish", 1}};
  io::JsonObject object(slip, "t.json");
  CHECK_THROWS_WITH(read_particulars(object), Contains("/L_pp_m: missing") &&
                                                  Contains("not yet read here: Lpp_m, rubbish") &&
                                                  Contains("is 'Lpp_m' meant?") && !Contains("is 'rubbish' meant"));
  CHECK_THROWS_WITH(particulars_with({{"Propeller", {{"diameter_m", 9.0}}}}), Contains("did you mean 'propeller'"));
  CHECK_THROWS_WITH(particulars_with({{"rudder", {{"area", 90.0}}}}), Contains("did you mean 'area_m2'?"));
}

TEST_CASE("particulars: a draft or speed given twice, a speed in kn, an angle of VecTwin rudders",
          "[estimate][particulars]") {
  CHECK_THROWS_WITH(particulars_with({{"d_fore_m", 20.0}}), Contains("/d_fore_m: stands beside d_m"));
  CHECK_THROWS_WITH(particulars_with({{"service_speed_kn", 70.0}}),
                    Contains("expected 0 to 65.3") && Contains("[kn], got 70"));
  CHECK_THROWS_WITH(particulars_with({{"rudder", {{"type", "vectwin"}, {"max_angle_deg", 70.0}}}}),
                    Contains("/rudder/max_angle_deg") && Contains("105 deg outward"));
}

TEST_CASE("particulars: what statistics give is limited to what makes sense, and that is said",
          "[estimate][particulars]") {
  CHECK(fill(particulars_with(io::Json::object())).warnings.empty());
  const CompleteHull light = fill(particulars_with({{"d_m", 6.0}, {"C_b", 0.9}}));
  std::string all;
  for (const std::string& warning : light.warnings) all += warning + "\n";
  CHECK_THAT(all, Contains("/propeller/pitch_ratio is 0.61") && Contains("limited to 0.65 to 1.1"));
  CHECK_THAT(all, Contains("/service_speed_mps") && Contains("Alexander") && Contains("limited to"));
}

TEST_CASE("particulars: errors name key, range and unit", "[estimate][particulars]") {
  CHECK_THROWS_WITH(particulars_with({{"C_b", 8.1}}), Contains("/C_b") && Contains("0.25 to 0.98") && Contains("8.1"));
  CHECK_THROWS_WITH(particulars_with({{"d_m", 68.2}}), Contains("/d_m") && Contains("[m]") && Contains("feet"));
  CHECK_THROWS_WITH(particulars_with({{"propeller", {{"diameter_m", 25.0}}}}),
                    Contains("/propeller/diameter_m") && Contains("20.8 m") && Contains("25"));
  CHECK_THROWS_WITH(particulars_with({{"propeller", {{"diametre_m", 9.0}}}}), Contains("unknown key"));
  CHECK_THROWS_WITH(particulars_with({{"speed", 9.0}}), Contains("/speed") && Contains("unknown key"));
  CHECK_THROWS_WITH(particulars_with({{"service_speed_kn", 80.0}}), Contains("/service_speed_kn") && Contains("[kn]"));
  CHECK_THROWS_WITH(particulars_with({{"propeller", {{"rps_at_service_speed", 91.5}}}}), Contains("per minute"));
}

TEST_CASE("particulars: several propellers and pods are said to be unsupported", "[estimate][particulars]") {
  CHECK_THROWS_WITH(particulars_with({{"propellers", io::Json::array()}}), Contains("not supported"));
  CHECK_THROWS_WITH(particulars_with({{"propeller", io::Json::array({{{"diameter_m", 5.0}}})}}),
                    Contains("not supported"));
  CHECK_THROWS_WITH(particulars_with({{"propeller", {{"count", 2}}}}), Contains("not supported"));
  CHECK_THROWS_WITH(particulars_with({{"pods", 2}}), Contains("not supported") && Contains("azimuth_thrusters"));
}

TEST_CASE("particulars: a displacement is a block coefficient, drafts have a mean", "[estimate][particulars]") {
  io::Json json = tanker();
  json.erase("C_b");
  json.erase("d_m");
  json.update({{"displacement_t", 312600.0 * 1.026}, {"d_fore_m", 20.3}, {"d_aft_m", 21.3}});
  io::JsonObject object(json, "t.json");
  const HullParticulars hull = read_particulars(object);
  CHECK_THAT(hull.d, WithinAbs(20.8, 1e-12));
  CHECK_THAT(hull.C_b, WithinRel(312600.0 / (320.0 * 58.0 * 20.8), 1e-9));
}

TEST_CASE("particulars: statistics fill what is missing and each is named", "[estimate][particulars]") {
  const CompleteHull hull = fill(particulars_with(io::Json::object()));
  CHECK(hull.assumptions.size() >= 15);
  for (const Assumption& a : hull.assumptions) CHECK(a.source.size() > 10);
  // What KVLCC2 has in truth, within what statistics of ships can do.
  CHECK_THAT(hull.D_P, WithinRel(9.86, 0.15));
  CHECK_THAT(hull.A_R, WithinRel(112.5, 0.15));
  CHECK_THAT(hull.x_G, WithinRel(11.2, 0.4));
  CHECK_THAT(hull.service_speed, WithinRel(15.5 * kKnot, 0.25));
  CHECK_THAT(hull.holtrop.wetted_surface, WithinRel(27194.0, 0.05));  // SIMMAN, hull without rudder
}
