#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "gap/filter/state_space.hpp"
#include "gap/fit/hypothesis.hpp"

namespace leeway::gap {

/// A ship in one recording, with the coefficients of a fit, and the inputs as its rudders follow them.
class EffectSide {
 public:
  ///   plain_theta  (coefficients, timing)
  ///   like         the response of the rudders that the inputs of the stretches have
  EffectSide(const Ship& ship, const Eigen::VectorXd& plain_theta, const RecordedInputs& recorded,
             const RudderResponse& like);
  /// Where step k of a stretch leads from the path.
  Vec6 step(const LinearStretch& stretch, std::size_t k) const;
  /// The same, as far as it differs by forces and the water's motion: where the acceleration in the middle of the step
  /// leads. It knows nothing of inputs that are others than those of the stretch.
  Vec6 push(const LinearStretch& stretch, std::size_t k) const;
  bool has_other_inputs() const { return inputs_.has_value(); }

 private:
  Model<double> model_;
  std::optional<RecordedInputs> inputs_;  // where they are not those of the stretch
};

/// How steps change with one coordinate of an effect: a central difference, since effects may also shift inputs in
/// time.
class EffectSlope {
 public:
  ///   side_at  the side with this coordinate off by as much
  EffectSlope(const std::function<EffectSide(double off)>& side_at, double difference)
      : above_(side_at(difference)), below_(side_at(-difference)), difference_(difference) {}
  /// Of step k of a stretch by the coordinate.
  Vec6 step(const LinearStretch& stretch, std::size_t k) const {
    return (above_.step(stretch, k) - below_.step(stretch, k)) / (2.0 * difference_);
  }
  Vec6 push(const LinearStretch& stretch, std::size_t k) const {
    return (above_.push(stretch, k) - below_.push(stretch, k)) / (2.0 * difference_);
  }
  bool has_other_inputs() const { return above_.has_other_inputs() || below_.has_other_inputs(); }

 private:
  EffectSide above_, below_;
  double difference_;
};

/// How steps change with the coordinates of effects.
class EffectColumns {
 public:
  ///   z            coordinates of the hypothesis
  ///   plain_theta  (coefficients, timing)
  EffectColumns(const Campaign& campaign, const Hypothesis& hypothesis, const Eigen::VectorXd& z,
                const Eigen::VectorXd& plain_theta, std::size_t recording);

  /// With the effects at z.
  const Ship& ship() const { return ship_; }
  const RudderResponse& response() const { return response_; }
  /// Puts the inputs as the rudders follow them on the stretch.
  void set_inputs_of(Stretch& stretch) const;
  /// Puts them between the coefficients and the timing of a stretch's own columns.
  void add_to(LinearStretch& stretch) const;

 private:
  const RecordedInputs& recorded_;
  const Ship ship_;
  const RudderResponse response_;
  std::vector<std::optional<EffectSlope>> slopes_;  // none: it does not act in this recording
};

/// (coefficients, timing) of (coefficients, z, timing).
Eigen::VectorXd without_effects(const Eigen::VectorXd& theta, Eigen::Index effects);

}  // namespace leeway::gap
