#include "gap/campaign.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/errors.hpp"
#include "core/units.hpp"
#include "gap/channel_quality.hpp"

namespace leeway::gap {
namespace {

constexpr std::size_t kFewestPoints = 20;  // of a stretch: about two correlation times of the model error
constexpr std::size_t kMostPoints = 1500;  // then a new stretch begins, so that threads share long recordings
constexpr double kIndependent = 2.0;   // correlation times of the noise after which a measurement tells something new
constexpr double kMostLeftOut = 10.0;  // points of the grid between two measurements

double median_interval(const std::vector<double>& t) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < t.size(); ++i) steps.push_back(t[i] - t[i - 1]);
  if (steps.empty()) return 0.0;
  std::nth_element(steps.begin(), steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2), steps.end());
  return steps[steps.size() / 2];
}

bool same_contents(const Trajectory& a, const Trajectory& b) {
  const auto same = [](const std::vector<double>& x, const std::vector<double>& y) {
    return std::equal(x.begin(), x.end(), y.begin(), y.end(),
                      [](double p, double q) { return p == q || (std::isnan(p) && std::isnan(q)); });
  };
  for (std::size_t c = 0; c < kChannelCount; ++c)
    if (!same(a.columns[c], b.columns[c])) return false;
  return true;
}

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
  return is_at_rest(recording) ? "no measured channel ever changes: the ship rests, or nothing was recorded" : "";
}

// Means over bins of `bin_s`; every sample is a bin of its own where bin_s is 0.
std::vector<Point> binned(const Trajectory& recording, std::size_t first, double bin_s) {
  const std::vector<double>& t = recording[Channel::t];
  std::vector<Point> points;
  for (std::size_t i = first; i < t.size();) {
    const double bin = bin_s > 0.0 ? std::floor((t[i] - t[first]) / bin_s + 1e-6) : 0.0;
    std::size_t end = i + 1;
    while (bin_s > 0.0 && end < t.size() && std::floor((t[end] - t[first]) / bin_s + 1e-6) == bin) ++end;
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
Vec6 correlation_s(const std::vector<Trajectory>& recordings) {
  constexpr std::array kTold{Channel::u, Channel::vm, Channel::x0, Channel::y0};
  Vec6 result = Vec6::Zero();
  std::vector<double> correlated;
  std::size_t told = 0;
  for (const ChannelQuality& quality : channel_qualities(recordings)) {
    if (std::find(kTold.begin(), kTold.end(), quality.channel) == kTold.end()) continue;
    ++told;
    if (quality.correlation_s > 0.0) correlated.push_back(quality.correlation_s);
    for (std::size_t c = 0; c < kMeasured.size(); ++c)
      if (kMeasured[c] == quality.channel) result[static_cast<Eigen::Index>(c)] = quality.correlation_s;
  }
  if (4 * correlated.size() < 3 * told || correlated.empty()) return result;
  std::nth_element(correlated.begin(), correlated.begin() + static_cast<std::ptrdiff_t>(correlated.size() / 2),
                   correlated.end());
  for (std::size_t c = 0; c < kMeasured.size(); ++c)
    if (kMeasured[c] == Channel::psi || kMeasured[c] == Channel::r)
      result[static_cast<Eigen::Index>(c)] = correlated[correlated.size() / 2];
  return result;
}

// The filter takes noise as independent from point to point. Where it is not, most measurements would tell little that
// the one before has not told, and be believed: they are left out.
void leave_out_repeated_noise(Campaign& campaign) {
  const Vec6 correlation = correlation_s(campaign.recordings);
  std::map<double, std::vector<std::string>> thinned;
  for (Eigen::Index c = 0; c < correlation.size(); ++c) {
    const double every = std::min(std::ceil(kIndependent * correlation[c] / campaign.step_s - 0.25), kMostLeftOut);
    if (every < 2.0) continue;
    const double apart_s = (every - 0.25) * campaign.step_s;
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
    campaign.notices.push_back(fmt::format("the noise of {} is correlated; of it, a measurement every {:.3g} s is used",
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
  constexpr int kParts = 8;
  StepInputs<double> step = inputs.step(t_s, dt_s);
  std::array<StepInputs<double>, kParts> parts;
  for (int i = 0; i < kParts; ++i) {
    const double from_s = t_s + dt_s * i / kParts;
    parts[static_cast<std::size_t>(i)] = inputs.step(from_s, dt_s / kParts);
  }
  const auto average = [&](const auto& value) {
    double mean = 0.0;
    for (StepInputs<double>& part : parts) mean += value(part.middle) / kParts;
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
    const auto substeps = static_cast<std::size_t>(std::ceil(stretch.dt_s(k) / longest_s - 1e-9));
    const double h = stretch.dt_s(k) / static_cast<double>(substeps);
    std::vector<StepInputs<double>>& step = stretch.inputs.emplace_back();
    std::vector<StepInputs<double>>& late = stretch.late_inputs.emplace_back();
    for (std::size_t i = 0; i < substeps; ++i) {
      const double from_s = stretch.t_s[k] + static_cast<double>(i) * h;
      step.push_back(averaged_step(inputs, from_s, h));
      late.push_back(step.back());
      const StepInputs<double> before = averaged_step(inputs, from_s - kTimingShare * stretch.sample_s, h);
      late.back().start.actuators = before.start.actuators;
      late.back().middle.actuators = before.middle.actuators;
      late.back().end.actuators = before.end.actuators;
    }
    wind_speed += step.front().start.true_wind.norm();
  }
  stretch.wind_speed_mps = wind_speed / static_cast<double>(stretch.size() - 1);
}

Campaign prepare(const Ship& ship, std::vector<Trajectory> recordings, const CampaignOptions& options) {
  Campaign campaign;
  campaign.ship = ship;
  campaign.ensemble = options.ensemble;
  const RudderResponse response = Effects<double>(ship).rudder_response();  // that the simulator itself knows
  const double time_unit_s = std::sqrt(ship.particulars.L_pp / kGravity_mps2);
  const double substep_s = options.ensemble ? options.ensemble->time_step_s() : time_unit_s;
  const double usual_step_s = options.ensemble ? substep_s : 2.0 * time_unit_s;
  const double gap_s = options.gap_s > 0.0 ? options.gap_s : 30.0 * campaign.time_scale();

  for (std::size_t a = 0; a < recordings.size(); ++a)
    for (std::size_t b = 0; b < a; ++b)
      if (same_contents(recordings[a], recordings[b]))
        throw InputError(recordings[a].file,
                         fmt::format("holds the same as {}; a recording counts once", recordings[b].file));

  std::vector<double> steps;
  std::map<std::string, std::size_t> thinned;
  std::size_t recordings_used = 0, recordings_with_wind = 0;
  for (std::size_t index = 0; index < recordings.size(); ++index) {
    const Trajectory& recording = recordings[index];
    if (options.ensemble) options.ensemble->check(recording);
    campaign.recorded_inputs.emplace_back(recording, ship, InputInterpolation::linear);
    const RecordedInputs inputs = campaign.recorded_inputs.back().through(response);
    for (const std::string& notice : inputs.notices()) campaign.notices.push_back(notice);
    campaign.has_wind |= inputs.has_wind();
    for (const Channel channel : kMeasured)
      if (recording.has(channel) &&
          std::none_of(recording[channel].begin(), recording[channel].end(), [](double x) { return std::isfinite(x); }))
        campaign.notices.push_back(
            fmt::format("{}: '{}' has no value at all and is left out", recording.file, column_name(channel)));
    campaign.has_position |= recording.has(Channel::x0) && recording.has(Channel::y0);
    campaign.has_heading |= recording.has(Channel::psi);
    if (const std::string why = useless(recording, inputs); !why.empty()) {
      campaign.notices.push_back(fmt::format("{}: {}; left out", recording.file, why));
      continue;
    }
    recordings_with_wind += inputs.has_wind() ? 1 : 0;
    ++recordings_used;

    const double sample_s = median_interval(recording[Channel::t]);
    const double target_s = options.step_s > 0.0 ? options.step_s : usual_step_s;
    const bool is_thinned = sample_s < 0.75 * target_s;
    const double bin_s = is_thinned ? std::round(target_s / sample_s) * sample_s : 0.0;
    const double step_s = is_thinned ? bin_s : sample_s;
    if (is_thinned && bin_s > 1.5 * sample_s)
      ++thinned[fmt::format("sampled every {:.3g} s, thinned to means over {:.3g} s", sample_s, bin_s)];
    steps.push_back(step_s);

    // Stretches end at holes; short holes are bridged by points without measurements.
    std::vector<std::vector<Point>> parts;
    double last_measured_s = -1e300, longest_hole_s = 0.0, longest_from_s = 0.0;
    std::size_t holes = 0;
    for (const Point& point : binned(recording, *inputs.first_known(), bin_s)) {
      if (!point.is_measured()) continue;
      if (const double hole_s = point.t_s - last_measured_s; !parts.empty() && hole_s > 1.6 * step_s) {
        ++holes;
        if (hole_s > longest_hole_s) longest_hole_s = hole_s, longest_from_s = last_measured_s;
      }
      const bool is_after_gap = point.t_s - last_measured_s > std::max(gap_s, 1.6 * step_s);
      if (is_after_gap || parts.back().size() >= kMostPoints) parts.emplace_back();
      std::vector<Point>& part = parts.back();
      if (!part.empty()) {
        const double from_s = part.back().t_s, hole_s = point.t_s - from_s;
        const auto n = static_cast<int>(std::lround(hole_s / step_s));
        for (int k = 1; k < n && hole_s > 1.6 * step_s; ++k)
          part.push_back({from_s + hole_s * k / n, Vec6::Constant(kMissing)});
      }
      part.push_back(point);
      last_measured_s = point.t_s;
    }
    if (holes > 0)
      campaign.notices.push_back(fmt::format(
          "{}: {} hole{} without any measurement, the longest of {:.3g} s from {:.4g} s on; {}", recording.file, holes,
          holes > 1 ? "s" : "", longest_hole_s, longest_from_s,
          longest_hole_s > gap_s ? "holes longer than " + fmt::format("{:.3g} s", gap_s) + " cut it in pieces"
                                 : "the filter passes over them"));
    double left_out_s = 0.0;
    std::size_t kept = 0;
    for (const std::vector<Point>& part : parts) {
      if (part.size() < kFewestPoints) {
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
      stretch.sample_s = sample_s;
      set_inputs(stretch, inputs, substep_s);
      campaign.stretches.push_back(std::move(stretch));
    }
    if (left_out_s > 0.0 || kept == 0)
      campaign.notices.push_back(
          kept == 0 ? fmt::format("{}: shorter than the {:.3g} s that a window needs; left out", recording.file,
                                  static_cast<double>(kFewestPoints) * step_s)
                    : fmt::format("{}: {:.3g} s lie in pieces shorter than {:.3g} s between gaps and are left out",
                                  recording.file, left_out_s, static_cast<double>(kFewestPoints) * step_s));
  }
  if (campaign.stretches.empty()) {
    const std::string why = campaign.notices.empty() ? "" : " (" + campaign.notices.back() + ")";
    throw InputError(recordings.front().file, "no recording is long enough" + why);
  }
  if (recordings_with_wind > 0 && recordings_with_wind < recordings_used)
    campaign.notices.push_back(
        fmt::format("{} of {} recordings have no wind columns while the others have: what the wind did there shows as "
                    "missing physics; give them their wind, or leave them out",
                    recordings_used - recordings_with_wind, recordings_used));
  for (const auto& [how, count] : thinned)
    campaign.notices.push_back(fmt::format("{} of {} recordings: {}", count, recordings.size(), how));
  std::nth_element(steps.begin(), steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2), steps.end());
  campaign.step_s = steps[steps.size() / 2];
  campaign.own_effects.resize(recordings.size());
  campaign.recordings = std::move(recordings);
  leave_out_repeated_noise(campaign);
  return campaign;
}

}  // namespace leeway::gap
