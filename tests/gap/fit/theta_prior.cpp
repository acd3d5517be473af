#include "gap/fit/theta_prior.hpp"

#include <cmath>

#include <catch2/catch.hpp>

#include "core/linear_algebra.hpp"

using namespace leeway;

namespace {

CoefficientLaw law_of(const Eigen::MatrixXd& covariance) {
  CoefficientLaw law;
  law.covariance = covariance;
  return law;
}

// ln of the normal density by the covariance itself, but for (2 pi)^(-n/2).
double log_density(const Eigen::MatrixXd& covariance, const Eigen::VectorXd& theta) {
  return -0.5 * theta.dot(covariance.llt().solve(theta)) - 0.5 * std::log(covariance.determinant());
}

}  // namespace

TEST_CASE("prior of theta: what is done to it is done to the covariance", "[gap]") {
  Eigen::Matrix3d coefficients;
  coefficients << 0.04, 0.03, 0.0, 0.03, 0.09, -0.01, 0.0, -0.01, 0.01;
  const gap::ThetaPrior prior(law_of(coefficients), 0.2);
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(4, 4);
  covariance.topLeftCorner<3, 3>() = coefficients;
  covariance(3, 3) = 0.04;
  const Eigen::Vector4d theta(0.1, -0.2, 0.05, 0.3);
  CHECK(prior.log_density(theta) == Approx(log_density(covariance, theta)).epsilon(1e-4));
  CHECK(prior.sd()[1] == Approx(0.3).epsilon(1e-5));

  SECTION("coefficients twice as uncertain") {
    covariance.topLeftCorner<3, 3>() *= 4.0;
    CHECK(prior.scaled(3, 2.0).log_density(theta) == Approx(log_density(covariance, theta)).epsilon(1e-4));
  }
  SECTION("one of them more uncertain by itself") {
    gap::ThetaPrior wide = prior;
    wide.widen(1, 0.6);
    covariance(1, 1) = 0.36;
    CHECK(wide.log_density(theta) == Approx(log_density(covariance, theta)).epsilon(1e-4));
    wide.widen(1, 0.5);  // less than it is
    CHECK(wide.log_density(theta) == Approx(log_density(covariance, theta)).epsilon(1e-4));
  }
  SECTION("one of them known tells of the others") {
    gap::ThetaPrior known = prior;
    known.hold(0, 1e-3);
    const Eigen::MatrixXd precision = known.precision();
    const double variance = precision.inverse()(1, 1);
    CHECK(variance == Approx(0.09 - 0.03 * 0.03 / 0.04).epsilon(1e-3));
    CHECK(known.sd()[1] == Approx(std::sqrt(variance)));
    known.hold(1, 1e-3);
    CHECK(known.log_determinant() == Approx(-std::log(known.precision().determinant())));
  }
  SECTION("coordinates come and go") {
    const gap::ThetaPrior with = prior.with(3, Eigen::Vector2d(1.0, 2.0));
    Eigen::VectorXd longer(6);
    longer << theta.head<3>(), 0.5, -3.0, theta[3];
    CHECK(with.log_density(longer) - prior.log_density(theta) == Approx(-0.5 * 0.25 - 0.5 * 9.0 / 4.0 - std::log(2.0)));
    CHECK(with.without(3, 2).precision().isApprox(prior.precision()));
    CHECK(with.without(3, 2).log_determinant() == Approx(prior.log_determinant()));
  }
}

TEST_CASE("prior of theta: a coefficient that follows from another one can be stated", "[gap]") {
  const gap::ThetaPrior prior(law_of(Eigen::Matrix2d::Constant(0.01)), 0.2);
  CHECK(prior.log_density(Eigen::Vector3d(0.1, 0.1, 0.0)) - prior.log_density(Eigen::Vector3d(0.1, 0.09, 0.0)) > 100.0);
  CHECK(std::isfinite(prior.log_determinant()));
}
