// libFuzzer's entry. The environment variable LEEWAY_READER names the reader.

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <string>

#include <nlohmann/json.hpp>

#include "fuzz/readers.hpp"

using namespace leeway;

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

namespace {

const test::Reader& chosen_reader() {
  static const test::Reader reader = [] {
    const char* name = std::getenv("LEEWAY_READER");
    for (const test::Reader& known : test::readers())
      if (name != nullptr && name == std::string_view(known.name)) return known;
    std::fprintf(stderr, "LEEWAY_READER: expected one of:");
    for (const test::Reader& known : test::readers()) std::fprintf(stderr, " %s", known.name);
    std::fprintf(stderr, "\n");
    std::exit(2);
  }();
  return reader;
}

// A value somewhere in a JSON text becomes an extreme one, goes, or takes the place of another.
std::string mutated_json(const std::string& text, std::minstd_rand& random) {
  io::Json json = io::Json::parse(text, nullptr, false);
  if (json.is_discarded() || !json.is_structured() || json.empty()) return "";
  io::Json* parent = &json;
  for (;;) {  // down to an object or array that holds the value
    auto child = parent->begin();
    std::advance(child, random() % parent->size());
    const bool is_deeper = child->is_structured() && !child->empty() && random() % 4 != 0;
    if (!is_deeper) {
      static const io::Json kExtremes = io::Json::parse(
          R"([0, -0.0, 1, -1, 1.5, 5e-324, 1e-308, 1e-9, 1e9, 1e308, -1e308, 2147483648, 9223372036854775807,
              18446744073709551615, true, null, "", "-", "..", "nan", "0", [], {}, [[]], [0, 0, 0], 30, 100])");
      const auto kind = random() % 8;
      if (kind == 0)
        parent->erase(child);
      else if (kind == 1)
        *child = json.flatten().begin().value();
      else
        *child = kExtremes[random() % kExtremes.size()];
      return json.dump(-1, ' ', false, io::Json::error_handler_t::replace);
    }
    parent = &*child;
  }
}

}  // namespace

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned int seed) {
  std::minstd_rand random(seed);
  if (size > 0 && (data[0] == '{' || data[0] == '[') && random() % 2 == 0) {
    const std::string mutated = mutated_json({reinterpret_cast<const char*>(data), size}, random);
    if (!mutated.empty() && mutated.size() <= max_size) {
      std::copy(mutated.begin(), mutated.end(), data);
      return mutated.size();
    }
  }
  return LLVMFuzzerMutate(data, size, max_size);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static test::HostileFiles files;
  try {
    test::accepts(chosen_reader(), files, {reinterpret_cast<const char*>(data), size});
  } catch (const std::exception& error) {
    std::fprintf(stderr, "misread by %s: %s\n", chosen_reader().name, error.what());
    std::abort();
  }
  return 0;
}
