#include "gap/filter/state_space.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include <Eigen/Eigenvalues>
#include <catch2/catch.hpp>

#include "gap/simulated_campaign.hpp"

using namespace leeway;

TEST_CASE("filter: a ship that does not keep her course leaves covariances what they are", "[gap]") {
  // Little model error, so that the filter believes a ship that runs away from what is measured.
  Ship unstable = read_ship("esso-osaka-3m");
  unstable.multiply({{"hull.N_v", 4.0}, {"hull.N_r", 0.2}});
  const std::vector<Trajectory> recordings = test::recorded(
      {.ship = "esso-osaka-3m", .recordings = 1, .duration_s = 600.0, .wind_mps = 0.0}, read_ship("esso-osaka-3m"));
  const gap::Campaign campaign = gap::prepare(unstable, recordings, {});
  REQUIRE(campaign.stretches.size() == 1);
  const auto stretch = std::make_shared<const gap::Stretch>(campaign.stretches.front());
  const auto coefficients = static_cast<Eigen::Index>(gap::uncertain_parameters(unstable).size());
  const gap::LinearStretch linear =
      gap::linearize(unstable, stretch, gap::measured_path(*stretch), Eigen::VectorXd::Zero(coefficients));
  gap::Noise noise;
  noise.sigma_w = {5e-5, 5e-5, 5e-5};
  noise.tau_s = 10.0;
  noise.wind_tau_s = 15.0;
  noise.measurement_sd << 0.03, 0.03, 0.002, 0.01, 0.01, 0.002;

  gap::Filter filter(linear, noise, 0);
  double fastest = 0.0;
  for (std::size_t k = 0; k < linear.path.size(); ++k) {
    if (k > 0) {
      filter.predict(k - 1);
      const Eigen::Matrix<double, 6, 6> ship = filter.covariance.topLeftCorner<6, 6>();
      REQUIRE(ship == ship.transpose());
      const Eigen::Matrix<double, 6, 6> A = filter.transition(k - 1).topLeftCorner<6, 6>();
      fastest = std::max(fastest, A.eigenvalues().cwiseAbs().maxCoeff());
    }
    filter.update(k, [](int, double z, const auto&, double S) {
      REQUIRE(S > 0.0);
      REQUIRE(std::isfinite(z));
    });
  }
  CHECK(fastest > 1.1);  // a step of the grid
  CHECK(std::isfinite(gap::evidence(linear, noise).log_likelihood));
}
