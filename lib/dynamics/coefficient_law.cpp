#include "dynamics/coefficient_law.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/errors.hpp"
#include "core/linear_algebra.hpp"
#include "core/similar_words.hpp"

namespace leeway {
namespace {

// The place of a name that the ship's file has at `pointer`; -1 for the timing.
Eigen::Index place_of(const std::string& name, const CoefficientLaw& law, const Ship& ship,
                      const std::string& pointer) {
  const auto found =
      std::ranges::find_if(law.coefficients, [&](const UncertainCoefficient& c) { return c.name == name; });
  if (found != law.coefficients.end()) return found - law.coefficients.begin();
  if (name == kTiming) return -1;
  std::vector<std::string> known;
  for (const UncertainCoefficient& c : law.coefficients) known.push_back(c.name);
  known.emplace_back(kTiming);
  throw InputError(ship.file, 0, pointer,
                   fmt::format("'{}' is not an uncertain parameter of this ship{}; known: {}", name,
                               did_you_mean(name, known), fmt::join(known, ", ")));
}

// Whether two names are the same coefficient of two sides, or of two devices.
bool are_sides(std::string_view one, std::string_view other) {
  constexpr std::array<std::array<std::string_view, 3>, 3> kSides{
      {{"", "_port", "_starboard"}, {"", "_negative", "_positive"}, {"azimuth.", "_1", "_2"}}};
  const auto is_pair = [&](const auto& of) {
    const auto [module, first, second] = of;
    return one.starts_with(module) && one.ends_with(first) && other.ends_with(second) &&
           one.substr(0, one.size() - first.size()) == other.substr(0, other.size() - second.size());
  };
  return std::ranges::any_of(kSides, is_pair);
}

}  // namespace

CoefficientLaw coefficient_law(const Ship& ship) {
  CoefficientLaw law;
  const std::vector<Coefficient> known = Model<double>(ship).coefficients();
  for (const Coefficient& coefficient : known)
    law.coefficients.push_back(
        {coefficient.name, coefficient.log_sd, false, false, coefficient.value, coefficient.is_form});
  const auto state = [&](Eigen::Index i, double sd) -> UncertainCoefficient& {
    UncertainCoefficient& coefficient = law.coefficients[static_cast<std::size_t>(i)];
    coefficient.sd = sd;
    coefficient.is_stated = true;
    return coefficient;
  };
  for (const Ship::Uncertainty& given : ship.uncertainty) {
    const std::string pointer = "/uncertainty/" + given.name;
    const Eigen::Index i = place_of(given.name, law, ship, pointer);
    if (given.is_absolute && (i < 0 || !known[static_cast<std::size_t>(i)].can_move))
      throw InputError(ship.file, 0, pointer, "is no single number: state the standard deviation of its logarithm");
    if (i >= 0) state(i, given.sd).is_absolute = given.is_absolute;
  }

  const auto n = static_cast<Eigen::Index>(law.coefficients.size());
  law.covariance = Eigen::MatrixXd::Zero(n, n);
  std::vector<Eigen::Index> places;
  if (ship.coefficient_covariance) {
    const Ship::JointUncertainty& joint = *ship.coefficient_covariance;
    for (std::size_t k = 0; k < joint.names.size(); ++k) {
      const std::string pointer = fmt::format("/coefficient_covariance/names/{}", k);
      places.push_back(place_of(joint.names[k], law, ship, pointer));
      if (places.back() < 0) throw InputError(ship.file, 0, pointer, "is no coefficient; it can stand in /uncertainty");
      state(places.back(), std::sqrt(joint.matrix(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(k))));
    }
  }
  for (Eigen::Index i = 0; i < n; ++i) {
    const double sd = law.coefficients[static_cast<std::size_t>(i)].sd;
    law.covariance(i, i) = sd * sd;
  }
  const auto is_joint = [&](Eigen::Index i) { return std::ranges::find(places, i) != places.end(); };
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) {
      const UncertainCoefficient &one = law.coefficients[static_cast<std::size_t>(i)],
                                 &other = law.coefficients[static_cast<std::size_t>(j)];
      if (is_joint(i) || is_joint(j) || one.is_absolute != other.is_absolute || !are_sides(one.name, other.name))
        continue;
      law.covariance(i, j) = law.covariance(j, i) = kSidesCorrelation * one.sd * other.sd;
    }
  for (std::size_t i = 0; i < places.size(); ++i)
    for (std::size_t j = 0; j < places.size(); ++j)
      law.covariance(places[i], places[j]) =
          ship.coefficient_covariance->matrix(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
  return law;
}

CoefficientFactor changed(const UncertainCoefficient& coefficient, double theta) {
  if (coefficient.is_absolute) return {coefficient.name, 1.0, theta};
  return {coefficient.name, std::exp(theta)};
}

std::vector<CoefficientFactor> draw_factors(const CoefficientLaw& law, double spread, RandomStream& random) {
  Eigen::VectorXd z(static_cast<Eigen::Index>(law.coefficients.size()));
  for (double& x : z) x = random.normal();
  const Eigen::LDLT<Eigen::MatrixXd> factors(law.covariance);  // also of a covariance without full rank
  const Eigen::VectorXd theta =
      factors.transpositionsP().transpose() *
      Eigen::VectorXd(factors.matrixL() * (factors.vectorD().cwiseMax(0.0).cwiseSqrt().cwiseProduct(z)));
  std::vector<CoefficientFactor> drawn;
  for (std::size_t i = 0; i < law.coefficients.size(); ++i)
    drawn.push_back(changed(law.coefficients[i], spread * theta(static_cast<Eigen::Index>(i))));
  return drawn;
}

}  // namespace leeway
