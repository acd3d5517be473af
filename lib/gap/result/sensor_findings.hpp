#pragma once

#include <optional>
#include <string>
#include <vector>

#include "recording/trajectory.hpp"

/// What recordings say of their sensors and conventions: plain results, which later stages and the reports use.
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
  double heldout_gain = 0.0;         ///< of log-likelihood over what was left out in turn [nats], against no fault
  double heldout_gain_sd = 0.0;      ///< its standard error
  double p_value = 1.0;              ///< of the fault against none, for the whole library of faults
  std::string sentence;              ///< what it is, to a person
  std::string separating_maneuver{};  ///< what distinguishes it from its look-alikes
  std::vector<Fault> rivals{};        ///< that predict what was left out no worse for certain: may stand in its place
  double log_odds = 0.0;              ///< of a rival: ln likelihood of all that was left out, against that fault [nats]
  /// By how much fits may take each parameter to be another than was corrected, one sd in its unit; none: not at all.
  std::vector<double> left_open{};
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
  bool is_checked = false;        ///< whether there was enough to check
  std::vector<Fault> faults;      ///< found: they improve what was held out, most certain first
  std::vector<Fault> hypotheses;  ///< all that were tested, best first
  std::vector<ChannelQuality> channels;
  std::vector<std::string>
      notices;  ///< what could not be checked and why, frozen channels, rivals that cannot be distinguished
  std::optional<bool>
      log_through_water;  ///< whether the velocities are through the water (a current shows in the track)

  Verdict verdict() const {
    return !faults.empty() ? Verdict::faulty : is_checked ? Verdict::consistent : Verdict::unchecked;
  }
};

/// One way to read a recording that differs from the stated convention: "psi_deg holds radians", "wind_dir_deg is where
/// the wind blows to", "delta_deg is positive to port", "x0 is east and y0 north", ...
struct Reading {
  std::string channel;    ///< name of the channel without unit: "delta", "wind_dir", "psi", ...
  std::string name;       ///< short, for JSON: "wind-to", "port-positive", "radians", "knots", "counter-clockwise", ...
  std::string sentence;   ///< to a person: which reading fits and by how much
  double log_odds = 0.0;  ///< log-likelihood by which it fits better than the stated convention [nats]; + is better
  double error_ratio = 1.0;  ///< residual error as stated by that under this reading
  std::string recording{};   ///< the one that it holds for; empty: all
  std::string premise{};     ///< "if wind_dir is where the wind blows to"
  /// The premise as a statement: "wind_dir is where the wind blows to".
  std::string claim() const { return premise.substr(premise.find(' ') + 1); }
};

struct Conventions {
  std::vector<Reading> contradicted;   ///< readings that fit far better than what is stated: the best one per channel
  std::vector<Reading> tested;         ///< all, best first
  std::vector<std::string> unchecked;  ///< what could not be checked and why
};

}  // namespace leeway::gap
