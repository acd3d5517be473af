#pragma once

/// What a force module may offer, for effects and others that change it. Each module states below its code what it
/// offers; who needs something asks for it by these names, never for a module.
namespace leeway {

/// A resistance to scale: scale_resistance(k).
template <typename M>
concept HasResistance = requires(M& m) {
  m.resistance_law;
}
&&requires { &M::scale_resistance; };

/// Linear derivatives of side force and moment by sway and yaw rate.
template <typename M>
concept HasLinearDerivatives = requires(M& m) {
  m.c.Y_v, m.c.Y_r, m.c.N_v, m.c.N_r;
};

/// A drag coefficient of the flow across the hull.
template <typename M>
concept HasCrossFlowDrag = requires(M& m) {
  m.c.C_D;
};

/// A thrust that drives the ship, to scale: scale_thrust(k).
template <typename M>
concept HasThrust = M::drives_ship && requires {
  &M::scale_thrust;
};

/// A wake fraction of straight ahead motion: increase_wake(dw), scale_wake(k).
template <typename M>
concept HasWake = requires {
  &M::increase_wake, &M::scale_wake;
};

/// Normal forces of rudders on the port and starboard side, with a shape over the angle of attack:
/// scale_normal_force(port, starboard). Of a single rudder the port one's factor counts.
template <typename M>
concept HasNormalForce = requires(M& m) {
  m.shape;
}
&&requires { &M::scale_normal_force; };

/// What straightens the flow towards a rudder: scale_flow_straightening(k).
template <typename M>
concept HasFlowStraightening = requires {
  &M::scale_flow_straightening;
};

/// Two rudders that disturb each other.
template <typename M>
concept HasTwinRudders = HasNormalForce<M> && requires(M& m) {
  m.k_interaction;
};

/// A thruster that pushes to both sides, each with its coefficient.
template <typename M>
concept HasSideThrust = requires(M& m) {
  m.c.channel, m.c.K_T_positive, m.c.K_T_negative;
};

/// A thrust that goes away with the ship's speed: inverse_u_c.
template <typename M>
concept HasSpeedLoss = requires(M& m) {
  m.inverse_u_c;
};

/// Gains of the wind's three forces, and areas: scale(k_X, k_Y, k_N), add_areas(front, side).
template <typename M>
concept HasWindForce = requires {
  &M::scale, &M::add_areas;
};

}  // namespace leeway
