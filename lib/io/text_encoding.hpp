#pragma once

#include <string>
#include <string_view>

namespace leeway::io {

/// Whether these bytes are UTF-8 (RFC 3629): no overlong forms, no surrogates, nothing beyond U+10FFFF.
bool is_utf8(std::string_view bytes);

/// Whether a file that begins with these two bytes is UTF-16: by its mark, or a letter beside a zero.
bool begins_as_utf16(std::string_view bytes);

/// Latin-1 (ISO 8859-1) as UTF-8.
std::string utf8_of_latin1(std::string_view bytes);

}  // namespace leeway::io
