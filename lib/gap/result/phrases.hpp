#pragma once

#include <string>
#include <vector>

#include "gap/result/explanation.hpp"

namespace leeway::gap {

/// An effect with its numbers, rounded to their errors, in the field's words: "a current of 0.10 m/s towards 90 deg".
/// Its name, where the catalogue does not hold it. Where it differs between recordings, of each of them in turn.
std::string phrase(const std::string& effect, const std::vector<ExplainedParameter>& parameters);

/// What an effect is, with its numbers, and what that means; where a coefficient may do the same, both readings, by the
/// sign of the change.
std::string sentence_of(const std::string& effect, const std::vector<ExplainedParameter>& parameters);

/// Recordings in which an effect has values of their own.
std::vector<std::string> recordings_with(const std::string& effect, const std::vector<ExplainedParameter>& parameters);

/// With a capital letter.
std::string capitalized(std::string text);

}  // namespace leeway::gap
