#pragma once

#include <map>
#include <string>
#include <vector>

#include "gap/compare/fitted.hpp"

/// Evidence and what was believed before make odds and probabilities.
namespace leeway::gap {

/// What each effect that was screened beside a fit would gain, by the place of the fit [nats].
using ScreenedGains = std::map<std::size_t, std::map<std::string, double>>;

/// ln of the number of sets of `count` things out of `of`.
double log_ways(std::size_t of, std::size_t count);

/// ln of the prior odds of one effect of the catalogue against nothing missing.
double log_prior_odds_of_one();

/// ln of the posterior odds of one of all against nothing missing, which is the first. Correlation between blocks takes
/// from all evidence what it takes from that of the likeliest.
double log_odds(const std::vector<Fitted>& all, std::size_t i);

/// Of all that were fitted; between those that lack something tempered. What is missing to 1 is shared by the single
/// effects that were screened alone.
std::vector<double> probabilities(const std::vector<Fitted>& all, const ScreenedGains& screened, const Ship& ship);

}  // namespace leeway::gap
