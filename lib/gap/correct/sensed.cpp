#include "gap/correct/sensed.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "core/linear_algebra.hpp"
#include "core/parallel.hpp"
#include "gap/correct/sensing.hpp"
#include "gap/fit/coefficient_scale.hpp"
#include "gap/fit/events.hpp"
#include "gap/policy/policy.hpp"
#include "gap/sensors/audit.hpp"
#include "gap/sensors/sensor_faults.hpp"

namespace leeway::gap {
namespace {

// The free numbers of some faults, z, each in units of its usual size. A current's speed and set are none.
class FreeNumbers {
 public:
  FreeNumbers(const std::vector<Fault>& faults, const FroudeScale& scale) {
    for (std::size_t f = 0; f < faults.size(); ++f) {
      const FaultCandidate* candidate = candidate_of(faults[f]);
      if (candidate == nullptr) continue;
      std::size_t first = 0;
      for (const std::vector<FaultParameter>& number : candidate->numbers) {
        const FaultParameterInfo& of = info(number.front());
        places_.push_back({f, first, number.size(), of.usual_sd * scale.of(of.quantity) / of.unit});
        first += number.size();
      }
    }
  }
  Eigen::Index size() const { return static_cast<Eigen::Index>(places_.size()); }
  Eigen::VectorXd of(const std::vector<Fault>& faults) const {
    Eigen::VectorXd z(size());
    for (Eigen::Index i = 0; i < size(); ++i) {
      const Place& place = at(i);
      z[i] = faults[place.fault].parameters[place.first].value / place.unit;
    }
    return z;
  }
  void set(std::vector<Fault>& faults, const Eigen::VectorXd& z, const Eigen::VectorXd& sd) const {
    for (Eigen::Index i = 0; i < size(); ++i) {
      const Place& place = at(i);
      for (std::size_t j = place.first; j < place.first + place.count; ++j) {
        faults[place.fault].parameters[j].value = z[i] * place.unit;
        faults[place.fault].parameters[j].sd = sd[i] * place.unit;
      }
    }
  }

 private:
  struct Place {
    std::size_t fault, first, count;  // of the parameters of one number
    double unit;                      // in the unit of the name
  };
  const Place& at(Eigen::Index i) const { return places_[static_cast<std::size_t>(i)]; }
  std::vector<Place> places_;
};

// The path of the simulator at `parts` points for each of a stretch, from one to the next; what it misses there goes
// evenly.
std::vector<StateVector> fine_path(const Model<double>& model, const RecordedInputs& inputs,
                                   const std::vector<double>& t_s, const std::vector<StateVector>& path,
                                   std::size_t parts) {
  std::vector<StateVector> result;
  for (std::size_t k = 0; k + 1 < path.size(); ++k) {
    const double h = (t_s[k + 1] - t_s[k]) / static_cast<double>(parts);
    std::vector<StateVector> way(1, path[k]);
    for (std::size_t i = 0; i < parts; ++i) {
      way.push_back(path[k]);  // errors stay over a step
      way.back().head<kShipStates>() =
          advance<double>(model, way[i], {inputs.step(t_s[k] + static_cast<double>(i) * h, h)}, h);
    }
    const Vec6 missed = (path[k + 1] - way.back()).head<kShipStates>() / static_cast<double>(parts);
    for (std::size_t i = 0; i < parts; ++i) {
      way[i].head<kShipStates>() += static_cast<double>(i) * missed;
      result.push_back(way[i]);
    }
  }
  result.push_back(path.back());
  return result;
}

std::vector<double> fine_times(const std::vector<double>& t_s, std::size_t parts) {
  std::vector<double> result;
  for (std::size_t k = 0; k + 1 < t_s.size(); ++k)
    for (std::size_t i = 0; i < parts; ++i)
      result.push_back(t_s[k] + (t_s[k + 1] - t_s[k]) * static_cast<double>(i) / static_cast<double>(parts));
  result.push_back(t_s.back());
  return result;
}

using SensedColumns = Eigen::Matrix<double, kShipStates, Eigen::Dynamic>;

// The simulator and the faults on their way to the likeliest coefficients, numbers and noise levels.
class SensedFit {
 public:
  SensedFit(const Campaign& recorded, const FittedNull& near_by, std::vector<Fault>& faults, const FroudeScale& scale,
            std::size_t jobs)
      : recorded_(recorded),
        near_by_(near_by),
        faults_(faults),
        jobs_(jobs),
        numbers_(faults, scale),
        fit_(near_by),
        dtheta_(Eigen::VectorXd::Zero(near_by.theta.size())),
        columns_(recorded.stretches.size()),
        z_(numbers_.of(faults)),
        widths_(with_coordinates(widths_by_scale(fit_.stated, fit_.parameters, fit_.effects), fit_.theta.size(),
                                 numbers_.size())) {
    for (std::size_t s = 0; s < recorded.stretches.size(); ++s)
      fit_.stretches[s].data = std::make_shared<const Stretch>(recorded.stretches[s]);
  }

  std::optional<double> settle() {
    constexpr auto levels_at = kPolicy.decide.sensed_levels_at;
    for (std::int64_t iteration = 0; iteration < kPolicy.decide.sensed_iterations; ++iteration) {
      sense();
      // Outliers and noise levels are judged once the paths know the fault.
      if (iteration == levels_at.front()) leave_out_outliers();
      if (std::ranges::count(levels_at, iteration) > 0) fit_levels();
      const Evidence total = evidence_now();
      Eigen::VectorXd at(total.b.size());
      at << fit_.theta, z_;
      const FileEvidence file = file_evidence(total, at, widths_);
      if (!std::isfinite(file.log_evidence)) return std::nullopt;
      const Eigen::MatrixXd M = total.F + file.likeliest.prior.precision();
      const Eigen::MatrixXd covariance = M.llt().solve(Eigen::MatrixXd::Identity(M.rows(), M.cols()));
      const Eigen::VectorXd step = covariance * (total.b - file.likeliest.prior.pull(at)),
                            moved = step.tail(numbers_.size()),
                            sd = covariance.diagonal().tail(numbers_.size()).cwiseSqrt();
      if (iteration > levels_at.back() &&
          (moved.cwiseAbs().array() < kPolicy.decide.sensed_converged_sd * sd.array()).all()) {
        numbers_.set(faults_, z_, sd);
        for (Fault& fault : faults_) rephrase(fault);
        const Levels off = (levels_of(fit_.noise) - fit_.level_prior_mean).cwiseQuotient(fit_.level_prior_sd);
        return file.log_evidence - 0.5 * off.squaredNorm();
      }
      go(step.head(fit_.theta.size()), moved);
    }
    return std::nullopt;
  }

 private:
  SensorFaults faults_at(const Eigen::VectorXd& z) const {
    std::vector<Fault> moved = faults_;
    numbers_.set(moved, z, Eigen::VectorXd::Zero(z.size()));
    return sensor_faults(moved);
  }

  // What the sensors read along the paths as smoothed now, and its derivatives by the numbers.
  void sense() {
    const SensorFaults here = faults_at(z_);
    const double by = kPolicy.decide.sensed_step;
    std::vector<std::pair<SensorFaults, SensorFaults>> beside;
    for (Eigen::Index i = 0; i < z_.size(); ++i) {
      const Eigen::VectorXd d = by * Eigen::VectorXd::Unit(z_.size(), i);
      beside.emplace_back(faults_at(z_ - d), faults_at(z_ + d));
    }
    constexpr std::size_t parts = kPolicy.decide.sensed_parts;
    parallel_for(columns_.size(), jobs_, [&](std::size_t s) {
      const Stretch& data = *fit_.stretches[s].data;
      Model<double> model(recorded_.ship_in(data.recording));
      apply_uncertainty(model, (fit_.theta + dtheta_).head(fit_.theta.size() - 1).eval());
      const std::vector<double> t_s = fine_times(data.t_s, parts);
      const std::vector<StateVector> path =
          fine_path(model, recorded_.recorded_inputs[data.recording], data.t_s, fit_.smoothed[s].state, parts);
      const std::vector<Vec6> read = read_beside(here, t_s, path);
      for (std::size_t k = 0; k < data.size(); ++k)
        fit_.stretches[s].mean_offset[k] = near_by_.stretches[s].mean_offset[k] + read[k * parts];
      columns_[s].assign(data.size(), SensedColumns(kShipStates, z_.size()));
      for (Eigen::Index i = 0; i < z_.size(); ++i) {
        const auto& [below, above] = beside[static_cast<std::size_t>(i)];
        const std::vector<Vec6> less = read_beside(below, t_s, path), more = read_beside(above, t_s, path);
        for (std::size_t k = 0; k < data.size(); ++k)
          columns_[s][k].col(i) = (more[k * parts] - less[k * parts]) / (2.0 * by);
      }
    });
  }

  void leave_out_outliers() {
    const std::vector<std::shared_ptr<const Stretch>> judged = without_outliers(fit_);
    for (std::size_t s = 0; s < judged.size(); ++s)
      if (judged[s]) fit_.stretches[s].data = judged[s];
  }

  void fit_levels() {
    const LevelProblem levels{fit_.stretches,
                              fit_.theta,
                              fit_.prior,
                              ExtraColumns{0, nullptr},
                              fit_.noise,
                              fit_.level_prior_mean,
                              fit_.level_prior_sd,
                              free_levels(true, recorded_.has_wind, fit_.noise.one_receiver),
                              jobs_};
    const auto steps = static_cast<int>(kPolicy.decide.sensed_level_steps);
    fit_.noise = noise_of(levels.minimize(levels_of(fit_.noise), steps, fit_.level_curvature), fit_.noise);
  }

  // About theta and the numbers.
  Evidence evidence_now() const {
    std::vector<Evidence> of(columns_.size());
    parallel_for(columns_.size(), jobs_, [&](std::size_t s) {
      of[s] = evidence(fit_.stretches[s], fit_.noise, 0, nullptr,
                       {z_.size(), [&](std::size_t k, Eigen::Ref<Eigen::MatrixXd> out) { out = columns_[s][k]; }});
    });
    Evidence total(fit_.theta.size() + z_.size());
    for (const Evidence& one : of) total += one;
    return total;
  }

  // The paths as smoothed with numbers and theta a step on.
  void go(const Eigen::VectorXd& dtheta, const Eigen::VectorXd& dz) {
    z_ += dz;
    dtheta_ = dtheta;
    parallel_for(columns_.size(), jobs_, [&](std::size_t s) {
      for (std::size_t k = 0; k < columns_[s].size(); ++k) fit_.stretches[s].mean_offset[k] += columns_[s][k] * dz;
      fit_.smoothed[s] = smooth(fit_.stretches[s], fit_.noise, dtheta);
    });
  }

  const Campaign& recorded_;
  const FittedNull& near_by_;
  std::vector<Fault>& faults_;
  std::size_t jobs_;
  FreeNumbers numbers_;
  FittedNull fit_;          // linearized where near_by_ is
  Eigen::VectorXd dtheta_;  // from there
  std::vector<std::vector<SensedColumns>> columns_;
  Eigen::VectorXd z_;
  std::vector<PriorWidths> widths_;
};

}  // namespace

SensedCampaign::SensedCampaign(Campaign recorded, const FittedNull& near_by, const FroudeScale& scale, std::size_t jobs)
    : recorded_(std::move(recorded)), near_by_(near_by), scale_(scale), jobs_(jobs) {}

std::optional<double> SensedCampaign::fit(std::vector<Fault>& faults) const {
  const auto has_same_times = [](const Stretch& a, const LinearStretch& b) { return a.t_s == b.data->t_s; };
  if (!std::ranges::equal(recorded_.stretches, near_by_.stretches, has_same_times)) return std::nullopt;
  return SensedFit(recorded_, near_by_, faults, scale_, jobs_).settle();
}

}  // namespace leeway::gap
