#include "gap/correct/seen_faults.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "core/linear_algebra.hpp"
#include "gap/correct/faults.hpp"
#include "gap/detect/blocks.hpp"
#include "gap/detect/gains_of_nothing.hpp"
#include "gap/detect/score_test.hpp"
#include "gap/fit/coefficient_scale.hpp"
#include "gap/policy/policy.hpp"
#include "gap/sensors/audit.hpp"
#include "gap/sensors/audit_faults.hpp"
#include "gap/sensors/froude_scale.hpp"
#include "gap/sensors/sensor_faults.hpp"

namespace leeway::gap {
namespace {

using enum FaultParameter;

constexpr auto kCount = static_cast<Eigen::Index>(kFaultParameterCount);
using PointColumns = Eigen::Matrix<double, kShipStates, kCount>;

struct Point {
  Vec6 state;           // the ship's
  Vec6 late, filtered;  // what a channel reads that is late, or filtered, by the usual delay, less the state
};

// What a fault of size 1 adds to the measurements at one point: derivatives by its parameter, of what is late or
// filtered the chord up to the usual delay.
PointColumns columns_at(const Point& at, double usual_delay_s) {
  PointColumns out = PointColumns::Zero();
  const Vec6& x = at.state;
  const Vec6 late = at.late / usual_delay_s, filtered = at.filtered / usual_delay_s;
  const auto add = [&](FaultParameter parameter, Eigen::Index state, double value) {
    out(state, static_cast<Eigen::Index>(parameter)) = value;
  };
  const double c = std::cos(x[2]), s = std::sin(x[2]);
  add(heading_bias, 2, 1.0);
  add(lever_x, 0, c), add(lever_x, 1, s);
  add(lever_y, 0, -s), add(lever_y, 1, c);
  add(log_scale, 3, x[3]);
  add(sway_log_scale, 4, x[4]);
  add(log_bias_u, 3, 1.0);
  add(log_bias_v, 4, 1.0);
  add(velocity_latency, 3, late[3]), add(velocity_latency, 4, late[4]);
  add(velocity_filter, 3, filtered[3]), add(velocity_filter, 4, filtered[4]);
  add(heading_latency, 2, late[2]);
  add(heading_filter, 2, filtered[2]);
  add(rate_latency, 5, late[5]);
  add(rate_filter, 5, filtered[5]);
  add(position_latency, 0, late[0]), add(position_latency, 1, late[1]);
  add(rate_bias, 5, 1.0);
  add(rate_scale, 5, x[5]);
  return out;
}

std::vector<PointColumns> columns_along(const Stretch& stretch, const std::vector<StateVector>& path,
                                        double usual_delay_s) {
  // Of the past alone, straight from point to point: where a pilot steers by the sensors, what follows is an answer to
  // the noise that is to be explained.
  const auto x = [&](std::size_t k) -> Vec6 { return path[k].head<kShipStates>(); };
  const auto slope_before = [&](std::size_t k) -> Vec6 {
    if (path.size() < 2) return Vec6::Zero();
    const std::size_t to = std::max<std::size_t>(k, 1);
    return (x(to) - x(to - 1)) / (stretch.t_s[to] - stretch.t_s[to - 1]);
  };
  std::vector<PointColumns> result;
  result.reserve(path.size());
  Vec6 filtered = Vec6::Zero();
  for (std::size_t k = 0; k < path.size(); ++k) {
    const double then_s = stretch.t_s[k] - usual_delay_s;
    std::size_t after = k;  // of the two points between which that was
    while (after > 1 && stretch.t_s[after - 1] > then_s) --after;
    const Vec6 then = x(after) + (then_s - stretch.t_s[after]) * slope_before(after);
    if (k == 0) {
      filtered = x(0) - usual_delay_s * slope_before(0);
    } else {
      const double h = stretch.t_s[k] - stretch.t_s[k - 1], kept = std::exp(-h / usual_delay_s);
      filtered = kept * filtered + (1.0 - kept) * x(k - 1) + (h - usual_delay_s * (1.0 - kept)) * slope_before(k);
    }
    result.push_back(columns_at({x(k), then - x(k), filtered - x(k)}, usual_delay_s));
  }
  return result;
}

// Evidence about theta and the parameters of all faults.
Blocks evidence_of_faults(const Campaign& campaign, const FittedNull& fit, const FroudeScale& scale, std::size_t jobs) {
  const double usual_delay_s = kPolicy.sensors.usual_delay_s * scale.time;
  const auto evidence_of = [&](std::size_t s, std::size_t points) {
    const std::vector<PointColumns> columns =
        columns_along(*fit.stretches[s].data, fit.smoothed[s].state, usual_delay_s);
    return evidence_by_blocks(fit.stretches[s], fit.noise, points, 0, nullptr,
                              {kCount, [&](std::size_t k, Eigen::Ref<Eigen::MatrixXd> out) { out = columns[k]; }});
  };
  return blocks_of(campaign, fit.stretches.size(), evidence_of, jobs);
}

Usual usual_of(const Campaign& campaign, const FroudeScale& scale) {
  double speeds = 0.0, rates = 0.0, points = 0.0;
  Usual usual;
  for (const Stretch& stretch : campaign.stretches) {
    usual.sample_s = std::max(usual.sample_s, stretch.sample_s / scale.time);
    for (const Vec6& y : stretch.measured) {
      if (!y.tail<3>().allFinite()) continue;
      speeds += y.segment<2>(3).squaredNorm();
      rates += y[5] * y[5];
      ++points;
    }
  }
  if (points > 0.0) {
    usual.speed_mps = std::sqrt(speeds / points) / scale.of(Quantity::speed);
    usual.rate_radps = std::sqrt(rates / points) / scale.of(Quantity::angular_rate);
  }
  return usual;
}

// Theta, and what the members of the library change, each number in units of its usual size.
struct Numbers {
  std::vector<const FaultCandidate*> members;
  std::vector<Eigen::Index> first;  // of the numbers of each member, in `unit`
  Eigen::VectorXd theta, unit;      // unit: SI
  Blocks blocks;                    // about theta and all numbers
  Evidence total;                   // of all blocks

  // of_parameters: about theta and the parameters of all faults
  Numbers(const Blocks& of_parameters, const Eigen::VectorXd& known, const FroudeScale& scale) : theta(known) {
    std::vector<double> units;
    std::vector<const std::vector<FaultParameter>*> by;
    for (const FaultCandidate& member : fault_library()) {
      if (member.numbers[0][0] == current_x) continue;
      members.push_back(&member);
      first.push_back(static_cast<Eigen::Index>(units.size()));
      for (const std::vector<FaultParameter>& number : member.numbers) {
        units.push_back(info(number.front()).usual_sd * scale.of(info(number.front()).quantity));
        by.push_back(&number);
      }
    }
    const Eigen::Index n = theta.size(), count = static_cast<Eigen::Index>(units.size());
    unit = Eigen::Map<const Eigen::VectorXd>(units.data(), count);
    Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(n + kCount, n + count);
    columns.topLeftCorner(n, n).setIdentity();
    for (Eigen::Index i = 0; i < count; ++i)
      for (const FaultParameter parameter : *by[static_cast<std::size_t>(i)])
        columns(n + static_cast<Eigen::Index>(parameter), n + i) = unit[i];
    blocks = of_parameters;
    for (Evidence& block : blocks.evidence) {
      block.b = (columns.transpose() * block.b).eval();
      block.F = (columns.transpose() * block.F * columns).eval();
    }
    total = blocks.total();
  }

  Eigen::Index count_of(std::size_t member) const { return static_cast<Eigen::Index>(members[member]->numbers.size()); }
  /// Evidence about theta and the numbers of one member, or of none.
  Blocks beside(std::optional<std::size_t> member) const {
    std::vector<Eigen::Index> places;
    for (Eigen::Index i = 0; i < theta.size(); ++i) places.push_back(i);
    for (Eigen::Index i = 0; member && i < count_of(*member); ++i) places.push_back(theta.size() + first[*member] + i);
    Blocks result = blocks;
    for (Evidence& block : result.evidence) {
      block.b = Eigen::VectorXd(block.b(places));
      block.F = Eigen::MatrixXd(block.F(places, places));
    }
    return result;
  }
  std::vector<LinearCandidate> candidates() const {
    std::vector<LinearCandidate> result;
    for (std::size_t m = 0; m < members.size(); ++m)
      result.push_back({first[m], Eigen::VectorXd::Zero(count_of(m)), std::nullopt});
    return result;
  }
};

}  // namespace

SeenFaults seen_faults(const Campaign& campaign, const FittedNull& fit, std::size_t jobs, std::uint64_t seed) {
  const FroudeScale scale(campaign.ship.particulars.L_pp);
  const Usual usual = usual_of(campaign, scale);
  const Numbers all(evidence_of_faults(campaign, fit, scale, jobs), fit.theta, scale);
  const std::vector<PriorWidths> widths = widths_by_scale(fit.stated, fit.parameters, fit.effects);
  const FileEvidence sound = file_evidence(fit.total, fit.theta, widths);
  const std::vector<std::vector<std::size_t>> folds = folds_of(campaign, all.blocks);
  const std::vector<double> folds_of_sound =
      fold_evidence(all.beside(std::nullopt), folds, fit.theta, sound.likeliest.prior);
  SeenFaults result;
  for (std::size_t m = 0; m < all.members.size(); ++m) {
    const FaultCandidate& member = *all.members[m];
    const Eigen::Index numbers = all.count_of(m), n = fit.theta.size();
    const Blocks blocks = all.beside(m);
    const Evidence beside = blocks.total();
    Eigen::VectorXd theta(n + numbers);
    theta << fit.theta, Eigen::VectorXd::Zero(numbers);
    const FileEvidence with = file_evidence(beside, theta, with_coordinates(widths, n, numbers));
    if (!std::isfinite(with.log_evidence)) continue;
    const ThetaPrior& prior = with.likeliest.prior;
    const Eigen::MatrixXd M = beside.F + prior.precision();
    const Eigen::MatrixXd covariance = M.llt().solve(Eigen::MatrixXd::Identity(M.rows(), M.cols()));
    const Eigen::VectorXd step = covariance * (beside.b - prior.pull(theta));
    SeenFault seen;
    seen.log_bayes_factor = with.log_evidence - sound.log_evidence;
    std::tie(seen.fault.heldout_gain, seen.fault.heldout_gain_sd) =
        heldout_gain(fold_evidence(blocks, folds, theta, with.likeliest.prior), folds_of_sound);
    seen.fault.name = member.name;
    seen.fault.separating_maneuver = separating_maneuver(member.name);
    Eigen::VectorXd at_3m(numbers);
    for (Eigen::Index i = 0; i < numbers; ++i) {
      const double unit = all.unit[all.first[m] + i];
      const double value = step[n + i] * unit, sd = std::sqrt(covariance(n + i, n + i)) * unit;
      for (const FaultParameter parameter : member.numbers[static_cast<std::size_t>(i)]) {
        const FaultParameterInfo& of = info(parameter);
        seen.fault.parameters.push_back({std::string(of.name), value / of.unit, sd / of.unit});
        at_3m[i] = value / scale.of(of.quantity);
      }
    }
    seen.is_small = size_by_smallest(member, at_3m, usual) < 1.0;
    rephrase(seen.fault);
    result.faults.push_back(std::move(seen));
  }
  result.gains_of_nothing = gains_of_nothing(project(all.total, fit.theta, sound.likeliest.prior), all.candidates(),
                                             kPolicy.compare.draws_of_nothing, seed);
  return result;
}

Campaign with_free_faults(Campaign campaign, const FittedNull& before, const std::vector<Fault>& faults) {
  const auto has_same_times = [](const Stretch& a, const LinearStretch& b) { return a.t_s == b.data->t_s; };
  if (!std::ranges::equal(campaign.stretches, before.stretches, has_same_times)) return campaign;
  std::vector<Eigen::VectorXd> numbers;  // how much of each parameter of all faults one moves [SI]
  for (const Fault& fault : faults) {
    const FaultCandidate* candidate = candidate_of(fault);
    if (candidate == nullptr || fault.left_open.empty()) continue;
    std::size_t i = 0;
    for (const std::vector<FaultParameter>& number : candidate->numbers) {
      Eigen::VectorXd& moves = numbers.emplace_back(Eigen::VectorXd::Zero(kCount));
      for (const FaultParameter parameter : number)
        moves[static_cast<Eigen::Index>(parameter)] = fault.left_open[i] * info(parameter).unit;
      UncertainParameter& free = campaign.free_faults.emplace_back();
      free.name = fault.parameters[i].name;
      free.sd = 1.0;
      free.is_of_sensor = true;
      i += number.size();
    }
  }
  if (numbers.empty()) return campaign;
  const double usual_delay_s = kPolicy.sensors.usual_delay_s * FroudeScale(campaign.ship.particulars.L_pp).time;
  for (std::size_t s = 0; s < campaign.stretches.size(); ++s) {
    FaultColumns& columns = campaign.stretches[s].by_faults;
    columns.first = before.coefficients();
    for (const PointColumns& by_parameter :
         columns_along(campaign.stretches[s], before.smoothed[s].state, usual_delay_s)) {
      auto& at = columns.at.emplace_back(kShipStates, static_cast<Eigen::Index>(numbers.size()));
      for (std::size_t i = 0; i < numbers.size(); ++i) at.col(static_cast<Eigen::Index>(i)) = by_parameter * numbers[i];
    }
  }
  return campaign;
}

std::optional<Fault> likeliest_of(const std::vector<SeenFault>& seen, const std::vector<Fault>& found) {
  std::vector<Fault> possible;
  for (const SeenFault& one : seen) {
    const auto is_other = [&](const Fault& other) { return other.name != one.fault.name; };
    if (one.is_small || is_early(one.fault) || !std::all_of(found.begin(), found.end(), is_other)) continue;
    possible.push_back(one.fault);
    possible.back().log_odds = one.log_bayes_factor;
  }
  if (possible.empty()) return std::nullopt;
  std::stable_sort(possible.begin(), possible.end(),
                   [](const Fault& a, const Fault& b) { return a.log_odds > b.log_odds; });
  Fault likeliest = possible.front();
  for (Fault& rival : possible) {
    if (rival.name == likeliest.name || rival.log_odds < likeliest.log_odds - kPolicy.decide.contradicted) continue;
    rival.log_odds -= likeliest.log_odds;
    likeliest.rivals.push_back(std::move(rival));
  }
  return likeliest;
}

}  // namespace leeway::gap
