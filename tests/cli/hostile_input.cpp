// Recordings, predictions and command lines that are nearly right: refused with their place, or read as they are meant.

#include <chrono>

#include <catch2/catch.hpp>

#include "ensemble.hpp"

using namespace leeway;
using namespace test;
using Catch::Matchers::Contains;

namespace {

const std::string kHeader = "t_s,u_mps,vm_mps,r_degps,psi_deg\n";
const std::string kPredictionHeader =
    "recording,sequence,step,t_s,particle,member,x0_m,y0_m,psi_deg,u_mps,vm_mps,r_degps\n";

}  // namespace

TEST_CASE("errors: CSV that is nearly right is refused with its place", "[cli][errors]") {
  const TemporaryFolder folder;
  const auto refused = [&](const std::string& text, const std::string& message) {
    CAPTURE(text.substr(0, 100));
    folder.write("rec.csv", text);
    check_refused(folder, "ens-predict --baseline hold rec.csv --steps 2 -o -", 3, "rec.csv:" + message);
  };
  refused(kHeader + "0,1,0,0,\"1\"2\n1,1,0,0,0\n", "2: column 'psi_deg': text behind the closing quotation mark");
  refused(kHeader + "0,1,0,0,1\"2\n1,1,0,0,0\n", "2: column 'psi_deg': a quotation mark within a field");
  refused("t_s,u_mps,vm_mps,r_degps\r0,1,0,0\r1,1,0,0\r", "1: a carriage return within a line");
  refused(kHeader + "0,1,0,0,0\n1,1,0,0,1e20\n", "3: column 'psi_deg': expected an angle within +-1e+09 deg");
  std::string columns = "time";
  for (int i = 0; i < 60'000; ++i) columns += fmt::format(",column-{}", i);
  refused(columns + "\n", "1: no column 't_s'; found time, column-0, ");
}

TEST_CASE("errors: many unknown columns cost time in proportion and are not all listed", "[cli][errors]") {
  const TemporaryFolder folder;
  const auto seconds = [&](int count) {
    std::string header = "t_s,u_mps,vm_mps,r_degps", row = ",1,0,0";
    for (int i = 0; i < count; ++i) {
      header += fmt::format(",column-{}", i);
      row += ",1";
    }
    folder.write("rec.csv", header + "\n0" + row + "\n1" + row + "\n");
    const auto start = std::chrono::steady_clock::now();
    const Outcome outcome = done(folder, "ens-predict --baseline hold rec.csv --steps 2 -o -");
    CHECK(outcome.err.size() < 3000);
    CHECK_THAT(outcome.err, Contains("warning: columns that no tool knows are ignored: column-0, "));
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  CHECK(seconds(60'000) < 10.0 * seconds(6'000) + 1.0);  // in the square it would be 100 times and a minute
}

TEST_CASE("errors: a prediction whose times do not increase is refused", "[cli][errors]") {
  const TemporaryFolder folder;
  folder.write("rec.csv", kHeader + "0,1,0,0,0\n1,1,0,0,0\n2,1,0,0,0\n");
  const std::string first = kPredictionHeader + "rec,0,0,1,0,0,0,0,0,1,0,0\n";
  for (const std::string t : {"1", "0.5"}) {
    folder.write("pred.csv", first + "rec,0,1," + t + ",0,0,0,0,0,1,0,0\n");
    check_refused(folder, "eval-metrics pred.csv --truth rec.csv -o -", 3,
                  "pred.csv:3: column 't_s': time must increase with the steps of recording 'rec', sequence 0, but " +
                      t + " s of step 1 follows 1 s");
  }
  folder.write("pred.csv", kPredictionHeader + "rec,0,0,1,0,0,0,0,1e20,1,0,0\n");
  check_refused(folder, "eval-metrics pred.csv --truth rec.csv -o -", 3,
                "pred.csv:2: column 'psi_deg': expected an angle");
}

TEST_CASE("eval-metrics: numbers that overflow are missing, never inf", "[cli][eval-metrics]") {
  const TemporaryFolder folder;
  folder.write("rec.csv", kHeader + "0,1,0,0,0\n1,1e308,0,0,0\n2,1,0,0,0\n");
  folder.write("pred.csv", kPredictionHeader + "rec,0,0,0,0,0,0,0,0,1,0,0\nrec,0,1,1,0,0,0,0,0,1,0,0\n");
  const Outcome outcome = done(folder, "eval-metrics pred.csv --truth rec.csv -o metrics.json --per-step steps.csv");
  for (const std::string& text :
       {outcome.err, io::read_text(folder / "metrics.json"), io::read_text(folder / "steps.csv")}) {
    CAPTURE(text);
    for (const std::string before : {",", " "})
      for (const std::string number : {"inf", "-inf", "nan"}) CHECK(text.find(before + number) == std::string::npos);
  }
  CHECK_THAT(io::read_text(folder / "steps.csv"), Contains("rec,0,1,1,1,0,0,0,0,0,1e+308,0,0,,0,,,,,,1e+308,0,0,"));
}

TEST_CASE("errors: a result whose file would have a name that is not UTF-8 is refused", "[cli][errors]") {
  const TemporaryFolder folder;
  folder.write("rec.csv", kHeader + "0,1,0,0,0\n1,1,0,0,0\n2,1,0,0,0\n");
  std::filesystem::copy_file(folder / "rec.csv", folder /
                                                     "b\xff"
                                                     "d.csv");
  const Outcome outcome = run(folder, "ens-predict --baseline hold --steps 2 b*d.csv -o out");
  CAPTURE(outcome.err);
  CHECK(outcome.exit_code == 2);
  CHECK_THAT(outcome.err, Contains("a result cannot have this name, since it is not UTF-8"));
}

TEST_CASE("errors: a seed is read as a whole number of 64 bits, or refused", "[cli][errors]") {
  const TemporaryFolder folder;
  const std::string random =
      "mmg-sim random --ship vectwin-3m --duration-s 20 --sample-s 10 --noise paper-model-scale ";
  for (const std::string seed : {"18446744073709551616", "1e30", "-1", "1.5", "0x10", "99999999999999999999999", ""}) {
    CAPTURE(seed);
    const Outcome outcome = run(folder, random + "--seed '" + seed + "'");
    CHECK(outcome.exit_code == 2);
    CHECK_THAT(outcome.err, Contains("mmg-sim: error: --seed: "));
  }
  const Outcome largest = done(folder, random + "--seed 18446744073709551615 -o -");
  CHECK(largest.out != done(folder, random + "--seed 18446744073709551614 -o -").out);
  CHECK(done(folder, random + "--seed 010 -o -").out == done(folder, random + "--seed 10 -o -").out);
  CHECK(run(folder, random + "--jobs 18446744073709551616").exit_code == 2);
}

TEST_CASE("mmg-sim replay: --effect before recordings does not take them", "[cli][mmg-sim]") {
  const TemporaryFolder folder;
  folder.write("current.json", R"({"type": "steady-current", "current_speed_mps": 0.1, "current_set_deg": 90})");
  done(folder, "mmg-sim zigzag --ship kvlcc2-l7 --duration-s 5 -o rec.csv");
  const std::string replay = "mmg-sim replay --ship kvlcc2-l7 ";
  const std::string expected = done(folder, replay + "rec.csv --effect current.json -o -").out;
  CHECK(done(folder, replay + "--effect current.json rec.csv -o -").out == expected);
  CHECK(done(folder, "mmg-sim replay --effect current.json rec.csv --ship kvlcc2-l7 -o -").out == expected);
  CHECK(done(folder, replay + "--effect current.json --effect current.json rec.csv -o -").out != expected);
}

TEST_CASE("dataset: a file may have .json# in its name", "[cli][errors]") {
  const TemporaryFolder folder;
  const std::string text = kHeader + "0,1,0,0,0\n1,1,0,0,0\n";
  folder.write("run.json#2.csv", text);
  folder.write("runs.json#1/rec.csv", text);
  folder.write("2.csv", text);
  folder.write("dataset.json", R"({"sets": [{"name": "2.csv", "recordings": [{"file": "2.csv"}]}]})");
  const std::string predict = "ens-predict --baseline hold --steps 2 -o - ";
  CHECK_THAT(done(folder, predict + "'run.json#2.csv'").out, Contains("\nrun.json#2,0,"));
  CHECK_THAT(done(folder, predict + "'runs.json#1/rec.csv'").out, Contains("\nrec,0,"));
  CHECK_THAT(done(folder, predict + "'dataset.json#2.csv'").out, Contains("\n2,0,"));
  check_refused(folder, predict + "'none.json#set'", 4, "none.json: cannot be opened");
}
