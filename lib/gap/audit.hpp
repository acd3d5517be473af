#pragma once

#include <optional>
#include <string>
#include <vector>

#include "recording/trajectory.hpp"

namespace leeway::gap {

/// A number with its standard deviation, in the unit that the name carries.
struct Estimate {
  std::string name;
  double value = 0.0, sd = 0.0;
};

/// A sensor fault, tested with the kinematics alone. Measured value = true value with the fault: a heading bias of
/// +3 deg means that the recorded heading is 3 deg too high, a latency of 1 s that the channel is recorded 1 s late.
struct Fault {
  std::string name;                  ///< "heading-bias", "lever-arm", "log-scale", "rate-bias", "velocity-latency", ...
  std::vector<Estimate> parameters;  ///< "heading_bias_deg", "lever_x_m", ...
  double heldout_gain = 0.0;         ///< mean gain of log-likelihood per left-out recording [nats], against no fault
  double heldout_gain_sd = 0.0;      ///< its standard error over the left-out recordings (or blocks of a single one)
  double p_value = 1.0;              ///< of the fault against none, for the whole library of faults
  std::string sentence;              ///< what it is, to a person
  std::string separating_maneuver{};  ///< what tells it from its look-alikes
  std::vector<Fault> rivals{};        ///< that predict what was left out no worse for certain: may stand in its place
  double log_odds = 0.0;              ///< of a rival: ln likelihood of all that was left out, against that fault [nats]
};

/// What a channel of the recordings is like, apart from what the ship does.
struct ChannelQuality {
  Channel channel = Channel::t;
  double noise_sd = 0.0;                 ///< of one sample [SI]
  double correlation_s = 0.0;            ///< time over which its noise is correlated; 0: white
  double filter_s = 0.0;                 ///< time constant of the first-order filter that the noise shows; 0: none
  double missing_share = 0.0;            ///< of the samples
  double frozen_share = 0.0;             ///< of the samples, in runs that repeat one value although the ship moves
  double resolution = 0.0;               ///< smallest step between different values [SI], 0 if not quantized
  std::vector<std::string> frozen_in{};  ///< names of the recordings in which the channel is frozen for a while
};

struct Audit {
  enum class Verdict { consistent, faulty, unchecked };
  Verdict verdict = Verdict::unchecked;
  std::vector<Fault> faults;      ///< found: they improve what was held out, most certain first
  std::vector<Fault> hypotheses;  ///< all that were tested, best first
  std::vector<ChannelQuality> channels;
  std::vector<std::string>
      notices;  ///< what could not be checked and why, frozen channels, rivals that cannot be told apart
  std::optional<bool>
      log_through_water;  ///< whether the velocities are through the water (a current shows in the track)
};

struct AuditOptions {
  double window_s = 10.0;     ///< over which eta' - R nu and psi' - r are integrated
  double false_alarm = 0.01;  ///< rate of finding a fault where there is none, over the whole library
  std::size_t jobs = 1;
  std::uint64_t seed = 1;
};

/// Compares the recordings with themselves, without any force model: over windows the integrals of eta' - R(psi) nu and
/// psi' - r, against each fault of the library, robustly, with rivalry between them. What is not recorded is said in
/// the notices. Formulas, signs and thresholds: docs/gap-audit.md.
Audit audit(const std::vector<Trajectory>& recordings, const AuditOptions& options);

/// Tells a fault's sentence anew, after its numbers have changed.
void retell(Fault& fault);

/// The recording with the faults taken out: channels shifted by fractions of a sample, rotated, rescaled. Samples that
/// a shift moves beyond the end become missing.
Trajectory corrected(const Trajectory& recording, const std::vector<Fault>& faults);

}  // namespace leeway::gap
