#include <cmath>
#include <filesystem>

#include <catch2/catch.hpp>

#include "ensemble.hpp"
#include "io/json.hpp"
#include "io/trajectory_csv.hpp"

using namespace leeway;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;
using Catch::Matchers::WithinAbs;
using test::check_refused;
using test::done;
using test::TemporaryFolder;

namespace {

// Recordings as a full-scale ship has them: the thruster's pitch current and the apparent wind alone.
const std::string kShipboard = R"("recorded": {"bow_thruster": "i_bt", "wind": "apparent"}, "noise": )";

void write_shipboard_data(const TemporaryFolder& folder, const std::string& noise = R"("paper-model-scale")") {
  test::write_ensemble_inputs(folder);
  std::string spec = test::kSpec;
  const std::string plain = R"("noise": "paper-model-scale")";
  spec.replace(spec.find(plain), plain.size(), kShipboard + noise);
  folder.write("spec.json", spec);
  std::filesystem::remove_all(folder / "data");
  done(folder, "mmg-sim dataset spec.json -o data --quiet");
}

std::string header_of(const std::string& path) {
  const std::string text = io::read_text(path);
  return text.substr(0, text.find('\n'));
}

}  // namespace

TEST_CASE("i_bt: a data set records it and the apparent wind alone, its truth has all", "[cli]") {
  const TemporaryFolder folder;
  write_shipboard_data(folder);
  CHECK(header_of(folder / "data/train/train-r-01.csv") ==
        "t_s,u_mps,vm_mps,r_degps,x0_m,y0_m,psi_deg,delta_p_deg,delta_s_deg,n_p_rps,i_bt,app_wind_speed_mps,"
        "app_wind_dir_deg");
  const Trajectory truth = io::read_trajectory(folder / "data/train/truth/train-r-01.csv");
  CHECK(truth.has(Channel::wind_speed));
  for (std::size_t i = 0; i < truth.size(); ++i)
    CHECK_THAT(truth[Channel::n_bt][i], WithinAbs(30.0 * truth[Channel::i_bt][i], 1e-12));
  done(folder,
       "mmg-sim turning --ship vectwin-150m --duration-s 20 --record-bow-thruster i_bt --record-wind true -o t.csv");
  CHECK_THAT(header_of(folder / "t.csv"), Contains("n_p_rps,i_bt,wind_speed_mps,wind_dir_deg") && !Contains("app"));
  check_refused(folder, "mmg-sim turning --ship esso-osaka-3m --record-bow-thruster i_bt", 3,
                "esso-osaka-3m.json: /actuators: the ship 'esso-osaka-3m' has no actuator n_bt with a 'pitch_current'");
  folder.write("bad.json", R"({"ship": "vectwin-3m", "recorded": {"bow_thruster": "i"}, "sets": []})");
  check_refused(folder, "mmg-sim dataset bad.json -o bad", 3,
                "/recorded/bow_thruster: unknown 'i'; known: n_bt_rps, i_bt");
}

TEST_CASE("i_bt: a replay with it is that with the revolutions that it stands for", "[cli]") {
  const TemporaryFolder folder;
  write_shipboard_data(folder, "{}");
  const std::string replay = "mmg-sim replay --ship vectwin-3m --dt-s 0.1 --sample-s 1 --hold ";
  const std::string by_current = done(folder, replay + "data/test/test-r-01.csv").out;
  CHECK_THAT(by_current, Contains("n_bt_rps"));
  folder.write("by-current.csv", by_current);
  folder.write("by-revolutions.csv", done(folder, replay + "data/test/truth/test-r-01.csv").out);
  const Trajectory a = io::read_trajectory(folder / "by-current.csv"),
                   b = io::read_trajectory(folder / "by-revolutions.csv");
  REQUIRE(a.size() == b.size());
  for (const Channel channel : {Channel::u, Channel::vm, Channel::r, Channel::n_bt})
    for (std::size_t i = 0; i < a.size(); ++i) CHECK_THAT(a[channel][i], WithinAbs(b[channel][i], 1e-9));
  check_refused(folder, "mmg-sim replay --ship esso-osaka-3m data/test/test-r-01.csv", 3,
                "test-r-01.csv:1: has 'i_bt' and no 'n_bt_rps', but the ship 'esso-osaka-3m' does not state");
}

TEST_CASE("i_bt: networks take it as it is, and with a base ship as its revolutions", "[cli][ens][base]") {
  const TemporaryFolder folder;
  write_shipboard_data(folder);
  done(folder, test::kTrain + "tiny.json -o plain");
  done(folder, test::kTrain + "tiny.json -o based --base vectwin-3m");
  const auto inputs = [&](const std::string& model) {
    std::vector<std::string> names;
    const io::Json header = io::read_json(folder / (model + "/ensemble.json"));
    for (const io::Json& input : header["training"]["inputs"]) names.push_back(input["name"]);
    return names;
  };
  const std::vector<std::string> wind{"app_wind_x_mps", "app_wind_y_mps"};
  CHECK(inputs("plain") ==
        std::vector<std::string>{"u_mps", "vm_mps", "r_radps", "delta_p_rad", "delta_s_rad", "i_bt", wind[0], wind[1]});
  CHECK(inputs("based") == std::vector<std::string>{"u_mps", "vm_mps", "r_radps", "delta_p_rad", "delta_s_rad",
                                                    "n_bt_rps", wind[0], wind[1]});
  for (const std::string model : {"plain", "based"}) {
    CAPTURE(model);
    // From the recordings, and from the truths, which have both columns.
    for (const std::string state : {"observed", "true"})
      CHECK_THAT(done(folder, "ens-predict " + model +
                                  " 'data/dataset.json#test' --particles 4 --quiet --initial-state " + state)
                     .out,
                 StartsWith("recording,"));
    done(folder, "pd-sweep " + model + " --ship vectwin-3m --kp 40 --kd 60 --duration-s 20 --quiet");
  }
  check_refused(folder, "pd-sweep plain --ship esso-osaka-3m --kp 40 --kd 60", 2, "the ensemble needs");
  check_refused(folder, test::kTrain + "tiny.json -o none --base esso-osaka-3m", 3,
                "does not state what the pitch current");
  // Where recordings have both, the revolutions count.
  const auto both = done(folder, "ens-train data/train/truth/*.csv --config tiny.json -o both");
  CHECK_THAT(both.err, Contains("column 'i_bt' is left out: 'n_bt_rps' counts"));
  CHECK(inputs("both") == inputs("based"));
}

TEST_CASE("i_bt: the gap tools read it, with a ship as with an ensemble", "[cli][gap]") {
  const TemporaryFolder folder;
  write_shipboard_data(folder);
  done(folder, test::kTrain + "tiny.json -o model");
  for (const std::string simulator : {"--ship vectwin-3m", "--model model"}) {
    done(folder, "gap-locate " + simulator + " data/train/*.csv --quiet -o located");
    CHECK(std::filesystem::exists(folder / "located/locate.json"));
  }
  check_refused(folder, "gap-locate --ship esso-osaka-3m data/train/train-r-01.csv -o no", 3,
                "does not state what the pitch current stands for");
  done(folder, "gap-explain --ship vectwin-3m data/train/*.csv --holdout data/test/test-r-01.csv --quiet -o explained");
  CHECK(io::read_json(folder / "explained/report.json").at("verdict") != "mismatch");
}
