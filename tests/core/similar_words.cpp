#include "core/similar_words.hpp"

#include <catch2/catch.hpp>

using namespace leeway;

TEST_CASE("similar words: a letter left out, added, changed or two swapped lead back to the known word", "[core]") {
  const std::vector<std::string> known{"zigzag", "turning", "random", "berthing", "spiral"};
  for (const std::string word : {"zigzg", "zigzagg", "zigsag", "zizgag", "ZIGZAG"})
    CHECK(similar_words(word, known) == std::vector<std::string>{"zigzag"});
  CHECK(similar_words("turnign", known) == std::vector<std::string>{"turning"});
  CHECK(did_you_mean("spirl", known) == "; did you mean 'spiral'?");
}

TEST_CASE("similar words: abbreviations and parts are known, a word that is far off is not", "[core]") {
  const std::vector<std::string> ships{"esso-osaka-3m", "kvlcc2-full", "kvlcc2-l7", "vectwin-3m"};
  CHECK(similar_words("kvlcc2", ships) == std::vector<std::string>{"kvlcc2-full", "kvlcc2-l7"});
  CHECK(similar_words("osaka", ships) == std::vector<std::string>{"esso-osaka-3m"});
  CHECK(did_you_mean("kvlcc2", ships) == "; did you mean 'kvlcc2-full' or 'kvlcc2-l7'?");
  CHECK(similar_words("titanic", ships).empty());
  CHECK(did_you_mean("titanic", ships).empty());
  CHECK(similar_words("", ships).empty());
  CHECK(similar_words(std::string(100'000, 'x'), ships).empty());
}
