#include "gap/filter/campaign.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/errors.hpp"
#include "core/statistics.hpp"
#include "core/units.hpp"
#include "gap/filter/actuator_errors.hpp"
#include "gap/filter/time_grid.hpp"
#include "gap/policy/policy.hpp"
#include "gap/sensors/channel_quality.hpp"

namespace leeway::gap {
namespace {

struct Point {
  double t_s;
  Vec6 measured;
  double spread_s2 = 0.0;
  bool is_measured() const { return !measured.array().isNaN().all(); }
};

// Why nothing can be learned from a recording; empty if something can.
std::string useless(const Trajectory& recording, const RecordedInputs& inputs) {
  if (recording.size() < 2) return "it has a single sample";
  const auto has_value = [](double x) { return std::isfinite(x); };
  for (const Channel channel : inputs.channels())
    if (std::none_of(recording[channel].begin(), recording[channel].end(), has_value))
      return fmt::format("'{}' has no value at all, and the ship needs it", column_name(channel));
  if (!inputs.first_known()) return "at no sample all actuators and the wind are known";
  return is_at_rest(recording) ? "no measured channel ever changes: the ship is at rest, or nothing was recorded" : "";
}

// Means over bins of `bin_s`; every sample is a bin of its own where bin_s is 0.
std::vector<Point> binned(const Trajectory& recording, std::size_t first, double bin_s) {
  const std::vector<double>& t = recording[Channel::t];
  std::vector<Point> points;
  for (std::size_t i = first; i < t.size();) {
    const double bin = bin_s > 0.0 ? std::floor((t[i] - t[first]) / bin_s + kPolicy.filter.same_bin) : 0.0;
    std::size_t end = i + 1;
    while (bin_s > 0.0 && end < t.size() && std::floor((t[end] - t[first]) / bin_s + kPolicy.filter.same_bin) == bin)
      ++end;
    const auto n = static_cast<double>(end - i);
    Point point{0.0, Vec6::Constant(kMissing)};
    for (std::size_t k = i; k < end; ++k) point.t_s += t[k] / n;
    for (std::size_t k = i; k < end; ++k) point.spread_s2 += (t[k] - point.t_s) * (t[k] - point.t_s) / n;
    for (std::size_t c = 0; c < kMeasured.size(); ++c) {
      const std::vector<double>& values = recording[kMeasured[c]];
      if (values.empty()) continue;
      double sum = 0.0, known = 0.0;
      for (std::size_t k = i; k < end; ++k)
        if (std::isfinite(values[k])) sum += values[k], known += 1.0;
      if (known == n) point.measured[static_cast<Eigen::Index>(c)] = sum / known;
    }
    points.push_back(point);
    i = end;
  }
  return points;
}

// Time over which the noise of each measured channel is correlated; 0: from point to point it is not. Quick turns look
// like correlated noise of heading and yaw rate, and hide it: they have what most of the others have.
Vec6 correlation_s(const std::vector<Trajectory>& recordings, const FroudeScale& scale) {
  constexpr std::array kJudged{Channel::u, Channel::vm, Channel::x0, Channel::y0};
  Vec6 result = Vec6::Zero();
  std::vector<double> correlated;
  std::size_t judged = 0;
  for (const ChannelQuality& quality : channel_qualities(recordings, scale)) {
    if (std::find(kJudged.begin(), kJudged.end(), quality.channel) == kJudged.end()) continue;
    ++judged;
    if (quality.correlation_s > 0.0) correlated.push_back(quality.correlation_s);
    for (std::size_t c = 0; c < kMeasured.size(); ++c)
      if (kMeasured[c] == quality.channel) result[static_cast<Eigen::Index>(c)] = quality.correlation_s;
  }
  if (static_cast<double>(correlated.size()) < kPolicy.filter.correlated_share * static_cast<double>(judged) ||
      correlated.empty())
    return result;
  for (std::size_t c = 0; c < kMeasured.size(); ++c)
    if (kMeasured[c] == Channel::psi || kMeasured[c] == Channel::r)
      result[static_cast<Eigen::Index>(c)] = median(correlated);
  return result;
}

// The filter takes noise as independent from point to point. Where it is not, most measurements would add
// little to the one before, and be believed: they are left out.
void leave_out_repeated_noise(Campaign& campaign) {
  const Vec6 correlation = correlation_s(campaign.recordings, FroudeScale(campaign.ship.particulars.L_pp));
  std::map<double, std::vector<std::string>> thinned;
  for (Eigen::Index c = 0; c < correlation.size(); ++c) {
    const double every = std::min(
        std::ceil(kPolicy.filter.independent * correlation[c] / campaign.step_s - kPolicy.filter.nearly_a_step),
        kPolicy.filter.most_left_out);
    if (every < 2.0) continue;
    const double apart_s = (every - kPolicy.filter.nearly_a_step) * campaign.step_s;
    for (Stretch& stretch : campaign.stretches) {
      double last_s = -std::numeric_limits<double>::infinity();
      for (std::size_t k = 0; k < stretch.size(); ++k) {
        double& measured = stretch.measured[k][c];
        if (std::isnan(measured)) continue;
        if (stretch.t_s[k] - last_s < apart_s)
          measured = kMissing;
        else
          last_s = stretch.t_s[k];
      }
    }
    thinned[every * campaign.step_s].push_back(column_name(kMeasured[static_cast<std::size_t>(c)]));
  }
  for (const auto& [every_s, columns] : thinned)
    campaign.notices.push_back(
        fmt::format("errors of neighboring samples of {} are alike: one measurement every {:.3g} s is used",
                    fmt::join(columns, ", "), every_s));
}

}  // namespace

std::size_t Campaign::points() const {
  std::size_t n = 0;
  for (const Stretch& stretch : stretches) n += stretch.size();
  return n;
}

Ship Campaign::ship_in(std::size_t recording) const {
  Ship result = ship;
  result.effects.insert(result.effects.end(), own_effects[recording].begin(), own_effects[recording].end());
  return result;
}

StepInputs<double> averaged_step(const RecordedInputs& inputs, double t_s, double dt_s) {
  StepInputs<double> step = inputs.step(t_s, dt_s);
  std::array<StepInputs<double>, kPolicy.filter.averaged_parts> parts;
  for (int i = 0; i < kPolicy.filter.averaged_parts; ++i) {
    const double from_s = t_s + dt_s * i / kPolicy.filter.averaged_parts;
    parts[static_cast<std::size_t>(i)] = inputs.step(from_s, dt_s / kPolicy.filter.averaged_parts);
  }
  const auto average = [&](const auto& value) {
    double mean = 0.0;
    for (StepInputs<double>& part : parts) mean += value(part.middle) / kPolicy.filter.averaged_parts;
    value(step.middle) = 0.25 * (6.0 * mean - value(step.start) - value(step.end));
  };
  for (std::size_t i = 0; i < kActuatorChannels.size(); ++i)
    average([i](Inputs<double>& in) -> double& { return in.actuators.values[i]; });
  for (const Eigen::Index i : {0, 1}) average([i](Inputs<double>& in) -> double& { return in.true_wind[i]; });
  return step;
}

void set_inputs(Stretch& stretch, const RecordedInputs& inputs, const Ship& ship) {
  set_inputs(stretch, inputs, std::sqrt(ship.particulars.L_pp / kGravity_mps2));
}

void set_inputs(Stretch& stretch, const RecordedInputs& inputs, double longest_s) {
  stretch.inputs.clear();
  stretch.late_inputs.clear();
  double wind_speed = 0.0;
  for (std::size_t k = 0; k + 1 < stretch.size(); ++k) {
    const auto substeps =
        static_cast<std::size_t>(std::ceil(stretch.dt_s(k) / longest_s - kPolicy.filter.same_substep));
    const double h = stretch.dt_s(k) / static_cast<double>(substeps);
    std::vector<StepInputs<double>>& step = stretch.inputs.emplace_back();
    std::vector<StepInputs<double>>& late = stretch.late_inputs.emplace_back();
    for (std::size_t i = 0; i < substeps; ++i) {
      const double from_s = stretch.t_s[k] + static_cast<double>(i) * h;
      step.push_back(averaged_step(inputs, from_s, h));
      late.push_back(step.back());
      const StepInputs<double> before =
          averaged_step(inputs, from_s - kPolicy.filter.timing_share * stretch.sample_s, h);
      late.back().start.actuators = before.start.actuators;
      late.back().middle.actuators = before.middle.actuators;
      late.back().end.actuators = before.end.actuators;
    }
    wind_speed += step.front().start.true_wind.norm();
  }
  stretch.wind_speed_mps = wind_speed / static_cast<double>(stretch.size() - 1);
}

namespace {

// Puts recordings on a campaign's time grid, one after the other; what is said of many of them is said at the end.
class Preparation {
 public:
  Preparation(const Ship& ship, const CampaignOptions& options)
      : options_(options), response_(rudder_response_of(ship)) {
    campaign_.ship = ship;
    campaign_.ensemble = options.ensemble;
    const double time_unit_s = std::sqrt(ship.particulars.L_pp / kGravity_mps2);
    substep_s_ = options.ensemble ? options.ensemble->time_step_s() : time_unit_s;
    const double usual_step_s = options.ensemble ? substep_s_ : kPolicy.filter.step_time_units * time_unit_s;
    target_s_ = options.step_s > 0.0 ? options.step_s : usual_step_s;
    adapts_ = options.step_s == 0.0 && !options.ensemble;
    gap_s_ = options.gap_s > 0.0 ? options.gap_s : kPolicy.filter.longest_gap_s * campaign_.time_scale();
  }

  void read_inputs(const std::vector<Trajectory>& recordings) {
    std::vector<Driven> driven;
    for (const Trajectory& recording : recordings) {
      if (options_.ensemble) options_.ensemble->check(recording);
      campaign_.recorded_inputs.emplace_back(recording, campaign_.ship, InputInterpolation::at_actuator_rate);
      driven.push_back({&recording, campaign_.recorded_inputs.back().through(response_)});
    }
    actuator_errors_.emplace(recordings, campaign_.ship);
    if (adapts_) target_s_ = grid_step_s(campaign_.ship, driven, target_s_);
  }

  void add(std::size_t index, const Trajectory& recording) {
    const RecordedInputs inputs = campaign_.recorded_inputs[index].through(response_);
    note_channels(recording, inputs);
    if (const std::string why = useless(recording, inputs); !why.empty()) {
      campaign_.notices.push_back(fmt::format("{}: {}; left out", recording.file, why));
      return;
    }
    const double sample_s = sampling_time_s(recording);
    if (sample_s > gap_s_) {
      campaign_.notices.push_back(fmt::format(
          "{}: its samples are {:.3g} s apart, and holes longer than {:.3g} s are not passed over; left out",
          recording.file, sample_s, gap_s_));
      return;
    }
    with_wind_ += inputs.has_wind() ? 1 : 0;
    ++used_;

    const bool is_thinned = sample_s < kPolicy.filter.thinned_below * target_s_;
    const double bin_s = is_thinned ? std::round(target_s_ / sample_s) * sample_s : 0.0;
    const double step_s = is_thinned ? bin_s : sample_s;
    if (is_thinned && bin_s > kPolicy.filter.thinning_worth_a_word * sample_s)
      ++thinned_[fmt::format("sampled every {:.3g} s, thinned to means over {:.3g} s", sample_s, bin_s)];
    steps_.push_back(step_s);
    add_stretches(index, recording, inputs, parts(recording, binned(recording, *inputs.first_known(), bin_s), step_s),
                  step_s);
  }

  Campaign finish(std::vector<Trajectory> recordings) {
    if (campaign_.stretches.empty()) {
      const std::string why = campaign_.notices.empty() ? "" : " (" + campaign_.notices.back() + ")";
      throw InputError(recordings.front().file, "no recording is long enough" + why);
    }
    if (with_wind_ > 0 && with_wind_ < used_)
      campaign_.notices.push_back(fmt::format(
          "{} of {} recordings have no wind columns while the others have: what the wind did there shows as "
          "missing physics; give them their wind, or leave them out",
          used_ - with_wind_, used_));
    for (const auto& [how, count] : thinned_)
      campaign_.notices.push_back(fmt::format("{} of {} recordings: {}", count, recordings.size(), how));
    for (std::string& notice : actuator_errors_->notices()) campaign_.notices.push_back(std::move(notice));
    campaign_.step_s = median(std::move(steps_));
    campaign_.own_effects.resize(recordings.size());
    campaign_.recordings = std::move(recordings);
    leave_out_repeated_noise(campaign_);
    return std::move(campaign_);
  }

 private:
  void note_channels(const Trajectory& recording, const RecordedInputs& inputs) {
    for (const std::string& notice : inputs.notices()) campaign_.notices.push_back(notice);
    campaign_.has_wind |= inputs.has_wind();
    for (const Channel channel : kMeasured)
      if (recording.has(channel) &&
          std::none_of(recording[channel].begin(), recording[channel].end(), [](double x) { return std::isfinite(x); }))
        campaign_.notices.push_back(
            fmt::format("{}: '{}' has no value at all and is left out", recording.file, column_name(channel)));
    campaign_.has_position |= recording.has(Channel::x0) && recording.has(Channel::y0);
    campaign_.has_heading |= recording.has(Channel::psi);
  }

  // Parts end at holes; short holes are bridged by points without measurements.
  std::vector<std::vector<Point>> parts(const Trajectory& recording, const std::vector<Point>& points, double step_s) {
    std::vector<std::vector<Point>> parts;
    const std::vector<std::pair<double, double>> lost = actuator_errors_->lost(recording, step_s);
    auto next = lost.begin();
    double last_measured_s = -1e300, longest_hole_s = 0.0, longest_from_s = 0.0;
    std::size_t holes = 0;
    for (const Point& point : points) {
      if (!point.is_measured()) continue;
      bool is_cut = false;  // by what nobody knows of an actuator
      while (next != lost.end() && next->second <= point.t_s) ++next, is_cut = true;
      if (next != lost.end() && next->first < point.t_s) continue;
      if (const double hole_s = point.t_s - last_measured_s;
          !parts.empty() && !is_cut && hole_s > kPolicy.filter.hole_steps * step_s) {
        ++holes;
        if (hole_s > longest_hole_s) longest_hole_s = hole_s, longest_from_s = last_measured_s;
      }
      const bool is_after_gap =
          is_cut || point.t_s - last_measured_s > std::max(gap_s_, kPolicy.filter.hole_steps * step_s);
      if (is_after_gap || parts.back().size() >= kPolicy.filter.most_points) parts.emplace_back();
      std::vector<Point>& part = parts.back();
      if (!part.empty()) {
        const double from_s = part.back().t_s, hole_s = point.t_s - from_s;
        const auto n = static_cast<int>(std::lround(hole_s / step_s));
        for (int k = 1; k < n && hole_s > kPolicy.filter.hole_steps * step_s; ++k)
          part.push_back({from_s + hole_s * k / n, Vec6::Constant(kMissing)});
      }
      part.push_back(point);
      last_measured_s = point.t_s;
    }
    if (holes > 0)
      campaign_.notices.push_back(fmt::format(
          "{}: {} hole{} without any measurement, the longest of {:.3g} s from {:.4g} s on; {}", recording.file, holes,
          holes > 1 ? "s" : "", longest_hole_s, longest_from_s,
          longest_hole_s > gap_s_ ? "holes longer than " + fmt::format("{:.3g} s", gap_s_) + " cut it in pieces"
          : lost.empty()          ? "the filter passes over them"
                                  : "the filter passes over those in which it is known what actuators did"));
    if (!lost.empty())
      campaign_.notices.push_back(
          fmt::format("{}: nobody knows what actuators did in {} hole{}, the first of {:.3g} s from {:.4g} s on: such "
                      "holes cut it in pieces",
                      recording.file, lost.size(), lost.size() > 1 ? "s" : "", lost.front().second - lost.front().first,
                      lost.front().first));
    return parts;
  }

  void add_stretches(std::size_t index, const Trajectory& recording, const RecordedInputs& inputs,
                     const std::vector<std::vector<Point>>& parts, double step_s) {
    double left_out_s = 0.0;
    std::size_t kept = 0;
    for (const std::vector<Point>& part : parts) {
      if (part.size() < kPolicy.filter.fewest_points) {
        left_out_s += part.back().t_s - part.front().t_s;
        continue;
      }
      ++kept;
      Stretch stretch;
      stretch.recording = index;
      for (const Point& point : part) {
        stretch.t_s.push_back(point.t_s);
        stretch.measured.push_back(point.measured);
        stretch.spread_s2.push_back(point.spread_s2);
      }
      stretch.sample_s = sampling_time_s(recording);
      set_inputs(stretch, inputs, substep_s_);
      actuator_errors_->set(stretch, recording);
      campaign_.stretches.push_back(std::move(stretch));
    }
    const double least_s = static_cast<double>(kPolicy.filter.fewest_points) * step_s;
    if (kept == 0)
      campaign_.notices.push_back(
          fmt::format("{}: shorter than the {:.3g} s that a window needs; left out", recording.file, least_s));
    else if (left_out_s > 0.0)
      campaign_.notices.push_back(
          fmt::format("{}: {:.3g} s lie in pieces shorter than {:.3g} s between gaps and are left out", recording.file,
                      left_out_s, least_s));
  }

  Campaign campaign_;
  const CampaignOptions& options_;
  const RudderResponse response_;  // that the simulator itself knows
  std::optional<ActuatorErrors> actuator_errors_;
  double substep_s_, target_s_, gap_s_;
  bool adapts_;  // whether the grid follows what means over it would be off by
  std::vector<double> steps_;
  std::map<std::string, std::size_t> thinned_;
  std::size_t used_ = 0, with_wind_ = 0;
};

}  // namespace

Campaign prepare(const Ship& ship, std::vector<Trajectory> recordings, const CampaignOptions& options) {
  for (std::size_t a = 0; a < recordings.size(); ++a)
    for (std::size_t b = 0; b < a; ++b)
      if (same_contents(recordings[a], recordings[b]))
        throw InputError(recordings[a].file,
                         fmt::format("holds the same as {}; a recording counts once", recordings[b].file));
  Preparation preparation(ship, options);
  preparation.read_inputs(recordings);
  for (std::size_t i = 0; i < recordings.size(); ++i) preparation.add(i, recordings[i]);
  return preparation.finish(std::move(recordings));
}

}  // namespace leeway::gap
