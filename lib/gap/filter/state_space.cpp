#include "gap/filter/state_space.hpp"

#include <algorithm>
#include <cmath>

#include "core/linear_algebra.hpp"
#include "gap/filter/noise_slope.hpp"
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
    : mean(Vector::Zero()),
      covariance(Matrix::Zero()),
      columns(Columns::Zero(kFilterStates, count)),
      stretch_(stretch),
      noise_(noise),
      wind_sd_(noise.wind_share * stretch.data->wind_speed_mps),
      rows_(kShipStates, count) {
  const StateVector& x = stretch.path.front();
  mean.segment<kStates - kErrorStart>(kErrorStart) = -x.tail<kStates - kErrorStart>();
  covariance.diagonal().head<kShipStates>() = stretch.initial_sd.array().square();
  covariance.diagonal().segment<3>(kErrorStart) = sigma_w(0).array().square();
  covariance.block<3, 3>(kErrorStart, kErrorStart) += spread(0);
  covariance.diagonal().segment<2>(kWindStart).setConstant(wind_sd_ * wind_sd_);
  if (noise.one_receiver)
    covariance.diagonal().segment<2>(kReceiverStart).setConstant(noise.receiver_sd * noise.receiver_sd);
  covariance.diagonal().tail<kActuatorErrors>().setOnes();
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

Filter::Matrix Filter::transition(std::size_t k) const {
  const double dt = stretch_.data->dt_s(k);
  Matrix A = Matrix::Zero();
  A.topLeftCorner<kShipStates, kStates>() = stretch_.steps[k].A;
  A.diagonal().segment<3>(kErrorStart).setConstant(std::exp(-dt / noise_.tau_s));
  A.diagonal().segment<2>(kWindStart).setConstant(std::exp(-dt / noise_.wind_tau_s));
  if (!stretch_.data->uncertain.empty()) {
    A.topRightCorner<kShipStates, kActuatorErrors>() = stretch_.steps[k].by_actuators;
    for (std::size_t a = 0; a < kActuatorErrors; ++a)
      A.diagonal().tail<kActuatorErrors>()[static_cast<Eigen::Index>(a)] =
          stretch_.data->actuator_errors[k].goes_on[a] ? 1.0 : 0.0;
  }
  if (!noise_.one_receiver) return A;
  const double kept = std::exp(-dt / noise_.receiver_tau_s);
  A.diagonal().segment<2>(kReceiverStart).setConstant(kept);
  A.block<2, 2>(0, kReceiverStart).diagonal().setConstant(noise_.receiver_tau_s * (1.0 - kept));  // its way
  return A;
}

template <int states>
void Filter::predict(std::size_t k) {
  const Matrix whole = transition(k);
  const auto A = whole.topLeftCorner<states, states>();
  Eigen::Matrix<double, states, 1> offset = Eigen::Matrix<double, states, 1>::Zero();
  offset.template head<kShipStates>() = stretch_.steps[k].offset;
  for (int i = kErrorStart; i < kStates; ++i) offset[i] = A(i, i) * stretch_.path[k][i] - stretch_.path[k + 1][i];
  mean.head<states>() = (A * mean.head<states>() + offset).eval();
  // A is full in its upper rows and diagonal below. Lazy products: for matrices this small, blocking costs more than it
  // saves.
  const Eigen::Matrix<double, kShipStates, states> upper = A.template topRows<kShipStates>();
  constexpr int kErrors = states - kErrorStart;
  const Eigen::Matrix<double, kErrors, 1> decay = A.diagonal().template tail<kErrors>();
  auto P = covariance.topLeftCorner<states, states>();
  const Eigen::Matrix<double, kShipStates, states> moved = upper.lazyProduct(P);
  auto ship = covariance.topLeftCorner<kShipStates, kShipStates>();
  ship = moved.lazyProduct(upper.transpose());
  // Symmetric to the last bit: no measurement takes from the difference of the halves, which grows with what is
  // unstable.
  ship.triangularView<Eigen::StrictlyUpper>() = ship.transpose();
  P.template topRightCorner<kShipStates, kErrors>() = moved.template rightCols<kErrors>() * decay.asDiagonal();
  P.template bottomLeftCorner<kErrors, kShipStates>() = P.template topRightCorner<kShipStates, kErrors>().transpose();
  P.template bottomRightCorner<kErrors, kErrors>().array() *= (decay * decay.transpose()).array();
  const Vec3<double> sigma = sigma_w(k + 1);
  for (int i = 0; i < 3; ++i)
    covariance(kErrorStart + i, kErrorStart + i) +=
        sigma[i] * sigma[i] * (1.0 - A(kErrorStart + i, kErrorStart + i) * A(kErrorStart + i, kErrorStart + i));
  covariance.block<3, 3>(kErrorStart, kErrorStart) += (1.0 - decay[0] * decay[0]) * spread(k);
  for (int i = kWindStart; i < kStates; ++i) covariance(i, i) += wind_sd_ * wind_sd_ * (1.0 - A(i, i) * A(i, i));
  const Vec6 timing = noise_.timing_sd * stretch_.steps[k].G.rightCols<1>();
  ship += timing * timing.transpose();
  if (stretch_.steps[k].answer) ship += stretch_.steps[k].by_helm * stretch_.steps[k].by_helm.transpose();
  if constexpr (states > kActuatorStart)
    for (int i = kActuatorStart; i < states; ++i) covariance(i, i) += 1.0 - A(i, i);
  if (states > kStates && noise_.one_receiver) {
    // Of an Ornstein-Uhlenbeck velocity and the way that it leads.
    const double tau = noise_.receiver_tau_s, variance = noise_.receiver_sd * noise_.receiver_sd,
                 kept = A(kReceiverStart, kReceiverStart), lost = 1.0 - kept;
    for (int i = 0; i < 2; ++i) {
      covariance(kReceiverStart + i, kReceiverStart + i) += variance * (1.0 - kept * kept);
      covariance(i, kReceiverStart + i) += variance * tau * lost * lost;
      covariance(kReceiverStart + i, i) += variance * tau * lost * lost;
      covariance(i, i) += variance * tau * tau * (2.0 * stretch_.data->dt_s(k) / tau - 2.0 * lost - lost * lost);
    }
  }
  P.diagonal().array() += kPolicy.filter.tiny;
  // Where no wind is recorded it has no error, not even by rounding: an anemometer would err by the ship's own speed.
  if (wind_sd_ == 0.0) covariance.diagonal().segment<2>(kWindStart).setZero();
  Eigen::Index first = 0;
  for (; first + kWidth <= columns.cols(); first += kWidth) move_columns<states, kWidth>(upper, first);
  for (; first < columns.cols(); ++first) move_columns<states, 1>(upper, first);
  for (int i = kErrorStart; i < states; ++i) columns.row(i) *= A(i, i);
}

template <int states, int width>
void Filter::move_columns(const Eigen::Matrix<double, kShipStates, states>& A, Eigen::Index first) {
  Eigen::Array<double, width, 1> in[states];
  for (int j = 0; j < states; ++j) in[j] = columns.block<1, width>(j, first).transpose();
  for (int i = 0; i < kShipStates; ++i) {
    Eigen::Array<double, width, 1> out = A(i, 0) * in[0];
    for (int j = 1; j < states; ++j) out += A(i, j) * in[j];
    columns.block<1, width>(i, first) = out.transpose();
  }
}

template <int states>
int Filter::take(std::size_t k) {
  auto P = covariance.topLeftCorner<states, states>();
  auto m = mean.head<states>();
  int count = 0;
  for (int i = 0; i < kShipStates; ++i) {
    const double y = stretch_.data->measured[k][i];
    if (std::isnan(y)) continue;
    Vec2<double> of_receiver = Vec2<double>::Zero();
    Eigen::Matrix<double, states, 1> with = P.col(i);  // covariance of the states with what is measured
    double S = covariance(i, i) + noise_.measurement_sd[i] * noise_.measurement_sd[i], expected = mean[i];
    if constexpr (states > kStates)
      if (noise_.one_receiver && (i == 3 || i == 4)) {
        const double psi = stretch_.path[k][2];
        of_receiver = i == 3 ? Vec2<double>(std::cos(psi), std::sin(psi)) : Vec2<double>(-std::sin(psi), std::cos(psi));
        with += P.template middleCols<2>(kReceiverStart) * of_receiver;
        S += (with + P.col(i)).template segment<2>(kReceiverStart).dot(of_receiver);
        expected += m.template segment<2>(kReceiverStart).dot(of_receiver);
      }
    const double per_root = 1.0 / std::sqrt(S);
    const double e = y - stretch_.path[k][i] - stretch_.mean_offset[k][i] - expected;
    const Eigen::Matrix<double, states, 1> K = with / S;
    m += K * e;
    P -= K.lazyProduct((K * S).transpose());
    Taken& taken = taken_[static_cast<std::size_t>(count++)];
    taken = {i, e * per_root, S, per_root, Vector::Zero(), of_receiver};
    taken.gain.head<states>() = K / per_root;
  }
  Eigen::Index first = 0;
  for (; first + kWidth <= columns.cols(); first += kWidth) take_columns<states, kWidth>(count, first);
  for (; first < columns.cols(); ++first) take_columns<states, 1>(count, first);
  return count;
}

template <int states, int width>
void Filter::take_columns(int count, Eigen::Index first) {
  Eigen::Array<double, width, 1> x[states];
  for (int j = 0; j < states; ++j) x[j] = columns.block<1, width>(j, first).transpose();
  for (int t = 0; t < count; ++t) {
    const Taken& taken = taken_[static_cast<std::size_t>(t)];
    Eigen::Array<double, width, 1> row = x[taken.channel];
    if constexpr (states > kStates)
      row += taken.of_receiver(0) * x[kReceiverStart] + taken.of_receiver(1) * x[kReceiverStart + 1];
    row *= taken.per_root;
    rows_.block<1, width>(t, first) = row.transpose();
    for (int j = 0; j < states; ++j) x[j] -= taken.gain[j] * row;
  }
  for (int j = 0; j < states; ++j) columns.block<1, width>(j, first) = x[j].transpose();
}

template void Filter::predict<kStates>(std::size_t k);
template void Filter::predict<kReceiverStates>(std::size_t k);
template void Filter::predict<kFilterStates>(std::size_t k);
template int Filter::take<kStates>(std::size_t k);
template int Filter::take<kReceiverStates>(std::size_t k);
template int Filter::take<kFilterStates>(std::size_t k);

namespace {

void make_room(Passage& passage, const LinearStretch& stretch, Eigen::Index columns) {
  Eigen::Index measurements = 0;
  for (const Vec6& y : stretch.data->measured) measurements += (y.array() == y.array()).count();
  const std::size_t n = stretch.path.size();
  passage.first_taken.assign(1, 0);
  passage.taken.clear();
  passage.innovations.resize(measurements);
  passage.rows.resize(measurements, columns);
  passage.mean.resize(n);
  passage.covariance.resize(n);
  passage.errors.resize(Passage::kDecaying * static_cast<Eigen::Index>(n), columns);
}

void keep(Passage& passage, const Filter& filter, std::size_t k) {
  passage.first_taken.push_back(passage.taken.size());
  passage.mean[k] = filter.mean;
  passage.covariance[k] = filter.covariance;
  const Eigen::Index first = Passage::kDecaying * static_cast<Eigen::Index>(k);
  passage.errors.middleRows<3>(first) = filter.columns.middleRows<3>(kErrorStart);
  passage.errors.middleRows<2>(first + 3) = filter.columns.middleRows<2>(kReceiverStart);
}

std::vector<Evidence> evidence_by_blocks(const LinearStretch& stretch, const Noise& noise, std::size_t block_points,
                                         Eigen::Index count, const MoreColumns& more, const MeasuredColumns& measured,
                                         Passage* passage) {
  const Eigen::Index p = stretch.steps.front().G.cols(), columns = p + count + measured.count;
  const std::size_t n = stretch.path.size();
  std::vector<Evidence> blocks((n + block_points - 1) / block_points, Evidence(columns));
  Filter filter(stretch, noise, columns);
  if (passage != nullptr) make_room(*passage, stretch, columns);
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
    filter.update(k, [&](const Filter::Taken& taken, const auto& row) {
      block.log_likelihood -= 0.5 * (taken.z * taken.z + std::log(2.0 * kPi * taken.S));
      ++block.measurements;
      rows.row(filled) = row;
      innovations[filled] = taken.z;
      if (passage != nullptr) {
        const auto t = static_cast<Eigen::Index>(passage->taken.size());
        passage->taken.push_back(taken);
        passage->rows.row(t) = row;
        passage->innovations[t] = taken.z;
      }
      if (++filled == kRows) flush(block);
    });
    if (measured.count > 0) filter.columns.topRightCorner(kShipStates, measured.count) -= measured_addition;
    if (passage != nullptr) keep(*passage, filter, k);
    if (k + 1 == n || (k + 1) % block_points == 0) flush(block);
  }
  for (Evidence& block : blocks) block.F.triangularView<Eigen::StrictlyUpper>() = block.F.transpose();
  return blocks;
}

}  // namespace

std::vector<Evidence> evidence_by_blocks(const LinearStretch& stretch, const Noise& noise, std::size_t block_points,
                                         Eigen::Index count, const MoreColumns& more, const MeasuredColumns& measured) {
  return evidence_by_blocks(stretch, noise, block_points, count, more, measured, nullptr);
}

Evidence evidence(const LinearStretch& stretch, const Noise& noise, Eigen::Index count, const MoreColumns& more,
                  const MeasuredColumns& measured) {
  return evidence_by_blocks(stretch, noise, stretch.path.size(), count, more, measured, nullptr).front();
}

Evidence evidence(const LinearStretch& stretch, const Noise& noise, Eigen::Index count, const MoreColumns& more,
                  Passage& passage) {
  return evidence_by_blocks(stretch, noise, stretch.path.size(), count, more, {}, &passage).front();
}

namespace {

// What the filter knew at each point, before and after its measurements.
struct Passed {
  std::vector<Filter::Vector> predicted, filtered;
  std::vector<Filter::Matrix> predicted_covariance, filtered_covariance;
};

// Rauch, Tung & Striebel (1965), of the first `states`.
template <int states>
void smooth_back(const Filter& filter, const Passed& passed, Smoothed& result) {
  const std::size_t n = passed.filtered.size();
  Eigen::Matrix<double, states, 1> state = passed.filtered[n - 1].head<states>();
  Eigen::Matrix<double, states, states> covariance = passed.filtered_covariance[n - 1].topLeftCorner<states, states>();
  for (std::size_t k = n - 1;; --k) {
    result.state[k] = state.template head<kStates>();
    result.covariance[k] = covariance.template topLeftCorner<kStates, kStates>();
    if (k == 0) return;
    const Eigen::Matrix<double, states, states> A = filter.transition(k - 1).topLeftCorner<states, states>(),
                                                filtered =
                                                    passed.filtered_covariance[k - 1].topLeftCorner<states, states>(),
                                                predicted =
                                                    passed.predicted_covariance[k].topLeftCorner<states, states>();
    const Eigen::Matrix<double, states, states> C = predicted.ldlt().solve(A * filtered).transpose();
    state = passed.filtered[k - 1].head<states>() + C * (state - passed.predicted[k].head<states>());
    covariance = filtered + C * (covariance - predicted) * C.transpose();
  }
}

}  // namespace

Smoothed smooth(const LinearStretch& stretch, const Noise& noise, const Eigen::VectorXd& dtheta) {
  const std::size_t n = stretch.path.size();
  Smoothed result;
  result.state.resize(n);
  result.covariance.resize(n);
  result.innovations.assign(n, Vec6::Constant(kMissing));
  Passed passed{std::vector<Filter::Vector>(n), std::vector<Filter::Vector>(n), std::vector<Filter::Matrix>(n),
                std::vector<Filter::Matrix>(n)};
  Filter filter(stretch, noise, 0);
  for (std::size_t k = 0; k < n; ++k) {
    if (k > 0) {
      filter.predict(k - 1);
      filter.mean.head<kShipStates>() += stretch.steps[k - 1].G * dtheta;
    }
    passed.predicted[k] = filter.mean;
    passed.predicted_covariance[k] = filter.covariance;
    const Vec6 read = stretch.data->by_faults.of(k, dtheta);
    filter.mean.head<kShipStates>() += read;
    filter.update(k, [&](const Filter::Taken& taken, const auto&) { result.innovations[k][taken.channel] = taken.z; });
    filter.mean.head<kShipStates>() -= read;
    passed.filtered[k] = filter.mean;
    passed.filtered_covariance[k] = filter.covariance;
  }
  with_states(stretch, noise, [&]<int states>() { smooth_back<states>(filter, passed, result); });
  for (std::size_t k = 0; k < n; ++k) result.state[k] += stretch.path[k];
  return result;
}

}  // namespace leeway::gap
