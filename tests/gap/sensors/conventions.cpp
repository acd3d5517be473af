#include "gap/sensors/conventions.hpp"

#include <functional>
#include <tuple>

#include <catch2/catch.hpp>

#include "core/errors.hpp"
#include "core/random.hpp"
#include "core/units.hpp"
#include "gap/perturbed_ship.hpp"
#include "gap/simulated_campaign.hpp"

using namespace leeway;
using namespace leeway::gap;
using namespace leeway::test;
using Catch::Matchers::WithinAbs;

namespace {

using Misread = std::function<void(Trajectory&)>;

void scale(Trajectory& recording, std::initializer_list<Channel> channels, double factor) {
  for (const Channel channel : channels)
    for (double& x : recording[channel]) x *= factor;
}

void forget(Trajectory& recording, std::initializer_list<Channel> channels) {
  for (const Channel channel : channels) recording[channel].clear();
}

struct Wrong {
  std::vector<std::pair<std::string, std::string>> readings;  // channel and name
  Misread make;
};

// The claimed readings are those, and rereading gives back what the sensors saw.
void check_found(const Ship& ship, const std::vector<Trajectory>& right, const Wrong& wrong) {
  std::vector<Trajectory> recordings = right;
  for (Trajectory& recording : recordings) wrong.make(recording);
  const Conventions result = check_conventions(ship, recordings);
  CAPTURE(wrong.readings[0].first, wrong.readings[0].second);
  std::string claimed;
  for (const Reading& reading : result.contradicted) claimed += reading.channel + "/" + reading.name + "; ";
  CAPTURE(claimed);
  REQUIRE(result.contradicted.size() == wrong.readings.size());
  for (const auto& [channel, name] : wrong.readings) {
    const auto is_this = [&](const Reading& r) { return r.channel == channel && r.name == name; };
    const auto found = std::find_if(result.contradicted.begin(), result.contradicted.end(), is_this);
    REQUIRE(found != result.contradicted.end());
    CHECK(found->log_odds > 10.0);
    CHECK(found->error_ratio > 1.3);
    CHECK(found->sentence.find("times smaller") != std::string::npos);
    CHECK(std::any_of(result.tested.begin(), result.tested.end(), is_this));
  }
  for (std::size_t i = 0; i < right.size(); ++i) {
    const Trajectory again = reread(recordings[i], result.contradicted);
    for (const ChannelInfo& known : kChannels) {
      REQUIRE(again.has(known.channel) == recordings[i].has(known.channel));
      for (std::size_t k = 0; k < again[known.channel].size(); k += 20) {
        const double difference = again[known.channel][k] - right[i][known.channel][k];
        const bool is_angle = known.quantity == Quantity::angle;
        CHECK_THAT(is_angle ? wrap_angle(difference) : difference, WithinAbs(0.0, 1e-9));
      }
    }
  }
}

const std::initializer_list<Channel> kRudders{Channel::delta, Channel::delta_p, Channel::delta_s};

void turn_wind(Trajectory& recording, Channel direction) {
  for (double& x : recording[direction]) x -= kPi;
}

}  // namespace

TEST_CASE("conventions: a contradicted reading of the motion is found by kinematics", "[gap][conventions]") {
  const Ship ship = read_ship("vectwin-3m");
  const std::vector<Trajectory> right = recorded({.seed = 11, .recordings = 4}, ship);
  const std::vector<Wrong> all{
      {{{"psi", "counter-clockwise"}}, [](Trajectory& t) { scale(t, {Channel::psi}, -1.0); }},
      {{{"psi", "radians"}}, [](Trajectory& t) { scale(t, {Channel::psi}, kDegree); }},
      {{{"psi", "radians"}},
       [](Trajectory& t) {
         for (double& x : t[Channel::psi]) x = wrap_angle(x) * kDegree;
         unwrap(t[Channel::psi]);
       }},
      {{{"x0", "east"}}, [](Trajectory& t) { std::swap(t[Channel::x0], t[Channel::y0]); }},
      {{{"u", "knots"}},
       [](Trajectory& t) {
         scale(t, {Channel::u, Channel::vm}, 1.0 / kKnot);
       }},
      {{{"u", "kmh"}},
       [](Trajectory& t) {
         scale(t, {Channel::u, Channel::vm}, 1.0 / kKilometerPerHour);
       }},
      {{{"x0", "km"}},
       [](Trajectory& t) {
         scale(t, {Channel::x0, Channel::y0}, 0.001);
       }},
      {{{"x0", "ft"}},
       [](Trajectory& t) {
         scale(t, {Channel::x0, Channel::y0}, 1.0 / kFoot_m);
       }},
      {{{"vm", "port-positive"}}, [](Trajectory& t) { scale(t, {Channel::vm}, -1.0); }},
      {{{"r", "counter-clockwise"}}, [](Trajectory& t) { scale(t, {Channel::r}, -1.0); }},
      {{{"r", "radians"}}, [](Trajectory& t) { scale(t, {Channel::r}, kDegree); }},
      {{{"r", "degpmin"}}, [](Trajectory& t) { scale(t, {Channel::r}, 60.0); }},
      {{{"psi", "counter-clockwise"}, {"u", "knots"}},
       [](Trajectory& t) {
         scale(t, {Channel::psi}, -1.0);
         scale(t, {Channel::u, Channel::vm}, 1.0 / kKnot);
       }},
  };
  for (const Wrong& wrong : all) check_found(ship, right, wrong);
}

TEST_CASE("conventions: true and apparent wind tell each other's conventions", "[gap][conventions]") {
  const Ship ship = read_ship("esso-osaka-3m");
  const std::vector<Trajectory> right = recorded({.ship = "esso-osaka-3m", .seed = 13, .recordings = 4}, ship);
  const std::vector<Wrong> all{
      {{{"wind_dir", "wind-to"}}, [](Trajectory& t) { turn_wind(t, Channel::wind_dir); }},
      {{{"app_wind_dir", "wind-to"}}, [](Trajectory& t) { turn_wind(t, Channel::app_wind_dir); }},
      {{{"wind_dir", "wind-to"}, {"app_wind_dir", "wind-to"}},
       [](Trajectory& t) {
         turn_wind(t, Channel::wind_dir);
         turn_wind(t, Channel::app_wind_dir);
       }},
      {{{"wind", "apparent"}},
       [](Trajectory& t) {
         std::swap(t[Channel::wind_speed], t[Channel::app_wind_speed]);
         std::swap(t[Channel::wind_dir], t[Channel::app_wind_dir]);
       }},
      {{{"app_wind_speed", "knots"}}, [](Trajectory& t) { scale(t, {Channel::app_wind_speed}, 1.0 / kKnot); }},
      {{{"wind_dir", "radians"}}, [](Trajectory& t) { scale(t, {Channel::wind_dir}, kDegree); }},
  };
  for (const Wrong& wrong : all) check_found(ship, right, wrong);
}

TEST_CASE("conventions: readings of rudders, propeller and wind are found by the forces of a ship 20 % wrong",
          "[gap][conventions][long]") {
  const Ship truth = read_ship("esso-osaka-3m"), wrong_ship = perturbed_ship("esso-osaka-3m", 0.2, 3);
  std::vector<Trajectory> right =
      recorded({.ship = "esso-osaka-3m", .seed = 11, .recordings = 8, .wind_mps = 2.0}, truth);
  for (Trajectory& recording : right) forget(recording, {Channel::app_wind_speed, Channel::app_wind_dir});
  const std::vector<Wrong> all{
      {{{"delta", "port-positive"}}, [](Trajectory& t) { scale(t, kRudders, -1.0); }},
      {{{"delta", "radians"}}, [](Trajectory& t) { scale(t, kRudders, kDegree); }},
      {{{"n_p", "rpm"}}, [](Trajectory& t) { scale(t, {Channel::n_p}, 60.0); }},
      {{{"wind_dir", "wind-to"}}, [](Trajectory& t) { turn_wind(t, Channel::wind_dir); }},
      {{{"wind_speed", "knots"}}, [](Trajectory& t) { scale(t, {Channel::wind_speed}, 1.0 / kKnot); }},
      {{{"delta", "port-positive"}, {"wind_dir", "wind-to"}},
       [](Trajectory& t) {
         scale(t, kRudders, -1.0);
         turn_wind(t, Channel::wind_dir);
       }},
  };
  for (const Wrong& wrong : all) check_found(wrong_ship, right, wrong);
}

TEST_CASE("conventions: one recording among others is named, and it alone is read anew", "[gap][conventions]") {
  const Ship ship = read_ship("esso-osaka-3m");
  std::vector<Trajectory> recordings = recorded({.ship = "esso-osaka-3m", .seed = 11, .recordings = 4}, ship);
  CHECK(contradicted_in_one(ship, recordings, check_conventions(ship, recordings), 1).empty());
  scale(recordings[1], kRudders, -1.0);
  const std::vector<Reading> found = contradicted_in_one(ship, recordings, check_conventions(ship, recordings), 2);
  REQUIRE(found.size() == 1);
  CHECK(found[0].channel == "delta");
  CHECK(found[0].name == "port-positive");
  CHECK(found[0].recording == recordings[1].name);
  CHECK(reread(recordings[0], found)[Channel::delta] == recordings[0][Channel::delta]);
  CHECK(reread(recordings[1], found)[Channel::delta] != recordings[1][Channel::delta]);
}

TEST_CASE("conventions: strong forces that the model lacks in one recording are no reading of it",
          "[gap][conventions][long]") {
  const Ship ship = read_ship("vectwin-3m");
  Ship truth = ship;
  EffectEntry& interaction = truth.effects.emplace_back();
  interaction.type = "vectwin-interaction";
  interaction.parameters = {{"k_interaction", 0.9}};
  for (const std::uint64_t seed : {1, 2, 3, 4, 5, 6, 7, 8}) {
    std::vector<Trajectory> recordings = recorded({.seed = seed, .recordings = 4}, ship);
    recordings[0] = recorded({.seed = seed, .recordings = 4}, truth)[0];
    for (const Reading& reading : contradicted_in_one(ship, recordings, check_conventions(ship, recordings), 2))
      FAIL_CHECK(seed << ": " << reading.sentence);
  }
}

TEST_CASE("conventions: angles that rudders have are not tried as degrees labeled rad", "[gap][conventions]") {
  const Ship ship = read_ship("esso-osaka-3m");
  std::vector<Trajectory> recordings = recorded({.ship = "esso-osaka-3m", .seed = 12, .recordings = 2}, ship);
  const auto tries_degrees = [&] {
    const Conventions result = check_conventions(ship, recordings);
    return std::any_of(result.tested.begin(), result.tested.end(),
                       [](const Reading& r) { return r.channel == "delta" && r.name == "degrees"; });
  };
  CHECK_FALSE(tries_degrees());
  for (Trajectory& recording : recordings) scale(recording, kRudders, 1.0 / kDegree);
  CHECK(tries_degrees());
}

TEST_CASE("conventions: one rudder of two, and a thruster, can be the one that is reversed",
          "[gap][conventions][long]") {
  const Ship truth = read_ship("vectwin-3m"), wrong_ship = perturbed_ship("vectwin-3m", 0.1, 5);
  const std::vector<Trajectory> right = recorded({.seed = 17, .recordings = 16}, truth);
  check_found(wrong_ship, right,
              {{{"delta_s", "port-positive"}}, [](Trajectory& t) { scale(t, {Channel::delta_s}, -1.0); }});
  check_found(wrong_ship, right, {{{"n_bt", "port-positive"}}, [](Trajectory& t) { scale(t, {Channel::n_bt}, -1.0); }});
}

TEST_CASE("conventions: nothing is claimed of right recordings, though the ship is wrong and a current unknown",
          "[gap][conventions][long]") {
  std::size_t claims = 0;
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    const std::string name = seed % 2 == 0 ? "vectwin-3m" : "esso-osaka-3m";
    Ship truth = read_ship(name);
    const TemporaryFolder folder;
    RandomStream stream(seed, "unknown");
    const double strength = stream.uniform(), direction = stream.uniform(0.0, 360.0);
    if (seed % 3 != 0) {
      const std::string path = folder / "effect.json";
      io::write_text(path, seed % 3 == 1 ? fmt::format("{{\"type\": \"steady-current\", \"current_speed_mps\": {}, "
                                                       "\"current_set_deg\": {}}}",
                                                       0.08 * strength, direction)
                                         : fmt::format("{{\"type\": \"unmeasured-wind\", \"wind_speed_mps\": {}, "
                                                       "\"wind_dir_deg\": {}}}",
                                                       2.0 * strength, direction));
      truth.effects = read_effects(path);
    }
    std::vector<Trajectory> recordings = recorded(
        {.ship = name, .seed = 900 + seed, .recordings = 1 + seed % 8, .wind_mps = 0.3 * static_cast<double>(seed % 5)},
        truth);
    for (Trajectory& recording : recordings) {
      if (seed % 4 == 1) forget(recording, {Channel::app_wind_speed, Channel::app_wind_dir});
      if (seed % 4 == 2) forget(recording, {Channel::wind_speed, Channel::wind_dir});
    }
    claims += check_conventions(perturbed_ship(name, 0.2, seed), recordings).contradicted.size();
  }
  CHECK(claims == 0);
}

TEST_CASE("conventions: a sensor fault is no convention", "[gap][conventions]") {
  const Ship ship = read_ship("vectwin-3m");
  for (const double size : {-1.0, 1.0}) {
    Injected fault;
    fault.heading_bias = 8.0 * size * kDegree;
    fault.velocity_latency_s = fault.rate_latency_s = 2.0 * size;
    fault.log_scale = 0.2 * size;
    CHECK(check_conventions(ship, recorded({.seed = 19}, ship, fault)).contradicted.empty());
  }
}

TEST_CASE("conventions: without heading the forces show the sign of r", "[gap][conventions]") {
  const Ship ship = read_ship("vectwin-3m");
  std::vector<Trajectory> recordings = recorded({.seed = 23}, ship);
  for (Trajectory& recording : recordings) {
    forget(recording, {Channel::x0, Channel::y0, Channel::psi, Channel::wind_speed, Channel::wind_dir,
                       Channel::app_wind_speed, Channel::app_wind_dir});
    scale(recording, {Channel::r}, -1.0);
  }
  const Conventions result = check_conventions(ship, recordings);
  REQUIRE(result.contradicted.size() == 1);
  CHECK(result.contradicted[0].channel == "r");
  CHECK(result.contradicted[0].name == "counter-clockwise");
  CHECK(result.unchecked.size() == 2);
}

TEST_CASE("conventions: recordings without what is needed are said to be unchecked", "[gap][conventions]") {
  const Ship ship = read_ship("vectwin-3m");
  std::vector<Trajectory> recordings = recorded({.seed = 29, .recordings = 2}, ship);
  for (Trajectory& recording : recordings) forget(recording, {Channel::delta_p, Channel::psi});
  const Conventions result = check_conventions(ship, recordings);
  CHECK(result.contradicted.empty());
  CHECK(result.unchecked.size() >= 3);
  CHECK(check_conventions(ship, {}).contradicted.empty());
  CHECK_THROWS_AS(reread(recordings[0], {{.channel = "u", .name = "furlongs", .sentence = ""}}), UsageError);
}

TEST_CASE("conventions: a yaw rate that is noise on straight runs is not taken for degrees", "[gap][conventions]") {
  RandomStream random(3, "straight runs");
  std::vector<Trajectory> recordings;
  for (int run = 0; run < 3; ++run) {
    Trajectory& recording = recordings.emplace_back();
    recording.name = recording.file = "straight" + std::to_string(run);
    for (int k = 0; k <= 100; ++k)
      for (const auto& [channel, value, sd] : {std::tuple{Channel::t, static_cast<double>(k), 0.0},
                                               {Channel::x0, 0.5 * k, 0.03},
                                               {Channel::y0, 0.0, 0.03},
                                               {Channel::psi, 0.0, 0.1 * kDegree},
                                               {Channel::u, 0.5, 0.01},
                                               {Channel::vm, 0.0, 0.01},
                                               {Channel::r, 0.0, 0.3 * kDegree},
                                               {Channel::n_p, 10.0, 0.0},
                                               {Channel::delta, 0.0, 0.0}})
        recording[channel].push_back(value + sd * random.normal());
  }
  const Ship ship = read_ship("esso-osaka-3m");
  const Conventions result = check_conventions(ship, recordings);
  for (const Reading& reading : result.contradicted) FAIL_CHECK(reading.sentence);
  // Nor in one such run among others that turn.
  std::vector<Trajectory> among = recorded({.ship = "esso-osaka-3m", .recordings = 3}, ship);
  among.push_back(recordings.front());
  for (const Reading& reading : contradicted_in_one(ship, among, check_conventions(ship, among), 1))
    FAIL_CHECK(reading.sentence);
}
