#include "gap/compare/current_course.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

#include <fmt/format.h>

#include "core/linear_algebra.hpp"
#include "core/units.hpp"
#include "effects/varying_current.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {
namespace {

using CurrentEffect = VaryingCurrent<double>;
using Course = Eigen::Matrix<double, CurrentEffect::kCosines, 1>;
using CourseCovariance = Eigen::Matrix<double, CurrentEffect::kCosines, CurrentEffect::kCosines>;

constexpr int kQuadrature = static_cast<int>(kPolicy.compare.quadrature),
              kGrid = static_cast<int>(kPolicy.compare.grid);

Prior prior_of(std::size_t parameter, const Ship& ship) {
  return CurrentEffect::parameters[parameter].prior(ship.particulars.L_pp);
}

// Covariance of the cosines of one component of an Ornstein-Uhlenbeck process with variance 1 over a course.
//   tau  time constant by the course's length
CourseCovariance of_process(double tau) {
  Eigen::Matrix<double, CurrentEffect::kCosines, kQuadrature> project;
  for (Eigen::Index k = 0; k < project.rows(); ++k)
    for (int i = 0; i < kQuadrature; ++i)
      project(k, i) =
          (k == 0 ? 1.0 : 2.0) / kQuadrature * std::cos(kPi * static_cast<double>(k) * (i + 0.5) / kQuadrature);
  Eigen::Matrix<double, kQuadrature, kQuadrature> process;
  for (int i = 0; i < kQuadrature; ++i)
    for (int j = 0; j < kQuadrature; ++j) process(i, j) = std::exp(-std::abs(i - j) / (kQuadrature * tau));
  return project * process * project.transpose();
}

std::string name_of(std::size_t parameter) { return std::string(CurrentEffect::parameters[parameter].name); }
std::string cosine_name(std::size_t axis, std::size_t k) { return name_of(CurrentEffect::kCourse + 2 * k + axis); }

// Median, standard deviation and 95 % interval of values with weights, in equal steps of the logarithm.
FreeEffect::Parameter summed_up(const std::string& name, const std::vector<double>& values,
                                const std::vector<double>& weights) {
  const double all = std::accumulate(weights.begin(), weights.end(), 0.0);
  const auto quantile = [&](double share) {
    double before = 0.0;
    std::size_t i = 0;
    while (i + 1 < values.size() && before + weights[i] / all < share) before += weights[i++] / all;
    return values[i] * std::pow(values[1] / values[0], (share - before) * all / weights[i] - 0.5);
  };
  double mean = 0.0, square = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i)
    mean += weights[i] / all * values[i], square += weights[i] / all * values[i] * values[i];
  return {name, quantile(0.5), std::sqrt(std::max(0.0, square - mean * mean)), quantile(kPolicy.show.tail95),
          quantile(1.0 - kPolicy.show.tail95)};
}

// Coordinates are cosines by these.
Course units_of(const FreeEffect& course) {
  const std::vector<double> at_one = course.values(Eigen::VectorXd::Ones(course.size()));
  Course units;
  for (std::size_t k = 0; k < CurrentEffect::kCosines; ++k)
    units[static_cast<Eigen::Index>(k)] = at_one[CurrentEffect::kCourse + 2 * k];
  return units;
}

double length_s(const FreeEffect& course) {
  return course.values(Eigen::VectorXd::Zero(course.size()))[CurrentEffect::kLength];
}

}  // namespace

FreeEffect::Choice current_course(const Campaign& campaign) {
  double begin_s = campaign.stretches.front().t_s.front(), end_s = begin_s;
  for (const Stretch& stretch : campaign.stretches) {
    begin_s = std::min(begin_s, stretch.t_s.front());
    end_s = std::max(end_s, stretch.t_s.back());
  }
  const double tau_s = prior_of(CurrentEffect::kTau, campaign.ship).median;
  FreeEffect::Choice choice;
  const double course_s = std::max(end_s - begin_s, 1.0);
  choice.fixed = {{name_of(CurrentEffect::kSd), 0.0},
                  {name_of(CurrentEffect::kTau), tau_s},
                  {name_of(CurrentEffect::kSeed), 1.0},
                  {name_of(CurrentEffect::kStart), begin_s},
                  {name_of(CurrentEffect::kLength), course_s}};
  const CourseCovariance covariance = of_process(tau_s / course_s);
  for (std::size_t k = 0; k < CurrentEffect::kCosines; ++k) {
    const auto place = static_cast<Eigen::Index>(k);
    const double sd = prior_of(CurrentEffect::kSd, campaign.ship).sd * std::sqrt(covariance(place, place));
    for (const std::size_t axis : {0, 1})
      choice.priors[cosine_name(axis, k)] =
          normal(0.0, sd, -kPolicy.compare.widest_sd * sd, kPolicy.compare.widest_sd * sd);
  }
  return choice;
}

std::vector<CurrentPath> current_paths(const Campaign& campaign, const Hypothesis& hypothesis,
                                       const Eigen::VectorXd& mean, const Eigen::MatrixXd& covariance) {
  std::vector<CurrentPath> paths;
  Eigen::Index at = 0;
  for (const FreeEffect& effect : hypothesis.effects) {
    const Eigen::Index first = at, size = effect.size();
    at += size;
    if (search_start(effect.name()) != SearchStart::course) continue;
    const Course units = units_of(effect);
    const std::vector<double> values = effect.values(mean.segment(first, size));
    for (std::size_t r = 0; r < campaign.recordings.size(); ++r) {
      if (effect.recording().value_or(r) != r) continue;
      CurrentPath path{campaign.recordings[r].name, campaign.recordings[r][Channel::t], {}, {}};
      for (const double t : path.t_s) {
        const double share = std::clamp((t - values[CurrentEffect::kStart]) / values[CurrentEffect::kLength], 0.0, 1.0);
        Vec2<double> velocity, sd;
        for (Eigen::Index axis = 0; axis < 2; ++axis) {
          Eigen::VectorXd slope = Eigen::VectorXd::Zero(size);
          for (Eigen::Index k = 0; k < units.size(); ++k)
            slope[2 * k + axis] = units[k] * std::cos(kPi * static_cast<double>(k) * share);
          velocity[axis] = slope.dot(mean.segment(first, size));
          sd[axis] = std::sqrt(std::max(0.0, slope.dot(covariance.block(first, first, size, size) * slope)));
        }
        path.velocity_mps.push_back(velocity);
        path.sd_mps.push_back(sd);
      }
      paths.push_back(std::move(path));
    }
  }
  return paths;
}

std::string path_text(const CurrentPath& path) {
  std::string text = "t_s,current_north_mps,current_east_mps,current_north_sd_mps,current_east_sd_mps\n";
  for (std::size_t i = 0; i < path.t_s.size(); ++i)
    fmt::format_to(std::back_inserter(text), "{},{:.6g},{:.6g},{:.3g},{:.3g}\n", path.t_s[i], path.velocity_mps[i](0),
                   path.velocity_mps[i](1), path.sd_mps[i](0), path.sd_mps[i](1));
  return text;
}

std::vector<FreeEffect::Parameter> current_process(const Ship& ship, const std::vector<FreeEffect>& courses,
                                                   const Eigen::VectorXd& mean, const Eigen::MatrixXd& covariance) {
  const Prior sd_prior = prior_of(CurrentEffect::kSd, ship), tau_prior = prior_of(CurrentEffect::kTau, ship);
  std::vector<double> sds, taus;
  for (int i = 0; i < kGrid; ++i) {
    const double share = (i + 0.5) / kGrid;
    sds.push_back(sd_prior.high * std::pow(kPolicy.compare.least_current_sd, 1.0 - share));
    taus.push_back(tau_prior.low * std::pow(tau_prior.high / tau_prior.low, share));
  }
  std::vector<double> log_weights;
  for (const double tau_s : taus) {
    const CourseCovariance process =
        courses.empty() ? CourseCovariance() : of_process(tau_s / length_s(courses.front()));
    for (const double sd : sds) {
      // Before: Rayleigh, of a logarithmic grid, and log-normal.
      double log_weight = courses.empty() ? 2.0 * std::log(sd) - 0.5 * std::pow(sd / sd_prior.sd, 2) -
                                                0.5 * std::pow(std::log(tau_s / tau_prior.median) / tau_prior.sd, 2)
                                          : 0.0;
      Eigen::Index first = 0;
      for (const FreeEffect& course : courses) {
        const Course units = units_of(course);
        for (Eigen::Index axis = 0; axis < 2; ++axis) {
          Course c;
          CourseCovariance of_c = sd * sd * process;
          for (Eigen::Index j = 0; j < units.size(); ++j) {
            c[j] = units[j] * mean[first + 2 * j + axis];
            for (Eigen::Index k = 0; k < units.size(); ++k)
              of_c(j, k) += units[j] * units[k] * covariance(first + 2 * j + axis, first + 2 * k + axis);
          }
          const Eigen::LLT<CourseCovariance> root(of_c);
          log_weight -= 0.5 * c.dot(root.solve(c)) + CourseCovariance(root.matrixL()).diagonal().array().log().sum();
        }
        first += course.size();
      }
      log_weights.push_back(log_weight);
    }
  }
  const double most = *std::max_element(log_weights.begin(), log_weights.end());
  std::vector<double> of_sd(sds.size(), 0.0), of_tau(taus.size(), 0.0);
  for (std::size_t t = 0; t < taus.size(); ++t)
    for (std::size_t s = 0; s < sds.size(); ++s) {
      const double weight = std::exp(log_weights[t * sds.size() + s] - most);
      of_sd[s] += weight;
      of_tau[t] += weight;
    }
  return {summed_up(name_of(CurrentEffect::kSd), sds, of_sd), summed_up(name_of(CurrentEffect::kTau), taus, of_tau)};
}

}  // namespace leeway::gap
