// Everything that the fuzzers found, and what earlier faults looked like, in the ordinary build.

#include <algorithm>
#include <filesystem>

#include <catch2/catch.hpp>

#include "fuzz/readers.hpp"
#include "io/files.hpp"

using namespace leeway;
namespace fs = std::filesystem;

namespace {

std::vector<std::string> files_below(const fs::path& folder) {
  std::vector<std::string> files;
  if (fs::exists(folder))
    for (const auto& entry : fs::recursive_directory_iterator(folder))
      if (entry.is_regular_file()) files.push_back(entry.path().string());
  std::sort(files.begin(), files.end());
  return files;
}

// The corpus of a reader and the shipped files of its kind.
std::vector<std::string> texts_of(const test::Reader& reader) {
  std::vector<std::string> files = files_below(fs::path(LEEWAY_SOURCE_FOLDER "/tests/fuzz/corpus") / reader.name);
  if (*reader.seeds != '\0')
    for (const std::string& file : files_below(fs::path(LEEWAY_SOURCE_FOLDER) / reader.seeds)) files.push_back(file);
  return files;
}

}  // namespace

TEST_CASE("fuzz: no reader crashes on its corpus or misreads it", "[fuzz]") {
  for (const test::Reader& reader : test::readers()) {
    test::HostileFiles files;
    CAPTURE(reader.name);
    int accepted = 0, refused = 0;
    for (const std::string& file : texts_of(reader)) {
      CAPTURE(file);
      bool accepts = false;
      CHECK_NOTHROW(accepts = test::accepts(reader, files, io::read_text(file)));
      ++(accepts ? accepted : refused);
    }
    CHECK(accepted > 0);  // seeds from which the fuzzer gets further than the first check
    if (reader.wrong == test::Wrong::refused) CHECK(refused > 0);
  }
}

TEST_CASE("fuzz: readers accept the shipped files of their kind", "[fuzz]") {
  test::HostileFiles files;
  for (const test::Reader& reader : test::readers()) {
    if (*reader.seeds == '\0') continue;
    for (const std::string& file : files_below(fs::path(LEEWAY_SOURCE_FOLDER) / reader.seeds)) {
      CAPTURE(reader.name, file);
      CHECK(test::accepts(reader, files, io::read_text(file)));
    }
  }
}
