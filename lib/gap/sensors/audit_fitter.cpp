#include "gap/sensors/audit_fitter.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/linear_algebra.hpp"
#include "core/statistics.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using enum FaultParameter;

double huber(double z) {
  const double a = std::abs(z);
  return a <= kPolicy.sensors.huber ? 0.5 * z * z : kPolicy.sensors.huber * (a - 0.5 * kPolicy.sensors.huber);
}

// Makes the rows of a run white, of unit variance; `log_sd` receives the logarithm of what each row was divided by.
template <typename Rows>
void whiten(const WindowNoise& noise, Rows rows, VectorXd* log_sd) {
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
    if (log_sd) (*log_sd)(k) = std::log(noise.sd) + 0.5 * std::log(d);
  }
  if (rho >= 0.0) {
    for (Index k = rows.rows() - 1; k > 0; --k)
      rows.row(k) = (rows.row(k) - rho * rows.row(k - 1)) / (noise.sd * std::sqrt(1.0 - rho * rho));
    if (rows.rows() > 0) rows.row(0) /= noise.sd;
  }
}

}  // namespace

void NormalEquations::add(const Eigen::Ref<const VectorXd>& j, double z, double weight) {
  A += weight * j * j.transpose();
  b += weight * z * j;
}

NormalEquations& NormalEquations::operator+=(const NormalEquations& other) {
  A += other.A;
  b += other.b;
  return *this;
}

NormalEquations& NormalEquations::operator-=(const NormalEquations& other) {
  A -= other.A;
  b -= other.b;
  return *this;
}

FaultFitter::FaultFitter(const KinematicWindows& windows)
    : windows_(windows), unit_of_row_(static_cast<std::size_t>(windows.rows())) {
  for (const WindowRun& run : windows.runs())
    for (Index k = 0; k < run.size; ++k) unit_of_row_[static_cast<std::size_t>(run.begin + k)] = run.unit;
}

FaultFit FaultFitter::sound() const {
  FaultFit fit;
  fit.numbers.resize(0);
  fit.residuals = windows_.residuals({});
  fit.sensitivities.resize(windows_.rows(), 0);
  fit.noise = estimate_noise(fit.residuals, 0);
  predict_left_out(fit);
  return fit;
}

FaultFit FaultFitter::with(const FaultFit& base, std::size_t candidate) const {
  FaultFit start = base;
  start.members.push_back(candidate);
  const std::vector<std::vector<FaultParameter>>& numbers = fault_library()[candidate].numbers;
  const Index old = base.numbers.size(), size = old + static_cast<Index>(numbers.size());
  start.numbers.conservativeResize(size);
  start.numbers.tail(size - old).setZero();
  if (info(numbers[0][0]).quantity != Quantity::time) return fitted(start);

  const bool is_lag = numbers[0][0] == velocity_filter;
  const double longest = windows_.longest_latency_s();
  FaultFit best = start;
  double least = std::numeric_limits<double>::infinity();
  for (const double share : kPolicy.sensors.start_latencies) {
    if (is_lag && share < 0.0) continue;
    start.numbers(old) = share * longest;
    const double cost = cost_of(windows_.residuals(faults_of(start)), start, base.noise);
    if (cost < least) {
      least = cost;
      best.numbers = start.numbers;
    }
  }
  return fitted(best);
}

FaultFit FaultFitter::without(const FaultFit& base, std::size_t place) const {
  FaultFit start = base;
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

Index FaultFitter::size_of(std::size_t member) { return static_cast<Index>(fault_library()[member].numbers.size()); }

VectorXd FaultFitter::own_numbers(const FaultFit& fit, std::size_t place) const {
  Index begin = 0;
  for (std::size_t m = 0; m < place; ++m) begin += size_of(fit.members[m]);
  return fit.numbers.segment(begin, size_of(fit.members[place]));
}

VectorXd FaultFitter::prior_precision(const std::vector<std::size_t>& members) const {
  std::vector<double> precision;
  for (const std::size_t member : members)
    for (const std::vector<FaultParameter>& number : fault_library()[member].numbers)
      precision.push_back(1.0 / std::pow(info(number[0]).prior_sd, 2));
  return Eigen::Map<VectorXd>(precision.data(), static_cast<Index>(precision.size()));
}

WhitenedRows FaultFitter::whitened(const FaultFit& fit, const KinematicNoise& noise) const {
  WhitenedRows rows{fit.residuals, VectorXd::Ones(windows_.rows()), VectorXd::Zero(windows_.rows()), fit.sensitivities};
  for (const WindowRun& run : windows_.runs()) {
    const WindowNoise& of = noise[static_cast<std::size_t>(run.kind)];
    VectorXd log_sd(run.size);
    whiten(of, rows.z.segment(run.begin, run.size), &log_sd);
    whiten(of, rows.J.middleRows(run.begin, run.size), nullptr);
    rows.log_sd.segment(run.begin, run.size) = log_sd;
  }
  for (Index k = 0; k < rows.z.size(); ++k)
    rows.weights(k) = std::min(1.0, kPolicy.sensors.huber / std::abs(rows.z(k)));
  return rows;
}

std::vector<NormalEquations> FaultFitter::normals_by_unit(const WhitenedRows& rows) const {
  std::vector<NormalEquations> result(windows_.unit_count(), NormalEquations(rows.J.cols()));
  for (Index k = 0; k < rows.z.size(); ++k) result[unit(k)].add(rows.J.row(k).transpose(), rows.z(k), rows.weights(k));
  return result;
}

VectorXd FaultFitter::resampled_sd(const FaultFit& fit, RandomStream stream,
                                   const std::function<VectorXd(const VectorXd&)>& derive) const {
  const std::vector<NormalEquations> of_unit = normals_by_unit(whitened(fit, fit.noise));
  const std::size_t units = of_unit.size();
  const VectorXd center = derive(fit.numbers);
  VectorXd sum = VectorXd::Zero(center.size()), squares = sum;
  for (std::size_t draw = 0; draw < kPolicy.sensors.resamples; ++draw) {
    NormalEquations total(fit.numbers.size());
    total.A.diagonal() += prior_precision(fit.members);
    for (std::size_t g = 0; g < units; ++g) total += of_unit[stream.below(units)];
    const VectorXd drawn = derive(fit.numbers - total.A.ldlt().solve(total.b)) - center;
    sum += drawn;
    squares += drawn.cwiseAbs2();
  }
  const double n = static_cast<double>(kPolicy.sensors.resamples), G = static_cast<double>(units);
  const VectorXd resampled = (squares / n - (sum / n).cwiseAbs2()).cwiseMax(0.0) * G / (G - 1.0);
  // Few units look more alike than they are: no less than what the noise alone would leave.
  NormalEquations all(fit.numbers.size());
  all.A.diagonal() += prior_precision(fit.members);
  for (const NormalEquations& normal : of_unit) all += normal;
  const MatrixXd covariance = all.A.inverse();
  MatrixXd slope(center.size(), fit.numbers.size());
  for (Index k = 0; k < fit.numbers.size(); ++k) {
    VectorXd moved = fit.numbers;
    const double step = kPolicy.sensors.difference_sd * std::sqrt(covariance(k, k));
    moved(k) += step;
    slope.col(k) = (derive(moved) - center) / step;
  }
  return resampled.cwiseMax((slope * covariance * slope.transpose()).diagonal()).cwiseSqrt();
}

// The correlation of neighbors, from residuals that are limited to few standard deviations.
double FaultFitter::correlation(Kinematics kind, const VectorXd& residuals, double n, double rough_sd) const {
  double products = 0.0, squares = 0.0, pairs = 0.0;
  const auto limited = [&](Index row) {
    return std::clamp(residuals(row), -kPolicy.sensors.limited_sd * rough_sd, kPolicy.sensors.limited_sd * rough_sd);
  };
  for (const WindowRun& run : windows_.runs())
    if (run.kind == kind)
      for (Index k = 0; k < run.size; ++k) {
        squares += std::pow(limited(run.begin + k), 2);
        if (k + 1 < run.size) products += limited(run.begin + k) * limited(run.begin + k + 1), pairs += 1.0;
      }
  if (!(pairs > 0.0 && squares > 0.0)) return 0.0;
  return std::clamp(products / pairs / (squares / n) * n / (n + kPolicy.sensors.shrinking_pairs),
                    kPolicy.sensors.least_rho, kPolicy.sensors.most_rho);
}

// Huber's second proposal: the level at which the limited squares have their expectation.
double FaultFitter::huber_level(Kinematics kind, VectorXd residuals, double rho, double freedom,
                                double rough_sd) const {
  const double least =
      kind == Kinematics::track ? kPolicy.sensors.least_track_noise_m : kPolicy.sensors.least_heading_noise_rad;
  for (const WindowRun& run : windows_.runs())
    if (run.kind == kind) whiten({1.0, rho}, residuals.segment(run.begin, run.size), nullptr);
  double sd = rough_sd;
  for (int i = 0; i < kPolicy.sensors.level_rounds; ++i) {
    double sum = 0.0;
    for (const WindowRun& run : windows_.runs())
      if (run.kind == kind)
        for (Index k = 0; k < run.size; ++k)
          sum += std::min(std::pow(residuals(run.begin + k), 2), std::pow(kPolicy.sensors.huber * sd, 2));
    sd = std::max(least, std::sqrt(sum / (freedom * kPolicy.sensors.huber_variance)));
  }
  return sd;
}

WindowNoise FaultFitter::estimate_noise(Kinematics kind, const VectorXd& residuals, Index parameters) const {
  const double least =
      kind == Kinematics::track ? kPolicy.sensors.least_track_noise_m : kPolicy.sensors.least_heading_noise_rad;
  std::vector<double> sizes;
  for (const WindowRun& run : windows_.runs())
    if (run.kind == kind)
      for (Index k = 0; k < run.size; ++k) sizes.push_back(residuals(run.begin + k));
  if (sizes.empty()) return {};
  const double n = static_cast<double>(sizes.size());
  const double rough_sd = std::max(robust_sd(std::move(sizes)), least);
  const double freedom = std::max(1.0, n - static_cast<double>(parameters));
  WindowNoise noise;
  noise.rho = correlation(kind, residuals, n, rough_sd);
  noise.sd = huber_level(kind, residuals, noise.rho, freedom, rough_sd);
  return noise;
}

KinematicNoise FaultFitter::estimate_noise(const VectorXd& residuals, Index parameters) const {
  return {estimate_noise(Kinematics::track, residuals, parameters),
          estimate_noise(Kinematics::heading, residuals, parameters)};
}

double FaultFitter::cost_of(VectorXd residuals, const FaultFit& of, const KinematicNoise& noise) const {
  double cost = 0.5 * of.numbers.cwiseAbs2().dot(prior_precision(of.members));
  for (const WindowRun& run : windows_.runs()) {
    whiten(noise[static_cast<std::size_t>(run.kind)], residuals.segment(run.begin, run.size), nullptr);
    for (Index k = 0; k < run.size; ++k) cost += huber(residuals(run.begin + k));
  }
  return cost;
}

SensorFaults FaultFitter::faults_of(const FaultFit& fit) const {
  SensorFaults faults;
  Index k = 0;
  for (const std::size_t member : fit.members)
    for (const std::vector<FaultParameter>& number : fault_library()[member].numbers) {
      for (const FaultParameter parameter : number) faults[parameter] += fit.numbers(k);
      ++k;
    }
  return faults;
}

// The mean slope of the residuals along one number of a fit, between two of its values.
VectorXd FaultFitter::chord(const FaultFit& fit, Index column, const std::vector<FaultParameter>& number, double from,
                            double to) const {
  bool in_track = false, in_heading = false;
  for (const FaultParameter parameter : number) {
    in_track = in_track || info(parameter).in_track;
    in_heading = in_heading || info(parameter).in_heading;
  }
  FaultFit moved;
  moved.members = fit.members;
  moved.numbers = fit.numbers;
  const auto at = [&](double value) {
    moved.numbers(column) = value;
    const SensorFaults faults = faults_of(moved);
    VectorXd residuals = fit.residuals;
    if (in_track) windows_.update(Kinematics::track, faults, residuals);
    if (in_heading) windows_.update(Kinematics::heading, faults, residuals);
    return residuals;
  };
  return (at(to) - (from == fit.numbers(column) ? fit.residuals : at(from))) / (to - from);
}

MatrixXd FaultFitter::sensitivities(const FaultFit& fit) const {
  MatrixXd result(windows_.rows(), fit.numbers.size());
  Index column = 0;
  for (const std::size_t member : fit.members)
    for (const std::vector<FaultParameter>& number : fault_library()[member].numbers) {
      const double value = fit.numbers(column);
      const double step = kPolicy.sensors.difference_prior_sd * info(number[0]).prior_sd;
      result.col(column) = chord(fit, column, number, value, value + step);
      ++column;
    }
  return result;
}

MatrixXd FaultFitter::actions_of_last(const FaultFit& fit) const {
  const std::vector<std::vector<FaultParameter>>& numbers = fault_library()[fit.members.back()].numbers;
  MatrixXd result = fit.sensitivities.rightCols(static_cast<Index>(numbers.size()));
  for (Index i = 0; i < result.cols(); ++i) {
    const std::vector<FaultParameter>& number = numbers[static_cast<std::size_t>(i)];
    const Index column = fit.numbers.size() - result.cols() + i;
    const double value = fit.numbers(column);
    if (info(number[0]).quantity == Quantity::time && value != 0.0)
      result.col(i) = chord(fit, column, number, -value, value);
  }
  return result;
}

// Keeps latencies and lags where the windows know the channels.
void FaultFitter::limit(FaultFit& fit) const {
  Index k = 0;
  for (const std::size_t member : fit.members)
    for (const std::vector<FaultParameter>& number : fault_library()[member].numbers) {
      const double longest = windows_.longest_latency_s();
      if (number[0] == velocity_filter)
        fit.numbers(k) = std::clamp(fit.numbers(k), 0.0, longest);
      else if (info(number[0]).quantity == Quantity::time)
        fit.numbers(k) = std::clamp(fit.numbers(k), -longest, longest);
      ++k;
    }
}

// One step of Gauss-Newton, halved until the cost falls; false where the fit has converged.
bool FaultFitter::step(FaultFit& fit) const {
  fit.noise = estimate_noise(fit.residuals, fit.numbers.size());
  fit.sensitivities = sensitivities(fit);
  NormalEquations total(fit.numbers.size());
  for (const NormalEquations& normal : normals_by_unit(whitened(fit, fit.noise))) total += normal;
  const VectorXd precision = prior_precision(fit.members);
  total.A.diagonal() += precision;
  total.b += precision.cwiseProduct(fit.numbers);
  const VectorXd full = total.A.ldlt().solve(total.b);
  const double before = cost_of(fit.residuals, fit, fit.noise);
  FaultFit next = fit;
  bool is_better = false;
  for (double share = 1.0; share > kPolicy.sensors.least_share_of_step && !is_better; share *= 0.5) {
    next.numbers = fit.numbers - share * full;
    limit(next);
    next.residuals = windows_.residuals(faults_of(next));
    is_better = cost_of(next.residuals, next, fit.noise) <= before;
  }
  if (!is_better) return false;
  const VectorXd moved = next.numbers - fit.numbers;
  fit = std::move(next);
  return !(moved.dot(total.A * moved) < kPolicy.sensors.fit_converged);
}

FaultFit FaultFitter::fitted(FaultFit fit) const {
  fit.residuals = windows_.residuals(faults_of(fit));
  for (int i = 0; i < kPolicy.sensors.fit_steps; ++i)
    if (!step(fit)) break;
  fit.noise = estimate_noise(fit.residuals, fit.numbers.size());
  fit.sensitivities = sensitivities(fit);
  predict_left_out(fit);
  return fit;
}

// What a factor of a sensor that is undone makes of the noise of its channel, in each row: where that is all the noise
// there is, residuals shrink by as much, and a likelihood of residuals has to pay for it. (Where the noise is of
// positions, a factor above 1 shrinks nothing; the dearer of both counts.)
std::array<double, 2> FaultFitter::log_shrinking(const FaultFit& fit) const {
  const SensorFaults faults = faults_of(fit);
  const auto of = [&](FaultParameter factor) { return std::log1p(std::max(0.0, faults[factor])); };
  return {0.5 * (of(FaultParameter::log_scale) + of(sway_log_scale)), of(rate_scale)};
}

// The log-likelihood of each unit by the fit to the others. Of the neighbors of a block, the windows at its border
// are left out as well.
void FaultFitter::predict_left_out(FaultFit& fit) const {
  const std::array<double, 2> shrinking = log_shrinking(fit);
  const WhitenedRows rows = whitened(fit, fit.noise);
  const Index size = fit.numbers.size();
  const std::size_t units = windows_.unit_count();
  const NormalEquations none(size);
  std::vector<NormalEquations> of_unit(units, none), of_first(units, none), of_last(units, none);
  for (const WindowRun& run : windows_.runs())
    for (Index k = 0; k < run.size; ++k) {
      const Index row = run.begin + k;
      const VectorXd j = rows.J.row(row).transpose();
      of_unit[run.unit].add(j, rows.z(row), rows.weights(row));
      if (run.is_first_of_unit && k == 0) of_first[run.unit].add(j, rows.z(row), rows.weights(row));
      if (run.is_last_of_unit && k + 1 == run.size) of_last[run.unit].add(j, rows.z(row), rows.weights(row));
    }
  NormalEquations all(size);
  for (const NormalEquations& normal : of_unit) all += normal;
  all.A.diagonal() += prior_precision(fit.members);
  all.b += prior_precision(fit.members).cwiseProduct(fit.numbers);
  std::vector<VectorXd> moved(units, VectorXd::Zero(size));
  for (std::size_t g = 0; g < units && size > 0; ++g) {
    NormalEquations rest = all;
    rest -= of_unit[g];
    if (g > 0 && windows_.recording_of(g - 1) == windows_.recording_of(g)) rest -= of_last[g - 1];
    if (g + 1 < units && windows_.recording_of(g + 1) == windows_.recording_of(g)) rest -= of_first[g + 1];
    moved[g] = -rest.A.ldlt().solve(rest.b);
  }
  fit.heldout = VectorXd::Zero(static_cast<Index>(units));
  for (const WindowRun& run : windows_.runs())
    for (Index row = run.begin; row < run.begin + run.size; ++row) {
      const double z = rows.z(row) + (size > 0 ? rows.J.row(row).dot(moved[run.unit]) : 0.0);
      fit.heldout(static_cast<Index>(run.unit)) -=
          huber(z) + rows.log_sd(row) + shrinking[static_cast<std::size_t>(run.kind)];
    }
}

}  // namespace leeway::gap
