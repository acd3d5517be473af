// Model directories that were changed, damaged or left by a training that diverged.

#include <filesystem>

#include "ensemble.hpp"

using namespace leeway;
using namespace test;
using Catch::Matchers::Contains;

TEST_CASE("ens-predict: a model directory that was tampered with ends with 3", "[cli][ens]") {
  const TemporaryFolder folder;
  prepare_model(folder);
  folder.write("rec.csv", "t_s,u_mps,vm_mps,r_degps\n0,1,0,0\n1,1,0,0\n");
  const auto refused = [&](const std::string& file, const std::string& what, const std::string& with,
                           const std::string& message) {
    const std::string good = io::read_text(folder / "model/" + file);
    replace(folder / "model/" + file, what, with);
    check_refused(folder, "ens-predict model rec.csv", 3, "model/" + file + message);
    io::write_text(folder / "model/" + file, good);
  };
  refused("ensemble.json", "leeway ensemble 1", "leeway ensemble 2", ": /format: expected \"leeway ensemble 1\"");
  refused("ensemble.json", "\"seed\": 1", "\"seed\": \"one\"", ": /training/seed: expected a whole number >= 0");
  refused("ensemble.json", "\"members\": [", "\"members\": [], \"was\": [", ": /members: expected at least one member");
  refused("ensemble.json", "delta_p_deg", "delta_q_deg",
          ": /training/actuators: unknown actuator column 'delta_q_deg'");
  refused("member-00.json", "\"bias\":[", "\"bias\":[0.5,", ": /dynamics/0/bias: expected an array of");
  refused("member-00.json", "\"output_sd\":[\"", "\"output_sd\":[\"-", ": /output_sd: expected numbers > 0");
  refused("member-00.json", "\"dynamics\":", "\"dynamic\":", ": /dynamics: is missing");
  refused("member-00.json", "}\n", "", ":1:");
  // What decides a prediction or a verdict, and was changed.
  refused("ensemble.json", "\"sd\": ", "\"sd\": 1", ": /training_id: is not the SHA-256 of /training");
  refused("ensemble.json", "\"time_step_s\": 1.0", "\"time_step_s\": 1.5", ": /training_id: is not the SHA-256");
  refused("ensemble.json", "\"high\": ", "\"high\": 7", ": /sha256: is not that of /training_id and /domain");
  refused("ensemble.json", "\"member-02.json\"", "\"member-12.json\"", ": /members/2: expected \"member-02.json\"");
  refused("member-00.json", "\"member\":0", "\"member\":1", ": /member: expected 0, got 1");
  for (const std::string number : {"\"weights\":[[", "\"bias\":[", "\"output_mean\":[\"", "\"output_sd\":[\""}) {
    CAPTURE(number);
    const std::string text = io::read_text(folder / "model/member-00.json");
    const std::size_t begin = text.find(number), digit = text.find_first_of("12345678", begin + number.size());
    const std::string before = text.substr(begin, digit - begin);
    refused("member-00.json", before + text[digit], before + static_cast<char>(text[digit] + 1),
            ": /sha256: is not that of weights and standardization");
  }
  // Keys that nobody reads.
  refused("ensemble.json", "\"members\": [", "\"comment\": 1, \"members\": [", ": /comment: unknown key");
  refused("ensemble.json", "\"wind\": ", "\"windy\": true, \"wind\": ", ": /training/windy: unknown key");
  refused("ensemble.json", "\"low\": ", "\"middle\": 1, \"low\": ", ": /domain/0/middle: unknown key");
  refused("member-00.json", "\"kernel\":", "\"colonel\":1,\"kernel\":", ": /colonel: unknown key");
  refused("member-00.json", "\"bias\":", "\"bios\":1,\"bias\":", ": /dynamics/0/bios: unknown key");
  refused("member-00.json", "leeway member 1", "leeway member 0", ": /format: expected \"leeway member 1\"");
}

TEST_CASE(
    "ens-predict: a model of an earlier version has no hashes and is used with a warning; one that lost some is "
    "refused",
    "[cli][ens]") {
  const TemporaryFolder folder;
  prepare_model(folder);
  const std::string predict = "ens-predict model 'data/dataset.json#test' --particles 2";
  const Outcome whole = done(folder, predict);
  done(folder, "cp -r model whole");
  done(folder, R"(sed -i 's/,"sha256":"[0-9a-f]*"//' model/member-00.json)");
  check_refused(folder, predict, 3, "member-00.json: /sha256: is missing");
  const std::string without =
      "python3 -c \"import json; p = 'model/ensemble.json'; j = json.load(open(p)); del j['sha256']; "
      "json.dump(j, open(p, 'w'))\"";
  done(folder, R"(sed -i 's/,"sha256":"[0-9a-f]*"//' model/member-0*.json && )" + without);
  const Outcome earlier = done(folder, predict);
  CHECK(earlier.out == whole.out);
  CHECK_THAT(earlier.err, Contains("warning: a model of an earlier version has no hashes"));
  // Also where ensemble.json alone lost it, and what it guards was changed.
  done(folder, "rm -r model && cp -r whole model && " + without);
  CHECK_THAT(done(folder, predict).err, Contains("warning: a model of an earlier version has no hashes"));
}

TEST_CASE("ens-predict: a member's file that lacks or garbles a value is refused with its place", "[cli][ens]") {
  const TemporaryFolder folder;
  prepare_model(folder);
  done(folder, "cp -r model whole");
  const auto refused = [&](const std::string& change, const std::string& message) {
    CAPTURE(change);
    done(folder,
         "rm -r model && cp -r whole model && python3 -c \"import json; p = 'model/member-00.json'; "
         "j = json.load(open(p)); " +
             change + "; json.dump(j, open(p, 'w'))\"");
    check_refused(folder, "ens-predict model 'data/dataset.json#test' --particles 2 -o -", 3,
                  "member-00.json: " + message);
  };
  refused("del j['kernel']", "/kernel: is missing");
  refused("del j['dynamics']", "/dynamics: is missing");
  refused("j['format'] = None", "/format: type must be string, but is null");
  refused("j['output_mean'][1] = None", "/output_mean: type must be string, but is null");
  refused("j['output_sd'][2] = '0'", "/output_sd: expected numbers > 0");
  refused("j['dynamics'][0]['weights'][1][0] = 'x'", "/dynamics/0/weights/1: type must be number, but is string");
  refused("j['dynamics'][0]['bias'].pop()", "/dynamics/0/bias: expected an array of");
  refused("j['initial_state'] = {}", "/initial_state: expected an array of");
  refused("j['member'] = 1", "/member: expected 0, got 1");
}

TEST_CASE("ens-train: a training that diverges, be it in its last step, ends with 1 and saves nothing", "[cli][ens]") {
  const TemporaryFolder folder;
  write_ensemble_inputs(folder);
  for (const std::string rate : {"1e20", "1e36", "1e39", "1e300"})
    for (const int epochs : {1, 2}) {
      CAPTURE(rate, epochs);
      std::string text = config(epochs);
      text.replace(text.find("1e-3"), 4, rate);
      text.replace(text.find("\"batch_size\": 2"), 15, "\"batch_size\": 1000");  // one step an epoch
      folder.write("wild.json", text);
      std::filesystem::remove_all(folder / "model");
      const Outcome outcome = run(folder, kTrain + "wild.json --members 2 --checkpoint-s 0 -o model");
      CHECK((outcome.exit_code == 0 || outcome.exit_code == 1));
      if (rate == "1e39" || rate == "1e300") CHECK(outcome.exit_code == 1);
      if (outcome.exit_code == 1) CHECK_THAT(outcome.err, Contains("training diverged. Lower learning_rate (now 1e"));
      for (const auto& [name, contents] : files_of(folder / "model")) {
        CAPTURE(name);
        if (name.starts_with("member-") && name.ends_with(".json")) CHECK(outcome.exit_code == 0);
        CHECK(contents.find("null") == std::string::npos);
      }
    }
}
