#pragma once

#include <string>
#include <string_view>

#include "io/json.hpp"

/// Files that say beside them what made them: CSV has no place for it.
namespace leeway::io {

/// FILE.provenance.json; empty for a stream, a device, and where no output is wanted.
std::string provenance_path(const std::string& file);

/// Writes a text as write_text(), and its provenance with the SHA-256 of the text beside it. The provenance of an
/// earlier file goes before that, and comes last: where it lies, the text is the one that it tells of.
void write_described(const std::string& file, std::string_view text, const Json& provenance);

/// remove_output() of a file and of its provenance.
void remove_described(const std::string& file);

}  // namespace leeway::io
