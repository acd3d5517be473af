#include "gap/result/inclusion.hpp"

#include <catch2/catch.hpp>

using namespace leeway::gap;

namespace {

Explained hypothesis(std::vector<std::string> effects, double probability) {
  Explained result;
  result.effects = std::move(effects);
  result.probability = probability;
  return result;
}

}  // namespace

TEST_CASE("inclusion: over all that was fitted, and what was screened beside it", "[gap]") {
  Explanation explanation;
  explanation.hypotheses = {hypothesis({}, 0.1), hypothesis({"fouling"}, 0.4), hypothesis({"fouling", "trim"}, 0.2)};
  explanation.hypotheses[0].unseen = {{"wake", 0.5}};
  explanation.hypotheses[1].unseen = {{"wake", 0.25}, {"bank", 0.125}};
  explanation.hypotheses[2].unseen = {{"trim", 0.5}};  // of another hypothesis: here it has the name already
  explanation.hypotheses[0].coefficients_off = {{"hull.N_r", 0.8}};
  const auto result = inclusion(explanation);
  // 0.1 x 1.5 + 0.4 x 1.375 + 0.2 x 1.5 = 1
  CHECK(result.at("fouling") == Approx(0.85));
  CHECK(result.at("trim") == Approx(0.3));
  CHECK(result.at("wake") == Approx(0.05 + 0.1));
  CHECK(result.at("bank") == Approx(0.05));
  CHECK(result.at("coefficient:hull.N_r") == Approx(0.12));
  CHECK(not_fitted(explanation) == Approx(0.3));

  SECTION("what simulated campaigns say was not fitted is missing to 1") {
    for (Explained& one : explanation.hypotheses) one.probability *= 0.7;
    CHECK(inclusion(explanation).at("fouling") == Approx(0.7 * 0.85));
    CHECK(not_fitted(explanation) == Approx(1.0 - 0.49));
  }
  SECTION("what has no fit of its own comes on top") {
    explanation.hypotheses.push_back(hypothesis({"unknown"}, 1.0));
    CHECK(inclusion(explanation).at("unknown") == Approx(0.5));
    CHECK(inclusion(explanation).at("fouling") == Approx(0.425));
  }
}

TEST_CASE("sets: the fewest that hold 95 %, of what was fitted and of what was screened beside it", "[gap]") {
  Explanation explanation;
  explanation.hypotheses = {hypothesis({"fouling"}, 0.6), hypothesis({}, 0.2), hypothesis({"wake"}, 0.04)};
  explanation.hypotheses[0].unseen = {{"wake", 0.2}};
  explanation.hypotheses[1].unseen = {{"bank", 0.1}};
  explanation.hypotheses[2].unseen = {{"fouling", 0.5}};  // the same set as fouling beside which wake acts
  const std::vector<ProbableSet> sets = probable_sets(explanation);
  REQUIRE(sets.size() == 4);  // not the bank, which is beyond 95 % and was not fitted
  CHECK(sets[0].names == std::vector<std::string>{"fouling"});
  CHECK(sets[1].names.empty());
  CHECK(sets[1].probability == Approx(0.2));
  CHECK(sets[2].names == std::vector<std::string>{"fouling", "wake"});
  CHECK(sets[2].probability == Approx(0.14));
  CHECK(sets[3].names == std::vector<std::string>{"wake"});
  CHECK(sets[3].is_credible);  // 0.94 before it
  SECTION("what was fitted is told, however little it holds") {
    const double probabilities[] = {0.65, 0.17, 0.02};
    for (std::size_t i = 0; i < 3; ++i) explanation.hypotheses[i].probability = probabilities[i];
    const std::vector<ProbableSet> more = probable_sets(explanation);
    REQUIRE(more.size() == 4);
    CHECK(!more[3].is_credible);
  }
}
