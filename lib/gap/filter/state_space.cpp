#include "gap/filter/state_space.hpp"

#include <algorithm>
#include <cmath>

#include "core/linear_algebra.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {
namespace {

// Columns that a filter moves at a time: two AVX vectors.
constexpr int kWidth = 8;

}  // namespace

Evidence& Evidence::operator+=(const Evidence& other) {
  log_likelihood += other.log_likelihood;
  b += other.b;
  F += other.F;
  measurements += other.measurements;
  return *this;
}

Filter::Filter(const LinearStretch& stretch, const Noise& noise, Eigen::Index count)
    : mean(StateVector::Zero()),
      covariance(StateMatrix::Zero()),
      columns(Columns::Zero(kStates, count)),
      stretch_(stretch),
      noise_(noise),
      wind_sd_(noise.wind_share * stretch.data->wind_speed_mps),
      rows_(kShipStates, count) {
  const StateVector& x = stretch.path.front();
  mean.tail<kStates - kErrorStart>() = -x.tail<kStates - kErrorStart>();
  covariance.diagonal().head<kShipStates>() = stretch.initial_sd.array().square();
  covariance.diagonal().segment<3>(kErrorStart) = sigma_w(0).array().square();
  covariance.block<3, 3>(kErrorStart, kErrorStart) += spread(0);
  covariance.diagonal().tail<2>().setConstant(wind_sd_ * wind_sd_);
}

Vec3<double> Filter::sigma_w(std::size_t k) const {
  if (!noise_.knows_events || stretch_.event_scale.empty()) return noise_.sigma_w;
  return noise_.sigma_w.cwiseProduct(stretch_.event_scale[k]);
}

// Beyond the training data members may agree without knowing: a tenth of an input's range outside they know nothing.
Mat3<double> Filter::spread(std::size_t k) const {
  if (!noise_.knows_spread) return Mat3<double>::Zero();
  const LinearStep& step = stretch_.steps[k];
  Mat3<double> result = step.spread;
  result.diagonal() += (std::min(step.beyond, 1.0) * stretch_.untrained_sd).cwiseAbs2();
  return result;
}

StateMatrix Filter::transition(std::size_t k) const {
  const double dt = stretch_.data->dt_s(k);
  StateMatrix A = StateMatrix::Zero();
  A.topRows<kShipStates>() = stretch_.steps[k].A;
  A.diagonal().segment<3>(kErrorStart).setConstant(std::exp(-dt / noise_.tau_s));
  A.diagonal().tail<2>().setConstant(std::exp(-dt / noise_.wind_tau_s));
  return A;
}

void Filter::predict(std::size_t k) {
  const StateMatrix A = transition(k);
  StateVector offset;
  offset.head<kShipStates>() = stretch_.steps[k].offset;
  for (int i = kErrorStart; i < kStates; ++i) offset[i] = A(i, i) * stretch_.path[k][i] - stretch_.path[k + 1][i];
  mean = A * mean + offset;
  // A is full in its upper rows and diagonal below. Lazy products: for matrices this small, blocking costs more than it
  // saves.
  const Eigen::Matrix<double, kShipStates, kStates>& upper = stretch_.steps[k].A;
  constexpr int kErrors = kStates - kErrorStart;
  const Eigen::Matrix<double, kErrors, 1> decay = A.diagonal().tail<kErrors>();
  const Eigen::Matrix<double, kShipStates, kStates> moved = upper.lazyProduct(covariance);
  auto ship = covariance.topLeftCorner<kShipStates, kShipStates>();
  ship = moved.lazyProduct(upper.transpose());
  // Symmetric to the last bit: no measurement takes from the difference of the halves, which grows with what is
  // unstable.
  ship.triangularView<Eigen::StrictlyUpper>() = ship.transpose();
  covariance.topRightCorner<kShipStates, kErrors>() = moved.rightCols<kErrors>() * decay.asDiagonal();
  covariance.bottomLeftCorner<kErrors, kShipStates>() = covariance.topRightCorner<kShipStates, kErrors>().transpose();
  covariance.bottomRightCorner<kErrors, kErrors>().array() *= (decay * decay.transpose()).array();
  const Vec3<double> sigma = sigma_w(k + 1);
  for (int i = 0; i < 3; ++i)
    covariance(kErrorStart + i, kErrorStart + i) +=
        sigma[i] * sigma[i] * (1.0 - A(kErrorStart + i, kErrorStart + i) * A(kErrorStart + i, kErrorStart + i));
  covariance.block<3, 3>(kErrorStart, kErrorStart) += (1.0 - decay[0] * decay[0]) * spread(k);
  for (int i = kWindStart; i < kStates; ++i) covariance(i, i) += wind_sd_ * wind_sd_ * (1.0 - A(i, i) * A(i, i));
  const Vec6 timing = noise_.timing_sd * stretch_.steps[k].G.rightCols<1>();
  ship += timing * timing.transpose();
  covariance.diagonal().array() += kPolicy.filter.tiny;
  Eigen::Index first = 0;
  for (; first + kWidth <= columns.cols(); first += kWidth) move_columns<kWidth>(upper, first);
  for (; first < columns.cols(); ++first) move_columns<1>(upper, first);
  for (int i = kErrorStart; i < kStates; ++i) columns.row(i) *= A(i, i);
}

template <int width>
void Filter::move_columns(const Eigen::Matrix<double, kShipStates, kStates>& A, Eigen::Index first) {
  Eigen::Array<double, width, 1> in[kStates];
  for (int j = 0; j < kStates; ++j) in[j] = columns.block<1, width>(j, first).transpose();
  for (int i = 0; i < kShipStates; ++i) {
    Eigen::Array<double, width, 1> out = A(i, 0) * in[0];
    for (int j = 1; j < kStates; ++j) out += A(i, j) * in[j];
    columns.block<1, width>(i, first) = out.transpose();
  }
}

template <int width>
void Filter::take_columns(int count, Eigen::Index first) {
  Eigen::Array<double, width, 1> x[kStates];
  for (int j = 0; j < kStates; ++j) x[j] = columns.block<1, width>(j, first).transpose();
  for (int t = 0; t < count; ++t) {
    const Taken& taken = taken_[static_cast<std::size_t>(t)];
    const Eigen::Array<double, width, 1> row = x[taken.channel] * taken.per_root;
    rows_.block<1, width>(t, first) = row.transpose();
    for (int j = 0; j < kStates; ++j) x[j] -= taken.gain[j] * row;
  }
  for (int j = 0; j < kStates; ++j) columns.block<1, width>(j, first) = x[j].transpose();
}

void Filter::take_columns(int count) {
  Eigen::Index first = 0;
  for (; first + kWidth <= columns.cols(); first += kWidth) take_columns<kWidth>(count, first);
  for (; first < columns.cols(); ++first) take_columns<1>(count, first);
}

std::vector<Evidence> evidence_by_blocks(const LinearStretch& stretch, const Noise& noise, std::size_t block_points,
                                         Eigen::Index count, const MoreColumns& more, const MeasuredColumns& measured) {
  const Eigen::Index p = stretch.steps.front().G.cols(), columns = p + count + measured.count;
  const std::size_t n = stretch.path.size();
  std::vector<Evidence> blocks((n + block_points - 1) / block_points, Evidence(columns));
  Filter filter(stretch, noise, columns);
  // Rows are gathered, so that F grows by matrix products.
  constexpr Eigen::Index kRows = 96;
  ByRow<Eigen::Dynamic> rows(kRows, columns);
  Eigen::VectorXd innovations(kRows);
  Eigen::Index filled = 0;
  const auto flush = [&](Evidence& block) {
    if (filled == 0) return;  // where measurements are a multiple of kRows; Eigen divides by this
    block.F.selfadjointView<Eigen::Lower>().rankUpdate(rows.topRows(filled).transpose());
    block.b.noalias() += rows.topRows(filled).transpose() * innovations.head(filled);
    filled = 0;
  };
  Eigen::MatrixXd addition(kShipStates, count), measured_addition(kShipStates, measured.count);
  for (std::size_t k = 0; k < n; ++k) {
    Evidence& block = blocks[k / block_points];
    if (k > 0) {
      filter.predict(k - 1);
      filter.columns.topLeftCorner(kShipStates, p) += stretch.steps[k - 1].G;
      if (count > 0) {
        more(k - 1, addition);
        filter.columns.block(0, p, kShipStates, count) += addition;
      }
    }
    // To a measurement, what its sensor adds is as if the ship were there.
    if (measured.count > 0) {
      measured.of(k, measured_addition);
      filter.columns.topRightCorner(kShipStates, measured.count) += measured_addition;
    }
    filter.update(k, [&](int, double z, const auto& row, double S) {
      block.log_likelihood -= 0.5 * (z * z + std::log(2.0 * kPi * S));
      ++block.measurements;
      rows.row(filled) = row;
      innovations[filled] = z;
      if (++filled == kRows) flush(block);
    });
    if (measured.count > 0) filter.columns.topRightCorner(kShipStates, measured.count) -= measured_addition;
    if (k + 1 == n || (k + 1) % block_points == 0) flush(block);
  }
  for (Evidence& block : blocks) block.F.triangularView<Eigen::StrictlyUpper>() = block.F.transpose();
  return blocks;
}

Evidence evidence(const LinearStretch& stretch, const Noise& noise, Eigen::Index count, const MoreColumns& more,
                  const MeasuredColumns& measured) {
  return evidence_by_blocks(stretch, noise, stretch.path.size(), count, more, measured).front();
}

Smoothed smooth(const LinearStretch& stretch, const Noise& noise, const Eigen::VectorXd& dtheta) {
  const std::size_t n = stretch.path.size();
  Smoothed result;
  result.state.resize(n);
  result.covariance.resize(n);
  result.innovations.assign(n, Vec6::Constant(kMissing));
  std::vector<StateVector> predicted(n), filtered(n);
  std::vector<StateMatrix> predicted_covariance(n), filtered_covariance(n);
  Filter filter(stretch, noise, 0);
  for (std::size_t k = 0; k < n; ++k) {
    if (k > 0) {
      filter.predict(k - 1);
      filter.mean.head<kShipStates>() += stretch.steps[k - 1].G * dtheta;
    }
    predicted[k] = filter.mean;
    predicted_covariance[k] = filter.covariance;
    filter.update(k, [&](int i, double z, const auto&, double) { result.innovations[k][i] = z; });
    filtered[k] = filter.mean;
    filtered_covariance[k] = filter.covariance;
  }
  // Rauch, Tung & Striebel (1965).
  result.state[n - 1] = filtered[n - 1];
  result.covariance[n - 1] = filtered_covariance[n - 1];
  for (std::size_t k = n - 1; k-- > 0;) {
    const StateMatrix A = filter.transition(k);
    const StateMatrix C = predicted_covariance[k + 1].ldlt().solve(A * filtered_covariance[k]).transpose();
    result.state[k] = filtered[k] + C * (result.state[k + 1] - predicted[k + 1]);
    result.covariance[k] =
        filtered_covariance[k] + C * (result.covariance[k + 1] - predicted_covariance[k + 1]) * C.transpose();
  }
  for (std::size_t k = 0; k < n; ++k) result.state[k] += stretch.path[k];
  return result;
}

}  // namespace leeway::gap
