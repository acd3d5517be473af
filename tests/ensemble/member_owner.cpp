#include "ensemble/member_owner.hpp"

#include <filesystem>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>

#include "io/files.hpp"
#include "temporary_folder.hpp"

using namespace leeway;
using namespace leeway::ensemble;
using Catch::Matchers::Contains;

namespace {

const std::string kElsewhere =
    R"({"host": "another-node", "pid": 12, "process_start": 34, "token": "56", "epochs_done": 7, "loss": 8.5,
        "held_out_loss": 9.5, "seconds_left": null})";

}  // namespace

TEST_CASE("member owner: the record says who trains and how far it is, and goes with the owner", "[ensemble]") {
  const test::TemporaryFolder folder;
  const std::string path = folder.path().string();
  {
    MemberOwner owner(path, 3);
    owner.report({5, 12.25, std::nullopt, 60.5});
    const auto record = read_owner(path, 3);
    REQUIRE(record);
    CHECK(record->here());
    CHECK(record->alive());
    CHECK(record->pid == ::getpid());
    CHECK(record->progress.epochs_done == 5);
    CHECK(record->progress.loss == 12.25);
    CHECK_FALSE(record->progress.held_out_loss);
    CHECK(record->progress.seconds_left == 60.5);
    CHECK(record->age_s < 60.0);
    CHECK_THROWS_WITH(MemberOwner(path, 3), Contains("member-03.owner: process") && Contains("of this machine trains"));
    const MemberOwner another_member(path, 4);
  }
  CHECK(folder.listing().empty());
}

TEST_CASE("member owner: a process that has ended owns nothing", "[ensemble]") {
  const test::TemporaryFolder folder;
  const std::string path = folder.path().string();
  const pid_t child = ::fork();
  if (child == 0) {
    const MemberOwner owner(path, 0);
    ::_exit(0);  // as a kill: nothing is cleaned up
  }
  const auto ended = [&] {
    const auto record = read_owner(path, 0);
    return record && !record->alive();
  };
  while (!ended()) ::usleep(1000);  // although nobody has waited for it yet
  { const MemberOwner owner(path, 0); }
  CHECK(::waitpid(child, nullptr, 0) == child);
  CHECK(folder.listing().empty());
  // The same process number again is another process.
  folder.write("member-00.owner", R"({"host": ")" + io::read_text("/proc/sys/kernel/hostname"));
  CHECK_FALSE(read_owner(path, 0));
  const MemberOwner owner(path, 0);
  CHECK(read_owner(path, 0)->alive());
}

TEST_CASE("member owner: the later of two owners stays, and the earlier one leaves its record alone", "[ensemble]") {
  const test::TemporaryFolder folder;
  const std::string path = folder.path().string();
  folder.write("member-01.owner", kElsewhere);
  {
    MemberOwner here(path, 1);  // one elsewhere may be alive or not: it is displaced
    here.check();
    folder.write("member-01.owner", kElsewhere);
    CHECK_THROWS_AS(here.check(), Displaced);
    CHECK_THROWS_WITH(here.report({}), Contains("process 12 on another-node has taken this member over"));
  }
  CHECK(io::read_text(folder / "member-01.owner") == kElsewhere);
  MemberOwner here(path, 1);
  std::filesystem::remove(folder / "member-01.owner");  // as a training does that begins anew
  CHECK_THROWS_WITH(here.check(), Contains("has been removed"));
}
