// What a training does when: rate, clipping, growing windows, Muon.

#include <cmath>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "core/errors.hpp"
#include "ensemble/model_files.hpp"
#include "ensemble/synthetic.hpp"
#include "temporary_folder.hpp"

using namespace leeway;
using namespace leeway::ensemble;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinRel;

namespace {

TrainingConfig curriculum_config() {
  TrainingConfig config;
  config.steps = 40;
  config.curriculum = {{6, 0.2}, {20, 0.3}};
  config.initial_state_steps = 10;
  config.hidden_layers = 3;
  config.hidden_units = 16;
  config.batch_size = 4;
  config.epochs = 20;
  config.members = 1;
  config.learning_rate = 3e-3;
  config.schedule = RateSchedule::cosine;
  config.gradient_clip_norm = 100.0;
  return config;
}

std::vector<Trajectory> recordings() { return {test::synthetic_recording(1, 130), test::synthetic_recording(2, 75)}; }

TrainingConfig config_from(const std::string& text) {
  const io::Json json = io::parse_json(text, "config.json");
  return training_config_from(io::JsonObject(json, "config.json"));
}

}  // namespace

TEST_CASE("schedule: the rate falls along half a cosine, or stays", "[ensemble][schedule]") {
  TrainingConfig config;
  config.learning_rate = 5e-3;
  CHECK(learning_rate(config, 0.9) == 5e-3);
  config.schedule = RateSchedule::cosine;
  CHECK(learning_rate(config, 0.0) == 5e-3);
  CHECK_THAT(learning_rate(config, 1.0 / 3.0), WithinRel(0.75 * 5e-3, 1e-14));  // cos(pi/3) = 1/2
  CHECK_THAT(learning_rate(config, 0.5), WithinRel(0.5 * 5e-3, 1e-14));
  CHECK(learning_rate(config, 1.0) == 0.0);
}

TEST_CASE("schedule: clipping bounds the norm, keeps the direction, and leaves small gradients alone",
          "[ensemble][schedule]") {
  nn::AlignedVector<float> gradient{3.0F, -4.0F, 12.0F};  // of norm 13
  const nn::AlignedVector<float> before = gradient;
  clip(gradient, 13.1);
  CHECK(gradient == before);
  clip(gradient, 6.5);
  CHECK(gradient == nn::AlignedVector<float>{1.5F, -2.0F, 6.0F});
}

TEST_CASE("schedule: windows grow when their share of the epochs is done", "[ensemble][schedule]") {
  TrainingConfig config;
  config.epochs = 500;
  CHECK(curriculum_stage(config, 0) == 0);  // no stages: whole windows at once
  config.curriculum = {{12, 0.1}, {25, 0.1}, {50, 0.15}};
  for (const auto& [epoch, stage] : {std::pair{0, 0}, std::pair{49, 0}, std::pair{50, 1}, std::pair{99, 1},
                                     std::pair{100, 2}, std::pair{174, 2}, std::pair{175, 3}, std::pair{499, 3}}) {
    CAPTURE(epoch);
    CHECK(curriculum_stage(config, epoch) == static_cast<std::size_t>(stage));
  }
}

TEST_CASE("schedule: short windows cover every point, and see as much of the start as long ones",
          "[ensemble][schedule]") {
  const TrainingData data = prepare_training_data(recordings(), curriculum_config());
  REQUIRE(data.curriculum.size() == 2);
  CHECK(&data.windows_of_epoch(3) == &data.curriculum[0]);
  CHECK(&data.windows_of_epoch(4) == &data.curriculum[1]);
  CHECK(&data.windows_of_epoch(10) == &data.windows);
  std::size_t alike = 0;
  for (const auto& windows : data.curriculum) {
    std::vector<std::vector<int>> covered;
    for (const Samples& s : data.stretches) covered.emplace_back(static_cast<std::size_t>(s.size()), 0);
    for (const Window& w : windows) {
      for (Eigen::Index k = 0; k < w.range.size; ++k) ++covered[w.stretch][static_cast<std::size_t>(w.range.begin + k)];
      const bool in_sight = w.range.begin + 10 <= data.stretches[w.stretch].size();
      CHECK(w.initial_state_inputs.size() == (in_sight ? data.inputs.initial_state.size() : 0));
      for (const Window& whole : data.windows)
        if (whole.stretch == w.stretch && whole.range.begin == w.range.begin) {
          CHECK(whole.initial_state_inputs == w.initial_state_inputs);
          ++alike;
        }
    }
    for (const auto& counts : covered) CHECK(*std::min_element(counts.begin(), counts.end()) == 1);
  }
  CHECK(alike >= 4);
}

TEST_CASE("schedule: with growing windows and Muon, a stop at any step continues to the same bits",
          "[ensemble][schedule]") {
  for (const Optimizer optimizer : {Optimizer::adam, Optimizer::muon}) {
    TrainingConfig config = curriculum_config();
    config.optimizer = optimizer;
    const TrainingData data = prepare_training_data(recordings(), config);
    const EnsembleHeader header = make_header(data, 1, {});
    const test::TemporaryFolder folder;
    const std::string path = folder.path().string();
    TrainingState whole = initial_training_state(data, 1, 0, nn::kernels());
    REQUIRE(train(data, 1, nn::kernels(), whole, [](const TrainingState&) { return true; }));
    TrainingState stopped = initial_training_state(data, 1, 0, nn::kernels());
    int steps = 0;
    while (!train(data, 1, nn::kernels(), stopped, [&](const TrainingState&) { return ++steps % 7 != 0; })) {
      write_checkpoint(path, stopped, header);
      stopped = *read_checkpoint(path, 0, header);
    }
    CHECK(stopped.member.parameters == whole.member.parameters);
    CHECK(stopped.member.training_curve == whole.member.training_curve);
    CHECK(whole.member.training_curve.back() < 0.5F * whole.member.training_curve[10]);
  }
}

TEST_CASE("schedule: the keys read back, and a training without them is the training that it was",
          "[ensemble][schedule]") {
  const TrainingConfig config = config_from(
      R"({"steps": 100, "curriculum": [{"steps": 12, "share": 0.1}, {"steps": 50, "share": 0.25}], "optimizer": "muon",
          "muon_rate_factor": 2.5})");
  CHECK(config.curriculum == std::vector<CurriculumStage>{{12, 0.1}, {50, 0.25}});
  CHECK(config.optimizer == Optimizer::muon);
  CHECK(config_from(to_json(config).dump()).curriculum == config.curriculum);
  CHECK(config_from(to_json(config).dump()).muon_rate_factor == 2.5);
  for (const char* name : {"model-scale", "full-scale"}) {
    const TrainingConfig paper = read_training_config(name);
    CHECK(paper.curriculum.empty());
    CHECK(paper.optimizer == Optimizer::adam);
    CHECK(paper.gradient_clip_norm == 0.0);
    CHECK(paper.schedule == RateSchedule::constant);
    for (const char* key : {"curriculum", "optimizer", "muon_rate_factor"}) CHECK_FALSE(to_json(paper).contains(key));
  }
  const TrainingConfig fast = read_training_config("fast");
  CHECK(fast.follows.empty());
  CHECK(fast.epochs == 150);
  CHECK(curriculum_stage(fast, 74) == 2);
  CHECK(curriculum_stage(fast, 75) == 3);

  const auto refused = [](const std::string& text, const std::string& message) {
    CHECK_THROWS_WITH(config_from(text), Contains("config.json: " + message));
  };
  refused(R"({"optimizer": "sgd"})", "/optimizer: ");
  refused(R"({"curriculum": 12})", "/curriculum: ");
  refused(R"({"curriculum": [{"steps": 12}]})", "/curriculum/0/share: ");
  refused(R"({"curriculum": [{"steps": 1, "share": 0.1}]})", "/curriculum/0/steps: ");
  refused(R"({"curriculum": [{"steps": 101, "share": 0.1}]})", "/curriculum/0/steps: ");
  refused(R"({"curriculum": [{"steps": 12, "share": 0.5}, {"steps": 25, "share": 0.5}]})",
          "/curriculum: expected shares that leave some to the whole windows");
  refused(R"({"curriculum": [{"steps": 12, "share": 0.1, "epochs": 5}]})", "/curriculum/0/epochs: unknown key");
}

TEST_CASE("schedule: what says that it follows the paper, has the paper's numbers", "[ensemble][schedule]") {
  for (const char* name : {"model-scale", "full-scale"}) {
    const TrainingConfig paper = read_training_config(name);
    CHECK(paper.follows == "paper");
    CHECK(config_from(to_json(paper).dump()).follows == "paper");
    io::Json json = to_json(paper);
    json["members"] = 75;  // as in the paper's discussion
    CHECK(config_from(json.dump()).members == 75);
    for (const auto& [key, value] : std::initializer_list<std::pair<const char*, io::Json>>{
             {"steps", 99},
             {"initial_state_steps", 20},
             {"initial_state_net", false},
             {"hidden_layers", 2},
             {"hidden_units", 64},
             {"learning_rate", 2e-4},
             {"learning_rate_schedule", "cosine"},
             {"gradient_clip_norm", 1000},
             {"optimizer", "muon"},
             {"batch_size", 8},
             {"integrator_predict", "euler"},
             {"state_resampling", "average"},
             {"time_step_s", 2.0},
             {"epochs", 150},
             {"curriculum", {{{"steps", 12}, {"share", 0.1}}}},
             {"sigma", {{"u_mps", 0.02}, {"vm_mps", 0.01}, {"r_degps", 0.1}}},
             {"sigma", {{"u_mps", 0.01}, {"vm_mps", 0.01}, {"r_degps", 0.05}}}}) {
      io::Json changed = to_json(paper);
      changed[key] = value;
      CAPTURE(name, key);
      CHECK_THROWS_WITH(config_from(changed.dump()), Contains("config.json: /follows: 'paper', but") && Contains(key));
    }
  }
  CHECK_THROWS_WITH(config_from(R"({"follows": "me"})"), Contains("/follows: "));
}
