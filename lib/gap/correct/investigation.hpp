#pragma once

#include <memory>
#include <vector>

#include "gap/detect/effect_library.hpp"
#include "gap/fit/null_fit.hpp"
#include "gap/policy/options.hpp"
#include "gap/sensors/froude_scale.hpp"

/// The recordings read and corrected as they fit the simulator, and the simulator fitted to them.
namespace leeway::gap {

/// What gap-locate finds, with what it is based on, to continue from.
struct Investigation {
  Findings findings;
  Campaign campaign;
  FittedNull null;
};

/// The stages up to what is left of the recordings, in the order in which they are called. Each reads and writes
/// `result`; the recordings are corrected in place.
class Investigator {
 public:
  ///   ensemble  the simulator in place of the ship's equations of motion; nullptr: none
  /// Throws InputError for recordings that cannot be used.
  Investigator(const Ship& ship, std::shared_ptr<const EnsembleSimulator> ensemble, std::vector<Trajectory>& recordings,
               const GapLocateOptions& options);

  /// Whether signs, units and frames are those that the columns state. What is contradicted is read as it fits.
  void check_conventions();
  /// The recordings against themselves; faults are corrected.
  void audit_sensors();
  /// The simulator fitted within its stated uncertainty.
  void fit();
  /// A faint fault, corrected where there is none, would look like missing physics: it stays only where the recordings
  /// are not likelier without it in the measurement function. Its p-value is then what the filter says as well, if
  /// that is smaller.
  void withdraw_faint_faults();
  /// Faults that the kinematics leave open, as the filter sees them, which knows the ship's forces and the sizes of the
  /// noise: one after another, where it is likelier than sound sensors and than any one effect.
  void identify_faults();
  /// The likeliest of each fault and its rivals, and their numbers, where all stand in the measurement function.
  void refine_faults();
  /// Effects of the catalogue around the fit.
  void test_effects();
  /// Where something is left: a wind that reads otherwise, as the fit sees it.
  void reread_wind();

  Investigation result;

 private:
  void progress(double done, const std::string& note) const;
  /// Without frozen channels, which say nothing.
  std::vector<Trajectory> moving(const std::vector<Trajectory>& recordings) const;
  void correct(const std::vector<Fault>& faults);
  void fit_anew(const FittedNull* near_by = nullptr);
  bool is_corrected() const;
  /// p-values of faults that the filter sees beside a fit without them.
  void judge_by_forces(std::vector<Fault>& faults) const;

  const Ship& ship_;
  const FroudeScale scale_;
  std::shared_ptr<const EnsembleSimulator> ensemble_;
  std::vector<Trajectory>& recordings_;
  const GapLocateOptions& options_;
  CampaignOptions campaign_options_;
  FitOptions fit_options_;
  std::vector<Trajectory> reread_;  ///< as recorded, but for conventions
  std::vector<Fault> certain_;      ///< faults that the simulator is not asked about
};

}  // namespace leeway::gap
