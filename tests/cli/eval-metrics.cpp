#include <algorithm>

#include <catch2/catch.hpp>

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
  CHECK(folder.listing() == "m.json pred s.csv test");
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
