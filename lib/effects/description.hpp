#pragma once

#include <array>
#include <initializer_list>
#include <limits>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "ship/ship.hpp"

/// What is said of effects, without their code: texts, parameters with their priors, values as a ship's JSON gives
/// them.
namespace leeway {

/// What is known about a parameter before any recording was seen. Median and sd in the parameter's unit, the sd of a
/// log-normal in natural logarithms; bounds are hard.
struct Prior {
  enum class Kind { normal, log_normal, rayleigh, uniform } kind;
  double median, sd, low, high;
};
constexpr Prior normal(double median, double sd, double low, double high) {
  return {Prior::Kind::normal, median, sd, low, high};
}
constexpr Prior log_normal(double median, double log_sd, double low, double high) {
  return {Prior::Kind::log_normal, median, log_sd, low, high};
}
/// The length of a vector whose two components are normal with this sd and mean 0.
constexpr Prior rayleigh(double sd, double high) {
  return {Prior::Kind::rayleigh, sd * 1.1774100225154747 /* sqrt(2 ln 2) */, sd, 0.0, high};
}
constexpr Prior uniform(double low, double high) {
  return {Prior::Kind::uniform, 0.5 * (low + high), 0.28867513459481287 * (high - low), low, high};
}
inline constexpr Prior kAnyDirection = uniform(0.0, 360.0);
constexpr bool is_direction(const Prior& prior) {
  return prior.kind == Prior::Kind::uniform && prior.high - prior.low >= 360.0;
}

/// What a parameter is to a search, where its prior does not say it.
enum class ParameterRole {
  plain,
  force,          ///< of what comes and goes: a piece of it is taken away by its negative
  begin,          ///< when the effect begins, in the run's time
  end,            ///< when it ends
  lever,          ///< point of action along the ship: sought, where other points keep their default
  wall_distance,  ///< as Wall has it
  anchor_x,       ///< where a line is made fast ashore
  anchor_y,       ///< likewise
  slack,          ///< length at which it goes taut
  response_time,  ///< by which rudders act later: no better known than the inputs between samples
};

/// One parameter of an effect, in the unit that its name carries.
struct EffectParameter {
  std::string_view name, meaning;
  double off;        ///< the value at which the effect vanishes; NaN where no finite value does
  double otherwise;  ///< taken where the ship JSON does not give it; NaN: it must be given
  double low, high;  ///< what makes sense at all
  Prior at_3m, at_150m;
  ParameterRole role = ParameterRole::plain;

  /// Of a ship of this length between perpendiculars [m]. Numbers that differ between 3 m and 150 m follow a power of
  /// the length through both, as speeds, times, lengths and forces do by Froude's law, also beyond: a tug pulls on any
  /// place of a longer hull. Where no power goes through them, since one is 0 or their signs differ, they are linear in
  /// the logarithm of the length between, and held beyond.
  Prior prior(double L_pp) const;
};
inline constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
inline constexpr double kUnbounded = std::numeric_limits<double>::infinity();

/// Names of a few effects, known when the program is compiled.
class EffectNames {
 public:
  constexpr EffectNames(std::initializer_list<std::string_view> names) : count_(names.size()) {
    std::size_t i = 0;
    for (const std::string_view name : names) names_.at(i++) = name;
  }
  constexpr const std::string_view* begin() const { return names_.data(); }
  constexpr const std::string_view* end() const { return names_.data() + count_; }

 private:
  std::array<std::string_view, 8> names_{};
  std::size_t count_;
};

/// Elsewhere, or at another time, an effect that is bound does nothing.
enum class BoundTo { nothing, place, time };

/// From where the gap tools search for an effect.
enum class SearchStart {
  /// A linear step from no strength, or from typical ones where none is finite: most effects.
  linear_step,
  compass,    ///< the same and a weak one in each direction: it grows with the square, so that none shows no direction
  wall,       ///< walls beside the tracks
  contact,    ///< walls that the hull touches somewhere, in recordings in which something acts at times
  anchor,     ///< points about the tracks
  interval,   ///< intervals in which something acts
  course,     ///< its course over the time of the recordings, in the cosines of varying-current
  terms,      ///< the few of its parameters that explain most of what is left
  every_fit,  ///< none: it is the noise of every fit
  none,       ///< it is for the simulator alone: the gap tools do not try it, and it has no share in the prior
};
/// Whether one linear step about a fit shows the effect.
constexpr bool is_screened(SearchStart start) {
  return start == SearchStart::linear_step || start == SearchStart::compass;
}

/// What an effect is to a simulator that has no forces to change (an ensemble), only its motion.
enum class EnsembleForm { none, body_acceleration, earth_acceleration, water_velocity, wind_velocity };

/// Names of coefficients, as in a ship's coefficient_factors; empty ones do not count.
using CoefficientNames = std::array<std::string_view, 3>;

/// A force of the standard model that an effect does nothing but multiply.
enum class MultipliedForce { none, resistance, thrust, rudder };

/// What an effect says of itself: texts for people, then traits, by which alone the gap tools treat it.
struct EffectInfo {
  std::string_view name, number;  ///< as in the ship JSON; in the catalogue of missing physics
  std::string_view sentence;      ///< what it is, to a person
  /// The same with numbers, as a clause that may follow "because of". Parts between semicolons go where their
  /// parameters are not known, or not off. {name}: value and unit; {name%}: how far it is from where the effect
  /// vanishes, in per cent; {name!}: likewise in its unit; {name?above|below}: a word for each side of it.
  std::string_view phrase;
  /// Of an effect that does nothing but multiply what a coefficient of the ship's file multiplies, both readings: what
  /// may have happened to the ship, if there is less (or more) of it than the file states, and which coefficient may be
  /// wrong.
  std::string_view cause_of_less = {}, cause_of_more = {}, or_coefficient = {};
  MultipliedForce multiplies = MultipliedForce::none;
  /// Coefficients each of which does the same by itself; where only one of the two causes above is given, on that side.
  CoefficientNames coefficients = {};
  std::string_view formula, source;
  std::string_view look_alikes;  ///< to a person, with conditions, sensor faults and other things
  /// Effects that recordings distinguish badly from this one. The relation is symmetric: that one of two names the
  /// other is enough (are_look_alikes).
  EffectNames looks_like = {};
  std::string_view separating_maneuver;
  /// How well the formula itself is known, relative: intervals of strengths and directions have it besides (ours:
  /// authors' formulas for one thing differ by as much and more).
  double formula_sd = 0.1;
  BoundTo bound_to = BoundTo::nothing;
  /// Whether it shows in how hull and rudders answer alone, so that recordings of a ship that is kept on its course say
  /// nothing of it.
  bool needs_turns = false;
  /// Whether it is another one on another day (a current, a wind, a pull), and so may differ between recordings.
  bool differs_by_recording = false;
  bool changes_depth = false;       ///< whether the water is no longer deep
  bool is_of_surroundings = false;  ///< water, wind, ice, shore and tugs: the ship itself is as its file says
  std::string_view to_record = "";  ///< what would have told it, had it been recorded
  SearchStart search = SearchStart::linear_step;
  EnsembleForm to_ensemble = EnsembleForm::none;
};

/// What is known of an effect before any ship: its text and its parameters.
struct EffectDescription {
  EffectInfo info;
  std::span<const EffectParameter> parameters;
};

/// All effects, in the order of the list above.
const std::vector<EffectDescription>& effect_catalogue();

/// The place of an effect in the catalogue; nothing for an unknown name.
std::optional<std::size_t> find_effect(std::string_view name);
/// Throws UsageError for an unknown name.
const EffectDescription& effect_named(std::string_view name);

/// How the search for what has this name starts; none where the catalogue does not hold it (a sensor's fault).
SearchStart search_start(std::string_view name);
BoundTo bound_to(std::string_view name);  ///< likewise
/// Names of the effects of which the search starts like this, in the catalogue's order.
std::vector<std::string> effects_searched_from(SearchStart start);
/// How many effects share in the prior: all but those that the gap tools do not try.
std::size_t count_of_tried_effects();
/// Whether one of two effects says that it looks like the other.
bool are_look_alikes(std::string_view a, std::string_view b);

/// The place of the parameter with this role among the effect's; throws std::logic_error where it has none.
std::size_t place_of(ParameterRole role, const EffectDescription& effect);
/// Its name.
std::string name_of(ParameterRole role, const EffectDescription& effect);

/// Whether a null for this parameter switches the effect off: its first one, where no parameter has a neutral value.
bool is_switch(const EffectDescription& effect, const EffectParameter& parameter);

/// The values of an effect's parameters in the catalogue's order and units, completed where the ship JSON leaves them
/// out; nothing where a null switches the effect off. Throws InputError for an unknown effect or parameter, a missing
/// or impossible value.
struct EffectValues {
  std::size_t type;  ///< place in the catalogue
  std::vector<double> values;
};
std::optional<EffectValues> effect_values(const EffectEntry& entry);

/// Thrown by the constructor of an effect that needs something that the ship does not have.
struct EffectNotApplicable : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Throws EffectNotApplicable if the ship lacks what the effect at this place in the catalogue needs at these values.
void require_applicable(std::size_t type, std::span<const double> values, const Ship& ship);

}  // namespace leeway
