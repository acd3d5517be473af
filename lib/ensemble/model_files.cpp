#include "ensemble/model_files.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "core/errors.hpp"
#include "ensemble/model_json.hpp"
#include "io/csv.hpp"
#include "io/files.hpp"

namespace leeway::ensemble {
namespace fs = std::filesystem;
namespace {

constexpr const char* kIndexFile = "ensemble.json";
constexpr const char* kMemberPrefix = "member-";
constexpr const char* kBaseFile = "base-ship.json";
constexpr const char* kStatedFile = "stated-ship.json";
constexpr const char* kCalibrationFile = "calibration.json";

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
    if (!h.base->stated_sha256.empty()) json["base"]["fitted_from"] = h.base->stated_sha256;
  }
  return json;
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

std::shared_ptr<const BaseModel> read_base_file(const std::string& path, const std::string& sha256,
                                                const std::string& which) {
  std::string text = io::read_text(path);
  if (io::sha256(text) != sha256) throw InputError(path, fmt::format("is not the ship {}", which));
  return std::make_shared<const BaseModel>(read_ship(path), std::move(text));
}

}  // namespace

EnsembleHeader make_header(const TrainingData& data, std::uint64_t seed, std::vector<TrainingFile> files) {
  EnsembleHeader header{data.config, data.inputs, seed, std::move(files), std::nullopt, ""};
  if (data.base)
    header.base = {data.base->ship().name, data.base->sha256(), data.base_spread,
                   data.stated ? data.stated->sha256() : std::string()};
  header.training_id = hash_of(training_to_json(header));
  return header;
}

void write_header(const std::string& folder, const EnsembleHeader& header, const io::Json& provenance,
                  const BaseModel* base, const BaseModel* stated) {
  for (const auto& [ship, file] : {std::pair(base, base_path(folder)), std::pair(stated, stated_path(folder))}) {
    std::error_code error;
    if (ship != nullptr)
      io::write_text(file, ship->text());
    else
      fs::remove(file, error);  // of an earlier training
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
    h.base = {base->text("name"), base->text("sha256"), base->number_or("spread", 0.0, io::kPositive),
              base->text_or("fitted_from", "")};
    for (const std::string& name : base->texts("actuators"))
      h.inputs.base_actuators.push_back(channel_from(*base, "actuators", name));
    base->check_all_known();
  }
  training.check_all_known();
  for (const io::JsonObject& range : file.objects("domain")) {
    h.inputs.domain.push_back({range.text("name"), range.number("low"), range.number("high")});
    range.check_all_known();
  }
  file.has("provenance");
  h.is_hashed = file.has("sha256");
  file.check_all_known();
  if (hash_of(json.at("training")) != h.training_id)
    file.fail("training_id", "is not the SHA-256 of /training: the file was changed after the training");
  if (h.is_hashed && file.text("sha256") != header_hash(json))
    file.fail("sha256", "is not that of /training_id and /domain: the file was changed after the training");
  return h;
}

bool is_model_file(const std::string& path) {
  const std::string name = fs::path(path).filename().string();
  return name == kIndexFile || name == kBaseFile || name == kStatedFile || name == kCalibrationFile ||
         name.starts_with(kMemberPrefix);
}

std::string base_path(const std::string& folder) { return (fs::path(folder) / kBaseFile).string(); }

std::string stated_path(const std::string& folder) { return (fs::path(folder) / kStatedFile).string(); }

std::string calibration_path(const std::string& folder) { return (fs::path(folder) / kCalibrationFile).string(); }

bool has_base_file(const std::string& folder, const EnsembleHeader& header) {
  const auto holds = [](const std::string& path, const std::string& sha256) {
    std::error_code error;
    return fs::exists(path, error) && io::sha256(io::read_text(path)) == sha256;
  };
  if (!header.base) return true;
  const std::string& stated = header.base->stated_sha256;
  return holds(base_path(folder), header.base->sha256) && (stated.empty() || holds(stated_path(folder), stated));
}

std::shared_ptr<const BaseModel> read_base(const std::string& folder, const EnsembleHeader& header) {
  if (!header.base) return nullptr;
  return read_base_file(base_path(folder), header.base->sha256,
                        fmt::format("'{}' that the members were trained with", header.base->name));
}

std::shared_ptr<const BaseModel> read_given_base(const std::string& folder, const EnsembleHeader& header) {
  if (!header.base || header.base->stated_sha256.empty()) return read_base(folder, header);
  return read_base_file(stated_path(folder), header.base->stated_sha256, "that the training was given");
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

}  // namespace leeway::ensemble
