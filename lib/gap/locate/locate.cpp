#include "gap/locate/locate.hpp"

#include <algorithm>

#include "gap/locate/frames.hpp"
#include "gap/locate/line_of_action.hpp"
#include "gap/locate/regimes.hpp"
#include "gap/locate/walking_gains.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {
namespace {

bool is_in(const std::vector<Interval>& intervals, const Campaign& campaign, std::size_t stretch, std::size_t k) {
  const std::string& file = campaign.recordings[campaign.stretches[stretch].recording].file;
  const double t_s = campaign.stretches[stretch].t_s[k];
  return std::any_of(intervals.begin(), intervals.end(),
                     [&](const Interval& i) { return i.file == file && i.t_start_s <= t_s && t_s <= i.t_end_s; });
}

// Share of the residual's energy by axis. An event counts whole where something was located, and by its scale
// elsewhere, since it would hide all else.
Vec3<double> shares_of(const Campaign& campaign, const FittedNull& fit, const std::vector<Interval>& located,
                       const std::vector<Eigen::Matrix3Xd>& residual) {
  Vec3<double> energy = Vec3<double>::Zero();
  for (std::size_t s = 0; s < residual.size(); ++s)
    for (Eigen::Index k = 0; k < residual[s].cols(); ++k) {
      const std::vector<Vec3<double>>& scale = fit.event_scale[s];
      const auto at = static_cast<std::size_t>(k);
      energy += residual[s].col(k).cwiseAbs2().cwiseQuotient(
          (scale.empty() || is_in(located, campaign, s, at) ? Vec3<double>::Ones() : scale[at]).cwiseAbs2());
    }
  if (!(energy.sum() > 0.0)) return Vec3<double>::Zero();
  return energy / energy.sum();
}

}  // namespace

Location locate(const Campaign& campaign, const FittedNull& fit, const LocateOptions& options) {
  Location result;
  const std::vector<Module> modules = modules_of(campaign, fit);
  const BlockEvidence blocks = block_evidence(campaign, fit, modules, options.jobs);
  FoundIntervals found = intervals_of(campaign, fit, blocks, options);
  result.scan_p_value = found.strongest_p_value;
  result.located.intervals = std::move(found.intervals);
  result.located.modules = walking_gains(campaign, fit, blocks, modules, options.jobs);

  const std::vector<Eigen::Matrix3Xd> residual = smoothed_residual(campaign, fit);
  result.located.share = shares_of(campaign, fit, result.located.intervals, residual);
  result.located.frames = frames_of(campaign, fit, residual, options.jobs);
  result.located.regimes = regimes_of(campaign, fit, residual, options);

  if (!campaign.knows_inertia()) return result;
  if (result.located.share[1] > kPolicy.locate.sway_share)
    result.located.line_of_action = line_of_action(campaign, fit, blocks.blocks, residual);
  if (const auto sharper = line_of_action(campaign, result.located.intervals)) result.located.line_of_action = sharper;
  return result;
}

}  // namespace leeway::gap
