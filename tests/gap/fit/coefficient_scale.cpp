#include "gap/fit/coefficient_scale.hpp"

#include <cmath>
#include <vector>

#include <catch2/catch.hpp>

#include "gap/policy/policy.hpp"

using namespace leeway;

namespace {

std::vector<gap::UncertainParameter> parameters(std::size_t coefficients, double sd) {
  std::vector<gap::UncertainParameter> result;
  for (std::size_t i = 0; i < coefficients; ++i) result.push_back({"hull." + std::to_string(i), sd});
  result.push_back(gap::timing_parameter());
  return result;
}

// Each coefficient independent of the others.
gap::ThetaPrior stated(const std::vector<gap::UncertainParameter>& parameters) {
  Eigen::VectorXd sd(static_cast<Eigen::Index>(parameters.size()));
  for (std::size_t i = 0; i < parameters.size(); ++i) sd[static_cast<Eigen::Index>(i)] = parameters[i].sd;
  return gap::ThetaPrior(sd);
}

// What recordings say that know each coefficient to `sd`, and have it at `off`.
gap::Evidence known(const Eigen::VectorXd& off, double sd) {
  gap::Evidence evidence(off.size());
  evidence.F.diagonal().setConstant(1.0 / (sd * sd));
  evidence.b = off / (sd * sd);
  return evidence;
}

}  // namespace

TEST_CASE("common scale: the evidence is that of all scales and of all that may be off by far more", "[gap]") {
  const std::vector<gap::UncertainParameter> all = parameters(3, 0.1);
  const bool go_together = GENERATE(false, true);
  leeway::CoefficientLaw law;
  law.covariance.resize(3, 3);
  law.covariance << 0.010, 0.007, -0.002, 0.007, 0.010, 0.0, -0.002, 0.0, 0.010;
  const gap::ThetaPrior before = go_together ? gap::ThetaPrior(law, all.back().sd) : stated(all);
  gap::Evidence evidence(4);
  Eigen::MatrixXd root(4, 4);
  root << 9.0, 2.0, -1.0, 0.5, 0.0, 12.0, 3.0, 1.0, 0.0, 0.0, 4.0, -2.0, 0.0, 0.0, 0.0, 1.0;
  evidence.F = root * root.transpose();
  evidence.b << 20.0, -35.0, 6.0, 0.3;
  evidence.log_likelihood = -12.0;
  const Eigen::VectorXd theta = (Eigen::VectorXd(4) << 0.05, -0.02, 0.0, 0.1).finished();
  const std::vector<gap::PriorWidths> widths = gap::widths_by_scale(before, all, 0);
  double sum = 0.0;
  for (const gap::PriorWidths& one : widths) {
    double here = std::exp(gap::marginal(evidence, theta, one.prior));
    for (Eigen::Index i = 0; i < 3; ++i) {
      gap::ThetaPrior wide = one.prior;
      wide.widen(i, gap::kPolicy.fit.slab_log_sd);
      if (wide.sd()[i] > one.prior.sd()[i])
        here += gap::kPolicy.fit.slab_odds / 3.0 * std::exp(gap::marginal(evidence, theta, wide));
    }
    // Two of them are as good as excluded here.
    sum += std::exp(one.log_weight) * here / std::pow(1.0 + gap::kPolicy.fit.slab_odds / 3.0, 3.0);
  }
  CHECK(gap::file_evidence(evidence, theta, widths).log_evidence == Approx(std::log(sum)).epsilon(1e-9));
}

TEST_CASE("common scale: coordinates beside theta make the evidence that they make within theta", "[gap]") {
  const std::vector<gap::UncertainParameter> all = parameters(3, 0.1);
  leeway::CoefficientLaw law;
  law.covariance.resize(3, 3);
  law.covariance << 0.010, 0.007, -0.002, 0.007, 0.010, 0.0, -0.002, 0.0, 0.010;
  const std::vector<gap::PriorWidths> widths = gap::widths_by_scale(gap::ThetaPrior(law, all.back().sd), all, 0);
  gap::Evidence within(6);  // three coefficients, two coordinates, the timing
  Eigen::MatrixXd root(6, 6);
  root << 9.0, 2.0, -1.0, 0.5, 1.0, 0.3, 0.0, 12.0, 3.0, 1.0, -2.0, 0.1, 0.0, 0.0, 14.0, -2.0, 0.5, 0.4, 0.0, 0.0, 0.0,
      6.0, 2.5, -1.0, 0.0, 0.0, 0.0, 0.0, 3.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0;
  within.F = root * root.transpose();
  within.log_likelihood = -12.0;
  const bool one_is_far_off = GENERATE(false, true);
  const Eigen::VectorXd truth =
      (Eigen::VectorXd(6) << 0.05, one_is_far_off ? -1.2 : -0.1, 0.02, 0.7, -0.4, 0.1).finished();
  within.b = within.F * truth;
  const Eigen::VectorXd theta = (Eigen::VectorXd(6) << 0.05, -0.02, 0.0, 0.3, -0.2, 0.1).finished();
  const gap::FileEvidence expected = gap::file_evidence(within, theta, gap::with_coordinates(widths, 3, 2));

  const std::vector<Eigen::Index> own{0, 1, 2, 5}, more{3, 4};
  const gap::FileEvidence beside = gap::FileEvidenceBeside(within.F(own, own), theta(own), widths)
                                       .with(within.log_likelihood, within.b(own),
                                             {theta(more), within.b(more), within.F(own, more), within.F(more, more)});
  CHECK(beside.log_evidence == Approx(expected.log_evidence).epsilon(1e-9));
  CHECK(beside.likeliest.scale == expected.likeliest.scale);
  for (Eigen::Index i = 0; i < 3; ++i) CHECK(beside.off[i] == Approx(expected.off[i]).epsilon(1e-6).margin(1e-12));
  CHECK((expected.off.maxCoeff() > 0.5) == one_is_far_off);
}

TEST_CASE("common scale: a file that is wrong throughout is a worse file, one coefficient alone is off", "[gap]") {
  constexpr Eigen::Index kCoefficients = 20;
  const std::vector<gap::UncertainParameter> all = parameters(kCoefficients, 0.1);
  const std::vector<gap::PriorWidths> widths = gap::widths_by_scale(stated(all), all, 0);
  const Eigen::VectorXd there = Eigen::VectorXd::Zero(kCoefficients + 1);
  Eigen::VectorXd off = there;
  for (Eigen::Index i = 0; i < kCoefficients; ++i) off[i] = i % 2 == 0 ? 0.25 : -0.25;  // 2.5 sd, all of them
  const gap::FileEvidence worse = gap::file_evidence(known(off, 0.01), there, widths);
  CHECK(worse.likeliest.scale > 1.9);
  CHECK(worse.off.maxCoeff() < 0.1);
  off *= 0.2;  // as stated
  off[3] = 0.8;
  const gap::FileEvidence one = gap::file_evidence(known(off, 0.01), there, widths);
  CHECK(one.likeliest.scale < 1.2);
  CHECK(one.off[3] > 0.99);
  CHECK(one.likeliest.prior.sd()[3] > 0.5);
  CHECK(one.off.sum() - one.off[3] < 0.1);
}

TEST_CASE("common scale: two coefficients that are off by far more are both so, and the file is no worse for it",
          "[gap]") {
  constexpr Eigen::Index kCoefficients = 20;
  const std::vector<gap::UncertainParameter> all = parameters(kCoefficients, 0.1);
  const std::vector<gap::PriorWidths> widths = gap::widths_by_scale(stated(all), all, 0);
  const Eigen::VectorXd there = Eigen::VectorXd::Zero(kCoefficients + 1);
  Eigen::VectorXd off = there;
  for (Eigen::Index i = 0; i < kCoefficients; ++i) off[i] = i % 2 == 0 ? 0.05 : -0.05;
  off[3] = 0.6;
  off[8] = -0.7;
  const gap::FileEvidence both = gap::file_evidence(known(off, 0.01), there, widths);
  CHECK(both.likeliest.scale < 1.2);
  CHECK(both.off[3] > 0.99);
  CHECK(both.off[8] > 0.99);
  CHECK(both.off.sum() < 2.1);
  // A pair in the place of one is what two priors at these values make it: the sums of both orders agree.
  Eigen::VectorXd swapped = off;
  std::swap(swapped[3], swapped[8]);
  CHECK(gap::file_evidence(known(swapped, 0.01), there, widths).log_evidence ==
        Approx(both.log_evidence).epsilon(1e-9));
  // Where recordings know the sum of two alone, one of them is off and not both.
  off[3] = off[8] = 0.0;
  gap::Evidence sum_alone = known(off, 0.01);
  sum_alone.F(3, 8) = sum_alone.F(8, 3) = sum_alone.F(3, 3);
  sum_alone.b[3] = sum_alone.b[8] = 0.8 * sum_alone.F(3, 3);
  const gap::FileEvidence either = gap::file_evidence(sum_alone, there, widths);
  CHECK(either.off[3] + either.off[8] == Approx(1.0).margin(0.2));
}
