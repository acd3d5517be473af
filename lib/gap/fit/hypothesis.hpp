#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "effects/description.hpp"

namespace leeway::gap {

/// An effect of the catalogue with free parameters. Coordinates z stand for them, independent and standard normal
/// before any recording is seen, so that all effects are fitted in the same units:
///
///   - a speed or force with a direction: its two components by the prior's sd (Rayleigh); nothing is at z = 0;
///   - a direction of something else: from `towards_deg`, in units of 360/sqrt(2 pi) deg, as flat as the density of all
///     directions;
///   - log-normal, normal, uniform: the standard normal value below which is as much of the distribution, cut off at
///     its bounds, as is below x: (ln x - ln median)/sd, (x - median)/sd where the bounds are far.
///
/// A factor on something (1: nothing is missing) gets a log-sd of at least 0.6: stated coefficients have their own
/// uncertainty already. It is at most what the catalogue's prior allows. Parameters that have a default and no neutral
/// value (a place, a shape) keep the default, unless they are freed.
class FreeEffect {
 public:
  struct Choice {
    double towards_deg = 0.0;              ///< where a direction that is no vector has z = 0
    std::map<std::string, double> fixed;   ///< parameters that are known, in their units
    std::vector<std::string> freed;        ///< parameters that do not keep their default
    std::map<std::string, Prior> priors;   ///< of places, which are sought about the tracks
    std::optional<std::size_t> recording;  ///< in which alone it acts
    double log_ways = 0.0;                 ///< ln of how many others the known parameters were chosen from
  };
  /// Priors are those of the ship's scale. Throws UsageError for an unknown name, EffectNotApplicable if the ship lacks
  /// what the effect needs.
  FreeEffect(std::string_view name, const Ship& ship, const Choice& choice);
  FreeEffect(std::string_view name, const Ship& ship, double towards_deg = 0.0)
      : FreeEffect(name, ship, Choice{towards_deg, {}, {}, {}, {}, 0.0}) {}

  const std::string& name() const { return name_; }
  /// Another value for a parameter that is known; or as far from the one it has.
  void fix(std::string_view parameter, double value);
  void shift(std::string_view parameter, double by);
  /// The standard deviation of one that is known but for that, in its unit; 0 where nobody said.
  void know(std::string_view parameter, double sd);
  double known_sd(std::string_view parameter) const;
  double towards_deg() const { return towards_deg_; }
  /// Lets a direction that is no vector have z = 0 elsewhere, and z mean what it meant: effects of one name that act in
  /// different recordings are averaged by z.
  void count_from(double towards_deg, Eigen::VectorXd& z);
  const std::optional<std::size_t>& recording() const { return recording_; }
  Eigen::Index size() const;  ///< coordinates
  double log_ways() const { return log_ways_; }
  void choose_from(double log_ways) { log_ways_ = log_ways; }
  /// Whether it has a direction that is no vector, so that starts around the compass are needed.
  bool has_bare_direction() const;
  /// Places in z of the logarithms of strengths: far below nothing acts.
  std::vector<Eigen::Index> log_strengths() const;
  /// Places in z of what stands beside a vector that is an effect of its own (the shear beside the current); none for
  /// all other effects.
  std::vector<Eigen::Index> beside_vector() const;
  /// z at which the effect vanishes; nothing where no finite one does.
  std::optional<Eigen::VectorXd> neutral() const;

  /// Parameters in the catalogue's order and units, within their bounds.
  std::vector<double> values(const Eigen::Ref<const Eigen::VectorXd>& z) const;
  /// Steps of the coordinates for central differences.
  std::vector<double> differences() const;
  /// As it stands in a ship's JSON.
  EffectEntry entry(const Eigen::Ref<const Eigen::VectorXd>& z) const;

  /// One free parameter in its unit: estimate, standard deviation and 95 % interval, from z ~ N(mean, covariance).
  struct Parameter {
    std::string name;
    double estimate = 0.0, sd = 0.0, low = 0.0, high = 0.0;
    bool is_at_bound = false;  ///< of its prior, within its sd; 0, where nothing acts, is none
  };
  std::vector<Parameter> parameters(const Eigen::VectorXd& mean, const Eigen::MatrixXd& covariance) const;
  /// 95 % interval of each of these as the recordings alone say, whatever was believed before, and its estimate, from
  /// z ~ N(best + step, covariance): a parameter is as far from where it is at `best` as a straight step leads, in its
  /// unit or, log-normal, its logarithm, which likelihoods are closer to normal in than in z; at most to its bounds.
  struct Interval {
    double low = 0.0, high = 0.0;
  };
  std::vector<Interval> intervals(const Eigen::VectorXd& best, const Eigen::VectorXd& step,
                                  const Eigen::MatrixXd& covariance) const;
  /// Standard deviation of strengths and directions in z by the error of the effect's formula; places have none.
  Eigen::VectorXd sd_of_formula(const Eigen::VectorXd& z) const;

 private:
  struct Coordinate {
    std::size_t parameter;  ///< the speed, for a vector, whose direction is `direction_`
    Prior prior;
    bool is_vector() const { return prior.kind == Prior::Kind::rayleigh; }
  };
  double value_of(const Coordinate& coordinate, double z) const;
  double value_beside(const Coordinate& coordinate, double z, double step) const;
  /// Draws of all parameters: values_at(a standard normal vector of `size` numbers).
  template <class ValuesAt>
  std::vector<std::vector<double>> draws(Eigen::Index size, const ValuesAt& values_at) const;
  std::size_t place_of(std::string_view parameter) const;

  std::string name_;
  std::optional<std::size_t> recording_;
  double log_ways_;
  std::size_t type_ = 0;
  double towards_deg_ = 0.0;
  std::span<const EffectParameter> parameters_;
  std::vector<double> base_, base_sd_;   ///< values of what is not free, and what is left open of them
  std::vector<Coordinate> coordinates_;  ///< a vector counts once
  std::optional<std::size_t> direction_;
};

/// What may be missing: effects that act together. Their coordinates follow each other.
struct Hypothesis {
  std::vector<FreeEffect> effects;

  Eigen::Index size() const;
  /// Each name once, in order.
  std::vector<std::string> names() const;
  /// "steady-current + rudder-offset"; "none".
  std::string name() const;
  /// The ship with the effects at z added to its own, as it sails in one recording.
  Ship applied_to(const Ship& ship, const Eigen::VectorXd& z, std::size_t recording) const;
  /// As it sails in any: an effect that differs between recordings as it is in the mean, without one that acts in a
  /// single recording.
  Ship applied_to(const Ship& ship, const Eigen::VectorXd& z) const;
  /// Whether it sails differently in different recordings.
  bool differs() const;
};

}  // namespace leeway::gap
