#include "ensemble/base_spread.hpp"

#include <cmath>
#include <filesystem>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "dynamics/ship_draws.hpp"
#include "ensemble/ensemble_training.hpp"
#include "ensemble/prediction.hpp"
#include "ensemble/simulated.hpp"
#include "io/files.hpp"
#include "temporary_folder.hpp"

using namespace leeway;
using namespace leeway::ensemble;
using Catch::Matchers::Contains;

namespace {

TrainingConfig drawn_config() {
  TrainingConfig config;
  config.steps = 12;
  config.initial_state_steps = 4;
  config.hidden_layers = 2;
  config.hidden_units = 7;
  config.batch_size = 4;
  config.members = 3;
  config.epochs = 2;
  return config;
}

std::vector<Trajectory> recordings_of(const Ship& ship) {
  return {test::simulated_recording(ship, 1, 400, 0.01), test::simulated_recording(ship, 2, 400, 0.01)};
}

}  // namespace

TEST_CASE("base spread: how wrong a ship is shows in recordings, and a right one as well", "[ensemble][base][long]") {
  const std::shared_ptr<const BaseModel> stated = BaseModel::read("vectwin-3m");
  const auto inferred = [&](const Ship& truth) {
    const std::vector<Trajectory> recordings = recordings_of(truth);
    return infer_base_spread(prepare_training_data(recordings, drawn_config(), stated), recordings);
  };
  CHECK(inferred(stated->ship()).high < 0.3);
  // Forty coefficients tell the scale of a draw to about 1/sqrt(80).
  for (const double spread : {0.7, 1.5})
    for (int number = 0; number < 3; ++number) {
      const BaseSpreadEstimate found = inferred(ShipDraws(stated->ship(), spread, 5).draw(number).ship);
      CAPTURE(spread, number, found.low, found.spread, found.high);
      CHECK(found.spread > 0.6 * spread);
      CHECK(found.spread < 1.6 * spread);
      CHECK(found.low < found.spread);
      CHECK(found.spread < found.high);
    }
}

TEST_CASE("base spread: members learn on ships of their own, to the same bytes whatever the order",
          "[ensemble][base]") {
  const std::shared_ptr<const BaseModel> base = BaseModel::read("vectwin-3m");
  TrainingData data =
      prepare_training_data({test::simulated_recording(base->ship(), 1, 60, 0.01)}, drawn_config(), base);
  const std::string shared_id = make_header(data, 1, {}).training_id;
  data.base_spread = 1.2;
  const EnsembleHeader header = make_header(data, 1, {});
  CHECK(header.training_id != shared_id);
  const test::TemporaryFolder one, two, resumed;
  const auto train_all = [&](const test::TemporaryFolder& folder, std::vector<int> members, bool resume = false) {
    train_ensemble(data, header, {folder.path().string(), std::move(members), resume, 0.0, 2}, nn::kernels(),
                   {[](int, const MemberProgress&) {}, [](const std::string&) {}});
  };
  train_all(one, {0, 1, 2});
  train_all(two, {2});
  train_all(two, {1});
  const TrainingData own = data_of_member(data, 1, 1);
  TrainingState state = initial_training_state(own, 1, 1, nn::kernels());
  CHECK_FALSE(train(own, 1, nn::kernels(), state, [&](const TrainingState& now) { return now.epochs_done < 1; }));
  write_checkpoint(resumed.path().string(), state, header);
  train_all(resumed, {1}, true);
  for (const char* file : {"member-01.json", "member-01.ship.json"}) {
    CHECK(io::read_text(two / file) == io::read_text(one / file));
    CHECK(io::read_text(resumed / file) == io::read_text(one / file));
  }

  const std::string folder = one.path().string();
  write_header(folder, header, io::Json::object(), base.get());
  CHECK(read_header(folder)->base == header.base);
  const Ensemble ensemble(folder, 0, nn::kernels());
  CHECK(ensemble.base()->ship().name == "vectwin-3m");
  CHECK(ensemble.base(1)->ship().name == "vectwin-3m-draw-01");
  const Ship drawn = ShipDraws(base->ship(), 1.2, 1, data.stretches[0].nu.row(0).maxCoeff()).draw(1).ship;
  CHECK(ensemble.base(1)->ship().coefficient_factors.front().factor == drawn.coefficient_factors.front().factor);
  // Without their networks' part members move as their ships do.
  EnsembleEvaluator evaluator(ensemble);
  const Samples& samples = data.stretches.front();
  const Eigen::Matrix3Xd eta = samples.eta.col(0), nu = samples.nu.col(0);
  for (int m = 0; m < 3; ++m) {
    Eigen::Matrix3Xd e = eta, v = nu;
    evaluator.step(m, Integrator::euler, 1.0, samples.actuators.col(0), samples.true_wind.col(0), e, v);
    const Eigen::Matrix3Xd network =
        evaluator.accelerations(m, eta, nu, samples.actuators.col(0), samples.true_wind.col(0));
    const Vec3<double> alone = ensemble.base(m)
                                   ->step({eta.col(0), nu.col(0)},
                                          ensemble.base(m)->inputs(samples, header.inputs.sampled_actuators(), 0), 1.0)
                                   .nu;
    CHECK((v.col(0) - network.col(0) - alone).norm() < 1e-12);
  }
  io::write_text(one / "member-01.ship.json", ensemble.base(1)->text() + " ");
  CHECK_THROWS_WITH(Ensemble(folder, 0, nn::kernels()), Contains("member-01.ship.json: is not the ship that member 1"));
  CHECK_NOTHROW(Ensemble(folder, 1, nn::kernels()));
  remove_training(folder);
  CHECK_FALSE(std::filesystem::exists(one / "member-02.ship.json"));
}

TEST_CASE("base fit: the truth lies within what the recordings leave open, though inputs jump between samples",
          "[ensemble][base][long]") {
  const std::shared_ptr<const BaseModel> truth = BaseModel::read("vectwin-3m");
  // They jump where a sample is: half a change behind the straight line, everywhere.
  const std::vector<Trajectory> recordings = recordings_of(truth->ship());
  const ShipDraws draws(truth->ship(), 1.0, 5);
  int refused = 0;
  const std::shared_ptr<const BaseModel> base = truth->drawn(draws, 0, refused);
  const BaseSpreadEstimate found =
      infer_base_spread(prepare_training_data(recordings, drawn_config(), base), recordings);
  double square = 0.0, before = 0.0;
  for (std::size_t i = 0; i < found.factors.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    const auto of_base =
        std::ranges::find(base->ship().coefficient_factors, found.factors[i].name, &CoefficientFactor::name);
    REQUIRE(of_base != base->ship().coefficient_factors.end());
    const double error = std::log(found.factors[i].factor * of_base->factor);
    square += error * error / found.covariance(k, k);
    before += std::pow(std::log(of_base->factor), 2.0) / found.covariance(k, k);
  }
  const auto n = static_cast<double>(found.factors.size());
  CAPTURE(square / n, before / n, found.spread);
  CHECK(square / n < 2.0);
  CHECK(before / n > 10.0);
}
