#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <tuple>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "core/errors.hpp"
#include "ensemble/model_files.hpp"
#include "ensemble/model_json.hpp"
#include "ensemble/muon.hpp"
#include "io/csv.hpp"
#include "io/files.hpp"
#include "io/json_check.hpp"

namespace leeway::ensemble {
namespace fs = std::filesystem;
namespace {

constexpr const char* kMemberFormat = "leeway member 1";
constexpr std::string_view kCheckpointFormat = "leeway checkpoint 2 ";  // then the hash of all that follows the line

// All that a prediction takes from a member's file.
FloatJson deciding_part(const FloatJson& member) {
  FloatJson part;
  for (const char* key : {"training_id", "output_mean", "output_sd", "dynamics", "initial_state"})
    part[key] = member.at(key);
  if (member.contains("base")) part["base"] = member.at("base");
  return part;
}

void require_finite(const Member& member, const std::string& path) {
  const auto finite = [](double x) { return std::isfinite(x); };
  const auto& [mean, sd, curve] = std::tie(member.output_mean, member.output_sd, member.training_curve);
  if (!std::all_of(member.parameters.begin(), member.parameters.end(), finite) ||
      !std::all_of(mean.begin(), mean.end(), finite) || !std::all_of(curve.begin(), curve.end(), finite) ||
      !std::all_of(sd.begin(), sd.end(), [](double x) { return std::isfinite(x) && x > 0.0; }))
    throw NumericalError(
        fmt::format("{}: a weight, a loss or the standardization would be no finite number; nothing is "
                    "written",
                    path));
}

FloatJson network_to_json(const nn::NetworkShape& shape, const float* parameters) {
  FloatJson layers = FloatJson::array();
  for (int l = 0; shape.outputs > 0 && l < nn::layer_count(shape); ++l) {
    const int rows = nn::layer_outputs(shape, l), cols = nn::layer_inputs(shape, l);
    FloatJson weights = FloatJson::array();
    for (int i = 0; i < rows; ++i) {
      FloatJson row = FloatJson::array();
      for (int j = 0; j < cols; ++j) row.push_back(parameters[j * rows + i]);
      weights.push_back(std::move(row));
    }
    parameters += static_cast<std::ptrdiff_t>(rows) * cols;
    layers.push_back({{"weights", std::move(weights)}, {"bias", std::vector<float>(parameters, parameters + rows)}});
    parameters += rows;
  }
  return layers;
}

// Where in a file the reading is, for messages.
struct Place {
  std::string pointer;
  // A value that the file must have.
  const FloatJson& at(const FloatJson& object, const std::string& key) {
    pointer += "/" + key;
    if (!object.is_object() || !object.contains(key)) throw std::out_of_range("is missing");
    return object.at(key);
  }
};

// Reads a file of ours: any mismatch is one InputError with its place.
//   read  takes a Place that it keeps
template <typename Read>
auto checked(const std::string& path, const Read& read) {
  Place place;
  try {
    return read(place);
  } catch (const nlohmann::json::exception& error) {
    const std::string what = error.what();  // "[json.exception.type_error.302] type must be string, but is null"
    throw InputError(path, 0, place.pointer, what.substr(std::min(what.size(), what.find("] ") + 2)));
  } catch (const std::out_of_range& error) {
    throw InputError(path, 0, place.pointer, error.what());
  }
}

// Reads one value: its place is that of the message if it is wrong.
template <typename Read>
auto value_of(Place& place, const FloatJson& object, const std::string& key, const Read& read) {
  const std::string before = place.pointer;
  auto value = read(place.at(object, key));
  place.pointer = before;
  return value;
}

std::string text_from(const FloatJson& json) { return json.get<std::string>(); }

float finite_from(const FloatJson& json) {
  const auto value = json.get<float>();
  if (!std::isfinite(value)) throw std::out_of_range("a number is not finite");
  return value;
}

void network_from_json(const FloatJson& layers, const nn::NetworkShape& shape, Place& place,
                       nn::AlignedVector<float>& parameters) {
  if (shape.outputs == 0) return;
  const auto require_count = [](const FloatJson& json, int count) {
    if (!json.is_array() || static_cast<int>(json.size()) != count)
      throw std::out_of_range(fmt::format("expected an array of {}, as the ensemble's config has it", count));
  };
  require_count(layers, nn::layer_count(shape));
  const std::string network = place.pointer;
  for (int l = 0; l < nn::layer_count(shape); ++l) {
    const int rows = nn::layer_outputs(shape, l), cols = nn::layer_inputs(shape, l);
    const std::string layer = place.pointer = fmt::format("{}/{}", network, l);
    const FloatJson& weights = place.at(layers.at(l), "weights");
    require_count(weights, rows);
    const std::size_t begin = parameters.size();
    parameters.resize(begin + static_cast<std::size_t>(rows) * cols);
    for (int i = 0; i < rows; ++i) {
      place.pointer = fmt::format("{}/weights/{}", layer, i);
      require_count(weights.at(i), cols);
      for (int j = 0; j < cols; ++j)
        parameters[begin + static_cast<std::size_t>(j) * rows + i] = finite_from(weights.at(i).at(j));
    }
    place.pointer = layer;
    const FloatJson& bias = place.at(layers.at(l), "bias");
    require_count(bias, rows);
    for (int i = 0; i < rows; ++i) parameters.push_back(finite_from(bias.at(i)));
  }
  place.pointer = network;
}

// Double-precision numbers as text within a single-precision file, so that their bits stay as well.
template <std::size_t n>
std::vector<std::string> exact(const std::array<double, n>& values) {
  std::vector<std::string> texts;
  texts.reserve(n);
  for (const double value : values) texts.push_back(fmt::format("{}", value));
  return texts;
}

template <std::size_t n>
std::array<double, n> exact_from(const FloatJson& json) {
  std::array<double, n> values{};
  if (!json.is_array() || json.size() != n) throw std::out_of_range(fmt::format("expected {} numbers as texts", n));
  for (std::size_t i = 0; i < n; ++i)
    if (!io::parse_number(json.at(i).get<std::string>(), values[i])) throw std::out_of_range("a number is not finite");
  return values;
}

long whole_from(const FloatJson& json) {
  const bool is_whole = json.is_number_unsigned() && json.get<std::uint64_t>() <= std::numeric_limits<int>::max();
  if (!is_whole) throw std::out_of_range(fmt::format("'{}' is no whole number >= 0", json.dump().substr(0, 40)));
  return json.get<long>();
}

nn::AlignedVector<float> floats_from(const FloatJson& json) {
  const auto values = json.get<std::vector<float>>();
  return {values.begin(), values.end()};
}

std::array<double, 3> positive_from(const FloatJson& json) {
  const std::array<double, 3> values = exact_from<3>(json);
  for (const double value : values)
    if (!(value > 0.0)) throw std::out_of_range("expected numbers > 0");
  return values;
}

OwnBase own_base_from(const FloatJson& json, Place& place) {
  return {value_of(place, json, "sha256", text_from), value_of(place, json, "acceleration_mean", exact_from<3>),
          value_of(place, json, "acceleration_sd", positive_from)};
}

void check_member_keys(const FloatJson& json, bool has_own_base, const std::string& path) {
  std::vector<std::string_view> keys{"format",    "training_id", "member",        "kernel",         "output_mean",
                                     "output_sd", "dynamics",    "initial_state", "training_curve", "sha256"};
  if (has_own_base) keys.push_back("base");
  const auto check = [&](const FloatJson& object, const std::string& pointer, auto begin, auto end) {
    for (const auto& item : object.items())
      if (std::find(begin, end, item.key()) == end)
        throw InputError(path, 0, pointer + item.key(),
                         fmt::format("unknown key; known here: {}", fmt::join(begin, end, ", ")));
  };
  check(json, "/", keys.begin(), keys.end());
  constexpr std::array kBaseKeys{"ship", "sha256", "acceleration_mean", "acceleration_sd"};
  if (has_own_base) check(json.at("base"), "/base/", kBaseKeys.begin(), kBaseKeys.end());
  constexpr std::array kLayerKeys{"weights", "bias"};
  for (const char* network : {"dynamics", "initial_state"})
    for (std::size_t l = 0; l < json.at(network).size(); ++l)
      check(json.at(network).at(l), fmt::format("/{}/{}/", network, l), kLayerKeys.begin(), kLayerKeys.end());
}

void check_training_id(const std::string& path, const std::string& found, const EnsembleHeader& header) {
  if (found != header.training_id)
    throw InputError(path, "belongs to another training (data, settings, base or seed differ from ensemble.json)");
}

}  // namespace

bool member_exists(const std::string& folder, int number) {
  std::error_code error;
  return fs::exists(member_path(folder, number), error);
}

void write_member(const std::string& folder, const Member& member, const EnsembleHeader& header,
                  const std::function<void()>& before_rename) {
  const std::size_t split = nn::parameter_count(member.dynamics);
  const std::string path = member_path(folder, member.number);
  require_finite(member, path);
  FloatJson json{{"format", kMemberFormat},
                 {"training_id", header.training_id},
                 {"member", member.number},
                 {"kernel", member.kernel},
                 {"output_mean", exact(member.output_mean)},
                 {"output_sd", exact(member.output_sd)},
                 {"dynamics", network_to_json(member.dynamics, member.parameters.data())},
                 {"initial_state", network_to_json(member.initial_state, member.parameters.data() + split)},
                 {"training_curve", member.training_curve}};
  if (member.own_base)
    json["base"] = {{"ship", fs::path(member_ship_path(folder, member.number)).filename().string()},
                    {"sha256", member.own_base->sha256},
                    {"acceleration_mean", exact(member.own_base->acceleration_mean)},
                    {"acceleration_sd", exact(member.own_base->acceleration_sd)}};
  json["sha256"] = hash_of(deciding_part(json));
  io::OutputFile file(path);
  file.write(json.dump() + "\n");
  file.commit(before_rename);
}

Member read_member(const std::string& folder, int number, const EnsembleHeader& header) {
  const std::string path = member_path(folder, number);
  const std::string text = io::read_text(path);
  return checked(path, [&](Place& place) {
    io::check_json<FloatJson>(text, path, io::JsonTop::object);
    const FloatJson json = FloatJson::parse(text);
    const auto of = [&](const char* key, const auto& read) { return value_of(place, json, key, read); };
    if (of("format", text_from) != kMemberFormat)
      throw InputError(path, 0, "/format", fmt::format("expected \"{}\"", kMemberFormat));
    check_training_id(path, of("training_id", text_from), header);
    Member member;
    member.number = static_cast<int>(of("member", whole_from));
    if (member.number != number)
      throw InputError(path, 0, "/member", fmt::format("expected {}, got {}", number, member.number));
    member.kernel = of("kernel", text_from);
    member.output_mean = of("output_mean", exact_from<3>);
    member.output_sd = of("output_sd", positive_from);
    member.dynamics = dynamics_shape(header.inputs, header.config);
    member.initial_state = initial_state_shape(header.inputs, header.config);
    const auto take_network = [&](const char* key, const nn::NetworkShape& shape) {
      of(key, [&](const FloatJson& layers) {
        network_from_json(layers, shape, place, member.parameters);
        return true;
      });
    };
    take_network("dynamics", member.dynamics);
    take_network("initial_state", member.initial_state);
    member.training_curve = of("training_curve", [](const FloatJson& c) { return c.get<std::vector<float>>(); });
    const bool has_own_base = header.base && header.base->spread > 0.0;
    if (has_own_base) member.own_base = of("base", [&](const FloatJson& base) { return own_base_from(base, place); });
    const bool is_hashed = header.is_hashed || has_own_base || json.contains("sha256");
    const std::string hash = is_hashed ? of("sha256", text_from) : "";
    check_member_keys(json, has_own_base, path);
    if (is_hashed && hash != hash_of(deciding_part(json)))
      throw InputError(path, 0, "/sha256",
                       "is not that of weights and standardization: the file was changed or damaged");
    return member;
  });
}

void write_checkpoint(const std::string& folder, const TrainingState& state, const EnsembleHeader& header,
                      const std::function<void()>& before_rename) {
  const Member& member = state.member;
  const FloatJson json{{"training_id", header.training_id},
                       {"kernel", member.kernel},
                       {"output_mean", exact(member.output_mean)},
                       {"output_sd", exact(member.output_sd)},
                       {"epochs_done", state.epochs_done},
                       {"windows_done", state.windows_done},
                       {"loss_sum_and_points", exact(std::array{state.loss_sum, state.points})},
                       {"adam_steps", state.adam_steps},
                       {"parameters", member.parameters},
                       {"adam_m", state.adam_m},
                       {"adam_v", state.adam_v},
                       {"muon_momentum", state.muon_momentum},
                       {"training_curve", member.training_curve}};
  const std::vector<std::uint8_t> bytes = FloatJson::to_cbor(json);
  const std::string_view body(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  io::OutputFile file(checkpoint_path(folder, member.number));
  file.write(fmt::format("{}{}\n", kCheckpointFormat, io::sha256(body)));
  file.write(body);
  file.commit(before_rename);
}

std::optional<TrainingState> read_checkpoint(const std::string& folder, int number, const EnsembleHeader& header) {
  const std::string path = checkpoint_path(folder, number);
  std::error_code error;
  if (!fs::exists(path, error)) return std::nullopt;
  const std::string text = io::read_text(path);
  if (!text.starts_with(kCheckpointFormat))
    throw InputError(path, "not a checkpoint of this version; without --resume the member begins anew");
  const std::size_t hash = kCheckpointFormat.size(), line_end = std::min(text.size(), text.find('\n'));
  const std::string_view body = std::string_view(text).substr(std::min(text.size(), line_end + 1));
  if (text.substr(hash, line_end - hash) != io::sha256(body))
    throw InputError(path, "is damaged: its hash is not that of its contents; without --resume the member begins anew");
  return checked(path, [&](Place& place) {
    io::check_cbor<FloatJson>(body, path);
    const FloatJson json = FloatJson::from_cbor(body);
    const auto of = [&](const char* key, const auto& read) { return value_of(place, json, key, read); };
    check_training_id(path, of("training_id", text_from), header);
    TrainingState state;
    state.member.number = number;
    state.member.kernel = of("kernel", text_from);
    state.member.output_mean = of("output_mean", exact_from<3>);
    state.member.output_sd = of("output_sd", exact_from<3>);
    state.member.dynamics = dynamics_shape(header.inputs, header.config);
    state.member.initial_state = initial_state_shape(header.inputs, header.config);
    state.epochs_done = static_cast<int>(of("epochs_done", whole_from));
    state.windows_done = static_cast<std::size_t>(of("windows_done", whole_from));
    const std::array<double, 2> sums = of("loss_sum_and_points", exact_from<2>);
    state.loss_sum = sums[0];
    state.points = sums[1];
    state.adam_steps = of("adam_steps", whole_from);
    state.member.parameters = of("parameters", floats_from);
    state.adam_m = of("adam_m", floats_from);
    state.adam_v = of("adam_v", floats_from);
    state.muon_momentum = of("muon_momentum", floats_from);
    state.member.training_curve = of("training_curve", [](const FloatJson& c) { return c.get<std::vector<float>>(); });
    const std::size_t n = nn::parameter_count(state.member.dynamics) + nn::parameter_count(state.member.initial_state);
    const std::size_t muon = header.config.optimizer == Optimizer::muon
                                 ? Muon({state.member.dynamics, state.member.initial_state}).size()
                                 : 0;
    if (state.member.parameters.size() != n || state.adam_m.size() != n || state.adam_v.size() != n ||
        state.muon_momentum.size() != muon)
      throw std::out_of_range("has not as many parameters as the ensemble's config says");
    return std::optional<TrainingState>(std::move(state));
  });
}

void remove_checkpoint(const std::string& folder, int number) {
  std::error_code error;
  fs::remove(checkpoint_path(folder, number), error);
}

}  // namespace leeway::ensemble
