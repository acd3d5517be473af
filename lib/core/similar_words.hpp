#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace leeway {

/// The known words that a misspelled one may have been meant to be, the likeliest first, three at most: those that it
/// abbreviates, else those that few edits lead to (a letter left out, added, changed, or two swapped; at most a third
/// of the longer word), else those that hold it. Upper and lower case count as the same.
std::vector<std::string> similar_words(std::string_view word, const std::vector<std::string>& known);

/// "; did you mean 'zigzag'?", for the end of a message; empty where no word is near.
std::string did_you_mean(std::string_view word, const std::vector<std::string>& known);

}  // namespace leeway
