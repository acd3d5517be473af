#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "forces/actuators.hpp"
#include "forces/inertia.hpp"
#include "forces/particulars.hpp"
#include "io/json.hpp"
#include "ship/residual_network.hpp"

namespace leeway {

/// Physics added to the standard model, as the JSON gives it; effects/registry.hpp knows the names and checks them.
struct EffectEntry {
  std::string type;
  std::vector<std::pair<std::string, std::optional<double>>> parameters;  ///< null: nothing
  std::string file, pointer;                                              ///< where it stands, for messages
};

/// What a file may state: of a coefficient's factor, of the standard deviation of its logarithm, and of its own.
inline constexpr io::Bounds kFactorRange{0.01, 100.0}, kLogSdRange{1e-4, 3.0}, kAbsoluteSdRange{1e-9, 1e9};

/// What a coefficient, or a group of them, is multiplied by, and what is added then: c becomes factor c + shift.
/// dynamics/coefficient_factors.hpp knows the names.
struct CoefficientFactor {
  std::string name;
  double factor = 1.0;
  double shift = 0.0;  ///< in the coefficient's own unit
};

/// Where the numbers of one part of a ship's JSON come from. `type` is empty for particulars and inertia.
struct PartSource {
  std::string part, type, source;
};

struct ModuleCoefficients;

/// The coefficients of a ship's force modules, copied with it. forces/registry.hpp, which needs all modules, has what
/// they are; few sources look at them.
class OwnModules {
 public:
  OwnModules();
  ~OwnModules();
  OwnModules(const OwnModules& other);
  OwnModules(OwnModules&& other) noexcept;
  OwnModules& operator=(OwnModules other) noexcept;

  ModuleCoefficients& operator*() { return *modules_; }
  const ModuleCoefficients& operator*() const { return *modules_; }
  ModuleCoefficients* operator->() { return modules_.get(); }
  const ModuleCoefficients* operator->() const { return modules_.get(); }

 private:
  std::unique_ptr<ModuleCoefficients> modules_;
};

/// A ship as its JSON describes it: complete and checked. SI and radians.
struct Ship {
  Particulars particulars;
  InertiaCoefficients<double> inertia;
  OwnModules modules;
  std::string name, description, file;
  double scale = 1.0;               ///< length of the full-scale ship by this one's
  std::vector<Actuator> actuators;  ///< every channel that a module reads, each once
  std::vector<EffectEntry> effects;
  std::vector<CoefficientFactor> coefficient_factors;
  std::shared_ptr<const ResidualNetwork> residual_network;  ///< nullptr: none
  /// How well a coefficient is known: standard deviation of its natural logarithm, or where its sign is not certain of
  /// its value; names as in coefficient_factors.
  struct Uncertainty {
    std::string name;
    double sd = 0.0;
    bool is_absolute = false;
  };
  std::vector<Uncertainty> uncertainty;
  /// Covariance of natural logarithms, and of values for names whose `uncertainty` is absolute, where the file states
  /// it; for its names it stands in place of `uncertainty`.
  struct JointUncertainty {
    std::vector<std::string> names;
    Eigen::MatrixXd matrix;  ///< symmetric, no negative variance in any direction
  };
  std::optional<JointUncertainty> coefficient_covariance;
  double u0_mps = 0.0;              ///< surge at which maneuvers start unless told otherwise
  double random_interval_s = 0.0;   ///< time between random orders
  std::vector<PartSource> sources;  ///< of particulars, inertia, each module and the actuators, in this order
  std::map<std::string, std::string> coefficient_sources;  ///< where single coefficients come from, by their names

  /// Nothing where the ship has no such actuator.
  const Actuator* find_actuator(Channel channel) const;
  std::vector<Channel> actuator_channels() const;
  Actuators<double> initial_actuators() const;
  /// Multiplies and moves coefficients, also such as have a factor already.
  void multiply(const std::vector<CoefficientFactor>& factors);
  bool has_absolute_uncertainty() const;
  /// Whether the file states the uncertainty of this coefficient's value, not of its logarithm.
  bool is_absolute(std::string_view coefficient) const;
  /// The actuators that drive the ship: its propeller, or the thrusters that do so.
  std::vector<Actuator> propulsion() const;
  /// The same revolutions for all of them [1/s].
  void order_propulsion(double n, Actuators<double>& command) const;
  bool has_propeller() const;
  bool has_rudders() const;
  bool has_twin_rudders() const;
  bool has_wind() const;  ///< forces of the wind
  /// C_b as the mass implies it: m' L/(2 B).
  double block_coefficient() const { return inertia.m * particulars.L_pp / (2.0 * particulars.B); }
};

/// Reads a ship ("-": standard input): a path, or the name of a shipped one such as "vectwin-3m". docs/mmg-sim.md
/// describes the keys. Throws InputError for an unknown, missing or impossible value, for a module without its
/// actuator, and for an actuator that no module reads; UsageError for a name that is not shipped.
Ship read_ship(const std::string& name_or_path);

/// The same from its JSON; `file` stands in messages.
Ship parse_ship(const io::Json& json, const std::string& file);

/// A ship's JSON with its coefficients multiplied and moved, also such as have a factor already.
///   source  of the factors
io::Json multiplied(io::Json ship, const std::vector<CoefficientFactor>& factors, const std::string& source);

/// One effect, a JSON object with "type", for Ship::effects.
EffectEntry parse_effect(const io::JsonObject& json);
/// Reads one effect or an array of them.
std::vector<EffectEntry> read_effects(const std::string& path);

}  // namespace leeway
