#include "ensemble/base_spread.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/errors.hpp"
#include "core/linear_algebra.hpp"
#include "core/parallel.hpp"
#include "core/units.hpp"
#include "dynamics/replay.hpp"
#include "ensemble/innovations.hpp"
#include "io/files.hpp"
#include "ship/joint_uncertainty.hpp"

namespace leeway::ensemble {
namespace {

constexpr Eigen::Index kMostPoints = 20'000;  // that are looked at; more tell S no better
// Of a coefficient's logarithm, to either side, for derivatives: chords, since forces switch here and there, and a jump
// within a smaller difference would pass for knowledge.
constexpr double kDifference = 0.01;
constexpr double kTypicalLogSd = 0.2;     // of a coefficient; what the difference of an absolute one is measured by
constexpr double kShareDifference = 0.1;  // of an input's share, to either side, for derivatives
constexpr double kLongestPart = 0.9;      // of a step, in sqrt(L_pp / g): what Runge-Kutta follows to 1e-3
constexpr double kMostTheta = 1.0;        // of a coefficient's logarithm, where it is linearized
constexpr int kNoiseFits = 2;             // of linearizations that count in full, along with which noise is fitted
// The first steps take what is stated at its word and the recordings for less than they are, lest a linearization lead
// far astray: the filter's likelihood has other maxima.
constexpr int kStatedSteps = 5;
constexpr double kTemper = 0.25;  // share of the likelihood that counts, of one step by that of the next
constexpr int kMostLinearizations = 20;
constexpr int kMostHalvings = 7;  // of a step that is too far
// A step's square in the metric of the posterior, by the number of coefficients. Not less: where forces switch, the
// derivatives themselves tremble by as much.
constexpr double kStepConverged = 0.05;
constexpr double kPriorOfLogS = 1.0;  // its standard deviation

using Columns = Eigen::Matrix<double, 3, Eigen::Dynamic>;
// Actuators as in Actuators, then the true wind.
using InputVector = Eigen::Matrix<double, static_cast<int>(kActuatorChannels.size()) + 2, 1>;

InputVector as_vector(const Inputs<double>& inputs) {
  InputVector result;
  result << Eigen::Map<const Eigen::VectorXd>(inputs.actuators.values.data(), result.size() - 2), inputs.true_wind;
  return result;
}

void move(Inputs<double>& inputs, const InputVector& by) {
  for (std::size_t i = 0; i < inputs.actuators.values.size(); ++i)
    inputs.actuators.values[i] += by(static_cast<Eigen::Index>(i));
  inputs.true_wind += by.tail<2>();
}

// What a coefficient of `from` was changed by to be that of `to`: see BaseSpreadEstimate.
double between(const UncertainCoefficient& coefficient, const Ship& from, const Ship& to) {
  const auto change = [&](const Ship& ship) {
    const auto found = std::ranges::find(ship.coefficient_factors, coefficient.name, &CoefficientFactor::name);
    return found == ship.coefficient_factors.end() ? CoefficientFactor{coefficient.name} : *found;
  };
  if (coefficient.is_absolute) return change(to).shift - change(from).shift;
  return std::log(change(to).factor / change(from).factor);
}

// A stretch with inputs that are linear between samples, and derivatives of its steps' ends.
struct Track {
  Samples samples;
  std::vector<std::vector<StepInputs<double>>> inputs;  // of the parts of each step, straight from sample to sample
  std::vector<InputVector> changes;                     // of the inputs over each step
  Eigen::Index steps;
  Eigen::Matrix3Xd path;          // velocities that it is linearized at: recorded at first, then filtered
  std::vector<Columns> by_theta;  // and by the shares of the inputs
  std::vector<Eigen::Matrix3d> by_state;
};

class SpreadFit {
 public:
  SpreadFit(const TrainingData& data, const std::vector<Trajectory>& recordings, std::optional<double> spread,
            std::size_t jobs, const BaseModel* near)
      : data_(data), jobs_(jobs), first_round_(near == nullptr ? 0 : kStatedSteps), dt_s_(data.config.time_step_s) {
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
    if (near != nullptr)
      for (std::size_t i = 0; i < coefficients_.size(); ++i)
        theta_(static_cast<Eigen::Index>(i)) = between(coefficients_[i], data.base->ship(), near->ship());
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
        Track track{samples, {}, {}, size - 1, samples.nu, {}, {}};
        for (Eigen::Index k = 0; k < track.steps; ++k) {
          track.inputs.emplace_back();
          for (int part = 0; part < parts_; ++part)
            track.inputs.back().push_back(inputs.step(samples.t_s(k) + part * part_s, part_s));
          track.changes.emplace_back(as_vector(track.inputs.back().back().end) -
                                     as_vector(track.inputs.back().front().start));
        }
        tracks_.push_back(std::move(track));
      }
    }
    for (Eigen::Index i = 0; i < InputVector::SizeAtCompileTime; ++i)
      if (std::ranges::any_of(tracks_, [&](const Track& track) {
            return std::ranges::any_of(track.changes, [&](const InputVector& change) { return change(i) != 0.0; });
          }))
        moving_.push_back(i);
    // Noise at first as large as all that the base ship leaves over.
    for (int i = 0; i < 3; ++i)
      log_noise_(i) = std::log(data.inputs.accelerations[static_cast<std::size_t>(i)].sd * std::sqrt(dt_s_));
  }

  BaseSpreadEstimate run() {
    Posterior last;
    for (int round = first_round_; round < kMostLinearizations; ++round) {
      linearize(round >= kStatedSteps);
      if (round == 0 || (round >= kStatedSteps && round < kStatedSteps + kNoiseFits)) fit_noise();
      last = posterior(round < kStatedSteps ? std::pow(kTemper, kStatedSteps - round) : 1.0);
      const Eigen::VectorXd before = theta_;
      step_towards(last, round >= kStatedSteps);
      const Eigen::VectorXd moved = theta_ - before;
      const double square =
          moved.dot(last.A * moved) + whitened_.solve(moved).squaredNorm() / (last.spread * last.spread);
      if (round >= kStatedSteps + kNoiseFits && square < kStepConverged * static_cast<double>(moved.size())) break;
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
  Vec3<double> step(const Model<double>& model, const Track& track, Eigen::Index k, const Vec3<double>& nu,
                    const InputVector& shares) const {
    ShipState<double> state;
    state.eta(2) = track.samples.eta(2, k);
    state.nu = nu;
    const InputVector ahead = shares.cwiseProduct(track.changes[static_cast<std::size_t>(k)]);
    for (StepInputs<double> part : track.inputs[static_cast<std::size_t>(k)]) {
      for (Inputs<double>* inputs : {&part.start, &part.middle, &part.end}) move(*inputs, ahead);
      state = integrate(model, state, part, dt_s_ / parts_);
    }
    return state.nu;
  }

  // To either side of theta_, for derivatives: of an absolute uncertainty a share of it.
  double difference(Eigen::Index i) const {
    const UncertainCoefficient& c = coefficients_[static_cast<std::size_t>(i)];
    return c.is_absolute ? kDifference * c.sd / kTypicalLogSd : kDifference;
  }

  // The model at theta_, and derivatives along the paths.
  //   both_sides  of a coefficient; otherwise upwards alone
  void linearize(bool both_sides) {
    model_ = model_at(theta_);
    const Eigen::Index n = theta_.size();
    std::vector<Chord> chords;
    for (Eigen::Index i = 0; i < n; ++i) {
      const Eigen::VectorXd h = difference(i) * Eigen::VectorXd::Unit(n, i);
      chords.push_back({model_at(theta_ + h), std::nullopt});
      if (both_sides) chords.back().below = model_at(theta_ - h);
    }
    parallel_for(tracks_.size(), jobs_, [&](std::size_t t) {
      Track& track = tracks_[t];
      track.by_theta.clear();
      track.by_state.clear();
      for (Eigen::Index k = 0; k < track.steps; ++k) linearize_step(chords, track, k);
    });
  }

  // Models with a coefficient that is moved.
  struct Chord {
    Model<double> above;
    std::optional<Model<double>> below;
  };
  void linearize_step(const std::vector<Chord>& chords, Track& track, Eigen::Index k) const {
    const Vec3<double> nu = track.path.col(k);
    const Vec3<double> end = step(*model_, track, k, nu, shares_);
    const Eigen::Index n = theta_.size();
    Columns by_theta(3, size());
    for (Eigen::Index i = 0; i < n; ++i) {
      const Chord& chord = chords[static_cast<std::size_t>(i)];
      const Vec3<double> above = step(chord.above, track, k, nu, shares_);
      by_theta.col(i) = chord.below ? (above - step(*chord.below, track, k, nu, shares_)) / (2.0 * difference(i))
                                    : (above - end) / difference(i);
    }
    for (std::size_t j = 0; j < moving_.size(); ++j) {
      const InputVector h = kShareDifference * InputVector::Unit(moving_[j]);
      by_theta.col(n + static_cast<Eigen::Index>(j)) =
          (step(*model_, track, k, nu, shares_ + h) - step(*model_, track, k, nu, shares_ - h)) /
          (2.0 * kShareDifference);
    }
    Eigen::Matrix3d by_state;
    for (int i = 0; i < 3; ++i) {
      const double h = 1e-3 * data_.config.sigma(i);
      by_state.col(i) = (step(*model_, track, k, nu + h * Vec3<double>::Unit(i), shares_) - end) / h;
    }
    if (!by_theta.allFinite() || !by_state.allFinite())
      throw NumericalError(fmt::format("{}: the base ship '{}' has no finite acceleration at t = {} s",
                                       track.samples.file, data_.base->ship().name, track.samples.t_s(k)));
    track.by_theta.push_back(std::move(by_theta));
    track.by_state.push_back(by_state);
  }

  // Of x in Likelihood, and where it is linearized.
  Eigen::Index size() const { return theta_.size() + static_cast<Eigen::Index>(moving_.size()); }
  Eigen::VectorXd here() const {
    Eigen::VectorXd x(size());
    x << theta_, shares_(moving_);
    return x;
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
    std::vector<Likelihood> of_tracks(tracks_.size());
    if (paths != nullptr) paths->resize(tracks_.size());
    parallel_for(tracks_.size(), jobs_, [&](std::size_t i) {
      of_tracks[i] = likelihood(tracks_[i], log_noise, paths == nullptr ? nullptr : &(*paths)[i]);
    });
    Likelihood sum{Eigen::MatrixXd::Zero(size(), size()), Eigen::VectorXd::Zero(size()), 0.0, 0.0};
    for (const Likelihood& track : of_tracks) {
      sum.A += track.A;
      sum.b += track.b;
      sum.here += track.here;
    }
    sum.A = Eigen::MatrixXd(sum.A.selfadjointView<Eigen::Lower>());
    // From differences to x itself.
    const Eigen::VectorXd x = here();
    sum.rest = sum.here + 2.0 * sum.b.dot(x) + x.dot(sum.A * x);
    sum.b += sum.A * x;
    return sum;
  }

  // Of a track: its part of A (the lower triangle), b and here, by differences to x.
  Likelihood likelihood(const Track& track, const Vec3<double>& log_noise, Eigen::Matrix3Xd* path) const {
    const Eigen::Index n = size();
    Likelihood sum{Eigen::MatrixXd::Zero(n, n), Eigen::VectorXd::Zero(n), 0.0, 0.0};
    const Eigen::Matrix3d R = data_.config.sigma.cwiseAbs2().asDiagonal();
    const Eigen::Matrix3d Q = ((2.0 * log_noise).array().exp() * dt_s_).matrix().asDiagonal();
    Vec3<double> nu = track.samples.nu.col(0);
    if (path != nullptr) *path = track.samples.nu;
    Eigen::Matrix3d P = R;
    Columns by_theta = Columns::Zero(3, n);
    for (Eigen::Index k = 0; k < track.steps; ++k) {
      const Vec3<double> end = step(*model_, track, k, nu, shares_);
      if (!end.allFinite()) break;
      const Eigen::Matrix3d& F = track.by_state[static_cast<std::size_t>(k)];
      const Columns& by_x = track.by_theta[static_cast<std::size_t>(k)];
      // In each step by a share of its own besides.
      const auto by_shares = by_x.rightCols(n - theta_.size());
      const Eigen::Matrix3d before =
          F * P * F.transpose() + Q + kInputShareVariance * by_shares * by_shares.transpose();
      const Columns moved = F * by_theta + by_x;
      const Vec3<double> e = track.samples.nu.col(k + 1) - end;
      const Eigen::LLT<Eigen::Matrix3d> V(before + R);
      const Eigen::Matrix3d L = V.matrixL();
      sum.here += V.solve(e).dot(e) + 2.0 * L.diagonal().array().log().sum();
      const Columns scaled = V.matrixL().solve(moved);
      sum.A.selfadjointView<Eigen::Lower>().rankUpdate(scaled.transpose());
      sum.b += scaled.transpose() * V.matrixL().solve(e);
      const Eigen::Matrix3d gain = V.solve(before).transpose();
      nu = end + gain * e;
      if (path != nullptr) path->col(k + 1) = nu;
      P = before - gain * before;
      P = (0.5 * (P + P.transpose())).eval();
      by_theta = moved - gain * moved;
    }
    return sum;
  }

  // Log evidence of each S on the grid, coefficients and shares integrated out; the prior of S is in it.
  std::vector<double> log_evidence(const Likelihood& with_shares) const {
    const Likelihood of = with_shares.without_shares(theta_.size());
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

  // The three levels one after the other, by golden sections that narrow from round to round and from fit to fit.
  void fit_noise() {
    constexpr double kGolden = 0.6180339887498949;
    constexpr int kRounds = 2;
    for (int round = 0; round < kRounds; ++round, noise_width_ *= 0.25)
      for (int i = 0; i < 3; ++i) {
        const auto value = [&](double x) {
          Vec3<double> log_noise = log_noise_;
          log_noise(i) = x;
          return best_evidence(log_noise);
        };
        double low = log_noise_(i) - noise_width_, high = log_noise_(i) + noise_width_;
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
    noise_width_ *= 8.0;  // the next fit begins at half of this one
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
    Eigen::VectorXd shares;  // the likeliest, with the mean
    Eigen::MatrixXd covariance;
    Eigen::MatrixXd A;  // what the likelihood adds to the prior's precision
    double spread = 1.0;
  };
  //   share  of the likelihood that counts; S is 1 where it is not whole, if it is not given
  Posterior posterior(double share) const {
    Likelihood whole = likelihood(log_noise_);
    const double spread = share < 1.0 && log_S_.size() > 1 ? 1.0 : quantile(posterior_of_log_S(whole), 0.5);
    whole.A *= share;
    whole.b *= share;
    const Likelihood of = whole.without_shares(theta_.size());
    const Eigen::MatrixXd root = spread * root_;
    const Eigen::LDLT<Eigen::MatrixXd> precision(Eigen::MatrixXd::Identity(theta_.size(), theta_.size()) +
                                                 root.transpose() * of.A * root);
    const Eigen::MatrixXd covariance = root * precision.solve(root.transpose());
    const Eigen::VectorXd mean = covariance * of.b;
    return {mean, whole.shares(mean), 0.5 * (covariance + covariance.transpose()), of.A, spread};
  }

  // To the posterior's mean, or a part of the way where that is less likely than here: linearizations reach so far
  // only.
  void step_towards(const Posterior& posterior, bool checks) {
    const Eigen::VectorXd from = theta_, step = posterior.mean.cwiseMax(-most_theta_).cwiseMin(most_theta_) - from;
    const Eigen::VectorXd shares_from = shares_(moving_), shares_step = posterior.shares - shares_from;
    const double before = cost(posterior.spread);
    for (int halvings = 0; halvings < kMostHalvings; ++halvings) {
      theta_ = from + std::ldexp(1.0, -halvings) * step;
      shares_(moving_) = shares_from + std::ldexp(1.0, -halvings) * shares_step;
      if (!checks || cost(posterior.spread) <= before) break;
    }
    follow();
  }

  // -2 log posterior of the coefficients at theta_, by the filter itself.
  double cost(double spread) {
    model_ = model_at(theta_);
    const double cost = likelihood(log_noise_).here + whitened_.solve(theta_).squaredNorm() / (spread * spread) +
                        shares_.squaredNorm() / kInputShareVariance;
    return std::isfinite(cost) ? cost : INFINITY;
  }

  const TrainingData& data_;
  std::size_t jobs_;
  int first_round_;
  double dt_s_;
  int parts_ = 1;  // of a step
  std::vector<UncertainCoefficient> coefficients_;
  Eigen::MatrixXd root_;                                              // root_ root_' is the stated covariance
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> whitened_;  // of root_
  Eigen::VectorXd theta_;
  Eigen::VectorXd most_theta_;        // to either side, of where it is linearized
  std::vector<double> log_S_;         // of which the evidence is computed
  std::vector<Eigen::Index> moving_;  // inputs that change
  InputVector shares_ = InputVector::Zero();
  Vec3<double> log_noise_ = Vec3<double>::Zero();
  double noise_width_ = 3.0;  // of the logarithms, to either side, that are looked at next
  std::optional<Model<double>> model_;
  std::vector<Track> tracks_;
};

}  // namespace

BaseSpreadEstimate infer_base_spread(const TrainingData& data, std::vector<Trajectory> recordings,
                                     std::optional<double> spread, std::size_t jobs, const BaseModel* near) {
  data.base->prepare(recordings);
  return SpreadFit(data, recordings, spread, jobs, near).run();
}

std::shared_ptr<const BaseModel> calibrated(const BaseModel& base, const BaseSpreadEstimate& by) {
  Ship ship = base.ship();
  ship.name += "-calibrated";
  ship.multiply(by.factors);
  Ship::JointUncertainty joint{{}, by.covariance};
  for (const CoefficientFactor& factor : by.factors) joint.names.push_back(factor.name);
  joint = statable(std::move(joint), ship);
  io::Json json =
      multiplied(io::parse_json(base.text(), base.ship().file), by.factors,
                 fmt::format("fitted to recordings from '{}', whose stated uncertainty times {:.3g} was the "
                             "prior",
                             base.ship().name, by.spread));
  json["name"] = ship.name;
  json["coefficient_covariance"] = to_json(joint, "what the recordings leave open");
  ship.coefficient_covariance = std::move(joint);
  return std::make_shared<const BaseModel>(std::move(ship), io::to_text(json));
}

}  // namespace leeway::ensemble
