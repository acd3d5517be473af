#include <algorithm>
#include <map>

#include <catch2/catch.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cli/run.hpp"
#include "io/json.hpp"

using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;
using leeway::io::read_text;
using leeway::test::Outcome;
using leeway::test::run;
using leeway::test::TemporaryFolder;

namespace {

long lines(const std::string& text) { return std::count(text.begin(), text.end(), '\n'); }

// Runs a command whose files, if any, have their full paths.
Outcome run_tool(const std::string& command) { return run(TemporaryFolder(), command); }

}  // namespace

TEST_CASE("mmg-sim: a maneuver goes to stdout, with all columns, and nothing else does", "[cli]") {
  const Outcome result = run_tool("mmg-sim zigzag --ship vectwin-3m --duration-s 20");
  CHECK(result.exit_code == 0);
  CHECK(result.err.empty());
  CHECK_THAT(result.out,
             StartsWith("t_s,u_mps,vm_mps,r_degps,x0_m,y0_m,psi_deg,delta_p_deg,delta_s_deg,n_p_rps,n_bt_rps,"
                        "wind_speed_mps,wind_dir_deg,app_wind_speed_mps,app_wind_dir_deg\n"
                        "0,0.5,0,0,0,0,0,0,0,10,0,0,0,0.5,0\n1,"));
  CHECK(lines(result.out) == 22);
}

TEST_CASE("mmg-sim: a negative rudder angle starts to port", "[cli]") {
  const Outcome result = run_tool("mmg-sim turning --ship esso-osaka-3m --rudder-deg -20 --duration-s 5 --n-p-rps 12");
  CHECK(result.exit_code == 0);
  CHECK_THAT(result.out, Contains(",-20,12,"));
}

TEST_CASE("mmg-sim: the same seed gives the same bytes, another seed others", "[cli]") {
  const std::string command = "mmg-sim random --ship vectwin-3m --noise paper-model-scale --duration-s 60 --seed ";
  CHECK(run_tool(command + "3").out == run_tool(command + "3").out);
  CHECK(run_tool(command + "3").out != run_tool(command + "4").out);
}

TEST_CASE("mmg-sim: noise is on the recording and not on the truth", "[cli]") {
  const TemporaryFolder folder;
  const std::string common = "mmg-sim random --ship vectwin-3m --duration-s 30 --wind-speed-mps 1 --wind-dir-deg 30 ";
  const std::string plain = run_tool(common).out;
  const Outcome result = run_tool(common + "--noise paper-model-scale --truth " + (folder / "t.csv"));
  CHECK(result.exit_code == 0);
  CHECK(result.out != plain);
  CHECK(read_text(folder / "t.csv") == plain);
}

TEST_CASE("mmg-sim: a recording is replayed to its end, from a pipe too", "[cli]") {
  const Outcome result = run_tool(
      "mmg-sim random --ship esso-osaka-3m --duration-s 30 | mmg-sim replay --ship esso-osaka-3m --sample-s 0.5 -");
  CHECK(result.exit_code == 0);
  CHECK(lines(result.out) == 62);
}

TEST_CASE("mmg-sim: restarted replays are predictions of particle 0 and member 0", "[cli]") {
  const TemporaryFolder folder;
  const std::string recording = folder / "rec.csv";
  REQUIRE(run_tool("mmg-sim random --ship vectwin-3m --duration-s 25 -o " + recording).exit_code == 0);
  const Outcome result = run_tool("mmg-sim replay --ship vectwin-3m --restart-steps 10 --prediction -o - " + recording);
  CHECK(result.exit_code == 0);
  CHECK_THAT(result.out, StartsWith("recording,sequence,step,t_s,particle,member,"));
  CHECK_THAT(result.out,
             Contains("\nrec,0,0,0,0,0,") && Contains("\nrec,1,0,10,0,0,") && Contains("\nrec,1,9,19,0,0,"));
  CHECK(lines(result.out) == 21);  // 26 points: two sequences of 10, a rest of 6
  CHECK(run_tool("mmg-sim replay --ship vectwin-3m --restart-steps 10 --prediction -o " + (folder / "p") + " " +
                 recording)
            .exit_code == 0);
  CHECK(read_text(folder / "p/rec.csv") == result.out);
}

TEST_CASE("mmg-sim: a dataset is the same for any number of threads, and lists what it wrote", "[cli]") {
  const TemporaryFolder folder;
  REQUIRE(run_tool("mmg-sim dataset demo --jobs 1 -o " + (folder / "a")).exit_code == 0);
  REQUIRE(run_tool("mmg-sim dataset demo --jobs 3 -o " + (folder / "b")).exit_code == 0);
  CHECK(run_tool("diff -r " + (folder / "a") + " " + (folder / "b")).exit_code == 0);
  CHECK_THAT(read_text(folder / "a/dataset.json"),
             Contains("\"Test-ZT/test-zt-z10.csv\"") && Contains("\"Test-ZT/truth/test-zt-z10.csv\"") &&
                 Contains("\"configs/ships/vectwin-3m.json\"") && !Contains(folder / "a"));
  CHECK(lines(read_text(folder / "a/Train/train-r-08.csv")) == 202);
  // A dataset and its sets stand for their recordings.
  const Outcome result = run_tool("mmg-sim replay --ship vectwin-3m --restart-steps 100 --prediction -o - " +
                                  (folder / "a/dataset.json#Test-ZT"));
  CHECK(result.exit_code == 0);
  CHECK(lines(result.out) == 1 + 4 * 2 * 100);
}

TEST_CASE("mmg-sim: a wrong command line is exit code 2 with one line and no output", "[cli]") {
  for (const auto& [arguments, message] : std::initializer_list<std::pair<const char*, const char*>>{
           {"", "subcommand"},
           {"zigzag", "--ship is required"},
           {"zigzag --ship titanic", "no file 'titanic'"},
           {"zigzag --ship vectwin-3m --dt-s nan", "expected a number > 0, got 'nan'"},
           {"zigzag --ship vectwin-3m --dt-s 0.3", "must be a multiple of the time step (--dt-s)"},
           {"dataset demo -o -", "a dataset is a folder"},
           {"zigzag --ship vectwin-3m --n-p-rps 30", "outside the limits"},
           {"zigzag --ship vectwin-3m --wind gusty", "--wind"},
           {"random --ship vectwin-3m --noise loud", "no file 'loud'"},
           {"dataset demo", "give --output DIR"},
           {"replay --ship vectwin-3m --prediction a.csv", "belong together"}}) {
    const Outcome result = run_tool(fmt::format("mmg-sim {}", arguments));
    CAPTURE(arguments, result.err);
    CHECK(result.exit_code == 2);
    CHECK(result.out.empty());
    CHECK_THAT(result.err, StartsWith("mmg-sim: error: ") && Contains(message));
    CHECK(lines(result.err) == 1);
  }
}

TEST_CASE("mmg-sim: wrong contents are exit code 3, unwritable output is 4, divergence is 1", "[cli]") {
  const TemporaryFolder folder;
  const std::string recording = folder.write("r.csv", "t_s,u_mps,vm_mps,r_degps,psi_deg\n0,0.1,0,0,0\n1,0.1,0,0,0\n");
  const Outcome lacking = run_tool("mmg-sim replay --ship esso-osaka-3m " + recording);
  CHECK(lacking.exit_code == 3);
  CHECK_THAT(lacking.err, Contains("r.csv:1: no column 'delta_deg'"));

  const std::string spec = folder.write("s.json", R"({"ship": "vectwin-3m", "sets": [{"name": "A", "runs": [
      {"maneuver": "turning", "rudder_deg": 10, "duration_s": 20}, {"maneuver": "turning", "rudder_deg": 10, "duration_s": 30}]}]})");
  const Outcome twice = run_tool("mmg-sim dataset " + spec + " -o " + (folder / "d"));
  CHECK(twice.exit_code == 3);
  CHECK_THAT(twice.err, Contains("/sets/0/runs: two recordings would be called 'a-t10'"));

  CHECK(run_tool("mmg-sim zigzag --ship vectwin-3m -o " + (folder / "no/such/file.csv")).exit_code == 4);
  CHECK(run_tool("mmg-sim zigzag --ship vectwin-3m -o /dev/full").exit_code == 4);
  const Outcome diverged = run_tool("mmg-sim turning --ship vectwin-3m --dt-s 100 --sample-s 100 --duration-s 10000");
  CHECK(diverged.exit_code == 1);
  CHECK(diverged.out.empty());
  CHECK_THAT(diverged.err, Contains("diverged at"));
}

TEST_CASE("mmg-sim: ships lists every shipped ship with its length and what it is", "[cli][mmg-sim]") {
  const Outcome result = run_tool("mmg-sim ships");
  CHECK(result.exit_code == 0);
  CHECK(result.err.empty());
  CHECK(lines(result.out) == 1 + static_cast<long>(leeway::io::config_names("ships").size()));
  CHECK_THAT(result.out, Contains("kvlcc2-l7                    7  7 m model of the tanker KVLCC2"));
  CHECK_THAT(result.out, Contains("kvlcc2-full                320  "));
  const Outcome extra = run_tool("mmg-sim ships all");
  CHECK(extra.exit_code == 2);
  CHECK(extra.out.empty());
  CHECK_THAT(extra.err, Contains("all"));
}

TEST_CASE("mmg-sim: show prints particulars, modules, limits, a straight run and self-propulsion", "[cli][mmg-sim]") {
  const Outcome result = run_tool("mmg-sim show kvlcc2-l7");
  CHECK(result.exit_code == 0);
  CHECK(result.err.empty());
  for (const char* text : {"3270 kg", "C_b", "Fr 0.1423", "hull, mmg-standard: ", "borrowed from the Esso Osaka",
                           "delta    -35 .. 35 deg, at most 15.8 deg/s", "n_p 11.8546 1/s, J 0.2763, 1 - w_P 0.6000",
                           "(1 - t_P) T 49.2603 N, hull -49.2603 N"})
    CHECK_THAT(result.out, Contains(text));
  for (const std::string& name : leeway::io::config_names("ships"))
    CHECK(run_tool("mmg-sim show " + name).exit_code == 0);
  CHECK(run_tool("mmg-sim show").exit_code == 2);
  CHECK(run_tool("mmg-sim show kvlcc2-l7 more").exit_code == 2);
  CHECK_THAT(run_tool("mmg-sim show kvlcc2").err, Contains("shipped: "));
}

TEST_CASE("mmg-sim: every maneuver runs with its defaults on a ship that can do it, and writes its indices", "[cli]") {
  const TemporaryFolder folder;
  const std::string schedule = folder.write("orders.csv", "t_s,n_p_rps\n5,8\n");
  for (const std::string maneuver :
       {"turning", "zigzag", "random", "pull-out", "spiral --rudder-deg 10 --fine-step-deg 5", "crash-stop",
        "coast-down", "thruster-pulses", "straight", "schedule SCHEDULE"}) {
    CAPTURE(maneuver);
    std::string command = "mmg-sim " + maneuver + " --ship vectwin-3m -o run.csv --indices i.json";
    if (const auto place = command.find("SCHEDULE"); place != std::string::npos)
      command.replace(place, 8, "orders.csv");
    const Outcome result = run(folder, command);
    CHECK(result.exit_code == 0);
    CHECK(result.out.empty());
    const leeway::io::Json json = leeway::io::read_json(folder / "i.json");
    CHECK(json["maneuver"] == maneuver.substr(0, maneuver.find(' ')));
    CHECK(json["ship"]["name"].get<std::string>().size() > 0);
    CHECK(json["conditions"].contains("u0_mps"));
    CHECK(json["run"]["min_max"].contains("delta_p_deg"));
    CHECK(json["provenance"]["tool"] == "mmg-sim");
    CHECK(json["provenance"]["inputs"][0]["file"] == "configs/ships/vectwin-3m.json");
    CHECK(json.contains("indices") == (maneuver != "random" && maneuver != "schedule SCHEDULE"));
    CHECK(lines(read_text(folder / "run.csv")) > 10);
  }
}

TEST_CASE("mmg-sim: indices come from every step, without noise, and leave the trajectory alone", "[cli]") {
  const TemporaryFolder folder;
  const std::string turn = "mmg-sim turning --ship esso-osaka-3m --duration-s 120 ";
  const std::string plain = run(folder, turn).out;
  const Outcome with = run(folder, turn + "--indices a.json");
  CHECK(with.out == plain);
  CHECK_THAT(with.err, Contains("time_to_360_deg_s"));  // not reached
  REQUIRE(run(folder, turn + "--indices b.json --sample-s 10 --noise paper-model-scale -o r.csv").exit_code == 0);
  const leeway::io::Json a = leeway::io::read_json(folder / "a.json"), b = leeway::io::read_json(folder / "b.json");
  CHECK(a["indices"] == b["indices"]);
  CHECK(a["indices"]["tactical_diameter_m"].is_number());
  CHECK(a["indices"]["time_to_360_deg_s"].is_null());

  const Outcome replayed = run(folder, "mmg-sim replay --ship esso-osaka-3m r.csv --indices c.json -o s.csv");
  CHECK(replayed.exit_code == 0);
  CHECK(leeway::io::read_json(folder / "c.json")["run"]["duration_s"] == 120.0);
  CHECK(run(folder, turn + "--indices - -o r.csv").out == read_text(folder / "a.json"));
}

TEST_CASE("mmg-sim: a maneuver that is done ends the run, at a sample", "[cli]") {
  const std::string stop = run_tool("mmg-sim crash-stop --ship esso-osaka-3m --sample-s 5").out;
  CHECK(lines(stop) < 60);
  CHECK_THAT(stop, Contains("\n110,-"));
  CHECK(lines(run_tool("mmg-sim crash-stop --ship esso-osaka-3m --duration-s 30").out) == 32);
}

TEST_CASE("mmg-sim: a ferry with azimuth thrusters follows a schedule, and its recording is replayed", "[cli]") {
  const TemporaryFolder folder;
  const std::string orders =
      folder.write("o.csv", "t_s,n_az1_rps,az1_deg,n_az2_rps,az2_deg\n0,4,350,3,-200\n60,3,90,,\n");
  const Outcome run_out = run(folder, "mmg-sim schedule --ship ferry-40m --u0-mps 0 --duration-s 120 o.csv -o r.csv");
  CHECK(run_out.exit_code == 0);
  CHECK(run_out.err.empty());
  const std::string text = read_text(folder / "r.csv");
  CHECK_THAT(text, StartsWith("t_s,u_mps,vm_mps,r_degps,x0_m,y0_m,psi_deg,n_az1_rps,az1_deg,n_az2_rps,az2_deg,wind_"));
  CHECK_THAT(text, Contains(",-9.9999999999"));  // the short way to 350 deg
  const Outcome replayed = run(folder, "mmg-sim replay --ship ferry-40m r.csv -o s.csv");
  CHECK(replayed.exit_code == 0);
  CHECK(lines(read_text(folder / "s.csv")) == 122);
  const Outcome show = run_tool("mmg-sim show ferry-40m");
  for (const char* part :
       {"thruster n_az1, azimuth: ", "az2      any angle, at most 15 deg/s", "of each thruster that drives"})
    CHECK_THAT(show.out, Contains(part));
  CHECK(run_tool("mmg-sim berthing --ship ferry-40m").exit_code == 2);
  CHECK(run_tool("mmg-sim turning --ship ferry-40m --duration-s 60 --indices i.json").exit_code == 0);
}

TEST_CASE("mmg-sim: stochastic wind follows the seed", "[cli]") {
  const std::string command =
      "mmg-sim straight --ship vectwin-3m --duration-s 20 --wind stochastic --wind-speed-mps 1 --wind-dir-deg 90 "
      "--seed ";
  const std::string a = run_tool(command + "1").out;
  CHECK(a == run_tool(command + "1").out);
  CHECK(a != run_tool(command + "2").out);
  CHECK_THAT(a, !Contains(",1,90,"));
}

TEST_CASE("mmg-sim: a schedule comes from a pipe too, and says what is wrong", "[cli]") {
  const Outcome result = run_tool("printf 't_s,delta_deg\\n0,40\\n' | mmg-sim schedule --ship esso-osaka-3m -");
  CHECK(result.exit_code == 0);
  CHECK(lines(result.out) == 202);
  CHECK_THAT(result.err, Contains("warning: -:2: column 'delta_deg': 1 order outside the limits -35 to 35"));
  const TemporaryFolder folder;
  const Outcome wrong =
      run(folder, "mmg-sim schedule --ship esso-osaka-3m " + folder.write("o.csv", "t_s,dleta_deg\n0,4\n"));
  CHECK(wrong.exit_code == 3);
  CHECK(wrong.out.empty());
  CHECK_THAT(wrong.err, Contains("o.csv:1: column 'dleta_deg': is no order of the ship"));
  CHECK(lines(wrong.err) == 1);
  CHECK(run(folder, "mmg-sim schedule --ship esso-osaka-3m nowhere.csv").exit_code == 4);
}

TEST_CASE("mmg-sim: maneuvers that a ship cannot do are exit code 2 with one line", "[cli]") {
  for (const auto& [arguments, message] : std::initializer_list<std::pair<const char*, const char*>>{
           {"spiral --ship vectwin-3m --step-deg 7", "25 deg is not one of 7 deg"},
           {"spiral --ship vectwin-3m --rudder-deg 40", "40 deg is outside the limits"},
           {"spiral --ship vectwin-3m --u0-mps 0", "needs a speed ahead"},
           {"pull-out --ship vectwin-3m --rudder-deg -5", "expected a number from 0.1 to 180"},
           {"pull-out --ship vectwin-3m --hold-s 0", "expected a number > 0, got '0'"},
           {"crash-stop --ship vectwin-3m --astern-rps -5", "within the limits 0 to 20"},
           {"crash-stop --ship esso-osaka-3m --astern-rps 5", "expected a number from -1000 to 0"},
           {"coast-down --ship vectwin-3m --u0-mps 0", "needs a speed ahead"},
           {"thruster-pulses --ship kvlcc2-l7", "has no bow or stern thruster"},
           {"thruster-pulses --ship vectwin-3m --thruster stern", "has no stern thruster"},
           {"thruster-pulses --ship vectwin-3m --thruster-rps 31", "(-30 to 30 1/s), got 31"},
           {"straight --ship vectwin-3m --u0-mps 0", "at a speed ahead"},
           {"schedule --ship vectwin-3m", "schedule is required"},
           {"turning --ship vectwin-3m --hold-s 5", "unknown option '--hold-s'"},
           {"turning --ship vectwin-3m --indices -", "only one of --output"},
           {"turning --ship vectwin-3m --wind stochastic --wind-speed-mps 40 --dt-s 1", "too long for stochastic wind"},
           {"replay --ship vectwin-3m --prediction --restart-steps 10 --indices i.json a.csv", "do not apply"}}) {
    const Outcome result = run_tool(fmt::format("mmg-sim {}", arguments));
    CAPTURE(arguments, result.err);
    CHECK(result.exit_code == 2);
    CHECK(result.out.empty());
    CHECK_THAT(result.err, StartsWith("mmg-sim: error: ") && Contains(message));
    CHECK(lines(result.err) == 1);
  }
  CHECK(run_tool("mmg-sim straight --ship vectwin-3m --u0-mps 3").exit_code == 1);
}

TEST_CASE("mmg-sim: a dataset holds the other maneuvers and stochastic wind, and refuses what a ship cannot do",
          "[cli]") {
  const TemporaryFolder folder;
  const auto dataset = [&](const std::string& ship, const std::string& runs) {
    const std::string spec =
        folder.write("s.json", fmt::format(R"({{"ship": "{}", "sets": [{{"name": "A", "runs": [{}]}}]}})", ship, runs));
    return run(folder, "mmg-sim dataset " + spec + " -o d");
  };
  CHECK(dataset("vectwin-3m", R"({"maneuver": "random", "duration_s": 20, "count": 2,
                                  "wind": {"kind": "stochastic", "speed_mps": [1, 2], "dir_deg": [0, 360]}},
                                 {"maneuver": "crash-stop", "duration_s": 300}, {"maneuver": "spiral", "rudder_deg": 20, "duration_s": 60},
                                 {"maneuver": "straight", "u0_mps": 0.3, "duration_s": 20})")
            .exit_code == 0);
  for (const char* name : {"a-r-01", "a-r-02", "a-crash-stop-01", "a-spiral-20", "a-straight-01"}) {
    CAPTURE(name);
    CHECK(lines(read_text(folder / fmt::format("d/A/truth/{}.csv", name))) > 20);
  }
  CHECK(lines(read_text(folder / "d/A/a-crash-stop-01.csv")) < 150);  // it ends when the ship has stopped
  const Outcome thruster = dataset("kvlcc2-l7", R"({"maneuver": "thruster-pulses", "duration_s": 60})");
  CHECK(thruster.exit_code == 3);
  CHECK_THAT(thruster.err, Contains("/sets/0/runs/0/maneuver: the ship 'kvlcc2-l7' has no"));
  const Outcome wind = dataset("vectwin-3m", R"({"maneuver": "random", "duration_s": 60, "wind": {"kind": "gusty"}})");
  CHECK(wind.exit_code == 3);
  CHECK_THAT(wind.err, Contains("/sets/0/runs/0/wind/kind"));
}

TEST_CASE("mmg-sim: berthing follows the seed, reports how it ended, and refuses a ship that cannot do it", "[cli]") {
  const TemporaryFolder folder;
  const std::string command = "mmg-sim berthing --ship vectwin-3m --seed ";
  const Outcome third = run(folder, command + "3 --indices i.json"), again = run(folder, command + "3"),
                fourth = run(folder, command + "4");
  CHECK(third.exit_code == 0);
  CHECK(lines(third.out) == 251);  // 450 sqrt(L/g), up to the next sample
  CHECK(third.out == again.out);
  CHECK(third.out != fourth.out);
  const leeway::io::Json json = leeway::io::read_json(folder / "i.json");
  CHECK(json["conditions"]["wind"]["kind"] == "stochastic");
  CHECK(json["conditions"]["wind"]["speed_mps"] > 0.0);
  CHECK(json["conditions"]["plan"]["quay_heading_deg"] > 0.0);
  CHECK(json["indices"]["distance_to_berth_at_end_over_L"] < 0.5);
  CHECK(json["indices"]["speed_at_end_mps"] < 0.06);
  // One word about the wind, and it is as everywhere else.
  REQUIRE(run(folder, command + "3 --wind-speed-mps 0.5 --indices i.json").exit_code == 0);
  CHECK(leeway::io::read_json(folder / "i.json")["conditions"]["wind"] ==
        leeway::io::Json{{"kind", "steady"}, {"speed_mps", 0.5}, {"dir_deg", 0.0}});
  for (const char* ship : {"kvlcc2-l7", "esso-osaka-3m"}) {
    const Outcome refused = run(folder, std::string("mmg-sim berthing --ship ") + ship);
    CHECK(refused.exit_code == 2);
    CHECK(refused.out.empty());
    CHECK_THAT(refused.err, Contains("berthing needs VecTwin rudders (delta_p, delta_s) and a bow thruster (n_bt)"));
  }
}

TEST_CASE("mmg-sim: the data sets of the paper have its sizes, whatever the number of threads", "[cli]") {
  const TemporaryFolder folder;
  REQUIRE(run(folder, "mmg-sim dataset paper-model-scale --jobs 1 -o a").exit_code == 0);
  REQUIRE(run(folder, "mmg-sim dataset paper-model-scale --jobs 3 -o b").exit_code == 0);
  const leeway::io::Json dataset = leeway::io::read_json(folder / "a/dataset.json");
  const std::map<std::string, std::pair<long, long>> sizes{
      {"Train-B", {27, 4770}}, {"Test-B", {14, 2304}}, {"Test-ZT", {12, 2400}}, {"Test-R", {10, 2000}}};
  CHECK(dataset["sets"].size() == sizes.size());
  for (const leeway::io::Json& set : dataset["sets"]) {
    long runs = 0, seconds = 0;
    for (const leeway::io::Json& recording : set["recordings"]) {
      const std::string file = recording["file"], truth = recording["truth"];
      const std::string text = read_text(folder / ("a/" + file));
      CHECK(text == read_text(folder / ("b/" + file)));
      CHECK(read_text(folder / ("a/" + truth)) == read_text(folder / ("b/" + truth)));
      ++runs;
      seconds += lines(text) - 2;  // the header, and the sample at 0 s
    }
    CAPTURE(set["name"].get<std::string>());
    CHECK(sizes.at(set["name"]) == std::pair(runs, seconds));
  }
}

TEST_CASE("mmg-sim: impossible durations of a dataset are refused with their place", "[cli]") {
  const TemporaryFolder folder;
  const auto check = [&](const std::string& ship, const std::string& runs, const std::string& message) {
    folder.write("spec.json", R"({"ship": ")" + ship + R"(", "sets": [{"name": "A", "runs": [)" + runs + "]}]}");
    const Outcome outcome = run(folder, "mmg-sim dataset spec.json -o d");
    CAPTURE(runs);
    CHECK(outcome.exit_code == 3);
    CHECK_THAT(outcome.err, Contains("spec.json: " + message));
    CHECK(lines(outcome.err) == 1);
  };
  check("vectwin-3m", R"({"maneuver": "berthing", "count": 9, "total_duration_s": 17})",
        "/sets/0/runs/0/total_duration_s: expected at least two samples for each run, 18 s for 9 of them, got 17");
  check("vectwin-3m", R"({"maneuver": "berthing", "duration_s": 9, "total_duration_s": 17})",
        "/sets/0/runs/0/total_duration_s: expected this or duration_s, not both");
  check("vectwin-3m", R"({"maneuver": "berthing", "total_duration_s": 17.5})",
        "/sets/0/runs/0/total_duration_s: the duration must be a multiple of the sampling time");
  check("vectwin-3m", R"({"maneuver": "berthing", "total_duration_s": -3})",
        "/sets/0/runs/0/total_duration_s: expected a number > 0");
  check("vectwin-3m", R"({"maneuver": "berthing"})", "/sets/0/runs/0/duration_s: ");
  check("vectwin-3m", "", "/sets/0/runs: expected at least one entry");
  check("vectwin-3m", R"({"maneuver": "berthing", "duration_s": 60, "u0_mps": 0.3})",
        "/sets/0/runs/0/u0_mps: a berthing draws its own speed");
  check("kvlcc2-l7", R"({"maneuver": "berthing", "duration_s": 60})",
        "/sets/0/runs/0/maneuver: berthing needs VecTwin rudders");
}

TEST_CASE("mmg-sim: effects are listed, added to a run, and refused where they are wrong", "[cli][mmg-sim]") {
  const TemporaryFolder folder;
  const Outcome list = run_tool("mmg-sim effects");
  CHECK(list.exit_code == 0);
  for (const char* text : {"steady-current (E1)", "current_set_deg", "earth-force (E47)", "formula", "source"})
    CHECK_THAT(list.out, Contains(text));
  CHECK_THAT(run_tool("mmg-sim effects tug").out, Contains("force_N") && !Contains("steady-current (E1)"));
  CHECK(run_tool("mmg-sim effects tugg").exit_code == 2);

  folder.write("none.json",
               R"([{"type": "tug", "force_N": 0, "direction_deg": 10}, {"type": "shallow-water", "h_over_T": null}])");
  folder.write("current.json", R"({"type": "steady-current", "current_speed_mps": 0.2, "current_set_deg": 90})");
  const std::string command = "mmg-sim turning --ship kvlcc2-l7 --duration-s 60 ";
  const Outcome without = run(folder, command);
  CHECK(run(folder, command + "--effect none.json").out == without.out);
  const Outcome with = run(folder, command + "--effect none.json --effect current.json --indices i.json");
  CHECK(with.exit_code == 0);
  CHECK(with.out != without.out);
  const leeway::io::Json json = leeway::io::read_json(folder / "i.json");
  CHECK(json["conditions"]["effects"].size() == 3);
  CHECK(json["imo_msc_137_76"]["applies"] == false);
  CHECK(json["provenance"]["inputs"].size() == 3);

  folder.write("wrong.json", R"([{"type": "wake", "wake_fraction_increase": 0.1}, {"type": "tugg"}])");
  const Outcome wrong = run(folder, command + "--effect wrong.json");
  CHECK(wrong.exit_code == 3);
  CHECK(wrong.out.empty());
  CHECK_THAT(wrong.err, Contains("wrong.json: /1/type: unknown effect 'tugg'"));
  CHECK(run(folder, command + "--effect nowhere.json").exit_code == 4);
}
