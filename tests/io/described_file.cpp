#include "io/described_file.hpp"

#include <filesystem>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "core/errors.hpp"
#include "io/files.hpp"
#include "temporary_folder.hpp"

using namespace leeway;

TEST_CASE("described file: the provenance lies beside and has the hash of the text", "[io]") {
  const test::TemporaryFolder folder;
  io::write_described(folder / "run.csv", "t_s\n0\n", {{"tool", "a test"}});
  CHECK(io::read_text(folder / "run.csv") == "t_s\n0\n");
  const io::Json json = io::read_json(folder / "run.csv.provenance.json");
  CHECK(json["sha256"] == io::sha256_of_file(folder / "run.csv"));
  CHECK(json["provenance"]["tool"] == "a test");
  // Equal results are equal files, whatever their names.
  io::write_described(folder / "other.csv", "t_s\n0\n", {{"tool", "a test"}});
  CHECK(io::read_text(folder / "other.csv.provenance.json") == io::read_text(folder / "run.csv.provenance.json"));
  io::remove_described(folder / "run.csv");
  CHECK(folder.listing() == "other.csv other.csv.provenance.json");
}

TEST_CASE("described file: streams and devices have none, and what cannot be written leaves nothing behind", "[io]") {
  const test::TemporaryFolder folder;
  for (const std::string stream : {"-", "", "/dev/null"}) CHECK(io::provenance_path(stream).empty());
  io::write_described("/dev/null", "text", {});
  CHECK_THROWS_AS(io::write_described(folder / "no/such/run.csv", "text", {}), IoError);
  std::filesystem::create_directories(folder / "run.csv.provenance.json");
  CHECK_THROWS_AS(io::write_described(folder / "run.csv", "text", {}), IoError);
  CHECK(folder.listing() == "run.csv.provenance.json");
}
