#include <filesystem>

#include <catch2/catch.hpp>

#include "io/json.hpp"
#include "run.hpp"

using namespace leeway;
using Catch::Matchers::Contains;
using test::run;

TEST_CASE("gap-locate: recordings of the simulator itself, from the shell", "[cli][gap][long]") {
  const test::TemporaryFolder folder;
  REQUIRE(run(folder,
              "mmg-sim zigzag --ship kvlcc2-l7 --duration-s 300 --noise paper-model-scale --quiet -o zigzag.csv && "
              "mmg-sim turning --ship kvlcc2-l7 --rudder-deg 20 --duration-s 300 --noise paper-model-scale --seed 2 "
              "--quiet -o turning.csv")
              .exit_code == 0);
  const auto outcome = run(folder, "gap-locate --ship kvlcc2-l7 zigzag.csv turning.csv -o out");
  CAPTURE(outcome.err);
  REQUIRE(outcome.exit_code == 0);
  CHECK(outcome.out.empty());
  CHECK_THAT(outcome.err, Contains("NO MISMATCH"));
  const io::Json json = io::read_json(folder / "out/locate.json");
  CHECK(json.at("verdict") == "no-mismatch");
  CHECK(json.at("p_value").get<double>() > 0.01);
  CHECK(json.at("located").at("intervals").empty());
  CHECK(json.at("audit").at("faults").empty());
  CHECK(json.at("sigma_w").is_object());
  CHECK(json.at("provenance").at("inputs").size() == 3);
  CHECK_THAT(io::read_text(folder / "out/zigzag.residual.csv"), Contains("t_s,u_dot_residual_mps2"));
  CHECK_THAT(io::read_text(folder / "out/report.html"), Contains("<html"));

  SECTION("the number of threads changes nothing") {
    REQUIRE(run(folder, "gap-locate --ship kvlcc2-l7 zigzag.csv turning.csv --jobs 1 --quiet -o one").exit_code == 0);
    io::Json one = io::read_json(folder / "one/locate.json"), two = json;
    CHECK(one == two);
  }
}

TEST_CASE("gap-locate: wrong input is refused with its reason and nothing is written", "[cli][gap]") {
  const test::TemporaryFolder folder;
  REQUIRE(run(folder,
              "mmg-sim zigzag --ship esso-osaka-3m --duration-s 60 --quiet -o a.csv && cp a.csv b.csv && "
              "head -9 a.csv > short.csv && cut -d, -f1-4 a.csv > bare.csv && mkdir other && cp a.csv other/")
              .exit_code == 0);
  const auto check = [&](const std::string& arguments, int exit_code, const std::string& words) {
    const auto outcome = run(folder, "gap-locate " + arguments + " -o out");
    CAPTURE(arguments, outcome.err);
    CHECK(outcome.exit_code == exit_code);
    CHECK(outcome.out.empty());
    CHECK_THAT(outcome.err, Contains(words));
    CHECK_FALSE(std::filesystem::exists(folder / "out"));
  };
  check("--ship esso-osaka-3m a.csv b.csv", 3, "holds the same as a.csv");
  check("--ship esso-osaka-3m a.csv other/a.csv", 2, "other/a.csv: has the same name as a.csv");
  check("--ship esso-osaka-3m a.csv a.csv", 2, "has the same name");
  check("--ship esso-osaka-3m a.csv --seed -1", 2, "--seed");
  check("--ship esso-osaka-3m short.csv", 3, "no recording is long enough");
  check("--ship esso-osaka-3m bare.csv", 3, "no column 'delta_deg'");
  check("--ship vectwin-3m a.csv", 3, "no column 'delta_p_deg'");
  check("--ship esso-osaka-3m missing.csv", 4, "missing.csv");
  check("--ship nowhere a.csv", 2, "nowhere");
  check("--ship esso-osaka-3m a.csv --false-alarm 2", 2, "--false-alarm");
  check("a.csv", 2, "--ship");
}
