#include "gap/report/notices.hpp"

#include <fmt/format.h>

#include "gap/policy/policy.hpp"
#include "gap/sensors/channel_quality.hpp"

namespace leeway::gap {

void add_notices(Findings& findings, const Campaign& campaign) {
  std::vector<std::string>& notices = findings.notices;
  const NullFit& fit = findings.fit;
  for (const Trajectory& recording : campaign.recordings)
    for (const std::string& sentence : suspect_actuators(recording, FroudeScale(campaign.ship.particulars.L_pp)))
      notices.push_back(recording.file + ": " + sentence);
  notices.insert(notices.end(), campaign.notices.begin(), campaign.notices.end());
  if (fit.outliers > 0)
    notices.push_back(
        fmt::format("{} of {} measurements lay more than {:g} sd from what the others predict and were left out",
                    fit.outliers, fit.samples + fit.outliers, kPolicy.fit.outlier_sd));
  if (fit.receiver)
    notices.push_back(fmt::format(
        "positions and velocities err together, by {:.2g} m/s for some {:.2g} s, as those of one receiver do",
        fit.receiver->sd_mps, fit.receiver->tau_s));
  if (fit.is_noise_free)
    notices.push_back(
        fmt::format("u, v_m and r show no noise, as simulated recordings: differences below {:.0f} % of the typical "
                    "acceleration are not judged",
                    100.0 * kPolicy.decide.error_of_inputs));
  if (!campaign.has_position)
    notices.push_back("no positions: slow effects show two to four times less; record x0_m and y0_m");
  if (!campaign.has_heading) notices.push_back("no heading: effects with a direction in earth axes cannot be seen");
}

void add_ensemble_notices(const EnsembleSimulator& simulator, Findings& findings) {
  const ensemble::EnsembleHeader& header = simulator.ensemble().header();
  if (simulator.ensemble().members() < 2)
    findings.notices.emplace_back("a single member has no spread: what it was not trained for does not show");
  if (header.inputs.domain.empty())
    findings.notices.emplace_back("the ensemble does not say what its training data covered; train it anew to know");
  for (const std::string& notice : simulator.ensemble().notices()) findings.notices.push_back(notice);
}

std::string counted_from(const Origin& origin) {
  return fmt::format("the recordings are far from the origin of their positions: places in the results count from {}",
                     origin.text());
}

std::string another_ship(const Ship& ship) {
  return fmt::format(
      "parameters moved by more than {:.0f} sd of what is stated, and no effect of the catalogue brings them back; are "
      "these recordings of the ship '{}'?",
      kPolicy.decide.far_parameter_sd, ship.name);
}

}  // namespace leeway::gap
