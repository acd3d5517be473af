#include "gap/decide/decide.hpp"

#include <algorithm>
#include <functional>
#include <optional>
#include <string>

#include <catch2/catch.hpp>

using namespace leeway;
using gap::Decision;
using gap::Found;
using gap::HypothesesFound;
using gap::Reason;
using gap::Rivals;
using gap::Verdict;

namespace {

// A campaign of 4000 measurements in which nothing is seen.
Found nothing_seen() {
  Found found;
  found.tests.samples = 4000;
  found.tests.effects_tested = 20;
  found.tests.error_share = 0.2;
  return found;
}

// p-values of a test that is this many times the rate, once all families share it.
double p_of(double times_rate, const Found& found) {
  return times_rate * found.false_alarm / gap::kPolicy.decide.families;
}

// Something is named, with odds that nothing missing has in one of a million campaigns.
HypothesesFound named() {
  HypothesesFound h;
  h.is_named = true;
  h.chance_of_best = 1e-6;
  h.log_odds_of_chosen = 12.0;
  h.error_share = 0.3;
  h.taken_share = 0.8;
  return h;
}

}  // namespace

TEST_CASE("decide: each reason of the tests is reached, and only by what it says", "[gap][decide]") {
  struct Row {
    const char* what;
    std::function<void(Found&)> change;
    Verdict verdict;
    Reason reason;
  };
  const Row rows[] = {
      {"nothing", [](Found&) {}, Verdict::no_mismatch, Reason::nothing_left},
      {"no convergence", [](Found& f) { f.tests.converged = false; }, Verdict::undecided, Reason::not_converged},
      {"no noise and a small error",
       [](Found& f) {
         f.tests.is_noise_free = true;
         f.tests.error_share = 0.04;
         f.tests.effects_p = p_of(1e-3, f);
       },
       Verdict::undecided, Reason::error_of_inputs},
      {"an interval",
       [](Found& f) {
         f.tests.intervals_p = p_of(0.5, f);
         f.tests.effects_p = p_of(0.6, f);
       },
       Verdict::mismatch, Reason::interval},
      {"an effect that predicts better",
       [](Found& f) {
         f.tests.effects_p = p_of(0.5, f);
         f.tests.heldout_gain = 2.1;
         f.tests.heldout_gain_sd = 1.0;
       },
       Verdict::mismatch, Reason::effect},
      {"an effect that predicts a little better, but is certain",
       [](Found& f) {
         f.tests.effects_p = p_of(0.5 * f.false_alarm, f);
         f.tests.heldout_gain = 1.1;
         f.tests.heldout_gain_sd = 1.0;
       },
       Verdict::mismatch, Reason::effect},
      {"an effect that does not predict better",
       [](Found& f) {
         f.tests.effects_p = p_of(0.5, f);
         f.tests.heldout_gain = 1.9;
         f.tests.heldout_gain_sd = 1.0;
       },
       Verdict::undecided, Reason::effect_not_heldout},
      {"no noise and a small error, close to the rate",
       [](Found& f) {
         f.tests.is_noise_free = true;
         f.tests.error_share = 0.04;
         f.tests.intervals_p = p_of(4.9, f);
       },
       Verdict::undecided, Reason::error_of_inputs},
      {"no noise, but more than inputs can make",
       [](Found& f) {
         f.tests.is_noise_free = true;
         f.tests.error_share = 0.05;
         f.tests.intervals_p = p_of(0.5, f);
       },
       Verdict::mismatch, Reason::interval},
      {"close to the rate", [](Found& f) { f.tests.intervals_p = p_of(4.9, f); }, Verdict::undecided,
       Reason::close_to_rate},
      {"small intervals", [](Found& f) { f.tests.small_intervals = 1; }, Verdict::undecided, Reason::small_intervals},
      {"untrained intervals", [](Found& f) { f.tests.untrained_intervals = 2; }, Verdict::undecided,
       Reason::untrained_intervals},
      {"few samples", [](Found& f) { f.tests.samples = 299; }, Verdict::undecided, Reason::too_few_samples},
      {"no effect excited", [](Found& f) { f.tests.effects_tested = 0; }, Verdict::undecided, Reason::nothing_excited},
      {"large error: what little shows is no evidence", [](Found& f) { f.tests.error_share = 1.5; },
       Verdict::no_mismatch, Reason::nothing_left},
      {"far parameters", [](Found& f) { f.tests.far_parameters = 4; }, Verdict::undecided, Reason::far_parameters},
      {"two far parameters and a large error",
       [](Found& f) {
         f.tests.far_parameters = 2;
         f.tests.error_share = 0.6;
       },
       Verdict::undecided, Reason::far_parameters},
      {"two far parameters and an error that only just is not large",
       [](Found& f) {
         f.tests.far_parameters = 2;
         f.tests.error_share = 0.5;
       },
       Verdict::no_mismatch, Reason::nothing_left},
      {"two far parameters alone", [](Found& f) { f.tests.far_parameters = 2; }, Verdict::no_mismatch,
       Reason::nothing_left},
  };
  for (const Row& row : rows) {
    CAPTURE(row.what);
    Found found = nothing_seen();
    row.change(found);
    const Decision decision = gap::decide(found);
    CHECK(decision.verdict == row.verdict);
    CHECK(decision.reason == row.reason);
  }
}

TEST_CASE("decide: p-values of all families share the rate, and never exceed one", "[gap][decide]") {
  Found found = nothing_seen();
  found.tests.effects_p = 0.004;
  found.tests.intervals_p = 0.03;
  CHECK(gap::decide(found).p_value == Approx(0.004 * 3.0).epsilon(1e-12));
  found.tests.effects_p = 0.9;
  found.tests.intervals_p = 0.8;
  CHECK(gap::decide(found).p_value == 1.0);
}

TEST_CASE("decide: what is claimed of hypotheses", "[gap][decide]") {
  struct Row {
    const char* what;
    std::function<void(Found&, HypothesesFound&)> change;
    Verdict verdict;
    bool names, unknown, complete;
  };
  const auto seen = [](Found& f) { f.tests.intervals_p = p_of(1e-6, f); };  // as surely as can be
  const Row rows[] = {
      {"a name, nothing left", [](Found&, HypothesesFound&) {}, Verdict::mismatch, true, false, true},
      {"a name, and something left", [](Found&, HypothesesFound& h) { h.left_p = 1e-9; }, Verdict::mismatch, true, true,
       false},
      {"a name, and something left that is not certain beside it", [](Found&, HypothesesFound& h) { h.left_p = 1e-6; },
       Verdict::mismatch, true, false, false},
      {"a name, and something negligible left",
       [](Found&, HypothesesFound& h) {
         h.left_p = 1e-9;
         h.is_negligible = true;
       },
       Verdict::mismatch, true, false, true},
      {"a name, and something left that is as small as errors of forms",
       [](Found&, HypothesesFound& h) {
         h.left_p = 1e-9;
         h.error_share = 0.05;
       },
       Verdict::mismatch, true, false, false},
      {"a weak name that takes little away, much left: unknown alone",
       [](Found&, HypothesesFound& h) {
         h.left_p = 1e-9;
         h.taken_share = 0.2;
         h.log_odds_of_chosen = 5.0;
       },
       Verdict::mismatch, false, true, false},
      {"a weak name that takes little away, little left: undecided",
       [](Found&, HypothesesFound& h) {
         h.left_p = 1e-3;
         h.taken_share = 0.2;
         h.log_odds_of_chosen = 5.0;
       },
       Verdict::undecided, false, false, false},
      {"strong odds for a name that takes little away: named, and unknown beside it",
       [](Found&, HypothesesFound& h) {
         h.left_p = 1e-9;
         h.taken_share = 0.2;
         h.log_odds_of_chosen = 5.8;
       },
       Verdict::mismatch, true, true, false},
      {"terms of the unknown, and more left: said once",
       [](Found&, HypothesesFound& h) {
         h.left_p = 1e-9;
         h.has_terms = true;
       },
       Verdict::mismatch, true, false, false},
      {"no name, surely seen, large: unknown",
       [&](Found& f, HypothesesFound& h) {
         seen(f);
         h.is_named = false;
         h.left_p = 1e-8;
       },
       Verdict::mismatch, false, true, false},
      {"no name, surely seen, but small: undecided",
       [&](Found& f, HypothesesFound& h) {
         seen(f);
         h.is_named = false;
         h.left_p = 1e-8;
         h.error_share = 0.05;
       },
       Verdict::undecided, false, false, true},
      {"no name, but what it depends on: unknown, however small",
       [](Found&, HypothesesFound& h) {
         h.is_named = false;
         h.is_latent = true;
         h.chance_of_latent = 1e-5;
         h.error_share = 0.02;
       },
       Verdict::mismatch, false, true, false},
      {"a name, and what acts beside it, known by what it depends on: both",
       [](Found&, HypothesesFound& h) { h.is_latent = true; }, Verdict::mismatch, true, true, false},
      {"no name, barely seen: undecided",
       [](Found& f, HypothesesFound& h) {
         f.tests.intervals_p = p_of(0.5, f);
         h.is_named = false;
         h.left_p = 0.005;
       },
       Verdict::undecided, false, false, true},
      {"no name, surely seen and large, but little left once effects are fitted: undecided",
       [&](Found& f, HypothesesFound& h) {
         seen(f);
         h.is_named = false;
         h.left_p = 0.005;
       },
       Verdict::undecided, false, false, false},
      {"no name, and the tests cannot tell: undecided",
       [](Found& f, HypothesesFound& h) {
         f.tests.converged = false;
         h.is_named = false;
       },
       Verdict::undecided, false, false, true},
      {"no name, and only the tests for effects surely see something: undecided",
       [](Found& f, HypothesesFound& h) {
         f.tests.effects_p = p_of(1e-6, f);
         f.tests.heldout_gain = 10.0;
         h.is_named = false;
         h.left_p = 1e-8;
       },
       Verdict::undecided, false, false, true},
      {"no name, and tests that are close to the rate: no mismatch, since odds judge",
       [](Found& f, HypothesesFound& h) {
         f.tests.intervals_p = p_of(1.1, f);
         h.is_named = false;
       },
       Verdict::no_mismatch, false, false, true},
      {"no name, and a file that is far off: no mismatch, and the file is judged",
       [](Found& f, HypothesesFound& h) {
         f.tests.far_parameters = 4;
         h.is_named = false;
       },
       Verdict::no_mismatch, false, false, true},
      {"no name and nothing seen, but something is likelier than not: undecided",
       [](Found&, HypothesesFound& h) {
         h.is_named = false;
         h.is_likelier_than_not = true;
       },
       Verdict::undecided, false, false, true},
  };
  for (const Row& row : rows) {
    CAPTURE(row.what);
    Found found = nothing_seen();
    HypothesesFound hypotheses = named();
    row.change(found, hypotheses);
    found.hypotheses = hypotheses;
    const Decision decision = gap::decide(found);
    CHECK(decision.verdict == row.verdict);
    CHECK(decision.claims_names == row.names);
    CHECK(decision.claims_unknown == row.unknown);
    CHECK(decision.is_complete == row.complete);
  }
}

TEST_CASE("decide: why hypotheses leave it open", "[gap][decide]") {
  Found found = nothing_seen();
  found.hypotheses = named();
  found.hypotheses->is_named = false;
  CHECK(gap::decide(found).reason == Reason::nothing_left);
  found.hypotheses->is_likelier_than_not = true;
  found.hypotheses->chance_of_best = 0.2;
  CHECK(gap::decide(found).reason == Reason::likelier_than_not);
  found.hypotheses->chance_of_best = 1e-4;  // rare, but not claimed
  CHECK(gap::decide(found).reason == Reason::likelier_than_not);
  found.hypotheses->best_is_likelier_than_not = true;
  CHECK(gap::decide(found).reason == Reason::likelier_but_not_told_from_none);
  found.hypotheses->best_is_significant = true;
  CHECK(gap::decide(found).reason == Reason::likelier_but_not_heldout);
  found.tests.intervals_p = p_of(0.5, found);
  CHECK(gap::decide(found).reason == Reason::odds_not_rare);
}

TEST_CASE("decide: a fault of a sensor is a mismatch, whatever is found of the forces", "[gap][decide]") {
  for (const bool is_named : {true, false}) {
    Found found = nothing_seen();
    found.tests.effects_p = p_of(40.0, found);
    found.hypotheses = named();
    found.hypotheses->is_named = is_named;
    if (!is_named) found.hypotheses->chance_of_best = 1.0;
    const Decision without = gap::decide(found);
    found.sensors = {1, 3e-4};
    const Decision with = gap::decide(found);
    CAPTURE(is_named);
    CHECK(without.verdict == (is_named ? Verdict::mismatch : Verdict::no_mismatch));
    CHECK(with.verdict == Verdict::mismatch);
    CHECK(with.claims_sensors);
    CHECK_FALSE(without.claims_sensors);
    CHECK(with.p_value == std::min(without.p_value, 3e-4));
    // What is claimed of the forces stays.
    CHECK(with.claims_names == without.claims_names);
    CHECK(with.claims_unknown == without.claims_unknown);
    CHECK(with.is_complete == without.is_complete);
  }
  Found found = nothing_seen();
  found.tests.samples = 299;  // too few for a verdict of the forces
  found.sensors = {2, 0.0};   // one of them a convention
  CHECK(gap::decide(found).verdict == Verdict::mismatch);
  CHECK(gap::decide(found).p_value == 0.0);
}

TEST_CASE("decide: a name's p-value is how often nothing missing has such odds, for all families", "[gap][decide]") {
  Found found = nothing_seen();
  found.hypotheses = named();
  CHECK(gap::decide(found).p_value == Approx(gap::kPolicy.decide.families * 1e-6).epsilon(1e-12));
}

TEST_CASE("decide: thresholds come from the policy that is given", "[gap][decide]") {
  Found found = nothing_seen();
  found.tests.samples = 250;
  CHECK(gap::decide(found).reason == Reason::too_few_samples);
  gap::Policy policy;
  policy.decide.fewest_samples = 200;
  CHECK(gap::decide(found, policy).reason == Reason::nothing_left);
}

TEST_CASE("decide: when one hypothesis holds against another", "[gap][decide]") {
  struct Row {
    const char* what;
    Rivals rivals;
    bool holds;
  };
  const Row rows[] = {
      {"less likely", {-0.1, true, false, true, 9.0, 1.0, true}, false},
      {"an effect that is nothing", {9.0, false, false, true, 9.0, 1.0, true}, false},
      {"rare odds against nothing, predicting as well", {3.0, true, false, true, -1.0, 1.0, false}, true},
      {"rare odds against nothing, predicting worse", {6.0, true, false, true, -2.1, 1.0, false}, false},
      {"rare odds against nothing, but terms alone", {6.0, true, true, true, -1.0, 1.0, false}, false},
      {"terms with strong odds need one standard error", {6.0, true, true, true, 1.1, 1.0, false}, true},
      {"strong odds against another need a gain", {6.0, true, false, false, 0.1, 1.0, false}, true},
      {"strong odds against another, no gain", {6.0, true, false, false, -0.1, 1.0, false}, false},
      {"terms with strong odds against another need one standard error",
       {6.0, true, true, false, 0.9, 1.0, false},
       false},
      {"weak odds need two standard errors", {3.0, true, false, false, 1.9, 1.0, false}, false},
      {"weak odds with two standard errors", {3.0, true, false, false, 2.1, 1.0, false}, true},
      {"weak odds, but something surely is left: one is enough", {3.0, true, false, false, 1.1, 1.0, true}, true},
      {"likelier than not, predicting worse by less", {3.0, true, false, false, -2.9, 0.1, false, true}, true},
      {"likelier than not, predicting worse by more", {3.0, true, false, false, -3.1, 1.0, false, true}, false},
      {"likelier than not, but terms alone", {3.0, true, true, false, 1.9, 1.0, false, true}, false},
  };
  for (const Row& row : rows) {
    CAPTURE(row.what);
    CHECK(gap::holds(row.rivals) == row.holds);
  }
}

TEST_CASE("decide: which hypotheses may be claimed", "[gap][decide]") {
  const double rate = 0.01;
  CHECK(gap::may_be_claimed({false, 0.1, 0.01, 1.0}, rate));  // a name always
  CHECK(gap::may_be_claimed({true, 3.0, 0.1, 9e-5}, rate));   // terms where the tests are sure
  CHECK(gap::may_be_claimed({true, 10.1, 0.1, 1.0}, rate));   // or the odds
  CHECK_FALSE(gap::may_be_claimed({true, 9.9, 0.1, 2e-4}, rate));
  CHECK_FALSE(gap::may_be_claimed({true, 10.1, 0.09, 9e-5}, rate));  // not what errors of forms make
}

TEST_CASE("decide: when the likeliest is certain enough to be claimed", "[gap][decide]") {
  struct Row {
    const char* what;
    gap::Likeliest best;
    bool is_certain;
  };
  const Row rows[] = {
      {"rare odds", {0.6, 0.1, 0.009}, true},
      {"odds that are not so rare", {0.6, 0.1, 0.011}, false},
      {"terms that may not be claimed are likelier", {0.4, 0.5, 0.009}, false},
      {"they are as likely", {0.45, 0.45, 0.009}, true},
  };
  for (const Row& row : rows) {
    CAPTURE(row.what);
    CHECK(gap::is_certain(row.best, 0.01) == row.is_certain);
  }
}

TEST_CASE("decide: what has no name is claimed by what it depends on", "[gap][decide]") {
  gap::LatentFound latent{24.0, 20.0, 5.0, 0.2, {}, 0.0};
  CHECK_FALSE(gap::holds_beside(latent, 0.01));
  const double needed = std::log(gap::kPolicy.decide.families / 0.01);  // Markov's inequality for all tests
  latent.log_odds_with_chosen = 20.0 + needed - 0.1;
  CHECK_FALSE(gap::holds_beside(latent, 0.01));
  latent.log_odds_with_chosen = 20.0 + needed + 0.1;
  CHECK(gap::holds_beside(latent, 0.01));
  CHECK(gap::is_claimed(latent, 0.01));
  latent.log_odds_of_names = 21.0;  // a name is likelier
  CHECK(!gap::is_claimed(latent, 0.01));
  CHECK(gap::is_rare(latent, 0.01));
  latent.log_odds_of_names = -5.0;
  latent.log_evidence = needed - 0.1;
  CHECK(!gap::is_claimed(latent, 0.01));
  latent.log_evidence += 0.2;
  CHECK(gap::is_claimed(latent, 0.01));
  latent.error_share = 0.05;  // other forms of the ship's own forces leave as much
  CHECK(!gap::is_claimed(latent, 0.01));
  latent.error_share = 0.2;
  latent.log_odds = -0.1;  // rare evidence of what is hardly believed
  CHECK(gap::is_rare(latent, 0.01));
  CHECK(!gap::is_claimed(latent, 0.01));
  latent.log_odds = 20.0;
  latent.tests.is_noise_free = true;  // what inputs do between the samples makes as much
  latent.tests.error_share = 0.01;
  CHECK(!gap::is_claimed(latent, 0.01));
}

TEST_CASE("decide: when what is left beside what is named is worth a word, and when terms are asked for",
          "[gap][decide]") {
  const double rate = 0.01;
  struct Row {
    const char* what;
    gap::LeftBeside left;
    bool is_negligible;
  };
  const Row rows[] = {
      {"much left", {1e-9, 100.0, 0.3, std::nullopt}, false},
      {"little beside a strong name: -ln p is less than a twentieth of its evidence",
       {0.01, 100.0, 0.3, std::nullopt},
       true},
      {"likelier with one effect more, and no sure sign", {2e-4, 10.0, 0.3, 0.5}, true},
      {"the same with a sure sign", {9e-5, 10.0, 0.3, 0.5}, false},
      {"less likely with one effect more", {2e-4, 10.0, 0.3, -0.5}, false},
  };
  for (const Row& row : rows) {
    CAPTURE(row.what);
    CHECK(gap::is_negligible(row.left, rate) == row.is_negligible);
  }

  CHECK(gap::may_have_terms({9e-9, 0.0, 0.1, std::nullopt}, false, rate));
  CHECK_FALSE(gap::may_have_terms({9e-9, 0.0, 0.1, std::nullopt}, true, rate));
  CHECK_FALSE(gap::may_have_terms({2e-8, 0.0, 0.1, std::nullopt}, false, rate));
  CHECK_FALSE(gap::may_have_terms({9e-9, 0.0, 0.09, std::nullopt}, false, rate));
}
