#pragma once

#include <string>
#include <vector>

namespace leeway {

/// The catalogue of effects as text for a terminal, or one effect of it. Throws UsageError for an unknown name.
std::string catalogue_text(const std::string& effect = "");

/// The names of all effects, in the catalogue's order.
std::vector<std::string> effect_names();

/// docs/effects.md: the catalogue as a page.
std::string catalogue_page();

}  // namespace leeway
