#pragma once

#include <memory>
#include <string>
#include <vector>

#include "gap/fit/effect_columns.hpp"
#include "gap/fit/levels.hpp"
#include "gap/fit/null_fit.hpp"

/// Fits climb to the best parameters and noise levels.
namespace leeway::gap {

/// The columns of the effects of a hypothesis at coordinates z, one for each recording.
std::vector<EffectColumns> columns_by_recording(const Campaign& campaign, const Hypothesis& hypothesis,
                                                const Eigen::VectorXd& z, const Eigen::VectorXd& plain_theta);

enum class Judged { nothing, events, all };  // all: outliers as well

/// The way to the best parameters and noise levels, by Gauss-Newton steps along paths that are renewed.
class Climb {
 public:
  ///   knows_sensors  false: the noise of the measurements stays what it is
  Climb(const Campaign& campaign, FittedNull& fit, const Hypothesis& hypothesis, const FitOptions& options,
        bool knows_sensors);

  LevelProblem levels() const;

  /// Renews stretches and total at theta, from stretches near by.
  ///   neighbors  of measured_path(), of stretches that have none before
  void linearize_all(const std::vector<LinearStretch>& before, std::size_t neighbors = 0);
  /// The same along the path that the filter takes now; where the simulator runs away along it, they stay.
  void linearize_anew();
  /// Whether the simulator follows the recordings at all.
  bool follows() const;
  /// Continues until the steps converge or are too many; returns whether they converged.
  /// Outliers are judged on the way for nothing missing alone, so that hypotheses are compared on the same data.
  ///   levels_from  iteration in which noise levels move first, where outliers are judged: by default once the path has
  ///                been smoothed for the first time
  bool until_converged(int most_iterations, Judged judged, std::int64_t levels_from = 1);
  /// Judges the linearized stretches by the events that were found.
  void take_events();
  /// Leaves the stretches with the inputs as recorded, from which other fits begin.
  void restore_inputs();

 private:
  std::shared_ptr<const Stretch> acting_as(const EffectColumns& columns, std::size_t s);
  std::string diverged() const;
  void begin();
  void linearize_ensemble(const std::vector<LinearStretch>& before, std::size_t neighbors);
  void judge_all();
  Eigen::VectorXd slope_now() const { return fit_.total.b - fit_.prior.pull(fit_.theta); }
  Eigen::MatrixXd curvature_now() const;
  double distance_now() const;
  double log_posterior() const;
  Eigen::VectorXd step(double& damping, bool anyhow);
  void leave_out_outliers();
  bool leave_out_needless_events();

  const Campaign& campaign_;
  FittedNull& fit_;
  const Hypothesis& hypothesis_;
  const FitOptions& options_;
  const RudderResponse own_response_ = rudder_response_of(campaign_.ship);
  std::vector<std::shared_ptr<const Stretch>> own_;     // with the inputs as recorded, without outliers
  std::vector<std::shared_ptr<const Stretch>> acting_;  // with the inputs as rudders follow them late; nullptr: own_
  std::vector<RudderResponse> responses_ = std::vector<RudderResponse>(campaign_.stretches.size(), own_response_);
  std::vector<int> free_levels_;
};

}  // namespace leeway::gap
