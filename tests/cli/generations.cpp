// Files of two runs never stand beside each other as one result, wherever a run is killed.

#include <chrono>
#include <fcntl.h>
#include <filesystem>
#include <set>
#include <sys/file.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "core/random.hpp"
#include "ensemble.hpp"
#include "io/json.hpp"

using namespace leeway;
using namespace test;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

namespace {

const std::string kManySpec = R"({"ship": "vectwin-3m", "noise": "paper-model-scale", "sets": [
  {"name": "one", "runs": [{"maneuver": "random", "count": 12, "duration_s": 30}]},
  {"name": "two", "runs": [{"maneuver": "random", "count": 3, "duration_s": 30}]}]})";
const std::string kFewSpec = R"({"ship": "vectwin-3m", "sets": [
  {"name": "one", "runs": [{"maneuver": "random", "count": 2, "duration_s": 30}]}]})";

std::set<std::string> names_in(const std::string& folder) {
  std::set<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) names.insert(fs::relative(entry.path(), folder).string());
  return names;
}

// Where there is an index, its parts are those that it hashed, and nothing else lies there.
bool has_whole_generation(const std::string& folder, const std::string& index) {
  const std::string path = folder + "/" + index;
  if (!fs::exists(path)) return false;
  std::set<std::string> expected{index};
  const io::Json json = io::read_json(path);
  for (const auto& [name, hash] : json.at("parts").items()) {
    CAPTURE(folder, name);
    CHECK(io::sha256_of_file(folder + "/" + name) == hash);
    expected.insert(name);
  }
  std::set<std::string> found = names_in(folder);
  std::erase_if(found, [&](const std::string& name) {  // between the index and the end
    return name == index + ".unfinished" || name.ends_with(".tmp");
  });
  CHECK(found == expected);
  return true;
}

// Runs a command in turn with two settings over one folder and kills it at random moments: the folder holds a whole
// generation or no index, and the run after it leaves what a run in an empty folder leaves.
void kill_and_run_again(const TemporaryFolder& folder, const std::string& command, const std::string& more,
                        const std::string& output, const std::string& index, int kills) {
  done(folder, command + more + " -o fresh");
  const auto start = std::chrono::steady_clock::now();
  done(folder, command + " -o " + output);
  const double duration_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  RandomStream random(1, "moments of the kills");
  int whole = 0;
  for (int i = 0; i < kills; ++i) {
    // The last one ends, on a busy machine as well.
    const double after_s = duration_s * (i + 1 < kills ? random.uniform(0.0, 1.1) : 5.0);
    const Outcome outcome =
        run(folder, fmt::format("{}{} -o {} & pid=$!\n(sleep {:.4f}; kill -9 $pid) 2> errors & killer=$!\n"
                                "wait $pid; kill $killer 2> errors; wait",
                                command, i % 2 == 0 ? more : "", output, after_s));
    CAPTURE(i, after_s, outcome.err);
    whole += has_whole_generation(folder / output, index) ? 1 : 0;
  }
  CHECK(whole > 0);
  done(folder, command + more + " -o " + output);
  CHECK(has_whole_generation(folder / output, index));
  CHECK(names_in(folder / output) == names_in(folder / "fresh"));
  CHECK(io::read_json(folder / (output + "/" + index)).at("parts") ==
        io::read_json(folder / ("fresh/" + index)).at("parts"));
}

std::string temporary_name(const std::string& output, const std::string& machine) {
  return output + "." + machine + "-0123abcd.tmp";
}

std::string this_machine() {
  char name[256] = {};
  REQUIRE(::gethostname(name, sizeof name - 1) == 0);
  return io::sha256(name).substr(0, 8);
}

}  // namespace

TEST_CASE("generations: a data set that is killed and made again is one or the other", "[cli]") {
  const TemporaryFolder folder;
  folder.write("many.json", kManySpec);
  kill_and_run_again(folder, "mmg-sim dataset many.json --quiet", " --seed 2", "out", "dataset.json", 30);
}

TEST_CASE("generations: predictions that are killed and made again are one or the other", "[cli][ens]") {
  const TemporaryFolder folder;
  prepare_model(folder);
  kill_and_run_again(folder, "ens-predict model data/dataset.json --particles 200 --quiet", " --seed 2", "out",
                     "prediction.json", 15);
  kill_and_run_again(folder,
                     "mmg-sim replay --ship vectwin-3m data/dataset.json --prediction --restart-steps 20 --quiet",
                     " --hold", "replayed", "prediction.json", 10);
}

TEST_CASE("generations: a report that is killed and made again is one or the other", "[cli][long][gap]") {
  const TemporaryFolder folder;
  done(folder, "mmg-sim zigzag --ship esso-osaka-3m --duration-s 100 --noise paper-model-scale --quiet -o rec.csv");
  kill_and_run_again(folder, "gap-locate --ship esso-osaka-3m rec.csv --quiet", " --seed 2", "out", "locate.json", 6);
}

TEST_CASE("generations: what an earlier run wrote and this one does not goes, and nothing else", "[cli]") {
  const TemporaryFolder folder;
  folder.write("many.json", kManySpec);
  folder.write("few.json", kFewSpec);
  done(folder, "mmg-sim dataset many.json --quiet -o out");
  folder.write("out/one/mine.csv", "by hand");
  folder.write("out/two/two-r-02.csv", "edited");
  done(folder, "mmg-sim dataset few.json --quiet -o out");
  CHECK(names_in(folder / "out") == std::set<std::string>{"dataset.json", "one/mine.csv", "one/one-r-01.csv",
                                                          "one/one-r-02.csv", "one/truth/one-r-01.csv",
                                                          "one/truth/one-r-02.csv", "two/two-r-02.csv"});
  // An index that names what lies elsewhere makes nobody remove it.
  folder.write("keep.txt", "kept");
  folder.write("out/dataset.json",
               R"({"sets": [], "parts": {"../keep.txt": null, ")" + (folder / "keep.txt") + R"(": null}})");
  done(folder, "mmg-sim dataset few.json --quiet -o out");
  CHECK(io::read_text(folder / "keep.txt") == "kept");
}

TEST_CASE("generations: a run that fails leaves no half of its results", "[cli]") {
  const TemporaryFolder folder;
  folder.write("many.json", kManySpec);
  // Files beyond 2 kB cannot be written: the list of the run can, the index cannot.
  const Outcome full = run(folder, "ulimit -f 4; mmg-sim dataset many.json --quiet -o out");
  CHECK(full.exit_code == 4);
  CHECK(names_in(folder / "out").empty());
}

TEST_CASE("generations: recordings that are not those of the index are refused", "[cli][errors]") {
  const TemporaryFolder folder;
  folder.write("few.json", kFewSpec);
  done(folder,
       "mmg-sim dataset few.json --quiet -o data && mmg-sim dataset few.json --seed 2 --quiet -o other && cp "
       "other/one/one-r-02.csv data/one/");
  check_refused(folder, "ens-predict --baseline hold data/dataset.json --steps 10 -o -", 3,
                "data/one/one-r-02.csv: is not the file that data/dataset.json names");
}

TEST_CASE("generations: a run that fails over results of its kind leaves them whole, or none", "[cli][ens]") {
  const TemporaryFolder folder;
  const auto recording = [&](const std::string& name, int rows) {
    std::string text = "t_s,u_mps,vm_mps,r_degps\n";
    for (int i = 0; i < rows; ++i) text += fmt::format("{},1,0,0\n", i);
    folder.write(name, text);
  };
  recording("a.csv", 4);
  recording("b.csv", 400);
  const std::string predict = "ens-predict --baseline hold a.csv b.csv --steps 2 --jobs 1 --quiet -o pred";
  done(folder, predict);
  CHECK(run(folder, "ulimit -f 16; " + predict).exit_code == 4);  // 8 kB, beyond which b.csv is
  CHECK(names_in(folder / "pred") == std::set<std::string>{"a.csv", "b.csv", "prediction.json"});
  CHECK(has_whole_generation(folder / "pred", "prediction.json"));
  recording("a.csv", 6);  // what the run writes before it fails is another
  CHECK(run(folder, "ulimit -f 16; " + predict).exit_code == 4);
  CHECK(names_in(folder / "pred").empty());
}

TEST_CASE("generations: a folder that a living run writes is no other run's", "[cli]") {
  const TemporaryFolder folder;
  folder.write("few.json", kFewSpec);
  done(folder, "mmg-sim dataset few.json --quiet -o out");
  const std::string unfinished = folder.write("out/dataset.json.unfinished", "{}");
  const int lock = ::open(unfinished.c_str(), O_RDWR | O_CLOEXEC);
  REQUIRE(::flock(lock, LOCK_EX | LOCK_NB) == 0);
  check_refused(folder, "mmg-sim dataset few.json --seed 2 -o out", 4,
                "out/dataset.json.unfinished: another run is writing this folder");
  ::close(lock);
  done(folder, "mmg-sim dataset few.json --seed 2 --quiet -o out");
  CHECK(has_whole_generation(folder / "out", "dataset.json"));
}

TEST_CASE("generations: where the main output cannot be written, nothing else is", "[cli]") {
  const TemporaryFolder folder;
  folder.write("rec.csv", "t_s,u_mps,vm_mps,r_degps\n0,1,0,0\n1,1,0,0\n");
  done(folder, "mkdir taken && ens-predict --baseline hold rec.csv --steps 2 --quiet -o pred.csv");
  check_refused(folder, "eval-metrics pred.csv/rec.csv --truth rec.csv --per-step s.csv -o taken", 4,
                "taken: is a folder");
  check_refused(folder, "mmg-sim zigzag --ship vectwin-3m --duration-s 5 --truth s.csv -o taken", 4,
                "taken: is a folder");
  CHECK_FALSE(fs::exists(folder / "s.csv"));
  check_refused(folder, "mmg-sim turning --ship vectwin-3m --duration-s 5 --truth taken --indices i.json -o a.csv", 4,
                "taken: is a folder");
  CHECK_FALSE(fs::exists(folder / "i.json"));
}

TEST_CASE("generations: predictions of one model and options may come one by one, others are replaced", "[cli][ens]") {
  const TemporaryFolder folder;
  prepare_model(folder);
  const std::string predict = "ens-predict model --particles 3 --quiet -o pred ";
  const std::string score = "eval-metrics pred --truth data/dataset.json --quiet -o ";
  const auto parts = [&] { return io::read_json(folder / "pred/prediction.json").at("parts").size(); };
  done(folder, predict + "data/test/test-t20.csv");
  done(folder, predict + "data/test/test-r-01.csv");
  CHECK(parts() == 2);
  done(folder, score + "two.json");
  done(folder, predict + "data/test/test-r-01.csv --sampling ts1");
  CHECK(names_in(folder / "pred") == std::set<std::string>{"prediction.json", "test-r-01.csv"});
  done(folder, "cp pred/test-r-01.csv kept.csv && cp pred/prediction.json kept.json");
  done(folder, "echo >> pred/test-r-01.csv");
  check_refused(folder, score + "m.json", 3, "pred/test-r-01.csv: is not the file that pred/prediction.json names");
  done(folder, "cp kept.csv pred/test-r-01.csv && cp kept.csv pred/other.csv");
  check_refused(folder, score + "m.json", 3, "pred/other.csv: is not of the run that pred/prediction.json tells of");
  done(folder, "rm pred/other.csv && mv pred/prediction.json pred/prediction.json.unfinished");
  check_refused(folder, score + "m.json", 3, "pred/prediction.json.unfinished: the run that writes this folder is not");
  done(folder, predict + "data/test/test-r-01.csv --sampling ts1 && cmp kept.json pred/prediction.json");
}

TEST_CASE("generations: sweep and trajectories are of one run", "[cli][ens]") {
  const TemporaryFolder folder;
  prepare_model(folder);
  const std::string sweep =
      "pd-sweep model --ship vectwin-3m --particles 2 --duration-s 20 --quiet --trajectories runs ";
  done(folder, sweep + "--kp 20,40 --kd 20 -o sweep.csv");
  done(folder, sweep + "--kp 30 --kd 20 -o sweep.csv");
  CHECK(names_in(folder / "runs") == std::set<std::string>{"kp30_kd20.csv", "trajectories.json"});
  CHECK(has_whole_generation(folder / "runs", "trajectories.json"));
  // What fails in the middle leaves no main output of the run before.
  fs::create_directories(folder / "blocked.csv");
  CHECK(run(folder, "rm -r runs && touch runs && " + sweep + "--kp 30 --kd 20 -o sweep.csv").exit_code == 4);
  CHECK_FALSE(fs::exists(folder / "sweep.csv"));
}

TEST_CASE("generations: a training over what a killed one left begins anew", "[cli][ens]") {
  const TemporaryFolder folder;
  prepare_model(folder);
  done(folder, kTrain + "tiny.json --seed 2 --members 2 -o other && cp -r other again");
  // Killed between the index and the members.
  done(folder, "rm other/ensemble.json && cp model/member-03.json other/ && echo half > other/member-01.json");
  done(folder, kTrain + "tiny.json --seed 2 --members 2 -o other");
  CHECK(files_of(folder / "other") == files_of(folder / "again"));
}

TEST_CASE("generations: temporary files of killed runs are cleared up, those of living ones are not", "[cli]") {
  const TemporaryFolder folder;
  const std::string dead = temporary_name("x.csv", this_machine()), old = temporary_name("old.csv", "00000000"),
                    elsewhere = temporary_name("x.csv", "00000001"), alive = temporary_name("y.csv", this_machine());
  for (const std::string& name : {dead, old, elsewhere, alive}) folder.write(name, "half");
  folder.write("notes.0123.tmp", "by hand");
  fs::last_write_time(folder / old, fs::file_time_type::clock::now() - std::chrono::hours(48));
  const int lock = ::open((folder / alive).c_str(), O_RDWR | O_CLOEXEC);
  REQUIRE(::flock(lock, LOCK_EX | LOCK_NB) == 0);
  done(folder, "mmg-sim zigzag --ship vectwin-3m --duration-s 10 --quiet -o x.csv");
  ::close(lock);
  CHECK(names_in(folder.path().string()) ==
        std::set<std::string>{"x.csv", "x.csv.provenance.json", elsewhere, alive, "notes.0123.tmp"});
}
