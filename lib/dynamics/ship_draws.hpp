#pragma once

#include <cstdint>

#include "dynamics/coefficient_law.hpp"

namespace leeway {

/// A ship drawn from what a ship's file states of its coefficients.
struct ShipDraw {
  Ship ship;
  std::vector<CoefficientFactor> factors;  ///< on the coefficients of the ship that it is drawn from
  int refused = 0;                         ///< draws before it that made no ship
};

/// Draws 0, 1, ...: each is the same whichever others are drawn. A draw that makes no ship is refused and drawn anew:
/// one whose propulsion, at its limit, does not drive it straight ahead as fast as was recorded, or that comes to no
/// steady turn under full rudder, to either side, or runs away astern by twin rudders. Effects of the ship are kept,
/// and left out of that trial.
class ShipDraws {
 public:
  ///   spread              what the stated standard deviations are multiplied by
  ///   recorded_speed_mps  largest surge in the recordings; 0: the ship's u0_mps
  ShipDraws(const Ship& ship, double spread, std::uint64_t seed, double recorded_speed_mps = 0.0);

  /// Throws NumericalError where nearly every draw is refused.
  ShipDraw draw(int number) const;
  /// The JSON of a draw from that of the ship; "-draw-07" is added to its name.
  io::Json json(io::Json of_ship, const ShipDraw& draw, int number) const;

 private:
  Ship ship_;
  CoefficientLaw law_;
  double spread_, speed_mps_;
  std::uint64_t seed_;
};

/// Whether the ship can be driven to this surge [m/s], and comes to a steady turn to either side, astern to a speed.
bool runs_and_turns(Ship ship, double speed_mps);

}  // namespace leeway
