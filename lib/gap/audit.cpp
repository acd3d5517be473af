#include "gap/audit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>

#include <Eigen/Dense>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/distributions.hpp"
#include "core/parallel.hpp"
#include "core/random.hpp"
#include "core/units.hpp"
#include "gap/channel_quality.hpp"
#include "gap/kinematic_windows.hpp"
#include "gap/sensor_faults.hpp"
#include "gap/words.hpp"

namespace leeway::gap {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using enum FaultParameter;

constexpr double kHuber = 2.0;               // standard deviations from which a residual counts linearly
constexpr double kHuberVariance = 0.9205;    // mean of min(z^2, kHuber^2) of a standard normal z
constexpr double kRateNoise = 0.1;           // of what the ship turned in a window, above which r has no factor
constexpr double kLeastTrackNoise_m = 1e-4;  // residuals below are rounding and interpolation
constexpr double kLeastHeadingNoise_rad = 1e-5;
constexpr std::size_t kFewestWindows = 8, kFewestUnits = 4;
constexpr std::size_t kMostFaults = 4, kMostAbsorbed = 3;
constexpr std::size_t kSignFlips = 40000, kResamples = 400;

double huber(double z) {
  const double a = std::abs(z);
  return a <= kHuber ? 0.5 * z * z : kHuber * (a - 0.5 * kHuber);
}

// Level of the residuals of one kind and the correlation of neighbors: negative where the noise of the pose that they
// share prevails (a moving average), positive where the noise lasts (autoregressive).
struct WindowNoise {
  double sd = 1.0, rho = 0.0;
};
using KinematicNoise = std::array<WindowNoise, 2>;

// Makes the rows of a run white, of unit variance; `spread` receives the logarithm of what each row was divided by.
template <typename Rows>
void whiten(const WindowNoise& noise, Rows rows, VectorXd* spread) {
  const double rho = noise.rho;
  double d = 1.0;
  for (Index k = 0; k < rows.rows(); ++k) {
    if (k > 0) {
      if (rho < 0.0) {
        const double before = d;
        d = 1.0 - rho * rho / before;
        // rows(k - 1) is white already: undo its scale.
        rows.row(k) -= rho / std::sqrt(before) * noise.sd * rows.row(k - 1);
      } else {
        d = 1.0 - rho * rho;
      }
    }
    if (rho < 0.0) rows.row(k) /= noise.sd * std::sqrt(d);
    if (spread) (*spread)(k) = std::log(noise.sd) + 0.5 * std::log(d);
  }
  if (rho >= 0.0) {
    for (Index k = rows.rows() - 1; k > 0; --k)
      rows.row(k) = (rows.row(k) - rho * rows.row(k - 1)) / (noise.sd * std::sqrt(1.0 - rho * rho));
    if (rows.rows() > 0) rows.row(0) /= noise.sd;
  }
}

// What the fit of a set of candidates to the recordings is.
struct FaultModel {
  std::vector<std::size_t> members;  // of the library
  VectorXd numbers;                  // of all members, one after the other
  VectorXd residuals;
  MatrixXd sensitivities;  // of the residuals to the numbers
  KinematicNoise noise;
  double cost = 0.0;
  VectorXd heldout;  // log-likelihood of each unit by the fit without it
};

// Normal equations of some rows.
struct Normal {
  MatrixXd A;
  VectorXd b;
  explicit Normal(Index n) : A(MatrixXd::Zero(n, n)), b(VectorXd::Zero(n)) {}
  void add(const Eigen::Ref<const VectorXd>& j, double z, double weight) {
    A += weight * j * j.transpose();
    b += weight * z * j;
  }
  Normal& operator+=(const Normal& other) {
    A += other.A;
    b += other.b;
    return *this;
  }
  Normal& operator-=(const Normal& other) {
    A -= other.A;
    b -= other.b;
    return *this;
  }
};

class Fitter {
 public:
  explicit Fitter(const KinematicWindows& windows) : windows_(windows), unit_of_row_(windows.rows()) {
    for (const WindowRun& run : windows.runs())
      for (Index k = 0; k < run.size; ++k) unit_of_row_[static_cast<std::size_t>(run.begin + k)] = run.unit;
  }

  FaultModel sound() const {
    FaultModel model;
    model.numbers.resize(0);
    model.residuals = windows_.residuals({});
    model.sensitivities.resize(windows_.rows(), 0);
    model.noise = estimate_noise(model.residuals, 0);
    finish(model);
    return model;
  }

  // The members of `base` with one more, all numbers fitted anew; latencies are searched over their whole range.
  FaultModel with(const FaultModel& base, std::size_t candidate) const {
    FaultModel start = base;
    start.members.push_back(candidate);
    const std::vector<std::vector<FaultParameter>>& numbers = fault_library()[candidate].numbers;
    const Index old = base.numbers.size(), size = old + static_cast<Index>(numbers.size());
    start.numbers.conservativeResize(size);
    start.numbers.tail(size - old).setZero();
    if (!info(numbers[0][0]).is_time) return fitted(start);

    const bool is_lag = numbers[0][0] == velocity_filter;
    const double longest = windows_.longest_latency_s();
    FaultModel best = start;
    double least = std::numeric_limits<double>::infinity();
    for (const double share : {-0.9, -0.5, -0.2, 0.0, 0.1, 0.2, 0.35, 0.5, 0.7, 0.9}) {
      if (is_lag && share < 0.0) continue;
      start.numbers(old) = share * longest;
      const double cost = cost_of(windows_.residuals(faults_of(start)), start.numbers, start.members, base.noise);
      if (cost < least) {
        least = cost;
        best.numbers = start.numbers;
        best.members = start.members;
      }
    }
    return fitted(best);
  }

  // The same members with some left out.
  FaultModel without(const FaultModel& base, std::size_t place) const {
    FaultModel start = base;
    start.members.erase(start.members.begin() + static_cast<std::ptrdiff_t>(place));
    start.numbers.resize(base.numbers.size() - size_of(base.members[place]));
    Index from = 0, to = 0;
    for (std::size_t m = 0; m < base.members.size(); ++m) {
      const Index n = size_of(base.members[m]);
      if (m != place) {
        start.numbers.segment(to, n) = base.numbers.segment(from, n);
        to += n;
      }
      from += n;
    }
    if (start.members.empty()) return sound();
    return fitted(start);
  }

  SensorFaults faults_of(const FaultModel& model) const {
    SensorFaults faults;
    Index k = 0;
    for (const std::size_t member : model.members)
      for (const std::vector<FaultParameter>& number : fault_library()[member].numbers) {
        for (const FaultParameter parameter : number) faults[parameter] += model.numbers(k);
        ++k;
      }
    return faults;
  }

  VectorXd own_numbers(const FaultModel& model, std::size_t place) const {
    Index begin = 0;
    for (std::size_t m = 0; m < place; ++m) begin += size_of(model.members[m]);
    return model.numbers.segment(begin, size_of(model.members[place]));
  }

  static Index size_of(std::size_t member) { return static_cast<Index>(fault_library()[member].numbers.size()); }

  struct White {
    VectorXd z, weights, spread;
    MatrixXd J;
  };
  // Residuals and sensitivities, whitened with the noise of a model.
  White white(const FaultModel& model, const KinematicNoise& noise) const {
    White result{model.residuals, VectorXd::Ones(windows_.rows()), VectorXd::Zero(windows_.rows()),
                 model.sensitivities};
    for (const WindowRun& run : windows_.runs()) {
      const WindowNoise& of = noise[static_cast<std::size_t>(run.kind)];
      VectorXd spread(run.size);
      whiten(of, result.z.segment(run.begin, run.size), &spread);
      whiten(of, result.J.middleRows(run.begin, run.size), nullptr);
      result.spread.segment(run.begin, run.size) = spread;
    }
    for (Index k = 0; k < result.z.size(); ++k) result.weights(k) = std::min(1.0, kHuber / std::abs(result.z(k)));
    return result;
  }

  std::vector<Normal> normals(const White& rows) const {
    std::vector<Normal> result(windows_.unit_count(), Normal(rows.J.cols()));
    for (Index k = 0; k < rows.z.size(); ++k)
      result[unit(k)].add(rows.J.row(k).transpose(), rows.z(k), rows.weights(k));
    return result;
  }

  VectorXd prior_precision(const std::vector<std::size_t>& members) const {
    std::vector<double> precision;
    for (const std::size_t member : members)
      for (const std::vector<FaultParameter>& number : fault_library()[member].numbers)
        precision.push_back(1.0 / std::pow(info(number[0]).prior_sd, 2));
    return Eigen::Map<VectorXd>(precision.data(), static_cast<Index>(precision.size()));
  }

  std::size_t unit(Index row) const { return unit_of_row_[static_cast<std::size_t>(row)]; }
  const KinematicWindows& windows() const { return windows_; }

  // Standard deviations of functions of the numbers, by drawing units with replacement.
  //   derive  maps the numbers of a draw to what the deviation is wanted of
  template <typename Derive>
  VectorXd resampled_sd(const FaultModel& model, RandomStream stream, const Derive& derive) const {
    const std::vector<Normal> of_unit = normals(white(model, model.noise));
    const std::size_t units = of_unit.size();
    const VectorXd center = derive(model.numbers, model.numbers);
    VectorXd sum = VectorXd::Zero(center.size()), squares = sum;
    for (std::size_t draw = 0; draw < kResamples; ++draw) {
      Normal total(model.numbers.size());
      total.A.diagonal() += prior_precision(model.members);
      for (std::size_t g = 0; g < units; ++g) total += of_unit[stream.below(units)];
      const VectorXd drawn = derive(model.numbers - total.A.ldlt().solve(total.b), model.numbers) - center;
      sum += drawn;
      squares += drawn.cwiseAbs2();
    }
    const double n = static_cast<double>(kResamples), G = static_cast<double>(units);
    const VectorXd resampled = (squares / n - (sum / n).cwiseAbs2()).cwiseMax(0.0) * G / (G - 1.0);
    // Few units look more alike than they are: no less than what the noise alone would leave.
    Normal all(model.numbers.size());
    all.A.diagonal() += prior_precision(model.members);
    for (const Normal& normal : of_unit) all += normal;
    const MatrixXd covariance = all.A.inverse();
    MatrixXd slope(center.size(), model.numbers.size());
    for (Index k = 0; k < model.numbers.size(); ++k) {
      VectorXd moved = model.numbers;
      const double step = 1e-2 * std::sqrt(covariance(k, k));
      moved(k) += step;
      slope.col(k) = (derive(moved, model.numbers) - center) / step;
    }
    return resampled.cwiseMax((slope * covariance * slope.transpose()).diagonal()).cwiseSqrt();
  }

 private:
  KinematicNoise estimate_noise(const VectorXd& residuals, Index parameters) const {
    KinematicNoise noise;
    for (const Kinematics kind : {Kinematics::track, Kinematics::heading}) {
      WindowNoise& of = noise[static_cast<std::size_t>(kind)];
      const double least = kind == Kinematics::track ? kLeastTrackNoise_m : kLeastHeadingNoise_rad;
      std::vector<double> sizes;
      for (const WindowRun& run : windows_.runs())
        if (run.kind == kind)
          for (Index k = 0; k < run.size; ++k) sizes.push_back(std::abs(residuals(run.begin + k)));
      if (sizes.empty()) continue;
      const double n = static_cast<double>(sizes.size());
      const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
      std::nth_element(sizes.begin(), middle, sizes.end());
      const double rough = std::max(1.4826 * *middle, least);
      double products = 0.0, squares = 0.0, pairs = 0.0;
      const auto limited = [&](Index row) { return std::clamp(residuals(row), -2.5 * rough, 2.5 * rough); };
      for (const WindowRun& run : windows_.runs())
        if (run.kind == kind)
          for (Index k = 0; k < run.size; ++k) {
            squares += std::pow(limited(run.begin + k), 2);
            if (k + 1 < run.size) products += limited(run.begin + k) * limited(run.begin + k + 1), pairs += 1.0;
          }
      if (pairs > 0.0 && squares > 0.0)
        of.rho = std::clamp(products / pairs / (squares / n) * n / (n + 10.0), -0.45, 0.9);
      // Huber's second proposal: the level at which the limited squares have their expectation.
      of.sd = 1.0;
      VectorXd z = residuals;
      for (const WindowRun& run : windows_.runs())
        if (run.kind == kind) whiten(of, z.segment(run.begin, run.size), nullptr);
      const double freedom = std::max(1.0, n - static_cast<double>(parameters));
      double sd = rough;
      for (int i = 0; i < 30; ++i) {
        double sum = 0.0;
        for (const WindowRun& run : windows_.runs())
          if (run.kind == kind)
            for (Index k = 0; k < run.size; ++k)
              sum += std::min(std::pow(z(run.begin + k), 2), std::pow(kHuber * sd, 2));
        sd = std::max(least, std::sqrt(sum / (freedom * kHuberVariance)));
      }
      of.sd = sd;
    }
    return noise;
  }

  double cost_of(VectorXd residuals, const VectorXd& numbers, const std::vector<std::size_t>& members,
                 const KinematicNoise& noise) const {
    double cost = 0.5 * numbers.cwiseAbs2().dot(prior_precision(members));
    for (const WindowRun& run : windows_.runs()) {
      whiten(noise[static_cast<std::size_t>(run.kind)], residuals.segment(run.begin, run.size), nullptr);
      for (Index k = 0; k < run.size; ++k) cost += huber(residuals(run.begin + k));
    }
    return cost;
  }

  MatrixXd sensitivities(const FaultModel& model) const {
    MatrixXd result = MatrixXd::Zero(windows_.rows(), model.numbers.size());
    Index column = 0;
    for (const std::size_t member : model.members)
      for (const std::vector<FaultParameter>& number : fault_library()[member].numbers) {
        const double step = 1e-4 * info(number[0]).prior_sd;
        FaultModel moved;
        moved.members = model.members;
        moved.numbers = model.numbers;
        moved.numbers(column) += step;
        const SensorFaults faults = faults_of(moved);
        VectorXd residuals = model.residuals;
        bool in_track = false, in_heading = false;
        for (const FaultParameter parameter : number) {
          in_track = in_track || info(parameter).in_track;
          in_heading = in_heading || info(parameter).in_heading;
        }
        if (in_track) windows_.update(Kinematics::track, faults, residuals);
        if (in_heading) windows_.update(Kinematics::heading, faults, residuals);
        result.col(column) = (residuals - model.residuals) / step;
        ++column;
      }
    return result;
  }

  void limit(FaultModel& model) const {
    Index k = 0;
    for (const std::size_t member : model.members)
      for (const std::vector<FaultParameter>& number : fault_library()[member].numbers) {
        const double longest = windows_.longest_latency_s();
        if (number[0] == velocity_filter)
          model.numbers(k) = std::clamp(model.numbers(k), 0.0, longest);
        else if (info(number[0]).is_time)
          model.numbers(k) = std::clamp(model.numbers(k), -longest, longest);
        ++k;
      }
  }

  // Gauss-Newton with the noise estimated along the way.
  FaultModel fitted(FaultModel model) const {
    model.residuals = windows_.residuals(faults_of(model));
    for (int i = 0; i < 12; ++i) {
      model.noise = estimate_noise(model.residuals, model.numbers.size());
      model.sensitivities = sensitivities(model);
      const White rows = white(model, model.noise);
      Normal total(model.numbers.size());
      for (const Normal& normal : normals(rows)) total += normal;
      const VectorXd precision = prior_precision(model.members);
      total.A.diagonal() += precision;
      total.b += precision.cwiseProduct(model.numbers);
      const VectorXd full = total.A.ldlt().solve(total.b);
      const double before = cost_of(model.residuals, model.numbers, model.members, model.noise);
      FaultModel next = model;
      bool is_better = false;
      for (double share = 1.0; share > 0.05 && !is_better; share *= 0.5) {
        next.numbers = model.numbers - share * full;
        limit(next);
        next.residuals = windows_.residuals(faults_of(next));
        is_better = cost_of(next.residuals, next.numbers, next.members, model.noise) <= before;
      }
      if (!is_better) break;
      const VectorXd moved = next.numbers - model.numbers;
      const bool is_done = moved.dot(total.A * moved) < 1e-4;
      model = next;
      if (is_done) break;
    }
    model.noise = estimate_noise(model.residuals, model.numbers.size());
    model.sensitivities = sensitivities(model);
    finish(model);
    return model;
  }

  // The log-likelihood of each unit by the fit to the others. Of the neighbors of a block, the windows at its border
  // are left out as well.
  void finish(FaultModel& model) const {
    const White rows = white(model, model.noise);
    const Index size = model.numbers.size();
    const std::size_t units = windows_.unit_count();
    std::vector<Normal> of_unit(units, Normal(size)), of_first(units, Normal(size)), of_last(units, Normal(size));
    for (const WindowRun& run : windows_.runs())
      for (Index k = 0; k < run.size; ++k) {
        const Index row = run.begin + k;
        const VectorXd j = rows.J.row(row).transpose();
        of_unit[run.unit].add(j, rows.z(row), rows.weights(row));
        if (run.is_first_of_unit && k == 0) of_first[run.unit].add(j, rows.z(row), rows.weights(row));
        if (run.is_last_of_unit && k + 1 == run.size) of_last[run.unit].add(j, rows.z(row), rows.weights(row));
      }
    Normal all(size);
    for (const Normal& normal : of_unit) all += normal;
    all.A.diagonal() += prior_precision(model.members);
    all.b += prior_precision(model.members).cwiseProduct(model.numbers);
    std::vector<VectorXd> moved(units, VectorXd::Zero(size));
    for (std::size_t g = 0; g < units && size > 0; ++g) {
      Normal rest = all;
      rest -= of_unit[g];
      if (g > 0 && windows_.recording_of(g - 1) == windows_.recording_of(g)) rest -= of_last[g - 1];
      if (g + 1 < units && windows_.recording_of(g + 1) == windows_.recording_of(g)) rest -= of_first[g + 1];
      moved[g] = -rest.A.ldlt().solve(rest.b);
    }
    model.heldout = VectorXd::Zero(static_cast<Index>(units));
    model.cost = 0.0;
    for (Index row = 0; row < rows.z.size(); ++row) {
      const std::size_t g = unit(row);
      const double z = rows.z(row) + (size > 0 ? rows.J.row(row).dot(moved[g]) : 0.0);
      model.heldout(static_cast<Index>(g)) -= huber(z) + rows.spread(row);
      model.cost += huber(rows.z(row)) + rows.spread(row);
    }
  }

  const KinematicWindows& windows_;
  std::vector<std::size_t> unit_of_row_;
};

// The gain in held-out log-likelihood of one fit over another: mean over the units that have data and standard error.
struct Gain {
  double mean = 0.0, sd = 0.0, total = 0.0;
  bool is_certain(double standard_errors = 2.0) const { return mean > standard_errors * sd && mean > 0.0; }
};

Gain heldout_gain(const FaultModel& better, const FaultModel& worse) {
  const VectorXd difference = better.heldout - worse.heldout;
  const double n = static_cast<double>(difference.size());
  Gain gain;
  gain.total = difference.sum();
  gain.mean = gain.total / n;
  gain.sd = std::sqrt((difference.array() - gain.mean).square().sum() / (n * (n - 1.0)));
  return gain;
}

// Student's, of a gain that large where there is none. Scores say little of a fault where others have taken what is
// linear in it.
double chance_of(const Gain& gain, std::size_t units) {
  if (!(gain.mean > 0.0) || !(gain.sd > 0.0)) return 1.0;
  return f_survival(std::pow(gain.mean / gain.sd, 2), 1.0, static_cast<double>(units) - 1.0);
}

// p-value of chi-squared with one or two degrees of freedom, as its logarithm.
double log_chi2_p(double value, Index freedom) {
  if (freedom == 2) return -0.5 * value;
  const double root = std::sqrt(0.5 * value);
  // Far out erfc underflows: its asymptote.
  return root < 25.0 ? std::log(std::erfc(root)) : -root * root - std::log(root * std::sqrt(kPi));
}

// Family-wise p-values of candidates against a common base. Under the base the scores of the units have signs that
// are as good as tossed; their flips, the same for all candidates, give the distribution of the smallest p-value of
// the whole library, however the residuals are correlated within a unit and distributed.
std::vector<double> family_p_values(const Fitter& fitter, const FaultModel& base, const std::vector<FaultModel>& tried,
                                    RandomStream stream) {
  const std::size_t units = fitter.windows().unit_count();
  struct Score {
    MatrixXd of_unit;  // one column per unit
    MatrixXd inverse;
    Index freedom;
  };
  std::vector<Score> scores;
  const Index old = base.numbers.size();
  for (const FaultModel& model : tried) {
    // With the sensitivities at the fit, so that a long latency is judged by what it does, not by its beginning.
    FaultModel at = model;
    at.residuals = base.residuals;
    // A constant fault looks like slow noise where it is not taken out: noise is that beside the candidate.
    const Fitter::White of_base = fitter.white(base, model.noise), rows = fitter.white(at, model.noise);
    const VectorXd &z = of_base.z, &weights = of_base.weights;
    MatrixXd own = rows.J.rightCols(model.numbers.size() - old);
    if (old > 0) {
      const MatrixXd known = rows.J.leftCols(old);
      const MatrixXd weighted = weights.asDiagonal() * known;
      MatrixXd A = known.transpose() * weighted;
      A.diagonal() += fitter.prior_precision(base.members);
      own -= known * A.ldlt().solve(weighted.transpose() * own);
    }
    Score score{MatrixXd::Zero(own.cols(), static_cast<Index>(units)), {}, own.cols()};
    MatrixXd information = own.transpose() * weights.asDiagonal() * own;
    information.diagonal() += fitter.prior_precision({model.members.back()});
    score.inverse = information.inverse();
    for (Index k = 0; k < z.size(); ++k)
      score.of_unit.col(static_cast<Index>(fitter.unit(k))) += weights(k) * z(k) * own.row(k).transpose();
    scores.push_back(std::move(score));
  }
  const auto log_p = [&](const Score& score, const VectorXd& signs) {
    const VectorXd sum = score.of_unit * signs;
    return log_chi2_p(sum.dot(score.inverse * sum), score.freedom);
  };
  const VectorXd as_is = VectorXd::Ones(static_cast<Index>(units));
  std::vector<double> observed;
  for (const Score& score : scores) observed.push_back(log_p(score, as_is));
  std::vector<std::size_t> as_small(tried.size(), 0);
  for (std::size_t draw = 0; draw < kSignFlips; ++draw) {
    VectorXd signs(static_cast<Index>(units));
    for (Index g = 0; g < signs.size(); ++g) signs(g) = stream.uniform() < 0.5 ? -1.0 : 1.0;
    double least = 0.0;
    for (const Score& score : scores) least = std::min(least, log_p(score, signs));
    for (std::size_t c = 0; c < tried.size(); ++c)
      if (least <= observed[c]) ++as_small[c];
  }
  std::vector<double> result;
  for (const std::size_t count : as_small)
    result.push_back(static_cast<double>(1 + count) / static_cast<double>(1 + kSignFlips));
  return result;
}

// The size of a member's fault by the smallest that matters.
double by_smallest(const Fitter& fitter, std::size_t member, const VectorXd& own) {
  const KinematicWindows& windows = fitter.windows();
  const double speed = std::max(windows.rms_speed(), 1e-3), rate = std::max(windows.rms_rate(), 1e-4);
  const double latency = std::max(0.05, 0.1 * windows.sample_s());
  const FaultParameter first = fault_library()[member].numbers[0][0];
  switch (first) {
    case heading_bias:
      return std::abs(own(0)) / (0.2 * kDegree);
    case lever_x:
    case lever_y:
      return own.norm() / 0.05;
    case log_scale:
    case sway_log_scale:
    case rate_scale:
      return std::abs(own(0)) / 0.01;
    case log_bias_u:
    case log_bias_v:
    case current_x:
    case current_y:
      return own.norm() / (0.01 * speed);
    case velocity_latency:
    case heading_latency:
    case rate_latency:
    case position_latency:
    case velocity_filter:
    case rate_filter:
    case heading_filter:
      return std::abs(own(0)) / latency;
    case rate_bias:
      return std::abs(own(0)) / (0.01 * rate);
  }
  return 0.0;
}

std::string signed_side(double value, const char* positive, const char* negative) {
  return value > 0.0 ? positive : negative;
}

std::string sentence_of(std::size_t member, const std::vector<Estimate>& e) {
  const FaultCandidate& candidate = fault_library()[member];
  const std::size_t moved = candidate.numbers[0].size();
  const auto late = [&](const std::string& what) {
    return fmt::format("{} are recorded {:.2f} s (sd {:.2f}) too {}", what, std::abs(e[0].value), e[0].sd,
                       signed_side(e[0].value, "late", "early"));
  };
  switch (candidate.numbers[0][0]) {
    case heading_bias:
      return fmt::format("the heading is {:.2f} deg (sd {:.2f}) too {}, or the log is turned by as much to {}",
                         std::abs(e[0].value), e[0].sd, signed_side(e[0].value, "high", "low"),
                         signed_side(e[0].value, "port", "starboard"));
    case lever_x:
    case lever_y:
      return fmt::format(
          "the position is that of a point {:.2f} m (sd {:.2f}) {} of and {:.2f} m (sd {:.2f}) to {} of the one that u "
          "and v_m belong to",
          std::abs(e[0].value), e[0].sd, signed_side(e[0].value, "ahead", "astern"), std::abs(e[1].value), e[1].sd,
          signed_side(e[1].value, "starboard", "port"));
    case log_scale:
      return fmt::format("{} {:.1f} % (sd {:.1f}) too {}", moved > 1 ? "u and v_m are" : "u is",
                         100.0 * std::abs(e[0].value), 100.0 * e[0].sd, signed_side(e[0].value, "high", "low"));
    case sway_log_scale:
      return fmt::format("v_m is {:.1f} % (sd {:.1f}) too {}", 100.0 * std::abs(e[0].value), 100.0 * e[0].sd,
                         signed_side(e[0].value, "high", "low"));
    case log_bias_u:
    case log_bias_v:
      return fmt::format("u is {:+.4f} m/s (sd {:.4f}) and v_m {:+.4f} m/s (sd {:.4f}) off", e[0].value, e[0].sd,
                         e[1].value, e[1].sd);
    case current_x:
    case current_y:
      return fmt::format(
          "u and v_m are measured through the water, which sets towards {:.0f} deg (sd {:.0f}) at {:.4f} m/s (sd "
          "{:.4f})",
          e[1].value, e[1].sd, e[0].value, e[0].sd);
    case velocity_latency:
      return late(moved > 1 ? "u, v_m and r" : "u and v_m");
    case heading_latency:
      return fmt::format("the heading is recorded {:.2f} s (sd {:.2f}) too {}", std::abs(e[0].value), e[0].sd,
                         signed_side(e[0].value, "late", "early"));
    case rate_latency:
      return fmt::format("r is recorded {:.2f} s (sd {:.2f}) too {}", std::abs(e[0].value), e[0].sd,
                         signed_side(e[0].value, "late", "early"));
    case position_latency:
      return late("the positions") + (e[0].value < 0.0 ? ", or all other channels late" : "");
    case rate_bias:
      return fmt::format("r is {:.4f} deg/s (sd {:.4f}) too {}", std::abs(e[0].value), e[0].sd,
                         signed_side(e[0].value, "high", "low"));
    case rate_scale:
      return fmt::format("r is {:.1f} % (sd {:.1f}) too {}", 100.0 * std::abs(e[0].value), 100.0 * e[0].sd,
                         signed_side(e[0].value, "high", "low"));
    case velocity_filter:
    case rate_filter:
    case heading_filter:
      return fmt::format("{} have passed a filter of first order with a time constant of {:.2f} s (sd {:.2f})",
                         moved > 2   ? "u, v_m, r and the heading"
                         : moved > 1 ? "u, v_m and r"
                                     : "u and v_m",
                         e[0].value, e[0].sd);
  }
  return "";
}

// One member of a fit as a fault of the report.
Fault fault_of(const Fitter& fitter, const FaultModel& model, std::size_t place, const RandomStream& stream) {
  Index begin = 0;
  for (std::size_t m = 0; m < place; ++m) begin += Fitter::size_of(model.members[m]);
  const FaultCandidate& candidate = fault_library()[model.members[place]];
  const bool is_current = candidate.numbers[0][0] == current_x;
  Fault fault;
  fault.name = candidate.name;
  const auto derive = [&](const VectorXd& numbers, const VectorXd& reference) -> VectorXd {
    if (!is_current) return numbers.segment(begin, Fitter::size_of(model.members[place]));
    const double set = std::atan2(reference(begin + 1), reference(begin));
    const double drawn = std::atan2(numbers(begin + 1), numbers(begin));
    VectorXd polar(2);
    polar << numbers.segment(begin, 2).norm(), set + wrap_angle(drawn - set);
    return polar;
  };
  const VectorXd value = derive(model.numbers, model.numbers), sd = fitter.resampled_sd(model, stream, derive);
  if (is_current) {
    const double set = value(1) < 0.0 ? value(1) + 2.0 * kPi : value(1);
    fault.parameters = {{"current_speed_mps", value(0), sd(0)},
                        {"current_set_deg", rad_to_deg(set), rad_to_deg(sd(1))}};
  } else {
    for (std::size_t n = 0; n < candidate.numbers.size(); ++n)
      for (const FaultParameter parameter : candidate.numbers[n]) {
        const FaultParameterInfo& of = info(parameter);
        const auto k = static_cast<Index>(n);
        fault.parameters.push_back({std::string(of.name), value(k) / of.unit, sd(k) / of.unit});
      }
  }
  fault.sentence = sentence_of(model.members[place], fault.parameters);
  fault.separating_maneuver = separating_maneuver(candidate.name);
  return fault;
}

// Where the same parameter would stand twice, or what two members do is the same.
bool exclude_each_other(std::size_t a, std::size_t b) {
  if (fault_library()[a].name == fault_library()[b].name) return true;
  // To first order a lag of first order is a latency. One of all channels but the positions is another matter: some of
  // them may come late on top of it.
  const auto effect = [](FaultParameter parameter) {
    return parameter == velocity_filter ? velocity_latency : parameter == rate_filter ? rate_latency : parameter;
  };
  for (const std::size_t member : {a, b})
    for (const FaultParameter parameter : fault_library()[member].numbers[0])
      if (parameter == heading_filter) return false;
  for (const std::vector<FaultParameter>& of_a : fault_library()[a].numbers)
    for (const std::vector<FaultParameter>& of_b : fault_library()[b].numbers)
      for (const FaultParameter in_a : of_a)
        for (const FaultParameter in_b : of_b)
          if (effect(in_a) == effect(in_b)) return true;
  return false;
}

struct Search {
  const Fitter& fitter;
  const AuditOptions& options;

  std::vector<FaultModel> tried(const FaultModel& base) const {
    std::vector<std::size_t> candidates;
    for (std::size_t c = 0; c < fault_library().size(); ++c) {
      bool is_open = is_testable(c);
      for (const std::size_t member : base.members) is_open = is_open && !exclude_each_other(c, member);
      if (is_open) candidates.push_back(c);
    }
    std::vector<FaultModel> result(candidates.size());
    parallel_for(candidates.size(), options.jobs, [&](std::size_t i) { result[i] = fitter.with(base, candidates[i]); });
    return result;
  }

  bool is_testable(std::size_t candidate) const {
    // A factor on an r that is mostly noise shrinks the noise: its estimate is off by noise^2/signal^2.
    const KinematicWindows& windows = fitter.windows();
    if (fault_library()[candidate].numbers[0][0] == rate_scale &&
        windows.rate_noise() > kRateNoise * windows.rms_turned())
      return false;
    bool in_track = false, in_heading = false;
    for (const std::vector<FaultParameter>& number : fault_library()[candidate].numbers)
      for (const FaultParameter parameter : number) {
        in_track = in_track || info(parameter).in_track;
        in_heading = in_heading || info(parameter).in_heading;
      }
    const bool has_track = fitter.windows().windows(Kinematics::track) >= kFewestWindows;
    const bool has_heading = fitter.windows().windows(Kinematics::heading) >= kFewestWindows;
    // A candidate that shows in both is told from its rivals only where both are there.
    if (in_track && in_heading && fault_library()[candidate].numbers[0].size() > 1) return has_track && has_heading;
    return (in_track && has_track) || (in_heading && has_heading);
  }

  static const FaultCandidate& last(const FaultModel& model) { return fault_library()[model.members.back()]; }

  // The best of the tried: by held-out likelihood, of those that are significant if any is; of variants of one name the
  // simpler unless the other is clearly better.
  //   p  of each
  std::size_t best(const std::vector<FaultModel>& tried, const std::vector<double>& p) const {
    const auto worth = [&](std::size_t c) { return std::pair(p[c] < options.false_alarm, tried[c].heldout.sum()); };
    std::size_t best = 0;
    for (std::size_t c = 1; c < tried.size(); ++c)
      if (worth(c) > worth(best)) best = c;
    const auto is_clear = [](const Gain& gain) { return gain.is_certain() && gain.total > 2.0; };
    // Clocks are relative, so that one late channel can be told as the others being early: sensors are late.
    // Early positions stand for all others being late.
    const auto latency = [&](std::size_t c) {
      const FaultParameter first = last(tried[c]).numbers[0][0];
      const bool is_latency = first == velocity_latency || first == heading_latency || first == rate_latency;
      return is_latency ? tried[c].numbers(tried[c].numbers.size() - 1) : 0.0;
    };
    if (latency(best) < 0.0) {
      std::optional<std::size_t> late;
      for (std::size_t c = 0; c < tried.size(); ++c)
        if (latency(c) > 0.0 && worth(c).first == worth(best).first && !is_clear(heldout_gain(tried[best], tried[c])) &&
            (!late || tried[c].heldout.sum() > tried[*late].heldout.sum()))
          late = c;
      if (late) best = *late;
    }
    // A factor of the log, one number, stands before offsets, two, unless they are clearly better.
    if (last(tried[best]).name == "log-bias") {
      std::optional<std::size_t> factor;
      for (std::size_t c = 0; c < tried.size(); ++c)
        if (last(tried[c]).name == "log-scale" && worth(c).first == worth(best).first &&
            !is_clear(heldout_gain(tried[best], tried[c])) && (!factor || worth(c) > worth(*factor)))
          factor = c;
      if (factor) best = *factor;
    }
    for (std::size_t c = 0; c < best; ++c)
      if (last(tried[c]).name == last(tried[best]).name && worth(c).first == worth(best).first &&
          !is_clear(heldout_gain(tried[best], tried[c])))
        return c;
    return best;
  }

  // Where the p-value is a tenth of the rate, one standard error is enough.
  bool predicts_better(const FaultModel& with, const FaultModel& base, double p) const {
    return heldout_gain(with, base).is_certain(p < 0.1 * options.false_alarm ? 1.0 : 2.0);
  }
  bool is_found(const FaultModel& with, const FaultModel& base, double p) const {
    return p < options.false_alarm && predicts_better(with, base, p);
  }

  // Two faults can hide each other, as each is noise to the other: the last of `first` and one more, where each is
  // found beside the other.
  std::optional<FaultModel> pair_with(const FaultModel& first, std::size_t stage) const {
    const std::vector<FaultModel> pairs = tried(first);
    if (pairs.empty()) return std::nullopt;
    const std::vector<double> p =
        family_p_values(fitter, first, pairs, RandomStream(options.seed, "audit sign flips", 100 + stage));
    const std::size_t second = best(pairs, p);
    const FaultModel& pair = pairs[second];
    if (!is_found(pair, first, p[second])) return std::nullopt;
    const FaultModel other = fitter.without(pair, first.members.size() - 1);
    const std::vector<FaultModel> back = tried(other);
    const std::vector<double> p_back =
        family_p_values(fitter, other, back, RandomStream(options.seed, "audit sign flips", 200 + stage));
    for (std::size_t c = 0; c < back.size(); ++c)
      if (back[c].members.back() == first.members.back() && is_found(back[c], other, p_back[c])) return pair;
    return std::nullopt;
  }
};

void note_channels(const std::vector<Trajectory>& recordings, Audit& result) {
  for (const ChannelQuality& quality : result.channels) {
    const std::string_view name = info(quality.channel).name;
    if (quality.frozen_share > 0.0)
      result.notices.push_back(
          fmt::format("{} is frozen in {} of its samples although the ship moves ({}): they are left out", name,
                      percent(quality.frozen_share), fmt::join(quality.frozen_in, ", ")));
    if (quality.missing_share > 0.0)
      result.notices.push_back(fmt::format("{} lacks {} of its samples", name, percent(quality.missing_share)));
  }
  std::size_t without_track = 0, without_heading = 0;
  for (const Trajectory& recording : recordings) {
    if (!recording.has(Channel::psi))
      ++without_heading;
    else if (!recording.has(Channel::x0) || !recording.has(Channel::y0))
      ++without_track;
  }
  if (without_heading > 0)
    result.notices.push_back(fmt::format("{} of {} recordings have no heading: nothing could be checked there",
                                         without_heading, recordings.size()));
  if (without_track > 0)
    result.notices.push_back(
        fmt::format("{} of {} recordings have no positions: there only psi' - r could be checked; heading bias, lever "
                    "arm, faults of u and v_m, latencies of the velocities and a current stay unseen",
                    without_track, recordings.size()));
}

}  // namespace

Audit audit(const std::vector<Trajectory>& given, const AuditOptions& options) {
  Audit result;
  result.channels = channel_qualities(given);
  note_channels(given, result);
  std::vector<Trajectory> recordings;
  for (const Trajectory& recording : given) recordings.push_back(without_frozen(recording));

  const KinematicWindows windows(recordings, options.window_s);
  const bool has_track = windows.windows(Kinematics::track) >= kFewestWindows;
  const bool has_heading = windows.windows(Kinematics::heading) >= kFewestWindows;
  if ((!has_track && !has_heading) || windows.unit_count() < kFewestUnits) {
    result.notices.push_back(fmt::format(
        "too little to check the kinematics: {} windows of {:.0f} s with a track, {} with heading and yaw rate; {} are "
        "needed",
        windows.windows(Kinematics::track), windows.window_s(), windows.windows(Kinematics::heading), kFewestWindows));
    return result;
  }
  result.verdict = Audit::Verdict::consistent;
  if (!has_heading) result.notices.push_back("psi' - r could not be checked: too few windows");

  const Fitter fitter(windows);
  const Search search{fitter, options};
  FaultModel model = fitter.sound();
  const auto is_small = [&](const FaultModel& of, std::size_t place) {
    return by_smallest(fitter, of.members[place], fitter.own_numbers(of, place)) < 1.0;
  };
  for (std::size_t stage = 0, faults = 0, absorbed = 0; faults < kMostFaults && absorbed < kMostAbsorbed; ++stage) {
    const std::vector<FaultModel> tried = search.tried(model);
    if (tried.empty()) break;
    const std::vector<double> p =
        family_p_values(fitter, model, tried, RandomStream(options.seed, "audit sign flips", stage));
    if (stage == 0) {
      for (std::size_t c = 0; c < tried.size(); ++c) {
        Fault fault = fault_of(fitter, tried[c], 0, RandomStream(options.seed, "audit resampling", c));
        const Gain gain = heldout_gain(tried[c], model);
        fault.heldout_gain = gain.mean;
        fault.heldout_gain_sd = gain.sd;
        fault.p_value = p[c];
        result.hypotheses.push_back(std::move(fault));
      }
      std::stable_sort(result.hypotheses.begin(), result.hypotheses.end(),
                       [](const Fault& a, const Fault& b) { return a.heldout_gain > b.heldout_gain; });
    }
    const std::size_t best = search.best(tried, p), before = model.members.size();
    if (search.is_found(tried[best], model, p[best])) {
      model = tried[best];
    } else if (const std::optional<FaultModel> pair = search.pair_with(tried[best], stage)) {
      model = *pair;
    } else {
      break;
    }
    // What is real but too small to matter stays in the model, so that it does not feign another fault.
    for (std::size_t m = before; m < model.members.size(); ++m) ++(is_small(model, m) ? absorbed : faults);
  }

  // A first choice can be a mixture of two faults: each member has to hold its place against all others.
  for (int round = 0; round < 3; ++round) {
    bool has_changed = false;
    for (std::size_t m = 0; m < model.members.size() && model.members.size() > 1; ++m) {
      const FaultModel base = fitter.without(model, m);
      const std::vector<FaultModel> tried = search.tried(base);
      const std::vector<double> p =
          family_p_values(fitter, base, tried, RandomStream(options.seed, "audit sign flips", 1000 + m));
      const std::size_t first = search.best(tried, p);
      const FaultModel& best = tried[first];
      if (!search.predicts_better(best, base, p[first])) {
        model = base;
        has_changed = true;
        break;
      }
      if (best.members.back() == model.members[m]) continue;
      model = best;
      has_changed = true;
      break;
    }
    if (!has_changed) break;
  }

  for (std::size_t m = 0; m < model.members.size(); ++m) {
    const FaultModel base = fitter.without(model, m);
    std::vector<FaultModel> tried = search.tried(base);
    const auto is_own = [&](const FaultModel& of) { return of.members.back() == model.members[m]; };
    if (std::none_of(tried.begin(), tried.end(), is_own)) tried.push_back(fitter.with(base, model.members[m]));
    const std::vector<double> p =
        family_p_values(fitter, base, tried, RandomStream(options.seed, "audit sign flips", 1000 + m));
    Fault fault = fault_of(fitter, model, m, RandomStream(options.seed, "audit resampling", 1000 + m));
    const Gain gain = heldout_gain(model, base);
    fault.heldout_gain = gain.mean;
    fault.heldout_gain_sd = gain.sd;
    for (std::size_t c = 0; c < tried.size(); ++c)
      if (is_own(tried[c])) fault.p_value = p[c] < options.false_alarm ? p[c] : chance_of(gain, windows.unit_count());
    if (is_small(model, m)) {
      result.notices.push_back(fault.sentence + ": too little to matter");
      continue;
    }
    std::set<std::string> rivals;
    for (std::size_t c = 0; c < tried.size(); ++c) {
      if (Search::last(tried[c]).name == fault.name || !heldout_gain(tried[c], base).is_certain() ||
          heldout_gain(model, tried[c]).is_certain())
        continue;
      Fault rival = fault_of(fitter, tried[c], tried[c].members.size() - 1,
                             RandomStream(options.seed, "audit resampling", 2000 + 100 * m + c));
      const Gain own = heldout_gain(tried[c], base);
      rival.heldout_gain = own.mean;
      rival.heldout_gain_sd = own.sd;
      rival.p_value = p[c];
      rival.log_odds = heldout_gain(tried[c], model).total;
      rivals.insert(rival.name);
      fault.rivals.push_back(std::move(rival));
    }
    std::stable_sort(fault.rivals.begin(), fault.rivals.end(),
                     [](const Fault& a, const Fault& b) { return a.log_odds > b.log_odds; });
    if (!rivals.empty())
      result.notices.push_back(
          fmt::format("{} fits best, but {} {} almost as well: these recordings do not tell them apart", fault.name,
                      fmt::join(rivals, ", "), rivals.size() == 1 ? "fits" : "fit"));
    result.faults.push_back(std::move(fault));
  }
  std::stable_sort(result.faults.begin(), result.faults.end(),
                   [](const Fault& a, const Fault& b) { return a.heldout_gain > b.heldout_gain; });
  if (!result.faults.empty()) result.verdict = Audit::Verdict::faulty;
  for (const Fault& fault : result.faults)
    if (fault.name == "steady-current") result.log_through_water = true;
  if (has_track)
    result.notices.push_back(
        "not visible here: a heading bias where u and v_m were turned by that heading, and a lever arm that positions "
        "and velocities share");
  return result;
}

void retell(Fault& fault) {
  for (std::size_t c = 0; c < fault_library().size(); ++c) {
    std::vector<std::string_view> names;
    for (const std::vector<FaultParameter>& number : fault_library()[c].numbers)
      for (const FaultParameter parameter : number) names.push_back(info(parameter).name);
    if (fault_library()[c].name == fault.name &&
        std::equal(names.begin(), names.end(), fault.parameters.begin(), fault.parameters.end(),
                   [](std::string_view name, const Estimate& e) { return name == e.name; }))
      fault.sentence = sentence_of(c, fault.parameters);
  }
}

Trajectory corrected(const Trajectory& recording, const std::vector<Fault>& faults) {
  const SensorFaults fault = sensor_faults(faults);
  Trajectory result = recording;
  const std::vector<double>& t = recording[Channel::t];
  const double hole_s = std::max(3.5 * sampling_time(recording), 1.0);

  // A channel at t + latency_s. A lag of first order is undone as a latency: exact but for a bend, where the inverse of
  // the filter would make every glitch of the sensor several times as large.
  const auto read = [&](Channel channel, double latency_s) {
    if (!recording.has(channel) || latency_s == 0.0) return recording[channel];
    const Spline spline(t, recording[channel]);
    std::vector<double> values(t.size(), kMissing);
    if (spline.empty()) return values;
    std::size_t place = 0;
    for (std::size_t k = 0; k < t.size(); ++k) {
      const double then = t[k] + latency_s;
      if (spline.gap(then, place) <= hole_s) values[k] = spline.value(then, place);
    }
    return values;
  };
  result[Channel::psi] = read(Channel::psi, fault[heading_latency]);
  result[Channel::u] = read(Channel::u, fault[velocity_latency] + fault[velocity_filter]);
  result[Channel::vm] = read(Channel::vm, fault[velocity_latency] + fault[velocity_filter]);
  result[Channel::r] = read(Channel::r, fault[rate_latency] + fault[rate_filter]);
  result[Channel::x0] = read(Channel::x0, fault[position_latency]);
  result[Channel::y0] = read(Channel::y0, fault[position_latency]);

  // The recorded r is the slope of a heading behind the same lag.
  if (fault[heading_filter] != 0.0 && recording.has(Channel::psi)) {
    const std::vector<double> slope = read(Channel::r, fault[rate_latency]);
    for (std::size_t k = 0; k < t.size(); ++k) result[Channel::psi][k] += fault[heading_filter] * slope[k];
  }
  for (double& psi : result[Channel::psi]) psi -= fault[heading_bias];
  for (double& u : result[Channel::u]) u = (u - fault[log_bias_u]) / (1.0 + fault[log_scale]);
  for (double& v : result[Channel::vm]) v = (v - fault[log_bias_v]) / (1.0 + fault[sway_log_scale]);
  for (double& r : result[Channel::r]) r = (r - fault[rate_bias]) / (1.0 + fault[rate_scale]);
  if (!recording.has(Channel::psi)) return result;
  const bool has_current = fault[current_x] != 0.0 || fault[current_y] != 0.0;
  const bool has_lever = fault[lever_x] != 0.0 || fault[lever_y] != 0.0;
  for (std::size_t k = 0; k < t.size(); ++k) {
    const double c = std::cos(result[Channel::psi][k]), s = std::sin(result[Channel::psi][k]);
    if (has_current && recording.has(Channel::u) && recording.has(Channel::vm)) {
      result[Channel::u][k] += c * fault[current_x] + s * fault[current_y];
      result[Channel::vm][k] += -s * fault[current_x] + c * fault[current_y];
    }
    if (has_lever && recording.has(Channel::x0) && recording.has(Channel::y0)) {
      result[Channel::x0][k] -= c * fault[lever_x] - s * fault[lever_y];
      result[Channel::y0][k] -= s * fault[lever_x] + c * fault[lever_y];
    }
  }
  return result;
}

}  // namespace leeway::gap
