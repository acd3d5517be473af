#pragma once

#include <string>
#include <vector>

#include "recording/trajectory.hpp"

/// What recordings say of the ship's file: of its coefficients, apart from missing physics and sensors.
namespace leeway::gap {

enum class ShipFileState { as_stated, off, cannot_tell };

/// A number that recordings know about as a factor on what the ship's file makes of it.
struct FileFactor {
  double factor = 1.0, low = 1.0, high = 1.0;  ///< low, high: 95 % interval
  bool is_off() const { return low > 1.0 || high < 1.0; }
};

/// What a module does where the recordings were made: its resistance at their usual speed, and the like.
struct ModuleChange {
  std::string quantity;              ///< "resistance", "turning moment of the rudder"
  std::string where;                 ///< "at 1.18 m/s"
  std::string unit;                  ///< of `before` and `after`
  double before = 0.0, after = 0.0;  ///< by the ship's file, and with the coefficients that were fitted
  FileFactor by;                     ///< after/before
  std::string by_effect{};           ///< of the catalogue, if one does the same
};

/// A module whose coefficients alone were fitted, all others as the file has them.
struct CalibratedModule {
  std::string name;                   ///< "hull", as coefficient names begin
  double gain = 0.0, gain_sd = 0.0;   ///< over the file, on what was left out in turn [nats]
  bool helps_free_runs = false;       ///< whether errors of free runs over what was left out fall beyond chance
  std::vector<ModuleChange> changes;  ///< the surest first
};

/// A coefficient, or a group of them, as all were fitted together.
struct FittedCoefficient {
  std::string name;
  bool is_absolute = false;            ///< the file states an absolute uncertainty: `by` is nothing then
  bool is_form = false;                ///< a term of another form of the same force
  bool may_be_far = false;             ///< whether it may be off by far more than stated, with a probability
  double far_off = 0.0;                ///< which is this one
  double stated_sd = 0.0;              ///< of the logarithm, or absolute
  double shift = 0.0, shift_sd = 0.0;  ///< of the logarithm, or absolute
  FileFactor by;
  std::string module() const { return name.substr(0, name.find('.')); }
};

/// One thing of the file that is off.
struct ShipFileFinding {
  std::string name;  ///< of the module or of the coefficient
  FileFactor by;
  double stated_log_sd = kMissing;  ///< of a coefficient
  double heldout_gain = 0.0;        ///< of its module, alone [nats]
  std::string sentence;
  std::string cause{};  ///< what may have happened to the ship instead: "a damaged or fouled rudder"
};

struct ShipFile {
  ShipFileState state = ShipFileState::cannot_tell;
  std::vector<ShipFileFinding> findings;  ///< what matters most first; none unless it is off
  std::vector<CalibratedModule> modules;  ///< each alone, the largest gain first
  std::vector<CalibratedModule> off;      ///< those that are, each with its gain beside those before, and its changes
  std::string sentence;                   ///< the state in words
  double heldout_gain = 0.0, heldout_gain_sd = 0.0;  ///< of all coefficients together, over the file [nats]
};

}  // namespace leeway::gap
