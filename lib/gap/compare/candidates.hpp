#pragma once

#include <string>
#include <vector>

#include "gap/compare/fitted.hpp"

/// Candidates for a fit with one effect more.
namespace leeway::gap {

/// An effect everywhere, and where it may be another one in each of a few recordings, in each; none where the ship
/// lacks what it needs. Of a current that varies: its course.
std::vector<Candidate> candidates_with(const Campaign& campaign, const std::string& effect,
                                       const FreeEffect::Choice& chosen);

/// What is tried of the candidates [begin, end), which belong to one effect: each that acts everywhere, and of those
/// that act in one recording alone one of each, which together are likeliest, and the same with the opposite direction
/// in one recording.
std::vector<std::vector<std::size_t>> sets_of(const EffectScreen& screen, std::size_t begin, std::size_t end,
                                              bool is_of_one_recording);

/// Candidates beside a fit, from its own coefficients, as uncertain as any common scale makes them.
EffectScreen screen_of(const Campaign& campaign, const Fitted& fitted, std::vector<Candidate> candidates,
                       const ScreenOptions& options);

/// The largest expected gain first.
void sort(std::vector<Start>& starts);

}  // namespace leeway::gap
