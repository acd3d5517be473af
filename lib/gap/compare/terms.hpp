#pragma once

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

}  // namespace leeway::gap
