// Readers of JSON, but for those of a model.

#include <algorithm>
#include <filesystem>
#include <functional>
#include <set>

#include <nlohmann/json.hpp>

#include "core/errors.hpp"
#include "dynamics/dataset.hpp"
#include "dynamics/model.hpp"
#include "effects/description.hpp"
#include "ensemble/config.hpp"
#include "fuzz/readers.hpp"
#include "io/columns_map.hpp"
#include "io/dataset_json.hpp"
#include "io/result_folder.hpp"
#include "metrics/scores.hpp"
#include "ship/ship.hpp"

namespace leeway::test {
namespace {
namespace fs = std::filesystem;

void read_plain_json(HostileFiles& files, std::string_view text) {
  const std::string path = files.write("any.json", text);
  const io::Json json = io::read_json(path, io::JsonTop::object_or_array);
  expect(io::Json::accept(text), "no JSON, and accepted");
  expect(io::parse_json(io::to_text(json), path, io::JsonTop::object_or_array) == json,
         "written and read again, it differs");
}

// Accelerations somewhere off a straight course: in them is all that a ship's file says of its forces.
Vec3<double> accelerations(const Ship& ship, const Model<double>& model) {
  Actuators<double> actuators = ship.initial_actuators();
  for (const Actuator& actuator : ship.actuators)
    if (!actuator.is_propulsion()) actuators[actuator.channel] = 0.3 * actuator.max;
  return model.acceleration({0.8, -0.1, 0.02}, actuators, {2.0, 1.0});
}

void read_ship_text(HostileFiles& files, std::string_view text) {
  const Ship ship = read_ship(files.write("ship.json", text));
  const Vec3<double> before = accelerations(ship, Model<double>(ship));
  for (const Actuator& a : ship.actuators)
    expect(a.min <= a.initial && a.initial <= a.max, "an actuator starts outside its limits");
  if (ship.residual_network) {
    const io::Json network = to_json(*ship.residual_network);
    const ResidualNetwork again = residual_network_from(io::JsonObject(network, files.path("ship.json")));
    expect(to_json(again) == network, "a network that is written and read again differs");
  }
  const std::string rewritten = io::to_text(io::Json::parse(text));
  const auto read = [&](const std::string& changed) {
    const Ship again = read_ship(files.write("again.json", changed));
    return accelerations(again, Model<double>(again));
  };
  const Vec3<double> after = read(rewritten);
  for (int i = 0; i < 3; ++i) expect(same(before(i), after(i)), "written and read again, the ship moves otherwise");
  expect_strict(rewritten, {}, read);
}

void read_effects_text(HostileFiles& files, std::string_view text) {
  static const Ship ship = read_ship("vectwin-3m");
  const auto read = [&](const std::string& path) {
    Ship with = ship;
    with.effects = read_effects(path);
    for (const EffectEntry& entry : with.effects)
      if (const auto values = effect_values(entry))
        for (const double value : values->values) expect(std::isfinite(value) || std::isnan(value), "infinite");
    accelerations(with, Model<double>(with));
  };
  read(files.write("effect.json", text));
  expect_strict(std::string(text), {}, [&](const std::string& changed) { read(files.write("again.json", changed)); });
}

void read_spec_text(HostileFiles& files, std::string_view text) {
  const DatasetSpec spec = read_dataset_spec(files.write("spec.json", text));
  std::set<std::string> names;
  for (const DatasetSpec::Set& set : spec.sets) {
    expect(!set.runs.empty(), "a set without runs");
    for (const RunSpec& run : set.runs) {
      expect(names.insert(run.name).second, "two runs of one name");
      expect(run.name.find('/') == std::string::npos, "a name leads out of the folder");
      if (run.kind == ManeuverKind::replay) continue;  // as long as what it replays
      expect(run.duration_s > 0.0 && std::isfinite(run.duration_s), "a run without a duration");
    }
  }
  expect_strict(std::string(text), {},
                [&](const std::string& changed) { read_dataset_spec(files.write("again.json", changed)); });
}

void read_dataset_text(HostileFiles& files, std::string_view text) {
  const std::string path = files.write("dataset.json", text);
  const std::vector<io::RecordingFile> all = io::expand_recordings({path});
  expect(!all.empty(), "no recording");
  std::set<std::string> sets;
  for (const io::RecordingFile& recording : all) sets.insert(recording.set);
  std::size_t in_sets = 0;
  for (const std::string& set : sets)
    if (!set.empty() && !fs::exists(path + "#" + set)) in_sets += io::expand_recordings({path + "#" + set}).size();
  if (!sets.contains("")) expect(in_sets == all.size(), "the sets' recordings are not those of the data set");
  expect(io::named_files({path}).size() > all.size(), "a file is lost");
  expect_strict(std::string(text),
                {"name", "description", "source", "ship", "maneuver", "noise", "seed", "spec", "provenance", "parts"},
                [&](const std::string& changed) { io::expand_recordings({files.write("again.json", changed)}); });
}

void read_noise_text(HostileFiles& files, std::string_view text) {
  const ObservationNoise noise = read_noise(files.write("noise.json", text));
  const io::Json written = to_json(noise);
  const ObservationNoise again = parse_noise(io::JsonObject(written, "again"));
  for (const double ObservationNoise::*sd : {&ObservationNoise::x0, &ObservationNoise::y0, &ObservationNoise::psi,
                                             &ObservationNoise::u, &ObservationNoise::vm, &ObservationNoise::r})
    expect(noise.*sd >= 0.0 && same(noise.*sd, again.*sd), "written and read again, it differs");
  expect_strict(std::string(text), {},
                [&](const std::string& changed) { read_noise(files.write("again.json", changed)); });
}

void read_config_text(HostileFiles& files, std::string_view text) {
  const ensemble::TrainingConfig config = ensemble::read_training_config(files.write("config.json", text));
  expect((config.sigma.array() > 0.0).all() && (config.pose_scale.array() > 0.0).all(), "a sigma of zero");
  const io::Json written = ensemble::to_json(config);
  const io::Json again = ensemble::to_json(ensemble::training_config_from(io::JsonObject(written, "again")));
  const io::Json flat = written.flatten(), flat_again = again.flatten();
  expect(flat.size() == flat_again.size(), "written and read again, keys differ");
  for (const auto& [key, value] : flat.items())
    expect(
        value.is_number_float() ? same(value.get<double>(), flat_again[key].get<double>()) : value == flat_again[key],
        "written and read again, it differs: " + key);
  expect_strict(std::string(text), {}, [&](const std::string& changed) {
    ensemble::read_training_config(files.write("again.json", changed));
  });
}

void read_map_text(HostileFiles& files, std::string_view text) {
  const io::ColumnsMap map = io::read_columns_map(files.write("map.json", text));
  io::Json written{{"missing", map.missing}}, file = io::Json::object();
  const bool is_earth = map.velocity_frame == io::VelocityFrame::earth;
  if (map.velocity_frame != io::VelocityFrame::ship) file["velocity_frame"] = is_earth ? "earth" : "course-and-speed";
  if (map.position == io::PositionForm::latitude_longitude) file["position"] = "latitude-longitude";
  file["scale_factor"] = map.scale_factor;
  written["file"] = file;
  for (const io::ColumnsMap::Source& source : map.columns) {
    expect(source.factor != 0.0 && std::isfinite(source.factor), "a unit without a factor");
    io::Json& column = written[column_name(source.channel)];
    column["from"] = source.from.number > 0 ? io::Json(source.from.number) : io::Json(source.from.name);
    if (!source.unit.suffix.empty()) column["unit"] = source.unit.suffix;
    column["scale"] = source.factor / source.unit.factor;
    column["offset"] = source.offset / source.unit.factor;
  }
  for (const io::ColumnsMap::Derivation& derivation : map.derived)
    written[column_name(derivation.channel)] = {{"derive", column_name(derivation.of)}};
  const io::ColumnsMap again = io::read_columns_map(files.write("again.json", io::to_text(written)));
  expect(again.missing == map.missing && again.columns.size() == map.columns.size() &&
             again.derived.size() == map.derived.size(),
         "written and read again, it differs");
  for (const io::ColumnsMap::Source& source : again.columns) {
    const io::ColumnsMap::Source* const before = map.source_of(source.channel);
    expect(before != nullptr && before->from == source.from && same(before->factor, source.factor) &&
               same(before->offset, source.offset),
           "written and read again, a column differs");
  }
  // A column's number as a text is a name.
  expect_strict(std::string(text), {"from"},
                [&](const std::string& changed) { io::read_columns_map(files.write("again.json", changed)); });
}

// prediction.json beside a prediction.
void read_prediction_index(HostileFiles& files, std::string_view text) {
  files.write("rec.csv", "recording\n");
  const std::string path = files.write("prediction.json", text);
  const PredictionSource source = find_predictions({files.folder()});
  expect(std::ranges::any_of(source.files, [&](const auto& file) { return file.path == files.path("rec.csv"); }),
         "a prediction is lost");
  const std::vector<std::string> free{
      "provenance", "parts", "generation", "members", "particles", "time_step_s", "particles_out_of_bounds", "steps"};
  expect_strict(std::string(text), free, [&](const std::string& changed) {
    files.write("prediction.json", changed);
    find_predictions({files.folder()});
  });
}

// The index of a folder of results, and the list of a run that was killed: what they name is removed.
void read_result_index(HostileFiles& files, std::string_view text) {
  files.write("part.csv", "");
  for (const char* name : {"report.json", "report.json.unfinished"}) files.write(name, text);
  for (const std::string& path : io::ResultFolder(files.folder(), "report.json", {"new.csv"}).outputs())
    expect(fs::path(path).lexically_normal().string().starts_with(files.folder() + "/"),
           "what lies elsewhere would be removed: " + path);
}

}  // namespace

const std::vector<Reader>& json_readers() {
  static const std::vector<Reader> all{{"json", "configs/noise", read_plain_json},
                                       {"ship", "configs/ships", read_ship_text},
                                       {"effects", "", read_effects_text},
                                       {"dataset-spec", "configs/datasets", read_spec_text},
                                       {"dataset", "", read_dataset_text},
                                       {"noise", "configs/noise", read_noise_text},
                                       {"training-config", "configs/train", read_config_text},
                                       {"columns-map", "configs/columns", read_map_text},
                                       {"prediction-index", "", read_prediction_index},
                                       {"result-index", "", read_result_index, Wrong::passed_over}};
  return all;
}

}  // namespace leeway::test
