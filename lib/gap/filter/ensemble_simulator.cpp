#include "gap/filter/ensemble_simulator.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "core/errors.hpp"
#include "core/wind.hpp"
#include "forces/registry.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {
namespace {

// The ship as far as an ensemble without a base knows it.
Ship ship_of(const ensemble::EnsembleHeader& header, double L_pp_m) {
  Ship ship;
  const double dt_s = header.config.time_step_s;
  ship.particulars.L_pp = L_pp_m > 0.0 ? L_pp_m : kPolicy.filter.paper_length_m * dt_s * dt_s;
  return ship;
}

// Inputs of a network have one value over a step: the mean, by Simpson's rule.
Inputs<double> held(const StepInputs<double>& in) {
  Inputs<double> mean = in.start;
  const auto simpson = [](double start, double middle, double end) { return (start + 4.0 * middle + end) / 6.0; };
  for (std::size_t i = 0; i < kActuatorChannels.size(); ++i)
    mean.actuators.values[i] =
        simpson(in.start.actuators.values[i], in.middle.actuators.values[i], in.end.actuators.values[i]);
  for (const Eigen::Index i : {0, 1})
    mean.true_wind[i] = simpson(in.start.true_wind[i], in.middle.true_wind[i], in.end.true_wind[i]);
  return mean;
}

}  // namespace

EnsembleSimulator::EnsembleSimulator(ensemble::Ensemble ensemble, std::string name, double L_pp_m)
    : ensemble_(std::move(ensemble)), name_(std::move(name)) {
  const ensemble::EnsembleHeader& header = ensemble_.header();
  ship_ = ensemble_.base() != nullptr ? ensemble_.base()->ship() : ship_of(header, L_pp_m);
  if (ensemble_.base() == nullptr) ship_.name = name_;
  const auto add = [&](Channel channel, bool is_optional) {
    if (ship_.find_actuator(channel) != nullptr) return;
    Actuator actuator{};
    actuator.channel = channel;
    actuator.min = -std::numeric_limits<double>::infinity();
    actuator.max = std::numeric_limits<double>::infinity();
    actuator.is_optional = is_optional;
    ship_.actuators.push_back(actuator);
  };
  for (const Channel channel : header.inputs.sampled_actuators()) add(channel, false);
  for (const auto& [channel, value] : header.inputs.constants) add(channel, true);  // no input, but it may be reported
  if (!header.inputs.wind)
    ship_.modules->wind.reset();
  else if (!ship_.modules->wind)
    ship_.modules->wind.emplace();
}

void EnsembleSimulator::check(const Trajectory& recording) const {
  const ensemble::ModelInputs& inputs = ensemble_.header().inputs;
  const auto refuse = [&](const std::string& column) {
    return InputError(recording.file, 1, "",
                      fmt::format("no column '{}', which the ensemble '{}' was trained with; found actuators: {}",
                                  column, name_, found_actuators(recording)));
  };
  for (const Channel channel : inputs.sampled_actuators())
    if (!recording.has(channel)) throw refuse(column_name(channel));
  if (inputs.wind && !recording.has_wind()) throw refuse(column_name(Channel::wind_speed));
  if (ensemble_.base() != nullptr) ensemble_.base()->check(recording);
  const double sample_s = mean_sampling_time_s(recording);
  if (sample_s > kPolicy.filter.slowest * time_step_s())
    throw InputError(recording.file, 1, "t_s",
                     fmt::format("sampled every {:.3g} s; the ensemble '{}' was trained with steps of {:.3g} s and "
                                 "needs samples at least every {:.3g} s",
                                 sample_s, name_, time_step_s(), kPolicy.filter.slowest * time_step_s()));
}

std::vector<double> EnsembleSimulator::beyond(double psi, const Vec3<double>& nu, const Inputs<double>& inputs) const {
  const ensemble::ModelInputs& known = ensemble_.header().inputs;
  if (known.domain.empty()) return {};
  std::vector<double> values{nu(0), nu(1), nu(2)};
  for (const Channel channel : known.actuators) values.push_back(inputs.actuators[channel]);
  if (known.wind) {
    const Vec2<double> wind = apparent_wind<double>(inputs.true_wind, psi, nu(0), nu(1));
    values.insert(values.end(), {wind(0), wind(1)});
  }
  std::vector<double> result;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto& [input, low, high] = known.domain[i];
    result.push_back(std::max({0.0, low - values[i], values[i] - high}) / (kPolicy.filter.margin * (high - low)));
  }
  return result;
}

Vec3<double> EnsembleSimulator::typical_acceleration() const {
  const std::vector<ensemble::Spread>& known = ensemble_.header().inputs.accelerations;
  return {known[0].sd, known[1].sd, known[2].sd};
}

EnsembleSteps::EnsembleSteps(const EnsembleSimulator& simulator)
    : simulator_(simulator),
      evaluator_(simulator.ensemble()),
      channels_(simulator.ensemble().header().inputs.sampled_actuators()) {}

EnsembleSteps::Step EnsembleSteps::advance(const Eigen::Matrix<double, 11, 1>& x,
                                           const std::vector<StepInputs<double>>& inputs, double h_s,
                                           bool with_derivatives) {
  const ensemble::Ensemble& ensemble = simulator_.ensemble();
  const ensemble::EnsembleHeader& header = ensemble.header();
  const std::vector<ensemble::Spread>& spreads = header.inputs.inputs;
  const Integrator integrator = header.config.integrator_predict;
  const Vec3<double> kick = 0.5 * h_s * x.segment<3>(6);
  // Central differences by heading, velocities and, where the ensemble sees it, wind: two columns each after the first.
  std::vector<std::pair<Eigen::Index, double>> differences;  // place in x, step
  if (with_derivatives) {
    differences.push_back({2, kPolicy.filter.heading_difference_rad});
    for (Eigen::Index i = 0; i < 3; ++i)
      differences.push_back({3 + i, kPolicy.filter.input_difference * spreads[static_cast<std::size_t>(i)].sd});
    if (header.inputs.wind)
      for (Eigen::Index i = 0; i < 2; ++i)
        differences.push_back({9 + i, kPolicy.filter.input_difference * spreads[spreads.size() - 2].sd});
  }
  const Eigen::Index n = 1 + 2 * static_cast<Eigen::Index>(differences.size());
  const auto members = static_cast<double>(ensemble.members());

  Step result{x.head<6>(), Eigen::Matrix<double, 6, 11>::Zero(), Mat3<double>::Zero()};
  result.derivatives.leftCols<6>().setIdentity();
  for (const StepInputs<double>& in : inputs) {
    const Inputs<double> mean = held(in);
    Eigen::VectorXd actuators(static_cast<Eigen::Index>(channels_.size()));
    for (std::size_t a = 0; a < channels_.size(); ++a)
      actuators(static_cast<Eigen::Index>(a)) = mean.actuators[channels_[a]];
    result.end.tail<3>() += kick;
    result.derivatives.block<3, 3>(3, 6).diagonal().array() += 0.5 * h_s;
    Eigen::Matrix<double, 8, Eigen::Dynamic> starts(8, n);  // (eta, nu, wind)
    starts.colwise() = (Eigen::Matrix<double, 8, 1>() << result.end, mean.true_wind + x.segment<2>(9)).finished();
    for (Eigen::Index d = 0; d < (n - 1) / 2; ++d) {
      const auto& [place, size] = differences[static_cast<std::size_t>(d)];
      const Eigen::Index row = place < 6 ? place : place - 3;
      starts(row, 1 + 2 * d) += size;
      starts(row, 2 + 2 * d) -= size;
    }
    Eigen::Matrix<double, 6, Eigen::Dynamic> ends = Eigen::Matrix<double, 6, Eigen::Dynamic>::Zero(6, n);
    Eigen::Matrix3Xd rates(3, ensemble.members());
    for (int m = 0; m < ensemble.members(); ++m) {
      Eigen::Matrix3Xd eta = starts.topRows<3>(), nu = starts.middleRows<3>(3);
      evaluator_.step(m, integrator, h_s, actuators, starts.bottomRows<2>(), eta, nu,
                      Eigen::RowVectorXd::Constant(1, mean.t_s));
      ends.topRows<3>() += eta / members;
      ends.bottomRows<3>() += nu / members;
      rates.col(m) = (nu.col(0) - result.end.tail<3>()) / h_s;
    }
    if (ensemble.members() > 1) {
      const Eigen::Matrix3Xd off = rates.colwise() - rates.rowwise().mean();
      result.spread += off * off.transpose() / (members - 1.0) / static_cast<double>(inputs.size());
    }
    if (with_derivatives) {
      // By (x0, y0, psi, u, v_m, r) and by the wind; the place does not matter.
      Eigen::Matrix<double, 6, 6> A = Eigen::Matrix<double, 6, 6>::Identity();
      Eigen::Matrix<double, 6, 2> by_wind = Eigen::Matrix<double, 6, 2>::Zero();
      for (Eigen::Index d = 0; d < (n - 1) / 2; ++d) {
        const auto& [place, size] = differences[static_cast<std::size_t>(d)];
        const Eigen::Matrix<double, 6, 1> slope = (ends.col(1 + 2 * d) - ends.col(2 + 2 * d)) / (2.0 * size);
        if (place < 6)
          A.col(place) = slope;
        else
          by_wind.col(place - 9) = slope;
      }
      result.derivatives = (A * result.derivatives).eval();
      result.derivatives.rightCols<2>() += by_wind;
      result.derivatives.block<3, 3>(3, 6).diagonal().array() += 0.5 * h_s;
    }
    result.end = ends.col(0);
    result.end.tail<3>() += kick;
  }
  return result;
}

EnsembleSteps::Step EnsembleSteps::step(const Eigen::Matrix<double, 11, 1>& x,
                                        const std::vector<StepInputs<double>>& inputs, double h_s) {
  return advance(x, inputs, h_s, true);
}

Eigen::Matrix<double, 6, 1> EnsembleSteps::end(const Eigen::Matrix<double, 11, 1>& x,
                                               const std::vector<StepInputs<double>>& inputs, double h_s) {
  return advance(x, inputs, h_s, false).end;
}

}  // namespace leeway::gap
