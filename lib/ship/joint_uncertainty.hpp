#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "ship/ship.hpp"

namespace leeway {

/// The same with standard deviations that a ship's file may state: smaller ones are raised to the least.
inline Ship::JointUncertainty statable(Ship::JointUncertainty joint, const Ship& ship) {
  for (std::size_t i = 0; i < joint.names.size(); ++i) {
    const double least = ship.is_absolute(joint.names[i]) ? kAbsoluteSdRange.low : kLogSdRange.low;
    double& variance = joint.matrix(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i));
    variance = std::max(variance, least * least);
  }
  return joint;
}

/// A ship's `coefficient_covariance`.
///   source  of the numbers
inline io::Json to_json(const Ship::JointUncertainty& joint, const std::string& source) {
  io::Json matrix = io::Json::array();
  for (const auto& row : joint.matrix.rowwise()) matrix.push_back(std::vector<double>(row.begin(), row.end()));
  return {{"source", source}, {"names", joint.names}, {"matrix", matrix}};
}

}  // namespace leeway
