#pragma once

#include <map>
#include <string>
#include <vector>

#include "gap/compare/fitted.hpp"
#include "gap/result/latent_force.hpp"

/// Evidence and what was believed before make odds and probabilities.
namespace leeway::gap {

/// What each effect that was screened beside a fit would gain, by the place of the fit [nats].
using ScreenedGains = std::map<std::size_t, std::map<std::string, double>>;

/// ln of the number of sets of `count` things out of `of`.
double log_ways(std::size_t of, std::size_t count);

/// ln of the prior odds of one effect of the catalogue more against none beside so many.
double log_prior_odds_of_one(std::size_t beside = 0);

/// ln of what was believed of a hypothesis before.
double log_prior(const Hypothesis& hypothesis);

/// ln of the posterior odds of one of all against nothing missing, which is the first. Correlation between blocks takes
/// from all evidence what it takes from that of the likeliest, or of its own, if that is more.
double log_odds(const std::vector<Fitted>& all, std::size_t i);

/// ln of how many times likelier the recordings are with a force that the catalogue does not hold than without, where
/// all its kinds are equally likely; the likeliest kind first.
double log_evidence_of(const std::vector<LatentForce>& kinds);
/// The posterior odds of one, beside so many effects; all kinds together are believed like one effect.
double log_odds_of(const std::vector<LatentForce>& kinds, std::size_t beside = 0);

/// The least odds of nothing against something that a p-value leaves: -e p ln p (Sellke, Bayarri & Berger 2001, The
/// American Statistician 55, 62-71).
double least_odds_of_nothing(double p_value);

/// Effects of which too little was expected to be fitted beside a hypothesis: the odds of each acting beside it,
/// against the hypothesis alone.
using Unseen = std::map<std::string, double>;
double sum_of(const Unseen& unseen);

/// Of all that were fitted. Beside one that was not screened another effect that does not show is as likely as beside
/// the likeliest that was.
std::vector<Unseen> unseen_effects(const std::vector<Fitted>& all, const ScreenedGains& screened, const Ship& ship);

/// Of all that were fitted, each alone; what is missing to 1 is that of its unseen effects.
std::vector<double> probabilities(const std::vector<Fitted>& all, const std::vector<Unseen>& unseen);

}  // namespace leeway::gap
