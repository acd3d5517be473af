#include "ship/residual_network.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

namespace leeway {
namespace {

std::vector<std::string> wind_inputs() { return {"app_wind_x_mps", "app_wind_y_mps"}; }

// Finds out which actuators and wind the inputs are.
void name_inputs(const io::JsonObject& json, ResidualNetwork& network) {
  const std::vector<std::string> velocities{"u_mps", "vm_mps", "r_radps"};
  std::vector<std::string> names, expected = velocities;
  for (const ResidualNetwork::Input& input : network.inputs) names.push_back(input.name);
  for (const std::string& name : names)
    for (const Channel channel : kActuatorChannels)
      if (name == si_name(channel)) {
        network.actuators.push_back(channel);
        expected.push_back(name);
      }
  if (!names.empty() && names.back() == wind_inputs().back()) {
    network.wind = true;
    for (const std::string& name : wind_inputs()) expected.push_back(name);
  }
  if (names != expected)
    json.fail("inputs",
              fmt::format("expected {}, then actuators, then {} or no wind; found {}", fmt::join(velocities, ", "),
                          fmt::join(wind_inputs(), ", "), fmt::join(names, ", ")));
}

}  // namespace

ResidualNetwork residual_network_from(const io::JsonObject& json) {
  ResidualNetwork network;
  network.source = json.text("source");
  for (const io::JsonObject& input : json.objects("inputs")) {
    network.inputs.push_back({input.text("name"), input.number("mean"), input.number("sd", io::kPositive),
                              input.number("low"), input.number("high")});
    const ResidualNetwork::Input& one = network.inputs.back();
    if (!(one.low < one.high))
      input.fail("high", fmt::format("expected more than low, {}, found {}", one.low, one.high));
    input.check_all_known();
  }
  name_inputs(json, network);
  std::size_t width = network.inputs.size();
  const std::vector<io::JsonObject> layers = json.objects("layers");
  if (layers.empty()) json.fail("layers", "expected at least one");
  for (const io::JsonObject& layer : layers) {
    const std::vector<double> biases = layer.numbers("biases");
    const std::size_t units = &layer == &layers.back() ? 3 : biases.size();
    if (biases.empty() || biases.size() != units)
      layer.fail("biases",
                 fmt::format("expected {}, found {}", units == 0 ? "some" : std::to_string(units), biases.size()));
    const std::vector<double> weights = layer.numbers("weights", units * width);  // row by row
    const auto rows = static_cast<Eigen::Index>(units), columns = static_cast<Eigen::Index>(width);
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    network.layers.push_back({Eigen::Map<const RowMajor>(weights.data(), rows, columns),
                              Eigen::Map<const Eigen::VectorXd>(biases.data(), rows)});
    layer.check_all_known();
    width = units;
  }
  json.check_all_known();
  return network;
}

io::Json to_json(const ResidualNetwork& network) {
  io::Json inputs = io::Json::array(), layers = io::Json::array();
  for (const ResidualNetwork::Input& input : network.inputs)
    inputs.push_back(
        {{"name", input.name}, {"mean", input.mean}, {"sd", input.sd}, {"low", input.low}, {"high", input.high}});
  for (const ResidualNetwork::Layer& layer : network.layers) {
    io::Json weights = io::Json::array();
    for (const auto row : layer.weights.rowwise())
      for (const double w : row) weights.push_back(w);
    layers.push_back({{"weights", weights}, {"biases", std::vector<double>(layer.biases.begin(), layer.biases.end())}});
  }
  return {{"source", network.source}, {"inputs", inputs}, {"layers", layers}};
}

}  // namespace leeway
