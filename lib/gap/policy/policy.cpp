#include "gap/policy/policy.hpp"

#include <bit>

#include "io/files.hpp"

namespace leeway::gap {

std::string policy_hash(const Policy& policy) {
  using Words = std::array<std::uint64_t, sizeof(Policy) / sizeof(std::uint64_t)>;
  static_assert(sizeof(Words) == sizeof(Policy), "a member of Policy has not eight bytes");
  std::string text;
  for (const std::uint64_t word : std::bit_cast<Words>(policy))  // the same on every machine
    for (int byte = 0; byte < 8; ++byte) text += static_cast<char>(word >> (8 * byte) & 0xff);
  return io::sha256(text);
}

}  // namespace leeway::gap
