#include "gap/locate/residuals.hpp"

#include <algorithm>

#include "forces/inertia.hpp"
#include "gap/filter/reference_units.hpp"

namespace leeway::gap {

Mat3<double> inertia_matrix(const Ship& ship) {
  const Inertia<double> i(ship.inertia, ship.particulars);
  const double S = i.x_G * i.m;
  Mat3<double> M;
  M << i.m + i.m_x, 0, 0, 0, i.m + i.m_y, S, 0, S, i.I_z + i.x_G * S;
  return M;
}

std::vector<Residual> residuals(const Campaign& campaign, const FittedNull& fit) {
  const bool knows_inertia = campaign.knows_inertia();
  const Mat3<double> M = inertia_matrix(campaign.ship);
  std::vector<Residual> result(campaign.recordings.size());
  for (std::size_t i = 0; i < result.size(); ++i) {
    result[i].recording = campaign.recordings[i].name;
    result[i].file = campaign.recordings[i].file;
    result[i].has_position = campaign.recordings[i].has(Channel::x0) && campaign.recordings[i].has(Channel::y0);
  }
  for (std::size_t s = 0; s < fit.smoothed.size(); ++s) {
    const Stretch& stretch = campaign.stretches[s];
    Residual& residual = result[stretch.recording];
    for (std::size_t k = 0; k < stretch.size(); ++k) {
      const StateVector& x = fit.smoothed[s].state[k];
      const Mat3<double> P = fit.smoothed[s].covariance[k].block<3, 3>(kErrorStart, kErrorStart);
      residual.t_s.push_back(stretch.t_s[k]);
      residual.acceleration.push_back(x.segment<3>(kErrorStart));
      residual.acceleration_sd.push_back(P.diagonal().cwiseMax(0.0).cwiseSqrt());
      residual.eta.push_back(x.head<3>());
      residual.nu.push_back(x.segment<3>(3));
      residual.measured_nu.push_back(stretch.measured[k].tail<3>());
      if (!knows_inertia) continue;
      residual.force.push_back(M * x.segment<3>(kErrorStart));
      residual.force_sd.push_back((M * P * M.transpose()).diagonal().cwiseMax(0.0).cwiseSqrt());
    }
  }
  result.erase(std::remove_if(result.begin(), result.end(), [](const Residual& r) { return r.t_s.empty(); }),
               result.end());
  return result;
}

std::vector<Eigen::Matrix3Xd> smoothed_residual(const Campaign& campaign, const FittedNull& fit) {
  const Vec3<double> per_unit = reference_acceleration(campaign.ship).cwiseInverse();
  std::vector<Eigen::Matrix3Xd> result;
  for (const Smoothed& smoothed : fit.smoothed) {
    Eigen::Matrix3Xd w(3, static_cast<Eigen::Index>(smoothed.state.size()) - 1);
    for (Eigen::Index k = 0; k < w.cols(); ++k)
      w.col(k) = smoothed.state[static_cast<std::size_t>(k)].segment<3>(kErrorStart).cwiseProduct(per_unit);
    result.push_back(std::move(w));
  }
  return result;
}

}  // namespace leeway::gap
