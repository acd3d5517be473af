// Readers of a model directory. Hashes guard its files: each text is read as it is and with the hashes that it should
// have, since otherwise hardly one would pass the first check.

#include <algorithm>
#include <functional>
#include <map>

#include <nlohmann/json.hpp>

#include "core/errors.hpp"
#include "ensemble/model_files.hpp"
#include "ensemble/training_status.hpp"
#include "fuzz/readers.hpp"
#include "io/files.hpp"

namespace leeway::test {
namespace {

using ensemble::EnsembleHeader;
using FloatJson =
    nlohmann::basic_json<nlohmann::ordered_map, std::vector, std::string, bool, std::int64_t, std::uint64_t, float>;

template <typename AnyJson>
std::string hash_of(const AnyJson& json) {
  return io::sha256(json.dump(-1, ' ', false, AnyJson::error_handler_t::replace));
}

template <typename AnyJson>
std::string compact(const AnyJson& json) {
  return json.dump(-1, ' ', false, AnyJson::error_handler_t::replace) + "\n";
}

// The text with the hashes that belong to it; as it is where it is not of the form.
std::string with_header_hashes(const std::string& text) {
  io::Json json = io::Json::parse(text, nullptr, false);
  if (!json.is_object() || !json.contains("training")) return text;
  json["training_id"] = hash_of(json["training"]);
  if (json.contains("domain"))
    json["sha256"] = hash_of(io::Json{{"training_id", json["training_id"]}, {"domain", json["domain"]}});
  return compact(json);
}

std::string with_member_hashes(const std::string& text, const std::string& training_id) {
  FloatJson json = FloatJson::parse(text, nullptr, false);
  if (!json.is_object()) return text;
  json["training_id"] = training_id;
  FloatJson part;
  for (const char* key : {"training_id", "output_mean", "output_sd", "dynamics", "initial_state"}) {
    if (!json.contains(key)) return text;
    part[key] = json[key];
  }
  json["sha256"] = hash_of(part);
  return compact(json);
}

std::string with_checkpoint_hash(std::string_view body) {
  return fmt::format("leeway checkpoint 2 {}\n{}", io::sha256(body), body);
}

// That of the members and checkpoints in the corpus.
const EnsembleHeader& small_header() {
  static const EnsembleHeader header = [] {
    EnsembleHeader h;
    h.config.hidden_layers = 1;
    h.config.hidden_units = 2;
    h.config.initial_state_steps = 1;
    h.config.initial_state_net = false;
    h.config.members = 1;
    for (const char* name : {"u_mps", "vm_mps", "r_radps"}) h.inputs.inputs.push_back({name, 0.0, 1.0});
    h.inputs.accelerations = h.inputs.inputs;
    h.training_id = "small";
    return h;
  }();
  return header;
}

// Refused or not: both are right for a text with other hashes.
template <typename Read>
void try_to(const Read& read) {
  try {
    read();
  } catch (const InputError&) {
  } catch (const IoError&) {
  }
}

void expect_sound(const EnsembleHeader& header) {
  expect(header.config.members >= 1, "no member");
  expect(header.inputs.inputs.size() == 3 + header.inputs.actuators.size() + (header.inputs.wind ? 2 : 0), "inputs");
  for (const auto* spreads : {&header.inputs.inputs, &header.inputs.accelerations, &header.inputs.initial_state})
    for (const ensemble::Spread& spread : *spreads)
      expect(std::isfinite(spread.mean) && spread.sd > 0.0 && std::isfinite(spread.sd), "a standardization");
}

void read_header_text(HostileFiles& files, std::string_view text) {
  const auto read = [&](const std::string& changed) {
    files.write("ensemble.json", changed);
    expect_sound(*ensemble::read_header(files.folder()));
  };
  try_to([&] { read(std::string(text)); });
  const std::string whole = with_header_hashes(std::string(text));
  read(whole);
  expect_strict(whole, {"provenance"}, [&](const std::string& changed) { read(with_header_hashes(changed)); });
}

void expect_finite(const ensemble::Member& member) {
  const auto finite = [](double x) { return std::isfinite(x); };
  expect(std::ranges::all_of(member.parameters, finite) && std::ranges::all_of(member.training_curve, finite) &&
             std::ranges::all_of(member.output_mean, finite) &&
             std::ranges::all_of(member.output_sd, [&](double x) { return finite(x) && x > 0.0; }),
         "a member with numbers that are not finite");
}

void read_member_text(HostileFiles& files, std::string_view text) {
  const auto read = [&](const std::string& changed) {
    files.write("member-00.json", changed);
    const ensemble::Member member = ensemble::read_member(files.folder(), 0, small_header());
    expect(member.parameters.size() == nn::parameter_count(member.dynamics), "number of weights");
    expect(FloatJson::parse(changed)["member"] == 0, "another member's number");
    expect_finite(member);
    return member;
  };
  try_to([&] { read(std::string(text)); });
  const std::string whole = with_member_hashes(std::string(text), small_header().training_id);
  const ensemble::Member member = read(whole);
  const ensemble::Member again = read(compact(FloatJson::parse(whole)));
  expect(std::ranges::equal(member.parameters, again.parameters) && member.output_mean == again.output_mean &&
             member.output_sd == again.output_sd && member.training_curve == again.training_curve,
         "written and read again, it differs");
  expect_strict(whole, {},
                [&](const std::string& changed) { read(with_member_hashes(changed, small_header().training_id)); });
}

void read_checkpoint_text(HostileFiles& files, std::string_view text) {
  const auto read = [&](std::string_view changed) {
    files.write("member-00.checkpoint", changed);
    const auto state = ensemble::read_checkpoint(files.folder(), 0, small_header());
    expect(state.has_value(), "a checkpoint that is there is passed over");
    const std::size_t n = nn::parameter_count(state->member.dynamics);
    expect(state->member.parameters.size() == n && state->adam_m.size() == n && state->adam_v.size() == n, "sizes");
    expect_finite(state->member);
    expect(state->epochs_done >= 0 && state->adam_steps >= 0 && std::isfinite(state->loss_sum), "counts");
  };
  try_to([&] { read(text); });
  read(with_checkpoint_hash(text));
}

void read_owner_text(HostileFiles& files, std::string_view text) {
  files.write("member-00.owner", text);
  if (const auto owner = ensemble::read_owner(files.folder(), 0)) {
    const io::Json json = io::Json::parse(text);
    expect(static_cast<double>(owner->pid) == json["pid"].get<double>() &&
               owner->progress.epochs_done == json["epochs_done"].get<double>(),
           "other numbers than stand there");
    owner->alive();
  }
}

// A model directory as one text: its files one behind the other, each after a line "=== NAME".
void read_directory_text(HostileFiles& files, std::string_view text) {
  constexpr const char* kNames[] = {"ensemble.json",        "member-00.json",  "member-01.json",
                                    "member-00.checkpoint", "member-00.owner", "base-ship.json"};
  std::map<std::string, std::string> parts;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.size(), text.find("\n=== ", at));
    const std::string_view part = text.substr(at, end - at);
    const std::size_t line = std::min(part.size(), part.find('\n'));
    const std::string name(part.substr(part.starts_with("=== ") ? 4 : 0, line - (part.starts_with("=== ") ? 4 : 0)));
    if (line < part.size()) parts[name] = part.substr(line + 1);
    at = end + 1;
  }
  std::string& index = parts["ensemble.json"];
  index = with_header_hashes(index);
  const io::Json json = io::Json::parse(index, nullptr, false);
  const std::string id = json.is_object() && json.contains("training_id") && json["training_id"].is_string()
                             ? json["training_id"].get<std::string>()
                             : "";
  for (const char* name : kNames) {
    const auto part = parts.find(name);
    if (part == parts.end())
      files.remove(name);
    else if (std::string_view(name).starts_with("member-") && std::string_view(name).ends_with(".json"))
      files.write(name, with_member_hashes(part->second, id));
    else if (std::string_view(name).ends_with(".checkpoint"))
      files.write(name, with_checkpoint_hash(part->second));
    else
      files.write(name, part->second);
  }
  const EnsembleHeader header = *ensemble::read_header(files.folder());
  expect_sound(header);
  try_to([&] { ensemble::read_base(files.folder(), header); });
  const ensemble::TrainingStatus status = ensemble::read_training_status(files.folder());
  expect(static_cast<int>(status.members.size()) == header.config.members, "the status has other members");
  for (int k = 0; k < std::min(2, header.config.members); ++k) {
    try_to([&] { ensemble::read_checkpoint(files.folder(), k, header); });
    if (ensemble::member_exists(files.folder(), k)) expect_finite(ensemble::read_member(files.folder(), k, header));
  }
}

}  // namespace

const std::vector<Reader>& model_readers() {
  static const std::vector<Reader> all{{"ensemble", "", read_header_text},
                                       {"member", "", read_member_text},
                                       {"checkpoint", "", read_checkpoint_text},
                                       {"owner", "", read_owner_text, Wrong::passed_over},
                                       {"model-directory", "", read_directory_text}};
  return all;
}

}  // namespace leeway::test
