#include "gap/filter/noise_slope.hpp"

#include <algorithm>
#include <cmath>

namespace leeway::gap {
namespace {

// The way back, with as many states as there are errors (with_states()). What is known of later
// measurements is their derivative by the predicted mean, r, and less its expected square by the predicted covariance,
// N. r is linear in the parameters, which are Gaussian: its first column is at their mean, the others go with `root`,
// so that E[r r'] = W W'.
template <int states>
class WayBack {
 public:
  using Square = Eigen::Matrix<double, states, states>;
  using Wide = ByRow<states>;
  static constexpr int kDecaying = states == kStates ? 3 : Passage::kDecaying;
  static constexpr std::size_t kChunk = 128;  // points whose products with `root` are made at a time

  WayBack(const LinearStretch& stretch, const Noise& noise, const Passage& passage, const Eigen::VectorXd& mean,
          const Eigen::MatrixXd& root)
      : stretch_(stretch),
        noise_(noise),
        passage_(passage),
        filter_(stretch, noise, 0),
        mean_(mean),
        root_(root),
        W_(Wide::Zero(states, root.cols() + 1)) {}

  NoiseSlope go() {
    const std::size_t last = stretch_.path.size() - 1;
    for (std::size_t k = last;; --k) {
      if (k == last || (k + 1) % kChunk == 0) take_chunk(k / kChunk * kChunk, k);
      for (std::size_t t = passage_.first_taken[k + 1]; t-- > passage_.first_taken[k];) take_back(t);
      by_covariance_ = W_ * W_.transpose() - N_;
      if (k == 0) break;
      const Square A = filter_.transition(k - 1).template topLeftCorner<states, states>();
      add_step(k - 1, A);
      const Wide before = W_;
      W_.noalias() = A.transpose().lazyProduct(before);
      N_ = (A.transpose() * N_ * A).eval();
    }
    add_start();
    return slope_;
  }

 private:
  // What was measured at points first to last, and the errors before their steps, at the parameters' mean and along
  // `root`: many at a time, since these are products of large matrices.
  void take_chunk(std::size_t first, std::size_t last) {
    first_taken_ = passage_.first_taken[first];
    const auto start = static_cast<Eigen::Index>(first_taken_),
               count = static_cast<Eigen::Index>(passage_.first_taken[last + 1]) - start;
    const auto rows = passage_.rows.middleRows(start, count);
    inputs_.resize(count, W_.cols());
    inputs_.col(0) = passage_.innovations.segment(start, count) - rows * mean_;
    inputs_.rightCols(root_.cols()).noalias() = -rows * root_;
    first_step_ = std::max<std::size_t>(first, 1) - 1;  // the one that leads to the first point
    const auto errors = passage_.errors.middleRows(Passage::kDecaying * static_cast<Eigen::Index>(first_step_),
                                                   Passage::kDecaying * static_cast<Eigen::Index>(last - first_step_));
    errors_.resize(errors.rows(), W_.cols());
    errors_.col(0) = errors * mean_;
    errors_.rightCols(root_.cols()).noalias() = errors * root_;
  }

  void take_back(std::size_t t) {
    const Filter::Taken& taken = passage_.taken[t];
    const int i = taken.channel;
    const Eigen::Matrix<double, states, 1> gain = taken.gain.template head<states>() * taken.per_root;
    const Eigen::RowVectorXd e =
        inputs_.row(static_cast<Eigen::Index>(t - first_taken_)) * taken.per_root - gain.transpose().lazyProduct(W_);
    const Eigen::Matrix<double, states, 1> of_gain = N_ * gain;
    const double D = 1.0 / taken.S + gain.dot(of_gain);
    const double variance = noise_.measurement_sd[i] * noise_.measurement_sd[i];
    slope_.measurement_sd[i] += variance * (e.squaredNorm() - D);
    Eigen::Matrix<double, states, 1> Z = Eigen::Matrix<double, states, 1>::Unit(i);
    if constexpr (states > kStates) Z.template segment<2>(kReceiverStart) = taken.of_receiver;
    W_.row(i) += e;
    if constexpr (states > kStates)
      for (int j = 0; j < 2; ++j)
        if (taken.of_receiver[j] != 0.0) W_.row(kReceiverStart + j) += taken.of_receiver[j] * e;
    N_ += D * Z * Z.transpose() - Z * of_gain.transpose() - of_gain * Z.transpose();
  }

  // By what moves the errors from point k to the next, and by what is added to them there.
  void add_step(std::size_t k, const Square& A) {
    const auto P = passage_.covariance[k].topLeftCorner<states, states>();
    // d ln p / dA = E[r m'] + (E[r r'] - N) A P, by columns of what decays; m with the path, which decays as well.
    auto m = errors_.middleRows(Passage::kDecaying * static_cast<Eigen::Index>(k - first_step_), kDecaying);
    Eigen::Matrix<double, states, kDecaying> AP;
    for (int i = 0; i < kDecaying; ++i) {
      const int state = i < 3 ? kErrorStart + i : kReceiverStart + i - 3;
      m(i, 0) += passage_.mean[k][state] + (i < 3 ? stretch_.path[k][state] : 0.0);
      AP.col(i) = A * P.col(state);
    }
    const Eigen::Matrix<double, states, kDecaying> by_A = W_.lazyProduct(m.transpose()) + by_covariance_ * AP;

    const double dt = stretch_.data->dt_s(k), kept = A(kErrorStart, kErrorStart),
                 per_tau = kept * dt / noise_.tau_s;  // d kept / d ln tau
    const Vec3<double> sigma = filter_.sigma_w(k + 1);
    const Mat3<double> stationary = filter_.spread(k);
    double by_kept = 0.0;
    for (int i = 0; i < 3; ++i) {
      const int state = kErrorStart + i;
      const double variance = sigma[i] * sigma[i];
      slope_.sigma_w[i] += by_covariance_(state, state) * (1.0 - kept * kept) * variance;
      by_kept += by_A(state, i) - kept * by_covariance_(state, state) * variance;
    }
    by_kept -= kept * by_covariance_.template block<3, 3>(kErrorStart, kErrorStart).cwiseProduct(stationary).sum();
    slope_.tau += by_kept * per_tau;
    const double wind_sd = noise_.wind_share * stretch_.data->wind_speed_mps;
    for (int i = kWindStart; i < kStates; ++i)
      slope_.wind_share += by_covariance_(i, i) * (1.0 - A(i, i) * A(i, i)) * wind_sd * wind_sd;
    if constexpr (states > kStates)
      if (noise_.one_receiver) add_receiver(k, by_A);
  }

  // The receiver's velocity and the way that it leads, see Filter::predict.
  void add_receiver(std::size_t k, const Eigen::Matrix<double, states, kDecaying>& by_A) {
    const double dt = stretch_.data->dt_s(k), tau = noise_.receiver_tau_s, kept = std::exp(-dt / tau),
                 lost = 1.0 - kept, moved = kept * dt / tau;  // d kept / d ln tau
    const double variance = noise_.receiver_sd * noise_.receiver_sd;
    for (int i = 0; i < 2; ++i) {
      const int n = kReceiverStart + i;
      const double by_velocity = by_covariance_(n, n), by_both = by_covariance_(i, n), by_way = by_covariance_(i, i);
      slope_.receiver_sd += variance * (by_velocity * (1.0 - kept * kept) + 2.0 * by_both * tau * lost * lost +
                                        by_way * tau * tau * (2.0 * dt / tau - 2.0 * lost - lost * lost));
      slope_.receiver_tau +=
          by_A(n, 3 + i) * moved + by_A(i, 3 + i) * tau * (lost - moved) - by_velocity * variance * kept * moved +
          by_both * variance * tau * (lost * lost - 2.0 * lost * moved) +
          by_way * variance * (dt * tau - tau * tau * (2.0 * lost + lost * lost) + tau * tau * (1.0 + lost) * moved);
    }
  }

  // By the covariance of the errors at the first point.
  void add_start() {
    const Vec3<double> sigma = filter_.sigma_w(0);
    for (int i = 0; i < 3; ++i)
      slope_.sigma_w[i] += by_covariance_(kErrorStart + i, kErrorStart + i) * sigma[i] * sigma[i];
    const double wind_sd = noise_.wind_share * stretch_.data->wind_speed_mps;
    for (int i = kWindStart; i < kStates; ++i) slope_.wind_share += by_covariance_(i, i) * wind_sd * wind_sd;
    for (int i = kReceiverStart; i < std::min(states, kReceiverStates) && noise_.one_receiver; ++i)
      slope_.receiver_sd += by_covariance_(i, i) * noise_.receiver_sd * noise_.receiver_sd;
  }

  const LinearStretch& stretch_;
  const Noise& noise_;
  const Passage& passage_;
  const Filter filter_;  // for what it knows of a step
  const Eigen::VectorXd& mean_;
  const Eigen::MatrixXd& root_;
  ByRow<Eigen::Dynamic> inputs_, errors_;  // of a chunk of points, which begins with ...
  std::size_t first_taken_ = 0, first_step_ = 0;
  Wide W_;
  Square N_ = Square::Zero(), by_covariance_ = Square::Zero();  // twice the derivative by the predicted covariance
  NoiseSlope slope_;
};

}  // namespace

NoiseSlope& NoiseSlope::operator+=(const NoiseSlope& other) {
  sigma_w += other.sigma_w;
  tau += other.tau;
  measurement_sd += other.measurement_sd;
  wind_share += other.wind_share;
  receiver_sd += other.receiver_sd;
  receiver_tau += other.receiver_tau;
  return *this;
}

NoiseSlope noise_slope(const LinearStretch& stretch, const Noise& noise, const Passage& passage,
                       const Eigen::VectorXd& mean, const Eigen::MatrixXd& root) {
  return with_states(stretch, noise,
                     [&]<int states>() { return WayBack<states>(stretch, noise, passage, mean, root).go(); });
}

}  // namespace leeway::gap
