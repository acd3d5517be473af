#include "ensemble/cross_fit.hpp"

#include <cmath>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "core/errors.hpp"
#include "ensemble/prediction.hpp"
#include "ensemble/simulated.hpp"
#include "io/files.hpp"
#include "temporary_folder.hpp"

using namespace leeway;
using namespace leeway::ensemble;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinRel;

namespace {

// Networks that learn next to nothing, on a base ship that is known: what is left is what was planted.
TrainingConfig quiet_config() {
  TrainingConfig config;
  config.steps = 50;
  config.initial_state_net = false;
  config.hidden_layers = 1;
  config.hidden_units = 4;
  config.epochs = 1;
  config.learning_rate = 1e-9;
  config.members = 3;
  config.calibration = CrossFitConfig{3, 3};
  return config;
}

std::vector<Trajectory> recordings_of(const Ship& ship, double noise) {
  std::vector<Trajectory> recordings;
  for (std::uint64_t seed = 1; seed <= 9; ++seed)
    recordings.push_back(test::simulated_recording(ship, seed, 301, noise));
  return recordings;
}

Calibration calibration_of(const Ship& truth, double noise, const TrainingConfig& config) {
  const std::vector<Trajectory> recordings = recordings_of(truth, noise);
  const auto found =
      cross_fit({recordings, config, BaseModel::read("vectwin-3m"), nullptr, 1, 2, nn::kernels(), {}, {}});
  REQUIRE(found);
  return *found;
}

}  // namespace

TEST_CASE("cross-fitting: every recording is held out once, and what is expected adds up", "[ensemble][calibration]") {
  const Calibration found = calibration_of(read_ship("vectwin-3m"), 0.01, quiet_config());
  CHECK(found.folds == 3);
  CHECK(found.members == 3);
  CHECK(found.recordings == 9);
  CHECK(found.sequences == 54);
  // Networks at random are no draws of the truth, which has none: they expect more than is missed, never less.
  const Vec3<double> expected = found.of_members + found.of_inputs + found.of_disturbance + found.of_sensors;
  for (int axis = 0; axis < 3; ++axis) CHECK(expected(axis) > 0.8 * found.squared_error(axis));
}

TEST_CASE("cross-fitting: radii are those of so many recordings", "[ensemble][calibration]") {
  const Calibration found = calibration_of(read_ship("vectwin-3m"), 0.01, quiet_config());
  REQUIRE(found.radii.size() == 49);
  CHECK(found.radii.front().t_s == 1.0);
  CHECK(found.radii.back().t_s == 49.0);
  // Of nine recordings the fifth smallest is the median, and only the largest holds 90 % of a tenth one.
  for (const RadiiAtTime& at : found.radii)
    for (const Radius& radius : at.channels) {
      REQUIRE(radius.half);
      REQUIRE(radius.most);
      CHECK(*radius.half <= *radius.most);
    }
  TrainingConfig config = quiet_config();
  std::vector<Trajectory> few = recordings_of(read_ship("vectwin-3m"), 0.01);
  few.pop_back();
  const auto of_eight = cross_fit({few, config, BaseModel::read("vectwin-3m"), nullptr, 1, 2, nn::kernels(), {}, {}});
  REQUIRE(of_eight);
  CHECK(of_eight->radii.front().channels[0].half);
  CHECK_FALSE(of_eight->radii.front().channels[0].most);  // ceil(9 * 0.9) = 9 of eight
  few.resize(1);
  CHECK_THROWS_WITH(cross_fit({few, config, nullptr, nullptr, 1, 2, nn::kernels(), {}, {}}),
                    Contains("expected at least two, got 1"));
}

TEST_CASE("cross-fitting: the same numbers for any number of threads; it can be stopped", "[ensemble][calibration]") {
  const std::vector<Trajectory> recordings = recordings_of(read_ship("vectwin-3m"), 0.01);
  const TrainingConfig config = quiet_config();
  const auto base = BaseModel::read("vectwin-3m");
  int trained = 0;
  const auto one = cross_fit({recordings, config, base, nullptr, 1, 1, nn::kernels(), {}, [&] { ++trained; }});
  const auto two = cross_fit({recordings, config, base, nullptr, 1, 2, nn::kernels(), {}, {}});
  CHECK(trained == networks_of_cross_fit(config, recordings.size()));
  CHECK(one->disturbance == two->disturbance);
  CHECK(one->sensor_sd == two->sensor_sd);
  CHECK(one->radii == two->radii);
  CHECK_FALSE(cross_fit({recordings, config, base, nullptr, 1, 2, nn::kernels(), [] { return true; }, {}}));
}

TEST_CASE("calibration: what is written is read back, and a changed file is refused", "[ensemble][calibration]") {
  const TrainingConfig config = quiet_config();
  Calibration written = calibration_of(read_ship("vectwin-3m"), 0.01, config);
  written.radii.front().channels[3].most = std::nullopt;
  const EnsembleHeader header =
      make_header(prepare_training_data(recordings_of(read_ship("vectwin-3m"), 0.01), config), 1, {});
  const test::TemporaryFolder folder;
  const std::string path = folder.path().string();
  CHECK_FALSE(read_calibration(path, header));
  write_calibration(path, written, header, io::Json::object());
  const auto read = read_calibration(path, header);
  REQUIRE(read);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    REQUIRE(read->disturbance.axes[axis].size() == written.disturbance.axes[axis].size());
    for (std::size_t i = 0; i < read->disturbance.axes[axis].size(); ++i)
      CHECK_THAT(read->disturbance.axes[axis][i].sd, WithinRel(written.disturbance.axes[axis][i].sd, 1e-14));
  }
  CHECK_FALSE(read->radii.front().channels[3].most);
  EnsembleHeader other = header;
  other.training_id = "another";
  CHECK_THROWS_WITH(read_calibration(path, other), Contains("/training_id: is of another training"));
  std::string text = io::read_text(calibration_path(path));
  text.replace(text.find("\"folds\": 3"), 10, "\"folds\": 4");
  io::write_text(calibration_path(path), text);
  CHECK_THROWS_WITH(read_calibration(path, header), Contains("/sha256: is not that of the file's numbers"));
}
