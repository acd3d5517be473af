#include "ensemble/error_growth.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/linear_algebra.hpp"
#include "recording/samples.hpp"

namespace leeway::ensemble {
namespace {

constexpr double kTimeConstantRatio = 3.1622776601683795;  // of one process to the next: two a decade
constexpr Eigen::Index kBlock = 10;    // points that are averaged, so that the sensors' noise hides less, our choice
constexpr int kMostIterations = 1000;  // of the variances
constexpr double kConverged = 1e-3;    // change of a variance that counts, by itself

// The blocks that the points 1 .. n fall into.
struct Blocks {
  Eigen::Index points;
  Eigen::Index size() const { return (points + kBlock - 1) / kBlock; }
  Eigen::Index of(Eigen::Index point) const { return (point - 1) / kBlock; }
  double count(Eigen::Index block) const { return static_cast<double>(std::min(kBlock, points - block * kBlock)); }
};

// What the block means become by pushes (columns) of (psi, u, v_m, r) at a point.
Eigen::MatrixXd response(const std::vector<StepDerivatives>& steps, const Blocks& blocks, Eigen::Index point,
                         Eigen::Matrix4Xd push) {
  Eigen::MatrixXd means = Eigen::MatrixXd::Zero(3 * blocks.size(), push.cols());
  for (Eigen::Index k = point; k <= blocks.points; ++k) {
    if (k > point) push = (steps[static_cast<std::size_t>(k - 1)].by_state * push).eval();
    if (k > 0) means.middleRows(3 * blocks.of(k), 3) += push.bottomRows<3>() / blocks.count(blocks.of(k));
  }
  return means;
}

// Covariances of the block means by a unit of each noise.
std::vector<Eigen::MatrixXd> spread_noises(const std::vector<StepDerivatives>& steps, const Blocks& blocks,
                                           const Noises& noises, Eigen::MatrixXd& of_inputs) {
  const double dt_s = noises.time_step_s;
  std::vector<Eigen::MatrixXd> by_unit;
  const auto n = static_cast<Eigen::Index>(steps.size()), rows = 3 * blocks.size();
  std::array<Eigen::MatrixXd, 3> by_axis;
  by_axis.fill(Eigen::MatrixXd(rows, n));
  Eigen::MatrixXd by_inputs = Eigen::MatrixXd::Zero(rows, steps.front().by_input.cols());
  Eigen::Matrix4Xd accelerations = Eigen::Matrix4Xd::Zero(4, 3);
  accelerations.bottomRows<3>() = dt_s * Eigen::Matrix3d::Identity();
  for (Eigen::Index k = 0; k < n; ++k) {
    Eigen::Matrix4Xd push(4, 3 + steps[static_cast<std::size_t>(k)].by_input.cols());
    push << accelerations, steps[static_cast<std::size_t>(k)].by_input;
    const Eigen::MatrixXd means = response(steps, blocks, k + 1, std::move(push));
    for (std::size_t axis = 0; axis < 3; ++axis) by_axis[axis].col(k) = means.col(static_cast<Eigen::Index>(axis));
    by_inputs += means.rightCols(means.cols() - 3);
  }
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (const double tau_s : noises.tau_s) {
      Eigen::MatrixXd correlation(n, n);
      for (Eigen::Index i = 0; i < n; ++i)
        for (Eigen::Index j = 0; j < n; ++j)
          correlation(i, j) = std::exp(-static_cast<double>(std::abs(i - j)) * dt_s / tau_s);
      by_unit.emplace_back(by_axis[axis] * correlation * by_axis[axis].transpose());
    }
  Eigen::Matrix4Xd starts = Eigen::Matrix4Xd::Zero(4, 3);
  starts.bottomRows<3>().setIdentity();
  const Eigen::MatrixXd by_start = response(steps, blocks, 0, starts);
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    by_unit.emplace_back(by_start.col(axis) * by_start.col(axis).transpose());
    for (Eigen::Index block = 0; block < blocks.size(); ++block)
      by_unit.back()(3 * block + axis, 3 * block + axis) += 1.0 / blocks.count(block);
  }
  of_inputs = kInputShareVariance * by_inputs * by_inputs.transpose();
  return by_unit;
}

}  // namespace

Noises::Noises(double step_s, int steps) : time_step_s(step_s) {
  const int last = static_cast<int>(std::floor(std::log(steps) / std::log(kTimeConstantRatio) + 1e-9));
  for (int i = 0; i <= last; ++i) tau_s.push_back(step_s * std::pow(kTimeConstantRatio, i));
}

MissedBlocks missed_blocks(const std::vector<Vec3<double>>& error, const std::vector<Eigen::Matrix3Xd>& networks,
                           const std::vector<StepDerivatives>& steps, const Noises& noises) {
  const Blocks blocks{static_cast<Eigen::Index>(error.size())};
  const Eigen::Index M = networks.front().cols();
  MissedBlocks result{Eigen::VectorXd::Zero(3 * blocks.size()), {}, {}, {}};
  result.by_unit = spread_noises(steps, blocks, noises, result.of_inputs);
  Eigen::MatrixXd around = Eigen::MatrixXd::Zero(3 * blocks.size(), M);
  for (Eigen::Index k = 1; k <= blocks.points; ++k) {
    const auto i = static_cast<std::size_t>(k - 1);
    const double count = blocks.count(blocks.of(k));
    result.missed.segment<3>(3 * blocks.of(k)) += error[i] / count;
    const Vec3<double> mean = networks[i].rowwise().mean();
    around.middleRows(3 * blocks.of(k), 3) += (networks[i].colwise() - mean) / count;
  }
  const auto n = static_cast<double>(M);
  result.of_members = (1.0 + 1.0 / n) / (n - 1.0) * around * around.transpose();
  return result;
}

std::vector<double> noise_variances(const std::vector<MissedBlocks>& all, const Noises& noises) {
  // At first each noise alone explains all.
  std::vector<double> v(noises.size());
  double squares = 0.0;
  for (const MissedBlocks& sequence : all) squares += sequence.missed.squaredNorm();
  for (std::size_t c = 0; c < v.size(); ++c) {
    double unit = 0.0;
    for (const MissedBlocks& sequence : all) unit += sequence.by_unit[c].trace();
    v[c] = unit > 0.0 ? squares / unit : 0.0;
  }
  const auto expected = [&](const MissedBlocks& sequence) {
    Eigen::MatrixXd C = sequence.of_members + sequence.of_inputs;
    for (std::size_t c = 0; c < v.size(); ++c) C += v[c] * sequence.by_unit[c];
    return C;
  };
  for (int iteration = 0; iteration < kMostIterations; ++iteration) {
    Eigen::MatrixXd mean = Eigen::MatrixXd::Zero(all.front().missed.size(), all.front().missed.size());
    for (const MissedBlocks& sequence : all) mean += expected(sequence) / static_cast<double>(all.size());
    const Eigen::MatrixXd W = mean.llt().solve(Eigen::MatrixXd::Identity(mean.rows(), mean.cols()));
    std::vector<double> asked(v.size(), 0.0), given(v.size(), 0.0);
    for (const MissedBlocks& sequence : all) {
      const Eigen::MatrixXd weighed = W * expected(sequence) * W;
      const Eigen::VectorXd missed = W * sequence.missed;
      for (std::size_t c = 0; c < v.size(); ++c) {
        asked[c] += missed.dot(sequence.by_unit[c] * missed);
        given[c] += weighed.cwiseProduct(sequence.by_unit[c]).sum();
      }
    }
    double change = 0.0;
    for (std::size_t c = 0; c < v.size(); ++c) {
      const double factor = std::sqrt(asked[c] / given[c]);
      // What a noise that dies out loses is no change that counts.
      if (v[c] * given[c] > kConverged) change = std::max(change, std::abs(factor - 1.0));
      v[c] *= factor;
    }
    if (change < kConverged) break;
  }
  return v;
}

}  // namespace leeway::ensemble
