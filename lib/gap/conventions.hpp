#pragma once

#include <string>
#include <vector>

#include "recording/trajectory.hpp"
#include "ship/ship.hpp"

namespace leeway::gap {

/// One way to read a recording that differs from the stated convention: "psi_deg holds radians", "wind_dir_deg is where
/// the wind blows to", "delta_deg is positive to port", "x0 is east and y0 north", ...
struct Reading {
  std::string channel;    ///< name of the channel without unit: "delta", "wind_dir", "psi", ...
  std::string name;       ///< short, for JSON: "wind-to", "port-positive", "radians", "knots", "counter-clockwise", ...
  std::string sentence;   ///< to a person: which reading fits and by how much
  double log_odds = 0.0;  ///< log-likelihood by which it fits better than the stated convention [nats]; + is better
  double error_ratio = 1.0;  ///< residual error as stated by that under this reading
  std::string recording{};   ///< the one that it holds for; empty: all
};

struct Conventions {
  std::vector<Reading> contradicted;   ///< readings that fit far better than what is stated: the best one per channel
  std::vector<Reading> tested;         ///< all, best first
  std::vector<std::string> unchecked;  ///< what could not be checked and why
};

/// Enumerates sign, unit and frame readings of each channel and scores them by kinematic consistency (eta' against
/// R(psi) nu, psi' against r, true against apparent wind) and by gross force consistency (the ship's model against the
/// recorded velocities over short times). Nothing is fitted. Readings that the data cannot tell from the stated one are
/// not claimed. Readings and thresholds: docs/gap-audit.md.
Conventions check_conventions(const Ship& ship, const std::vector<Trajectory>& recordings);
/// The same by kinematic consistency alone.
Conventions check_conventions(const std::vector<Trajectory>& recordings);
/// One recording that reads otherwise than all others: for each recording by itself the reading that fits best, where
/// it fits better than what is stated and the others refute it. With the others' word for the channel less is needed
/// than for all recordings together. At most one reading for a recording.
std::vector<Reading> contradicted_in_one(const Ship& ship, const std::vector<Trajectory>& recordings,
                                         const Conventions& of_all, std::size_t jobs);

/// The recording as it reads when the named readings hold that are for it: afterwards it follows leeway's conventions.
Trajectory reread(const Trajectory& recording, const std::vector<Reading>& readings);

}  // namespace leeway::gap
