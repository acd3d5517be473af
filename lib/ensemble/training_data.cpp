#include "ensemble/training_data.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/errors.hpp"
#include "core/units.hpp"
#include "core/wind.hpp"

namespace leeway::ensemble {
namespace {

struct Moments {
  double n = 0.0, mean = 0.0, m2 = 0.0, low = 1e300, high = -1e300;
  void add(double x) {
    n += 1.0;
    const double d = x - mean;
    mean += d / n;
    m2 += d * (x - mean);
    low = std::min(low, x);
    high = std::max(high, x);
  }
  double sd() const { return n > 0 ? std::sqrt(m2 / n) : 0.0; }
  // Rounding of units makes a constant differ in its last bits.
  bool varies() const { return n > 0 && high - low > 1e-9 * std::max(std::abs(high), std::abs(low)); }
};

Moments of_channel(const std::vector<Trajectory>& recordings, Channel channel) {
  Moments moments;
  for (const Trajectory& recording : recordings)
    for (const double x : recording[channel])
      if (!std::isnan(x)) moments.add(x);
  return moments;
}

void find_actuators(const std::vector<Trajectory>& recordings, TrainingData& data) {
  for (const Channel channel : kActuatorChannels) {
    const bool anywhere =
        std::any_of(recordings.begin(), recordings.end(), [&](const auto& r) { return r.has(channel); });
    if (!anywhere) continue;
    if (channel == Channel::i_bt &&
        std::count(data.inputs.actuators.begin(), data.inputs.actuators.end(), Channel::n_bt)) {
      data.notices.push_back(
          fmt::format("column '{}' is left out: '{}' counts", column_name(Channel::i_bt), column_name(Channel::n_bt)));
      continue;
    }
    const Moments moments = of_channel(recordings, channel);
    if (moments.varies()) {
      data.inputs.actuators.push_back(channel);
    } else {
      const bool of_base = data.base && data.base->ship().find_actuator(channel) != nullptr;
      if (of_base) data.inputs.base_actuators.push_back(channel);
      data.inputs.constants.emplace_back(channel, moments.mean);
      data.notices.push_back(fmt::format("column '{}' never varies in the training data and is left out{}",
                                         column_name(channel), of_base ? " of the networks' inputs" : ""));
    }
  }
}

// Wind is an input where any recording has some; in calm air the apparent wind only repeats the velocity.
void find_wind(const std::vector<Trajectory>& recordings, TrainingData& data) {
  const bool anywhere = std::any_of(recordings.begin(), recordings.end(), [](const auto& r) { return r.has_wind(); });
  if (!anywhere) {
    data.notices.emplace_back("the training data have no wind columns: the model will not know the wind");
    if (data.base && data.base->ship().has_wind()) data.notices.back() += ", and its base ship will be in calm air";
    return;
  }
  bool calm = true;
  for (const Trajectory& recording : recordings) {
    if (!recording.has_wind()) continue;
    if (!recording.has(Channel::wind_speed)) calm = false;
    for (const double speed : recording[Channel::wind_speed])
      if (speed != 0.0 && !std::isnan(speed)) calm = false;
  }
  if (calm)
    data.notices.emplace_back("the wind speed is zero throughout the training data: the wind is left out");
  else
    data.inputs.wind = true;
}

// What the base model leaves over of the accelerations by forward differences. Its deviation is that of means over
// blocks of steps, in which the noise of the observations cancels but for that at the ends; and never less than what
// adds up to sigma over a window, since less is not seen.
void find_residuals(TrainingData& data) {
  constexpr Eigen::Index kBlock = 10;
  const std::vector<Channel> channels = data.inputs.sampled_actuators();
  std::vector<Moments> single(3), blocks(3);
  for (const Samples& s : data.stretches) {
    Vec3<double> sum = Vec3<double>::Zero();
    Eigen::Index count = 0;
    for (Eigen::Index k = 0; k + 1 < s.size(); ++k) {
      const ShipState<double> end =
          data.base->step({s.eta.col(k), s.nu.col(k)}, data.base->inputs(s, channels, k), s.dt_s);
      const Vec3<double> residual = (s.nu.col(k + 1) - end.nu) / s.dt_s;
      if (!residual.allFinite())
        throw NumericalError(fmt::format("{}: the base ship '{}' has no finite acceleration at t = {} s", s.file,
                                         data.base->ship().name, s.t_s(k)));
      for (int i = 0; i < 3; ++i) single[i].add(residual(i));
      sum += residual;
      if (++count < std::min(kBlock, s.size() - 1)) continue;
      for (int i = 0; i < 3; ++i) blocks[i].add(sum(i) / static_cast<double>(count));
      sum.setZero();
      count = 0;
    }
  }
  for (int i = 0; i < 3; ++i) {
    const double least = data.config.sigma(i) / (data.config.time_step_s * (data.config.steps - 1));
    Spread& spread = data.inputs.accelerations[static_cast<std::size_t>(i)];
    spread.mean = single[static_cast<std::size_t>(i)].mean;
    spread.sd = std::max(blocks[static_cast<std::size_t>(i)].sd(), least);
  }
}

// Puts the recordings on the time grid; a notice says what is left out.
void add_stretches(const std::vector<Trajectory>& recordings, const std::string& all_files, TrainingData& data) {
  const TrainingConfig& config = data.config;
  for (const Trajectory& recording : recordings) {
    std::vector<Samples> stretches = resample(recording, data.inputs.sampled_actuators(), data.inputs.wind,
                                              config.time_step_s, config.resampling, config.inputs);
    Eigen::Index points = 0;
    for (const Samples& s : stretches) points += s.size();
    const double seconds = static_cast<double>(points) * config.time_step_s;
    const double recorded = recording[Channel::t].back() - recording[Channel::t].front();
    if (seconds < recorded - config.time_step_s)
      data.notices.push_back(fmt::format("{}: {:.1f} of {:.1f} s have missing samples and are left out", recording.file,
                                         recorded - seconds, recorded));
    for (Samples& s : stretches) data.stretches.push_back(std::move(s));
  }
  if (data.stretches.empty())
    throw InputError(all_files,
                     fmt::format("too little data: no stretch of two points {} s apart without missing samples",
                                 config.time_step_s));
}

// Cuts windows of K points and appends, for each, what the initial-state network observes, or nothing. It may look
// beyond the end of a short window.
std::vector<Window> cut_windows(const TrainingData& data, int K, std::vector<std::vector<double>>& observations) {
  const int seen = data.config.initial_state_steps;
  std::vector<Window> windows;
  for (std::size_t i = 0; i < data.stretches.size(); ++i)
    for (const Range range : training_windows(data.stretches[i].size(), K)) {
      windows.push_back({i, range, {}});
      observations.emplace_back();
      const Eigen::Index in_sight = K < data.config.steps ? data.stretches[i].size() - range.begin : range.size;
      if (data.config.initial_state_net && in_sight >= seen)
        observations.back() =
            initial_state_observations(data.stretches[i], range, seen, data.inputs.pose_in_initial_state);
    }
  return windows;
}

void standardize(const std::vector<Spread>& spreads, const std::vector<std::vector<double>>& observations,
                 std::vector<Window>& windows) {
  for (std::size_t w = 0; w < observations.size(); ++w)
    for (std::size_t j = 0; j < observations[w].size(); ++j)
      windows[w].initial_state_inputs.push_back(
          static_cast<float>((observations[w][j] - spreads[j].mean) / spreads[j].sd));
}

// Standardization of the network's inputs and outputs. The apparent wind is that of the observed states.
void find_spreads(const std::string& all_files, TrainingData& data) {
  ModelInputs& inputs = data.inputs;
  const std::size_t n_inputs = 3 + inputs.actuators.size() + (inputs.wind ? 2 : 0);
  std::vector<Moments> input(n_inputs), acceleration(3);
  for (const Samples& s : data.stretches)
    for (Eigen::Index k = 0; k < s.size(); ++k) {
      for (int i = 0; i < 3; ++i) {
        input[i].add(s.nu(i, k));
        if (k + 1 < s.size()) acceleration[i].add((s.nu(i, k + 1) - s.nu(i, k)) / s.dt_s);
      }
      for (std::size_t a = 0; a < inputs.actuators.size(); ++a)
        input[3 + a].add(s.actuators(static_cast<Eigen::Index>(a), k));
      if (inputs.wind) {
        const Vec2<double> wind = apparent_wind<double>(s.true_wind.col(k), s.eta(2, k), s.nu(0, k), s.nu(1, k));
        input[n_inputs - 2].add(wind(0));
        input[n_inputs - 1].add(wind(1));
      }
    }
  std::vector<std::string> names{"u_mps", "vm_mps", "r_radps"};
  for (const Channel channel : inputs.actuators) names.push_back(si_name(channel));
  if (inputs.wind) names.insert(names.end(), {"app_wind_x_mps", "app_wind_y_mps"});
  for (std::size_t i = 0; i < n_inputs; ++i) {
    if (!input[i].varies())
      throw InputError(
          all_files, fmt::format("'{}' never varies in the training data: nothing can be learned about it", names[i]));
    inputs.inputs.push_back({names[i], input[i].mean, input[i].sd()});
    inputs.domain.push_back({names[i], input[i].low, input[i].high});
  }
  const char* acceleration_names[] = {"udot_mps2", "vmdot_mps2", "rdot_radps2"};
  for (int i = 0; i < 3; ++i) {
    if (!acceleration[i].varies())
      throw InputError(all_files,
                       fmt::format("the acceleration '{}' never varies in the training data", acceleration_names[i]));
    inputs.accelerations.push_back({acceleration_names[i], acceleration[i].mean, acceleration[i].sd()});
  }
  inputs.largest_speed_mps = std::max({input[0].high, -input[0].low, input[1].high, -input[1].low});
  inputs.largest_rate_radps = std::max(input[2].high, -input[2].low);
}

// The same for what the initial-state network observes of each window; a notice says how many windows it cannot see.
void find_initial_state_spreads(const std::vector<std::vector<double>>& observations, const std::string& all_files,
                                TrainingData& data) {
  const TrainingConfig& config = data.config;
  ModelInputs& inputs = data.inputs;
  const std::size_t per_point = inputs.pose_in_initial_state ? 6 : 3;
  const std::size_t n = per_point * static_cast<std::size_t>(config.initial_state_steps);
  std::vector<Moments> moments(n);
  std::size_t usable = 0;
  for (const auto& o : observations) {
    for (std::size_t j = 0; j < o.size(); ++j) moments[j].add(o[j]);
    if (!o.empty()) ++usable;
  }
  if (usable == 0)
    throw InputError(all_files,
                     fmt::format("too little data: no stretch has the {} points of {} s that the initial-state "
                                 "network sees (initial_state_steps)",
                                 config.initial_state_steps, config.time_step_s));
  if (usable < observations.size())
    data.notices.push_back(fmt::format("{} of {} windows have fewer than {} points; they start from the observed state",
                                       observations.size() - usable, observations.size(), config.initial_state_steps));
  static constexpr const char* kNames[] = {"x_m", "y_m", "psi_rad", "u_mps", "vm_mps", "r_radps"};
  for (std::size_t j = 0; j < n; ++j)
    inputs.initial_state.push_back({fmt::format("{}[{}]", kNames[j % per_point + 6 - per_point], j / per_point),
                                    moments[j].mean,
                                    moments[j].varies() && moments[j].sd() > 0.0 ? moments[j].sd() : 1.0});
}

// All windows of whole training and of the curriculum, with what the initial-state network sees of them.
void cut_all_windows(TrainingData& data, const std::string& all_files) {
  const TrainingConfig& config = data.config;
  std::vector<std::vector<double>> observations;
  data.windows = cut_windows(data, config.steps, observations);
  if (config.initial_state_net) {
    if (data.inputs.initial_state.empty()) find_initial_state_spreads(observations, all_files, data);
    standardize(data.inputs.initial_state, observations, data.windows);
  }
  data.curriculum.clear();
  for (const CurriculumStage& stage : config.curriculum) {
    observations.clear();
    data.curriculum.push_back(cut_windows(data, stage.steps, observations));
    standardize(data.inputs.initial_state, observations, data.curriculum.back());
  }
}

// As many recordings as there are, drawn with replacement.
void draw_recordings(RandomStream random, TrainingData& data) {
  std::vector<std::string> names;
  for (const Samples& samples : data.stretches)
    if (std::ranges::find(names, samples.file) == names.end()) names.push_back(samples.file);
  std::map<std::string, int> times;
  for (std::size_t i = 0; i < names.size(); ++i) ++times[names[random.below(names.size())]];
  const auto drawn = [&](const std::vector<Window>& windows) {
    std::vector<Window> result;
    for (const Window& window : windows)
      result.insert(result.end(), static_cast<std::size_t>(times[data.stretches[window.stretch].file]), window);
    return result;
  };
  data.windows = drawn(data.windows);
  for (std::vector<Window>& windows : data.curriculum) windows = drawn(windows);
}

std::string name_of_all(const std::vector<Trajectory>& recordings) {
  if (recordings.empty()) return "";
  if (recordings.size() == 1) return recordings.front().file;
  return fmt::format("{} and {} more", recordings.front().file, recordings.size() - 1);
}

}  // namespace

std::vector<Channel> ModelInputs::sampled_actuators() const {
  std::vector<Channel> channels = actuators;
  channels.insert(channels.end(), base_actuators.begin(), base_actuators.end());
  return channels;
}

const std::vector<Window>& TrainingData::windows_of_epoch(int epoch) const {
  const std::size_t stage = curriculum_stage(config, epoch);
  return stage < curriculum.size() ? curriculum[stage] : windows;
}

std::vector<double> initial_state_observations(const Samples& samples, Range range, int steps, bool with_pose) {
  std::vector<double> values;
  const double psi0 = samples.eta(2, range.begin);
  const double c = std::cos(psi0), s = std::sin(psi0);
  for (Eigen::Index k = range.begin; k < range.begin + steps; ++k) {
    if (with_pose) {
      const double x = samples.eta(0, k) - samples.eta(0, range.begin),
                   y = samples.eta(1, k) - samples.eta(1, range.begin);
      values.insert(values.end(), {c * x + s * y, -s * x + c * y, samples.eta(2, k) - psi0});
    }
    values.insert(values.end(), {samples.nu(0, k), samples.nu(1, k), samples.nu(2, k)});
  }
  return values;
}

TrainingData prepare_training_data(std::vector<Trajectory> recordings, const TrainingConfig& config,
                                   std::shared_ptr<const BaseModel> base) {
  TrainingData data;
  data.config = config;
  data.base = std::move(base);
  ModelInputs& inputs = data.inputs;
  const std::string all_files = name_of_all(recordings);
  if (data.base) data.base->prepare(recordings);
  find_actuators(recordings, data);
  find_wind(recordings, data);
  if (inputs.actuators.empty() && !inputs.wind)
    throw InputError(all_files, "no actuator column varies and there is no wind: nothing moves this ship");

  add_stretches(recordings, all_files, data);

  find_spreads(all_files, data);
  if (data.base) find_residuals(data);

  // Windows, and what the initial-state network sees of them.
  inputs.pose_in_initial_state =
      std::all_of(data.stretches.begin(), data.stretches.end(), [](const Samples& s) { return s.has_position; });
  cut_all_windows(data, all_files);
  return data;
}

ShipDraws draws_of_members(const TrainingData& data, std::uint64_t seed) {
  double fastest = 0.0;
  for (const Samples& s : data.stretches) fastest = std::max(fastest, s.nu.row(0).maxCoeff());
  return {data.base->ship(), data.base_spread, seed, fastest};
}

TrainingData data_of_member(const TrainingData& data, std::uint64_t seed, int number) {
  TrainingData own = data;
  const auto index = static_cast<std::uint64_t>(number);
  if (data.config.bootstrap) draw_recordings({seed, "recordings of a member", index}, own);
  if (data.base == nullptr || data.base_spread == 0.0) return own;
  int refused = 0;
  own.base = data.base->drawn(draws_of_members(data, seed), number, refused);
  own.has_drawn_base = true;
  if (!own.stated) find_residuals(own);  // draws of a fitted ship leave over what it does
  return own;
}

TrainingData prepare_held_out_data(std::vector<Trajectory> recordings, const TrainingData& training) {
  TrainingData data;
  data.config = training.config;
  data.inputs = training.inputs;
  data.base = training.base;
  if (data.base) data.base->prepare(recordings);
  add_stretches(recordings, name_of_all(recordings), data);
  std::vector<std::vector<double>> observations;
  data.windows = cut_windows(data, data.config.steps, observations);
  // Where the networks know the pose, a recording without it starts from the observed state.
  for (std::size_t w = 0; w < observations.size(); ++w)
    if (data.inputs.pose_in_initial_state && !data.stretches[data.windows[w].stretch].has_position)
      observations[w].clear();
  standardize(data.inputs.initial_state, observations, data.windows);
  return data;
}

}  // namespace leeway::ensemble
