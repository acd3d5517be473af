#include "gap/correct/seen_faults.hpp"

#include <algorithm>
#include <cmath>

#include "core/linear_algebra.hpp"
#include "core/parallel.hpp"
#include "gap/correct/faults.hpp"
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
  Vec6 state, slope, bend;  // the ship's states, and their first and second derivatives by time
};

// What a fault of size 1 adds to the measurements at one point: derivatives by its parameter, of what is late or
// filtered the chord up to the usual delay.
PointColumns columns_at(const Point& at, double usual_delay_s) {
  PointColumns out = PointColumns::Zero();
  const Vec6& x = at.state;
  const Vec6 late = -at.slope + 0.5 * usual_delay_s * at.bend, filtered = -at.slope + usual_delay_s * at.bend;
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
  const auto slope = [&](std::size_t from, std::size_t to) -> Vec6 {
    if (from == to) return Vec6::Zero();
    return (path[to] - path[from]).head<kShipStates>() / (stretch.t_s[to] - stretch.t_s[from]);
  };
  std::vector<PointColumns> result;
  result.reserve(path.size());
  for (std::size_t k = 0; k < path.size(); ++k) {
    const std::size_t before = k > 0 ? k - 1 : k, after = std::min(k + 1, path.size() - 1);
    const double half_s = 0.5 * (stretch.t_s[after] - stretch.t_s[before]);
    const Vec6 bend = before < k && k < after ? Vec6((slope(k, after) - slope(before, k)) / half_s) : Vec6::Zero();
    result.push_back(columns_at({path[k].head<kShipStates>(), slope(before, after), bend}, usual_delay_s));
  }
  return result;
}

// Evidence about theta and the parameters of all faults.
Evidence evidence_of_faults(const FittedNull& fit, const FroudeScale& scale, std::size_t jobs) {
  const double usual_delay_s = kPolicy.sensors.usual_delay_s * scale.time;
  std::vector<Evidence> parts(fit.stretches.size());
  parallel_for(parts.size(), jobs, [&](std::size_t s) {
    const std::vector<PointColumns> columns =
        columns_along(*fit.stretches[s].data, fit.smoothed[s].state, usual_delay_s);
    parts[s] = evidence(fit.stretches[s], fit.noise, 0, nullptr,
                        {kCount, [&](std::size_t k, Eigen::Ref<Eigen::MatrixXd> out) { out = columns[k]; }});
  });
  Evidence total(fit.theta.size() + kCount);
  for (const Evidence& part : parts) total += part;
  return total;
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

// theta with the numbers of one candidate, in units of their usual sizes.
struct Beside {
  Evidence evidence;
  Eigen::VectorXd theta, unit;  // unit: SI

  Beside(const Evidence& total, const Eigen::VectorXd& known, const FaultCandidate& candidate, const FroudeScale& scale)
      : evidence(known.size() + static_cast<Eigen::Index>(candidate.numbers.size())) {
    const Eigen::Index n = known.size(), all = evidence.b.size();
    Eigen::MatrixXd by = Eigen::MatrixXd::Zero(total.b.size(), all);
    by.topLeftCorner(n, n).setIdentity();
    unit.resize(all - n);
    for (Eigen::Index i = n; i < all; ++i)
      for (const FaultParameter parameter : candidate.numbers[static_cast<std::size_t>(i - n)]) {
        unit[i - n] = info(parameter).usual_sd * scale.of(info(parameter).quantity);
        by(n + static_cast<Eigen::Index>(parameter), i) = unit[i - n];
      }
    evidence.log_likelihood = total.log_likelihood;
    evidence.b = by.transpose() * total.b;
    evidence.F = by.transpose() * total.F * by;
    theta.resize(all);
    theta << known, Eigen::VectorXd::Zero(all - n);
  }
};

bool is_same(const Fault& a, const Fault& b) {
  return a.name == b.name &&
         std::equal(a.parameters.begin(), a.parameters.end(), b.parameters.begin(), b.parameters.end(),
                    [](const Estimate& x, const Estimate& y) { return x.name == y.name; });
}

}  // namespace

std::vector<SeenFault> seen_faults(const Campaign& campaign, const FittedNull& fit, std::size_t jobs) {
  const FroudeScale scale(campaign.ship.particulars.L_pp);
  const Usual usual = usual_of(campaign, scale);
  const Evidence total = evidence_of_faults(fit, scale, jobs);
  const std::vector<PriorWidths> widths = widths_by_scale(fit.parameters, fit.effects);
  const double sound = file_evidence(fit.total, fit.theta, widths).log_evidence;
  std::vector<SeenFault> result;
  for (const FaultCandidate& candidate : fault_library()) {
    if (candidate.numbers[0][0] == current_x) continue;
    const Beside beside(total, fit.theta, candidate, scale);
    const Eigen::Index numbers = beside.unit.size();
    const FileEvidence with =
        file_evidence(beside.evidence, beside.theta, with_coordinates(widths, fit.theta.size(), numbers));
    if (!std::isfinite(with.log_evidence)) continue;
    const Eigen::VectorXd precision = with.likeliest.sd.array().square().inverse();
    Eigen::MatrixXd M = beside.evidence.F;
    M.diagonal() += precision;
    const Eigen::MatrixXd covariance = M.llt().solve(Eigen::MatrixXd::Identity(M.rows(), M.cols()));
    const Eigen::VectorXd step = covariance * (beside.evidence.b - precision.cwiseProduct(beside.theta));
    SeenFault seen;
    seen.log_bayes_factor = with.log_evidence - sound;
    seen.fault.name = candidate.name;
    seen.fault.separating_maneuver = separating_maneuver(candidate.name);
    Eigen::VectorXd at_3m(numbers);
    for (Eigen::Index i = 0; i < numbers; ++i) {
      const Eigen::Index place = fit.theta.size() + i;
      const double value = step[place] * beside.unit[i], sd = std::sqrt(covariance(place, place)) * beside.unit[i];
      for (const FaultParameter parameter : candidate.numbers[static_cast<std::size_t>(i)]) {
        const FaultParameterInfo& of = info(parameter);
        seen.fault.parameters.push_back({std::string(of.name), value / of.unit, sd / of.unit});
        at_3m[i] = value / scale.of(of.quantity);
      }
    }
    seen.is_small = size_by_smallest(candidate, at_3m, usual) < 1.0;
    rephrase(seen.fault);
    result.push_back(std::move(seen));
  }
  return result;
}

std::optional<Fault> likeliest_of(const std::vector<SeenFault>& seen, const std::vector<Fault>& found,
                                  const std::vector<Fault>& tested) {
  std::vector<Fault> possible;
  for (const SeenFault& one : seen) {
    const auto is_other = [&](const Fault& other) { return other.name != one.fault.name; };
    if (one.is_small || is_early(one.fault) || !std::all_of(found.begin(), found.end(), is_other)) continue;
    possible.push_back(one.fault);
    possible.back().log_odds = one.log_bayes_factor;
    for (const Fault& as_tested : tested)
      if (is_same(as_tested, one.fault)) {
        possible.back().heldout_gain = as_tested.heldout_gain;
        possible.back().heldout_gain_sd = as_tested.heldout_gain_sd;
      }
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
