#include "gap/correct/faults.hpp"

#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

using namespace leeway;

namespace {

gap::Fault fault(const std::string& name, const std::string& parameter, double value, double p_value) {
  gap::Fault result;
  result.name = name;
  result.parameters = {{parameter, value, 0.1}};
  result.p_value = p_value;
  return result;
}

}  // namespace

TEST_CASE("faults: the likeliest of a fault and what may stand in its place is named, near the audit's number",
          "[gap]") {
  std::vector<gap::Fault> faults{fault("velocity-latency", "velocity_latency_s", 1.0, 1e-3)};
  const std::vector<gap::Fault> hypotheses{
      fault("rate-bias", "rate_bias_degps", 0.1, 1e-9), fault("heading-latency", "heading_latency_s", -0.5, 1.0),
      fault("rate-latency", "rate_latency_s", 0.5, 1.0), fault("sensor-filter", "filter_s", 1.0, 2e-3)};
  const std::map<std::string, double> evidence{{"velocity-latency", 8.0},
                                               {"sensor-filter", 10.0},
                                               {"rate-latency", 1.0},
                                               {"rate-bias", 99.0},
                                               {"heading-latency", 99.0}};
  gap::refine(faults, hypotheses, [&](std::vector<gap::Fault>& tried) {
    tried.front().parameters.front().value += 5.0;
    return std::optional<double>(evidence.at(tried.front().name));
  });
  REQUIRE(faults.size() == 1);
  const gap::Fault& likeliest = faults.front();
  CHECK(likeliest.name == "sensor-filter");  // neither what is no delay, nor what is early
  CHECK(likeliest.p_value == 1e-3);
  CHECK(likeliest.parameters.front().value == Approx(1.2));  // two standard deviations on
  CHECK(likeliest.sentence.find("1.20 s") != std::string::npos);
  REQUIRE(likeliest.rivals.size() == 1);  // another one is far less likely
  CHECK(likeliest.rivals.front().name == "velocity-latency");
  // Three filters share what two latencies share.
  CHECK(likeliest.rivals.front().log_odds == Approx(-2.0 + std::log(3.0 / 2.0)));
}

TEST_CASE("faults: where nothing can be fitted, faults and rivals stay as the audit has them", "[gap]") {
  std::vector<gap::Fault> faults{fault("log-scale", "log_scale", 0.05, 1e-3)};
  faults.front().rivals = {fault("rate-bias", "rate_bias_degps", 0.1, 2e-3)};
  gap::refine(faults, {}, [](std::vector<gap::Fault>&) { return std::optional<double>(); });
  CHECK(faults.front().parameters.front().value == 0.05);
  CHECK(faults.front().rivals.size() == 1);
}
