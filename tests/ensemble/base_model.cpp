#include "ensemble/base_model.hpp"

#include <cmath>
#include <filesystem>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "core/errors.hpp"
#include "dynamics/model_parts.hpp"
#include "dynamics/replay.hpp"
#include "ensemble/ensemble_training.hpp"
#include "ensemble/prediction.hpp"
#include "ensemble/simulated.hpp"
#include "io/files.hpp"
#include "nn/numeric_gradient.hpp"
#include "temporary_folder.hpp"

using namespace leeway;
using namespace leeway::ensemble;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

Ship with_effects(const std::string& name, std::vector<EffectEntry> effects) {
  Ship ship = read_ship(name);
  for (EffectEntry& effect : effects) effect.file = name;
  ship.effects = std::move(effects);
  return ship;
}

std::shared_ptr<const BaseModel> base_of(const Ship& ship) {
  return std::make_shared<const BaseModel>(ship, ship.name);
}

// Effects of every kind: on the water, the wind, the forces (by heading and by time) and the actuators.
const std::vector<EffectEntry> kMany{
    {"steady-current", {{"current_speed_mps", 0.08}, {"current_set_deg", 70.0}}, "", ""},
    {"varying-current", {{"current_sd_mps", 0.03}, {"tau_s", 40.0}}, "", ""},
    {"unmeasured-wind", {{"wind_speed_mps", 0.9}, {"wind_dir_deg", 200.0}}, "", ""},
    {"earth-force", {{"force_N", 0.4}, {"direction_deg", 30.0}}, "", ""},
    {"rudder-offset", {{"rudder_offset_deg", 3.0}}, "", ""},
    {"fouling", {{"resistance_increase", 0.3}}, "", ""}};

TrainingConfig residual_config() {
  TrainingConfig config;
  config.steps = 12;
  config.initial_state_steps = 4;
  config.hidden_layers = 2;
  config.hidden_units = 7;
  config.batch_size = 4;
  config.members = 2;
  config.epochs = 4;
  config.learning_rate = 1e-3;
  config.pose_scale = {0.3, 0.3, 0.2};  // so that the heading correction matters
  config.sigma = {0.05, 0.04, 0.02};
  return config;
}

nn::AlignedVector<double> as_double(const nn::AlignedVector<float>& values) { return {values.begin(), values.end()}; }

// Networks without output.
void silence(ModelInputs& inputs, Member& member) {
  std::fill(member.parameters.begin(), member.parameters.end(), 0.0F);
  member.output_mean = {};
  for (Spread& acceleration : inputs.accelerations) acceleration.mean = 0.0;
}

double squared_error(const SequencePrediction& p, const Samples& samples, Range range) {
  double sum = 0.0;
  for (Eigen::Index k = 1; k < range.size; ++k) {
    const auto i = static_cast<std::size_t>(k);
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const int state : p.state[i]) mean += p.nu[i].col(state) / static_cast<double>(p.state[i].size());
    sum += (mean - samples.nu.col(range.begin + k)).squaredNorm() / static_cast<double>(range.size - 1);
  }
  return sum;
}

}  // namespace

TEST_CASE("base model: the derivatives of a step agree with central differences", "[ensemble][base]") {
  const std::vector<EffectEntry> of_single_rudder{kMany[0], kMany[3], kMany[5]};
  for (const Ship& ship : {with_effects("vectwin-3m", kMany), with_effects("esso-osaka-3m", of_single_rudder),
                           with_effects("kvlcc2-l7", of_single_rudder)}) {
    CAPTURE(ship.name);
    const BaseModel base(ship, "");
    Inputs<double> held{ship.initial_actuators(), {0.5, -0.8}, 30.0};
    for (const Actuator& a : ship.actuators)
      if (a.is_rudder()) held.actuators[a.channel] += 0.2;
    for (const Vec3<double>& nu : {Vec3<double>(0.4, 0.05, 0.02), Vec3<double>(0.1, -0.08, -0.06)}) {
      const BaseModel::MeanRates exact = base.mean_rates(nu, 0.7, held, 1.0);
      Eigen::Vector4d at;
      at << nu, 0.7;
      const double h = 1e-6;
      for (int j = 0; j < 4; ++j) {
        Eigen::Vector4d above = at, below = at;
        above(j) += h;
        below(j) -= h;
        const Eigen::Vector4d difference = (base.mean_rates(above.head<3>(), above(3), held, 1.0).rates -
                                            base.mean_rates(below.head<3>(), below(3), held, 1.0).rates) /
                                           (2.0 * h);
        for (int i = 0; i < 4; ++i) CHECK_THAT(exact.derivatives(i, j), WithinAbs(difference(i), 1e-7));
      }
      const ShipState<double> end = base.step({Vec3<double>(3.0, -4.0, 0.7), nu}, held, 1.0);
      for (int i = 0; i < 3; ++i) CHECK_THAT(nu(i) + exact.rates(i), WithinAbs(end.nu(i), 1e-14));
      CHECK_THAT(0.7 + exact.rates(3), WithinAbs(end.eta(2), 1e-14));
    }
  }
}

TEST_CASE("base model: the gradient of the whole loss agrees with central differences", "[ensemble][base]") {
  const Ship ship = with_effects("vectwin-3m", kMany), truth = read_ship("vectwin-3m");
  // 29 points: windows of 12 with an overlap; 9 and 3: shorter than K, and shorter than K_init.
  const TrainingData data = prepare_training_data(
      {test::simulated_recording(truth, 1, 29, 0.01), test::simulated_recording(truth, 2, 9, 0.01),
       test::simulated_recording(truth, 3, 3, 0.01)},
      residual_config(), base_of(ship));
  REQUIRE(data.windows.size() == 5);
  REQUIRE(data.inputs.base_actuators == std::vector<Channel>{Channel::n_p});
  const TrainingState state = initial_training_state(data, 5, 0, nn::kernels("portable"));
  const RolloutConstants<double> constants(data.inputs, data.config, state.member);
  std::vector<std::size_t> windows(data.windows.size());
  for (std::size_t i = 0; i < windows.size(); ++i) windows[i] = i;
  WindowBatch<double> batch;
  batch.assign(data, windows.data(), windows.size());
  const nn::Kernels<double>& kernels = nn::kernels_double();
  const nn::KernelWorkspace<double> workspace(kernels);
  nn::AlignedVector<double> parameters = as_double(state.member.parameters);
  nn::AlignedVector<double> gradient(parameters.size());
  const auto loss = [&](nn::AlignedVector<double>& out) {
    return kernels.loss_and_gradient(workspace.get(), constants.view(), batch.view(), parameters.data(), out.data());
  };
  const double exact_loss = loss(gradient);
  const double norm = test::largest_component(gradient);
  REQUIRE(norm > 0.0);
  CHECK(test::gradient_error(loss, parameters, gradient, 1e-5) < 1e-6);

  for (const std::string& name : nn::available_kernels()) {
    CAPTURE(name);
    const RolloutConstants<float> float_constants(data.inputs, data.config, state.member);
    WindowBatch<float> float_batch;
    float_batch.assign(data, windows.data(), windows.size());
    nn::AlignedVector<float> float_gradient(parameters.size());
    const nn::KernelWorkspace<float> float_workspace(nn::kernels(name));
    CHECK_THAT(nn::kernels(name).loss_and_gradient(float_workspace.get(), float_constants.view(), float_batch.view(),
                                                   state.member.parameters.data(), float_gradient.data()),
               WithinRel(exact_loss, 1e-4));
    for (std::size_t i = 0; i < gradient.size(); ++i) CHECK(std::abs(float_gradient[i] - gradient[i]) < 1e-3 * norm);
  }
}

TEST_CASE("base model: with silent networks training and prediction are a replay that holds its inputs",
          "[ensemble][base]") {
  // A replay holds a sample until 1e-6 s before the next one; it matters to effects that change with time alone.
  const bool with_time = GENERATE(true, false);
  const double tolerance = with_time ? 2e-6 : 1e-12;
  std::vector<EffectEntry> effects = kMany;
  if (!with_time) effects.erase(effects.begin() + 1);
  const Ship ship = with_effects("vectwin-3m", effects);
  const Trajectory recording = test::simulated_recording(read_ship("vectwin-3m"), 4, 40, 0.01);
  TrainingConfig config = residual_config();
  config.steps = 40;
  config.initial_state_net = false;
  TrainingData data = prepare_training_data({recording}, config, base_of(ship));
  Member member = initial_training_state(data, 1, 0, nn::kernels()).member;
  silence(data.inputs, member);
  const Ensemble ensemble(make_header(data, 1, {}), {member}, nn::kernels(), data.base);
  EnsembleEvaluator evaluator(ensemble);
  const Samples& samples = data.stretches.front();

  const Trajectory expected =
      replay(ship, recording, RecordedInputs(recording, ship, InputInterpolation::hold), {1.0, 1.0, 39.0});
  REQUIRE(expected.size() == 40);
  const Range all{0, 40};
  const SequencePrediction predicted = predict_sequence(evaluator, ensemble, samples, all, 0, {});
  const SequencePrediction fitted = fitted_rollout(evaluator, ensemble, samples, all);
  double error = 0.0;
  for (std::size_t k = 0; k < 40; ++k) {
    const Vec3<double> nu(expected[Channel::u][k], expected[Channel::vm][k], expected[Channel::r][k]);
    const Vec3<double> eta(expected[Channel::x0][k], expected[Channel::y0][k], expected[Channel::psi][k]);
    for (const SequencePrediction* p : {&predicted, &fitted}) {
      CHECK((p->nu[k].col(0) - nu).cwiseAbs().maxCoeff() < tolerance);
      CHECK((p->eta[k].col(0) - eta).cwiseAbs().maxCoeff() < tolerance);
    }
    error += (nu - samples.nu.col(static_cast<Eigen::Index>(k))).cwiseQuotient(config.sigma).squaredNorm() / 40.0;
  }
  const RolloutConstants<double> constants(data.inputs, config, member);
  const std::size_t window = 0;
  WindowBatch<double> batch;
  batch.assign(data, &window, 1);
  const nn::KernelWorkspace<double> workspace(nn::kernels_double());
  const nn::AlignedVector<double> parameters = as_double(member.parameters);
  nn::AlignedVector<double> gradient(parameters.size());
  CHECK_THAT(nn::kernels_double().loss_and_gradient(workspace.get(), constants.view(), batch.view(), parameters.data(),
                                                    gradient.data()),
             WithinRel(error, with_time ? 1e-4 : 1e-10));
}

TEST_CASE("base model: the outputs' scale is that of what the base leaves over", "[ensemble][base]") {
  const Ship truth = with_effects("vectwin-3m", {{"body-force", {{"X_N", 0.6}, {"N_Nm", 0.1}}, "", ""}});
  const Ship ship = read_ship("vectwin-3m");
  const Trajectory recording = test::simulated_recording(truth, 1, 400, 0.01);
  TrainingConfig config = residual_config();
  config.sigma = {0.01, 0.01, 0.001};
  const TrainingData plain = prepare_training_data({recording}, config);
  const TrainingData based = prepare_training_data({recording}, config, base_of(ship));
  const double M_x =
      Inertia<double>(ship.inertia, ship.particulars).m + Inertia<double>(ship.inertia, ship.particulars).m_x;
  // A constant force: the mean holds it, and what varies is noise, 0.01 sqrt(2)/10 m/s^2 in means of ten steps (a few
  // thousandths once the base has seen the noisy states), where single differences have 0.01 sqrt(2).
  CHECK_THAT(based.inputs.accelerations[0].mean, WithinRel(0.6 / M_x, 0.15));
  CHECK(plain.inputs.accelerations[0].sd > 0.014);
  CHECK(based.inputs.accelerations[0].sd < 0.003);
  // Where nothing is left over, the scale is what adds up to sigma over a window.
  const TrainingData exact = prepare_training_data({test::simulated_recording(ship, 1, 400)}, config, base_of(ship));
  for (std::size_t i = 0; i < 3; ++i)
    CHECK_THAT(exact.inputs.accelerations[i].sd, WithinRel(config.sigma(static_cast<Eigen::Index>(i)) / 11.0, 1e-12));
}

TEST_CASE("base model: networks learn what it lacks", "[ensemble][base][long]") {
  const Ship ship = read_ship("vectwin-3m");
  const Ship truth = with_effects("vectwin-3m", {{"fouling", {{"resistance_increase", 0.6}}, "", ""},
                                                 {"windage", {{"kX", 2.0}, {"kY", 2.0}, {"kN", 2.0}}, "", ""}});
  TrainingConfig config;
  config.steps = 50;
  config.initial_state_net = false;
  config.hidden_layers = 1;
  config.hidden_units = 16;
  config.batch_size = 4;
  config.epochs = 200;
  config.learning_rate = 3e-3;
  config.schedule = RateSchedule::cosine;
  config.gradient_clip_norm = 1000.0;
  config.members = 1;
  std::vector<Trajectory> training;
  for (const std::uint64_t seed : {1, 2, 3, 4}) training.push_back(test::simulated_recording(truth, seed, 300, 0.002));
  TrainingData data = prepare_training_data(training, config, base_of(ship));
  TrainingState state = initial_training_state(data, 1, 0, nn::kernels());
  train(data, 1, nn::kernels(), state, [](const TrainingState&) { return true; });
  const Ensemble trained(make_header(data, 1, {}), {state.member}, nn::kernels(), data.base);
  Member member = state.member;
  TrainingData silent = data;
  silence(silent.inputs, member);
  const Ensemble alone(make_header(silent, 1, {}), {member}, nn::kernels(), data.base);
  EnsembleEvaluator with_network(trained), without(alone);
  double error = 0.0, base_error = 0.0;
  for (const std::uint64_t seed : {11, 12, 13}) {
    const Samples samples =
        resample(test::simulated_recording(truth, seed, 200), data.inputs.sampled_actuators(), true, 1.0).front();
    for (const Range range : test_sequences(samples.size(), 50)) {
      error += squared_error(predict_sequence(with_network, trained, samples, range, 0, {}), samples, range);
      base_error += squared_error(predict_sequence(without, alone, samples, range, 0, {}), samples, range);
    }
  }
  CAPTURE(error, base_error, state.member.training_curve.back());
  CHECK(error < 0.4 * base_error);
}

TEST_CASE("base model: the same bytes member by member and resumed, with the ship in the folder", "[ensemble][base]") {
  const std::shared_ptr<const BaseModel> base = BaseModel::read("vectwin-3m");
  const TrainingConfig config = residual_config();
  const TrainingData data = prepare_training_data({test::simulated_recording(base->ship(), 1, 60, 0.01)}, config, base);
  const EnsembleHeader header = make_header(data, 1, {});
  const test::TemporaryFolder one, two, resumed;
  const auto train_all = [&](const test::TemporaryFolder& folder, std::vector<int> members, bool resume = false) {
    train_ensemble(data, header, {folder.path().string(), std::move(members), resume, 0.0, 2}, nn::kernels(),
                   {[](int, const MemberProgress&) {}, [](const std::string&) {}});
  };
  train_all(one, {0, 1});
  train_all(two, {1});
  TrainingState state = initial_training_state(data, 1, 1, nn::kernels());
  CHECK_FALSE(train(data, 1, nn::kernels(), state, [&](const TrainingState& now) { return now.epochs_done < 2; }));
  write_checkpoint(resumed.path().string(), state, header);
  train_all(resumed, {1}, true);
  const std::string expected = io::read_text(one / "member-01.json");
  CHECK(io::read_text(two / "member-01.json") == expected);
  CHECK(io::read_text(resumed / "member-01.json") == expected);

  const std::string folder = one.path().string();
  write_header(folder, header, io::Json::object(), base.get());
  const EnsembleHeader read = *read_header(folder);
  CHECK(read.base == header.base);
  CHECK(read.inputs.base_actuators == data.inputs.base_actuators);
  REQUIRE(read.inputs.domain.size() == data.inputs.inputs.size());
  CHECK(read.inputs.domain[3].name == "delta_p_rad");
  CHECK(read.inputs.domain[3].low == data.stretches.front().actuators.row(0).minCoeff());
  CHECK(read.inputs.domain[3].high == data.stretches.front().actuators.row(0).maxCoeff());
  const Ensemble ensemble(folder, 0, nn::kernels());
  CHECK(ensemble.base()->ship().name == base->ship().name);
  CHECK(io::read_text(one / "base-ship.json") == base->text());
  io::write_text(one / "base-ship.json", base->text() + " ");
  CHECK_THROWS_WITH(Ensemble(folder, 0, nn::kernels()), Contains("base-ship.json: is not the ship 'vectwin-3m'"));
  // Another base, or none, is another training; one without a base leaves no ship behind.
  const TrainingData other = prepare_training_data({test::simulated_recording(base->ship(), 1, 60, 0.01)}, config,
                                                   base_of(with_effects("vectwin-3m", {kMany[5]})));
  CHECK(make_header(other, 1, {}).training_id != header.training_id);
  const TrainingData none = prepare_training_data({test::simulated_recording(base->ship(), 1, 60, 0.01)}, config);
  write_header(folder, make_header(none, 1, {}), io::Json::object());
  CHECK_FALSE(std::filesystem::exists(one / "base-ship.json"));
}

TEST_CASE("base model: what a rollout cannot know is refused by the effect's name", "[ensemble][base]") {
  const Ship delayed = with_effects("vectwin-3m", {{"actuator-delay", {{"delay_s", 2.0}}, "", ""}});
  CHECK_THROWS_WITH(base_of(delayed),
                    Contains("actuator-delay: a base model cannot have an effect that depends on what"));
  Trajectory recording = test::simulated_recording(read_ship("vectwin-3m"), 1, 60);
  for (const Channel channel : {Channel::psi, Channel::x0, Channel::y0, Channel::wind_speed, Channel::wind_dir,
                                Channel::app_wind_speed, Channel::app_wind_dir})
    recording[channel].clear();
  const TrainingConfig config = residual_config();
  for (const std::size_t effect : {0, 1, 2, 3})
    CHECK_THROWS_WITH(
        prepare_training_data({recording}, config, base_of(with_effects("vectwin-3m", {kMany[effect]}))),
        Contains("simulated-1.csv:1: no column 'psi_deg', which the effect '" + kMany[effect].type + "' of the base"));
  const TrainingData data =
      prepare_training_data({recording}, config, base_of(with_effects("vectwin-3m", {kMany[4], kMany[5]})));
  CHECK_THAT(data.notices.back(), Contains("its base ship will be in calm air"));
  recording[Channel::n_p].clear();
  CHECK_THROWS_WITH(prepare_training_data({recording}, config, base_of(read_ship("vectwin-3m"))),
                    Contains("no column 'n_p_rps', which the base ship 'vectwin-3m' needs"));
}
