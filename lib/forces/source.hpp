#pragma once

#include "io/json.hpp"

namespace leeway {

/// Each object of a ship's JSON says where its numbers come from. Throws InputError where it does not.
inline void require_source(const io::JsonObject& json) {
  if (json.text("source").empty()) json.fail("source", "expected where the numbers come from, got nothing");
}

}  // namespace leeway
