#include "gap/conventions.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>

#include <fmt/format.h>

#include "core/errors.hpp"
#include "core/parallel.hpp"
#include "core/units.hpp"
#include "core/wind.hpp"
#include "dynamics/replay.hpp"
#include "gap/kinematic_windows.hpp"

namespace leeway::gap {
namespace {

// A reading is claimed only if the log-odds exceed the first, their mean over the blocks so many standard errors, and
// the error shrinks by the ratio: kinematics know no parameters, forces do.
constexpr double kUnexplainedTurn = 0.7;  // share of what the heading turned that a yaw rate may leave
constexpr double kDecisive = 10.0, kCertain = 3.0, kKinematicRatio = 2.0, kForceRatio = 1.3;
constexpr double kLikeOthers = 2.0;  // times their error: what is left where one recording is read rightly
constexpr double kOddOne = 6.0, kOddOneRatio = 1.5;  // of one recording where all others read as stated
constexpr double kAgainstPlain = 5.0;                // log-odds against a plain error of the force,
constexpr double kAbsentRatio = 1.15;                // against no force at all
constexpr double kMostPerBlock = 4.0;                // log-odds that one block may give [nats]
constexpr double kPerReading = 6.0;                  // log-odds against each reading that differs [nats]
constexpr double kLargestError = 10.0;               // in units of the typical change: beyond, all is equally wrong
constexpr std::size_t kFewestBlocks = 4, kMostWindows = 480, kWindowsPerBlock = 3, kMostForceReadings = 4,
                      kMostInPairs = 9;
constexpr double kDiffering = 0.5;  // of the median error: from there on two readings differ in a window
// The error of a force that counts as a plain error of a parameter, on either side.
constexpr std::array kPlainGains{0.0, 0.7, 1.0, 1.4};

struct ReadingEntry {
  std::string_view channel, name, says;
  std::function<void(Trajectory&)> apply;
};

void scale(Trajectory& recording, Channel channel, double factor) {
  for (double& x : recording[channel]) x *= factor;
}
void unwrap_scaled(Trajectory& recording, Channel channel, double factor) {
  scale(recording, channel, factor);
  unwrap(recording[channel]);
}

constexpr double kToDegrees = 1.0 / kDegree;

// All readings. A recording is reread in this order.
const std::vector<ReadingEntry>& entries() {
  using R = Trajectory&;
  static const std::vector<ReadingEntry> all = [] {
    std::vector<ReadingEntry> list{
        {"psi", "counter-clockwise", "psi is positive counter-clockwise", [](R t) { scale(t, Channel::psi, -1.0); }},
        {"psi", "radians", "psi_deg holds radians", [](R t) { unwrap_scaled(t, Channel::psi, kToDegrees); }},
        {"psi", "degrees", "psi_rad holds degrees", [](R t) { unwrap_scaled(t, Channel::psi, kDegree); }},
        {"x0", "east", "x0 is east and y0 north", [](R t) { std::swap(t[Channel::x0], t[Channel::y0]); }},
        {"y0", "west", "y0 is positive to the west", [](R t) { scale(t, Channel::y0, -1.0); }},
        {"u", "knots", "u and vm are in knots",
         [](R t) {
           scale(t, Channel::u, kKnot);
           scale(t, Channel::vm, kKnot);
         }},
        {"vm", "port-positive", "vm is positive to port", [](R t) { scale(t, Channel::vm, -1.0); }},
        {"r", "counter-clockwise", "r is positive to port", [](R t) { scale(t, Channel::r, -1.0); }},
        {"r", "radians", "r_degps holds radians per second", [](R t) { scale(t, Channel::r, kToDegrees); }},
        {"r", "degrees", "r_radps holds degrees per second", [](R t) { scale(t, Channel::r, kDegree); }},
        {"wind", "apparent", "the true wind is the apparent one",
         [](R t) {
           std::swap(t[Channel::wind_speed], t[Channel::app_wind_speed]);
           std::swap(t[Channel::wind_dir], t[Channel::app_wind_dir]);
         }},
        {"delta", "port-positive", "rudder angles are positive to port",
         [](R t) {
           for (const Channel rudder : {Channel::delta, Channel::delta_p, Channel::delta_s}) scale(t, rudder, -1.0);
         }},
        {"delta_p", "port-positive", "delta_p is positive to port", [](R t) { scale(t, Channel::delta_p, -1.0); }},
        {"delta_s", "port-positive", "delta_s is positive to port", [](R t) { scale(t, Channel::delta_s, -1.0); }},
        {"delta", "radians", "rudder angles labeled deg are in radians",
         [](R t) {
           for (const Channel rudder : {Channel::delta, Channel::delta_p, Channel::delta_s})
             scale(t, rudder, kToDegrees);
         }},
        {"delta", "degrees", "rudder angles labeled rad are in degrees",
         [](R t) {
           for (const Channel rudder : {Channel::delta, Channel::delta_p, Channel::delta_s}) scale(t, rudder, kDegree);
         }},
        {"n_p", "rpm", "n_p is in revolutions per minute", [](R t) { scale(t, Channel::n_p, 1.0 / 60.0); }},
        {"n_p", "radians", "n_p is in radians per second", [](R t) { scale(t, Channel::n_p, 0.5 / kPi); }},
        {"n_bt", "port-positive", "n_bt is positive where the force goes to port",
         [](R t) { scale(t, Channel::n_bt, -1.0); }},
        {"n_bt", "rpm", "n_bt is in revolutions per minute", [](R t) { scale(t, Channel::n_bt, 1.0 / 60.0); }},
        {"n_st", "port-positive", "n_st is positive where the force goes to port",
         [](R t) { scale(t, Channel::n_st, -1.0); }},
    };
    struct Wind {
      std::string_view direction, speed, word;
      Channel direction_channel, speed_channel;
    };
    for (const Wind& wind :
         {Wind{"wind_dir", "wind_speed", "true", Channel::wind_dir, Channel::wind_speed},
          Wind{"app_wind_dir", "app_wind_speed", "apparent", Channel::app_wind_dir, Channel::app_wind_speed}}) {
      const bool is_true = wind.word == "true";
      const Channel direction = wind.direction_channel, speed = wind.speed_channel;
      list.push_back({wind.direction, "wind-to",
                      is_true ? "wind_dir is where the wind blows to" : "app_wind_dir is where the wind blows to",
                      [direction](R t) {
                        for (double& x : t[direction]) x += kPi;
                      }});
      list.push_back({wind.direction, "radians",
                      is_true ? "wind_dir_deg holds radians" : "app_wind_dir_deg holds radians",
                      [direction](R t) { scale(t, direction, kToDegrees); }});
      list.push_back({wind.speed, "knots", is_true ? "wind_speed is in knots" : "app_wind_speed is in knots",
                      [speed](R t) { scale(t, speed, kKnot); }});
    }
    return list;
  }();
  return all;
}

const ReadingEntry* find_entry(std::string_view channel, std::string_view name) {
  for (const ReadingEntry& entry : entries())
    if (entry.channel == channel && entry.name == name) return &entry;
  return nullptr;
}

bool any_has(const std::vector<Trajectory>& recordings, Channel channel) {
  return std::any_of(recordings.begin(), recordings.end(), [&](const Trajectory& t) { return t.has(channel); });
}

std::vector<Trajectory> applied(std::vector<Trajectory> recordings, const std::vector<const ReadingEntry*>& readings) {
  for (Trajectory& recording : recordings)
    for (const ReadingEntry& entry : entries())
      if (std::find(readings.begin(), readings.end(), &entry) != readings.end()) entry.apply(recording);
  return recordings;
}

// Errors of one way to read, one per block; NaN where a block has no data.
using BlockErrors = std::vector<double>;

double total_error(const BlockErrors& errors) {
  double sum = 0.0, count = 0.0;
  for (const double e : errors)
    if (std::isfinite(e)) sum += e * e, count += 1.0;
  return count > 0.0 ? std::sqrt(sum / count) : 0.0;
}

struct Odds {
  double log_odds = 0.0, ratio = 1.0;
  bool is_certain = false;  ///< the blocks agree
};

// Of one way to read against another. Within a block errors last, so that it counts as two independent ones.
Odds odds_of(const BlockErrors& better, const BlockErrors& worse) {
  Odds odds;
  double squares = 0.0, n = 0.0;
  for (std::size_t b = 0; b < better.size(); ++b) {
    if (!std::isfinite(better[b]) || !std::isfinite(worse[b])) continue;
    const double d = std::clamp(2.0 * std::log((worse[b] + 1e-9) / (better[b] + 1e-9)), -kMostPerBlock, kMostPerBlock);
    odds.log_odds += d;
    squares += d * d;
    n += 1.0;
  }
  odds.ratio = (total_error(worse) + 1e-9) / (total_error(better) + 1e-9);
  if (n >= static_cast<double>(kFewestBlocks)) {
    const double mean = odds.log_odds / n, sd = std::sqrt(std::max(0.0, squares / n - mean * mean) / (n - 1.0));
    odds.is_certain = mean > kCertain * sd;
  }
  return odds;
}

Reading reading_of(const ReadingEntry& entry, const Odds& odds, const char* what) {
  Reading reading{std::string(entry.channel), std::string(entry.name), "", odds.log_odds, odds.ratio};
  const double times = odds.ratio >= 1.0 ? odds.ratio : 1.0 / odds.ratio;
  reading.sentence =
      fmt::format("if {}, the error of {} is {:.{}f} times {} than as stated (log-odds {:.0f})", entry.says, what,
                  times, times < 10.0 ? 2 : 0, odds.ratio >= 1.0 ? "smaller" : "larger", odds.log_odds);
  return reading;
}

// Puts a reading among the tested; a later test of the same one, with others corrected, replaces the earlier.
void note_tested(Conventions& result, const Reading& reading) {
  for (Reading& tested : result.tested)
    if (tested.channel == reading.channel && tested.name == reading.name) {
      tested = reading;
      return;
    }
  result.tested.push_back(reading);
}

// Root mean square of the windows' residuals of one kind, by unit of the windows. That of the heading is a share of
// what the heading turned: otherwise radians read as degrees would do well by being small.
BlockErrors window_errors(const KinematicWindows& windows, Kinematics kind) {
  Eigen::VectorXd residuals = windows.residuals({});
  if (kind == Kinematics::heading) residuals /= std::max(1e-6, windows.rms_turned());
  BlockErrors sums(windows.unit_count(), 0.0), counts(windows.unit_count(), 0.0);
  for (const WindowRun& run : windows.runs())
    if (run.kind == kind) {
      sums[run.unit] += residuals.segment(run.begin, run.size).squaredNorm();
      counts[run.unit] += static_cast<double>(run.size);
    }
  for (std::size_t b = 0; b < sums.size(); ++b) sums[b] = counts[b] > 0.0 ? std::sqrt(sums[b] / counts[b]) : kMissing;
  return sums;
}

std::size_t blocks_with_data(const BlockErrors& errors) {
  return static_cast<std::size_t>(
      std::count_if(errors.begin(), errors.end(), [](double e) { return std::isfinite(e); }));
}

// One reading for each question, or the stated one.
using Combination = std::vector<const ReadingEntry*>;

// All combinations of one alternative, or none, from each group.
std::vector<Combination> combinations(const std::vector<std::vector<const ReadingEntry*>>& groups) {
  std::vector<Combination> all{{}};
  for (const auto& group : groups) {
    const std::vector<Combination> before = all;
    for (const ReadingEntry* entry : group)
      for (Combination combination : before) {
        combination.push_back(entry);
        all.push_back(std::move(combination));
      }
  }
  return all;
}

// Finds the combination that explains the errors with the fewest changes, and claims what is decisive in it.
//   errors  of the recordings read by a combination; several lists, each against its own scale
std::vector<const ReadingEntry*> judge(const std::vector<std::vector<const ReadingEntry*>>& groups,
                                       const std::function<std::vector<BlockErrors>(const Combination&)>& errors,
                                       const char* what, Conventions& result) {
  const std::vector<Combination> all = combinations(groups);
  std::vector<std::vector<BlockErrors>> of;
  for (const Combination& combination : all) of.push_back(errors(combination));
  const auto against = [&](std::size_t better, std::size_t worse) {
    Odds total;
    for (std::size_t kind = 0; kind < of[better].size(); ++kind) {
      const Odds odds = odds_of(of[better][kind], of[worse][kind]);
      total.log_odds += odds.log_odds;
      // The kind in which the readings differ most tells the ratio.
      if (std::abs(std::log(odds.ratio)) > std::abs(std::log(total.ratio))) total.ratio = odds.ratio;
      total.is_certain = total.is_certain || odds.is_certain;
    }
    return total;
  };
  std::size_t best = 0;
  double best_score = 0.0;
  for (std::size_t c = 1; c < all.size(); ++c) {
    const double score = against(c, 0).log_odds - kPerReading * static_cast<double>(all[c].size());
    if (score > best_score) {
      best = c;
      best_score = score;
    }
    if (all[c].size() == 1) note_tested(result, reading_of(*all[c][0], against(c, 0), what));
  }
  std::vector<const ReadingEntry*> claimed;
  for (const ReadingEntry* entry : all[best]) {
    Combination rest = all[best];
    rest.erase(std::find(rest.begin(), rest.end(), entry));
    const auto without = static_cast<std::size_t>(std::find(all.begin(), all.end(), rest) - all.begin());
    const Odds odds = against(best, without);
    if (odds.log_odds < kDecisive || odds.ratio < kKinematicRatio || !odds.is_certain) continue;
    // A yaw rate that is noise does well by being made small: it has to explain what the heading turned.
    if (entry->channel == "r" && total_error(of[best].front()) > kUnexplainedTurn) continue;
    claimed.push_back(entry);
    result.contradicted.push_back(reading_of(*entry, odds, what));
    note_tested(result, result.contradicted.back());
  }
  return claimed;
}

std::vector<const ReadingEntry*> pick(std::initializer_list<std::pair<std::string_view, std::string_view>> names) {
  std::vector<const ReadingEntry*> result;
  for (const auto& [channel, name] : names) result.push_back(find_entry(channel, name));
  return result;
}

// eta' against R(psi) nu and psi' against r.
std::vector<const ReadingEntry*> judge_kinematics(const std::vector<Trajectory>& recordings, Conventions& result) {
  const KinematicWindows stated(recordings, 10.0);
  const std::size_t track = blocks_with_data(window_errors(stated, Kinematics::track));
  const std::size_t heading = blocks_with_data(window_errors(stated, Kinematics::heading));
  if (heading < kFewestBlocks) {
    result.unchecked.push_back("psi and r: too little heading and yaw rate to compare psi' with r");
    return {};
  }
  std::vector<std::vector<const ReadingEntry*>> groups{
      pick({{"psi", "counter-clockwise"}, {"psi", "radians"}, {"psi", "degrees"}}),
      pick({{"r", "counter-clockwise"}, {"r", "radians"}, {"r", "degrees"}})};
  if (track >= kFewestBlocks) {
    groups.push_back(pick({{"x0", "east"}, {"y0", "west"}}));
    groups.push_back(pick({{"vm", "port-positive"}}));
    groups.push_back(pick({{"u", "knots"}}));
  } else {
    result.unchecked.push_back("x0, y0, u, vm: no track with a heading to compare eta' with R(psi) nu");
  }
  // r leaves the track alone, and positions and velocities leave psi' - r alone: neither is computed twice.
  std::vector<std::pair<Combination, BlockErrors>> known;
  const auto errors_of = [&](const Combination& combination, Kinematics kind) {
    Combination needed;
    for (const ReadingEntry* entry : combination)
      if (entry->channel == "psi" || (entry->channel == "r") == (kind == Kinematics::heading)) needed.push_back(entry);
    Combination key = needed;
    key.push_back(kind == Kinematics::heading ? nullptr : &entries().back());
    for (const auto& [combination_known, errors] : known)
      if (combination_known == key) return errors;
    const std::vector<Trajectory> reread_ones = applied(recordings, needed);
    const KinematicWindows windows(reread_ones, 10.0);
    known.emplace_back(key, window_errors(windows, kind));
    return known.back().second;
  };
  return judge(
      groups,
      [&](const Combination& combination) {
        std::vector<BlockErrors> errors{errors_of(combination, Kinematics::heading)};
        if (track >= kFewestBlocks) errors.push_back(errors_of(combination, Kinematics::track));
        return errors;
      },
      "the kinematics", result);
}

// w'_A against R(psi)^T w_T + (u, v_m), where both winds are recorded.
std::vector<const ReadingEntry*> judge_wind(const std::vector<Trajectory>& recordings, Conventions& result) {
  const auto errors = [&](const Combination& combination) {
    const std::vector<Trajectory> read = applied(recordings, combination);
    BlockErrors blocks;
    for (const Trajectory& t : read) {
      for (const Channel needed : {Channel::wind_speed, Channel::wind_dir, Channel::app_wind_speed,
                                   Channel::app_wind_dir, Channel::psi, Channel::u, Channel::vm})
        if (!t.has(needed)) return std::vector<BlockErrors>{};
      const std::size_t step = std::max<std::size_t>(1, t.size() / 400);
      const std::size_t parts = std::clamp<std::size_t>(16 / read.size(), 1, 8);
      for (std::size_t part = 0; part < parts; ++part) {
        double sum = 0.0, count = 0.0;
        for (std::size_t k = part * t.size() / parts; k < (part + 1) * t.size() / parts; k += step) {
          const Vec2<double> expected =
              apparent_wind<double>(wind_from_vector(t[Channel::wind_speed][k], t[Channel::wind_dir][k]),
                                    t[Channel::psi][k], t[Channel::u][k], t[Channel::vm][k]);
          const Vec2<double> error =
              expected - wind_from_vector(t[Channel::app_wind_speed][k], t[Channel::app_wind_dir][k]);
          if (!error.allFinite()) continue;
          sum += error.squaredNorm();
          count += 1.0;
        }
        blocks.push_back(count > 0.0 ? std::sqrt(sum / count) : kMissing);
      }
    }
    return std::vector<BlockErrors>{blocks};
  };
  const std::vector<BlockErrors> stated = errors({});
  if (stated.empty() || blocks_with_data(stated[0]) < kFewestBlocks) return {};
  return judge({pick({{"wind", "apparent"}}), pick({{"wind_dir", "wind-to"}, {"wind_dir", "radians"}}),
                pick({{"app_wind_dir", "wind-to"}, {"app_wind_dir", "radians"}}), pick({{"wind_speed", "knots"}}),
                pick({{"app_wind_speed", "knots"}})},
               errors, "true against apparent wind", result);
}

using WindowError = Eigen::Matrix<double, 9, 1>;

// The blocks of two ways to read, from the windows in which they differ: where a thruster rests or the wind is faint,
// nothing can be told about it.
struct Compared {
  BlockErrors better, worse;
};
Compared compared(const std::vector<WindowError>& better, const std::vector<WindowError>& worse) {
  std::vector<double> least;
  for (std::size_t w = 0; w < better.size(); ++w)
    if (better[w].allFinite() && worse[w].allFinite()) least.push_back(std::min(better[w].norm(), worse[w].norm()));
  Compared result;
  if (least.empty()) return result;
  const auto middle = least.begin() + static_cast<std::ptrdiff_t>(least.size() / 2);
  std::nth_element(least.begin(), middle, least.end());
  const double differing = kDiffering * *middle;
  double sum_better = 0.0, sum_worse = 0.0;
  std::size_t count = 0;
  for (std::size_t w = 0; w < better.size(); ++w) {
    if (!better[w].allFinite() || !worse[w].allFinite() || (better[w] - worse[w]).norm() < differing) continue;
    sum_better += better[w].squaredNorm();
    sum_worse += worse[w].squaredNorm();
    if (++count % kWindowsPerBlock != 0) continue;
    result.better.push_back(std::sqrt(sum_better));
    result.worse.push_back(std::sqrt(sum_worse));
    sum_better = sum_worse = 0.0;
  }
  return result;
}
Odds odds_of(const std::vector<WindowError>& better, const std::vector<WindowError>& worse) {
  const Compared blocks = compared(better, worse);
  return odds_of(blocks.better, blocks.worse);
}

// Short predictions by the ship's model from recorded states, against what was recorded.
class ForceCheck {
 public:
  ForceCheck(const Ship& ship, const std::vector<Trajectory>& recordings) : ship_(ship), model_(ship) {
    horizon_s_ = 15.0 * std::sqrt(ship.particulars.L_pp / 3.0);
    std::size_t possible = 0;
    for (const Trajectory& t : recordings)
      if (t.size() > 1)
        possible += static_cast<std::size_t>((t[Channel::t].back() - t[Channel::t].front()) / horizon_s_);
    const std::size_t every = std::max<std::size_t>(1, (possible + kMostWindows - 1) / kMostWindows);
    std::array<std::vector<double>, 3> changes;
    for (std::size_t i = 0; i < recordings.size(); ++i) {
      const Trajectory& t = recordings[i];
      if (t.size() < 2) continue;
      const auto count = static_cast<std::size_t>((t[Channel::t].back() - t[Channel::t].front()) / horizon_s_);
      for (std::size_t w = 0; w < count; w += every) {
        const double start = t[Channel::t].front() + static_cast<double>(w) * horizon_s_;
        const auto from = state_at(t, start), to = state_at(t, start + horizon_s_);
        if (!from || !to) continue;
        windows_.push_back({i, start});
        for (int axis = 0; axis < 3; ++axis)
          changes[static_cast<std::size_t>(axis)].push_back(std::abs(to->nu(axis) - from->nu(axis)));
      }
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      double squares = 0.0;
      for (const double change : changes[axis]) squares += change * change;
      spread_(static_cast<Eigen::Index>(axis)) =
          std::max(1e-6, std::sqrt(squares / static_cast<double>(std::max<std::size_t>(1, changes[axis].size()))));
    }
  }

  std::size_t blocks() const { return windows_.size() / kWindowsPerBlock; }

  // Errors of the predicted velocities at three times of each window, in units of the typical change of each velocity;
  // NaN where there is none to compare.
  std::vector<WindowError> errors(const std::vector<Trajectory>& recordings) const {
    std::vector<std::optional<RecordedInputs>> inputs(recordings.size());
    for (std::size_t i = 0; i < recordings.size(); ++i)
      inputs[i] =
          RecordedInputs(recordings[i], ship_, InputInterpolation::linear).through(model_.effects.rudder_response());
    std::vector<WindowError> result(windows_.size(), WindowError::Constant(kMissing));
    for (std::size_t w = 0; w < windows_.size(); ++w) {
      const auto [i, start] = windows_[w];
      const Trajectory& t = recordings[i];
      const auto first = inputs[i]->first_known();
      if (!first || t[Channel::t][*first] > start) continue;
      std::optional<ShipState<double>> state = state_at(t, start);
      constexpr int kSteps = 60, kLooks = 3;
      const double dt_s = horizon_s_ / kSteps;
      for (int step = 0; state && step < kSteps; ++step) {
        const double now = start + step * dt_s;
        if (state->nu.allFinite()) *state = integrate(model_, *state, inputs[i]->step(now, dt_s), dt_s);
        if ((step + 1) % (kSteps / kLooks) != 0) continue;
        const auto seen = state_at(t, now + dt_s);
        if (!seen) continue;
        for (int axis = 0; axis < 3; ++axis) {
          const double error = (state->nu(axis) - seen->nu(axis)) / spread_(axis);
          result[w](3 * ((step + 1) / (kSteps / kLooks) - 1) + axis) =
              std::isfinite(error) ? std::clamp(error, -kLargestError, kLargestError) : kLargestError;
        }
      }
    }
    return result;
  }

 private:
  // The mean of the samples about a time; without a heading it stays zero.
  std::optional<ShipState<double>> state_at(const Trajectory& t, double time) const {
    const std::vector<double>& times = t[Channel::t];
    const double half = std::max(0.04 * horizon_s_, 0.51 * sampling_time_of(t));
    ShipState<double> sum;
    double count = 0.0;
    for (auto k = static_cast<std::size_t>(std::lower_bound(times.begin(), times.end(), time - half) - times.begin());
         k < times.size() && times[k] <= time + half; ++k) {
      const Vec3<double> nu{t[Channel::u][k], t[Channel::vm][k], t[Channel::r][k]};
      const double psi = t.has(Channel::psi) ? t[Channel::psi][k] : 0.0;
      if (!nu.allFinite() || !std::isfinite(psi)) continue;
      sum.nu += nu;
      sum.eta(2) += psi;
      count += 1.0;
    }
    if (count == 0.0) return std::nullopt;
    sum.nu /= count;
    sum.eta /= count;
    return sum;
  }
  static double sampling_time_of(const Trajectory& t) {
    return (t[Channel::t].back() - t[Channel::t].front()) / static_cast<double>(t.size() - 1);
  }

  struct Window {
    std::size_t recording;
    double start_s;
  };
  const Ship& ship_;
  Model<double> model_;
  double horizon_s_ = 0.0;
  std::vector<Window> windows_;
  Vec3<double> spread_ = Vec3<double>::Ones();
};

// Root mean square of the errors of one recording, in units of its own typical changes; none where it is too short.
std::optional<double> typical_force_error(const Ship& ship, const Trajectory& recording) {
  const ForceCheck check(ship, {recording});
  double sum = 0.0, count = 0.0;
  for (const WindowError& error : check.errors({recording}))
    if (error.allFinite()) sum += error.squaredNorm(), count += static_cast<double>(error.size());
  return count > 0.0 ? std::optional(std::sqrt(sum / count)) : std::nullopt;
}

bool is_judged_by_forces(std::string_view channel) {
  constexpr std::array kKinematic{"psi", "x0", "y0", "u", "vm", "r"};
  return std::find(kKinematic.begin(), kKinematic.end(), channel) == kKinematic.end();
}

// The force that a channel's input makes times `gain`, about as a wrong coefficient would have it.
void with_gain(Trajectory& recording, std::string_view channel, double gain) {
  if (channel.starts_with("delta"))
    for (const Channel rudder : {Channel::delta, Channel::delta_p, Channel::delta_s}) scale(recording, rudder, gain);
  else if (channel == "n_p")
    scale(recording, Channel::n_p, std::sqrt(gain));
  else if (channel == "n_bt")
    scale(recording, Channel::n_bt, std::sqrt(gain));
  else if (channel == "n_st")
    scale(recording, Channel::n_st, std::sqrt(gain));
  else
    for (const Channel speed : {Channel::wind_speed, Channel::app_wind_speed}) scale(recording, speed, std::sqrt(gain));
}

double largest_rudder_angle(const std::vector<Trajectory>& recordings) {
  double largest = 0.0;
  for (const Trajectory& t : recordings)
    for (const Channel rudder : {Channel::delta, Channel::delta_p, Channel::delta_s})
      if (t.has(rudder))
        for (const double angle : t[rudder])
          if (std::abs(angle) > largest) largest = std::abs(angle);
  return largest;
}

// Whether a reading changes these recordings, and concerns what the ship's forces need.
bool concerns_forces(const ReadingEntry& entry, const Ship& ship, const std::vector<Trajectory>& recordings,
                     bool wind_is_settled, bool velocities_are_settled) {
  const bool has_true = any_has(recordings, Channel::wind_speed) && any_has(recordings, Channel::wind_dir);
  const bool has_apparent = any_has(recordings, Channel::app_wind_speed) && any_has(recordings, Channel::app_wind_dir);
  const std::string_view channel = entry.channel;
  if (channel == "wind" || channel.find("wind_") != std::string_view::npos) {
    if (!ship.wind || wind_is_settled || !any_has(recordings, Channel::psi)) return false;
    if (channel == "wind") return has_true != has_apparent;
    return channel.starts_with("app_") ? has_apparent && !has_true : has_true;
  }
  if (channel == "delta" && entry.name == "radians")  // only angles that a rudder can have
    return largest_rudder_angle(recordings) * kToDegrees <= kPi;
  if (channel == "delta" && entry.name == "degrees")  // only angles that no rudder has
    return largest_rudder_angle(recordings) > kPi;
  if (channel == "delta") return true;
  if (channel == "vm" || channel == "r") return !velocities_are_settled;
  for (const Channel actuator : {Channel::delta_p, Channel::delta_s, Channel::n_p, Channel::n_bt, Channel::n_st})
    if (info(actuator).name == channel) return ship.find_actuator(actuator) && any_has(recordings, actuator);
  return false;
}

void judge_forces(const Ship& ship, std::vector<Trajectory> recordings, bool wind_is_settled,
                  bool velocities_are_settled, Conventions& result) {
  std::erase_if(recordings, [&](const Trajectory& t) {
    const auto lacks = [&](const Actuator& a) { return !a.is_optional && !t.has(a.channel); };
    const bool is_short = std::any_of(ship.actuators.begin(), ship.actuators.end(), lacks) ||
                          (t.has_wind() && ship.wind && !t.has(Channel::psi));
    if (is_short) result.unchecked.push_back(t.name + ": lacks an actuator or the heading that the forces need");
    return is_short;
  });
  const ForceCheck check(ship, recordings);
  if (check.blocks() < kFewestBlocks) {
    result.unchecked.push_back("actuators and wind: too little to compare with the ship's model");
    return;
  }
  if (!ship.wind || !std::any_of(recordings.begin(), recordings.end(), [](const auto& t) { return t.has_wind(); }))
    result.unchecked.push_back("wind: not recorded, or without a force in the ship's model");

  const auto is_decisive = [](const Odds& odds, double ratio) {
    return odds.log_odds > kDecisive && odds.is_certain && odds.ratio > ratio;
  };
  // Whether a reading of recordings that are read in the stated way, apart from what is settled, beats that way, and
  // also a plain error of the force, or none of it at all.
  const auto holds = [&](const ReadingEntry& entry, const std::vector<Trajectory>& as_stated,
                         const std::vector<WindowError>& errors, const Odds& odds) {
    if (!is_decisive(odds, kForceRatio)) return false;
    if (entry.channel == "vm" || entry.channel == "r") return true;
    for (const double gain : kPlainGains) {
      std::vector<Trajectory> plain = as_stated;
      for (Trajectory& recording : plain) with_gain(recording, entry.channel, gain);
      const Odds rival = odds_of(errors, check.errors(plain));
      if (!(rival.log_odds > kAgainstPlain && rival.is_certain &&
            rival.ratio > (gain == 0.0 ? kAbsentRatio : kForceRatio)))
        return false;
    }
    return true;
  };

  struct Tried {
    const ReadingEntry* entry;
    std::vector<WindowError> errors;
    Odds odds;
    bool holds = false;
  };
  for (std::size_t round = 0; round < kMostForceReadings; ++round) {
    const std::vector<WindowError> stated = check.errors(recordings);
    std::vector<Tried> tried;
    for (const ReadingEntry& entry : entries()) {
      if (!concerns_forces(entry, ship, recordings, wind_is_settled, velocities_are_settled)) continue;
      const auto is_same_channel = [&](const Reading& known) { return known.channel == entry.channel; };
      if (std::any_of(result.contradicted.begin(), result.contradicted.end(), is_same_channel)) continue;
      Tried one{&entry, check.errors(applied(recordings, {&entry})), {}};
      one.odds = odds_of(one.errors, stated);
      one.holds = holds(entry, recordings, one.errors, one.odds);
      note_tested(result, reading_of(entry, one.odds, "the forces"));
      tried.push_back(std::move(one));
    }
    std::stable_sort(tried.begin(), tried.end(),
                     [](const Tried& a, const Tried& b) { return a.odds.log_odds > b.odds.log_odds; });
    const auto best = std::find_if(tried.begin(), tried.end(), [](const Tried& one) { return one.holds; });
    if (best != tried.end()) {
      result.contradicted.push_back(reading_of(*best->entry, best->odds, "the forces"));
      recordings = applied(std::move(recordings), {best->entry});
      continue;
    }
    // Two wrong readings can hide each other: a pair is claimed where each holds given the other.
    std::erase_if(tried, [](const Tried& one) { return one.odds.log_odds == 0.0; });
    tried.resize(std::min(tried.size(), kMostInPairs));
    double best_odds = 0.0;
    std::vector<Reading> best_pair;
    Combination best_entries;
    for (std::size_t a = 0; a < tried.size(); ++a)
      for (std::size_t b = a + 1; b < tried.size(); ++b) {
        if (tried[a].entry->channel == tried[b].entry->channel) continue;
        const std::vector<Trajectory> with_a = applied(recordings, {tried[a].entry});
        const std::vector<Trajectory> with_b = applied(recordings, {tried[b].entry});
        const std::vector<WindowError> both = check.errors(applied(with_a, {tried[b].entry}));
        const Odds of_both = odds_of(both, stated);
        if (!(of_both.log_odds > best_odds) || !is_decisive(of_both, kForceRatio)) continue;
        const Odds of_a = odds_of(both, tried[b].errors), of_b = odds_of(both, tried[a].errors);
        if (!holds(*tried[a].entry, with_b, both, of_a) || !holds(*tried[b].entry, with_a, both, of_b)) continue;
        best_odds = of_both.log_odds;
        best_entries = {tried[a].entry, tried[b].entry};
        best_pair = {reading_of(*tried[a].entry, of_a, "the forces"), reading_of(*tried[b].entry, of_b, "the forces")};
      }
    if (best_entries.empty()) return;
    result.contradicted.insert(result.contradicted.end(), best_pair.begin(), best_pair.end());
    recordings = applied(std::move(recordings), best_entries);
  }
}

Conventions check(const Ship* ship, const std::vector<Trajectory>& given) {
  Conventions result;
  std::vector<Trajectory> recordings = given;
  const std::size_t unchecked = result.unchecked.size();
  const std::vector<const ReadingEntry*> kinematic = judge_kinematics(recordings, result);
  const bool velocities_are_settled = result.unchecked.size() == unchecked;
  recordings = applied(std::move(recordings), kinematic);

  const std::size_t tested = result.tested.size();
  const std::vector<const ReadingEntry*> wind = judge_wind(recordings, result);
  const bool wind_is_settled = result.tested.size() > tested;
  recordings = applied(std::move(recordings), wind);
  if (ship != nullptr)
    judge_forces(*ship, std::move(recordings), wind_is_settled, velocities_are_settled, result);
  else
    result.unchecked.emplace_back("actuators and the wind's force: there is no ship's model to compare with");
  std::stable_sort(result.tested.begin(), result.tested.end(),
                   [](const Reading& a, const Reading& b) { return a.log_odds > b.log_odds; });
  return result;
}

}  // namespace

Conventions check_conventions(const Ship& ship, const std::vector<Trajectory>& recordings) {
  return check(&ship, recordings);
}

Conventions check_conventions(const std::vector<Trajectory>& recordings) { return check(nullptr, recordings); }

std::vector<Reading> contradicted_in_one(const Ship& ship, const std::vector<Trajectory>& recordings,
                                         const Conventions& of_all, std::size_t jobs) {
  const auto odds_of_all = [&](const Reading& reading) {
    for (const Reading& known : of_all.tested)
      if (known.channel == reading.channel && known.name == reading.name) return known.log_odds;
    return 0.0;
  };
  const auto is_read_by_all = [&](std::size_t i) { return reread(recordings[i], of_all.contradicted); };
  // Strong forces that the model lacks are imitated by a reading that weakens an actuator; a right one leaves an error
  // as in the other recordings.
  const auto is_mended = [&](std::size_t i, const Reading& by) {
    std::vector<double> others;
    for (std::size_t j = 0; j < recordings.size(); ++j)
      if (const auto error = typical_force_error(ship, is_read_by_all(j)); j != i && error) others.push_back(*error);
    const auto error = typical_force_error(ship, reread(is_read_by_all(i), {by}));
    if (others.empty() || !error) return true;
    const auto middle = others.begin() + static_cast<std::ptrdiff_t>(others.size() / 2);
    std::nth_element(others.begin(), middle, others.end());
    return *error < kLikeOthers * *middle;
  };
  std::vector<std::optional<Reading>> found(recordings.size());
  parallel_for(recordings.size(), jobs, [&](std::size_t i) {
    const std::vector<Reading> tested = check_conventions(ship, {is_read_by_all(i)}).tested;
    if (tested.empty()) return;
    const Reading& best = tested.front();
    if (best.log_odds > kOddOne && best.error_ratio > kOddOneRatio && odds_of_all(best) - best.log_odds < -kDecisive &&
        (!is_judged_by_forces(best.channel) || is_mended(i, best)))
      found[i] = best;
  });
  std::vector<Reading> result;
  for (std::size_t i = 0; i < found.size(); ++i)
    if (found[i]) {
      found[i]->recording = recordings[i].name;
      found[i]->sentence = recordings[i].name + ": " + found[i]->sentence;
      result.push_back(*found[i]);
    }
  return result;
}

Trajectory reread(const Trajectory& recording, const std::vector<Reading>& readings) {
  std::vector<const ReadingEntry*> known;
  for (const Reading& reading : readings) {
    if (!reading.recording.empty() && reading.recording != recording.name) continue;
    const ReadingEntry* entry = find_entry(reading.channel, reading.name);
    if (!entry) throw UsageError(fmt::format("no reading '{}' of '{}' is known", reading.name, reading.channel));
    known.push_back(entry);
  }
  return applied({recording}, known)[0];
}

}  // namespace leeway::gap
