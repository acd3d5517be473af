#include <fstream>
#include <iterator>
#include <set>
#include <string>
#include <string_view>

#include <catch2/catch.hpp>

#include "forces/force_modules.hpp"
#include "ship/ship.hpp"

using namespace leeway;

TEST_CASE("coefficients: each that a module lists has a name, an uncertainty and a reference that the docs show",
          "[forces]") {
  std::ifstream stream(LEEWAY_SOURCE_FOLDER "/docs/gap-locate.md");
  const std::string documented{std::istreambuf_iterator<char>(stream), {}};
  for (const char* name : {"vectwin-3m", "esso-osaka-3m", "kvlcc2-l7", "kvlcc2-full", "vectwin-150m", "ferry-40m"}) {
    const Ship ship = read_ship(name);
    ForceModules<double> modules(*ship.modules, ship.particulars);
    Inertia<double> inertia(ship.inertia, ship.particulars);
    std::set<std::string> names, references;
    const auto check = [&](auto& module) {
      module.coefficients([&](const std::string& coefficient, double log_sd, std::string_view of, const auto&) {
        const std::string reference(of);
        references.insert(reference);
        CAPTURE(name, coefficient, reference);
        CHECK(names.insert(coefficient).second);
        CHECK(coefficient.find('.') != std::string::npos);
        CHECK(log_sd > 0.0);
        REQUIRE_FALSE(reference.empty());
        CHECK(documented.find("| " + reference + " |") != std::string::npos);
      });
    };
    check(inertia);
    modules.for_each(check);
    CHECK(names.size() > 20);
    CHECK(references.size() >= 4);  // not one for all
  }
}
