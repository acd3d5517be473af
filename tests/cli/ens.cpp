#include <algorithm>
#include <filesystem>
#include <map>
#include <set>

#include <catch2/catch.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "ensemble.hpp"
#include "io/json.hpp"

using namespace leeway;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;
using namespace test;

namespace {

// Fields of a CSV without quotation marks, one row after the other; the first is the header.
std::vector<std::vector<std::string>> rows_of(const std::string& text) {
  std::vector<std::vector<std::string>> rows;
  std::string field;
  bool line_begins = true;
  for (const char c : text) {
    if (line_begins) rows.emplace_back();
    line_begins = c == '\n';
    if (c == ',' || c == '\n') {
      rows.back().push_back(field);
      field.clear();
    } else {
      field += c;
    }
  }
  return rows;
}

std::size_t column(const std::vector<std::string>& header, const std::string& name) {
  const auto at = std::find(header.begin(), header.end(), name);
  REQUIRE(at != header.end());
  return static_cast<std::size_t>(at - header.begin());
}

}  // namespace

TEST_CASE("ens: a recording from a pipe has no hash rather than a wrong one", "[cli][ens]") {
  const TemporaryFolder folder;
  write_ensemble_inputs(folder);
  done(folder, "cat data/train/*.csv | head -45 | ens-train - --quiet --members 1 --config tiny.json -o model");
  const io::Json header = io::read_json(folder / "model/ensemble.json");
  CHECK(header["training"]["files"][0]["sha256"] == "");
  CHECK(header["provenance"]["inputs"][0]["sha256"] == "");
}

TEST_CASE("ens: from maneuvers to scores, through a folder and through a pipe", "[cli][ens]") {
  const TemporaryFolder folder;
  prepare_model(folder);
  const Outcome through_folder =
      done(folder,
           "ens-predict model 'data/dataset.json#test' --particles 30 -o prediction && eval-metrics prediction "
           "--truth data/dataset.json");
  CHECK_THAT(through_folder.err, Contains("ens-predict: info: prediction: 4 sequences; 12 of 92 s"));
  const Outcome through_pipe =
      done(folder,
           "ens-predict model 'data/dataset.json#test' --particles 30 --jobs 1 -o - | eval-metrics - --truth "
           "data/dataset.json");
  const io::Json a = io::parse_json(through_folder.out, "stdout"), b = io::parse_json(through_pipe.out, "stdout");
  CHECK(a["datasets"] == b["datasets"]);
  CHECK(a["overall"] == b["overall"]);
  CHECK(a["overall"]["sequences"] == 4);
  CHECK(a["overall"]["members"] == 4);
  CHECK(a["overall"]["sampling"] == "ts-inf");
  CHECK(a["overall"]["L_maha"].is_number());
  CHECK(files_of(folder / "prediction").size() == 3);
  const io::Json about = io::parse_json(io::read_text(folder / "prediction/prediction.json"), "prediction.json");
  CHECK(about["particles_out_of_bounds"] == 0);
  CHECK(about["provenance"]["inputs"].size() == 2);
}

TEST_CASE("ens-train: the same bytes with one thread or two, and member by member", "[cli][ens]") {
  const TemporaryFolder folder;
  write_ensemble_inputs(folder);
  done(folder, kTrain + "tiny.json -o one --jobs 1");
  done(folder, kTrain + "tiny.json -o two --jobs 2");
  for (const int member : {2, 0, 3, 1}) done(folder, kTrain + fmt::format("tiny.json -o single --member {}", member));
  const auto one = files_of(folder / "one");
  CHECK(one.size() == 5);
  CHECK(one.contains("ensemble.json"));
  CHECK(one.contains("member-03.json"));
  CHECK(one == files_of(folder / "two"));
  CHECK(one == files_of(folder / "single"));
  done(folder, kTrain + "tiny.json -o another --seed 2");
  CHECK(one.at("member-00.json") != files_of(folder / "another").at("member-00.json"));
  // A member that exists is kept; more members can be added later, and do not change those before them.
  done(folder, kTrain + "tiny.json -o two --members 5 --resume");
  auto five = files_of(folder / "two");
  CHECK(five.size() == 6);
  for (const std::string name : {"member-00.json", "member-03.json"}) CHECK(five.at(name) == one.at(name));
}

TEST_CASE("ens-train: a checkpoint of any epoch continues to the same bytes", "[cli][ens]") {
  const TemporaryFolder folder;
  write_ensemble_inputs(folder);
  done(folder, kTrain + "tiny.json --members 1 -o whole");
  // The kill comes as soon as there is a checkpoint: training has begun and not ended.
  const Outcome killed = run(folder, kTrain +
                                         "tiny.json --epochs 100000 --members 1 --checkpoint-s 0 -o part & pid=$!\n"
                                         "until test -e part/member-00.checkpoint; do kill -0 $pid || exit; sleep "
                                         "0.01; done\nkill -9 $pid; wait $pid; echo $?");
  CHECK(killed.out == "137\n");
  CHECK_FALSE(std::filesystem::exists(folder / "part/member-00.json"));
  check_refused(folder, "ens-predict part 'data/dataset.json#test'", 4, "part/member-00.json: is not trained yet");
  // Another number of epochs is another training.
  for (const std::string resume : {" --resume", ""})
    check_refused(folder, kTrain + "tiny.json --members 1 -o part" + resume, 2,
                  "holds an ensemble of other data, settings or seed: epochs: expected 6, found 100000; choose another "
                  "folder with -o, or remove 'part' first");
  // The same training begins anew without --resume.
  done(folder, "rm -r part && cp -r whole part && echo half > part/member-00.json");
  done(folder, kTrain + "tiny.json --members 1 -o part");
  auto begun_anew = files_of(folder / "part");
  std::erase_if(begun_anew, [](const auto& file) { return file.first.starts_with("ensemble.json."); });
  CHECK(begun_anew == files_of(folder / "whole"));
}

TEST_CASE("ens-train: files of another training are refused", "[cli][ens]") {
  const TemporaryFolder folder;
  prepare_model(folder);
  done(folder, kTrain + "tiny.json -o other --seed 7");
  for (const std::string settings : {"--seed 3", "--epochs 7", "--no-initial-state-net"}) {
    check_refused(folder, kTrain + "tiny.json -o model --resume " + settings, 2, "model holds an ensemble of other");
    check_refused(folder, kTrain + "tiny.json -o model --member 1 " + settings, 2, "model holds an ensemble of other");
    check_refused(folder, kTrain + "tiny.json -o model " + settings, 2, "or remove 'model' first");
  }
  const auto before = files_of(folder / "model");
  check_refused(folder, kTrain + "tiny.json -o model --seed 3 --epochs 7", 2,
                "epochs: expected 7, found 6; seed: expected 3, found 1; choose another folder");
  check_refused(folder, kTrain + "tiny.json -o model --no-initial-state-net", 2,
                "initial_state_net: expected false, found true");
  check_refused(folder, "ens-train data/train/train-r-01.csv --config tiny.json -o model --resume", 2,
                "recordings found and not expected: train-r-02");
  check_refused(folder, "ens-train data/dataset.json#test --config tiny.json -o model", 2,
                "recordings expected and not found: test-r-01");
  done(folder, "cp -r data/train copied && sed -i '$d' copied/train-r-01.csv");
  check_refused(folder, "ens-train copied/*.csv --config tiny.json -o model", 2,
                "recordings of other contents: train-r-01 (SHA-256 expected ");
  CHECK(files_of(folder / "model") == before);
  std::filesystem::copy_file(folder / "other/member-02.json", folder / "model/member-02.json",
                             std::filesystem::copy_options::overwrite_existing);
  check_refused(folder, "ens-predict model 'data/dataset.json#test'", 3,
                "model/member-02.json: belongs to another training");
  check_refused(folder, kTrain + "tiny.json -o model --resume", 3, "model/member-02.json: belongs to another training");
  done(folder, "ens-predict model 'data/dataset.json#test' --use-members 2");
}

TEST_CASE("ens-train: data that cannot train anything end with 3", "[cli][ens]") {
  const TemporaryFolder folder;
  write_ensemble_inputs(folder);
  const std::string header = "t_s,u_mps,vm_mps,r_degps,psi_deg,delta_deg\n";
  const auto refused = [&](const std::string& rows, const std::string& message) {
    folder.write("rec.csv", header + rows);
    check_refused(folder, "ens-train rec.csv --config tiny.json -o model", 3, message);
    CHECK_FALSE(std::filesystem::exists(folder / "model"));
  };
  refused("0,1,0,0,0,0\n0.4,1.1,0.1,0.1,0,5\n", "rec.csv: too little data: no stretch of two points 1 s apart");
  std::string still, straight, varied;
  for (int k = 0; k < 30; ++k) {
    still += fmt::format("{},{},{},{},0,5\n", k, 1 + 0.01 * k * k, 0.1 * (k % 3), 0.2 * (k * k % 7));
    straight += fmt::format("{},{},0,{},0,{}\n", k, 1 + 0.01 * k * k, 0.2 * (k * k % 7), k % 5);
    if (k < 4) varied += fmt::format("{},{},{},{},0,{}\n", k, 1 + 0.01 * k * k, 0.1 * (k % 3), 0.2 * (k * k % 7), k);
  }
  refused(still, "rec.csv: no actuator column varies and there is no wind");
  refused(straight, "rec.csv: 'vm_mps' never varies in the training data");
  refused(varied, "rec.csv: too little data: no stretch has the 5 points of 1 s that the initial-state network sees");
  folder.write("varied.csv", header + varied);  // read after the other, by its name
  check_refused(folder, "ens-train data/train/train-r-01.csv varied.csv --config tiny.json -o model", 3,
                "data/train/train-r-01.csv:1: no column 'delta_deg', which is needed here");
  // A recording shorter than a window trains with the length that it has.
  folder.write("rec.csv", header + varied);
  done(folder, "ens-train rec.csv --config tiny.json --no-initial-state-net --epochs 1 --members 1 -o model");
  // What cannot be calibrated in the end is not trained first.
  check_refused(folder, "ens-train rec.csv --config honest --epochs 1 -o calibrated", 3,
                "expected at least two, got 1");
  CHECK_FALSE(std::filesystem::exists(folder / "calibrated"));
}

TEST_CASE("ens-train: a loss that diverges ends with 1 and leaves no member", "[cli][ens]") {
  const TemporaryFolder folder;
  write_ensemble_inputs(folder);
  replace(folder / "tiny.json", "1e-3", "1e37");
  check_refused(folder, kTrain + "tiny.json -o model --jobs 2", 1,
                "the loss is no finite number in epoch 1: training diverged. Lower learning_rate (now 1e+37)");
  CHECK(files_of(folder / "model").size() == 1);
}

TEST_CASE("ens-train: a config that is wrong ends with 3 and points to the place", "[cli][ens]") {
  const TemporaryFolder folder;
  write_ensemble_inputs(folder);
  const auto refused = [&](const std::string& keys, const std::string& message) {
    folder.write("wrong.json", keys);
    check_refused(folder, kTrain + "wrong.json -o model", 3, "wrong.json: " + message);
  };
  refused(R"({"epocs": 5})", "/epocs: unknown key; known here: ");
  refused(R"({"epochs": "many"})", "/epochs: expected a whole number from 1");
  refused(R"({"epochs": 2.5})", "/epochs: expected a whole number from 1");
  refused(R"({"time_step_s": 0})", "/time_step_s: expected a number > 0, got 0");
  refused(R"({"steps": 1})", "/steps: expected a whole number from 2");
  refused(R"({"sigma": {"u": 1}})", "/sigma/u: unknown key");
  refused(R"({"sigma": 0.1})", "/sigma: expected an object, got 0.1");
  refused(R"({"activation": "relu"})", "/activation: ");
  refused(R"({"initial_state_net": "yes"})", "/initial_state_net: expected true or false");
  check_refused(folder, kTrain + "none-such -o model", 2, "shipped: demo, fast, full-scale, honest, model-scale");
  check_refused(folder, kTrain + "none-such.json -o model", 4, "none-such.json: cannot be opened");
  CHECK_FALSE(std::filesystem::exists(folder / "model"));
}

TEST_CASE("ens-train: a wrong command line ends with 2, a folder that cannot be written with 4", "[cli][ens]") {
  const TemporaryFolder folder;
  write_ensemble_inputs(folder);
  check_refused(folder, "ens-train data/dataset.json", 2, "--output is required");
  check_refused(folder, kTrain + "tiny.json -o -", 2, "--output: a model directory cannot be '-'");
  check_refused(folder, kTrain + "tiny.json -o model --member 4", 2, "--member 4: expected 0 to 3, one of the 4");
  check_refused(folder, kTrain + "tiny.json -o model --epochs 0", 2, "--epochs");
  check_refused(folder, kTrain + "tiny.json -o model --kernel mmx", 2, "kernel 'mmx' is unknown");
  check_refused(folder, "ens-train 'data/dataset.json#tarin' --config tiny.json -o model", 3,
                "data/dataset.json: no set 'tarin'; sets: train, test");
  check_refused(folder, "ens-train rec.csv --config tiny.json -o model", 4, "rec.csv: cannot be opened");
  check_refused(folder, kTrain + "tiny.json -o spec.json", 4, "spec.json: cannot be created");
  check_refused(folder, kTrain + "tiny.json -o /dev/full", 4, "/dev/full: cannot be created");
  CHECK_FALSE(std::filesystem::exists(folder / "model"));
}

TEST_CASE("ens-train: the order of the files on the command line changes nothing", "[cli][ens]") {
  const TemporaryFolder folder;
  write_ensemble_inputs(folder);
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder / "data/train"))
    if (entry.is_regular_file()) files.push_back("data/train/" + entry.path().filename().string());
  REQUIRE(files.size() == 2);
  const std::string train = "ens-train --config tiny.json --quiet -o ";
  const std::string one = fmt::format(" {} {}", files[0], files[1]), other = fmt::format(" {} {}", files[1], files[0]);
  done(folder, train + "one" + one);
  done(folder, train + "other" + other);
  for (int member = 0; member < 4; ++member) {
    const std::string name = fmt::format("/member-{:02d}.json", member);
    CHECK(io::read_text(folder / ("one" + name)) == io::read_text(folder / ("other" + name)));
  }
  auto described = io::read_json(folder / "one/ensemble.json"),
       described_too = io::read_json(folder / "other/ensemble.json");
  for (io::Json* json : {&described, &described_too}) (*json)["provenance"].erase("command");
  CHECK(described == described_too);
  done(folder, train + "one --resume" + other);

  check_refused(folder, train + "twice " + files[0] + " ./" + files[0], 2, "has the same name as");
  std::filesystem::copy_file(folder / files[0], folder / "copy.csv");
  CHECK_THAT(done(folder, "ens-train --config tiny.json -o copied copy.csv" + one).err,
             Contains("holds the same bytes as copy.csv; what they record weighs twice in the training"));
}

TEST_CASE("ens-train: a dataset without its set named gets a warning, since it may hold the tests", "[cli][ens]") {
  const TemporaryFolder folder;
  write_ensemble_inputs(folder);
  CHECK_THAT(done(folder, "ens-train data/dataset.json --config tiny.json --epochs 1 --members 1 -o model").err,
             Contains("warning: data/dataset.json: trains on all its sets (test, train); data/dataset.json#SET names"));
  CHECK(done(folder, "ens-train 'data/dataset.json#train' --config tiny.json --epochs 1 --members 1 -o of-set")
            .err.find("all its sets") == std::string::npos);
}

TEST_CASE("ens-train: members of different kernels are used with a warning", "[cli][ens]") {
  const TemporaryFolder folder;
  prepare_model(folder);
  replace(folder / "model/member-01.json", "\"kernel\":\"", "\"kernel\":\"an older ");
  const Outcome trained =
      done(folder, "ens-train 'data/dataset.json#train' --config tiny.json -o model --resume 2>&1 >/dev/null");
  CHECK_THAT(trained.out + trained.err, Contains("warning: member 1 is kept as kernel 'an older "));
  const Outcome predicted = done(folder, "ens-predict model 'data/dataset.json#test' --particles 1");
  CHECK_THAT(predicted.err, Contains("warning: the members were trained on different kernels (an older "));
}

TEST_CASE("ens-train, ens-predict, pd-sweep: avx2 and avx512 give the same numbers", "[cli][ens]") {
  const TemporaryFolder folder;
  write_ensemble_inputs(folder);
  folder.write("batch.json", replaced(config(6), "\"batch_size\": 2", "\"batch_size\": 3"));
  const std::string train = kTrain + "batch.json --kernel ";
  if (run(folder, train + "avx512 -o wide").exit_code == 2) {
    WARN("SKIPPED: this processor lacks AVX-512");
    return;
  }
  done(folder, train + "avx2 -o narrow");
  const auto numbers_of = [&](const std::string& model, int member) {
    const std::string name = fmt::format("/member-{:02d}.json", member);
    const std::string kernel = model == "wide" ? "avx512" : "avx2";
    return replaced(io::read_text(folder / (model + name)), "\"kernel\":\"" + kernel + "\"", "");
  };
  for (int member = 0; member < 4; ++member) CHECK(numbers_of("narrow", member) == numbers_of("wide", member));
  for (const std::string use : {"ens-predict wide 'data/dataset.json#test' --particles 5",
                                "ens-predict wide 'data/dataset.json#test' --particles 37 --sampling ts1",
                                "pd-sweep wide --ship vectwin-3m --kp 20,60 --kd 20,60 --duration-s 20"}) {
    CAPTURE(use);
    const Outcome narrow = done(folder, use + " --kernel avx2"), wide = done(folder, use + " --kernel avx512");
    CHECK(narrow.out == wide.out);
    CHECK(narrow.err.find("kernel") == std::string::npos);
  }
  // Members of both, and one that goes on with the other kernel, need no warning.
  std::filesystem::rename(folder / "narrow/member-01.json", folder / "wide/member-01.json");
  const std::string goes_on = "ens-train data/dataset.json#train --config batch.json -o wide --resume --kernel avx512";
  CHECK(done(folder, goes_on).err.find("kernel") == std::string::npos);
  CHECK(done(folder, "ens-predict wide 'data/dataset.json#test' --particles 1").err.find("kernel") ==
        std::string::npos);
}

TEST_CASE("ens-predict: rows are sequences x steps x particles, and say which member moved the particle",
          "[cli][ens]") {
  const TemporaryFolder folder;
  prepare_model(folder);
  const std::string predict =
      "ens-predict model 'data/dataset.json#test' --quiet --steps 15 --particles 12 --sampling ";
  const auto check_rows = [&](const std::string& sampling, bool varies) {
    CAPTURE(sampling);
    const std::string text = done(folder, predict + sampling).out;
    CHECK(text == done(folder, predict + sampling + " --jobs 1").out);
    CHECK(text != done(folder, predict + sampling + " --seed 2").out);
    const auto rows = rows_of(text);
    CHECK(rows.size() == 1 + 2 * 3 * 15 * 12);
    const std::size_t particle = column(rows[0], "particle"), member = column(rows[0], "member");
    std::map<std::vector<std::string>, std::set<std::string>> members;  // of recording, sequence, particle
    std::set<std::string> all;
    for (std::size_t i = 1; i < rows.size(); ++i) {
      members[{rows[i][0], rows[i][1], rows[i][particle]}].insert(rows[i][member]);
      all.insert(rows[i][member]);
    }
    CHECK(members.size() == 2 * 3 * 12);
    CHECK(all == std::set<std::string>{"0", "1", "2", "3"});
    const auto changes = [](const auto& entry) { return entry.second.size() > 1; };
    CHECK(std::any_of(members.begin(), members.end(), changes) == varies);
  };
  check_rows("ts-inf", false);
  check_rows("ts1", true);
  CHECK(rows_of(done(folder, predict + "ts1 --use-members 1").out).size() == 1 + 2 * 3 * 15 * 12);
}

TEST_CASE("ens-predict: the fitted rollout has one particle for each member and covers every point", "[cli][ens]") {
  const TemporaryFolder folder;
  prepare_model(folder);
  const Outcome fitted = done(folder,
                              "ens-predict model 'data/dataset.json#train' --fitted -o fitted && eval-metrics fitted "
                              "--truth data/dataset.json --quiet");
  const io::Json metrics = io::parse_json(fitted.out, "stdout")["overall"];
  CHECK(metrics["sequences"] == 6);  // 51 points in windows of 20: the last one overlaps its neighbor
  CHECK(metrics["particles"] == 4);
  CHECK(metrics["sampling"] == "fitted");
  CHECK(metrics["L_fit"].is_number());
  const auto rows = rows_of(done(folder, "ens-predict model data/train/train-r-01.csv --fitted --quiet").out);
  CHECK(rows.size() == 1 + 3 * 20 * 4);
  const std::size_t u = column(rows[0], "u_mps");
  CHECK(rows[1][u] != rows[2][u]);  // each member has its own estimate of the initial state
}

TEST_CASE("ens-predict: the baseline holds the initial velocity", "[cli][ens]") {
  const TemporaryFolder folder;
  write_ensemble_inputs(folder);
  const auto rows = rows_of(done(folder, "ens-predict --baseline hold data/test/test-t20.csv --steps 20 --quiet").out);
  REQUIRE(rows.size() == 1 + 2 * 20);
  for (const char* name : {"u_mps", "vm_mps", "r_degps", "particle", "member"}) {
    const std::size_t c = column(rows[0], name);
    for (std::size_t i = 2; i <= 20; ++i) CHECK(rows[i][c] == rows[1][c]);
  }
  CHECK(rows[1][column(rows[0], "x0_m")] != rows[20][column(rows[0], "x0_m")]);
}

TEST_CASE("ens-predict: what it cannot use or write is refused", "[cli][ens]") {
  const TemporaryFolder folder;
  prepare_model(folder);
  const std::string predict = "ens-predict model 'data/dataset.json#test' ";
  check_refused(folder, predict + "--use-members 5", 2, "--use-members 5: model has 4 members");
  check_refused(folder, "ens-predict model", 2, "expected MODEL_DIR and at least one test trajectory");
  check_refused(folder, predict + "--sampling ts2", 2, "--sampling");
  check_refused(folder, predict + "--particles 0", 2, "--particles");
  check_refused(folder, "ens-predict --baseline hold data/dataset.json --fitted", 2, "--fitted needs a model");
  check_refused(folder, "ens-predict model data/test/test-t20.csv --baseline hold", 2, "model is a model: with --base");
  check_refused(folder, predict + "--time-step-s 2", 2, "--time-step-s is for --baseline");
  const Outcome idle = done(folder, "ens-predict --baseline hold data/dataset.json --steps 20 --sampling ts1 -o hold");
  CHECK_THAT(idle.err, Contains("warning: --sampling has no effect with --baseline"));
  check_refused(folder, predict + "--steps 47", 3, "no recording holds 47 points 1 s apart without a gap");
  check_refused(folder, "ens-predict none-such data/dataset.json", 4, "none-such/ensemble.json: cannot be opened");
  check_refused(folder, "ens-predict data/dataset.json data/dataset.json", 4, "data/dataset.json/ensemble.json");
  check_refused(folder, predict + "-o spec.json", 4, "spec.json: cannot be created");
  check_refused(folder, predict + "-o /dev/full", 4, "/dev/full: cannot be created");
  if (std::filesystem::exists("/dev/full"))
    check_refused(folder, predict + "-o - > /dev/full", 4, "standard output: cannot be written: No space left");
  const Outcome head = run(folder, "(" + predict + "--quiet --particles 1000 -o -; echo $? > code) | head -1");
  CHECK_THAT(head.out, StartsWith("recording,sequence,step,t_s,particle,member,"));
  CHECK(head.err.empty());
  CHECK(io::read_text(folder / "code") == "0\n");

  std::filesystem::remove(folder / "model/member-03.json");
  check_refused(folder, predict, 4, "model/member-03.json: is not trained yet; run ens-train with --member 3");
}

TEST_CASE("pd-sweep: one row for each gain pair, and the true ship does not depend on the seed", "[cli][ens]") {
  const TemporaryFolder folder;
  prepare_model(folder);
  const std::string sweep = "pd-sweep model --ship vectwin-3m --kp 20:60:20 --kd 20,60 --duration-s 20 --quiet ";
  const auto rows = rows_of(done(folder, sweep + "--particles 7").out);
  const auto other = rows_of(done(folder, sweep + "--particles 7 --seed 2 --jobs 1").out);
  REQUIRE(rows.size() == 1 + 3 * 2);
  REQUIRE(other.size() == rows.size());
  CHECK(rows[0] == std::vector<std::string>{"kp_deg_per_rad", "kd_deg_per_radps", "score_true", "score_mean",
                                            "score_worst", "score_best", "score_member_00", "score_member_01",
                                            "score_member_02", "score_member_03"});
  for (std::size_t i = 1; i < rows.size(); ++i) {
    CAPTURE(i);
    const auto score = [&](std::size_t c) { return std::stod(rows[i][c]); };
    CHECK(score(0) == (i <= 2 ? 20.0 : i <= 4 ? 40.0 : 60.0));
    CHECK(score(1) == (i % 2 == 1 ? 20.0 : 60.0));
    CHECK(score(4) >= score(3));
    CHECK(score(3) >= score(5));
    CHECK(rows[i][2] == other[i][2]);
    for (std::size_t c = 6; c < 10; ++c) CHECK(rows[i][c] == other[i][c]);
  }
  // One member: all particles are equal, to the last bit.
  for (const auto& row : rows_of(done(folder, sweep + "--use-members 1").out)) {
    if (row[0].starts_with("kp")) continue;
    CHECK((row[3] == row[6] && row[4] == row[6] && row[5] == row[6]));
  }
}

TEST_CASE("pd-sweep: the runs of each gain pair go to a folder", "[cli][ens]") {
  const TemporaryFolder folder;
  prepare_model(folder);
  done(folder,
       "pd-sweep model --ship vectwin-3m --kp 20:60:20 --kd 20,60 --duration-s 20 --dt-s 0.2 --trajectories runs -o "
       "s.csv");
  CHECK(files_of(folder / "runs").size() == 6 + 1);  // with their index
  const auto rows = rows_of(io::read_text(folder / "runs/kp40_kd60.csv"));
  REQUIRE(rows.size() == 1 + 5 * 21);
  CHECK(rows[0] == std::vector<std::string>{"model", "t_s", "x0_m", "y0_m", "psi_deg", "u_mps", "vm_mps", "r_degps",
                                            "delta_p_deg", "delta_s_deg"});
  CHECK(rows[1][0] == "true");
  CHECK(rows[21][1] == "20");
  CHECK(rows[22][0] == "00");
  CHECK(rows[105][0] == "03");
}

TEST_CASE("pd-sweep: a wrong command line ends with 2", "[cli][ens]") {
  const TemporaryFolder folder;
  prepare_model(folder);
  const std::string sweep = "pd-sweep model --ship vectwin-3m ";
  for (const std::string range : {"5:1:2", "1:5:0", "1:5", "five", "1,,2", "nan", "0:1e30:1", "''"})
    check_refused(folder, sweep + "--kp " + range, 2, "--kp: ");
  check_refused(folder, sweep + "--duration-s 10 --dt-s 0.3", 2, "--duration-s must be a multiple of --dt-s");
  check_refused(folder, sweep + "--duration-s 3 --dt-s 0.3 --trajectories t", 2, "must be a multiple of --dt-s");
  check_refused(folder, sweep + "--use-members 5", 2, "--use-members 5: model has 4 members");
  check_refused(folder, "pd-sweep model --ship esso-osaka-3m", 2, "the ensemble needs 'delta_p_deg', which the ship");
  check_refused(folder, "pd-sweep model --ship none-such", 2,
                "shipped: esso-osaka-3m, ferry-40m, kvlcc2-full, kvlcc2-l7, vectwin-150m, vectwin-3m");
  check_refused(folder, "pd-sweep none-such --ship vectwin-3m", 4, "none-such/ensemble.json: cannot be opened");
  check_refused(folder, sweep + "--kp 20 --kd 20 -o no/such.csv", 4, "no/such.csv: cannot be written");
  if (std::filesystem::exists("/dev/full"))
    check_refused(folder, sweep + "--kp 20 --kd 20 -o /dev/full", 4, "/dev/full: cannot be written: No space left");
}

TEST_CASE("ens-train --base: the tools use such a model as any other, wherever it lies", "[cli][ens][base]") {
  const TemporaryFolder folder;
  write_ensemble_inputs(folder);
  done(folder, kTrain + "tiny.json -o one --base vectwin-3m --jobs 2");
  for (const int member : {2, 0, 3, 1})
    done(folder, kTrain + fmt::format("tiny.json -o single --base vectwin-3m --member {}", member));
  const auto one = files_of(folder / "one");
  CHECK(one.size() == 6);
  CHECK(one == files_of(folder / "single"));
  const io::Json header = io::read_json(folder / "one/ensemble.json");
  CHECK(header["training"]["base"]["ship"] == "base-ship.json");
  CHECK(header["training"]["base"]["name"] == "vectwin-3m");
  CHECK(header["training"]["base"]["actuators"] == io::Json::array({"n_p_rps"}));
  CHECK(header["domain"].size() == header["training"]["inputs"].size());
  CHECK(header["domain"][0]["low"] < header["domain"][0]["high"]);

  const std::string predict = " 'data/dataset.json#test' --particles 20 --quiet";
  const std::string expected = done(folder, "ens-predict one" + predict).out;
  std::filesystem::create_directories(folder / "elsewhere");
  std::filesystem::rename(folder / "one", folder / "elsewhere/moved");
  CHECK(done(folder, "ens-predict elsewhere/moved" + predict).out == expected);
  CHECK(expected != done(folder, kTrain + "tiny.json -o plain && ens-predict plain" + predict).out);
  CHECK_FALSE(std::filesystem::exists(folder / "plain/base-ship.json"));
  const auto rows =
      rows_of(done(folder, "pd-sweep elsewhere/moved --ship vectwin-3m --kp 40 --kd 60 --duration-s 20 --quiet").out);
  CHECK(rows.size() == 2);
  done(folder,
       "ens-predict elsewhere/moved 'data/dataset.json#train' --fitted --quiet | eval-metrics - --truth "
       "data/dataset.json --quiet");

  // Without its base it is another training.
  check_refused(folder, kTrain + "tiny.json -o single", 2, "single holds an ensemble of another base: 'vectwin-3m' (");
  CHECK(files_of(folder / "single") == one);
}

TEST_CASE("ens-train --base-spread: members with ships of their own, in any order, used as any other",
          "[cli][ens][base]") {
  const TemporaryFolder folder;
  write_ensemble_inputs(folder);
  const std::string train = kTrain + "tiny.json --base vectwin-3m --base-spread ";
  done(folder, train + "auto -o one --jobs 2");
  for (const int member : {2, 0, 3, 1}) done(folder, train + fmt::format("auto -o single --member {}", member));
  CHECK(files_of(folder / "one") == files_of(folder / "single"));
  CHECK(files_of(folder / "one").size() == 10);  // the index, the base, four members and their ships
  const io::Json header = io::read_json(folder / "one/ensemble.json");
  CHECK(header["training"]["base"]["spread"].get<double>() > 0.0);
  CHECK(header["training"]["config"]["base_spread"] == "auto");
  CHECK(done(folder, "mmg-sim show one/member-02.ship.json").out.starts_with("vectwin-3m-draw-02"));
  const std::string predict = " 'data/dataset.json#test' --particles 20 --quiet";
  const std::string all = done(folder, "ens-predict one" + predict).out;
  // A subset of members predicts as it did in the whole.
  CHECK(done(folder, "ens-predict single --use-members 2" + predict).out != all);
  done(folder, "pd-sweep one --ship vectwin-3m --kp 40 --kd 60 --duration-s 20 --quiet");
  // A drawn ship that is not the member's is noticed.
  std::filesystem::copy_file(folder / "one/member-00.ship.json", folder / "one/member-03.ship.json",
                             std::filesystem::copy_options::overwrite_existing);
  check_refused(folder, "ens-predict one" + predict, 3, "member-03.ship.json: is not the ship that member 3");

  // A ship that was lost or changed is drawn as it was where the training is gone on with.
  done(folder, "rm one/member-01.ship.json");
  done(folder, train + "auto -o one --resume");
  CHECK(files_of(folder / "one") == files_of(folder / "single"));

  done(folder, train + "0 -o same");
  done(folder, kTrain + "tiny.json --base vectwin-3m -o plain");
  CHECK(files_of(folder / "same").at("member-00.json") == files_of(folder / "plain").at("member-00.json"));
  check_refused(folder, train + "1.5 -o one --resume", 2, "base_spread: expected 1.5, found \"auto\"");
  check_refused(folder, train + "-1 -o bad", 2, "--base-spread: expected a number >= 0 or 'auto', got '-1'");
  check_refused(folder, train + "'' -o bad", 2, "--base-spread: expected a number >= 0 or 'auto', got ''");
  check_refused(folder, train + "wide -o bad", 2, "--base-spread: expected a number >= 0 or 'auto', got 'wide'");
  check_refused(folder, kTrain + "tiny.json --base-spread 1 -o bad", 2, "--base-spread needs --base");
}

TEST_CASE("ens-train: a fitted base and a calibration, by one process or many", "[cli][ens][base]") {
  const TemporaryFolder folder;
  write_ensemble_inputs(folder);
  folder.write("honest.json", config(3, R"(, "base_spread": "auto", "fit_base": true, "bootstrap": true,
    "inputs_between_samples": "linear", "calibration": {"folds": 2, "members": 2})"));
  const std::string train = kTrain + "honest.json --base vectwin-3m ";
  done(folder, train + "-o one");
  for (const int member : {3, 1, 0, 2}) done(folder, train + fmt::format("-o many --member {}", member));
  CHECK_FALSE(std::filesystem::exists(folder / "many/calibration.json"));
  const std::string again = "ens-train data/dataset.json#train --quiet --calibrate many";
  done(folder, again);
  std::map<std::string, std::string> one = files_of(folder / "one"), many = files_of(folder / "many");
  const io::Json calibration = io::read_json(folder / "one/calibration.json");
  CHECK(calibration["sha256"] ==
        io::read_json(folder / "many/calibration.json")["sha256"]);  // but for the command line
  one.erase("calibration.json");
  many.erase("calibration.json");
  CHECK(one == many);
  const io::Json base = io::read_json(folder / "one/base-ship.json");
  CHECK(base["name"] == "vectwin-3m-calibrated");
  CHECK(base["coefficient_covariance"]["names"].size() == base["coefficient_covariance"]["matrix"].size());
  CHECK(io::read_text(folder / "one/stated-ship.json") == io::read_text(io::find_config("ships", "vectwin-3m")));
  done(folder, "mmg-sim draws --ship one/base-ship.json --count 2 --spread 1 -o draws");

  // What a prediction takes of it.
  const std::string predict = "ens-predict one 'data/dataset.json#test' --particles 12 --quiet ";
  const std::string whole = done(folder, predict + "--initial-state observed").out;
  const std::string from_truth = done(folder, predict).out;
  CHECK(done(folder, predict + "--no-initial-error").out == from_truth);  // the truth has none
  CHECK(done(folder, predict + "--initial-state observed --no-initial-error").out != whole);
  CHECK(done(folder, predict + "--no-disturbance").out == done(folder, predict + "--no-calibration").out);
  CHECK(done(folder, predict + "--no-disturbance").out != from_truth);
  done(folder, predict + "-o predicted");
  const io::Json described = io::read_json(folder / "predicted/prediction.json");
  CHECK(described["disturbance"] == true);
  CHECK(described["radii"] == calibration["radii"]);
  done(folder, "eval-metrics predicted --truth data/dataset.json --quiet -o metrics.json");
  const std::string sweep = "pd-sweep one --ship vectwin-3m --kp 40 --kd 60 --duration-s 20 --particles 12 --quiet ";
  CHECK(done(folder, sweep).out != done(folder, sweep + "--no-disturbance").out);
  CHECK(done(folder, sweep + "--no-calibration").out == done(folder, sweep + "--no-disturbance").out);

  // A training that goes on keeps it; damage is noticed.
  const std::string kept = io::read_text(folder / "one/calibration.json");
  done(folder, train + "-o one --resume");
  CHECK(io::read_text(folder / "one/calibration.json") == kept);
  done(folder, "rm -r many");
  done(folder, kTrain + "tiny.json -o many");
  CHECK_FALSE(std::filesystem::exists(folder / "many/calibration.json"));
  CHECK_FALSE(std::filesystem::exists(folder / "many/stated-ship.json"));
  std::filesystem::copy_file(folder / "one/calibration.json", folder / "many/calibration.json");
  check_refused(folder, "ens-predict many 'data/dataset.json#test'", 3,
                "many/calibration.json: /training_id: is of another training");
  check_refused(folder, "ens-train data/dataset.json#test --calibrate one", 2,
                "trained on other recordings than these");
  check_refused(folder, "ens-train data/dataset.json#train --calibrate one -o two", 2, "--calibrate takes a model");
  done(folder, "rm one/member-02.json");
  check_refused(folder, "ens-train data/dataset.json#train --calibrate one", 4, "calibration needs all members");
  folder.write("bad.json", config(3, R"(, "calibration": {"folds": 1})"));
  check_refused(folder, kTrain + "bad.json -o bad", 3, "bad.json: /calibration/folds");
}

TEST_CASE("mmg-sim draws: ships that run as they are, the same for equal seeds", "[cli]") {
  const TemporaryFolder folder;
  done(folder, "mmg-sim draws --ship esso-osaka-3m --count 3 --spread 1.5 --seed 4 -o draws");
  CHECK(files_of(folder / "draws").size() == 4);
  const io::Json index = io::read_json(folder / "draws/draws.json");
  CHECK(index["draws"][1]["file"] == "draw-01.json");
  CHECK(index["draws"][1]["coefficient_factors"]["hull.Y_v"].get<double>() > 0.0);
  done(folder, "mmg-sim turning --ship draws/draw-02.json --duration-s 30 -o turning.csv");
  done(folder, "mmg-sim draws --ship esso-osaka-3m --count 2 --spread 1.5 --seed 4 -o fewer");
  CHECK(files_of(folder / "fewer").at("draw-01.json") == files_of(folder / "draws").at("draw-01.json"));
  check_refused(folder, "mmg-sim draws --ship esso-osaka-3m --count 0 -o none", 2, "--count");
  check_refused(folder, "mmg-sim draws --ship esso-osaka-3m --count 2 --spread 0 -o none", 2, "--spread");
  check_refused(folder, "mmg-sim draws --ship esso-osaka-3m --count 2", 2, "give --output DIR");
  check_refused(folder, "mmg-sim draws --ship esso-osaka-3m --count 1 --spread 1000 -o none", 1, "none reaches");
  check_refused(folder, "mmg-sim draws --ship draws/draw-00.json --count 9 -o draws", 2, "draw-00.json");
}

TEST_CASE("ens-train --base: what cannot be a base, or is another one, is refused", "[cli][ens][base]") {
  const TemporaryFolder folder;
  write_ensemble_inputs(folder);
  const std::string train = kTrain + "tiny.json -o model --base ";
  check_refused(folder, train + "none-such", 2, "shipped: esso-osaka-3m");
  check_refused(folder, train + "none-such.json", 4, "none-such.json: cannot be opened");
  check_refused(folder, train + "-", 2, "--base: expected a file or a shipped name, got '-'");
  folder.write("bad.json", R"({"name": "x", "particulars": {"source": "s", "L_pp_m": -3}})");
  check_refused(folder, train + "bad.json", 3, "bad.json: /particulars/L_pp_m: expected a number > 0, got -3");
  check_refused(folder, train + "kvlcc2-l7", 3,
                "train-r-01.csv:1: no column 'delta_deg', which the base ship 'kvlcc2-l7' needs");
  folder.write("late.json", io::read_text(LEEWAY_SOURCE_FOLDER "/configs/ships/vectwin-3m.json"));
  replace(folder / "late.json", "{", R"({"effects": [{"type": "actuator-delay", "delay_s": 1}],)");
  check_refused(folder, train + "late.json", 3, "late.json: /effects/0: actuator-delay: a base model cannot have");
  CHECK_FALSE(std::filesystem::exists(folder / "model"));

  done(folder, train + "vectwin-3m");
  check_refused(folder, kTrain + "tiny.json -o model --resume", 2,
                "model holds an ensemble of another base: 'vectwin-3m'");
  replace(folder / "late.json", R"("type": "actuator-delay", "delay_s": 1)",
          R"("type": "fouling", "resistance_increase": 0.1)");
  check_refused(folder, train + "late.json --resume", 2, "holds an ensemble of another base: 'vectwin-3m' (");
  check_refused(folder, train + "late.json --member 1", 2, "holds an ensemble of another base: 'vectwin-3m' (");
  done(folder, train + "vectwin-3m --resume");

  const std::string predict = "ens-predict model 'data/dataset.json#test'";
  folder.write("rec.csv", "t_s,u_mps,vm_mps,r_degps,psi_deg,delta_p_deg,delta_s_deg,n_bt_rps\n0,1,0,0,0,0,0,0\n");
  check_refused(folder, "ens-predict model rec.csv", 3, "rec.csv:1: no column 'n_p_rps', which the base ship");
  replace(folder / "model/base-ship.json", "{", "{ ");
  check_refused(folder, predict, 3, "model/base-ship.json: is not the ship 'vectwin-3m' that the members were trained");
  std::filesystem::remove(folder / "model/base-ship.json");
  check_refused(folder, predict, 4, "model/base-ship.json: cannot be opened");
}

TEST_CASE("ens-train: a training with other epochs than the paper's does not say that it follows the paper",
          "[cli][ens]") {
  const TemporaryFolder folder;
  write_ensemble_inputs(folder);
  done(folder, "ens-train data/dataset.json#train --config model-scale --epochs 1 --members 1 --quiet -o short");
  const io::Json header = io::read_json(folder / "short/ensemble.json");
  CHECK(header["training"]["config"]["epochs"] == 1);
  CHECK_FALSE(header["training"]["config"].contains("follows"));
  folder.write("wrong.json", R"({"follows": "paper", "epochs": 150})");
  check_refused(folder, "ens-train data/dataset.json#train --config wrong.json -o wrong", 3,
                "wrong.json: /follows: 'paper', but time_step_s, sigma or epochs differs from the paper's");
}
