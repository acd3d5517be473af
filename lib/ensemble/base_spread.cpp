#include "ensemble/base_spread.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include <Eigen/Dense>
#include <fmt/format.h>

#include "core/errors.hpp"
#include "core/units.hpp"
#include "dynamics/replay.hpp"

namespace leeway::ensemble {
namespace {

constexpr Eigen::Index kMostPoints = 20'000;  // that are looked at; more tell S no better
constexpr double kDifference = 1e-4;          // of a coefficient's logarithm, for derivatives
constexpr double kMostTheta = 1.0;            // of a coefficient's logarithm, where it is linearized
constexpr double kLongestPart = 0.9;          // of a step, in sqrt(L_pp / g): what Runge-Kutta follows to 1e-3
constexpr int kLinearizations = 3;
constexpr double kPriorOfLogS = 1.0;  // its standard deviation

using Columns = Eigen::Matrix<double, 3, Eigen::Dynamic>;

// A stretch, the inputs of its steps, and derivatives of the steps' ends.
struct Track {
  const Samples* samples;
  std::vector<std::vector<StepInputs<double>>> inputs;  // of the parts of each step
  std::vector<Columns> by_theta;
  std::vector<Eigen::Matrix3d> by_state;
};

// What the filter's innovations say: -2 log likelihood is rest + theta' A theta - 2 b' theta.
struct Likelihood {
  Eigen::MatrixXd A;
  Eigen::VectorXd b;
  double rest = 0.0;
};

class SpreadFit {
 public:
  SpreadFit(const TrainingData& data, const std::vector<Trajectory>& recordings)
      : data_(data), dt_s_(data.config.time_step_s) {
    const double L_pp = data.base->ship().particulars.L_pp;
    parts_ = static_cast<int>(std::ceil(dt_s_ / (kLongestPart * std::sqrt(L_pp / kGravity_mps2))));
    std::map<std::string, RecordedInputs> inputs_of;
    for (const Trajectory& recording : recordings)
      inputs_of.emplace(recording.file, RecordedInputs(recording, data.base->ship(), InputInterpolation::linear));
    const CoefficientLaw law = coefficient_law(data.base->ship());
    for (const UncertainCoefficient& c : law.coefficients) names_.push_back(c.name);
    const Eigen::LDLT<Eigen::MatrixXd> factors(law.covariance);
    root_ = factors.transpositionsP().transpose() * Eigen::MatrixXd(factors.matrixL());
    root_ = (root_ * factors.vectorD().cwiseMax(0.0).cwiseSqrt().asDiagonal()).eval();
    theta_ = Eigen::VectorXd::Zero(law.covariance.rows());
    Eigen::Index points = 0;
    for (const Samples& samples : data.stretches) {
      if (points >= kMostPoints) break;
      const Eigen::Index size = std::min(samples.size(), kMostPoints - points);
      points += size;
      Track track{&samples, {}, {}, {}};
      const RecordedInputs& inputs = inputs_of.at(samples.file);
      const double part_s = dt_s_ / parts_;
      for (Eigen::Index k = 0; k + 1 < size; ++k) {
        track.inputs.emplace_back();
        for (int part = 0; part < parts_; ++part)
          track.inputs.back().push_back(inputs.step(samples.t_s(k) + part * part_s, part_s));
      }
      tracks_.push_back(std::move(track));
    }
    // Noise at first as large as all that the base ship leaves over.
    for (int i = 0; i < 3; ++i)
      log_noise_(i) = std::log(data.inputs.accelerations[static_cast<std::size_t>(i)].sd * std::sqrt(dt_s_));
  }

  BaseSpreadEstimate run() {
    for (int round = 0; round < kLinearizations; ++round) {
      linearize();
      fit_noise();
      theta_ = likeliest().cwiseMax(-kMostTheta).cwiseMin(kMostTheta);
    }
    linearize();
    fit_noise();
    BaseSpreadEstimate estimate;
    const std::vector<double> weights = posterior_of_log_S(likelihood(log_noise_));
    estimate.low = quantile(weights, 0.05);
    estimate.spread = quantile(weights, 0.5);
    estimate.high = quantile(weights, 0.95);
    estimate.acceleration_noise = log_noise_.array().exp();
    for (std::size_t i = 0; i < names_.size(); ++i)
      estimate.factors.push_back({names_[i], std::exp(theta_(static_cast<Eigen::Index>(i)))});
    return estimate;
  }

 private:
  static constexpr int kGrid = 121;  // ln S from -3 to 3
  static double log_S(int i) { return -3.0 + 6.0 * i / (kGrid - 1); }

  Model<double> model_at(const Eigen::VectorXd& theta) const {
    Model<double> model = data_.base->model();
    std::vector<double> factors;
    for (const double x : theta) factors.push_back(std::exp(x));
    model.multiply_coefficients(factors);
    return model;
  }

  // The velocity at the end of a step from what is recorded of the heading.
  Vec3<double> step(const Model<double>& model, const Track& track, std::size_t k, const Vec3<double>& nu) const {
    ShipState<double> state;
    state.eta(2) = track.samples->eta(2, static_cast<Eigen::Index>(k));
    state.nu = nu;
    for (const StepInputs<double>& part : track.inputs[k]) state = integrate(model, state, part, dt_s_ / parts_);
    return state.nu;
  }

  // The model at theta_, and derivatives along the recorded states.
  void linearize() {
    model_ = model_at(theta_);
    std::vector<Model<double>> moved;
    for (Eigen::Index i = 0; i < theta_.size(); ++i)
      moved.push_back(model_at(theta_ + kDifference * Eigen::VectorXd::Unit(theta_.size(), i)));
    for (Track& track : tracks_) {
      track.by_theta.clear();
      track.by_state.clear();
      for (std::size_t k = 0; k < track.inputs.size(); ++k) {
        const Vec3<double> nu = track.samples->nu.col(static_cast<Eigen::Index>(k));
        const Vec3<double> end = step(*model_, track, k, nu);
        Columns by_theta(3, theta_.size());
        for (Eigen::Index i = 0; i < theta_.size(); ++i)
          by_theta.col(i) = (step(moved[static_cast<std::size_t>(i)], track, k, nu) - end) / kDifference;
        Eigen::Matrix3d by_state;
        for (int i = 0; i < 3; ++i) {
          const double h = 1e-3 * data_.config.sigma(i);
          by_state.col(i) = (step(*model_, track, k, nu + h * Vec3<double>::Unit(i)) - end) / h;
        }
        if (!by_theta.allFinite() || !by_state.allFinite())
          throw NumericalError(fmt::format("{}: the base ship '{}' has no finite acceleration at t = {} s",
                                           track.samples->file, data_.base->ship().name,
                                           track.samples->t_s(static_cast<Eigen::Index>(k))));
        track.by_theta.push_back(std::move(by_theta));
        track.by_state.push_back(by_state);
      }
    }
  }

  Likelihood likelihood(const Vec3<double>& log_noise) const {
    const Eigen::Index n = theta_.size();
    Likelihood sum{Eigen::MatrixXd::Zero(n, n), Eigen::VectorXd::Zero(n), 0.0};
    const Eigen::Matrix3d R = data_.config.sigma.cwiseAbs2().asDiagonal();
    const Eigen::Matrix3d Q = ((2.0 * log_noise).array().exp() * dt_s_).matrix().asDiagonal();
    double c = 0.0;
    for (const Track& track : tracks_) {
      Vec3<double> nu = track.samples->nu.col(0);
      Eigen::Matrix3d P = R;
      Columns by_theta = Columns::Zero(3, n);
      for (std::size_t k = 0; k < track.inputs.size(); ++k) {
        const Vec3<double> end = step(*model_, track, k, nu);
        if (!end.allFinite()) break;
        const Eigen::Matrix3d& F = track.by_state[k];
        const Eigen::Matrix3d before = F * P * F.transpose() + Q;
        const Columns moved = F * by_theta + track.by_theta[k];
        const Vec3<double> e = track.samples->nu.col(static_cast<Eigen::Index>(k) + 1) - end;
        const Eigen::LLT<Eigen::Matrix3d> V(before + R);
        const Eigen::Matrix3d L = V.matrixL();
        c += V.solve(e).dot(e) + 2.0 * L.diagonal().array().log().sum();
        const Columns scaled = V.matrixL().solve(moved);
        sum.A.selfadjointView<Eigen::Lower>().rankUpdate(scaled.transpose());
        sum.b += scaled.transpose() * V.matrixL().solve(e);
        const Eigen::Matrix3d gain = V.solve(before).transpose();
        nu = end + gain * e;
        P = before - gain * before;
        P = (0.5 * (P + P.transpose())).eval();
        by_theta = moved - gain * moved;
      }
    }
    sum.A = Eigen::MatrixXd(sum.A.selfadjointView<Eigen::Lower>());
    // From differences to theta_ to theta itself.
    sum.rest = c + 2.0 * sum.b.dot(theta_) + theta_.dot(sum.A * theta_);
    sum.b += sum.A * theta_;
    return sum;
  }

  // Log evidence of each S on the grid, coefficients integrated out; the prior of S is in it.
  std::vector<double> log_evidence(const Likelihood& of) const {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(root_.transpose() * of.A * root_);
    const Eigen::ArrayXd values = eigen.eigenvalues().array().max(0.0);
    const Eigen::ArrayXd b2 = (eigen.eigenvectors().transpose() * (root_.transpose() * of.b)).array().square();
    std::vector<double> result(kGrid);
    for (int i = 0; i < kGrid; ++i) {
      const double S2 = std::exp(2.0 * log_S(i));
      result[static_cast<std::size_t>(i)] = 0.5 * (S2 * b2 / (1.0 + S2 * values)).sum() -
                                            0.5 * (1.0 + S2 * values).log().sum() - 0.5 * of.rest -
                                            0.5 * std::pow(log_S(i) / kPriorOfLogS, 2.0);
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

  static double quantile(const std::vector<double>& weights, double share) {
    double below = 0.0;
    for (int i = 0; i < kGrid; ++i)
      if ((below += weights[static_cast<std::size_t>(i)]) >= share) return std::exp(log_S(i));
    return std::exp(log_S(kGrid - 1));
  }

  // The likeliest coefficients with the likeliest S.
  Eigen::VectorXd likeliest() const {
    const Likelihood of = likelihood(log_noise_);
    const double S = quantile(posterior_of_log_S(of), 0.5);
    const Eigen::MatrixXd root = S * root_;
    const Eigen::MatrixXd precision =
        Eigen::MatrixXd::Identity(theta_.size(), theta_.size()) + root.transpose() * of.A * root;
    return root * precision.ldlt().solve(root.transpose() * of.b);
  }

  const TrainingData& data_;
  double dt_s_;
  int parts_ = 1;  // of a step
  std::vector<std::string> names_;
  Eigen::MatrixXd root_;  // root_ root_' is the stated covariance
  Eigen::VectorXd theta_;
  Vec3<double> log_noise_ = Vec3<double>::Zero();
  std::optional<Model<double>> model_;
  std::vector<Track> tracks_;
};

}  // namespace

BaseSpreadEstimate infer_base_spread(const TrainingData& data, std::vector<Trajectory> recordings) {
  data.base->prepare(recordings);
  return SpreadFit(data, recordings).run();
}

}  // namespace leeway::ensemble
