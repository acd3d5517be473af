#include "ensemble/config.hpp"

#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/units.hpp"
#include "io/files.hpp"

namespace leeway::ensemble {
namespace {

constexpr double kMany = 1e9;

int whole(const io::JsonObject& object, const std::string& key, int otherwise, double low) {
  return static_cast<int>(object.integer_or(key, otherwise, {low, kMany}));
}

std::vector<CurriculumStage> curriculum_from(const io::JsonObject& object, int steps) {
  std::vector<CurriculumStage> stages;
  double total = 0.0;
  for (const io::JsonObject& item : object.objects("curriculum")) {
    const CurriculumStage stage{static_cast<int>(item.integer("steps", {2, static_cast<double>(steps)})),
                                item.number("share", io::kPositive)};
    item.check_all_known();
    total += stage.share;
    stages.push_back(stage);
  }
  if (!(total < 1.0))
    object.fail("curriculum",
                fmt::format("expected shares that leave some to the whole windows, got a sum of {}", total));
  return stages;
}

bool is_near(double x, double y) { return std::abs(x - y) <= 1e-9 * std::abs(y); }

// Throws unless all that the paper's text and table fix is as there; the number of members is free.
void check_follows_paper(const io::JsonObject& object, const TrainingConfig& c) {
  const TrainingConfig paper;
  const auto is_scale = [&](double time_step_s, double sigma_r_degps, int epochs) {
    return is_near(c.time_step_s, time_step_s) && is_near(c.sigma(2), deg_to_rad(sigma_r_degps)) && c.epochs == epochs;
  };
  const std::pair<const char*, bool> held[] = {
      {"steps", c.steps == paper.steps},
      {"curriculum", c.curriculum.empty()},
      {"initial_state_steps", c.initial_state_steps == paper.initial_state_steps},
      {"initial_state_net", c.initial_state_net},
      {"hidden_layers", c.hidden_layers == paper.hidden_layers},
      {"hidden_units", c.hidden_units == paper.hidden_units},
      {"sigma", is_near(c.sigma(0), paper.sigma(0)) && is_near(c.sigma(1), paper.sigma(1))},
      {"learning_rate", c.learning_rate == paper.learning_rate},
      {"learning_rate_schedule", c.schedule == RateSchedule::constant},
      {"gradient_clip_norm", c.gradient_clip_norm == 0.0},
      {"optimizer", c.optimizer == Optimizer::adam},
      {"batch_size", c.batch_size == paper.batch_size},
      {"base_spread", c.base_spread == paper.base_spread},
      {"fit_base", c.fit_base == paper.fit_base},
      {"inputs_between_samples", c.inputs == paper.inputs},
      {"bootstrap", !c.bootstrap},
      {"calibration", !c.calibration},
      {"integrator_predict", c.integrator_predict == paper.integrator_predict},
      {"state_resampling", c.resampling == paper.resampling},
      {"time_step_s, sigma or epochs", is_scale(1.0, 0.1, 20000) || is_scale(7.0, 0.01, 100000)}};
  for (const auto& [key, is_held] : held)
    if (!is_held) object.fail("follows", fmt::format("'paper', but {} differs from the paper's; leave one out", key));
}

}  // namespace

TrainingConfig training_config_from(const io::JsonObject& object) {
  TrainingConfig c;
  for (const char* note : {"description", "source"}) object.text_or(note, "");
  c.time_step_s = object.number_or("time_step_s", c.time_step_s, io::kPositive);
  c.steps = whole(object, "steps", c.steps, 2);
  if (object.has("curriculum")) c.curriculum = curriculum_from(object, c.steps);
  c.initial_state_steps = whole(object, "initial_state_steps", c.initial_state_steps, 1);
  c.hidden_layers = whole(object, "hidden_layers", c.hidden_layers, 1);
  if (c.hidden_layers > 16) object.fail("hidden_layers", "expected a whole number from 1 to 16");
  c.hidden_units = whole(object, "hidden_units", c.hidden_units, 1);
  if (object.has("activation")) object.word("activation", {"tanh"});
  if (const auto sigma = object.object_if("sigma")) {
    c.sigma(0) = sigma->number_or("u_mps", c.sigma(0), io::kPositive);
    c.sigma(1) = sigma->number_or("vm_mps", c.sigma(1), io::kPositive);
    c.sigma(2) = deg_to_rad(sigma->number_or("r_degps", rad_to_deg(c.sigma(2)), io::kPositive));
    sigma->check_all_known();
  }
  c.learning_rate = object.number_or("learning_rate", c.learning_rate, io::kPositive);
  if (object.has("learning_rate_schedule"))
    c.schedule = object.word("learning_rate_schedule", {"constant", "cosine"}) == "cosine" ? RateSchedule::cosine
                                                                                           : RateSchedule::constant;
  c.gradient_clip_norm = object.number_or("gradient_clip_norm", c.gradient_clip_norm, io::kNotNegative);
  if (object.has("optimizer"))
    c.optimizer = object.word("optimizer", {"adam", "muon"}) == "muon" ? Optimizer::muon : Optimizer::adam;
  c.muon_rate_factor = object.number_or("muon_rate_factor", c.muon_rate_factor, io::kPositive);
  c.batch_size = whole(object, "batch_size", c.batch_size, 1);
  c.epochs = whole(object, "epochs", c.epochs, 1);
  c.members = whole(object, "members", c.members, 1);
  if (object.has("base_spread")) {
    const io::Json& spread = object.value("base_spread");
    c.base_spread = spread.is_string() && object.word("base_spread", {"auto"}) == "auto"
                        ? std::nullopt
                        : std::optional(object.number("base_spread", io::kNotNegative));
  }
  c.initial_state_net = object.flag_or("initial_state_net", c.initial_state_net);
  if (const auto scale = object.object_if("pose_scale")) {
    c.pose_scale(0) = scale->number_or("x0_m", c.pose_scale(0), io::kPositive);
    c.pose_scale(1) = scale->number_or("y0_m", c.pose_scale(1), io::kPositive);
    c.pose_scale(2) = deg_to_rad(scale->number_or("psi_deg", rad_to_deg(c.pose_scale(2)), io::kPositive));
    scale->check_all_known();
  }
  if (object.has("integrator_train")) object.word("integrator_train", {"euler"});
  if (object.has("integrator_predict"))
    c.integrator_predict =
        object.word("integrator_predict", {"rk4", "euler"}) == "rk4" ? Integrator::rk4 : Integrator::euler;
  if (object.has("state_resampling"))
    c.resampling = object.word("state_resampling", {"decimate", "average"}) == "average" ? StateResampling::average
                                                                                         : StateResampling::decimate;
  if (object.has("inputs_between_samples"))
    c.inputs =
        object.word("inputs_between_samples", {"held", "linear"}) == "linear" ? InputPath::linear : InputPath::held;
  c.fit_base = object.flag_or("fit_base", c.fit_base);
  c.bootstrap = object.flag_or("bootstrap", c.bootstrap);
  if (const auto calibration = object.object_if("calibration")) {
    c.calibration.emplace();
    c.calibration->folds = whole(*calibration, "folds", c.calibration->folds, 2);
    c.calibration->members = whole(*calibration, "members", c.calibration->members, 2);
    calibration->check_all_known();
  }
  if (object.has("follows")) {
    c.follows = object.word("follows", {"paper"});
    check_follows_paper(object, c);
  }
  object.check_all_known();
  return c;
}

TrainingConfig read_training_config(const std::string& name_or_path) {
  const std::string path = io::find_config("train", name_or_path);
  const io::Json json = io::read_json(path);
  return training_config_from(io::JsonObject(json, path));
}

std::size_t curriculum_stage(const TrainingConfig& config, int epoch) {
  double end = 0.0;
  for (std::size_t i = 0; i < config.curriculum.size(); ++i) {
    end += config.curriculum[i].share;
    if (epoch < std::lround(end * config.epochs)) return i;
  }
  return config.curriculum.size();
}

double learning_rate(const TrainingConfig& config, double progress) {
  if (config.schedule == RateSchedule::constant) return config.learning_rate;
  return config.learning_rate * 0.5 * (1.0 + std::cos(kPi * progress));
}

io::Json to_json(const TrainingConfig& c) {
  io::Json json{
      {"time_step_s", c.time_step_s},
      {"steps", c.steps},
      {"initial_state_steps", c.initial_state_steps},
      {"hidden_layers", c.hidden_layers},
      {"hidden_units", c.hidden_units},
      {"activation", "tanh"},
      {"sigma", {{"u_mps", c.sigma(0)}, {"vm_mps", c.sigma(1)}, {"r_degps", rad_to_deg(c.sigma(2))}}},
      {"learning_rate", c.learning_rate},
      {"learning_rate_schedule", c.schedule == RateSchedule::cosine ? "cosine" : "constant"},
      {"gradient_clip_norm", c.gradient_clip_norm},
      {"batch_size", c.batch_size},
      {"epochs", c.epochs},
      {"members", c.members},
      {"initial_state_net", c.initial_state_net},
      {"pose_scale", {{"x0_m", c.pose_scale(0)}, {"y0_m", c.pose_scale(1)}, {"psi_deg", rad_to_deg(c.pose_scale(2))}}},
      {"integrator_train", "euler"},
      {"integrator_predict", c.integrator_predict == Integrator::rk4 ? "rk4" : "euler"},
      {"state_resampling", c.resampling == StateResampling::average ? "average" : "decimate"}};
  if (!c.follows.empty()) json["follows"] = c.follows;
  if (c.base_spread != 0.0) json["base_spread"] = c.base_spread ? io::Json(*c.base_spread) : io::Json("auto");
  if (c.fit_base) json["fit_base"] = true;
  if (c.inputs != InputPath::held) json["inputs_between_samples"] = c.inputs == InputPath::linear ? "linear" : "fitted";
  if (c.bootstrap) json["bootstrap"] = true;
  if (c.calibration) json["calibration"] = {{"folds", c.calibration->folds}, {"members", c.calibration->members}};
  if (!c.curriculum.empty()) {
    io::Json stages = io::Json::array();
    for (const CurriculumStage& stage : c.curriculum)
      stages.push_back({{"steps", stage.steps}, {"share", stage.share}});
    json["curriculum"] = stages;
  }
  if (c.optimizer == Optimizer::muon) {
    json["optimizer"] = "muon";
    json["muon_rate_factor"] = c.muon_rate_factor;
  }
  return json;
}

}  // namespace leeway::ensemble
