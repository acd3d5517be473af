#include <algorithm>

#include <catch2/catch.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "io/json.hpp"
#include "run.hpp"

using namespace leeway;
using Catch::Matchers::Contains;
using test::Outcome;
using test::run;
using test::TemporaryFolder;

namespace {

void write_scored_inputs(const TemporaryFolder& folder) {
  std::string truth = "t_s,u_mps,vm_mps,r_degps,x0_m,y0_m,rope\n";
  std::string prediction = "recording,sequence,step,t_s,particle,member,x0_m,y0_m,psi_deg,u_mps,vm_mps,r_degps\n";
  for (int k = 0; k < 10; ++k) {
    truth += fmt::format("{},1,{},0,{},0,1\n", k, 0.01 * k, k);
    for (int p = 0; p < 5; ++p)
      prediction += fmt::format("run,0,{},{},{},{},{},0,0,{},{},{}\n", k, k, p, p, k, 1 + 0.01 * k * (p % 2),
                                0.004 * k * (p % 3), 0.1 * k * (p % 4));
  }
  folder.write("test/run.csv", truth);
  folder.write("pred/run.csv", prediction);
}

}  // namespace

TEST_CASE("eval-metrics: a folder, a file and a pipe give the same figures", "[cli][eval-metrics]") {
  const TemporaryFolder folder;
  write_scored_inputs(folder);
  const auto figures = [&](const std::string& command) {
    const Outcome outcome = run(folder, command);
    REQUIRE(outcome.exit_code == 0);
    return io::parse_json(outcome.out, "stdout");
  };
  const io::Json from_folder = figures("eval-metrics pred --truth test/run.csv");
  const io::Json from_file = figures("eval-metrics pred/run.csv --truth test/run.csv -o -");
  const io::Json from_pipe = figures("cat pred/run.csv | eval-metrics - --truth test/run.csv");
  CHECK(from_folder["datasets"] == from_file["datasets"]);
  CHECK(from_folder["datasets"] == from_pipe["datasets"]);
  CHECK(from_folder["datasets"][0]["name"] == "test");
  CHECK(from_folder["overall"]["sequences"] == 1);
  CHECK(from_folder["provenance"]["tool"] == "eval-metrics");
  CHECK(from_folder["provenance"]["inputs"].size() == 2);
  CHECK(from_folder["provenance"]["inputs"][0]["sha256"].get<std::string>().size() == 64);
  CHECK(from_pipe["provenance"]["inputs"][0]["sha256"] == "");
}

TEST_CASE("eval-metrics: equal inputs give equal bytes, and files hold what the pipe does", "[cli][eval-metrics]") {
  const TemporaryFolder folder;
  write_scored_inputs(folder);
  const Outcome one = run(folder, "eval-metrics pred --truth test/run.csv --jobs 1");
  const Outcome two = run(folder, "eval-metrics pred --truth test/run.csv --jobs 3 --quiet -o m.json --per-step s.csv");
  CHECK(two.exit_code == 0);
  CHECK(two.out.empty());
  CHECK(two.err.empty());
  CHECK(io::read_text(folder / "m.json") == one.out);
  CHECK(folder.listing() == "m.json pred s.csv s.csv.provenance.json test");
  const std::string steps = io::read_text(folder / "s.csv");
  CHECK(std::count(steps.begin(), steps.end(), '\n') == 11);
  // The table for people and the notice of an unknown column stand on the standard error.
  CHECK_THAT(one.err, Contains("overall") && Contains("L_maha") && Contains("rope"));
}

TEST_CASE("eval-metrics: help and version go to the standard output", "[cli][eval-metrics]") {
  const TemporaryFolder folder;
  const Outcome help = run(folder, "eval-metrics --help"), version = run(folder, "eval-metrics --version");
  CHECK(help.exit_code == 0);
  CHECK_THAT(help.out, Contains("--per-step") && Contains("--sigma-r-degps") && Contains("=0.1"));
  CHECK(version.exit_code == 0);
  CHECK(version.out == "leeway " LEEWAY_VERSION "\n");
}

TEST_CASE("eval-metrics: what predictions are laid beside and start from is said, of folders as of pipes",
          "[cli][eval-metrics]") {
  const TemporaryFolder folder;
  folder.write("spec.json", R"({"ship": "vectwin-3m", "noise": "paper-model-scale", "sets": [
    {"name": "test", "runs": [{"maneuver": "turning", "rudder_deg": [20, 30], "duration_s": 30}]}]})");
  REQUIRE(run(folder, "mmg-sim dataset spec.json -o data --quiet").exit_code == 0);
  const auto said = [&](const std::string& command) {
    const Outcome outcome = run(folder, command);
    CAPTURE(command, outcome.err);
    REQUIRE(outcome.exit_code == 0);
    const io::Json json = io::parse_json(outcome.out, "stdout")["datasets"][0];
    return json["against"].get<std::string>() + ", from " + json["initial_state"].get<std::string>();
  };
  const std::string hold = "ens-predict --baseline hold data/dataset.json --steps 10 --quiet ";
  const std::string score = "eval-metrics - --quiet --truth ", all = "data/dataset.json";
  CHECK(said(hold + "| " + score + all) == "truth, from truth");
  CHECK(said(hold + "--initial-state observed | " + score + all + " --against observations") ==
        "observations, from observations");
  CHECK(said(hold + "--initial-state observed | " + score + all) == "truth, from unstated");
  CHECK(said(hold + "-o pred && eval-metrics pred --quiet --against observations --truth " + all) ==
        "observations, from truth");
  CHECK(said(hold + "--initial-state observed -o seen && eval-metrics seen --quiet --truth " + all) ==
        "truth, from observations");
  CHECK(said("mmg-sim replay --ship vectwin-3m " + all +
             " --prediction --restart-steps 10 --quiet -o replayed && "
             "eval-metrics replayed --quiet --truth " +
             all) == "truth, from observations");
  // Files alone: a folder `truth` says it, otherwise the command line does, or nobody.
  CHECK(said(hold + "| " + score + "data/test/truth/*.csv") == "truth, from truth");
  CHECK(said(hold + "| " + score + "data/test/*.csv") == "unstated, from unstated");
  CHECK(said(hold + "| " + score + "data/test/*.csv --against observations") == "observations, from unstated");

  const Outcome table = run(folder, hold + "| eval-metrics - --truth " + all);
  CHECK_THAT(table.err, Contains("laid beside: truth; initial states: truth"));
  const Outcome wrong = run(folder, hold + "| " + score + "data/test/truth/*.csv --against observations");
  CHECK(wrong.exit_code == 2);
  CHECK_THAT(wrong.err, Contains("lies in a folder of truths; observations were asked for"));
  folder.write(
      "data/plain.json",
      R"({"sets": [{"name": "test", "recordings": [{"file": "test/test-t20.csv"}, {"file": "test/test-t30.csv"}]}]})");
  const Outcome lacking = run(folder, hold + "| " + score + "data/plain.json --against truth");
  CHECK(lacking.exit_code == 3);
  CHECK_THAT(lacking.err, Contains("data/plain.json: lists no truth of data/test/test-t20.csv"));
  CHECK(said(hold + "| " + score + "data/plain.json") == "observations, from unstated");
}

TEST_CASE("eval-metrics: a row for each recording, in the table and in the JSON", "[cli][eval-metrics]") {
  const TemporaryFolder folder;
  folder.write("spec.json", R"({"ship": "vectwin-3m", "sets": [
    {"name": "test", "runs": [{"maneuver": "turning", "rudder_deg": [20, 30], "duration_s": 30}]}]})");
  REQUIRE(run(folder, "mmg-sim dataset spec.json -o data --quiet").exit_code == 0);
  REQUIRE(run(folder, "ens-predict --baseline hold data/dataset.json --steps 10 -o pred --quiet").exit_code == 0);
  const Outcome outcome = run(folder, "eval-metrics pred --truth data/dataset.json");
  REQUIRE(outcome.exit_code == 0);
  const io::Json json = io::parse_json(outcome.out, "stdout");
  REQUIRE(json["recordings"].size() == 2);
  CHECK(json["recordings"][0]["name"] == "test-t20");
  CHECK(json["recordings"][0]["set"] == "test");
  for (const char* key : {"L_eucl", "L_maha", "maha_honest", "coverage", "sequences", "crps"})
    CHECK(json["recordings"][1].contains(key));
  const double mean =
      0.5 * (json["recordings"][0]["L_eucl"].get<double>() + json["recordings"][1]["L_eucl"].get<double>());
  CHECK(mean == Approx(json["overall"]["L_eucl"].get<double>()));  // of equally many points
  CHECK_THAT(outcome.err, Contains("recording") && Contains("\ntest-t20 ") && Contains("\ntest-t30 ") &&
                              Contains("\nset ") && Contains("\noverall "));
}

TEST_CASE("eval-metrics: recordings shorter than a sequence are skipped, named and counted", "[cli][eval-metrics]") {
  const TemporaryFolder folder;
  for (const auto& [name, duration_s] : {std::pair{"long", 40}, std::pair{"short", 5}, std::pair{"tiny", 3}})
    REQUIRE(run(folder, fmt::format("mkdir -p test && mmg-sim turning --ship vectwin-3m --duration-s {} -o test/{}.csv",
                                    duration_s, name))
                .exit_code == 0);
  const std::string hold = "ens-predict --baseline hold test/*.csv --steps 20 ",
                    replay = "mmg-sim replay --ship vectwin-3m test/*.csv --prediction --restart-steps 20 ";
  for (const std::string& command : {hold, replay}) {
    CAPTURE(command);
    const Outcome outcome = run(folder, "rm -rf pred; " + command + "-o pred");
    CHECK(outcome.exit_code == 0);
    CHECK_THAT(outcome.err, Contains("2 of 3 recordings hold no 20 points 1 s apart without a gap, and are skipped: "
                                     "test/short.csv"));
    CHECK(run(folder, "ls pred").out == "long.csv\nprediction.json\n");
    const Outcome scored = run(folder, "eval-metrics pred --truth test/*.csv");
    CHECK(scored.exit_code == 0);
    CHECK_THAT(scored.err,
               Contains("2 of 3 recordings have no predicted sequence") && Contains("short") && Contains("tiny"));
  }
  for (const std::string command :
       {"ens-predict --baseline hold test/short.csv test/tiny.csv --steps 20 -o none",
        "mmg-sim replay --ship vectwin-3m test/short.csv test/tiny.csv --prediction --restart-steps 20 -o none"}) {
    const Outcome refused = run(folder, command);
    CHECK(refused.exit_code == 3);
    CHECK_THAT(refused.err, Contains("no recording holds 20 points 1 s apart without a gap"));
    CHECK(run(folder, "ls none/*.csv 2> errors").exit_code != 0);
  }
  // Predictions without a row, as of earlier versions: passed over beside others, an error alone.
  const std::string header = "recording,sequence,step,t_s,particle,member,x0_m,y0_m,psi_deg,u_mps,vm_mps,r_degps\n";
  REQUIRE(run(folder, hold + "-o - --quiet > good.csv").exit_code == 0);
  folder.write("old/short.csv", header);
  const Outcome beside = run(folder, "eval-metrics good.csv old/short.csv --truth test/*.csv");
  CHECK(beside.exit_code == 0);
  CHECK_THAT(beside.err, Contains("have no row and are skipped: old/short.csv"));
  CHECK(run(folder, "eval-metrics old --truth test/*.csv").exit_code == 3);
  folder.write("old/tiny.csv", header);
  CHECK(run(folder, "eval-metrics old --truth test/*.csv").exit_code == 3);
}
