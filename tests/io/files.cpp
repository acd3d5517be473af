#include "io/files.hpp"

#include <filesystem>
#include <fstream>
#include <sys/stat.h>
#include <unistd.h>

#include <catch2/catch.hpp>

#include "core/errors.hpp"
#include "temporary_folder.hpp"

using namespace leeway;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

TEST_CASE("files: an output appears whole at commit and not before", "[io][files]") {
  const test::TemporaryFolder folder;
  {
    io::OutputFile file(folder / "out.txt");
    file.write("first line\n");
    CHECK_FALSE(fs::exists(folder / "out.txt"));
    file.write("second\n");
    file.commit();
  }
  CHECK(folder.listing() == "out.txt");
  CHECK(io::read_text(folder / "out.txt") == "first line\nsecond\n");
}

TEST_CASE("files: without commit the old file stays and nothing else is left", "[io][files]") {
  const test::TemporaryFolder folder;
  folder.write("out.txt", "old");
  {
    io::OutputFile file(folder / "out.txt");
    file.write("half of the new");
  }
  CHECK(folder.listing() == "out.txt");
  CHECK(io::read_text(folder / "out.txt") == "old");
}

TEST_CASE("files: writing through a link changes its target and keeps the link", "[io][files]") {
  const test::TemporaryFolder folder;
  folder.write("store/real.txt", "old");
  fs::create_symlink("store/real.txt", folder / "link.txt");
  fs::create_symlink("store/later.txt", folder / "dangling.txt");
  io::write_text(folder / "link.txt", "new");
  io::write_text(folder / "dangling.txt", "made");
  CHECK(fs::is_symlink(folder / "link.txt"));
  CHECK(io::read_text(folder / "store/real.txt") == "new");
  CHECK(fs::is_symlink(folder / "dangling.txt"));
  CHECK(io::read_text(folder / "store/later.txt") == "made");
}

TEST_CASE("files: what cannot be written is an IoError and leaves nothing behind", "[io][files]") {
  const test::TemporaryFolder folder;
  CHECK_THROWS_AS(io::OutputFile(folder.path().string()), IoError);
  CHECK_THROWS_WITH(io::OutputFile(folder / "no/such/folder.txt"), Contains("No such file or directory"));
  CHECK(folder.listing().empty());
  if (fs::exists("/dev/full")) {
    io::OutputFile full("/dev/full");
    full.write("text");
    CHECK_THROWS_WITH(full.commit(), Contains("/dev/full: cannot be written"));
    CHECK(fs::is_character_file("/dev/full"));
  }
  io::write_text("/dev/null", "text");
  CHECK(fs::is_character_file("/dev/null"));
}

TEST_CASE("files: a folder that cannot be made is refused beforehand, and one that can is not made yet",
          "[io][files]") {
  const test::TemporaryFolder folder;
  const std::string file = folder.write("file.txt", "x");
  CHECK_THROWS_AS(io::require_can_make(file), IoError);
  CHECK_THROWS_AS(io::require_can_make(file + "/below/it"), IoError);
  io::require_can_make(folder / "new/and/newer");
  io::require_can_make("new-in-this-folder/");
  CHECK(folder.listing() == "file.txt");
}

TEST_CASE("files: a read-only file is not replaced", "[io][files]") {
  if (::geteuid() == 0) {
    WARN("SKIPPED: permissions do not bind the superuser");
    return;
  }
  const test::TemporaryFolder folder;
  fs::permissions(folder.write("out.txt", "old"), fs::perms::owner_read);
  CHECK_THROWS_AS(io::write_text(folder / "out.txt", "new"), IoError);
  CHECK(io::read_text(folder / "out.txt") == "old");
}

TEST_CASE("files: a replaced file keeps its permissions", "[io][files]") {
  const test::TemporaryFolder folder;
  const auto mode = fs::perms::owner_read | fs::perms::owner_write;
  fs::permissions(folder.write("out.txt", "old"), mode);
  io::write_text(folder / "out.txt", "new");
  CHECK(fs::status(folder / "out.txt").permissions() == mode);
}

TEST_CASE("files: SHA-256 of a text and of a file agree with the published example", "[io][files]") {
  // FIPS 180-2, appendix B.1.
  const std::string abc = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
  CHECK(io::sha256("abc") == abc);
  const test::TemporaryFolder folder;
  CHECK(io::sha256_of_file(folder.write("abc.txt", "abc")) == abc);
  const std::string longer(1'000'000, 'a');  // appendix B.3
  CHECK(io::sha256_of_file(folder.write("a.txt", longer)) ==
        "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
  CHECK_THROWS_AS(io::sha256_of_file(folder / "absent"), IoError);
}
