#include "gap/compare/latent_forces.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <memory>

#include "core/linear_algebra.hpp"
#include "core/parallel.hpp"
#include "core/units.hpp"
#include "gap/detect/effect_library.hpp"
#include "gap/filter/reference_units.hpp"
#include "gap/fit/coefficient_scale.hpp"
#include "gap/fit/levels.hpp"
#include "gap/locate/patterns.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {
namespace {

constexpr const ComparePolicy& kOf = kPolicy.compare;
constexpr int kGroups = 3;

// Columns of accelerations in units of reference_acceleration(), in three groups that may act together: those on
// surge, sway and yaw, or in earth axes.
struct Basis {
  Dependence on = Dependence::place;
  double argument = kMissing;
  bool is_of_recording = false;  // whether each stretch has strengths of its own
  bool rings = false;
  std::vector<Channel> states{};
  std::array<Eigen::Index, kGroups> counts{};  // columns of each group
  std::vector<Eigen::MatrixXd> values{};       // by stretch: 3 x (steps * columns)
  Eigen::Index columns() const { return counts[0] + counts[1] + counts[2]; }
};

// Groups of a basis that act together, and the axes on which they do.
struct Variant {
  std::vector<int> groups, axes;
};

std::vector<Variant> variants_of(Dependence on) {
  if (on == Dependence::place) return {{{0, 1}, {0, 1}}, {{0, 1, 2}, {0, 1, 2}}};
  if (on == Dependence::period) return {{{0}, {0}}, {{1}, {1}}, {{2}, {2}}};
  return {{{0}, {0}}, {{1, 2}, {1, 2}}, {{0, 1, 2}, {0, 1, 2}}};
}

using Moments = std::vector<std::vector<Moment>>;  // by stretch and step

// The leading functions of a Gaussian process over points (dimensions x points) whose covariance is `kernel` of the
// squared distance of two points, 1 at none (Nystrom's method): points x functions.
template <typename Kernel>
Eigen::MatrixXd leading_functions(const Eigen::MatrixXd& points, const Kernel& kernel) {
  const Eigen::Index n = points.cols(), m = std::min<Eigen::Index>(n, kOf.latent_landmarks);
  std::vector<Eigen::Index> at;
  for (Eigen::Index i = 0; i < m; ++i) at.push_back((2 * i + 1) * n / (2 * m));
  Eigen::MatrixXd K(m, m), across(n, m);
  for (Eigen::Index j = 0; j < m; ++j)
    for (Eigen::Index i = 0; i < n; ++i)
      across(i, j) = kernel((points.col(i) - points.col(at[static_cast<std::size_t>(j)])).squaredNorm());
  for (Eigen::Index i = 0; i < m; ++i) K.row(i) = across.row(at[static_cast<std::size_t>(i)]);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(K);
  Eigen::Index count = 0;
  while (count < std::min<Eigen::Index>(m, kOf.latent_functions) &&
         eigen.eigenvalues()[m - 1 - count] > kOf.latent_share * static_cast<double>(m))
    ++count;
  return across * eigen.eigenvectors().rightCols(count) *
         eigen.eigenvalues().tail(count).cwiseSqrt().cwiseInverse().asDiagonal();
}

// Puts the columns of each step on the axes: for each group one number for each of its columns.
using OfStep = std::function<std::array<Eigen::VectorXd, kGroups>(std::size_t stretch, std::size_t step)>;
Basis basis_of(Dependence on, double argument, const Moments& moments, const OfStep& of_step) {
  Basis basis{on, argument};
  for (std::size_t s = 0; s < moments.size(); ++s) {
    basis.values.emplace_back();
    for (std::size_t k = 0; k < moments[s].size(); ++k) {
      const std::array<Eigen::VectorXd, kGroups> here = of_step(s, k);
      for (std::size_t g = 0; g < kGroups; ++g) basis.counts[g] = here[g].size();
      const Eigen::Index columns = basis.columns();
      if (k == 0) basis.values[s] = Eigen::MatrixXd::Zero(3, static_cast<Eigen::Index>(moments[s].size()) * columns);
      auto out = basis.values[s].middleCols(static_cast<Eigen::Index>(k) * columns, columns);
      Eigen::Index column = 0;
      const double c = std::cos(moments[s][k].psi), sn = std::sin(moments[s][k].psi);
      for (int g = 0; g < kGroups; ++g)
        for (const double value : here[static_cast<std::size_t>(g)]) {
          if (on == Dependence::place && g < 2)
            out.col(column++).head<2>() = value * (g == 0 ? Vec2<double>(c, -sn) : Vec2<double>(sn, c));
          else
            out(g, column++) = value;
        }
    }
  }
  return basis;
}

// Scales the columns of each group, all alike in size, so that together they make a root mean square of 1.
void normalize(Basis& basis) {
  const Eigen::Index columns = basis.columns();
  Eigen::VectorXd square = Eigen::VectorXd::Zero(columns);
  double steps = 0.0;
  for (const Eigen::MatrixXd& values : basis.values) {
    for (Eigen::Index i = 0; i < values.cols(); ++i) square[i % columns] += values.col(i).squaredNorm();
    steps += static_cast<double>(columns > 0 ? values.cols() / columns : 0);
  }
  Eigen::VectorXd scale(columns);
  Eigen::Index column = 0;
  for (const Eigen::Index count : basis.counts)
    for (Eigen::Index i = 0; i < count; ++i, ++column) {
      const double rms = std::sqrt(square[column] / steps);
      scale[column] =
          rms > kPolicy.locate.least_pattern_rms ? 1.0 / (rms * std::sqrt(static_cast<double>(count))) : 0.0;
    }
  for (Eigen::MatrixXd& values : basis.values)
    for (Eigen::Index i = 0; i < values.cols(); ++i) values.col(i) *= scale[i % columns];
}

// A process over points, one for each step, that is smooth over a length.
Basis process_over(const Eigen::MatrixXd& points, double length, Dependence on, double argument,
                   const Moments& moments) {
  const Eigen::MatrixXd functions = leading_functions(
      points, [&](double squared_distance) { return std::exp(-0.5 * squared_distance / (length * length)); });
  Eigen::Index next = 0;
  return basis_of(on, argument, moments, [&](std::size_t, std::size_t) {
    const Eigen::VectorXd f = functions.row(next++).transpose();
    return std::array<Eigen::VectorXd, kGroups>{f, f, f};
  });
}

// What is to be known of each step, one below another: dimensions x steps.
template <typename Values>
Eigen::MatrixXd at_all_steps(const Moments& moments, const Values& values) {
  std::vector<Eigen::VectorXd> all;
  for (const auto& stretch : moments)
    for (const Moment& m : stretch) all.push_back(values(m));
  Eigen::MatrixXd result(all.front().size(), static_cast<Eigen::Index>(all.size()));
  for (std::size_t i = 0; i < all.size(); ++i) result.col(static_cast<Eigen::Index>(i)) = all[i];
  return result;
}

Basis headings(const Moments& moments) {
  Basis basis = basis_of(Dependence::heading, kMissing, moments, [&](std::size_t s, std::size_t k) {
    Eigen::VectorXd f(2 * kOf.latent_harmonics);
    for (Eigen::Index h = 0; h < kOf.latent_harmonics; ++h) {
      const double angle = static_cast<double>(h + 1) * moments[s][k].psi;
      f.segment<2>(2 * h) << std::cos(angle), std::sin(angle);
    }
    return std::array<Eigen::VectorXd, kGroups>{f, f, f};
  });
  normalize(basis);
  return basis;
}

std::vector<double> in_equal_ratios(std::int64_t count, double first, double last) {
  std::vector<double> result;
  for (std::int64_t i = 0; i < count; ++i)
    result.push_back(first * std::pow(last / first, static_cast<double>(i) / static_cast<double>(count - 1)));
  return result;
}

// An oscillation that keeps its phase for a few periods, or a part of the recording.
Basis oscillation(const Moments& moments, double period_s) {
  std::vector<Eigen::MatrixXd> functions;
  Eigen::Index count = 0;
  for (const auto& stretch : moments) {
    functions.emplace_back();
    if (stretch.empty()) continue;
    const Eigen::MatrixXd at =
        at_all_steps({stretch}, [](const Moment& m) { return Eigen::VectorXd::Constant(1, m.t_s); });
    const double coherent_s =
        std::max(kOf.coherent_periods * period_s, kOf.coherent_share * (stretch.back().t_s - stretch.front().t_s));
    functions.back() = leading_functions(at, [&](double squared_s) {
      return std::cos(2.0 * kPi * std::sqrt(squared_s) / period_s) *
             std::exp(-0.5 * squared_s / (coherent_s * coherent_s));
    });
    count = std::max(count, functions.back().cols());
  }
  Basis basis = basis_of(Dependence::period, period_s, moments, [&](std::size_t s, std::size_t k) {
    Eigen::VectorXd f = Eigen::VectorXd::Zero(count);
    f.head(functions[s].cols()) = functions[s].row(static_cast<Eigen::Index>(k)).transpose();
    return std::array<Eigen::VectorXd, kGroups>{f, f, f};
  });
  basis.is_of_recording = true;
  return basis;
}

// What forces follow, first even ones in surge, then odd ones in sway and yaw, in units that do not matter.
constexpr Eigen::Index kEvenMotions = 5;
Eigen::VectorXd motions(const Moment& m, double L_pp) {
  const Actuators<double>& a = m.actuators;
  const double w = m.r * L_pp, thrust = a[Channel::n_p] * std::abs(a[Channel::n_p]),
               s = std::sin(a[Channel::delta]) + 0.5 * (std::sin(a[Channel::delta_p]) + std::sin(a[Channel::delta_s]));
  return (Eigen::VectorXd(10) << m.u * std::abs(m.u), m.v * m.v, w * w, std::abs(w) * m.U, thrust, m.u * m.v, m.U * w,
          w * std::abs(w), thrust * s, a[Channel::n_bt] * std::abs(a[Channel::n_bt]))
      .finished();
}

// By how much each of them is uncertain at a moment, squared, as velocities and rudder angles there are.
Eigen::VectorXd squared_errors(const Moment& m, double L_pp, const Vec3<double>& nu_sd) {
  const Eigen::VectorXd here = motions(m, L_pp);
  Eigen::VectorXd result = Eigen::VectorXd::Zero(here.size());
  const auto add = [&](Moment other) {
    other.U = std::hypot(other.u, other.v);
    result += (motions(other, L_pp) - here).cwiseAbs2();
  };
  Moment other = m;
  other.u += nu_sd[0], add(other), other = m;
  other.v += nu_sd[1], add(other), other = m;
  other.r += nu_sd[2], add(other), other = m;
  for (const Channel rudder : {Channel::delta, Channel::delta_p, Channel::delta_s})
    other.actuators[rudder] += kKnownAngle, add(other), other = m;
  return result;
}

// The past of quantities, less what they are now: it fades in a time, or rings with that period.
class Past {
 public:
  Past(double time_s, bool rings) : time_s_(time_s), rings_(rings) {}

  /// Where the quantities have been `now` for dt.
  const Eigen::VectorXd& next(const Eigen::VectorXd& now, double dt) {
    if (now_.size() == 0) now_ = now, past_ = rate_ = Eigen::VectorXd::Zero(now.size());
    past_ += now_ - now;
    now_ = now;
    if (!rings_) {
      past_ *= std::exp(-dt / time_s_);
    } else {
      constexpr double damping = kOf.ringing_damping;
      const double all = 2.0 * kPi / time_s_, lost = damping * all, omega = all * std::sqrt(1.0 - damping * damping);
      const double less = std::exp(-lost * dt), c = less * std::cos(omega * dt),
                   s = less * std::sin(omega * dt) / omega;
      const Eigen::VectorXd before = past_;
      past_ = (c + lost * s) * before + s * rate_;
      rate_ = (c - lost * s) * rate_ - all * all * s * before;
    }
    return past_;
  }

 private:
  double time_s_;
  bool rings_;
  Eigen::VectorXd now_, past_, rate_;
};

// What differs from the present by no more than it is uncertain is left out: on a held course the past of small errors
// is no cause.
Basis memory(const Moments& moments, double L_pp, double time_s, bool rings, const Vec3<double>& nu_sd) {
  std::vector<std::vector<Eigen::VectorXd>> all(moments.size());
  Eigen::VectorXd error, square;
  for (std::size_t s = 0; s < moments.size(); ++s) {
    Past past(time_s, rings);
    for (std::size_t k = 0; k < moments[s].size(); ++k) {
      all[s].push_back(
          past.next(motions(moments[s][k], L_pp), k > 0 ? moments[s][k].t_s - moments[s][k - 1].t_s : 0.0));
      if (error.size() == 0) error = square = Eigen::VectorXd::Zero(all[s][k].size());
      error += squared_errors(moments[s][k], L_pp, nu_sd);
      square += all[s][k].cwiseAbs2();
    }
  }
  for (Eigen::Index i = 0; i < error.size(); ++i)
    if (square[i] < kOf.certain_motion_sd * kOf.certain_motion_sd * error[i])
      for (auto& stretch : all)
        for (Eigen::VectorXd& here : stretch) here[i] = 0.0;
  Basis basis = basis_of(Dependence::memory, time_s, moments, [&](std::size_t s, std::size_t k) {
    const Eigen::VectorXd &here = all[s][k], odd = here.tail(here.size() - kEvenMotions);
    return std::array<Eigen::VectorXd, kGroups>{here.head(kEvenMotions), odd, odd};
  });
  basis.rings = rings;
  normalize(basis);
  return basis;
}

// What the ship does or is told, of rudders their mean, by its standard deviation.
constexpr std::array<Channel, 6> kStateChannels{Channel::u,   Channel::vm,    Channel::r,
                                                Channel::n_p, Channel::delta, Channel::n_bt};
struct States {
  Eigen::MatrixXd values;                       // kStateChannels x steps
  std::vector<std::vector<Eigen::Index>> sets;  // one or two of those that change by more than they are uncertain
};
//   has_answers  whether hull and rudders show how they answer
States states_of(const Moments& moments, double L_pp, const Vec3<double>& nu_sd, bool has_answers) {
  States result;
  Eigen::MatrixXd& at = result.values = at_all_steps(moments, [&](const Moment& m) -> Eigen::VectorXd {
    const Actuators<double>& a = m.actuators;
    return Eigen::Vector<double, 6>(m.u, m.v, m.r * L_pp, a[Channel::n_p],
                                    a[Channel::delta] + 0.5 * (a[Channel::delta_p] + a[Channel::delta_s]),
                                    a[Channel::n_bt]);
  });
  at.colwise() -= at.rowwise().mean().eval();
  const Eigen::VectorXd sd = at.rowwise().norm() / std::sqrt(static_cast<double>(at.cols()));
  const Eigen::Vector<double, 6> error(nu_sd[0], nu_sd[1], nu_sd[2] * L_pp, 0.0, kKnownAngle, 0.0);
  std::vector<Eigen::Index> moving;
  for (Eigen::Index i = 0; i < at.rows(); ++i) {
    const Channel channel = kStateChannels[static_cast<std::size_t>(i)];
    const bool is_answer = channel == Channel::vm || channel == Channel::r || channel == Channel::delta;
    if (is_answer && !has_answers) continue;
    if (sd[i] < std::max(kOf.certain_motion_sd * error[i], kPolicy.locate.least_pattern_rms)) continue;
    at.row(i) /= sd[i];
    result.sets.push_back({i});
    for (const Eigen::Index other : moving) result.sets.push_back({other, i});
    moving.push_back(i);
  }
  return result;
}

// How each basis is made: together they would take more memory than a workstation has.
std::vector<std::function<Basis()>> bases_of(const Campaign& campaign, const FittedNull& fit, const Moments& moments) {
  const Vec3<double> nu_sd = fit.noise.measurement_sd.tail<3>();
  const double L_pp = campaign.ship.particulars.L_pp, time_unit = std::sqrt(L_pp / kPolicy.reference_length_m);
  std::vector<std::function<Basis()>> result;
  for (const double lengths : kOf.latent_lengths)
    if (campaign.has_position)
      result.emplace_back([&moments, length = lengths * L_pp] {
        const Eigen::MatrixXd at = at_all_steps(moments, [](const Moment& m) { return Vec2<double>(m.x0, m.y0); });
        return process_over(at, length, Dependence::place, length, moments);
      });
  if (campaign.has_heading) result.emplace_back([&moments] { return headings(moments); });
  const bool has_answers = Identifiable(campaign, fit).has_answers();
  const auto states = std::make_shared<const States>(states_of(moments, L_pp, nu_sd, has_answers));
  for (const auto& set : states->sets)
    for (const double length : set.size() == 1 ? kOf.lengths_of_one_state : kOf.lengths_of_two_states)
      result.emplace_back([&moments, states, set, length] {
        Basis basis =
            process_over(states->values(set, Eigen::indexing::all), length, Dependence::states, kMissing, moments);
        for (const Eigen::Index i : set) basis.states.push_back(kStateChannels[static_cast<std::size_t>(i)]);
        return basis;
      });
  for (const double period_s : in_equal_ratios(kOf.latent_periods, kOf.shortest_period_s, kOf.longest_period_s))
    result.emplace_back([&moments, period = time_unit * period_s] { return oscillation(moments, period); });
  if (!has_answers) return result;
  const auto add_memory = [&](double time_s, bool rings) {
    result.emplace_back([&moments, L_pp, nu_sd, time = time_unit * time_s, rings] {
      return memory(moments, L_pp, time, rings, nu_sd);
    });
  };
  for (const double time_s : kOf.fading_s) add_memory(time_s, false);
  for (const double time_s : in_equal_ratios(kOf.ringing_periods, kOf.shortest_ringing_s, kOf.longest_ringing_s))
    add_memory(time_s, true);
  return result;
}

double log_mean_exp(const std::vector<double>& x) {
  const double most = *std::ranges::max_element(x);
  double sum = 0.0;
  for (const double one : x) sum += std::exp(one - most);
  return most + std::log(sum / static_cast<double>(x.size()));
}

// The evidence about theta, the first `known`, where some columns with standard normal strengths times `size` act as
// well.
Evidence without_columns(const Evidence& all, Eigen::Index known, const std::vector<Eigen::Index>& columns,
                         double size) {
  Evidence result(known);
  result.measurements = all.measurements;
  const auto n = static_cast<Eigen::Index>(columns.size());
  Eigen::MatrixXd M = size * size * all.F(columns, columns);
  M.diagonal().array() += 1.0;
  const Eigen::LLT<Eigen::MatrixXd> factor(M);
  const Eigen::VectorXd b = size * all.b(columns);
  const Eigen::MatrixXd cross = size * all.F.topRows(known)(Eigen::indexing::all, columns);
  const Eigen::MatrixXd solved = factor.solve(cross.transpose());
  result.b = all.b.head(known) - solved.transpose() * b;
  result.F = all.F.topLeftCorner(known, known) - cross * solved;
  result.log_likelihood = all.log_likelihood + 0.5 * b.dot(factor.solve(b)) -
                          (n > 0 ? factor.matrixLLT().diagonal().array().log().sum() : 0.0);
  return result;
}

// The model error of a fit, a share of it on some axes, with or without the events.
struct ModelError {
  std::vector<int> axes{};
  double share = 1.0;
  bool knows_events = true;
};

class Search {
 public:
  Search(const Campaign& campaign, const FittedNull& fit, std::size_t jobs)
      : fit_(fit),
        unit_(reference_acceleration(campaign.ship)),
        widths_(widths_by_scale(fit.stated, fit.parameters, fit.effects)),
        jobs_(jobs) {
    Basis nothing;
    nothing.values.resize(fit.stretches.size());
    for (const bool knows_events : {true, false}) {
      const ModelError error{{}, 1.0, knows_events};
      none_ = std::max(none_, evidence_with(nothing, {}, parts(nothing, error), error));
    }
  }

  /// Evidence of each stretch about theta and the columns.
  std::vector<Evidence> parts(const Basis& basis, const ModelError& error) const {
    Noise noise = fit_.noise;
    noise.knows_events = error.knows_events;
    // Not below the least that is told from none: what is less is less without a force, too.
    for (const int axis : error.axes)
      noise.sigma_w[axis] = std::max(error.share * noise.sigma_w[axis], noise.least_sigma_w[axis]);
    const Eigen::Index count = basis.columns();
    std::vector<Evidence> result(fit_.stretches.size());
    parallel_for(result.size(), jobs_, [&](std::size_t s) {
      const LinearStretch& stretch = fit_.stretches[s];
      result[s] = evidence(stretch, noise, count, [&](std::size_t k, Eigen::Ref<Eigen::MatrixXd> out) {
        out.noalias() = stretch.steps[k].A.middleCols<3>(kErrorStart) *
                        (unit_.asDiagonal() * basis.values[s].middleCols(static_cast<Eigen::Index>(k) * count, count));
      });
    });
    return result;
  }

  /// What a variant gains, averaged over sizes.
  double gain(const Basis& basis, const Variant& variant, const std::vector<Evidence>& parts,
              const ModelError& error) const {
    return evidence_with(basis, variant, parts, error) - none_;
  }
  double gain(const Basis& basis, const Variant& variant, const ModelError& error) const {
    return gain(basis, variant, parts(basis, error), error);
  }

 private:
  double evidence_with(const Basis& basis, const Variant& variant, const std::vector<Evidence>& parts,
                       const ModelError& error) const {
    const Eigen::Index known = fit_.theta.size();
    std::vector<Eigen::Index> columns;
    Eigen::Index first = known;
    for (int g = 0; g < kGroups; ++g) {
      const Eigen::Index count = basis.counts[static_cast<std::size_t>(g)];
      for (Eigen::Index i = 0; i < count && std::ranges::find(variant.groups, g) != variant.groups.end(); ++i)
        columns.push_back(first + i);
      first += count;
    }
    Evidence together(known + basis.columns());
    for (const Evidence& part : parts) together += part;
    std::vector<double> by_size;
    for (const double size : kOf.latent_sizes) {
      Evidence total(known);
      if (basis.is_of_recording)
        for (const Evidence& part : parts) total += without_columns(part, known, columns, size);
      else
        total = without_columns(together, known, columns, size);
      // Coefficients that stood in for it may be as stated beside it.
      by_size.push_back(file_evidence(total, fit_.theta, widths_).log_evidence);
    }
    return log_mean_exp(by_size) + (error.knows_events ? fit_.log_prior_of_events : 0.0);
  }

  const FittedNull& fit_;
  Vec3<double> unit_;
  std::vector<PriorWidths> widths_;
  std::size_t jobs_;
  double none_ = -std::numeric_limits<double>::infinity();
};

struct Tried {
  std::size_t basis;
  Variant variant;
  double gain;
};

}  // namespace

std::vector<LatentForce> latent_forces(const Campaign& campaign, const FittedNull& fit, std::size_t jobs) {
  Moments moments;
  for (const LinearStretch& stretch : fit.stretches) {
    moments.emplace_back();
    for (std::size_t k = 0; k < stretch.steps.size(); ++k) moments.back().push_back(moment_of(stretch, k));
  }
  if (std::ranges::all_of(moments, &std::vector<Moment>::empty)) return {};
  const std::vector<std::function<Basis()>> bases = bases_of(campaign, fit, moments);
  const Search search(campaign, fit, jobs);
  std::map<Dependence, std::vector<Tried>> tried;
  for (std::size_t b = 0; b < bases.size(); ++b) {
    const Basis basis = bases[b]();
    const std::vector<Evidence> parts = search.parts(basis, {});
    for (const Variant& variant : variants_of(basis.on))
      tried[basis.on].push_back({b, variant, search.gain(basis, variant, parts, {})});
  }
  std::vector<LatentForce> result;
  for (auto& [on, all] : tried) {
    std::ranges::sort(all, std::greater(), &Tried::gain);
    // With a force of its own the everyday model error is smaller, and what seemed events may be none.
    for (std::size_t i = 0; i < std::min(all.size(), kOf.latent_leading); ++i) {
      const Basis basis = bases[all[i].basis]();
      for (const double share : kOf.latent_errors)
        all[i].gain = std::max(all[i].gain, search.gain(basis, all[i].variant, {all[i].variant.axes, share}));
      all[i].gain = std::max(all[i].gain, search.gain(basis, all[i].variant, {{}, 1.0, false}));
    }
    const auto best = std::ranges::max_element(all, {}, &Tried::gain);
    std::vector<double> gains;
    for (const Tried& one : all) gains.push_back(one.gain);
    const Basis basis = bases[best->basis]();
    result.push_back({on, best->variant.axes, basis.argument, basis.rings, basis.states, log_mean_exp(gains)});
  }
  std::ranges::sort(result, std::greater(), &LatentForce::log_evidence);
  return result;
}

}  // namespace leeway::gap
