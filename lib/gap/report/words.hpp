#pragma once

#include <string>
#include <string_view>

#include "gap/result/explanation.hpp"
#include "gap/result/numbers.hpp"

/// The words and numbers in which findings are reported, the same in JSON, summary and page.
namespace leeway::gap {

/// "mismatch", "no-mismatch", "undecided".
std::string_view word(Verdict verdict);

/// The hypothesis that is claimed; nullptr: none.
const Explained* chosen_of(const Explanation& explanation);

/// Whether one of these effects has other values in each recording.
bool differ_by_recording(const std::vector<std::string>& effects, const Explanation& explanation);
/// On what depends what the catalogue does not hold; null where that is not claimed.
const LatentForce* unknown_kind(const Explanation& explanation);

/// The cause of an interval in which an ensemble was not trained.
inline constexpr const char* kUntrained = "untrained region";

/// The verdict as one sentence.
std::string headline(const Findings& findings);

/// What was chosen, and whether it shows on what was held out, as one or two sentences.
std::string headline(const Explanation& explanation);

/// By what errors of free runs over what was held out fall: "3 to 6 times", "up to 40 times", "by 20 to 40 %"; empty
/// where they do not.
std::string fall_of_errors(const BeforeAfter& fit);

/// "predicts unseen data better by 43 +- 12 (log-likelihood)".
std::string gain_words(double gain, double sd);

/// "fixed to the earth" for the frame "earth"; the name itself where it is not known.
std::string frame_meaning(const std::string& name);

}  // namespace leeway::gap
