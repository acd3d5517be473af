#include <algorithm>

#include <catch2/catch.hpp>

#include "nn/rollout.hpp"
#include "run.hpp"

using namespace leeway;
using test::run;

namespace {

// "files: a b" or "words: a b" for what may stand in place of the last word of a command line.
std::string offered(const std::string& tool, const std::string& words) {
  const test::TemporaryFolder folder;
  const auto outcome = run(folder, tool + " --complete " + words);
  CAPTURE(tool, words, outcome.err);
  REQUIRE(outcome.exit_code == 0);
  std::string text = outcome.out;
  const std::size_t end = text.find('\n');
  REQUIRE(end != std::string::npos);
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text.insert(end, ":").substr(0, text.size() - 1);
}

}  // namespace

TEST_CASE("completion: subcommands, options that may still be given, and their words", "[cli][completion]") {
  CHECK(offered("mmg-sim", "p") == "words: port-navigation pull-out");
  CHECK(offered("mmg-sim", "--seed 3 dra") == "words: draws");
  CHECK(offered("mmg-sim", "turning --w") == "words: --wind --wind-dir-deg --wind-speed-mps");
  CHECK(offered("mmg-sim", "turning --wind steady --wind") == "words: --wind-dir-deg --wind-speed-mps");
  CHECK(offered("mmg-sim", "turning --effect a.json --ef") == "words: --effect");  // repeatable
  CHECK(offered("mmg-sim", "turning --se") == "words: --seed");                    // of the tool, behind the subcommand
  CHECK(offered("mmg-sim", "turning --wind ''") == "words: steady stochastic");
  CHECK(offered("leeway-bench", "''") == "words: train predict pd sim gap read");
  CHECK(offered("leeway-bench", "sim ''") == "words:");
  CHECK(offered("mmg-sim", "no-such-command ''").starts_with("words: zigzag turning "));
}

TEST_CASE("completion: the names of what is shipped, and files where a file may stand", "[cli][completion]") {
  CHECK(offered("mmg-sim", "zigzag --ship vect") == "files: vectwin-150m vectwin-3m vectwin-3m-estimated");
  CHECK(offered("mmg-sim", "show kvlcc2-l") == "files: kvlcc2-l7");
  CHECK(offered("mmg-sim", "show kvlcc2-l7 ''") == "words:");
  CHECK(offered("mmg-sim", "dataset paper-m") == "files: paper-model-scale");
  CHECK(offered("mmg-sim", "estimate s") == "files: s175");
  CHECK(offered("mmg-sim", "zigzag --noise paper-f") == "files: paper-full-scale");
  CHECK(offered("mmg-sim", "effects wave") == "words: wave-drift");
  CHECK(offered("ens-train", "a.csv --config ho") == "files: honest");
  CHECK(offered("ens-train", "a.csv --base kv") == "files: kvlcc2-full kvlcc2-l7");
  CHECK(offered("gap-locate", "a.csv --columns hs") == "files: hsva-kvlcc2");
  CHECK(offered("gap-explain", "a.csv b.csv ''") == "files:");
  CHECK(offered("eval-metrics", "prediction --truth a.csv ''") == "files:");
  CHECK(offered("mmg-sim", "zigzag -o ''") == "files:");
  CHECK(offered("mmg-sim", "zigzag --duration-s ''") == "words:");
  CHECK(offered("pd-sweep", "model --kp ''") == "words:");
  std::string kernels = "words:";
  for (const std::string& name : nn::available_kernels()) kernels += " " + name;
  CHECK(offered("ens-predict", "--kernel ''") == kernels + " auto");
}
