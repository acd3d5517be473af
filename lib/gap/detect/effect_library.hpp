#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "core/units.hpp"
#include "gap/fit/null_fit.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {

/// Mean square by which the angles of rudders differ along a stretch between two ways of responding [rad^2].
double angle_change(const Stretch& stretch, const RecordedInputs& one, const RecordedInputs& other);
/// Root mean square that is no different from none: angles are not measured better, and the small ones by which an
/// autopilot answers to what the model does not know would be taken for late ones [rad].
inline constexpr double kKnownAngle = kPolicy.detect.known_angle_deg * kDegree;

/// Whether recordings say anything of an effect. Where in all of them the rudders tell more of the ship than the
/// sensors do, and no thruster pushes, they say nothing of how hull and rudders answer: the rudders go with what the
/// filter errs by, and look weaker or late, and the hull steadier, than they are (Soderstrom & Stoica 1989, System
/// Identification, chapter 10, on closed loops; with_helms(); docs/gap-locate.md). Nor do they where rudders
/// stay and the ship neither drifts nor turns (is_straight()).
class Identifiable {
 public:
  ///   fit  with nothing missing
  Identifiable(const Campaign& campaign, const FittedNull& fit);
  bool operator()(std::string_view effect) const;
  /// Whether they say anything of how hull and rudders answer.
  bool has_answers() const { return !keeps_course_; }

 private:
  bool keeps_course_ = false;
};

/// What each effect of the catalogue would do to each step of the simulator: the difference of two simulations over the
/// step, with the effect at a nominal strength and without. Effects with a direction have one column for each of four
/// directions, those with several strengths one for each. Not here are effects whose search does not start from one
/// linear step (SearchStart): what comes and goes is left to the scan over intervals, a current that varies to the
/// comparison, which fits its course, and what is bound to a place to the search for places, since at one that is not
/// its own a step shows nothing of it. Where rudders that act late or slowly would differ by less than kKnownAngle,
/// they are not applicable; nor is what is not Identifiable. With an ensemble, which has no forces to change, only what
/// follows from its own derivatives (EnsembleForm), a wind where it sees the wind.
class EffectLibrary {
 public:
  struct Entry {
    std::string name;
    Eigen::Index first = 0, count = 0;  ///< its columns
    bool is_one_sided = false;          ///< whether a negative strength makes no sense (a delay, shallow water)
  };

  EffectLibrary(const Campaign& campaign, const FittedNull& fit);

  const std::vector<Entry>& entries() const { return entries_; }
  const std::vector<std::string>& not_applicable() const { return not_applicable_; }
  Eigen::Index columns() const { return entries_.empty() ? 0 : entries_.back().first + entries_.back().count; }

  /// The columns of the given entries at step k of a stretch, for evidence().
  MoreColumns columns_of(std::size_t stretch, std::vector<std::size_t> entries) const;

 private:
  void add_derived();

  struct Variant {
    Model<double> model;
    const RudderResponse& response() const { return model.rudder_response(); }
  };
  const Campaign& campaign_;
  const FittedNull& fit_;
  std::vector<Model<double>> null_;             // by recording
  std::vector<std::vector<Variant>> variants_;  // by recording
  using Derived = std::function<Vec6(const LinearStretch& stretch, std::size_t k)>;
  std::vector<Derived> derived_;  // of an ensemble: by column
  std::vector<Entry> entries_;
  std::vector<std::string> not_applicable_;
};

}  // namespace leeway::gap
