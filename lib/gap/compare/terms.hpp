#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "gap/compare/fitted.hpp"

/// Terms for what the catalogue does not hold.
namespace leeway::gap {

/// The effect that is made of terms, and says that the catalogue does not hold what acts: `unknown`.
std::string name_of_terms();
/// Whether it is among these names.
bool has_terms(const std::vector<std::string>& names);

/// The few terms of `unknown`, at most three, that best explain what is left beside a fit, by one linear
/// step: all sets among the leading ones are compared. None where no set is worth its own number of ways.
std::vector<Start> terms_beside(const Campaign& campaign, const Fitted& fitted, std::size_t jobs);

/// What terms gain beside effects, of these fits, less what the choice among terms costs [nats]; nothing where either
/// was not fitted.
std::optional<double> gain_of_terms(const std::vector<Fitted>& fits, const std::set<std::string>& beside);

}  // namespace leeway::gap
