#include "gap/sensors/reading_odds.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "gap/policy/policy.hpp"

namespace leeway::gap {
namespace {

// All combinations of one alternative, or none, from each group.
std::vector<Combination> combinations(const std::vector<Combination>& groups) {
  std::vector<Combination> all{{}};
  for (const Combination& group : groups) {
    const std::vector<Combination> before = all;
    for (const ReadingEntry* entry : group)
      for (Combination combination : before) {
        combination.push_back(entry);
        all.push_back(std::move(combination));
      }
  }
  return all;
}

Odds total_odds(const std::vector<BlockErrors>& better, const std::vector<BlockErrors>& worse) {
  Odds total;
  for (std::size_t kind = 0; kind < better.size(); ++kind) {
    const Odds odds = odds_of(better[kind], worse[kind]);
    total.log_odds += odds.log_odds;
    // The ratio is that of the kind in which the readings differ most.
    if (std::abs(std::log(odds.ratio)) > std::abs(std::log(total.ratio))) total.ratio = odds.ratio;
    total.is_certain = total.is_certain || odds.is_certain;
  }
  return total;
}

}  // namespace

double total_error(const BlockErrors& errors) {
  double sum = 0.0, count = 0.0;
  for (const double e : errors)
    if (std::isfinite(e)) sum += e * e, count += 1.0;
  return count > 0.0 ? std::sqrt(sum / count) : 0.0;
}

std::size_t blocks_with_data(const BlockErrors& errors) {
  return static_cast<std::size_t>(
      std::count_if(errors.begin(), errors.end(), [](double e) { return std::isfinite(e); }));
}

Odds odds_of(const BlockErrors& better, const BlockErrors& worse) {
  Odds odds;
  double squares = 0.0, n = 0.0;
  for (std::size_t b = 0; b < better.size(); ++b) {
    if (!std::isfinite(better[b]) || !std::isfinite(worse[b])) continue;
    const double d =
        std::clamp(2.0 * std::log((worse[b] + kPolicy.sensors.least_error) / (better[b] + kPolicy.sensors.least_error)),
                   -kPolicy.sensors.most_odds_per_block, kPolicy.sensors.most_odds_per_block);
    odds.log_odds += d;
    squares += d * d;
    n += 1.0;
  }
  odds.ratio = (total_error(worse) + kPolicy.sensors.least_error) / (total_error(better) + kPolicy.sensors.least_error);
  if (n >= static_cast<double>(kPolicy.sensors.fewest_blocks)) {
    const double mean = odds.log_odds / n, sd = std::sqrt(std::max(0.0, squares / n - mean * mean) / (n - 1.0));
    odds.is_certain = mean > kPolicy.sensors.certain_sd * sd;
  }
  return odds;
}

Reading reading_of(const ReadingEntry& entry, const Odds& odds, const char* what) {
  Reading reading{std::string(entry.channel), std::string(entry.name), "", odds.log_odds, odds.ratio};
  const double times = odds.ratio >= 1.0 ? odds.ratio : 1.0 / odds.ratio;
  reading.premise = fmt::format("if {}", entry.says);
  reading.sentence =
      fmt::format("if {}, the error of {} is {:.{}f} times {} than as stated (log-odds {:.0f})", entry.says, what,
                  times, times < 10.0 ? 2 : 0, odds.ratio >= 1.0 ? "smaller" : "larger", odds.log_odds);
  return reading;
}

void note_tested(Conventions& result, const Reading& reading) {
  for (Reading& tested : result.tested)
    if (tested.channel == reading.channel && tested.name == reading.name) {
      tested = reading;
      return;
    }
  result.tested.push_back(reading);
}

Combination claimed_of(const std::vector<Combination>& groups,
                       const std::function<std::vector<BlockErrors>(const Combination&)>& errors, const char* what,
                       Conventions& result) {
  const std::vector<Combination> all = combinations(groups);
  std::vector<std::vector<BlockErrors>> of;
  of.reserve(all.size());
  for (const Combination& combination : all) of.push_back(errors(combination));
  std::size_t best = 0;
  double best_score = 0.0;
  for (std::size_t c = 1; c < all.size(); ++c) {
    const Odds odds = total_odds(of[c], of[0]);
    const double score = odds.log_odds - kPolicy.sensors.odds_per_reading * static_cast<double>(all[c].size());
    if (score > best_score) {
      best = c;
      best_score = score;
    }
    if (all[c].size() == 1) note_tested(result, reading_of(*all[c][0], odds, what));
  }
  Combination claimed;
  for (const ReadingEntry* entry : all[best]) {
    Combination rest = all[best];
    rest.erase(std::find(rest.begin(), rest.end(), entry));
    const auto without = static_cast<std::size_t>(std::find(all.begin(), all.end(), rest) - all.begin());
    const Odds odds = total_odds(of[best], of[without]);
    if (!holds_by_kinematics(odds)) continue;
    claimed.push_back(entry);
    result.contradicted.push_back(reading_of(*entry, odds, what));
    note_tested(result, result.contradicted.back());
  }
  return claimed;
}

}  // namespace leeway::gap
