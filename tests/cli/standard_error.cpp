// Messages are best effort: a standard error that is full, closed or without a reader changes nothing else.

#include <catch2/catch.hpp>
#include <fmt/format.h>

#include "ensemble.hpp"

using namespace leeway;
using namespace test;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

namespace {

// What a command writes into `output`, by file name; and how it ended.
struct Kept {
  std::string code;
  std::map<std::string, std::string> files;
  bool operator==(const Kept&) const = default;
};

// A shell writes the command's exit code, since a pipe would hide it.
Kept kept_of(const TemporaryFolder& folder, const std::string& command, const std::string& around) {
  fs::remove_all(folder / "output");
  fs::create_directories(folder / "output");
  folder.write("command.sh", fmt::format("{}\n", command));
  const Outcome outcome = run(folder, fmt::vformat(around, fmt::make_format_args("sh command.sh")));
  CAPTURE(command, around, outcome.out, outcome.err);
  CHECK(outcome.exit_code == 0);
  return {io::read_text(folder / "code"), files_of(folder / "output")};
}

const std::vector<std::string> kLost{
    "{} 2> /dev/full; echo $? > code",
    "{} 2>&-; echo $? > code",
    "{} 2>&- >&- <&-; echo $? > code",
    "({}; echo $? > code) 2>&1 | true",
};

void check_the_same(const TemporaryFolder& folder, const std::string& command, const std::string& code) {
  const Kept expected = kept_of(folder, command, "{} 2> said; echo $? > code");
  CAPTURE(command, io::read_text(folder / "said"));
  CHECK(expected.code == code + "\n");
  CHECK_FALSE(io::read_text(folder / "said").empty());
  for (const std::string& around : kLost) {
    CAPTURE(around);
    CHECK(kept_of(folder, command, around) == expected);
  }
}

}  // namespace

TEST_CASE("standard error: that it cannot be written changes neither results nor exit codes", "[cli][errors]") {
  if (!fs::exists("/dev/full")) {
    WARN("SKIPPED: no /dev/full on this system");
    return;
  }
  const TemporaryFolder folder;
  prepare_model(folder);
  done(folder, "ens-predict model data/dataset.json#test --steps 10 --particles 4 --quiet -o predicted");
  const std::string train = "ens-train data/dataset.json#train --config tiny.json --members 2 ";
  check_the_same(folder, train + "--jobs 1 -o output", "0");
  check_the_same(folder, "ens-predict model data/dataset.json#test --steps 10 --particles 4 -o output", "0");
  check_the_same(folder, "eval-metrics predicted --truth data/dataset.json#test -o output/metrics.json", "0");
  check_the_same(folder, "pd-sweep model --ship vectwin-3m --kp 5:10:5 --kd 5:5:5 --particles 2 -o output/sweep.csv",
                 "0");
  check_the_same(folder,
                 "mmg-sim zigzag --ship kvlcc2-l7 --duration-s 5 -o output/z10.csv --indices output/indices.json", "0");
  check_the_same(folder, "gap-explain --ship vectwin-3m none-such.csv -o output", "4");
  check_the_same(folder, "gap-locate --ship vectwin-3m command.sh -o output", "3");
  check_the_same(folder, "mmg-sim zigzag --no-such-option -o output/z10.csv", "2");
}

TEST_CASE("standard error: where standard streams are closed, no file takes their place", "[cli][errors]") {
  const TemporaryFolder folder;
  // The first file that is opened would get the number of the standard error, and the message with it.
  folder.write("rec.csv", "t_s,u_mps,vm_mps,r_degps,delta_deg,n_p_rps\n0,1,0,0,0,99\n1,1,0,0,0,99\n");
  const std::string replay = "mmg-sim replay --ship kvlcc2-l7 rec.csv ";
  const Outcome expected = run(folder, replay + "-o expected.csv");
  CHECK_THAT(expected.err, Contains("outside the limits"));
  const Outcome outcome = run(folder, replay + "-o rep.csv 2>&- <&- >&-");
  CHECK(outcome.exit_code == 0);
  CHECK(io::read_text(folder / "rep.csv") == io::read_text(folder / "expected.csv"));
  const Outcome no_output = run(folder, replay + ">&-");
  CHECK(no_output.exit_code == 4);
  CHECK_THAT(no_output.err, Contains("standard output: cannot be written: Bad file descriptor"));
  const Outcome no_input = run(folder, "mmg-sim replay --ship kvlcc2-l7 - <&-");
  CHECK(no_input.exit_code == 4);
  CHECK_THAT(no_input.err, Contains("-: cannot be read: Bad file descriptor"));
}
