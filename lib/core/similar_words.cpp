#include "core/similar_words.hpp"

#include <algorithm>
#include <cctype>
#include <cstddef>

#include <fmt/format.h>

namespace leeway {
namespace {

constexpr std::size_t kMostWords = 3, kShortestPart = 3;

std::string lower_case(std::string_view word) {
  std::string result(word);
  for (char& c : result) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return result;
}

// Letters left out, added, changed, or swapped with their neighbor.
std::size_t edits_between(const std::string& a, const std::string& b) {
  std::vector<std::size_t> two_before, before(b.size() + 1), now(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) before[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    now[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t changed = a[i - 1] == b[j - 1] ? 0 : 1;
      now[j] = std::min({before[j] + 1, now[j - 1] + 1, before[j - 1] + changed});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        now[j] = std::min(now[j], two_before[j - 2] + 1);
    }
    two_before = before;
    before = now;
  }
  return before[b.size()];
}

}  // namespace

std::vector<std::string> similar_words(std::string_view word, const std::vector<std::string>& known) {
  const std::string wanted = lower_case(word);
  constexpr std::size_t kLongest = 100;  // nothing that is meant as a name is longer
  if (wanted.empty() || wanted.size() > kLongest) return {};
  std::vector<std::string> begin_with, hold, near;
  std::size_t fewest = kLongest;
  for (const std::string& candidate : known) {
    const std::string other = lower_case(candidate);
    if (wanted.size() >= kShortestPart && other.starts_with(wanted)) begin_with.push_back(candidate);
    if (wanted.size() >= kShortestPart && other.find(wanted) != std::string::npos) hold.push_back(candidate);
    const std::size_t edits = edits_between(wanted, other);
    if (edits > std::max<std::size_t>(1, std::max(wanted.size(), other.size()) / 3) || edits > fewest) continue;
    if (edits < fewest) near.clear();
    fewest = edits;
    near.push_back(candidate);
  }
  std::vector<std::string>& result = !begin_with.empty() ? begin_with : !near.empty() ? near : hold;
  if (result.size() > kMostWords) result.resize(kMostWords);
  return result;
}

std::string did_you_mean(std::string_view word, const std::vector<std::string>& known) {
  std::string text;
  for (const std::string& candidate : similar_words(word, known))
    text += fmt::format("{}'{}'", text.empty() ? "; did you mean " : " or ", candidate);
  return text.empty() ? text : text + '?';
}

}  // namespace leeway
