#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/types.hpp"
#include "recording/trajectory.hpp"

namespace leeway::gap {

/// On what a force depends that the catalogue does not hold.
enum class Dependence { place, heading, period, memory, states, time };
/// As report.json has it.
std::string_view word(Dependence on);

/// A force of which nothing is known but on what it depends.
struct LatentForce {
  Dependence on = Dependence::time;
  std::vector<int> axes{};  ///< of the ship on which it acts: 0 surge, 1 sway, 2 yaw
  /// Of a place: the length over which it changes [m]; of a period that [s]; of a memory the time in which it fades
  /// [s], or where it rings the period [s].
  double argument = kMissing;
  bool rings = false;
  std::vector<Channel> states{};        ///< of states: on which alone; empty: on several
  double log_evidence = 0.0;            ///< against the same without it [nats]
  std::optional<Vec2<double>> about{};  ///< place (x0, y0) [m] about which alone it acts; none: anywhere
};

/// "a turning moment with a period of 37 s, whatever the ship does".
std::string phrase(const LatentForce& force);

}  // namespace leeway::gap
