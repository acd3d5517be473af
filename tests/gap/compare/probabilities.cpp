#include "gap/compare/probabilities.hpp"

#include <cmath>
#include <numeric>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

using namespace leeway;

namespace {

gap::Fitted fitted(const Ship& ship, const std::vector<std::string>& effects, double log_evidence) {
  gap::Fitted result;
  for (const std::string& effect : effects) result.hypothesis.effects.emplace_back(effect, ship);
  result.log_evidence = log_evidence;
  return result;
}

}  // namespace

TEST_CASE("probabilities: odds are evidence times what was believed before", "[gap]") {
  const Ship ship = read_ship("esso-osaka-3m");
  const std::vector<gap::Fitted> all{fitted(ship, {}, 100.0), fitted(ship, {"steady-current"}, 124.0),
                                     fitted(ship, {"trim", "wake"}, 106.0)};
  CHECK(gap::log_odds(all, 0) == 0.0);
  CHECK(gap::log_odds(all, 1) == Approx(24.0 + gap::log_prior_odds_of_one()));
  CHECK(gap::log_odds(all, 2) == Approx(6.0 + gap::log_prior_odds_of_one() + gap::log_prior_odds_of_one(1)));
}

TEST_CASE("probabilities: what was screened beside a hypothesis and not fitted has its share", "[gap]") {
  const Ship ship = read_ship("esso-osaka-3m");
  const std::vector<gap::Fitted> all{fitted(ship, {}, 0.0), fitted(ship, {"steady-current"}, 5.0),
                                     fitted(ship, {"wave-drift"}, 3.0), fitted(ship, {"steady-current", "trim"}, 6.0)};
  std::vector<double> odds;
  for (std::size_t i = 0; i < all.size(); ++i) odds.push_back(std::exp(gap::log_odds(all, i)));
  const double sum = std::accumulate(odds.begin(), odds.end(), 0.0);
  const std::vector<double> plain = gap::probabilities(all, gap::unseen_effects(all, {}, ship));
  CHECK(std::accumulate(plain.begin(), plain.end(), 0.0) == Approx(1.0));
  CHECK(plain[1] == Approx(odds[1] / sum));

  // Beside the current rudder-stall was expected to lose a nat, trim was fitted; a gain that is expected alone counts
  // as none. What was not screened is as likely to lack another effect as the likeliest that was.
  const gap::ScreenedGains screened{{1, {{"rudder-stall", -1.0}, {"wake", 2.0}, {"trim", 1.0}}}, {2, {{"wake", -3.0}}}};
  const double more = std::exp(gap::log_prior_odds_of_one(1));
  const double beside_current = (std::exp(-1.0) + 1.0) * more, beside_waves = std::exp(-3.0) * more;
  const double total = (odds[0] + odds[1] + odds[3]) * (1.0 + beside_current) + odds[2] * (1.0 + beside_waves);
  const std::vector<double> stated = gap::probabilities(all, gap::unseen_effects(all, screened, ship));
  for (std::size_t i = 0; i < all.size(); ++i) {
    CAPTURE(i);
    CHECK(stated[i] == Approx(odds[i] / total));
  }
}
