#include <filesystem>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "ensemble.hpp"
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

TEST_CASE("gap-locate --model: a trained ensemble is the simulator, and says where it was not trained", "[cli][gap]") {
  const test::TemporaryFolder folder;
  test::prepare_model(folder);
  test::done(folder,
             "mmg-sim zigzag --ship vectwin-3m --rudder-deg 30 --heading-deg 30 --duration-s 90 --noise "
             "paper-model-scale --wind-speed-mps 0.7 --quiet -o zigzag.csv");
  const auto outcome = run(folder, "gap-locate --model model/ data/test/*.csv zigzag.csv --jobs 1 -o out");
  CAPTURE(outcome.err);
  REQUIRE(outcome.exit_code == 0);
  CHECK(outcome.out.empty());
  CHECK_THAT(outcome.err, Contains("ensemble model"));
  const io::Json json = io::read_json(folder / "out/locate.json");
  CHECK(json.at("verdict") != "mismatch");  // six epochs teach little, and the members know it
  CHECK(json.at("ship") == "model");
  CHECK(json.at("L_pp_m") == 3.0);
  const io::Json& ensemble = json.at("ensemble");
  CHECK(ensemble.at("members") == 4);
  CHECK(ensemble.at("time_step_s") == 1.0);
  CHECK(ensemble.at("base").is_null());
  CHECK(ensemble.at("outside_share").get<double>() > 0.05);
  CHECK(ensemble.at("members_sd").at("yaw_degps2").get<double>() > 0.0);
  for (const io::Json& interval : json.at("located").at("intervals")) {
    CHECK(interval.at("cause") == "untrained region");
    CHECK(interval.at("training").contains("outside_share"));
  }
  CHECK(json.at("provenance").at("inputs").at(0).at("file") == "model/ensemble.json");
  CHECK_THAT(io::read_text(folder / "out/zigzag.residual.csv"), Contains("t_s,u_dot_residual_mps2"));
  CHECK_THAT(io::read_text(folder / "out/report.html"), Contains("Recordings against model"));

  SECTION("the number of threads changes nothing") {
    test::done(folder, "gap-locate --model model/ data/test/*.csv zigzag.csv --jobs 2 --quiet -o two");
    CHECK(io::read_json(folder / "two/locate.json") == json);
  }
  SECTION("what does not fit is refused with its reason") {
    const std::string recording = " zigzag.csv -o refused";
    test::check_refused(folder, "gap-locate --model model --ship vectwin-3m" + recording, 2,
                        "exactly one of --ship and --model");
    test::check_refused(folder, "gap-locate" + recording, 2, "exactly one of --ship and --model");
    test::check_refused(folder, "gap-locate --ship vectwin-3m --length-m 3" + recording, 2, "--model");
    test::check_refused(folder, "gap-locate --model model --use-members 9" + recording, 2, "model has 4 members");
    test::check_refused(folder, "gap-locate --model data" + recording, 4, "data/ensemble.json");
    test::check_refused(folder, "gap-locate --model nowhere" + recording, 4, "nowhere/ensemble.json");
    test::done(folder,
               "cut -d, -f1-8 zigzag.csv > bare.csv && mmg-sim zigzag --ship esso-osaka-3m --duration-s 60 --quiet -o "
               "esso.csv "
               "&& sed '1s/delta_p_deg/rudder/' zigzag.csv > renamed.csv && awk 'NR == 1 || NR % 2 == 0' zigzag.csv > "
               "slow.csv");
    test::check_refused(folder, "gap-locate --model model esso.csv -o refused", 3, "no column 'delta_p_deg'");
    test::check_refused(folder, "gap-locate --model model renamed.csv -o refused", 3, "no column 'delta_p_deg'");
    test::check_refused(folder, "gap-locate --model model slow.csv -o refused", 3, "sampled every 2 s");
    test::done(folder, "rm model/member-02.json");
    test::check_refused(folder, "gap-locate --model model" + recording, 4, "member-02.json");
    test::done(folder, "sed -i 's/leeway ensemble 1/other/' model/ensemble.json");
    test::check_refused(folder, "gap-locate --model model" + recording, 3, "leeway ensemble 1");
    CHECK_FALSE(std::filesystem::exists(folder / "refused"));
  }
}
