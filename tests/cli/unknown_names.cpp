// Names that a command line misspells: what there is, and what may have been meant.

#include <catch2/catch.hpp>

#include "ensemble.hpp"

using namespace leeway::test;
using Catch::Matchers::Contains;

TEST_CASE("unknown names: a subcommand, an option, a shipped configuration or an effect gets a suggestion", "[cli]") {
  const TemporaryFolder folder;
  for (const auto& [command, message] : std::initializer_list<std::pair<const char*, const char*>>{
           {"mmg-sim zigzg --ship kvlcc2-l7", "unknown subcommand 'zigzg'; known: "},
           {"mmg-sim zigzg --ship kvlcc2-l7", "did you mean 'zigzag'?"},
           {"mmg-sim trun", "unknown subcommand 'trun'"},
           {"mmg-sim zigzag --shp kvlcc2-l7", "unknown option '--shp'; did you mean '--ship'?"},
           {"mmg-sim zigzag --ship kvlcc2-l7 --u0-mp 1", "unknown option '--u0-mp'; did you mean '--u0-mps'?"},
           {"mmg-sim zigzag --ship kvlcc2-l7 --ruder-deg=5",
            "unknown option '--ruder-deg'; did you mean '--rudder-deg'?"},
           {"mmg-sim zigzag --ship kvlcc2-l7 --sed 3", "did you mean '--seed'?"},
           {"mmg-sim --ship kvlcc2-l7 zigzag", "the option '--ship' belongs to the subcommand 'zigzag'"},
           {"mmg-sim zigzag --ship kvlc2-l7", "did you mean 'kvlcc2-l7'?"},
           {"mmg-sim show kvlcc2", "did you mean 'kvlcc2-full' or 'kvlcc2-l7'?"},
           {"mmg-sim random --ship vectwin-3m --noise paper-model-scal", "did you mean 'paper-model-scale'?"},
           {"mmg-sim dataset dem -o d", "did you mean 'demo'?"},
           {"mmg-sim effects fuoling", "did you mean 'fouling'?"},
           {"mmg-sim zigzag --ship vectwin-3m --effect fuoling", "no file 'fuoling'"},
           {"mmg-sim zigzag --ship vectwin-3m --effect fuoling", "did you mean 'fouling'?"},
           {"mmg-sim zigzag --ship vectwin-3m --effect tug", "'mmg-sim effects tug' lists them"},
           {"ens-train --mebers 3 a.csv", "unknown option '--mebers'; did you mean '--members'?"},
           {"ens-train a.csv -o m --config honst", "did you mean 'honest'?"},
           {"eval-metrics a.csv --trth b.csv", "unknown option '--trth'; did you mean '--truth'?"},
           {"gap-explain --shp kvlcc2-l7 a.csv -o d", "did you mean '--ship'?"}})
    check_refused(folder, command, 2, message);
  check_refused(folder, "mmg-sim zigzag --ship kvlcc2-l7 --ruder-deg=5", 2, "Try 'mmg-sim zigzag --help'");
  folder.write("z.csv", "t_s,u_mps,vm_mps,r_degps\n0,1,0,0\n1,1,0,0\n");
  folder.write("map.json", R"({"psi_dg": "heading"})");
  check_refused(folder, "mmg-sim import z.csv --columns ./map.json", 3, "did you mean 'psi_deg'?");
  const std::string misspelled = folder.write("e.json", R"({"type": "steady-curent", "current_speed_mps": 0.1})");
  check_refused(folder, "mmg-sim zigzag --ship vectwin-3m --effect e.json", 3, "did you mean 'steady-current'?");
  folder.write("e.json", R"({"type": "steady-current", "current_spede_mps": 0.1})");
  check_refused(folder, "mmg-sim zigzag --ship vectwin-3m --effect e.json", 3, "did you mean 'current_speed_mps'?");
}
