#include "ensemble/model_files.hpp"

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
#include "ensemble/muon.hpp"
#include "io/csv.hpp"
#include "io/files.hpp"
#include "io/json_check.hpp"

namespace leeway::ensemble {
namespace fs = std::filesystem;
namespace {

// Weights are single precision: this JSON prints and reads them as such, with the fewest digits that keep the bits.
using FloatJson =
    nlohmann::basic_json<nlohmann::ordered_map, std::vector, std::string, bool, std::int64_t, std::uint64_t, float>;

constexpr const char* kIndexFile = "ensemble.json";
constexpr const char* kMemberPrefix = "member-";
constexpr const char* kBaseFile = "base-ship.json";
constexpr std::string_view kCheckpointFormat = "leeway checkpoint 2 ";  // then the hash of all that follows the line

io::Json spreads_to_json(const std::vector<Spread>& spreads) {
  io::Json result = io::Json::array();
  for (const Spread& s : spreads) result.push_back({{"name", s.name}, {"mean", s.mean}, {"sd", s.sd}});
  return result;
}

io::Json domain_to_json(const std::vector<InputRange>& domain) {
  io::Json result = io::Json::array();
  for (const InputRange& r : domain) result.push_back({{"name", r.name}, {"low", r.low}, {"high", r.high}});
  return result;
}

std::vector<Spread> spreads_from(const io::JsonObject& object, const std::string& key) {
  std::vector<Spread> result;
  for (const io::JsonObject& item : object.objects(key)) {
    result.push_back({item.text("name"), item.number("mean"), item.number("sd", io::kPositive)});
    item.check_all_known();
  }
  return result;
}

Channel channel_from(const io::JsonObject& object, const std::string& key, const std::string& name) {
  for (const Channel channel : kActuatorChannels)
    if (column_name(channel) == name) return channel;
  object.fail(key, fmt::format("unknown actuator column '{}'", name));
}

// The part that decides the members; its hash is their training_id.
io::Json training_to_json(const EnsembleHeader& h) {
  io::Json config = to_json(h.config);
  config.erase("members");
  io::Json actuators = io::Json::array(), constants = io::Json::array(), files = io::Json::array();
  for (const Channel channel : h.inputs.actuators) actuators.push_back(column_name(channel));
  for (const auto& [channel, value] : h.inputs.constants)
    constants.push_back({{"column", column_name(channel)}, {"value_si", value}});
  for (const TrainingFile& f : h.files)
    files.push_back({{"recording", io::stem(f.file)}, {"sha256", f.sha256}, {"rows", f.rows}});
  io::Json json{{"seed", h.seed},
                {"config", config},
                {"actuators", actuators},
                {"wind", h.inputs.wind},
                {"constant_columns", constants},
                {"inputs", spreads_to_json(h.inputs.inputs)},
                {"accelerations", spreads_to_json(h.inputs.accelerations)},
                {"pose_in_initial_state", h.inputs.pose_in_initial_state},
                {"initial_state_inputs", spreads_to_json(h.inputs.initial_state)},
                {"largest_speed_mps", h.inputs.largest_speed_mps},
                {"largest_rate_radps", h.inputs.largest_rate_radps},
                {"files", files}};
  if (h.base) {
    io::Json of_base = io::Json::array();
    for (const Channel channel : h.inputs.base_actuators) of_base.push_back(column_name(channel));
    json["base"] = {{"ship", kBaseFile}, {"name", h.base->name}, {"sha256", h.base->sha256}, {"actuators", of_base}};
    if (h.base->spread > 0.0) json["base"]["spread"] = h.base->spread;
  }
  return json;
}

// No white space, whatever stands in a recording's name: equal text for what was written and what is read back.
template <typename AnyJson>
std::string hash_of(const AnyJson& json) {
  return io::sha256(json.dump(-1, ' ', false, AnyJson::error_handler_t::replace));
}

// All that a prediction takes from a member's file.
FloatJson deciding_part(const FloatJson& member) {
  FloatJson part;
  for (const char* key : {"training_id", "output_mean", "output_sd", "dynamics", "initial_state"})
    part[key] = member.at(key);
  if (member.contains("base")) part["base"] = member.at("base");
  return part;
}

// All that a training and its use take from ensemble.json and that the training_id does not cover.
std::string header_hash(const io::Json& json) {
  return hash_of(io::Json{{"training_id", json.at("training_id")}, {"domain", json.at("domain")}});
}

// JSON has no infinite number: one would be written as null.
void require_finite(const io::Json& json, const std::string& path) {
  const io::Json flat = json.flatten();
  for (const auto& [pointer, value] : flat.items())
    if (value.is_number_float() && !std::isfinite(value.get<double>()))
      throw NumericalError(fmt::format("{}: {} would be no finite number; nothing is written", path, pointer));
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

void network_from_json(const FloatJson& layers, const nn::NetworkShape& shape, nn::AlignedVector<float>& parameters) {
  if (shape.outputs == 0) return;
  if (static_cast<int>(layers.size()) != nn::layer_count(shape)) throw std::out_of_range("number of layers");
  for (int l = 0; l < nn::layer_count(shape); ++l) {
    const int rows = nn::layer_outputs(shape, l), cols = nn::layer_inputs(shape, l);
    const FloatJson& weights = layers.at(l).at("weights");
    const FloatJson& bias = layers.at(l).at("bias");
    if (static_cast<int>(weights.size()) != rows || static_cast<int>(bias.size()) != rows)
      throw std::out_of_range(fmt::format("rows of layer {}", l));
    const std::size_t begin = parameters.size();
    parameters.resize(begin + static_cast<std::size_t>(rows) * cols);
    for (int i = 0; i < rows; ++i) {
      if (static_cast<int>(weights.at(i).size()) != cols)
        throw std::out_of_range(fmt::format("columns of layer {}", l));
      for (int j = 0; j < cols; ++j)
        parameters[begin + static_cast<std::size_t>(j) * rows + i] = weights.at(i).at(j).get<float>();
    }
    for (int i = 0; i < rows; ++i) parameters.push_back(bias.at(i).get<float>());
  }
  for (const float p : parameters)
    if (!std::isfinite(p)) throw std::out_of_range("a weight is no finite number");
}

// Double-precision numbers as text within a single-precision file, so that their bits stay as well.
template <std::size_t n>
std::vector<std::string> exact(const std::array<double, n>& values) {
  std::vector<std::string> texts;
  texts.reserve(n);
  for (const double value : values) texts.push_back(fmt::format("{}", value));
  return texts;
}

template <std::size_t n = 3>
std::array<double, n> exact_from(const FloatJson& json) {
  std::array<double, n> values{};
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

// Reads a file of ours whose parts are nested too deep for one pointer each: any mismatch is one InputError.
template <typename Read>
auto checked(const std::string& path, const Read& read) {
  try {
    return read();
  } catch (const nlohmann::json::exception& error) {
    throw InputError(path, fmt::format("not a member file of this version: {}", error.what()));
  } catch (const std::out_of_range& error) {
    throw InputError(path, fmt::format("does not fit the ensemble: {}", error.what()));
  }
}

OwnBase own_base_from(const FloatJson& json) {
  OwnBase own{json.at("sha256").get<std::string>(), exact_from(json.at("acceleration_mean")),
              exact_from(json.at("acceleration_sd"))};
  for (const double sd : own.acceleration_sd)
    if (!(sd > 0.0)) throw std::out_of_range("acceleration_sd is not > 0");
  return own;
}

void check_member_keys(const FloatJson& json, const std::string& path) {
  if (json.at("format").get<std::string>() != "leeway member 1")
    throw InputError(path, 0, "/format", "expected \"leeway member 1\"");
  constexpr std::array kKeys{"format",   "training_id",   "member",         "kernel", "output_mean", "output_sd",
                             "dynamics", "initial_state", "training_curve", "sha256", "base"};
  const auto check = [&](const FloatJson& object, const std::string& pointer, auto begin, auto end) {
    for (const auto& item : object.items())
      if (std::find(begin, end, item.key()) == end)
        throw InputError(path, 0, pointer + item.key(),
                         fmt::format("unknown key; known here: {}", fmt::join(begin, end, ", ")));
  };
  check(json, "/", kKeys.begin(), kKeys.end());
  constexpr std::array kBaseKeys{"ship", "sha256", "acceleration_mean", "acceleration_sd"};
  if (json.contains("base")) check(json.at("base"), "/base/", kBaseKeys.begin(), kBaseKeys.end());
  constexpr std::array kLayerKeys{"weights", "bias"};
  for (const char* network : {"dynamics", "initial_state"})
    for (std::size_t l = 0; l < json.at(network).size(); ++l)
      check(json.at(network).at(l), fmt::format("/{}/{}/", network, l), kLayerKeys.begin(), kLayerKeys.end());
}

std::shared_ptr<const BaseModel> read_base_file(const std::string& path, const std::string& sha256,
                                                const std::string& which) {
  std::string text = io::read_text(path);
  if (io::sha256(text) != sha256) throw InputError(path, fmt::format("is not the ship {}", which));
  return std::make_shared<const BaseModel>(read_ship(path), std::move(text));
}

void check_training_id(const std::string& path, const std::string& found, const EnsembleHeader& header) {
  if (found != header.training_id)
    throw InputError(path, "belongs to another training (data, settings, base or seed differ from ensemble.json)");
}

}  // namespace

EnsembleHeader make_header(const TrainingData& data, std::uint64_t seed, std::vector<TrainingFile> files) {
  EnsembleHeader header{data.config, data.inputs, seed, std::move(files), std::nullopt, ""};
  if (data.base) header.base = {data.base->ship().name, data.base->sha256(), data.base_spread};
  header.training_id = hash_of(training_to_json(header));
  return header;
}

void write_header(const std::string& folder, const EnsembleHeader& header, const io::Json& provenance,
                  const BaseModel* base) {
  if (base != nullptr) {
    io::write_text(base_path(folder), base->text());
  } else {
    std::error_code error;
    fs::remove(base_path(folder), error);  // of an earlier training
  }
  io::Json members = io::Json::array();
  for (int k = 0; k < header.config.members; ++k)
    members.push_back(fs::path(member_path(folder, k)).filename().string());
  const std::string path = (fs::path(folder) / kIndexFile).string();
  io::Json json{{"format", "leeway ensemble 1"},
                {"training_id", header.training_id},
                {"training", training_to_json(header)},
                {"domain", domain_to_json(header.inputs.domain)},
                {"members", members},
                {"provenance", provenance}};
  json["sha256"] = header_hash(json);
  require_finite(json, path);
  io::write_text(path, io::to_text(json));
}

std::optional<EnsembleHeader> read_header(const std::string& folder, bool optional) {
  const std::string path = (fs::path(folder) / kIndexFile).string();
  std::error_code error;
  if (optional && !fs::exists(path, error)) return std::nullopt;
  const io::Json json = io::read_json(path);
  const io::JsonObject file(json, path);
  EnsembleHeader h;
  if (file.text("format") != "leeway ensemble 1") file.fail("format", "expected \"leeway ensemble 1\"");
  h.training_id = file.text("training_id");
  const io::JsonObject training = file.object("training");
  const io::Json& seed = training.value("seed");  // up to 2^64 - 1, which no other number here needs
  if (!seed.is_number_unsigned())
    training.fail("seed", fmt::format("expected a whole number >= 0, got {}", seed.dump()));
  h.seed = seed.get<std::uint64_t>();
  h.config = training_config_from(training.object("config"));
  const std::vector<std::string> members = file.texts("members");
  h.config.members = static_cast<int>(members.size());
  if (members.empty()) file.fail("members", "expected at least one member");
  for (int k = 0; k < h.config.members; ++k)
    if (const std::string expected = fs::path(member_path(folder, k)).filename().string();
        members[static_cast<std::size_t>(k)] != expected)
      file.fail(fmt::format("members/{}", k), fmt::format("expected \"{}\"", expected));
  for (const std::string& name : training.texts("actuators"))
    h.inputs.actuators.push_back(channel_from(training, "actuators", name));
  h.inputs.wind = training.flag_or("wind", false);
  for (const io::JsonObject& constant : training.objects("constant_columns")) {
    h.inputs.constants.emplace_back(channel_from(constant, "column", constant.text("column")),
                                    constant.number("value_si"));
    constant.check_all_known();
  }
  h.inputs.inputs = spreads_from(training, "inputs");
  h.inputs.accelerations = spreads_from(training, "accelerations");
  h.inputs.pose_in_initial_state = training.flag_or("pose_in_initial_state", false);
  h.inputs.initial_state = spreads_from(training, "initial_state_inputs");
  h.inputs.largest_speed_mps = training.number("largest_speed_mps");
  h.inputs.largest_rate_radps = training.number("largest_rate_radps");
  const std::size_t expected = 3 + h.inputs.actuators.size() + (h.inputs.wind ? 2 : 0);
  if (h.inputs.inputs.size() != expected)
    training.fail("inputs", fmt::format("expected {} entries, got {}", expected, h.inputs.inputs.size()));
  if (h.inputs.accelerations.size() != 3) training.fail("accelerations", "expected 3 entries");
  for (const io::JsonObject& f : training.objects("files")) {
    h.files.push_back(
        {f.text("recording"), f.text("sha256"), static_cast<std::size_t>(f.integer("rows", io::kNotNegative))});
    f.check_all_known();
  }
  if (const auto base = training.object_if("base")) {
    base->word("ship", {kBaseFile});
    h.base = {base->text("name"), base->text("sha256"), base->number_or("spread", 0.0, io::kPositive)};
    for (const std::string& name : base->texts("actuators"))
      h.inputs.base_actuators.push_back(channel_from(*base, "actuators", name));
    base->check_all_known();
  }
  training.check_all_known();
  if (file.has("domain"))  // ensembles of earlier versions have none
    for (const io::JsonObject& range : file.objects("domain")) {
      h.inputs.domain.push_back({range.text("name"), range.number("low"), range.number("high")});
      range.check_all_known();
    }
  file.has("provenance");
  const bool has_hash = file.has("sha256");  // nor have they one
  file.check_all_known();
  if (hash_of(json.at("training")) != h.training_id)
    file.fail("training_id", "is not the SHA-256 of /training: the file was changed after the training");
  if (has_hash && (!json.contains("domain") || file.text("sha256") != header_hash(json)))
    file.fail("sha256", "is not that of /training_id and /domain: the file was changed after the training");
  return h;
}

bool is_model_file(const std::string& path) {
  const std::string name = fs::path(path).filename().string();
  return name == kIndexFile || name == kBaseFile || name.starts_with(kMemberPrefix);
}

std::string base_path(const std::string& folder) { return (fs::path(folder) / kBaseFile).string(); }

std::shared_ptr<const BaseModel> read_base(const std::string& folder, const EnsembleHeader& header) {
  if (!header.base) return nullptr;
  return read_base_file(base_path(folder), header.base->sha256,
                        fmt::format("'{}' that the members were trained with", header.base->name));
}

std::shared_ptr<const BaseModel> read_own_base(const std::string& folder, const Member& member) {
  if (!member.own_base) return nullptr;
  return read_base_file(member_ship_path(folder, member.number), member.own_base->sha256,
                        fmt::format("that member {} was trained with", member.number));
}

std::string member_path(const std::string& folder, int number) {
  return (fs::path(folder) / fmt::format("member-{:02}.json", number)).string();
}

std::string member_ship_path(const std::string& folder, int number) {
  return (fs::path(folder) / fmt::format("member-{:02}.ship.json", number)).string();
}

std::string checkpoint_path(const std::string& folder, int number) {
  return (fs::path(folder) / fmt::format("member-{:02}.checkpoint", number)).string();
}

bool member_exists(const std::string& folder, int number) {
  std::error_code error;
  return fs::exists(member_path(folder, number), error);
}

void write_member(const std::string& folder, const Member& member, const EnsembleHeader& header,
                  const std::function<void()>& before_rename) {
  const std::size_t split = nn::parameter_count(member.dynamics);
  const std::string path = member_path(folder, member.number);
  require_finite(member, path);
  FloatJson json{{"format", "leeway member 1"},
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
  return checked(path, [&] {
    io::check_json<FloatJson>(text, path, io::JsonTop::object);
    const FloatJson json = FloatJson::parse(text);
    check_training_id(path, json.at("training_id").get<std::string>(), header);
    Member member;
    member.number = static_cast<int>(whole_from(json.at("member")));
    if (member.number != number) throw std::out_of_range(fmt::format("it is member {}", member.number));
    member.kernel = json.at("kernel").get<std::string>();
    member.output_mean = exact_from(json.at("output_mean"));
    member.output_sd = exact_from(json.at("output_sd"));
    for (const double sd : member.output_sd)
      if (!(sd > 0.0)) throw std::out_of_range("output_sd is not > 0");
    member.dynamics = dynamics_shape(header.inputs, header.config);
    member.initial_state = initial_state_shape(header.inputs, header.config);
    network_from_json(json.at("dynamics"), member.dynamics, member.parameters);
    network_from_json(json.at("initial_state"), member.initial_state, member.parameters);
    member.training_curve = json.at("training_curve").get<std::vector<float>>();
    if (header.base && header.base->spread > 0.0) member.own_base = own_base_from(json.at("base"));
    check_member_keys(json, path);
    member.verified = json.contains("sha256");
    if (member.verified && json.at("sha256").get<std::string>() != hash_of(deciding_part(json)))
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
  return checked(path, [&] {
    io::check_cbor<FloatJson>(body, path);
    const FloatJson json = FloatJson::from_cbor(body);
    check_training_id(path, json.at("training_id").get<std::string>(), header);
    TrainingState state;
    state.member.number = number;
    state.member.kernel = json.at("kernel").get<std::string>();
    state.member.output_mean = exact_from(json.at("output_mean"));
    state.member.output_sd = exact_from(json.at("output_sd"));
    state.member.dynamics = dynamics_shape(header.inputs, header.config);
    state.member.initial_state = initial_state_shape(header.inputs, header.config);
    state.epochs_done = static_cast<int>(whole_from(json.at("epochs_done")));
    state.windows_done = static_cast<std::size_t>(whole_from(json.at("windows_done")));
    const std::array<double, 2> sums = exact_from<2>(json.at("loss_sum_and_points"));
    state.loss_sum = sums[0];
    state.points = sums[1];
    state.adam_steps = whole_from(json.at("adam_steps"));
    state.member.parameters = floats_from(json.at("parameters"));
    state.adam_m = floats_from(json.at("adam_m"));
    state.adam_v = floats_from(json.at("adam_v"));
    state.muon_momentum = floats_from(json.at("muon_momentum"));
    state.member.training_curve = json.at("training_curve").get<std::vector<float>>();
    const std::size_t n = nn::parameter_count(state.member.dynamics) + nn::parameter_count(state.member.initial_state);
    const std::size_t muon = header.config.optimizer == Optimizer::muon
                                 ? Muon({state.member.dynamics, state.member.initial_state}).size()
                                 : 0;
    if (state.member.parameters.size() != n || state.adam_m.size() != n || state.adam_v.size() != n ||
        state.muon_momentum.size() != muon)
      throw std::out_of_range("number of parameters");
    return std::optional<TrainingState>(std::move(state));
  });
}

void remove_checkpoint(const std::string& folder, int number) {
  std::error_code error;
  fs::remove(checkpoint_path(folder, number), error);
}

}  // namespace leeway::ensemble
