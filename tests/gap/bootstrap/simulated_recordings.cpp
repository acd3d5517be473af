#include "gap/bootstrap/simulated_recordings.hpp"

#include <cmath>

#include <catch2/catch.hpp>

#include "core/units.hpp"
#include "gap/gap_locate.hpp"
#include "gap/simulated_campaign.hpp"

using namespace leeway;

namespace {

gap::Fitted nothing_missing(const gap::Investigation& of) {
  gap::Fitted fitted;
  fitted.fit = of.null;
  return fitted;
}

// Root mean square of what differs between neighbors but for what a cubic through their neighbors says: white noise
// of sd 1 makes sqrt(70).
double roughness(const Trajectory& recording, Channel channel) {
  const std::vector<double>& x = recording[channel];
  double sum = 0.0, n = 0.0;
  for (std::size_t i = 4; i < x.size(); ++i) {
    const double d = x[i] - 4.0 * x[i - 1] + 6.0 * x[i - 2] - 4.0 * x[i - 3] + x[i - 4];
    if (std::isfinite(d)) sum += d * d, n += 1.0;
  }
  return std::sqrt(sum / n / 70.0);
}

}  // namespace

TEST_CASE("simulated recordings: as the recorded ones, with new noise, holes in the same places", "[gap][bootstrap]") {
  const Ship ship = read_ship("esso-osaka-3m");
  std::vector<Trajectory> recordings = test::recorded({"esso-osaka-3m", 3, 3, 150.0, 1.0, 0.5}, ship);
  for (std::size_t i = 40; i < 45; ++i) recordings[0][Channel::u][i] = kMissing;
  recordings[1][Channel::x0].clear();
  recordings[1][Channel::y0].clear();
  const gap::Investigation investigation = gap::investigate(ship, recordings, {});
  const gap::Fitted fitted = nothing_missing(investigation);
  const auto simulate = [&](std::uint64_t c) {
    return gap::simulated_recordings(investigation.campaign, fitted, RandomStream(1, "test", c));
  };
  const std::vector<Trajectory> first = simulate(0), again = simulate(0), second = simulate(1);
  REQUIRE(first.size() == 3);
  for (std::size_t r = 0; r < 3; ++r) {
    CHECK(first[r].columns[0] == recordings[r].columns[0]);
    CHECK(first[r][Channel::n_p] == recordings[r][Channel::n_p]);
    CHECK(first[r][Channel::wind_speed] == recordings[r][Channel::wind_speed]);
    for (const Channel channel : gap::kMeasured) {
      REQUIRE(first[r].has(channel) == recordings[r].has(channel));
      for (std::size_t i = 0; i < first[r][channel].size(); ++i) {
        CHECK(std::isnan(first[r][channel][i]) == std::isnan(recordings[r][channel][i]));
        if (std::isnan(first[r][channel][i])) continue;
        CHECK(first[r][channel][i] == again[r][channel][i]);
        CHECK(first[r][channel][i] != second[r][channel][i]);
      }
    }
    // Noise as large as recorded.
    CHECK(roughness(first[r], Channel::u) == Approx(roughness(recordings[r], Channel::u)).epsilon(0.25));
    CHECK(roughness(first[r], Channel::r) == Approx(roughness(recordings[r], Channel::r)).epsilon(0.25));
    // She follows the recorded course, as if it had been steered again.
    for (std::size_t i = 0; i < first[r].size(); ++i)
      CHECK(std::abs(first[r][Channel::psi][i] - recordings[r][Channel::psi][i]) < 30.0 * kDegree);
  }
}

TEST_CASE("simulated recordings: what is drawn scatters as the fit says", "[gap][bootstrap][long]") {
  const Ship ship = read_ship("esso-osaka-3m");
  std::vector<Trajectory> recordings = test::recorded({"esso-osaka-3m", 3, 3, 150.0, 1.0, 0.0}, ship);
  const gap::Investigation investigation = gap::investigate(ship, recordings, {});
  const gap::Fitted fitted = nothing_missing(investigation);
  // A tool that is given them again finds coefficients that scatter by what the posterior and the fit leave open, and
  // the noise that was drawn.
  constexpr int kDraws = 6;
  double noise = 0.0;
  for (int c = 0; c < kDraws; ++c) {
    std::vector<Trajectory> drawn = gap::simulated_recordings(investigation.campaign, fitted,
                                                              RandomStream(2, "test", static_cast<std::uint64_t>(c)));
    const gap::Investigation other = gap::investigate(ship, drawn, {});
    CHECK(other.findings.verdict != gap::Verdict::mismatch);
    noise += other.null.noise.measurement_sd[3] / fitted.fit.noise.measurement_sd[3] / kDraws;
    const Eigen::VectorXd sd = gap::posterior_covariance(fitted.fit).diagonal().cwiseSqrt();
    const Eigen::VectorXd away =
        (other.null.theta - fitted.fit.theta).cwiseQuotient(std::sqrt(2.0) * sd).head(other.null.theta.size() - 1);
    CHECK(away.squaredNorm() / static_cast<double>(away.size()) < 2.5);
  }
  CHECK(noise == Approx(1.0).margin(0.1));
}
