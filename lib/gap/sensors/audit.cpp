#include "gap/sensors/audit.hpp"

#include <algorithm>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "gap/policy/policy.hpp"
#include "gap/result/numbers.hpp"
#include "gap/sensors/audit_faults.hpp"
#include "gap/sensors/audit_fitter.hpp"
#include "gap/sensors/audit_search.hpp"
#include "gap/sensors/channel_quality.hpp"
#include "gap/sensors/kinematic_windows.hpp"

namespace leeway::gap {
namespace {

void note_channels(Audit& result) {
  for (const ChannelQuality& quality : result.channels) {
    const std::string_view name = info(quality.channel).name;
    if (quality.frozen_share > 0.0) result.notices.push_back(frozen_text(quality));
    if (quality.missing_share > 0.0)
      result.notices.push_back(fmt::format("{} lacks {} of its samples", name, percent(quality.missing_share)));
  }
}

void note_missing_channels(const std::vector<Trajectory>& recordings, Audit& result) {
  std::size_t without_track = 0, without_heading = 0;
  for (const Trajectory& recording : recordings) {
    if (!recording.has(Channel::psi))
      ++without_heading;
    else if (!recording.has(Channel::x0) || !recording.has(Channel::y0))
      ++without_track;
  }
  if (without_heading > 0)
    result.notices.push_back(fmt::format("{} of {} recordings have no heading: nothing could be checked there",
                                         without_heading, recordings.size()));
  if (without_track > 0)
    result.notices.push_back(
        fmt::format("{} of {} recordings have no positions: there only psi' - r could be checked; heading bias, lever "
                    "arm, faults of u and v_m, latencies of the velocities and a current stay unseen",
                    without_track, recordings.size()));
}

// A derived channel agrees with its source whatever that shows.
void note_derived_channels(const std::vector<Trajectory>& recordings, Audit& result) {
  for (const DerivableChannel& derivable : kDerivableChannels) {
    const auto count = std::count_if(recordings.begin(), recordings.end(), [&](const Trajectory& recording) {
      return recording.is_derived(derivable.channel);
    });
    if (count > 0)
      result.notices.push_back(
          fmt::format("{} of {} of {} recordings is derived from {}: that they agree is no check of either",
                      info(derivable.channel).name, count, recordings.size(), info(derivable.of).name));
  }
}

// The stages of an audit after the windows are known to hold enough.
class AuditStages {
 public:
  AuditStages(const KinematicWindows& windows, const AuditOptions& options)
      : fitter_(windows), options_(options), search_(fitter_, options) {}
  AuditStages(const AuditStages&) = delete;  // the search keeps a reference to the fitter
  AuditStages& operator=(const AuditStages&) = delete;

  // One fault after the other, or two that hide each other, as long as any is found. The candidates of the first step
  // are the hypotheses.
  FaultFit selected(std::vector<Fault>& hypotheses) const {
    FaultFit fit = fitter_.sound();
    for (std::size_t stage = 0, faults = 0, absorbed = 0;
         faults < kPolicy.sensors.most_faults && absorbed < kPolicy.sensors.most_absorbed; ++stage) {
      const std::vector<FaultFit> tried = search_.tried(fit);
      if (tried.empty()) break;
      const std::vector<double> p = search_.p_values(fit, tried, stage);
      if (stage == 0) hypotheses = hypotheses_of(fit, tried, p);
      const std::size_t best = search_.best(tried, p), before = fit.members.size();
      if (search_.is_found(tried[best], fit, p[best])) {
        fit = tried[best];
      } else if (const std::optional<FaultFit> pair = search_.pair_with(tried[best], stage)) {
        fit = *pair;
      } else {
        break;
      }
      // What is real but too small to matter stays in the fit, so that it does not feign another fault.
      for (std::size_t m = before; m < fit.members.size(); ++m) ++(is_small(fit, m) ? absorbed : faults);
    }
    return fit;
  }

  // A first choice can be a mixture of two faults: each member has to hold its place against all others, and what is
  // left of two that hid each other has to be found alone.
  FaultFit reconsidered(FaultFit fit) const {
    for (int round = 0; round < kPolicy.sensors.reconsidered_rounds; ++round)
      if (!replace_one(fit)) break;
    return fit;
  }

  // Each member with its rivals as a fault, or as a notice where it is too small.
  void report(const FaultFit& fit, Audit& result) const {
    for (std::size_t m = 0; m < fit.members.size(); ++m) {
      const FaultFit base = fitter_.without(fit, m);
      std::vector<FaultFit> tried = search_.tried(base);
      const auto is_own = [&](const FaultFit& of) { return of.members.back() == fit.members[m]; };
      if (std::none_of(tried.begin(), tried.end(), is_own)) tried.push_back(fitter_.with(base, fit.members[m]));
      const std::vector<double> p = search_.p_values(base, tried, 1000 + m);
      Fault fault = fault_of(fitter_, fit, m, resampling(1000 + m), options_.scale);
      const HeldoutGain gain = heldout_gain(fit, base);
      fault.heldout_gain = gain.sum;
      fault.heldout_gain_sd = gain.sd;
      for (std::size_t c = 0; c < tried.size(); ++c)
        if (is_own(tried[c]))
          fault.p_value = p[c] < options_.false_alarm ? p[c] : chance_of(gain, fitter_.windows().unit_count());
      if (is_small(fit, m)) {
        result.notices.push_back(fault.sentence + ": too little to matter");
        continue;
      }
      fault.rivals = rivals_of(fault, m, fit, base, tried, p);
      if (const std::optional<std::string> notice = rivals_notice(fault)) result.notices.push_back(*notice);
      result.faults.push_back(std::move(fault));
    }
    std::stable_sort(result.faults.begin(), result.faults.end(), gains_more);
  }

 private:
  static bool gains_more(const Fault& a, const Fault& b) { return a.heldout_gain > b.heldout_gain; }
  bool is_small(const FaultFit& fit, std::size_t place) const { return size_by_smallest(fitter_, fit, place) < 1.0; }
  RandomStream resampling(std::size_t stream) const { return {options_.seed, "audit resampling", stream}; }

  std::vector<Fault> hypotheses_of(const FaultFit& base, const std::vector<FaultFit>& tried,
                                   const std::vector<double>& p) const {
    std::vector<Fault> hypotheses;
    for (std::size_t c = 0; c < tried.size(); ++c) {
      Fault fault = fault_of(fitter_, tried[c], 0, resampling(c), options_.scale);
      const HeldoutGain gain = heldout_gain(tried[c], base);
      fault.heldout_gain = gain.sum;
      fault.heldout_gain_sd = gain.sd;
      fault.p_value = p[c];
      hypotheses.push_back(std::move(fault));
    }
    std::stable_sort(hypotheses.begin(), hypotheses.end(), gains_more);
    return hypotheses;
  }

  // Drops or replaces the first member that does not hold its place; false where all do.
  bool replace_one(FaultFit& fit) const {
    for (std::size_t m = 0; m < fit.members.size(); ++m) {
      const FaultFit base = fitter_.without(fit, m);
      const std::vector<FaultFit> tried = search_.tried(base);
      const std::vector<double> p = search_.p_values(base, tried, 1000 + m);
      const std::size_t first = search_.best(tried, p);
      const FaultFit& best = tried[first];
      if (!search_.predicts_better(best, base, p[first])) {
        fit = base;
        return true;
      }
      if (best.members.back() == fit.members[m]) continue;
      fit = best;
      return true;
    }
    return false;
  }

  // Other faults beside the same base that predict what was left out no worse for certain.
  std::vector<Fault> rivals_of(const Fault& fault, std::size_t place, const FaultFit& fit, const FaultFit& base,
                               const std::vector<FaultFit>& tried, const std::vector<double>& p) const {
    std::vector<Fault> rivals;
    for (std::size_t c = 0; c < tried.size(); ++c) {
      const HeldoutGain own = heldout_gain(tried[c], base);
      if (last_of(tried[c]).name == fault.name || !own.is_certain() || heldout_gain(fit, tried[c]).is_certain())
        continue;
      Fault rival =
          fault_of(fitter_, tried[c], tried[c].members.size() - 1, resampling(2000 + 100 * place + c), options_.scale);
      rival.heldout_gain = own.sum;
      rival.heldout_gain_sd = own.sd;
      rival.p_value = p[c];
      rival.log_odds = heldout_gain(tried[c], fit).sum;
      rivals.push_back(std::move(rival));
    }
    std::stable_sort(rivals.begin(), rivals.end(),
                     [](const Fault& a, const Fault& b) { return a.log_odds > b.log_odds; });
    return rivals;
  }

  FaultFitter fitter_;
  const AuditOptions& options_;
  FaultSearch search_;
};

}  // namespace

std::optional<std::string> rivals_notice(const Fault& fault) {
  std::set<std::string> names;
  for (const Fault& rival : fault.rivals) names.insert(rival.name);
  if (names.empty()) return std::nullopt;
  return fmt::format("{} fits best, but {} {} almost as well: these recordings do not distinguish them", fault.name,
                     fmt::join(names, ", "), names.size() == 1 ? "fits" : "fit");
}

Audit audit(const std::vector<Trajectory>& given, const AuditOptions& options) {
  Audit result;
  result.channels = channel_qualities(given, options.scale);
  note_channels(result);
  note_missing_channels(given, result);
  note_derived_channels(given, result);
  std::vector<Trajectory> recordings;
  recordings.reserve(given.size());
  for (const Trajectory& recording : given)
    recordings.push_back(at_3m(without_frozen(recording, options.scale), options.scale));

  const KinematicWindows windows(recordings);
  const bool has_track = has_enough(windows, Kinematics::track), has_heading = has_enough(windows, Kinematics::heading);
  if ((!has_track && !has_heading) || windows.unit_count() < kPolicy.sensors.fewest_units) {
    result.notices.push_back(fmt::format(
        "too little was recorded to compare track and velocities ({} stretches of {:.0f} s), or heading and yaw rate "
        "({}); {} are needed",
        windows.windows(Kinematics::track), windows.window_s() * options.scale.time,
        windows.windows(Kinematics::heading), kPolicy.sensors.fewest_windows));
    return result;
  }
  if (!has_heading) result.notices.push_back("psi' - r could not be checked: too few windows");

  const AuditStages stages(windows, options);
  const FaultFit fit = stages.reconsidered(stages.selected(result.hypotheses));
  stages.report(fit, result);
  result.is_checked = true;
  const SensorFaults found = sensor_faults(result.faults);
  if (found[FaultParameter::current_x] != 0.0 || found[FaultParameter::current_y] != 0.0)
    result.log_through_water = true;
  if (has_track)
    result.notices.push_back(
        "not visible here: a heading bias where u and v_m were turned by that heading, and a lever arm that positions "
        "and velocities share");
  return result;
}

}  // namespace leeway::gap
