#include "ensemble/training.hpp"

#include <cmath>
#include <filesystem>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

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

const TrainingReports kSilent{[](int, const MemberProgress&) {}, [](const std::string&) {}};

std::string hash(const test::TemporaryFolder& folder, const std::string& file) {
  return io::sha256_of_file(folder / file);
}

void train_all(const TrainingData& data, const std::string& folder, std::vector<int> members, std::size_t jobs,
               bool resume = false) {
  const EnsembleHeader header = make_header(data, 1, {});
  train_ensemble(data, header, {folder, std::move(members), resume, 0.0, jobs}, nn::kernels(), kSilent);
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
  train(data, 1, nn::kernels(), a, [](const TrainingState&) { return true; });
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
  for (const int number : {0, 1, 2}) {
    TrainingState state = initial_training_state(data, 1, number, nn::kernels());
    CHECK_FALSE(train(data, 1, nn::kernels(), state, [&](const TrainingState& now) { return now.epochs_done < 3; }));
    write_checkpoint(resumed.path().string(), state, header);
  }
  train_all(data, resumed.path().string(), {0, 1, 2}, 1, true);
  for (const char* file : {"member-00.json", "member-01.json", "member-02.json"})
    CHECK(hash(one, file) == hash(resumed, file));
  CHECK(!fs::exists(checkpoint_path(resumed.path().string(), 0)));
}

TEST_CASE("training: stopped after any optimizer step, it continues to the same bits", "[ensemble]") {
  TrainingConfig config = small_config();
  config.schedule = RateSchedule::cosine;
  config.gradient_clip_norm = 100.0;
  const TrainingData data = small_data(config);
  const EnsembleHeader header = make_header(data, 1, {});
  const test::TemporaryFolder whole, stopped;
  train_all(data, whole.path().string(), {1}, 1);
  const std::string folder = stopped.path().string();
  // 11 windows in batches of 4 are 3 steps: stops of 1, 2, 3, ... steps meet every place of an epoch.
  for (int length = 1; length <= 7; ++length) {
    CAPTURE(length);
    TrainingState state = initial_training_state(data, 1, 1, nn::kernels());
    int steps = 0;
    bool between = false;
    while (!train(data, 1, nn::kernels(), state, [&](const TrainingState&) { return ++steps % length != 0; })) {
      between = between || state.windows_done > 0;
      write_checkpoint(folder, state, header);
      state = *read_checkpoint(folder, 1, header);
    }
    CHECK(steps == 18);
    CHECK((between || length % 3 == 0));
    write_member(folder, state.member, header);
    CHECK(hash(stopped, "member-01.json") == hash(whole, "member-01.json"));
  }
}

TEST_CASE("training: a stop is asked for after every step, and leaves a checkpoint", "[ensemble]") {
  const TrainingData data = small_data(small_config());
  const EnsembleHeader header = make_header(data, 1, {});
  const test::TemporaryFolder whole, stopped;
  train_all(data, whole.path().string(), {0, 1, 2}, 1);
  int asked = 0, stops = 0;
  EnsembleTraining training{stopped.path().string(), {0, 1, 2}, true, 1000.0, 1, nullptr, {}};
  training.stop = [&] { return ++asked % 5 == 0; };
  while (!train_ensemble(data, header, training, nn::kernels(), kSilent)) ++stops;
  CHECK(stops >= 4);
  CHECK(stopped.listing() == whole.listing());
  for (const char* file : {"member-00.json", "member-01.json", "member-02.json"})
    CHECK(hash(stopped, file) == hash(whole, file));
}

TEST_CASE("training: a checkpoint that is damaged or cut anywhere is refused", "[ensemble]") {
  const TrainingData data = small_data(small_config());
  const EnsembleHeader header = make_header(data, 1, {});
  const test::TemporaryFolder folder;
  const std::string path = folder.path().string(), file = checkpoint_path(path, 0);
  write_checkpoint(path, initial_training_state(data, 1, 0, nn::kernels()), header);
  const std::string good = io::read_text(file);
  REQUIRE(read_checkpoint(path, 0, header));
  for (const std::size_t size : {std::size_t{0}, std::size_t{10}, std::size_t{50}, std::size_t{84}, std::size_t{85},
                                 good.size() / 2, good.size() - 1}) {
    CAPTURE(size);
    io::write_text(file, good.substr(0, size));
    CHECK_THROWS_AS(read_checkpoint(path, 0, header), InputError);
  }
  std::string flipped = good;
  flipped[good.size() / 2] = static_cast<char>(flipped[good.size() / 2] ^ 1);
  io::write_text(file, flipped);
  CHECK_THROWS_WITH(read_checkpoint(path, 0, header), Contains("is damaged"));
  io::write_text(file, "\xa9 as the versions before");
  CHECK_THROWS_WITH(read_checkpoint(path, 0, header), Contains("not a checkpoint of this version"));
}

TEST_CASE("training: held-out data are seen with the inputs and standardization of the training", "[ensemble]") {
  const TrainingConfig config = small_config();
  const TrainingData data = small_data(config);
  const TrainingData held_out = prepare_held_out_data({test::synthetic_recording(3, 90)}, data);
  CHECK(held_out.windows.size() == 5);
  CHECK(held_out.inputs.inputs[0].mean == data.inputs.inputs[0].mean);
  // Those of the training itself are the same windows again.
  const TrainingData same =
      prepare_held_out_data({test::synthetic_recording(1, 130), test::synthetic_recording(2, 75)}, data);
  REQUIRE(same.windows.size() == data.windows.size());
  for (std::size_t w = 0; w < same.windows.size(); ++w)
    CHECK(same.windows[w].initial_state_inputs == data.windows[w].initial_state_inputs);
  // At a vanishing rate the mean over an epoch's batches is the loss of the member.
  TrainingConfig still = config;
  still.learning_rate = 1e-30;
  still.epochs = 1;
  const TrainingData unmoved = small_data(still);
  TrainingState state = initial_training_state(unmoved, 1, 0, nn::kernels());
  train(unmoved, 1, nn::kernels(), state, [](const TrainingState&) { return true; });
  CHECK_THAT(mean_loss(same, state.member, nn::kernels()), WithinRel(state.member.training_curve.back(), 1e-4F));
  Trajectory without = test::synthetic_recording(3, 60);
  without[Channel::n_bt].clear();
  CHECK_THROWS_WITH(prepare_held_out_data({without}, data), Contains("no column 'n_bt_rps'"));
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
  CHECK(make_header({read.config, read.inputs, {}, {}, {}, {}}, read.seed, {}).training_id == header.training_id);
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
  CHECK_THROWS_WITH(train(data, 1, nn::kernels(), state, [](const TrainingState&) { return true; }),
                    Contains("learning_rate"));
}
