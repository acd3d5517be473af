#include "io/prediction_csv.hpp"

#include <catch2/catch.hpp>

#include "core/errors.hpp"
#include "temporary_folder.hpp"

using namespace leeway;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinRel;

TEST_CASE("prediction: rows come back as they were written, names with commas too", "[io][prediction]") {
  const test::TemporaryFolder folder;
  const std::string name = "trial 3, \"port\"";
  {
    io::PredictionWriter writer(folder / "p.csv");
    // More than one buffer.
    for (std::size_t i = 0; i < 5000; ++i)
      writer.write(
          {name, i / 1000, i % 1000, 0.1 * static_cast<double>(i), i % 7, i % 3, {1.5, -2.25, 0.7}, {0.3, -0.1, 0.02}});
    CHECK(folder.listing() != "p.csv");
    writer.commit();
  }
  io::PredictionReader reader(folder / "p.csv");
  io::PredictionRow row;
  std::size_t i = 0;
  for (; reader.next(row); ++i) {
    REQUIRE(row.recording == name);
    REQUIRE((row.sequence == i / 1000 && row.step == i % 1000 && row.particle == i % 7 && row.member == i % 3));
    REQUIRE(row.t_s == 0.1 * static_cast<double>(i));
    REQUIRE((row.eta(0) == 1.5 && row.eta(1) == -2.25 && row.nu(0) == 0.3 && row.nu(1) == -0.1));
    REQUIRE_THAT(row.eta(2), WithinRel(0.7, 2.3e-16));
    REQUIRE_THAT(row.nu(2), WithinRel(0.02, 2.3e-16));
  }
  CHECK(i == 5000);
}

TEST_CASE("prediction: a missing column, a negative step and a missing number are refused", "[io][prediction]") {
  const test::TemporaryFolder folder;
  const std::string header = "recording,sequence,step,t_s,particle,member,x0_m,y0_m,psi_deg,u_mps,vm_mps,r_degps\n";
  const auto refused = [&](const std::string& text, const std::string& because) {
    const std::string path = folder.write("p.csv", text);
    const auto read = [&] {
      io::PredictionReader reader(path);
      io::PredictionRow row;
      while (reader.next(row)) {
      }
    };
    CHECK_THROWS_AS(read(), InputError);
    CHECK_THROWS_WITH(read(), Contains(because));
  };
  refused("recording,sequence,step\n", "no column 't_s'; found recording, sequence, step");
  refused(header + "a,0,-1,0,0,0,0,0,0,0,0,0\n", "p.csv:2: column 'step': expected a whole number >= 0, got '-1'");
  refused(header + "a,0,1,0,0,0,0,0,0,,0,0\n", "p.csv:2: column 'u_mps': expected a finite number [m/s], got ''");
  refused(header + "a,0,1,0,0,0,0,0,0,inf,0,0\n", "column 'u_mps'");
}
