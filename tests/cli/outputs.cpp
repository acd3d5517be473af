// Inputs are never written over, by any tool, however a path is spelled.

#include <filesystem>

#include "ensemble.hpp"

using namespace leeway;
using namespace test;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

namespace {

// Everything below a folder, by path.
std::map<std::string, std::string> all_files(const TemporaryFolder& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder.path()))
    if (entry.is_regular_file()) files[entry.path().string()] = io::read_text(entry.path().string());
  return files;
}

void check_nothing_written(const TemporaryFolder& folder, const std::string& command, const std::string& message) {
  const auto before = all_files(folder);
  check_refused(folder, command, 2, message);
  CHECK(all_files(folder) == before);
}

// A model, recordings, a ship and an effect, under the names that the tools give their results.
void write_inputs(const TemporaryFolder& folder) {
  prepare_model(folder);
  done(
      folder,
      "mmg-sim zigzag --ship esso-osaka-3m --duration-s 60 --quiet -o esso.csv && mkdir out && cp esso.csv "
      "out/esso.residual.csv && "
      "cp data/test/test-t20.csv keep.csv && cp \"$(dirname $(command -v mmg-sim))\"/../share/leeway/configs/"
      "ships/esso-osaka-3m.json out/ship.json && cp -L out/ship.json ship.json && cp tiny.json model/member-77.json && "
      "cp ship.json model/base-ship.json");
  folder.write("effect.json", R"({"type": "steady-current", "current_speed_mps": 0.1, "current_set_deg": 30})");
  folder.write("map.json", R"({"t_s": "t_s"})");
}

}  // namespace

TEST_CASE("outputs: no tool writes over what it reads", "[cli][errors]") {
  const TemporaryFolder folder;
  write_inputs(folder);
  // A new tool, or a new output, is a line here.
  for (const std::string command :
       {"ens-predict model keep.csv -o .",
        "ens-predict --baseline hold keep.csv -o .",

        "ens-predict model data/dataset.json#test -o data/test",
        "ens-predict model data/dataset.json#test -o data/test/truth",
        "ens-predict model keep.csv -o - >> keep.csv",
        "mmg-sim replay --ship vectwin-3m keep.csv --restart-steps 20 --prediction -o .",
        "mmg-sim replay --ship vectwin-3m keep.csv -o keep.csv",
        "mmg-sim replay --ship vectwin-3m keep.csv --truth ./keep.csv",
        "mmg-sim replay --ship vectwin-3m - --indices keep.csv < keep.csv",
        "mmg-sim show ship.json -o ship.json",
        "mmg-sim zigzag --ship ship.json --duration-s 20 -o ship.json",
        "mmg-sim zigzag --ship ship.json --effect effect.json --duration-s 20 -o effect.json",
        "eval-metrics keep.csv --truth keep.csv -o keep.csv",
        "eval-metrics esso.csv --truth data/dataset.json --per-step data/dataset.json",
        "pd-sweep model --ship vectwin-3m --kp 5 --kd 5 --particles 1 -o model/ensemble.json",
        "pd-sweep model --ship ship.json --kp 5 --kd 5 --particles 1 -o ship.json",
        "ens-train keep.csv --config tiny.json --base model/base-ship.json -o model",
        "ens-train keep.csv --config model/member-77.json -o model",
        "gap-locate --ship out/ship.json out/esso.residual.csv esso.csv -o out",
        "gap-locate --ship esso-osaka-3m esso.csv -o out --write-corrected .",
        "gap-locate --model model keep.csv -o out --write-corrected .",
        "gap-explain --ship out/ship.json esso.csv -o out"}) {
    CAPTURE(command);
    check_nothing_written(folder, command, "no input is written over");
  }
  folder.write("again/dataset.json", kSpec);
  check_nothing_written(folder, "mmg-sim dataset again/dataset.json -o again", "no input is written over");
}

TEST_CASE("outputs: links and other spellings of an input are the input", "[cli][errors]") {
  const TemporaryFolder folder;
  write_inputs(folder);
  fs::create_symlink("keep.csv", folder / "soft.csv");
  fs::create_hard_link(folder / "keep.csv", folder / "hard.csv");
  fs::create_directory_symlink(".", folder / "here");
  const std::string replay = "mmg-sim replay --ship vectwin-3m ";
  for (const std::string output : {"soft.csv", "hard.csv", "here/keep.csv", "data/../keep.csv", ".//keep.csv",
                                   "\"$PWD\"/keep.csv", "/proc/self/cwd/keep.csv"}) {
    CAPTURE(output);
    check_nothing_written(folder, replay + "keep.csv -o " + output, "no input is written over");
  }
  check_nothing_written(folder, replay + "soft.csv -o keep.csv", "keep.csv: is also the input soft.csv");
}

TEST_CASE("outputs: two outputs of one run do not go to one file", "[cli][errors]") {
  const TemporaryFolder folder;
  write_inputs(folder);
  fs::create_symlink("later.csv", folder / "link.csv");
  for (const std::string outputs :
       {"--truth x.csv -o x.csv", "--truth ./x.csv -o x.csv", "--truth link.csv -o later.csv",
        "--indices new/../x.csv --truth x.csv -o y.csv", "--truth esso.csv -o - >> esso.csv"}) {
    CAPTURE(outputs);
    check_nothing_written(folder, "mmg-sim zigzag --ship vectwin-3m --duration-s 20 " + outputs, "");
  }
  check_nothing_written(folder, "mmg-sim zigzag --ship vectwin-3m --duration-s 20 --truth x.csv -o x.csv",
                        "x.csv: two outputs go to one file (x.csv)");
  folder.write("rec.csv", "t_s,u_mps,vm_mps,r_degps\n0,1,0,0\n1,1,0,0\n");
  done(folder, "ens-predict --baseline hold rec.csv --steps 2 --quiet -o pred.csv");
  check_nothing_written(folder, "eval-metrics pred.csv/rec.csv --truth rec.csv -o x --per-step ./x",
                        "two outputs go to one file");
}

TEST_CASE("outputs: devices, pipes and an old result are written as ever", "[cli]") {
  const TemporaryFolder folder;
  const std::string run = "mmg-sim zigzag --ship vectwin-3m --duration-s 20 --quiet ";
  done(folder, run + "--truth /dev/null --indices /dev/null -o /dev/null");
  done(folder, run + "--truth x.csv -o y.csv && cp y.csv first.csv && " + run + "--truth x.csv -o y.csv");
  CHECK(io::read_text(folder / "y.csv") == io::read_text(folder / "first.csv"));
  CHECK_THAT(done(folder, "mmg-sim replay --ship vectwin-3m - -o - < x.csv | cat").out, Contains("t_s,"));
}
