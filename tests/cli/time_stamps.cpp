// One wrong time in a recording: named with its line, and never the cause of a grid over centuries.

#include <functional>

#include <catch2/catch.hpp>

#include "ensemble.hpp"

using namespace leeway;
using namespace test;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

namespace {

// A recording with other times: `of` gets the row's number from 0 and its time.
std::string with_times(const std::string& recording, const std::function<std::string(int, const std::string&)>& of) {
  std::string result = recording.substr(0, recording.find('\n') + 1);
  int row = 0;
  for (std::size_t begin = result.size(); begin < recording.size(); ++row) {
    const std::size_t end = recording.find('\n', begin), comma = recording.find(',', begin);
    const std::string time = of(row, recording.substr(begin, comma - begin));
    if (!time.empty()) result += time + recording.substr(comma, end + 1 - comma);
    begin = end + 1;
  }
  return result;
}

// Little memory and time: what takes more is made per second of a hole.
#ifdef __SANITIZE_ADDRESS__  // which maps more than that
const std::string kBounded = "timeout 120 ";
#else
const std::string kBounded = "ulimit -v 4000000; timeout 120 ";
#endif

void prepare(const TemporaryFolder& folder) {
  prepare_model(folder);
  done(folder,
       "mmg-sim random --ship vectwin-3m --duration-s 60 --wind-speed-mps 0.5 --noise paper-model-scale -o rec.csv");
  done(folder, "ens-predict --baseline hold rec.csv --steps 10 --quiet -o predicted");
}

}  // namespace

TEST_CASE("time: a time that no clock shows is refused by every reader, with its line", "[cli][errors]") {
  const TemporaryFolder folder;
  prepare(folder);
  const std::string good = io::read_text(folder / "rec.csv");
  for (const std::string last : {"1e308", "9.3e18", "-1e308", "2e11"}) {
    const bool is_first = last.starts_with('-');
    folder.write("rec.csv", with_times(good, [&](int row, const std::string& t) {
                   return row == (is_first ? 0 : 60) ? last : t;
                 }));
    for (const std::string command :
         {"mmg-sim replay --ship vectwin-3m rec.csv -o -",
          "mmg-sim replay --ship vectwin-3m rec.csv --prediction --restart-steps 10 -o -",
          "ens-train rec.csv --config tiny.json -o out",
          "ens-train data/dataset.json#train --config tiny.json --held-out rec.csv -o out",
          "ens-predict model rec.csv --steps 10 -o -", "ens-predict --baseline hold rec.csv --steps 10 -o -",
          "gap-locate --ship vectwin-3m rec.csv -o out", "gap-explain --ship vectwin-3m rec.csv -o out",
          "eval-metrics predicted --truth rec.csv -o -"}) {
      CAPTURE(command, last);
      check_refused(folder, command, 3,
                    fmt::format("rec.csv:{}: column 't_s': expected seconds within +-", is_first ? 2 : 62));
      CHECK_FALSE(fs::exists(folder / "out"));
    }
  }
  folder.write("orders.csv", "t_s,delta_p_deg\n0,10\n1e308,0\n");
  check_refused(folder, "mmg-sim schedule orders.csv --ship vectwin-3m -o -", 3,
                "orders.csv:3: column 't_s': expected a time");
  folder.write("orders.csv", "t_s,delta_p_deg\n0,10\n5e10,0\n");
  check_refused(folder, "mmg-sim schedule orders.csv --ship vectwin-3m -o -", 2, "is more than 1e9 times");
}

TEST_CASE("time: a clock that jumps is named, and no grid spans the jump", "[cli][errors]") {
  const TemporaryFolder folder;
  prepare(folder);
  const std::string good = io::read_text(folder / "rec.csv");
  for (const double jump_s : {1e8, 1.7e9, 9e10}) {
    CAPTURE(jump_s);
    fs::remove_all(folder / "out");
    folder.write("rec.csv", with_times(good, [&](int row, const std::string& t) {
                   return row < 30 ? t : fmt::format("{}", jump_s + row);
                 }));
    const std::string named = "rec.csv:32: column 't_s': from 29 s to ";
    for (const std::string command :
         {"ens-train rec.csv --config tiny.json --jobs 2 -o out",
          "mmg-sim replay --ship vectwin-3m rec.csv --prediction --restart-steps 10 -o out/replayed",
          "ens-predict model rec.csv --steps 10 --jobs 2 -o out/predicted",
          "ens-predict --baseline hold rec.csv --steps 10 --jobs 2 -o out/held",
          "gap-locate --ship vectwin-3m rec.csv --jobs 2 -o out/located"}) {
      const Outcome outcome = run(folder, kBounded + command);
      CAPTURE(command, outcome.err);
      CHECK(outcome.exit_code == 0);
      CHECK_THAT(outcome.err, Contains(named));
    }
    const std::string replay = "mmg-sim replay --ship vectwin-3m rec.csv -o -";
    check_refused(folder, replay, 3, named);
    check_refused(folder, replay, 3,
                  "while all others last 59 s together: a replay does not drive through such a hole");
    // Three whole sequences of ten points on each side, as in two recordings.
    for (const std::string from : {"replayed", "predicted", "held"}) {
      const std::string text = io::read_text(folder / ("out/" + from + "/rec.csv"));
      CAPTURE(from);
      CHECK_THAT(text, Contains("\nrec,4,9,") && !Contains("\nrec,6,"));
    }
  }
}

TEST_CASE("time: samples at one time are refused by every reader, with their line", "[cli][errors]") {
  const TemporaryFolder folder;
  prepare(folder);
  const std::string good = io::read_text(folder / "rec.csv");
  for (const std::string time : {"29.000000000001", "29.000000001"}) {
    folder.write("rec.csv", with_times(good, [&](int row, const std::string& t) { return row == 30 ? time : t; }));
    for (const std::string command :
         {"mmg-sim replay --ship vectwin-3m rec.csv -o -", "ens-train rec.csv --config tiny.json -o out",
          "ens-predict model rec.csv --steps 10 -o -", "gap-locate --ship vectwin-3m rec.csv -o out",
          "gap-explain --ship vectwin-3m rec.csv -o out"})
      check_refused(folder, command, 3,
                    "rec.csv:32: column 't_s': time must increase by 1e-06 s at least, but " + time);
  }
}

TEST_CASE("time: what is made per second of a recording is not made of a long pause", "[cli][errors]") {
  const TemporaryFolder folder;
  prepare(folder);
  const std::string good = io::read_text(folder / "rec.csv");
  folder.write("rec.csv", with_times(good, [](int row, const std::string& t) {
                 return row < 30 ? t : fmt::format("{}", 1000000 + row);
               }));
  const Outcome outcome = run(folder, kBounded + "gap-locate --ship vectwin-3m rec.csv --quiet -o out");
  CAPTURE(outcome.err);
  CHECK(outcome.exit_code == 0);
  // Microseconds: a replay of years.
  folder.write("rec.csv", with_times(good, [](int row, const std::string&) { return fmt::format("{}e4", 5 * row); }));
  check_refused(folder, "mmg-sim replay --ship vectwin-3m rec.csv --sample-s 0.1 --dt-s 0.1 -o -", 3,
                "is it in seconds?");
  check_refused(folder, "mmg-sim replay --ship vectwin-3m rec.csv --prediction --restart-steps 40 -o -", 3,
                "sampled every 50000 s");
  folder.write("rec.csv", good);
  check_refused(folder, "mmg-sim replay --ship vectwin-3m rec.csv --prediction --restart-steps 400 -o -", 3,
                "no recording holds 400 points 1 s apart without a gap");
}

TEST_CASE("time: a clock in another unit than seconds is not driven by", "[cli][errors]") {
  const TemporaryFolder folder;
  prepare(folder);
  folder.write("rec.csv", with_times(io::read_text(folder / "rec.csv"),
                                     [](int row, const std::string&) { return fmt::format("{}e8", row); }));
  check_refused(folder, "mmg-sim replay --ship vectwin-3m rec.csv -o -", 3,
                "rec.csv:3: column 't_s': 100000000 s after the sample before");
  check_refused(folder, "ens-train rec.csv --config tiny.json -o out", 3,
                "rec.csv:1: column 't_s': sampled every 1e+08 s");
  check_refused(folder, "ens-predict model rec.csv --steps 10 -o -", 3,
                "rec.csv:1: column 't_s': sampled every 1e+08 s");
  for (const std::string tool : {"gap-locate", "gap-explain"}) {
    const Outcome outcome = run(folder, kBounded + tool + " --ship vectwin-3m rec.csv --quiet -o out");
    CAPTURE(tool, outcome.err);
    CHECK(outcome.exit_code == 3);
    CHECK_THAT(outcome.err, Contains("its samples are 1e+08 s apart, and holes longer than 30 s are not passed over"));
  }
}

TEST_CASE("mmg-sim replay: says that it drives through a hole", "[cli][mmg-sim]") {
  const TemporaryFolder folder;
  done(folder, "mmg-sim zigzag --ship kvlcc2-l7 --duration-s 60 -o rec.csv");
  const std::string good = io::read_text(folder / "rec.csv"), replay = "mmg-sim replay --ship kvlcc2-l7 rec.csv -o ";
  CHECK(done(folder, replay + "whole.csv").err.find("no sample") == std::string::npos);
  folder.write("rec.csv",
               with_times(good, [](int row, const std::string& t) { return row > 20 && row < 31 ? "" : t; }));
  const Outcome outcome = done(folder, replay + "through.csv");
  CHECK_THAT(outcome.err,
             Contains("warning: rec.csv:23: no sample from 20 s to 31 s; the simulation drives on through the hole"));
  CHECK(io::read_text(folder / "through.csv").size() > good.size() / 2);
}
