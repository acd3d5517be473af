#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "io/files.hpp"

/// What the files of a model directory share: ensemble.json and those of members.
namespace leeway::ensemble {

/// Weights are single precision: this JSON prints and reads them as such, with the fewest digits that keep the bits.
using FloatJson =
    nlohmann::basic_json<nlohmann::ordered_map, std::vector, std::string, bool, std::int64_t, std::uint64_t, float>;

/// SHA-256 of the text without white space, whatever stands in a recording's name: the same for what was written and
/// what is read back.
template <typename AnyJson>
std::string hash_of(const AnyJson& json) {
  return io::sha256(json.dump(-1, ' ', false, AnyJson::error_handler_t::replace));
}

}  // namespace leeway::ensemble
