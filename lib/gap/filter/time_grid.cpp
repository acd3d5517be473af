#include "gap/filter/time_grid.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "core/statistics.hpp"
#include "core/wind.hpp"
#include "dynamics/model.hpp"
#include "gap/filter/campaign.hpp"
#include "gap/filter/reference_units.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {
namespace {

// Noise of single samples of u, v_m and r, from second differences, which leave little of the ship's motion.
Vec3<double> noise_of_samples(const std::vector<Driven>& recordings) {
  Vec3<double> sd;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> differences;
    for (const Driven& driven : recordings) {
      const std::vector<double>& x = (*driven.recording)[kMeasured[static_cast<std::size_t>(axis) + 3]];
      for (std::size_t i = 2; i < x.size(); ++i)
        if (const double bend = x[i] - 2.0 * x[i - 1] + x[i - 2]; std::isfinite(bend)) differences.push_back(bend);
    }
    sd[axis] = robust_sd(std::move(differences)) / std::sqrt(6.0);
  }
  return sd;
}

// Accelerations of the ship at the samples of a bin, as what drives her changes; she herself as she is in the mean, so
// that noise of the sensors makes no corners. NaN where a velocity is not known.
std::vector<Vec3<double>> accelerations(const Model<double>& model, const Driven& driven, std::size_t first,
                                        std::size_t end) {
  const Trajectory& t = *driven.recording;
  Vec3<double> nu = Vec3<double>::Zero();
  for (std::size_t i = first; i < end; ++i)
    nu += Vec3<double>(t[Channel::u][i], t[Channel::vm][i], t[Channel::r][i]) / static_cast<double>(end - first);
  const double psi = t.has(Channel::psi) ? t[Channel::psi][first] : 0.0;
  std::vector<Vec3<double>> result;
  for (std::size_t i = first; i < end; ++i) {
    const Inputs<double> inputs = driven.inputs.at(t[Channel::t][i]);
    result.push_back(
        model.acceleration(nu, inputs.actuators, apparent_wind<double>(inputs.true_wind, psi, nu[0], nu[1])));
  }
  return result;
}

// By how much the mean velocity of a bin differs from that of a parabola, squared; 0 where it is not known. The
// velocity is the integral of the accelerations from the middle on, by the trapezoidal rule.
//   t, a  of its samples
Vec3<double> squared_error(std::span<const double> t, const std::vector<Vec3<double>>& a) {
  const auto n = static_cast<double>(t.size());
  double middle_s = 0.0, spread_s2 = 0.0;
  for (std::size_t i = 0; i < t.size(); ++i) middle_s += t[i] / n;
  Vec3<double> mean_a = Vec3<double>::Zero(), slope = Vec3<double>::Zero();
  for (std::size_t i = 0; i < t.size(); ++i) {
    spread_s2 += (t[i] - middle_s) * (t[i] - middle_s) / n;
    slope += (t[i] - middle_s) / n * a[i];
    mean_a += a[i] / n;
  }
  slope /= spread_s2;
  // Less what is constant, which has no mean, so that the middle is where the velocity is zero.
  Vec3<double> velocity = Vec3<double>::Zero(), at_middle = velocity, mean = velocity;
  for (std::size_t i = 0; i < t.size(); ++i) {
    if (i > 0) {
      const double h = t[i] - t[i - 1], from = middle_s - t[i - 1];
      if (from >= 0.0 && middle_s < t[i])
        at_middle = velocity + from * (a[i - 1] - mean_a) + 0.5 * from * from / h * (a[i] - a[i - 1]);
      velocity += 0.5 * h * (a[i] + a[i - 1] - 2.0 * mean_a);
    }
    mean += velocity / n;
  }
  const Vec3<double> off = mean - at_middle - 0.5 * spread_s2 * slope;
  return off.allFinite() ? Vec3<double>(off.cwiseAbs2()) : Vec3<double>::Zero();
}

// How clearly the errors of all means together stand out of their noise: d', the root of the sum of squares.
double separability(const Model<double>& model, const std::vector<Driven>& recordings, const Vec3<double>& noise,
                    const Vec3<double>& least, double step_s) {
  double sum = 0.0;
  for (const Driven& driven : recordings) {
    const Trajectory& recording = *driven.recording;
    if (!recording.has(Channel::u) || !recording.has(Channel::vm) || !recording.has(Channel::r)) continue;
    const std::span<const double> t = recording[Channel::t];
    const double sample_s = sampling_time_s(recording);
    if (t.size() < 3 || sample_s >= kPolicy.filter.thinned_below * step_s) continue;
    const auto n = static_cast<std::size_t>(std::round(step_s / sample_s));
    if (n < 3) continue;
    Vec3<double> errors = Vec3<double>::Zero();
    for (std::size_t first = 0; first + n <= t.size(); first += n)
      if (t[first + n - 1] - t[first] <= step_s)  // no hole between them
        errors += squared_error(t.subspan(first, n), accelerations(model, driven, first, first + n));
    const Vec3<double> of_mean = (noise / std::sqrt(static_cast<double>(n))).cwiseMax(least);
    sum += errors.cwiseQuotient(of_mean.cwiseAbs2()).sum();
  }
  return std::sqrt(sum);
}

}  // namespace

double grid_step_s(const Ship& ship, const std::vector<Driven>& recordings, double usual_s) {
  const Vec3<double> noise = noise_of_samples(recordings), least = least_measurement_sd(ship).tail<3>();
  if ((noise.array() <= least.array()).all()) return usual_s;
  const Model<double> model(ship);
  double step_s = usual_s;
  while (step_s > kPolicy.filter.finest_grid * usual_s * (1.0 + kPolicy.filter.same_bin) &&
         separability(model, recordings, noise, least, step_s) > kPolicy.filter.grid_separability)
    step_s *= 0.5;
  return step_s;
}

}  // namespace leeway::gap
