#include "ensemble/base_spread.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include <Eigen/Dense>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/errors.hpp"
#include "core/units.hpp"
#include "dynamics/replay.hpp"
#include "io/files.hpp"

namespace leeway::ensemble {
namespace {

constexpr Eigen::Index kMostPoints = 20'000;  // that are looked at; more tell S no better
// Of a coefficient's logarithm, to either side, for derivatives: chords, since forces switch here and there, and a jump
// within a smaller difference would pass for knowledge.
constexpr double kDifference = 0.01;
constexpr double kTypicalLogSd = 0.2;  // of a coefficient; what the difference of an absolute one is measured by
constexpr double kLongestPart = 0.9;   // of a step, in sqrt(L_pp / g): what Runge-Kutta follows to 1e-3
constexpr double kMostTheta = 1.0;     // of a coefficient's logarithm, where it is linearized
constexpr int kNoiseFits = 2;          // of linearizations that count in full, along with which noise is fitted
// The first steps take what is stated at its word and the recordings for less than they are, lest a linearization lead
// far astray: the filter's likelihood has other maxima.
constexpr int kStatedSteps = 5;
constexpr double kTemper = 0.25;  // share of the likelihood that counts, of one step by that of the next
constexpr int kMostLinearizations = 20;
constexpr int kMostHalvings = 7;         // of a step that is too far
constexpr double kThetaConverged = 0.1;  // change of a coefficient in posterior standard deviations
constexpr double kPriorOfLogS = 1.0;     // its standard deviation

using Columns = Eigen::Matrix<double, 3, Eigen::Dynamic>;

// A stretch with inputs that are linear between samples, and derivatives of its steps' ends.
struct Track {
  Samples samples;
  std::vector<std::vector<StepInputs<double>>> inputs;  // of the parts of each step, straight from sample to sample
  Eigen::Index steps;
  Eigen::Matrix3Xd path;  // velocities that it is linearized at: recorded at first, then filtered
  std::vector<Columns> by_theta;
  std::vector<Eigen::Matrix3d> by_state;
};

// What the filter's innovations say: -2 log likelihood is rest + theta' A theta - 2 b' theta.
struct Likelihood {
  Eigen::MatrixXd A;
  Eigen::VectorXd b;
  double rest = 0.0;
  double here = 0.0;  // -2 log likelihood at theta_ itself
};

class SpreadFit {
 public:
  SpreadFit(const TrainingData& data, const std::vector<Trajectory>& recordings, std::optional<double> spread)
      : data_(data), dt_s_(data.config.time_step_s) {
    constexpr int kGrid = 121;  // ln S from -3 to 3
    if (spread)
      log_S_ = {std::log(*spread)};
    else
      for (int i = 0; i < kGrid; ++i) log_S_.push_back(-3.0 + 6.0 * i / (kGrid - 1));
    const CoefficientLaw law = coefficient_law(data.base->ship());
    coefficients_ = law.coefficients;
    const Eigen::LDLT<Eigen::MatrixXd> factors(law.covariance);
    root_ = factors.transpositionsP().transpose() * Eigen::MatrixXd(factors.matrixL());
    root_ = (root_ * factors.vectorD().cwiseMax(0.0).cwiseSqrt().asDiagonal()).eval();
    whitened_.compute(root_);
    theta_ = Eigen::VectorXd::Zero(law.covariance.rows());
    most_theta_ = Eigen::VectorXd::Constant(theta_.size(), kMostTheta);
    for (Eigen::Index i = 0; i < theta_.size(); ++i)
      if (const auto& c = coefficients_[static_cast<std::size_t>(i)]; c.is_absolute)
        most_theta_(i) = kMostTheta * c.sd / kTypicalLogSd;
    const double L_pp = data.base->ship().particulars.L_pp;
    parts_ = static_cast<int>(std::ceil(dt_s_ / (kLongestPart * std::sqrt(L_pp / kGravity_mps2))));
    const double part_s = dt_s_ / parts_;
    Eigen::Index points = 0;
    for (const Trajectory& recording : recordings) {
      const RecordedInputs inputs(recording, data.base->ship(), InputInterpolation::linear);
      for (const Samples& samples : data.stretches) {
        if (samples.file != recording.file || points >= kMostPoints) continue;
        const Eigen::Index size = std::min(samples.size(), kMostPoints - points);
        points += size;
        Track track{samples, {}, size - 1, samples.nu, {}, {}};
        for (Eigen::Index k = 0; k < track.steps; ++k) {
          track.inputs.emplace_back();
          for (int part = 0; part < parts_; ++part)
            track.inputs.back().push_back(inputs.step(samples.t_s(k) + part * part_s, part_s));
        }
        tracks_.push_back(std::move(track));
      }
    }
    // Noise at first as large as all that the base ship leaves over.
    for (int i = 0; i < 3; ++i)
      log_noise_(i) = std::log(data.inputs.accelerations[static_cast<std::size_t>(i)].sd * std::sqrt(dt_s_));
  }

  BaseSpreadEstimate run() {
    Posterior last;
    for (int round = 0; round < kMostLinearizations; ++round) {
      linearize();
      if (round == 0 || (round >= kStatedSteps && round < kStatedSteps + kNoiseFits)) fit_noise();
      last = posterior(round < kStatedSteps ? std::pow(kTemper, kStatedSteps - round) : 1.0);
      const Eigen::VectorXd before = theta_;
      step_towards(last, round >= kStatedSteps);
      const Eigen::VectorXd sd = last.covariance.diagonal().cwiseMax(1e-12).cwiseSqrt();
      if (round >= kStatedSteps + kNoiseFits &&
          ((theta_ - before).array() / sd.array()).abs().maxCoeff() < kThetaConverged)
        break;
    }
    BaseSpreadEstimate estimate;
    estimate.covariance = last.covariance;
    const std::vector<double> weights = posterior_of_log_S(likelihood(log_noise_));
    estimate.low = quantile(weights, 0.05);
    estimate.spread = quantile(weights, 0.5);
    estimate.high = quantile(weights, 0.95);
    estimate.acceleration_noise = log_noise_.array().exp();
    for (std::size_t i = 0; i < coefficients_.size(); ++i)
      estimate.factors.push_back(changed(coefficients_[i], theta_(static_cast<Eigen::Index>(i))));
    return estimate;
  }

 private:
  Model<double> model_at(const Eigen::VectorXd& theta) const {
    Model<double> model = data_.base->model();
    model.change_coefficients(std::span<const double>(theta.data(), static_cast<std::size_t>(theta.size())));
    return model;
  }

  // The velocity at the end of a step from what is recorded of the heading.
  Vec3<double> step(const Model<double>& model, const Track& track, Eigen::Index k, const Vec3<double>& nu) const {
    ShipState<double> state;
    state.eta(2) = track.samples.eta(2, k);
    state.nu = nu;
    for (const StepInputs<double>& part : track.inputs[static_cast<std::size_t>(k)])
      state = integrate(model, state, part, dt_s_ / parts_);
    return state.nu;
  }

  // To either side of theta_, for derivatives: of an absolute uncertainty a share of it.
  double difference(Eigen::Index i) const {
    const UncertainCoefficient& c = coefficients_[static_cast<std::size_t>(i)];
    return c.is_absolute ? kDifference * c.sd / kTypicalLogSd : kDifference;
  }

  // The model at theta_, and derivatives along the recorded states.
  void linearize() {
    model_ = model_at(theta_);
    const Eigen::Index n = theta_.size();
    std::vector<Model<double>> moved;
    for (Eigen::Index i = 0; i < n; ++i)
      for (const double side : {1.0, -1.0})
        moved.push_back(model_at(theta_ + side * difference(i) * Eigen::VectorXd::Unit(n, i)));
    for (Track& track : tracks_) {
      track.by_theta.clear();
      track.by_state.clear();
      for (Eigen::Index k = 0; k < track.steps; ++k) {
        const Vec3<double> nu = track.path.col(k);
        const Vec3<double> end = step(*model_, track, k, nu);
        Columns by_theta(3, n);
        for (Eigen::Index i = 0; i < n; ++i) {
          const auto m = static_cast<std::size_t>(2 * i);
          by_theta.col(i) = (step(moved[m], track, k, nu) - step(moved[m + 1], track, k, nu)) / (2.0 * difference(i));
        }
        Eigen::Matrix3d by_state;
        for (int i = 0; i < 3; ++i) {
          const double h = 1e-3 * data_.config.sigma(i);
          by_state.col(i) = (step(*model_, track, k, nu + h * Vec3<double>::Unit(i)) - end) / h;
        }
        if (!by_theta.allFinite() || !by_state.allFinite())
          throw NumericalError(fmt::format("{}: the base ship '{}' has no finite acceleration at t = {} s",
                                           track.samples.file, data_.base->ship().name, track.samples.t_s(k)));
        track.by_theta.push_back(std::move(by_theta));
        track.by_state.push_back(by_state);
      }
    }
  }

  // Paths that the filter finds with the likeliest coefficients: what noise is left in them is no part of the
  // innovations that follow, which would bias the coefficients.
  void follow() {
    model_ = model_at(theta_);
    std::vector<Eigen::Matrix3Xd> paths;
    likelihood(log_noise_, &paths);
    for (std::size_t i = 0; i < tracks_.size(); ++i) tracks_[i].path = std::move(paths[i]);
  }

  //   paths  nothing, or where the filtered velocities go
  Likelihood likelihood(const Vec3<double>& log_noise, std::vector<Eigen::Matrix3Xd>* paths = nullptr) const {
    const Eigen::Index n = theta_.size();
    Likelihood sum{Eigen::MatrixXd::Zero(n, n), Eigen::VectorXd::Zero(n), 0.0};
    const Eigen::Matrix3d R = data_.config.sigma.cwiseAbs2().asDiagonal();
    const Eigen::Matrix3d Q = ((2.0 * log_noise).array().exp() * dt_s_).matrix().asDiagonal();
    double c = 0.0;
    for (const Track& track : tracks_) {
      Vec3<double> nu = track.samples.nu.col(0);
      if (paths != nullptr) paths->push_back(track.samples.nu);
      Eigen::Matrix3d P = R;
      Columns by_theta = Columns::Zero(3, n);
      for (Eigen::Index k = 0; k < track.steps; ++k) {
        const Vec3<double> end = step(*model_, track, k, nu);
        if (!end.allFinite()) break;
        const Eigen::Matrix3d& F = track.by_state[static_cast<std::size_t>(k)];
        const Eigen::Matrix3d before = F * P * F.transpose() + Q;
        const Columns moved = F * by_theta + track.by_theta[static_cast<std::size_t>(k)];
        const Vec3<double> e = track.samples.nu.col(k + 1) - end;
        const Eigen::LLT<Eigen::Matrix3d> V(before + R);
        const Eigen::Matrix3d L = V.matrixL();
        c += V.solve(e).dot(e) + 2.0 * L.diagonal().array().log().sum();
        const Columns scaled = V.matrixL().solve(moved);
        sum.A.selfadjointView<Eigen::Lower>().rankUpdate(scaled.transpose());
        sum.b += scaled.transpose() * V.matrixL().solve(e);
        const Eigen::Matrix3d gain = V.solve(before).transpose();
        nu = end + gain * e;
        if (paths != nullptr) paths->back().col(k + 1) = nu;
        P = before - gain * before;
        P = (0.5 * (P + P.transpose())).eval();
        by_theta = moved - gain * moved;
      }
    }
    sum.A = Eigen::MatrixXd(sum.A.selfadjointView<Eigen::Lower>());
    // From differences to theta_ to theta itself.
    sum.here = c;
    sum.rest = c + 2.0 * sum.b.dot(theta_) + theta_.dot(sum.A * theta_);
    sum.b += sum.A * theta_;
    return sum;
  }

  // Log evidence of each S on the grid, coefficients integrated out; the prior of S is in it.
  std::vector<double> log_evidence(const Likelihood& of) const {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(root_.transpose() * of.A * root_);
    const Eigen::ArrayXd values = eigen.eigenvalues().array().max(0.0);
    const Eigen::ArrayXd b2 = (eigen.eigenvectors().transpose() * (root_.transpose() * of.b)).array().square();
    std::vector<double> result;
    for (const double log_S : log_S_) {
      const double S2 = std::exp(2.0 * log_S);
      result.push_back(0.5 * (S2 * b2 / (1.0 + S2 * values)).sum() - 0.5 * (1.0 + S2 * values).log().sum() -
                       0.5 * of.rest - 0.5 * std::pow(log_S / kPriorOfLogS, 2.0));
    }
    return result;
  }

  double best_evidence(const Vec3<double>& log_noise) const {
    const std::vector<double> all = log_evidence(likelihood(log_noise));
    const double best = *std::ranges::max_element(all);
    return std::isfinite(best) ? best : -INFINITY;
  }

  // The three levels one after the other, by golden sections that narrow from round to round.
  void fit_noise() {
    constexpr double kGolden = 0.6180339887498949;
    for (const double width : {3.0, 0.8, 0.2})
      for (int i = 0; i < 3; ++i) {
        const auto value = [&](double x) {
          Vec3<double> log_noise = log_noise_;
          log_noise(i) = x;
          return best_evidence(log_noise);
        };
        double low = log_noise_(i) - width, high = log_noise_(i) + width;
        double a = high - kGolden * (high - low), b = low + kGolden * (high - low);
        double at_a = value(a), at_b = value(b);
        for (int step = 0; step < 5; ++step) {
          if (at_a > at_b) {
            high = b, b = a, at_b = at_a;
            a = high - kGolden * (high - low), at_a = value(a);
          } else {
            low = a, a = b, at_a = at_b;
            b = low + kGolden * (high - low), at_b = value(b);
          }
        }
        log_noise_(i) = at_a > at_b ? a : b;
      }
  }

  std::vector<double> posterior_of_log_S(const Likelihood& of) const {
    std::vector<double> weights = log_evidence(of);
    const double best = *std::ranges::max_element(weights);
    double sum = 0.0;
    for (double& w : weights) sum += (w = std::exp(w - best));
    for (double& w : weights) w /= sum;
    return weights;
  }

  double quantile(const std::vector<double>& weights, double share) const {
    double below = 0.0;
    for (std::size_t i = 0; i < log_S_.size(); ++i)
      if ((below += weights[i]) >= share) return std::exp(log_S_[i]);
    return std::exp(log_S_.back());
  }

  // The coefficients' normal law with the median of S.
  struct Posterior {
    Eigen::VectorXd mean;
    Eigen::MatrixXd covariance;
    double spread = 1.0;
  };
  //   share  of the likelihood that counts; S is 1 where it is not whole, if it is not given
  Posterior posterior(double share) const {
    const Likelihood of = likelihood(log_noise_);
    const double spread = share < 1.0 && log_S_.size() > 1 ? 1.0 : quantile(posterior_of_log_S(of), 0.5);
    const Eigen::MatrixXd root = spread * root_;
    const Eigen::LDLT<Eigen::MatrixXd> precision(Eigen::MatrixXd::Identity(theta_.size(), theta_.size()) +
                                                 share * root.transpose() * of.A * root);
    const Eigen::MatrixXd covariance = root * precision.solve(root.transpose());
    return {share * covariance * of.b, 0.5 * (covariance + covariance.transpose()), spread};
  }

  // To the posterior's mean, or a part of the way where that is less likely than here: linearizations reach so far
  // only.
  void step_towards(const Posterior& posterior, bool checks) {
    const Eigen::VectorXd from = theta_, step = posterior.mean.cwiseMax(-most_theta_).cwiseMin(most_theta_) - from;
    const double before = cost(posterior.spread);
    for (int halvings = 0; halvings < kMostHalvings; ++halvings) {
      theta_ = from + std::ldexp(1.0, -halvings) * step;
      if (!checks || cost(posterior.spread) <= before) break;
    }
    follow();
  }

  // -2 log posterior of the coefficients at theta_, by the filter itself.
  double cost(double spread) {
    model_ = model_at(theta_);
    const double cost = likelihood(log_noise_).here + whitened_.solve(theta_).squaredNorm() / (spread * spread);
    return std::isfinite(cost) ? cost : INFINITY;
  }

  const TrainingData& data_;
  double dt_s_;
  int parts_ = 1;  // of a step
  std::vector<UncertainCoefficient> coefficients_;
  Eigen::MatrixXd root_;                                              // root_ root_' is the stated covariance
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> whitened_;  // of root_
  Eigen::VectorXd theta_;
  Eigen::VectorXd most_theta_;  // to either side, of where it is linearized
  std::vector<double> log_S_;   // of which the evidence is computed
  Vec3<double> log_noise_ = Vec3<double>::Zero();
  std::optional<Model<double>> model_;
  std::vector<Track> tracks_;
};

}  // namespace

BaseSpreadEstimate infer_base_spread(const TrainingData& data, std::vector<Trajectory> recordings,
                                     std::optional<double> spread) {
  data.base->prepare(recordings);
  return SpreadFit(data, recordings, spread).run();
}

std::shared_ptr<const BaseModel> calibrated(const BaseModel& base, const BaseSpreadEstimate& by) {
  Ship ship = base.ship();
  ship.name += "-calibrated";
  ship.multiply(by.factors);
  Ship::JointUncertainty joint{{}, by.covariance};
  for (std::size_t i = 0; i < by.factors.size(); ++i) {
    joint.names.push_back(by.factors[i].name);
    const double least = ship.is_absolute(by.factors[i].name) ? kAbsoluteSdRange.low : kLogSdRange.low;
    double& variance = joint.matrix(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i));
    variance = std::max(variance, least * least);
  }
  io::Json json =
      multiplied(io::parse_json(base.text(), base.ship().file), by.factors,
                 fmt::format("fitted to recordings from '{}', whose stated uncertainty times {:.3g} was the "
                             "prior",
                             base.ship().name, by.spread));
  json["name"] = ship.name;
  io::Json matrix = io::Json::array();
  for (const auto& row : joint.matrix.rowwise()) matrix.push_back(std::vector<double>(row.begin(), row.end()));
  json["coefficient_covariance"] = {
      {"source", "what the recordings leave open"}, {"names", joint.names}, {"matrix", matrix}};
  ship.coefficient_covariance = std::move(joint);
  return std::make_shared<const BaseModel>(std::move(ship), io::to_text(json));
}

}  // namespace leeway::ensemble
