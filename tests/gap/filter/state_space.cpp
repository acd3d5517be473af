#include "gap/filter/state_space.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include <Eigen/Eigenvalues>
#include <catch2/catch.hpp>

#include "core/random.hpp"
#include "core/units.hpp"
#include "gap/simulated_campaign.hpp"

using namespace leeway;

namespace {

// What the Esso Osaka recorded in calm air, with a ship linearized along it.
//   errs  whether rudder and propeller are taken not to be recorded well
gap::LinearStretch linearized(const Ship& ship, double duration_s, bool errs = false) {
  const std::vector<Trajectory> recordings =
      test::recorded({.ship = "esso-osaka-3m", .recordings = 1, .duration_s = duration_s, .wind_mps = 0.0},
                     read_ship("esso-osaka-3m"));
  const gap::Campaign campaign = gap::prepare(ship, recordings, {});
  REQUIRE(campaign.stretches.size() == 1);
  gap::Stretch stretch = campaign.stretches.front();
  REQUIRE(stretch.uncertain.empty());
  if (errs) {
    stretch.uncertain = {Channel::delta, Channel::n_p};
    for (std::size_t k = 0; k + 1 < stretch.size(); ++k)
      stretch.actuator_errors.push_back({{2.0 * kDegree, 0.5}, {k % 3 != 0, k % 7 != 0}});
  }
  const auto data = std::make_shared<const gap::Stretch>(stretch);
  const auto coefficients = static_cast<Eigen::Index>(gap::uncertain_parameters(ship).size());
  return gap::linearize(ship, data, gap::measured_path(*data), Eigen::VectorXd::Zero(coefficients));
}

}  // namespace

TEST_CASE("filter: a ship that does not keep her course leaves covariances what they are", "[gap]") {
  // Little model error, so that the filter believes a ship that runs away from what is measured.
  Ship unstable = read_ship("esso-osaka-3m");
  unstable.multiply({{"hull.N_v", 4.0}, {"hull.N_r", 0.2}});
  const gap::LinearStretch linear = linearized(unstable, 600.0);
  gap::Noise noise;
  noise.sigma_w = {5e-5, 5e-5, 5e-5};
  noise.tau_s = 10.0;
  noise.wind_tau_s = 15.0;
  noise.measurement_sd << 0.03, 0.03, 0.002, 0.01, 0.01, 0.002;

  gap::Filter filter(linear, noise, 0);
  double fastest = 0.0;
  for (std::size_t k = 0; k < linear.path.size(); ++k) {
    if (k > 0) {
      filter.predict(k - 1);
      const Eigen::Matrix<double, 6, 6> ship = filter.covariance.topLeftCorner<6, 6>();
      REQUIRE(ship == ship.transpose());
      const Eigen::Matrix<double, 6, 6> A = filter.transition(k - 1).topLeftCorner<6, 6>();
      fastest = std::max(fastest, A.eigenvalues().cwiseAbs().maxCoeff());
    }
    filter.update(k, [](const gap::Filter::Taken& taken, const auto&) {
      REQUIRE(taken.S > 0.0);
      REQUIRE(std::isfinite(taken.z));
    });
  }
  CHECK(fastest > 1.1);  // a step of the grid
  CHECK(std::isfinite(gap::evidence(linear, noise).log_likelihood));
}

TEST_CASE("filter: with errors of a receiver and of actuators it gives the density of what is measured", "[gap]") {
  const bool errs = GENERATE(false, true);
  const gap::LinearStretch linear = linearized(read_ship("esso-osaka-3m"), 40.0, errs);
  gap::Noise noise;
  noise.sigma_w = {5e-4, 5e-4, 5e-4};
  noise.tau_s = 10.0;
  noise.wind_tau_s = 15.0;
  noise.measurement_sd << 0.01, 0.02, 0.002, 0.004, 0.003, 0.002;
  noise.timing_sd = 0.0;
  noise.knows_spread = false;
  noise.one_receiver = GENERATE(false, true);
  CAPTURE(errs, noise.one_receiver);
  noise.receiver_sd = 0.02;
  noise.receiver_tau_s = 3.0;

  // All states of all points as one Gaussian vector, then what is measured of them.
  constexpr int states = gap::kFilterStates;
  const auto n = static_cast<Eigen::Index>(linear.path.size());
  gap::Filter filter(linear, noise, 0);
  Eigen::MatrixXd P = Eigen::MatrixXd::Zero(states * n, states * n);
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(states * n);
  P.topLeftCorner<states, states>() = filter.covariance;
  mean.head<states>() = filter.mean;
  for (Eigen::Index k = 0; k + 1 < n; ++k) {
    const auto at = static_cast<std::size_t>(k);
    const gap::Filter::Matrix A = filter.transition(at);
    gap::Filter::Matrix Q = gap::Filter::Matrix::Zero();
    for (int i = 0; i < 3; ++i)
      Q(6 + i, 6 + i) = noise.sigma_w[i] * noise.sigma_w[i] * (1.0 - A(6 + i, 6 + i) * A(6 + i, 6 + i));
    // The receiver's velocity n and its way w over dt, by many small steps: dw = n dt.
    const double dt = linear.data->dt_s(at), h = dt / 20000.0, kept = std::exp(-h / noise.receiver_tau_s);
    double nn = 0.0, nw = 0.0, ww = 0.0;
    for (int i = 0; i < 20000; ++i) {
      ww += 2.0 * h * nw + h * h * nn;
      nw = kept * (nw + h * nn);
      nn = kept * kept * nn + noise.receiver_sd * noise.receiver_sd * (1.0 - kept * kept);
    }
    for (int i = gap::kActuatorStart; i < states; ++i) Q(i, i) = 1.0 - A(i, i) * A(i, i);
    for (int i = 0; i < 2 && noise.one_receiver; ++i) {
      Q(11 + i, 11 + i) = nn;
      Q(i, 11 + i) = Q(11 + i, i) = nw;
      Q(i, i) = ww;
    }
    P.block(states * (k + 1), 0, states, states * (k + 1)) = A * P.block(states * k, 0, states, states * (k + 1));
    P.block(0, states * (k + 1), states * (k + 1), states) =
        P.block(states * (k + 1), 0, states, states * (k + 1)).transpose();
    P.block<states, states>(states * (k + 1), states * (k + 1)) =
        A * P.block<states, states>(states * k, states * k) * A.transpose() + Q;
    gap::Filter::Vector offset = gap::Filter::Vector::Zero();
    offset.head<6>() = linear.steps[at].offset;
    mean.segment<states>(states * (k + 1)) = A * mean.segment<states>(states * k) + offset;
  }
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(6 * n, states * n);
  Eigen::VectorXd y(6 * n), R(6 * n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const gap::StateVector& x = linear.path[static_cast<std::size_t>(k)];
    const double c = std::cos(x[2]), s = std::sin(x[2]);
    H.block(6 * k, states * k, 6, 6).setIdentity();
    H.block<1, 2>(6 * k + 3, states * k + 11) << c, s;
    H.block<1, 2>(6 * k + 4, states * k + 11) << -s, c;
    y.segment<6>(6 * k) = linear.data->measured[static_cast<std::size_t>(k)] - x.head<6>() -
                          linear.mean_offset[static_cast<std::size_t>(k)];
    R.segment<6>(6 * k) = noise.measurement_sd.array().square();
  }
  // What was not measured has no row.
  std::vector<Eigen::Index> known;
  for (Eigen::Index i = 0; i < y.size(); ++i)
    if (!std::isnan(y[i])) known.push_back(i);
  const auto count = static_cast<Eigen::Index>(known.size());
  Eigen::MatrixXd rows(count, states * n), S;
  Eigen::VectorXd e(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    rows.row(i) = H.row(known[static_cast<std::size_t>(i)]);
    e[i] = y[known[static_cast<std::size_t>(i)]] - rows.row(i).dot(mean);
  }
  S = rows * P * rows.transpose();
  for (Eigen::Index i = 0; i < count; ++i) S(i, i) += R[known[static_cast<std::size_t>(i)]];
  const Eigen::LLT<Eigen::MatrixXd> factor(S);
  const double expected = -0.5 * (e.dot(factor.solve(e)) + 2.0 * factor.matrixLLT().diagonal().array().log().sum() +
                                  static_cast<double>(count) * std::log(2.0 * kPi));
  CHECK(gap::evidence(linear, noise).log_likelihood == Approx(expected).margin(0.05));

  // And the smoothed states are the conditional means.
  const Eigen::VectorXd all = mean + P * rows.transpose() * factor.solve(e);
  const gap::Smoothed smoothed = gap::smooth(linear, noise, Eigen::VectorXd::Zero(linear.steps.front().G.cols()));
  for (Eigen::Index k = 0; k < n; ++k) {
    const gap::StateVector off = smoothed.state[static_cast<std::size_t>(k)] -
                                 linear.path[static_cast<std::size_t>(k)] - all.segment<11>(states * k);
    CHECK(off.head<6>().cwiseAbs().maxCoeff() < 1e-4);
  }
}

TEST_CASE("filter: where no wind is recorded it has no error, not even by rounding", "[gap]") {
  // With the least of a wind the scale of an anemometer would change the ship's own head wind.
  const Ship ship = read_ship("esso-osaka-3m");
  const gap::LinearStretch linear = linearized(ship, 100.0);
  gap::Noise noise;
  noise.sigma_w = {5e-4, 5e-4, 5e-4};
  noise.tau_s = 10.0;
  noise.wind_tau_s = 15.0;
  noise.wind_share = 0.2;
  noise.measurement_sd << 0.01, 0.02, 0.002, 0.004, 0.003, 0.002;
  const Eigen::VectorXd theta = Eigen::VectorXd::Zero(linear.steps.front().G.cols());
  const gap::LinearStretch filtered = gap::linearize_filtered(ship, linear, linear.data, noise, {}, theta);
  const gap::Smoothed smoothed = gap::smooth(filtered, noise, theta);
  CHECK((filtered.path[50] - linear.path[50]).head<gap::kShipStates>().norm() > 1e-6);
  for (std::size_t k = 0; k < linear.path.size(); ++k) {
    REQUIRE(filtered.path[k].tail<2>() == Vec2<double>::Zero());
    REQUIRE(smoothed.state[k].tail<2>() == Vec2<double>::Zero());
  }
}

TEST_CASE("filter: where a course is kept a step is that of ship and helmsman together", "[gap]") {
  const Ship ship = read_ship("vectwin-3m");
  const gap::Campaign campaign = gap::prepare(
      ship, test::recorded({.ship = "vectwin-3m", .recordings = 1, .duration_s = 60.0, .wind_mps = 0.0}, ship), {});
  REQUIRE(campaign.stretches.size() == 1);
  auto kept = std::make_shared<gap::Stretch>(campaign.stretches.front());
  gap::HelmLaw law;
  law.offset = 0.02;
  law.per_heading = -1.2;
  law.per_rate_s = -6.0;
  law.sd = 0.1 * kDegree;
  law.rudders = {Channel::delta_p, Channel::delta_s};
  const std::vector<gap::StateVector> path = gap::measured_path(*kept);
  for (std::size_t k = 0; k < kept->size(); ++k)  // beside his law the helmsman errs a little
    law.angle.push_back(law.at(path[k][2], path[k][5]) + 1e-4 * std::sin(static_cast<double>(k)));
  law.angle.back() = kMissing;
  kept->uncertain = {Channel::delta_p, Channel::n_p};
  kept->actuator_errors.assign(kept->size() - 1, {{1.0 * kDegree, 0.5}, {false, false}});
  const auto led = std::make_shared<const gap::Stretch>(*kept);
  kept->helm = law;
  const auto coefficients = static_cast<Eigen::Index>(gap::uncertain_parameters(ship).size());
  const gap::LinearStretch linear = gap::linearize(ship, kept, path, Eigen::VectorXd::Zero(coefficients));
  CHECK_FALSE(linear.steps.back().answer);  // at a limit
  // What the propeller errs by is answered, what is recorded of the rudders is not used.
  const gap::LinearStretch open = gap::linearize(ship, led, path, Eigen::VectorXd::Zero(coefficients));
  REQUIRE(linear.steps[20].answer);
  CHECK(linear.steps[20].by_actuators.col(0).isZero());
  CHECK_FALSE(open.steps[20].by_actuators.col(1).isZero());
  CHECK(linear.steps[20].by_actuators.col(1).isApprox(*linear.steps[20].answer * open.steps[20].by_actuators.col(1)));

  const Model<double> model(ship);
  RandomStream random(1, "kept");
  double moved = 0.0, missed = 0.0;
  for (std::size_t k = 10; k < 30; ++k) {
    gap::StateVector dx = gap::StateVector::Zero();
    for (int i = 2; i < 9; ++i) dx[i] = 1e-4 * random.normal();
    const gap::StateVector begin = linear.path[k] + dx;
    const double h = kept->dt_s(k) / static_cast<double>(kept->inputs[k].size());
    // By hand: the last angle is that of where the step leads.
    gap::Vec6 end = begin.head<6>();
    for (int round = 0; round < 30; ++round) {
      std::vector<StepInputs<double>> inputs = kept->inputs[k];
      const double more_first = law.at(begin[2], begin[5]) - law.angle[k],
                   more_last = law.at(end[2], end[5]) - law.angle[k + 1], n = static_cast<double>(inputs.size());
      for (std::size_t i = 0; i < inputs.size(); ++i) {
        Inputs<double>* at[] = {&inputs[i].start, &inputs[i].middle, &inputs[i].end};
        for (int part = 0; part < 3; ++part)
          for (const Channel rudder : law.rudders) {
            const double share = (static_cast<double>(i) + 0.5 * part) / n;
            at[part]->actuators[rudder] += (1.0 - share) * more_first + share * more_last;
          }
      }
      end = gap::advance<double>(model, begin, inputs, h);
    }
    const gap::Vec6 change = linear.steps[k].offset + linear.steps[k].A * dx;
    moved += change.norm();
    missed += (end - linear.path[k + 1].head<6>() - change).norm();
  }
  CHECK(moved > 0.0);
  CHECK(missed < 0.002 * moved);
}
