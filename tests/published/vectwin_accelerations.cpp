#include <array>
#include <filesystem>
#include <vector>

#include <catch2/catch.hpp>

#include "core/units.hpp"
#include "dynamics/model.hpp"
#include "forces/registry.hpp"
#include "io/csv.hpp"

using namespace leeway;

TEST_CASE("vectwin-3m: accelerations agree with an independent code", "[published]") {
  const std::string path = LEEWAY_SHARED_FOLDER "/reference/vectwin-3m-accelerations.csv";
  if (!std::filesystem::exists(path)) {
    WARN("SKIPPED: no " << path);
    return;
  }
  Ship ship = read_ship("vectwin-3m");
  std::get<FujiwaraWindGeometry>(*ship.modules->wind).rho_air = 1.220;  // of the reference
  const Model<double> model(ship);
  io::CsvReader csv(path);
  std::vector<std::string_view> fields;
  Vec3<double> sum = Vec3<double>::Zero(), largest = Vec3<double>::Zero();
  int rows = 0;
  for (; csv.next(fields); ++rows) {
    const auto value = [&](const char* name) { return csv.number(fields[csv.column(name)], name, ""); };
    const Vec3<double> nu(value("u_mps"), value("vm_mps"), value("r_radps"));
    Actuators<double> actuators;
    actuators[Channel::delta_p] = value("delta_p_rad");
    actuators[Channel::delta_s] = value("delta_s_rad");
    actuators[Channel::n_p] = value("n_p_rps");
    actuators[Channel::n_bt] = value("n_bt_rps");
    const Vec2<double> wind = apparent_wind<double>(wind_from_vector(value("wind_speed_mps"), value("wind_dir_rad")),
                                                    value("psi_rad"), nu(0), nu(1));
    const Vec3<double> reference(value("udot_mps2"), value("vmdot_mps2"), value("rdot_radps2"));
    const Vec3<double> difference = model.acceleration(nu, actuators, wind) - reference;
    sum += reference.cwiseAbs2();
    largest = largest.cwiseMax(difference.cwiseAbs());
  }
  REQUIRE(rows == 300);
  // The reference integrates the cross flow over 200 strips; exact integrals differ by up to 6e-5 of the rms.
  const Vec3<double> share = largest.cwiseQuotient((sum / rows).cwiseSqrt());
  for (int i = 0; i < 3; ++i) CHECK(share(i) < 1e-4);
}
