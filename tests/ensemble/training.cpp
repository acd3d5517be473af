#include "ensemble/training.hpp"

#include <cmath>
#include <filesystem>

#include <catch2/catch.hpp>

#include "core/errors.hpp"
#include "ensemble/ensemble_training.hpp"
#include "ensemble/synthetic.hpp"
#include "io/files.hpp"
#include "temporary_folder.hpp"

using namespace leeway;
using namespace leeway::ensemble;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;
namespace fs = std::filesystem;

namespace {

TrainingConfig small_config() {
  TrainingConfig config;
  config.steps = 20;
  config.initial_state_steps = 5;
  config.hidden_layers = 2;
  config.hidden_units = 16;
  config.batch_size = 4;
  config.epochs = 6;
  config.members = 3;
  config.learning_rate = 1e-3;
  return config;
}

TrainingData small_data(const TrainingConfig& config) {
  return prepare_training_data({test::synthetic_recording(1, 130), test::synthetic_recording(2, 75)}, config);
}

std::string hash(const test::TemporaryFolder& folder, const std::string& file) {
  return io::sha256_of_file(folder / file);
}

void train_all(const TrainingData& data, const std::string& folder, std::vector<int> members, std::size_t jobs,
               bool resume = false) {
  const EnsembleHeader header = make_header(data, 1, {});
  train_ensemble(data, header, {folder, std::move(members), resume, 0.0, jobs}, nn::kernels(), [](int, int, double) {});
}

}  // namespace

TEST_CASE("training data: inputs are found from the columns, constant ones are left out with a notice", "[ensemble]") {
  const TrainingData data = small_data(small_config());
  REQUIRE(data.inputs.actuators == std::vector<Channel>{Channel::delta_p, Channel::delta_s, Channel::n_bt});
  REQUIRE(data.inputs.wind);
  REQUIRE(data.inputs.inputs.size() == 8);
  CHECK(data.inputs.inputs[3].name == "delta_p_rad");
  CHECK(data.inputs.inputs[7].name == "app_wind_y_mps");
  REQUIRE(data.inputs.constants.size() == 1);
  CHECK(data.inputs.constants[0].first == Channel::n_p);
  REQUIRE(data.notices.size() == 1);
  CHECK_THAT(data.notices[0], Contains("n_p_rps"));
}

TEST_CASE("training data: a ship with one rudder and a propeller has seven inputs", "[ensemble]") {
  Trajectory t = test::synthetic_recording(4, 60);
  t[Channel::delta] = t[Channel::delta_p];
  for (std::size_t i = 0; i < t.size(); ++i) t[Channel::n_p][i] = 8.0 + static_cast<double>(i % 3);
  for (const Channel channel : {Channel::delta_p, Channel::delta_s, Channel::n_bt}) t[channel].clear();
  const TrainingData data = prepare_training_data({t}, small_config());
  CHECK(data.inputs.actuators == std::vector<Channel>{Channel::delta, Channel::n_p});
  CHECK(data.inputs.inputs.size() == 7);
}

TEST_CASE("training data: no recorded second is dropped", "[ensemble]") {
  const TrainingData data = small_data(small_config());
  for (std::size_t s = 0; s < data.stretches.size(); ++s) {
    std::vector<int> covered(static_cast<std::size_t>(data.stretches[s].size()), 0);
    for (const Window& w : data.windows)
      if (w.stretch == s)
        for (Eigen::Index k = 0; k < w.range.size; ++k) ++covered[static_cast<std::size_t>(w.range.begin + k)];
    CHECK(*std::min_element(covered.begin(), covered.end()) == 1);
  }
  CHECK(data.windows.size() == 7 + 4);
}

TEST_CASE("training data: the accelerations' mean and deviation are those of numerical differentiation", "[ensemble]") {
  const Trajectory t = test::synthetic_recording(1, 130);
  const TrainingData data = prepare_training_data({t}, small_config());
  double mean = 0.0, square = 0.0;
  for (std::size_t i = 0; i + 1 < t.size(); ++i) mean += (t[Channel::r][i + 1] - t[Channel::r][i]) / 129.0;
  for (std::size_t i = 0; i + 1 < t.size(); ++i)
    square += std::pow(t[Channel::r][i + 1] - t[Channel::r][i] - mean, 2) / 129.0;
  CHECK_THAT(data.inputs.accelerations[2].mean, WithinAbs(mean, 1e-15));
  CHECK_THAT(data.inputs.accelerations[2].sd, WithinRel(std::sqrt(square), 1e-12));
}

TEST_CASE("training data: where the pond lies does not matter to the initial-state network", "[ensemble]") {
  Trajectory t = test::synthetic_recording(1, 60);
  const TrainingData here = prepare_training_data({t}, small_config());
  for (std::size_t i = 0; i < t.size(); ++i) {
    const double x = t[Channel::x0][i], y = t[Channel::y0][i];
    t[Channel::x0][i] = 1000.0 - y;  // a quarter turn to starboard, and far away; the wind turns along
    t[Channel::y0][i] = -500.0 + x;
    t[Channel::psi][i] += std::acos(-1.0) / 2.0;
    t[Channel::wind_dir][i] += std::acos(-1.0) / 2.0;
  }
  const TrainingData there = prepare_training_data({t}, small_config());
  REQUIRE(here.inputs.initial_state.size() == 30);
  for (std::size_t j = 0; j < 30; ++j) {
    CHECK_THAT(there.inputs.initial_state[j].mean, WithinAbs(here.inputs.initial_state[j].mean, 1e-9));
    CHECK_THAT(there.inputs.initial_state[j].sd, WithinRel(here.inputs.initial_state[j].sd, 1e-6));
  }
  CHECK_THAT(there.inputs.inputs[7].mean, WithinAbs(here.inputs.inputs[7].mean, 1e-9));
}

TEST_CASE("training data: what cannot train anything is refused", "[ensemble]") {
  const TrainingConfig config = small_config();
  Trajectory still = test::synthetic_recording(1, 60, 1.0, false);
  for (const Channel channel : {Channel::delta_p, Channel::delta_s, Channel::n_bt})
    std::fill(still[channel].begin(), still[channel].end(), 0.3);
  CHECK_THROWS_WITH(prepare_training_data({still}, config), Contains("no actuator column varies"));
  Trajectory straight = test::synthetic_recording(1, 60);
  std::fill(straight[Channel::r].begin(), straight[Channel::r].end(), 0.0);
  CHECK_THROWS_WITH(prepare_training_data({straight}, config), Contains("'r_radps' never varies"));
  CHECK_THROWS_WITH(prepare_training_data({test::synthetic_recording(1, 4)}, config), Contains("too little data"));
  Trajectory without = test::synthetic_recording(3, 60);
  without[Channel::n_bt].clear();
  without.file = "no-thruster.csv";
  CHECK_THROWS_WITH(prepare_training_data({test::synthetic_recording(1, 60), without}, config),
                    Contains("no-thruster.csv:1: no column 'n_bt_rps'"));
}

TEST_CASE("training: outputs are standardized at initialization", "[ensemble]") {
  const TrainingData data = small_data(small_config());
  const TrainingState state = initial_training_state(data, 1, 0, nn::kernels());
  const nn::KernelWorkspace<float> workspace(nn::kernels());
  RandomStream random(99, "other inputs");  // not those that the mean and deviation were taken from
  constexpr int n = 20000;
  nn::AlignedVector<float> inputs(8 * n), outputs(3 * n);
  for (float& x : inputs) x = static_cast<float>(random.normal());
  const nn::PackedNetwork<float> network(nn::kernels(), state.member.dynamics, state.member.parameters.data());
  nn::kernels().forward(workspace.get(), network.get(), inputs.data(), n, outputs.data());
  for (std::size_t i = 0; i < 3; ++i) {
    double mean = 0.0, square = 0.0;
    for (std::size_t k = 0; k < n; ++k) {
      const double z = (outputs[3 * k + i] - state.member.output_mean[i]) / state.member.output_sd[i];
      mean += z / n;
      square += z * z / n;
    }
    CHECK_THAT(mean, WithinAbs(0.0, 0.06));  // 4 standard errors of the two sample means
    CHECK_THAT(square, WithinAbs(1.0, 0.08));
  }
}

TEST_CASE("training: the loss falls, and members differ", "[ensemble]") {
  TrainingConfig config = small_config();
  config.epochs = 60;
  const TrainingData data = small_data(config);
  TrainingState a = initial_training_state(data, 1, 0, nn::kernels());
  TrainingState b = initial_training_state(data, 1, 1, nn::kernels());
  CHECK(a.member.parameters != b.member.parameters);
  train(data, 1, nn::kernels(), a, [](const TrainingState&) {});
  REQUIRE(a.member.training_curve.size() == 60);
  CHECK(a.member.training_curve.back() < 0.3F * a.member.training_curve.front());
}

TEST_CASE("training: the same bytes with any number of jobs, member by member, and resumed", "[ensemble]") {
  const TrainingConfig config = small_config();
  const TrainingData data = small_data(config);
  const test::TemporaryFolder one, two, single, resumed;
  train_all(data, one.path().string(), {0, 1, 2}, 1);
  train_all(data, two.path().string(), {0, 1, 2}, 2);
  train_all(data, single.path().string(), {2}, 1);
  train_all(data, single.path().string(), {0}, 1);
  for (const char* file : {"member-00.json", "member-01.json", "member-02.json"})
    CHECK(hash(one, file) == hash(two, file));
  CHECK(hash(one, "member-02.json") == hash(single, "member-02.json"));
  CHECK(hash(one, "member-00.json") == hash(single, "member-00.json"));

  // Stop after three epochs as a killed run would leave it: its last checkpoint.
  const EnsembleHeader header = make_header(data, 1, {});
  struct Stop {};
  for (const int number : {0, 1, 2}) {
    TrainingState state = initial_training_state(data, 1, number, nn::kernels());
    CHECK_THROWS_AS(train(data, 1, nn::kernels(), state,
                          [&](const TrainingState& now) {
                            if (now.epochs_done < 3) return;
                            write_checkpoint(resumed.path().string(), now, header);
                            throw Stop{};
                          }),
                    Stop);
  }
  train_all(data, resumed.path().string(), {0, 1, 2}, 1, true);
  for (const char* file : {"member-00.json", "member-01.json", "member-02.json"})
    CHECK(hash(one, file) == hash(resumed, file));
  CHECK(!fs::exists(checkpoint_path(resumed.path().string(), 0)));
}

TEST_CASE("model files: weights read back to the same bits, and another training's files are refused", "[ensemble]") {
  const TrainingData data = small_data(small_config());
  const test::TemporaryFolder folder;
  const EnsembleHeader header = make_header(data, 1, {});
  write_header(folder.path().string(), header, io::Json::object());
  TrainingState state = initial_training_state(data, 1, 0, nn::kernels());
  state.member.training_curve = {1.5F, 0.1F};
  write_member(folder.path().string(), state.member, header);
  const EnsembleHeader read = *read_header(folder.path().string());
  CHECK(read.training_id == header.training_id);
  CHECK(make_header({read.config, read.inputs, {}, {}, {}}, read.seed, {}).training_id == header.training_id);
  const Member member = read_member(folder.path().string(), 0, read);
  CHECK(member.parameters == state.member.parameters);
  CHECK(member.output_mean == state.member.output_mean);
  CHECK(member.output_sd == state.member.output_sd);
  CHECK(member.training_curve == state.member.training_curve);
  const EnsembleHeader other = make_header(data, 2, {});
  CHECK_THROWS_WITH(read_member(folder.path().string(), 0, other), Contains("another training"));
}

TEST_CASE("training: a diverging loss is an error that says what to lower", "[ensemble]") {
  TrainingConfig config = small_config();
  config.learning_rate = 1e37;
  config.epochs = 50;
  const TrainingData data = small_data(config);
  TrainingState state = initial_training_state(data, 1, 0, nn::kernels());
  CHECK_THROWS_WITH(train(data, 1, nn::kernels(), state, [](const TrainingState&) {}), Contains("learning_rate"));
}
