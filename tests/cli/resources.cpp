// Threads and memory that the system refuses: one line and an exit code, or the same result.

#include "ensemble.hpp"

using namespace leeway;
using namespace test;
using Catch::Matchers::Contains;

namespace {

const std::vector<std::string> kTools{"mmg-sim",  "ens-train",  "ens-predict", "eval-metrics",
                                      "pd-sweep", "gap-locate", "gap-explain", "leeway-bench"};

// 0, or 1 or 4 with one line, in time; the loader's own 127 where not even the libraries fit.
void check_in_order(const Outcome& outcome) {
  CAPTURE(outcome.exit_code, outcome.err);
  CHECK((outcome.exit_code == 0 || outcome.exit_code == 1 || outcome.exit_code == 4 || outcome.exit_code == 127));
  if (outcome.exit_code == 1 || outcome.exit_code == 4)
    CHECK(std::count(outcome.err.begin(), outcome.err.end(), '\n') == 1);
}

// What a sanitizer maps is more than the limits below.
bool skip_with_sanitizers() {
#ifdef __SANITIZE_ADDRESS__
  WARN("SKIPPED: a tool with the address sanitizer needs more address space");
  return true;
#else
  return false;
#endif
}

}  // namespace

TEST_CASE("resources: no tool is linked with a library that starts threads of its own", "[cli]") {
  const TemporaryFolder folder;
  for (const std::string& tool : kTools) {
    CAPTURE(tool);
    const std::string libraries = done(folder, "ldd \"$(command -v " + tool + ")\"").out;
    for (const std::string library : {"blas", "lapack", "atlas", "gomp", "tbb", "ceres"})
      CHECK(libraries.find(library) == std::string::npos);
  }
}

TEST_CASE("resources: a small address space is no reason to hang or to abort", "[cli]") {
  if (skip_with_sanitizers()) return;
  const TemporaryFolder folder;
  prepare_model(folder);
  done(folder, "mmg-sim zigzag --ship esso-osaka-3m --duration-s 60 --quiet -o esso.csv");
  // From about 19 to 21 MB the libraries fit, but not what they allocate before main(): there the runtime itself ends.
  for (const int mb : {16, 30, 50, 90, 150, 200}) {
    CAPTURE(mb);
    const std::string limited = fmt::format("ulimit -v {}; timeout -s KILL 60 ", mb * 1024);
    for (const std::string& tool : kTools) check_in_order(run(folder, limited + tool + " --version"));
    for (const std::string command :
         {"mmg-sim zigzag --ship vectwin-3m --duration-s 50 --quiet -o z.csv",
          "mmg-sim dataset spec.json --quiet -o new",
          "ens-train data/train/train-r-01.csv --config tiny.json --quiet -o trained --jobs 4",
          "ens-predict model data/dataset.json --quiet -o predicted --jobs 4",
          "eval-metrics esso.csv --truth esso.csv --quiet -o metrics.json",
          "pd-sweep model --ship vectwin-3m --kp 20 --kd 20 --particles 2 --duration-s 20 --quiet -o sweep.csv --jobs "
          "4",
          "gap-locate --ship esso-osaka-3m esso.csv --quiet -o located --jobs 4"}) {
      CAPTURE(command);
      const Outcome outcome = run(folder, limited + command);
      if (outcome.exit_code != 3) check_in_order(outcome);  // of eval-metrics, whose prediction is none
    }
  }
}

TEST_CASE("resources: where threads are refused, those that there are do the work", "[cli]") {
  if (skip_with_sanitizers()) return;
  const TemporaryFolder folder;
  folder.write("spec.json", kSpec);
  done(folder, "mmg-sim dataset spec.json --quiet --jobs 1 -o one");
  folder.write("many.json", R"({"ship": "vectwin-3m", "sets": [{"name": "a", "runs": [
    {"maneuver": "random", "count": 120, "duration_s": 10}]}]})");
  // A hundred stacks of 8 MB do not fit.
  const Outcome outcome = run(folder, "ulimit -v 400000; mmg-sim dataset many.json --quiet --jobs 100 -o many");
  CAPTURE(outcome.err);
  CHECK(outcome.exit_code == 0);
  done(folder, "mmg-sim dataset many.json --quiet --jobs 1 -o same && diff -r same many");
}

TEST_CASE("resources: more members than there is room for end with one line before anything is done", "[cli][ens]") {
  const TemporaryFolder folder;
  write_ensemble_inputs(folder);
  for (const std::string how : {"", " --member 3", " --resume"}) {
    const Outcome outcome = run(folder, kTrain + "tiny.json --members 1000000000 -o model" + how);
    CAPTURE(outcome.err);
    CHECK((outcome.exit_code == 1 || outcome.exit_code == 4));
    CHECK(std::count(outcome.err.begin(), outcome.err.end(), '\n') == 1);
    CHECK_THAT(outcome.err, Contains("1000000000 members"));
    CHECK_FALSE(std::filesystem::exists(folder / "model"));
  }
}
