#include <fstream>
#include <iterator>
#include <set>
#include <string>

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
    ForceModules<double> modules(ship);
    Inertia<double> inertia(ship.inertia, ship.particulars);
    std::set<std::string> names;
    const auto check = [&](auto& module) {
      const std::string reference(module.reference);
      module.coefficients([&](const std::string& coefficient, double log_sd, const auto&) {
        CAPTURE(name, coefficient, reference);
        CHECK(names.insert(coefficient).second);
        CHECK(coefficient.find('.') != std::string::npos);
        CHECK(log_sd > 0.0);
        CHECK(documented.find("| " + reference + " |") != std::string::npos);
      });
    };
    check(inertia);
    modules.for_each(check);
    CHECK(names.size() > 20);
  }
}
