#include <filesystem>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "io/json.hpp"
#include "run.hpp"

using namespace leeway;
using Catch::Matchers::Contains;
using test::run;

TEST_CASE("gap-explain: the ship that it writes runs in the simulator", "[cli][gap][long]") {
  const test::TemporaryFolder folder;
  REQUIRE(run(folder,
              "echo '{\"type\": \"steady-current\", \"current_speed_mps\": 0.1, \"current_set_deg\": 90}' > "
              "current.json && "
              "for a in 10 20 30; do mmg-sim zigzag --ship esso-osaka-3m --rudder-deg $a --heading-deg 20 --effect "
              "current.json --noise paper-model-scale --quiet -o z$a.csv; done")
              .exit_code == 0);
  const auto outcome = run(folder, "gap-explain --ship esso-osaka-3m z10.csv z20.csv --holdout z30.csv -o out");
  CAPTURE(outcome.err);
  REQUIRE(outcome.exit_code == 0);
  CHECK(outcome.out.empty());
  CHECK_THAT(outcome.err, Contains("MISMATCH") && Contains("A current of 0.1"));
  const io::Json json = io::read_json(folder / "out/report.json");
  CHECK(json.at("verdict") == "mismatch");
  CHECK(json.at("chosen") == io::Json{"steady-current"});
  CHECK(json.at("ship") == "ship.json");
  CHECK(json.at("provenance").at("inputs").size() == 4);
  CHECK(json.at("fit").at("heldout").at("after").at("rmse_position_m").get<double>() <
        json.at("fit").at("heldout").at("before").at("rmse_position_m").get<double>());
  CHECK_THAT(io::read_text(folder / "out/report.html"), Contains("<html"));
  const auto replayed = run(folder, "mmg-sim replay z30.csv --ship out/ship.json --quiet -o replayed.csv");
  CAPTURE(replayed.err);
  CHECK(replayed.exit_code == 0);
  CHECK(
      run(folder,
          "gap-explain --ship esso-osaka-3m z10.csv z20.csv --fail-on-mismatch --thorough --campaigns 1 --quiet -o out")
          .exit_code == 1);
  const io::Json thorough = io::read_json(folder / "out/report.json"), &bootstrap = thorough.at("bootstrap");
  CHECK(bootstrap.at("campaigns").get<int>() + bootstrap.at("failed").get<int>() == 1);
  CHECK(bootstrap.at("truths").size() >= 1);
  double all = 0.0;
  for (const io::Json& one : thorough.at("hypotheses")) all += one.at("probability").get<double>();
  CHECK(all <= 1.0 - bootstrap.at("not_fitted").get<double>() + 1e-9);
  CHECK(thorough.at("not_fitted").get<double>() >= bootstrap.at("not_fitted").get<double>() - 1e-9);
  CHECK(json.at("bootstrap").is_null());
}

TEST_CASE("gap-explain: options that do not go together are a wrong command line", "[cli][gap]") {
  const test::TemporaryFolder folder;
  for (const char* options : {"--campaigns 10", "--thorough --calibrate", "--thorough --campaigns 0"}) {
    const auto outcome = run(folder, std::string("gap-explain --ship esso-osaka-3m z.csv -o out ") + options);
    CAPTURE(options, outcome.err);
    CHECK(outcome.exit_code == 2);
    CHECK_THAT(outcome.err, Contains("--thorough") || Contains("--campaigns"));
  }
}

TEST_CASE("gap-explain: one effect at most, if no more are asked for", "[cli][gap]") {
  const test::TemporaryFolder folder;
  REQUIRE(run(folder, "mmg-sim zigzag --ship esso-osaka-3m --duration-s 100 --quiet -o z.csv").exit_code == 0);
  REQUIRE(run(folder, "gap-explain --ship esso-osaka-3m z.csv --refits 1 --most-effects 1 --quiet -o out").exit_code ==
          0);
  const io::Json report = io::read_json(folder / "out/report.json");
  for (const io::Json& one : report.at("hypotheses")) CHECK(one.at("effects").size() <= 1);
}

TEST_CASE("gap-explain: its results are no standard output", "[cli][gap]") {
  const test::TemporaryFolder folder;
  REQUIRE(run(folder, "mmg-sim zigzag --ship esso-osaka-3m --quiet -o z.csv").exit_code == 0);
  const auto outcome = run(folder, "gap-explain --ship esso-osaka-3m z.csv -o -");
  CHECK(outcome.exit_code == 2);
  CHECK_THAT(outcome.err, Contains("expected a folder for the results, found '-'"));
}

TEST_CASE("gap-explain: a calibration writes a ship that other tools draw from", "[cli][gap][long]") {
  const test::TemporaryFolder folder;
  REQUIRE(run(folder,
              "for a in 10 20; do mmg-sim zigzag --ship vectwin-3m-estimated --rudder-deg $a --heading-deg 20 --noise "
              "paper-model-scale --quiet -o z$a.csv; done")
              .exit_code == 0);
  const auto outcome = run(folder, "gap-explain --calibrate --ship vectwin-3m z10.csv z20.csv -o out");
  CAPTURE(outcome.err);
  REQUIRE(outcome.exit_code == 0);
  CHECK_THAT(outcome.err, Contains("coefficients were fitted"));
  const io::Json report = io::read_json(folder / "out/report.json");
  CHECK(report.at("chosen").empty());
  CHECK(report.at("hypotheses").empty());
  CHECK(report.at("sets").empty());
  const io::Json ship = io::read_json(folder / "out/ship.json");
  CHECK(ship.at("name").get<std::string>().ends_with(", fitted"));
  CHECK(ship.at("coefficient_covariance").at("names").size() == ship.at("coefficient_covariance").at("matrix").size());
  const auto draws = run(folder, "mmg-sim draws --ship out/ship.json --count 2 --quiet -o ships");
  CAPTURE(draws.err);
  CHECK(draws.exit_code == 0);
}

TEST_CASE("gap-explain: wrong input is refused with its reason and nothing is written", "[cli][gap]") {
  const test::TemporaryFolder folder;
  REQUIRE(run(folder,
              "mmg-sim zigzag --ship esso-osaka-3m --duration-s 60 --quiet -o a.csv && cp a.csv b.csv && head -9 a.csv "
              "> short.csv")
              .exit_code == 0);
  const auto check = [&](const std::string& arguments, int exit_code, const std::string& words) {
    const auto outcome = run(folder, "gap-explain " + arguments + " -o out");
    CAPTURE(arguments, outcome.err);
    CHECK(outcome.exit_code == exit_code);
    CHECK(outcome.out.empty());
    CHECK_THAT(outcome.err, Contains(words));
    CHECK_FALSE(std::filesystem::exists(folder / "out"));
  };
  check("--ship esso-osaka-3m a.csv --holdout a.csv", 2, "is also among the recordings that are fitted");
  check("--ship esso-osaka-3m a.csv --holdout b.csv", 3, "b.csv: holds the same as a.csv");
  check("--ship esso-osaka-3m a.csv --holdout none.csv", 4, "none.csv");
  check("--ship esso-osaka-3m short.csv", 3, "no recording is long enough");
  check("--ship esso-osaka-3m a.csv --holdout short.csv", 3, "short.csv");
  check("--ship no-such-ship a.csv", 2, "no-such-ship");
  check("--ship esso-osaka-3m", 2, "recordings");
}
