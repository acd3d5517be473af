// Trainings that are killed, stopped, displaced or out of disk, and continue.

#include <chrono>

#include <catch2/catch.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/random.hpp"
#include "ensemble.hpp"
#include "io/json.hpp"

using namespace leeway;
using namespace test;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

namespace {

// A training that is long enough to be met in the middle.
void write_long_training(const TemporaryFolder& folder, int epochs) {
  write_ensemble_inputs(folder);
  folder.write("long.json", config(epochs, R"(, "learning_rate_schedule": "cosine")"));
}

std::map<std::string, std::string> results_of(const std::string& folder) {
  auto files = files_of(folder);
  std::erase_if(files, [](const auto& file) { return file.first.starts_with("ensemble.json."); });  // temporary ones
  return files;
}

// Kills a training at random moments and lets it continue; each time that it is done it has the bytes of an undisturbed
// one, and begins anew.
void kill_and_resume(int kills) {
  const TemporaryFolder folder;
  write_long_training(folder, 20);
  const std::string train = kTrain + "long.json --members 2 --jobs 2 --checkpoint-s ";
  const auto start = std::chrono::steady_clock::now();
  done(folder, train + "0 -o undisturbed");
  const double duration_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const auto expected = results_of(folder / "undisturbed");
  REQUIRE(expected.size() == 3);
  RandomStream random(1, "moments of the kills");
  int killed = 0, finished = 0, went_on = 0;
  while (killed < kills || finished == 0) {
    // A short interval spares time between the writes, none at all has nearly all the time spent on them.
    const std::string interval = random.uniform() < 0.5 ? "0" : "0.01";
    const double after_s = killed < kills ? duration_s * random.uniform(0.02, 0.8) : 60.0;
    const Outcome outcome =
        run(folder, fmt::format("{}{} -o killed --resume & pid=$!\n(sleep {:.4f}; kill -9 $pid) 2> errors & killer=$!\n"
                                "wait $pid; code=$?; kill $killer 2> errors; wait; echo $code",
                                train, interval, after_s));
    CAPTURE(killed, finished, outcome.err);
    if (!fs::exists(folder / "killed")) fs::create_directories(folder / "killed");
    for (const auto& [name, text] : files_of(folder / "killed")) {
      if (name.ends_with(".json")) CHECK(io::parse_json(text, name).is_object());
      if (name.ends_with(".checkpoint")) ++went_on;
    }
    if (outcome.out == "137\n") {
      ++killed;
      continue;
    }
    REQUIRE(outcome.out == "0\n");
    REQUIRE(results_of(folder / "killed") == expected);
    fs::remove_all(folder / "killed");
    ++finished;
  }
  CHECK(went_on > kills / 4);
}

// Starts a training in the background as $pid and waits until a member is under way and has a checkpoint.
std::string begun(const std::string& train) {
  return train +
         " & pid=$!\nuntil test -e model/member-00.owner && test -e model/member-00.checkpoint; do kill -0 $pid 2> "
         "errors || exit 98; sleep 0.01; "
         "done\n";
}

}  // namespace

TEST_CASE("ens-train: killed at random moments, it continues to the same bytes", "[cli][ens]") { kill_and_resume(12); }

TEST_CASE("ens-train: killed 300 times at random moments, it continues to the same bytes", "[cli][ens][slow]") {
  kill_and_resume(300);
}

TEST_CASE("ens-train: what a kill leaves half written is removed", "[cli][ens]") {
  const TemporaryFolder folder;
  write_ensemble_inputs(folder);
  done(folder, kTrain + "tiny.json -o whole");
  done(folder, kTrain + "tiny.json -o model --member 0");
  folder.write("model/member-00.checkpoint", "killed between the member's file and the end");
  folder.write("model/member-00.owner", "{}");
  folder.write("model/member-01.json.4711-abcd.tmp", "half a");
  folder.write("model/member-02.checkpoint.4712-abcd.tmp", "");
  done(folder, kTrain + "tiny.json -o model --resume");
  CHECK(files_of(folder / "model") == files_of(folder / "whole"));
}

TEST_CASE("ens-train: SIGTERM, SIGINT and SIGHUP write a checkpoint and say how to continue", "[cli][ens]") {
  const TemporaryFolder folder;
  write_long_training(folder, 6000);
  const std::string train = kTrain + "long.json --members 2 --checkpoint-s 0.1 ";
  done(folder, train + "-o whole");
  for (const std::string signal : {"TERM", "INT", "HUP"}) {
    CAPTURE(signal);
    // A shell without job control starts what is in the background with SIGINT ignored: env puts it back. SIGHUP is
    // ignored where the tests run under nohup.
    const std::string asked = "env --default-signal=INT,HUP " + train + "-o model --resume";
    const Outcome stopped = run(folder, begun(asked) + "kill -" + signal + " $pid; wait $pid; echo $?");
    CHECK(stopped.out == "1\n");
    CHECK(stopped.err == "ens-train: error: stopped by SIG" + signal +
                             "; checkpoints are written. The same command with --resume continues from there\n");
    CHECK(fs::exists(folder / "model/member-00.checkpoint"));
    CHECK_FALSE(fs::exists(folder / "model/member-00.owner"));
    CHECK_THAT(done(folder, "ens-train --status model").out, Contains("interrupted"));
  }
  done(folder, train + "-o model --resume");
  CHECK(results_of(folder / "model") == results_of(folder / "whole"));
}

TEST_CASE("ens-train: under nohup a training outlives SIGHUP", "[cli][ens]") {
  const TemporaryFolder folder;
  write_long_training(folder, 100000);
  const std::string asked = "nohup " + kTrain + "long.json --members 1 --checkpoint-s 0.1 -o model";
  const Outcome stopped = run(folder, begun(asked) + "kill -HUP $pid; sleep 0.5; kill -TERM $pid; wait $pid; echo $?");
  CHECK(stopped.out == "1\n");
  CHECK_THAT(stopped.err, Contains("stopped by SIGTERM"));
}

TEST_CASE("ens-train: a full disk keeps the last good checkpoint", "[cli][ens]") {
  const TemporaryFolder folder;
  write_long_training(folder, 100);
  const std::string train = kTrain + "long.json --members 1 ";
  done(folder, train + "-o whole");
  run(folder, begun(kTrain + "long.json --members 1 --checkpoint-s 0 -o model") + "kill -9 $pid; wait $pid");
  const std::string good = io::read_text(folder / "model/member-00.checkpoint");
  // No file may grow beyond 1 kB: that of the owner fits, no checkpoint does.
  const Outcome full = run(folder,
                           "ulimit -f 2; ens-train data/dataset.json#train --config long.json --members 1 "
                           "--checkpoint-s 0 -o model --resume 2> errors; code=$?; cat errors; exit $code");
  CHECK(full.exit_code == 4);
  CHECK_THAT(full.out,
             Contains("warning: model/member-00.checkpoint: cannot be written: File too large; training continues"));
  CHECK_THAT(full.out, Contains("ens-train: error: model/member-00.json: cannot be written: File too large"));
  CHECK(io::read_text(folder / "model/member-00.checkpoint") == good);
  CHECK(files_of(folder / "model").size() == 2);
  done(folder, train + "-o model --resume");
  CHECK(files_of(folder / "model") == files_of(folder / "whole"));
}

TEST_CASE("ens-train: a file system without room keeps the last good checkpoint", "[cli][ens]") {
  const TemporaryFolder folder;
  write_long_training(folder, 100);
  fs::create_directories(folder / "disk");
  const std::string train = kTrain + "long.json --members 1 ";
  done(folder, train + "-o whole");
  // Mounted in a name space of its own, the small disk goes with the shell.
  const std::string on_small_disk = R"(unshare --mount sh -c '
    mount -t tmpfs -o size=256k tmpfs disk || exit 97
    mkdir disk/model && ln -sfn disk/model model
    )" + begun(kTrain + "long.json --members 1 --checkpoint-s 0 -o model") +
                                    R"(
    kill -9 $pid; wait $pid
    rm -f disk/model/*.tmp  # half a file of the killed run, which the next one removes: room for its own
    cp model/member-00.checkpoint good
    cat /dev/zero > disk/others 2> errors
    )" + train + R"(--checkpoint-s 0 -o model --resume 2> said; echo $?
    cmp model/member-00.checkpoint good && rm disk/others && )" +
                                    train + "-o model --resume && cp -r disk/model saved'";
  const Outcome outcome = run(folder, on_small_disk);
  if (outcome.exit_code == 97 || outcome.err.find("unshare") != std::string::npos) {
    WARN("SKIPPED: this user may not mount a small disk");
    return;
  }
  CAPTURE(outcome.err, io::read_text(folder / "said"));
  CHECK(outcome.exit_code == 0);
  CHECK(outcome.out == "4\n");
  CHECK_THAT(io::read_text(folder / "said"), Contains("No space left on device"));
  CHECK(results_of(folder / "saved") == results_of(folder / "whole"));
}

TEST_CASE("ens-train: held-out recordings are evaluated and change nothing", "[cli][ens]") {
  const TemporaryFolder folder;
  write_ensemble_inputs(folder);
  done(folder, kTrain + "tiny.json -o without");
  const std::string train = "ens-train data/dataset.json#train --config tiny.json -o with ";
  CHECK_THAT(done(folder, train + "--held-out data/test/*.csv").err, Contains(" held-out "));
  CHECK(files_of(folder / "with") == files_of(folder / "without"));
  CHECK_THAT(done(folder, train + "--held-out data/dataset.json").err,
             Contains("warning: data/dataset.json: holds out all its sets (test, train)"));
  check_refused(folder, train + "--held-out none-such.csv", 4, "none-such.csv: cannot be opened");
  folder.write("rec.csv", "t_s,u_mps,vm_mps,r_degps\n0,1,0,0\n1,1,0,0\n");
  check_refused(folder, train + "--held-out rec.csv", 3, "rec.csv:1: no wind: expected the columns wind_speed_mps");
}

TEST_CASE("ens-train --status: reads a training that runs, was killed, or is done", "[cli][ens]") {
  const TemporaryFolder folder;
  write_long_training(folder, 100000);
  const std::string train = kTrain + "long.json --members 2 --jobs 1 --checkpoint-s 0.1 --held-out data/test/*.csv ";
  const Outcome running = run(folder, begun(train + "-o model") +
                                          "sleep 0.3; ens-train --status model; code=$?; kill -9 $pid; wait $pid; "
                                          "ens-train --status model; exit $code");
  CAPTURE(running.out);
  CHECK(running.exit_code == 0);
  CHECK_THAT(running.out, Contains("00      training ") && Contains("/100000") && Contains(" on "));
  CHECK_THAT(running.out, Contains("01      waiting ") && Contains("model: 1 training, 1 waiting of 2 members\n"));
  CHECK_THAT(running.out,
             Contains("00      interrupted") && Contains("model: 1 interrupted, 1 waiting of 2 members\n"));
  done(folder, kTrain + "tiny.json -o whole");
  CHECK_THAT(done(folder, "ens-train --status whole").out, Contains("03      trained               6/6"));
  check_refused(folder, "ens-train rec.csv --status whole -o out", 2, "--status stands alone");
  check_refused(folder, "ens-train --status none-such", 4, "none-such/ensemble.json: cannot be opened");
}

TEST_CASE("ens-train: two processes that train one member are noticed", "[cli][ens]") {
  const TemporaryFolder folder;
  write_long_training(folder, 100000);
  const std::string train = kTrain + "long.json --members 2 --jobs 1 --checkpoint-s 0.1 -o model ";
  const auto while_running = [&](const std::string& command) {
    return run(folder, begun(train) + command + "; code=$?; kill -9 $pid 2> errors; wait $pid; echo $?; exit $code");
  };
  for (const std::string other : {"--resume", "--member 0", ""}) {
    CAPTURE(other);
    fs::remove_all(folder / "model");
    const Outcome second = while_running(train + other);
    CHECK(second.exit_code == 4);
    CHECK(second.out == "137\n");  // the first went on until it was killed
    CHECK_THAT(second.err, Contains("model/member-00.owner: process ") && Contains("trains this member"));
  }
  // Another machine that shares the folder takes the member: the first process stops by itself.
  fs::remove_all(folder / "model");
  const Outcome displaced = run(folder, begun(train) + R"(
      echo '{"host": "elsewhere", "pid": 7, "process_start": 1, "token": "0123", "epochs_done": 3, "loss": 12.5,
             "held_out_loss": null, "seconds_left": 100}' > taken && mv taken model/member-00.owner
      wait $pid; echo $?; ens-train --status model)");
  CHECK_THAT(displaced.out, Catch::Matchers::StartsWith("4\n"));
  CHECK_THAT(displaced.out, Contains("00      training         3/100000      12.5") && Contains("7 on elsewhere"));
  CHECK(displaced.err ==
        "ens-train: error: model/member-00.owner: process 7 on elsewhere has taken this member over; this process "
        "stops training it\n");
}
