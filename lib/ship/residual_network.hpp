#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "io/json.hpp"
#include "recording/trajectory.hpp"

namespace leeway {

/// Accelerations that no formula holds, learned from recordings: a feedforward network with tanh units and a linear
/// last layer, added to the equations of motion inside the domain that the recordings covered.
///   inputs   u, v_m [m/s], r [rad/s] over ground; actuators [rad, 1/s]; apparent wind x, y in ship axes [m/s]
///   outputs  (du/dt, dv_m/dt [m/s^2], dr/dt [rad/s^2]) at midship
struct ResidualNetwork {
  struct Input {
    std::string name;  ///< with its SI unit: "u_mps", "delta_rad", "app_wind_x_mps"
    double mean = 0.0, sd = 1.0;
    double low = 0.0, high = 0.0;  ///< what the recordings covered
  };
  struct Layer {
    Eigen::MatrixXd weights;  ///< outputs x inputs
    Eigen::VectorXd biases;
  };
  std::vector<Input> inputs;       ///< 3, then one by actuator, then 2 if it sees the wind
  std::vector<Channel> actuators;  ///< those among the inputs, in their order
  bool wind = false;               ///< whether the apparent wind is an input
  std::vector<Layer> layers;
  std::string source;
};

/// The value of the key "residual_network" in a ship's JSON. Throws InputError for a missing or impossible value, an
/// unknown input, numbers of rows or columns that do not fit.
ResidualNetwork residual_network_from(const io::JsonObject& json);
io::Json to_json(const ResidualNetwork& network);

}  // namespace leeway
