#include "io/text_encoding.hpp"

namespace leeway::io {

bool is_utf8(std::string_view bytes) {
  for (std::size_t i = 0; i < bytes.size();) {
    const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(bytes[k]); };
    const unsigned first = byte(i);
    const std::size_t length = first < 0x80   ? 1
                               : first < 0xC2 ? 0
                               : first < 0xE0 ? 2
                               : first < 0xF0 ? 3
                               : first < 0xF5 ? 4
                                              : 0;
    if (length == 0 || i + length > bytes.size()) return false;
    for (std::size_t k = 1; k < length; ++k)
      if ((byte(i + k) & 0xC0U) != 0x80U) return false;
    const unsigned second = length > 1 ? byte(i + 1) : 0;
    const bool is_overlong = (first == 0xE0 && second < 0xA0) || (first == 0xF0 && second < 0x90);
    const bool is_no_character = (first == 0xED && second >= 0xA0) || (first == 0xF4 && second >= 0x90);
    if (is_overlong || is_no_character) return false;
    i += length;
  }
  return true;
}

bool begins_as_utf16(std::string_view bytes) {
  if (bytes.size() < 2) return false;
  const std::string_view first = bytes.substr(0, 2);
  const auto is_letter = [](char c) { return c >= ' ' && c <= '~'; };
  return first == "\xFF\xFE" || first == "\xFE\xFF" || (is_letter(first[0]) && first[1] == '\0') ||
         (first[0] == '\0' && is_letter(first[1]));
}

std::string utf8_of_latin1(std::string_view bytes) {
  std::string text;
  for (const char c : bytes) {
    const auto code = static_cast<unsigned char>(c);
    if (code < 0x80) {
      text += c;
    } else {
      text += static_cast<char>(0xC0U | (code >> 6U));
      text += static_cast<char>(0x80U | (code & 0x3FU));
    }
  }
  return text;
}

}  // namespace leeway::io
