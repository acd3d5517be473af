#include "gap/result/phrases.hpp"

#include <algorithm>
#include <string>
#include <tuple>
#include <vector>

#include <catch2/catch.hpp>

#include "effects/description.hpp"
#include "gap/result/numbers.hpp"

using namespace leeway;

namespace {

gap::ExplainedParameter parameter(const std::string& effect, const std::string& name, double estimate, double sd) {
  gap::ExplainedParameter p;
  p.effect = effect;
  p.name = name;
  p.estimate = estimate;
  p.sd = sd;
  return p;
}

}  // namespace

TEST_CASE("phrases: an effect is told with its numbers, rounded to their errors", "[gap][result]") {
  CHECK(gap::phrase("steady-current", {parameter("steady-current", "current_speed_mps", 0.1004, 0.012),
                                       parameter("steady-current", "current_set_deg", 90.3, 4.0)}) ==
        "a current of 0.100 m/s towards 90 deg");
  CHECK(gap::phrase("tug", {parameter("tug", "force_N", 5.04, 0.4), parameter("tug", "direction_deg", 101.0, 5.0),
                            parameter("tug", "t_start_s", 60.2, 1.1), parameter("tug", "t_end_s", 110.0, 1.0)}) ==
        "a tow force (5.0 N towards 101 deg clockwise from the bow, from 60.2 s to 110 s)");
}

TEST_CASE("phrases: what differs between recordings is told of each of them, not by its mean", "[gap][result]") {
  std::vector<gap::ExplainedParameter> wind{parameter("unmeasured-wind", "wind_speed_mps", 0.2, 0.1),
                                            parameter("unmeasured-wind", "wind_dir_deg", 302.0, 8.0)};
  for (const auto& [recording, speed, from] : {std::tuple("monday", 0.8, 20.0), std::tuple("friday", 1.2, 200.0)}) {
    wind.push_back(parameter("unmeasured-wind", "wind_speed_mps", speed, 0.1));
    wind.push_back(parameter("unmeasured-wind", "wind_dir_deg", from, 6.0));
    for (std::size_t i = wind.size() - 2; i < wind.size(); ++i) wind[i].recording = recording;
  }
  CHECK(gap::phrase("unmeasured-wind", wind) ==
        "an unrecorded wind of 0.80 m/s from 20 deg in monday, an unrecorded wind of 1.20 m/s from 200 deg in friday");
  CHECK(gap::recordings_with("unmeasured-wind", wind) == std::vector<std::string>{"monday", "friday"});
  CHECK(gap::recordings_with("tug", wind).empty());
}

TEST_CASE("phrases: an effect that is as good as off says what it is, not that it is more or less", "[gap][result]") {
  CHECK(gap::sentence_of("rudder-effectiveness", {parameter("rudder-effectiveness", "k_R", 0.99, 0.2)}) ==
        effect_named("rudder-effectiveness").info.sentence);
}

TEST_CASE("phrases: words follow the sign", "[gap][result]") {
  const auto rudder = [](double k) {
    return gap::phrase("rudder-effectiveness", {parameter("rudder-effectiveness", "k_R", k, 0.04)});
  };
  CHECK(rudder(0.8) == "20 % less rudder force");
  CHECK(rudder(1.15) == "15 % more rudder force");
  const auto offset = [](double deg) {
    return gap::phrase("rudder-offset", {parameter("rudder-offset", "rudder_offset_deg", deg, 0.4)});
  };
  CHECK(offset(2.0) == "a rudder 2.0 deg further to starboard than recorded");
  CHECK(offset(-2.0) == "a rudder 2.0 deg further to port than recorded");
}

TEST_CASE("phrases: less rudder force may be damage, more of it is a wrong coefficient", "[gap][result]") {
  const auto rudder = [](double k) {
    return gap::sentence_of("rudder-effectiveness", {parameter("rudder-effectiveness", "k_R", k, 0.04)});
  };
  CHECK_THAT(rudder(0.7), Catch::Matchers::StartsWith("30 % less rudder force than the ship file states. That is a "
                                                      "damaged or fouled rudder, or a wrong coefficient"));
  CHECK_THAT(rudder(3.5), Catch::Matchers::StartsWith("250 % more rudder force than the ship file states. That is a "
                                                      "wrong coefficient"));
}

TEST_CASE("phrases: what is where the effect vanishes is not told", "[gap][result]") {
  CHECK(gap::phrase("windage", {parameter("windage", "kX", 1.01, 0.1), parameter("windage", "kY", 1.4, 0.1),
                                parameter("windage", "kN", 0.6, 0.1)}) ==
        "another wind force (40 % more sideways, 40 % less in yaw)");
  CHECK(gap::phrase("windage", {}) == "another wind force");
}

TEST_CASE("phrases: every effect of the catalogue has one, and its braces name parameters of it", "[gap][result]") {
  for (const EffectDescription& effect : effect_catalogue()) {
    CAPTURE(effect.info.name);
    REQUIRE(!effect.info.phrase.empty());
    std::vector<gap::ExplainedParameter> all;
    for (const EffectParameter& p : effect.parameters)
      all.push_back(parameter(std::string(effect.info.name), std::string(p.name), 2.0, 0.1));
    const std::string told = gap::phrase(std::string(effect.info.name), all);
    CHECK(told.find_first_of("{}|?!;") == std::string::npos);
    std::string_view rest = effect.info.phrase;
    for (std::size_t open = rest.find('{'); open != std::string_view::npos; open = rest.find('{')) {
      const std::string_view name = rest.substr(open + 1, rest.find_first_of("%!?}", open) - open - 1);
      CAPTURE(name);
      CHECK(std::any_of(effect.parameters.begin(), effect.parameters.end(),
                        [&](const EffectParameter& p) { return p.name == name; }));
      rest.remove_prefix(open + 1);
    }
  }
  CHECK(gap::phrase("no such effect", {}) == "no such effect");
}

TEST_CASE("numbers: units that names carry; coefficients have none", "[gap][result]") {
  CHECK(gap::unit_of("rate_bias_degps") == "deg/s");
  CHECK(gap::unit_of("force_N") == "N");
  for (const char* name : {"C_N", "c_N", "k_R"}) CHECK(gap::unit_of(name) == "1");
}

TEST_CASE("numbers: rounded to an error, also to tens", "[gap][result]") {
  CHECK(gap::rounded(1.2345, 0.04) == "1.23");
  CHECK(gap::rounded(1234.0, 40.0) == "1230");
  CHECK(gap::rounded(8.46, 0.2) == "8.46");
  CHECK(gap::rounded(-0.001, 0.04) == "0.00");
  CHECK(gap::rounded(3.14159, 0.0) == "3.14");
}

TEST_CASE("numbers: words as a shell takes them", "[gap][result]") {
  CHECK(gap::shell_word("data/zigzag-1.csv") == "data/zigzag-1.csv");
  CHECK(gap::shell_word("my ship.json") == "'my ship.json'");
  CHECK(gap::shell_word("it's") == "'it'\\''s'");
  CHECK(gap::shell_word("") == "''");
}
