#include "ensemble/calibration.hpp"

#include <filesystem>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/units.hpp"
#include "ensemble/model_json.hpp"

namespace leeway::ensemble {
namespace {

constexpr const char* kFormat = "leeway calibration 1";

// A quantity of u, v_m and r in the file: its keys, and what SI numbers are divided by.
struct Keys {
  std::array<const char*, 3> names;
  std::array<double, 3> unit;
};
constexpr Keys kVelocities{{"u_mps", "vm_mps", "r_degps"}, {1.0, 1.0, kDegree}};
constexpr Keys kSquares{{"u_m2ps2", "vm_m2ps2", "r_deg2ps2"}, {1.0, 1.0, kDegree* kDegree}};
constexpr Keys kAccelerations{{"udot_mps2", "vmdot_mps2", "rdot_degps2"}, {1.0, 1.0, kDegree}};
constexpr std::array<const char*, 4> kChannels{"u_mps", "vm_mps", "r_degps", "position_m"};
constexpr std::array<double, 4> kChannelUnits{1.0, 1.0, kDegree, 1.0};

io::Json vector_to_json(const Vec3<double>& values, const Keys& keys) {
  io::Json json;
  for (std::size_t i = 0; i < 3; ++i) json[keys.names[i]] = values(static_cast<Eigen::Index>(i)) / keys.unit[i];
  return json;
}

Vec3<double> vector_from(const io::JsonObject& object, const Keys& keys) {
  Vec3<double> values;
  for (std::size_t i = 0; i < 3; ++i)
    values(static_cast<Eigen::Index>(i)) = keys.unit[i] * object.number(keys.names[i], io::kNotNegative);
  object.check_all_known();
  return values;
}

io::Json disturbance_to_json(const Disturbance& disturbance) {
  io::Json json;
  for (std::size_t i = 0; i < 3; ++i) {
    io::Json& axis = json[kAccelerations.names[i]] = io::Json::array();
    for (const OrnsteinUhlenbeck& process : disturbance.axes[i])
      axis.push_back({{"sd", process.sd / kAccelerations.unit[i]}, {"tau_s", process.tau_s}});
  }
  return json;
}

Disturbance disturbance_from(const io::JsonObject& object) {
  Disturbance disturbance;
  for (std::size_t i = 0; i < 3; ++i)
    for (const io::JsonObject& process : object.objects(kAccelerations.names[i])) {
      disturbance.axes[i].push_back(
          {kAccelerations.unit[i] * process.number("sd", io::kPositive), process.number("tau_s", io::kPositive)});
      process.check_all_known();
    }
  object.check_all_known();
  return disturbance;
}

std::vector<RadiiAtTime> radii_from(const std::vector<io::JsonObject>& objects) {
  std::vector<RadiiAtTime> radii;
  for (const io::JsonObject& object : objects) {
    RadiiAtTime at{object.number("t_s", io::kPositive), {}};
    for (std::size_t c = 0; c < kChannels.size(); ++c) {
      const io::JsonObject channel = object.object(kChannels[c]);
      const auto radius = [&](const char* key) -> std::optional<double> {
        if (channel.value(key).is_null()) return std::nullopt;
        return kChannelUnits[c] * channel.number(key, io::kNotNegative);
      };
      at.channels[c] = {radius("50"), radius("90")};
      channel.check_all_known();
    }
    object.check_all_known();
    radii.push_back(at);
  }
  return radii;
}

}  // namespace

io::Json to_json(const std::vector<RadiiAtTime>& radii) {
  io::Json json = io::Json::array();
  for (const RadiiAtTime& at : radii) {
    io::Json row{{"t_s", at.t_s}};
    for (std::size_t c = 0; c < kChannels.size(); ++c) {
      const auto number = [&](const std::optional<double>& radius) {
        return radius ? io::Json(*radius / kChannelUnits[c]) : io::Json();
      };
      row[kChannels[c]] = {{"50", number(at.channels[c].half)}, {"90", number(at.channels[c].most)}};
    }
    json.push_back(row);
  }
  return json;
}

void write_calibration(const std::string& folder, const Calibration& c, const EnsembleHeader& header,
                       const io::Json& provenance) {
  io::Json json{{"format", kFormat},
                {"training_id", header.training_id},
                {"disturbance", disturbance_to_json(c.disturbance)},
                {"sensor_sd", vector_to_json(c.sensor_sd, kVelocities)},
                {"squared_error", vector_to_json(c.squared_error, kSquares)},
                {"expected",
                 {{"members", vector_to_json(c.of_members, kSquares)},
                  {"inputs", vector_to_json(c.of_inputs, kSquares)},
                  {"disturbance", vector_to_json(c.of_disturbance, kSquares)},
                  {"sensors", vector_to_json(c.of_sensors, kSquares)}}},
                {"folds", c.folds},
                {"members", c.members},
                {"recordings", c.recordings},
                {"sequences", c.sequences},
                {"radii", to_json(c.radii)}};
  json["sha256"] = hash_of(json);
  json["provenance"] = provenance;
  io::write_text(calibration_path(folder), io::to_text(json));
}

std::optional<Calibration> read_calibration(const std::string& folder, const EnsembleHeader& header) {
  const std::string path = calibration_path(folder);
  std::error_code error;
  if (!std::filesystem::exists(path, error)) return std::nullopt;
  const io::Json json = io::read_json(path);
  const io::JsonObject file(json, path);
  if (file.text("format") != kFormat) file.fail("format", fmt::format("expected \"{}\"", kFormat));
  if (file.text("training_id") != header.training_id)
    file.fail("training_id", "is of another training than this folder's; ens-train --calibrate makes one that fits");
  Calibration c;
  c.disturbance = disturbance_from(file.object("disturbance"));
  c.sensor_sd = vector_from(file.object("sensor_sd"), kVelocities);
  c.squared_error = vector_from(file.object("squared_error"), kSquares);
  const io::JsonObject expected = file.object("expected");
  c.of_members = vector_from(expected.object("members"), kSquares);
  c.of_inputs = vector_from(expected.object("inputs"), kSquares);
  c.of_disturbance = vector_from(expected.object("disturbance"), kSquares);
  c.of_sensors = vector_from(expected.object("sensors"), kSquares);
  expected.check_all_known();
  c.folds = static_cast<int>(file.integer("folds", io::kPositive));
  c.members = static_cast<int>(file.integer("members", io::kPositive));
  c.recordings = static_cast<std::size_t>(file.integer("recordings", io::kPositive));
  c.sequences = static_cast<std::size_t>(file.integer("sequences", io::kPositive));
  c.radii = radii_from(file.objects("radii"));
  file.has("provenance");
  io::Json rest = json;
  rest.erase("provenance");
  rest.erase("sha256");
  if (file.text("sha256") != hash_of(rest)) file.fail("sha256", "is not that of the file's numbers: it was changed");
  file.check_all_known();
  return c;
}

}  // namespace leeway::ensemble
