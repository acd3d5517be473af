#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <variant>
#include <vector>

#include "core/errors.hpp"
#include "effects/actuator_delay.hpp"
#include "effects/actuator_lag.hpp"
#include "effects/actuator_rate.hpp"
#include "effects/added_mass.hpp"
#include "effects/anemometer.hpp"
#include "effects/bank.hpp"
#include "effects/body_force.hpp"
#include "effects/center_of_gravity.hpp"
#include "effects/cross_flow_drag.hpp"
#include "effects/draft.hpp"
#include "effects/earth_force.hpp"
#include "effects/fender.hpp"
#include "effects/fouling.hpp"
#include "effects/level_ice.hpp"
#include "effects/model_error.hpp"
#include "effects/mooring.hpp"
#include "effects/propeller_walk.hpp"
#include "effects/rudder_effectiveness.hpp"
#include "effects/rudder_latency.hpp"
#include "effects/rudder_offset.hpp"
#include "effects/rudder_stall.hpp"
#include "effects/shallow_water.hpp"
#include "effects/sheared_current.hpp"
#include "effects/steady_current.hpp"
#include "effects/thrust_loss.hpp"
#include "effects/thruster_gain.hpp"
#include "effects/thruster_speed_loss.hpp"
#include "effects/trim.hpp"
#include "effects/tug.hpp"
#include "effects/unknown.hpp"
#include "effects/unmeasured_wind.hpp"
#include "effects/varying_current.hpp"
#include "effects/vectwin_interaction.hpp"
#include "effects/wake.hpp"
#include "effects/wave_drift.hpp"
#include "effects/windage.hpp"

namespace leeway {

/// The one list of effects, in the order of the catalogue. A new one adds its header and its name here.
template <typename T>
using Effect =
    std::variant<SteadyCurrent<T>, VaryingCurrent<T>, ShearedCurrent<T>, ShallowWater<T>, Bank<T>, Windage<T>,
                 Anemometer<T>, UnmeasuredWind<T>, WaveDrift<T>, Fouling<T>, Draft<T>, CenterOfGravity<T>, Trim<T>,
                 CrossFlowDrag<T>, AddedMass<T>, ThrustLoss<T>, Wake<T>, PropellerWalk<T>, RudderOffset<T>,
                 RudderEffectiveness<T>, RudderStall<T>, VectwinInteraction<T>, ThrusterGain<T>, ThrusterSpeedLoss<T>,
                 ActuatorDelay<T>, ActuatorRate<T>, ActuatorLag<T>, RudderLatency<T>, Tug<T>, Mooring<T>, Fender<T>,
                 LevelIce<T>, BodyForce<T>, EarthForce<T>, ModelError<T>, Unknown<T>>;

/// The effect at this place in the catalogue, with parameter values in the catalogue's units. Throws
/// EffectNotApplicable if the ship lacks what it needs.
template <typename T>
Effect<T> make_effect(std::size_t type, std::span<const T> values, const Ship& ship) {
  const auto make = [&]<std::size_t i>(auto&& self, std::integral_constant<std::size_t, i>) -> Effect<T> {
    if constexpr (i < std::variant_size_v<Effect<T>>) {
      using Type = std::variant_alternative_t<i, Effect<T>>;
      if (type != i) return self(self, std::integral_constant<std::size_t, i + 1>{});
      std::array<T, Type::parameters.size()> array;
      for (std::size_t k = 0; k < array.size(); ++k) array[k] = values[k];
      return Type(array, ship);
    } else {
      throw std::out_of_range("no such effect");
    }
  };
  return make(make, std::integral_constant<std::size_t, 0>{});
}

/// The effects of a ship, and what they do together.
template <typename T>
class Effects {
 public:
  Effects() = default;
  /// Throws InputError, which points into the ship's JSON, for whatever is wrong with an entry.
  explicit Effects(const Ship& ship) {
    for (const EffectEntry& entry : ship.effects) {
      const std::optional<EffectValues> values = effect_values(entry);
      if (!values) continue;
      const std::vector<T> cast(values->values.begin(), values->values.end());
      try {
        add(make_effect<T>(values->type, cast, ship));
      } catch (const EffectNotApplicable& problem) {
        throw InputError(entry.file, 0, entry.pointer, entry.type + ": " + problem.what());
      }
    }
  }

  void add(Effect<T> effect) {
    std::visit(
        [&]<typename E>(const E& e) {
          acts_ |= requires(Actuators<T> & a) { e.act(a); };
          blows_ |= requires(Situation<T> at) { e.wind(at); };
          moves_water_ |= requires(Situation<T> at) { e.water(at); };
          pushes_ |= requires(Situation<T> at) { e.force(at); };
          if constexpr (requires { e.slow(response_); }) e.slow(response_);
        },
        effect);
    effects_.push_back(std::move(effect));
  }

  bool empty() const { return effects_.empty(); }
  /// Whether there is anything to do during a run; other effects are done when the model is made.
  bool act() const { return acts_; }
  bool blow() const { return blows_; }
  bool moves_water() const { return moves_water_; }
  bool push() const { return pushes_; }
  const RudderResponse& rudder_response() const { return response_; }

  void change(ModelParts<T> parts) const {
    for (const Effect<T>& effect : effects_)
      std::visit(
          [&](const auto& e) {
            if constexpr (requires { e.change(parts); }) e.change(parts);
          },
          effect);
  }
  void act(Actuators<T>& actuators) const {
    for_each([&](const auto& e) {
      if constexpr (requires { e.act(actuators); }) e.act(actuators);
    });
  }
  /// Sums over the effects; which members of `at` they read stands at Situation.
  Vec2<T> wind(const Situation<T>& at) const {
    Vec2<T> sum = Vec2<T>::Zero();
    for_each([&](const auto& e) {
      if constexpr (requires { e.wind(at); }) sum += e.wind(at);
    });
    return sum;
  }
  WaterMotion<T> water(const Situation<T>& at) const {
    WaterMotion<T> sum;
    for_each([&](const auto& e) {
      if constexpr (requires { e.water(at); }) {
        const WaterMotion<T> one = e.water(at);
        sum.velocity += one.velocity;
        sum.rate += one.rate;
        sum.gradient += one.gradient;
      }
    });
    return sum;
  }
  Vec3<T> force(const Situation<T>& at) const {
    Vec3<T> sum = Vec3<T>::Zero();
    for_each([&](const auto& e) {
      if constexpr (requires { e.force(at); }) sum += e.force(at);
    });
    return sum;
  }

 private:
  template <typename Call>
  void for_each(const Call& call) const {
    for (const Effect<T>& effect : effects_) std::visit(call, effect);
  }

  std::vector<Effect<T>> effects_;
  bool acts_ = false, blows_ = false, moves_water_ = false, pushes_ = false;
  RudderResponse response_;
};

}  // namespace leeway
