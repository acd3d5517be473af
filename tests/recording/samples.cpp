#include "recording/samples.hpp"

#include <cmath>

#include <catch2/catch.hpp>

#include "core/errors.hpp"
#include "core/units.hpp"
#include "core/wind.hpp"

using namespace leeway;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

constexpr Channel kRudder[] = {Channel::delta};

// A recording of smooth motion with all that resample() looks at.
Trajectory smooth(double dt_s, std::size_t n, double start_s = 2.5) {
  Trajectory trajectory;
  trajectory.name = "smooth";
  trajectory.file = "smooth.csv";
  for (std::size_t i = 0; i < n; ++i) {
    const double t = start_s + static_cast<double>(i) * dt_s;
    trajectory[Channel::t].push_back(t);
    trajectory[Channel::u].push_back(1.0 + 0.05 * t);
    trajectory[Channel::vm].push_back(-0.2 + 0.01 * t);
    trajectory[Channel::r].push_back(0.03 - 0.002 * t);
    trajectory[Channel::psi].push_back(0.4 + 0.3 * t);
    trajectory[Channel::x0].push_back(3.0 * t);
    trajectory[Channel::y0].push_back(5.0 - t);
    trajectory[Channel::delta].push_back(std::sin(t));
    trajectory[Channel::wind_speed].push_back(4.0);
    trajectory[Channel::wind_dir].push_back(1.1);
  }
  return trajectory;
}

}  // namespace

TEST_CASE("resample: at its own rate a recording stays as it is, to the bit", "[recording][resample]") {
  const Trajectory trajectory = smooth(0.25, 40);
  for (const auto how : {StateResampling::decimate, StateResampling::average}) {
    const auto stretches = resample(trajectory, kRudder, false, 0.25, how);
    REQUIRE(stretches.size() == 1);
    const Samples& s = stretches[0];
    REQUIRE(s.size() == 40);
    CHECK(s.t0_s == 2.5);
    CHECK(s.recording == "smooth");
    CHECK((s.has_position && s.has_heading));
    for (Eigen::Index k = 0; k < s.size(); ++k) {
      const auto i = static_cast<std::size_t>(k);
      REQUIRE(s.t_s(k) == trajectory[Channel::t][i]);
      REQUIRE(s.nu(0, k) == trajectory[Channel::u][i]);
      REQUIRE(s.nu(1, k) == trajectory[Channel::vm][i]);
      REQUIRE(s.nu(2, k) == trajectory[Channel::r][i]);
      REQUIRE(s.eta(0, k) == trajectory[Channel::x0][i]);
      REQUIRE(s.eta(1, k) == trajectory[Channel::y0][i]);
      REQUIRE(s.eta(2, k) == trajectory[Channel::psi][i]);
      REQUIRE(s.actuators(0, k) == trajectory[Channel::delta][i]);
    }
  }
}

TEST_CASE("resample: decimation and averaging both follow a straight line", "[recording][resample]") {
  const Trajectory trajectory = smooth(0.1, 101);
  const auto decimated = resample(trajectory, {}, false, 1.0, StateResampling::decimate);
  const auto averaged = resample(trajectory, {}, false, 1.0, StateResampling::average);
  REQUIRE(decimated.at(0).size() == 11);
  REQUIRE(averaged.at(0).size() == 11);
  for (Eigen::Index k = 0; k < 11; ++k) {
    const double t = 2.5 + static_cast<double>(k);
    CHECK_THAT(decimated[0].nu(0, k), WithinRel(1.0 + 0.05 * t, 1e-12));
    // Half a cell is missing at either end: the mean is that of the samples which are there.
    const double shift = k == 0 ? 0.25 : k == 10 ? -0.25 : 0.0;
    CHECK_THAT(averaged[0].nu(0, k), WithinRel(1.0 + 0.05 * (t + shift), 1e-12));
    CHECK_THAT(averaged[0].eta(2, k), WithinRel(0.4 + 0.3 * (t + shift), 1e-12));
  }
}

TEST_CASE("resample: averaging keeps the mean of a noise that decimation lets through", "[recording][resample]") {
  Trajectory trajectory = smooth(0.1, 101);
  for (std::size_t i = 0; i < 101; ++i) trajectory[Channel::u][i] = i % 2 == 0 ? 1.4 : 0.6;
  CHECK(resample(trajectory, {}, false, 1.0, StateResampling::decimate).at(0).nu(0, 4) == 1.4);
  // 11 samples, six of one sign at most.
  CHECK_THAT(resample(trajectory, {}, false, 1.0, StateResampling::average).at(0).nu(0, 4),
             WithinAbs(1.0, 0.4 / 11.0 + 1e-12));
}

TEST_CASE("resample: inputs are the mean of what acts until the next point", "[recording][resample]") {
  Trajectory trajectory = smooth(0.5, 9);
  trajectory[Channel::delta] = {0.1, 0.3, 0.5, 0.7, -0.2, 0.4, 0.0, 0.6, 0.9};
  const Samples s = resample(trajectory, kRudder, false, 1.0).at(0);
  REQUIRE(s.size() == 5);
  const double expected[] = {0.2, 0.6, 0.1, 0.3, 0.9};
  for (int k = 0; k < 5; ++k) CHECK_THAT(s.actuators(0, k), WithinRel(expected[k], 1e-14));
}

TEST_CASE("resample: inputs on straight paths are means of the lines, with what jumps would leave open",
          "[recording][resample]") {
  Trajectory trajectory = smooth(0.5, 9);
  trajectory[Channel::delta] = {0.1, 0.3, 0.5, 0.7, -0.2, 0.4, 0.0, 0.6, 0.9};
  const Samples s = resample(trajectory, kRudder, false, 1.0, StateResampling::decimate, InputPath::linear).at(0);
  REQUIRE(s.size() == 5);
  // Trapezoids over (t, t + 0.5 s, t + 1 s); behind the last point nothing is known, and it is held.
  const double expected[] = {0.3, 0.425, 0.15, 0.525, 0.9};
  for (int k = 0; k < 5; ++k) CHECK_THAT(s.actuators(0, k), WithinRel(expected[k], 1e-14));
  CHECK_THAT(s.actuators_open(0, 0), WithinRel(0.5 * (0.2 + 0.2), 1e-14));
  CHECK_THAT(s.actuators_open(0, 1), WithinRel(0.5 * (0.2 - 0.9), 1e-14));
  CHECK(s.actuators_open(0, 4) == 0.0);
  // At the sampling rate: halfway, and anywhere along the change. Ten samples in a step leave little open.
  const Samples own = resample(trajectory, kRudder, true, 0.5, StateResampling::decimate, InputPath::linear).at(0);
  CHECK_THAT(own.actuators(0, 3), WithinRel(0.25, 1e-14));
  CHECK_THAT(own.actuators_open(0, 3), WithinRel(-0.9, 1e-14));
  CHECK(own.true_wind_open.isZero(1e-14));  // a steady wind
  const Samples dense =
      resample(smooth(0.1, 101), kRudder, false, 1.0, StateResampling::decimate, InputPath::linear).at(0);
  CHECK_THAT(dense.actuators(0, 2), WithinRel(std::cos(4.5) - std::cos(5.5), 1e-3));  // the integral of the sine
  CHECK_THAT(dense.actuators_open(0, 2), WithinRel(0.1 * (std::sin(5.5) - std::sin(4.5)), 1e-12));
}

TEST_CASE("resample: a finer grid interpolates states and holds inputs", "[recording][resample]") {
  const Trajectory trajectory = smooth(1.0, 4);
  for (const auto how : {StateResampling::decimate, StateResampling::average}) {
    const auto stretches = resample(trajectory, kRudder, false, 0.25, how);
    REQUIRE(stretches.size() == 1);
    REQUIRE(stretches[0].size() == 13);
    CHECK_THAT(stretches[0].nu(0, 6), WithinRel(1.0 + 0.05 * 4.0, 1e-14));
    CHECK(stretches[0].actuators(0, 7) == trajectory[Channel::delta][1]);
  }
}

TEST_CASE("resample: a short hole is bridged, a long one splits the recording", "[recording][resample]") {
  Trajectory trajectory = smooth(0.1, 101);
  // 0.4 s without samples, less than 1.5 steps of the grid; then one of 2.9 s.
  for (std::size_t i = 19; i < 22; ++i) trajectory[Channel::u][i] = kMissing;
  for (std::size_t i = 52; i < 80; ++i) trajectory[Channel::vm][i] = kMissing;
  const auto stretches = resample(trajectory, kRudder, false, 1.0);
  REQUIRE(stretches.size() == 2);
  CHECK(stretches[0].t0_s == 2.5);
  CHECK(stretches[0].size() == 6);
  CHECK_THAT(stretches[0].nu(0, 2), WithinRel(1.0 + 0.05 * 4.5, 1e-12));
  CHECK(stretches[1].t0_s == 10.5);
  CHECK(stretches[1].size() == 3);
  for (const Samples& s : stretches) CHECK_FALSE((s.nu.hasNaN() || s.eta.hasNaN() || s.actuators.hasNaN()));
}

TEST_CASE("resample: rows that are not there are a hole as missing samples are", "[recording][resample]") {
  Trajectory trajectory = smooth(1.0, 12);
  for (auto& column : trajectory.columns)
    if (!column.empty()) column.erase(column.begin() + 4, column.begin() + 7);
  for (const auto how : {StateResampling::decimate, StateResampling::average}) {
    const auto stretches = resample(trajectory, {}, false, 1.0, how);
    REQUIRE(stretches.size() == 2);
    CHECK(stretches[0].size() == 4);
    CHECK(stretches[1].size() == 5);
    CHECK(stretches[1].t0_s == 9.5);
  }
}

TEST_CASE("resample: a hole costs nothing however long it is, and changes nothing beside it", "[recording][resample]") {
  for (const auto how : {StateResampling::decimate, StateResampling::average})
    for (const double dt_s : {0.1, 0.25, 1.0}) {
      const Trajectory first = smooth(0.25, 60);
      const auto alone = resample(first, kRudder, true, dt_s, how);
      REQUIRE(alone.size() == 1);
      for (const double hole_s : {10.0, 1e4, 1e8, 1.7e9, 9e10}) {
        CAPTURE(dt_s, hole_s);
        Trajectory both = first;
        const Trajectory later = smooth(0.25, 80, first[Channel::t].back() + hole_s);
        for (std::size_t c = 0; c < kChannelCount; ++c)
          both.columns[c].insert(both.columns[c].end(), later.columns[c].begin(), later.columns[c].end());
        const auto stretches = resample(both, kRudder, true, dt_s, how);
        REQUIRE(stretches.size() == 2);
        // Averaged, the last point still sees samples of half a step, and one more may.
        CHECK(stretches[0].size() >= alone[0].size());
        CHECK(stretches[0].size() <= alone[0].size() + 1);
        const Eigen::Index n = alone[0].size();
        CHECK(stretches[0].nu.leftCols(n) == alone[0].nu);
        CHECK(stretches[0].true_wind.leftCols(n) == alone[0].true_wind);
        const auto points = static_cast<double>(stretches[1].size());
        CHECK_THAT(points * dt_s, WithinAbs(79 * 0.25, 2.0 * dt_s + 0.25));
        CHECK(stretches[1].t0_s >= later[Channel::t].front() - dt_s);
      }
    }
  CHECK_THROWS_WITH(resample(smooth(1e8, 60), kRudder, false, 1.0),
                    Catch::Matchers::Contains("smooth.csv:1: column 't_s': sampled every 1e+08 s"));
}

TEST_CASE("recording: a clock that jumps is found, and a pause between tests is not one", "[recording]") {
  Trajectory recording = smooth(1.0, 60, 0.0);
  CHECK_FALSE(clock_jumps(recording));
  CHECK(mean_sampling_time_s(recording) == 1.0);
  for (std::size_t i = 30; i < 60; ++i) recording[Channel::t][i] += 1.7e9;
  recording.longest_step = {32, 29.0, 1.7e9 + 30.0};
  CHECK(clock_jumps(recording));
  CHECK(jump_text(recording) == "from 29 s to 1700000030 s in one step, while all others last 58 s together");
  CHECK(spans_between_jumps(recording).size() == 2);
  CHECK(mean_sampling_time_s(recording) == 1.0);
  recording.longest_step = {32, 29.0, 80.0};
  for (std::size_t i = 30; i < 60; ++i) recording[Channel::t][i] -= 1.7e9 - 50.0;
  CHECK_FALSE(clock_jumps(recording));
  CHECK(spans_between_jumps(recording).size() == 1);
}

TEST_CASE("resample: an apparent wind alone gives the same true wind", "[recording][resample]") {
  const Trajectory with_true = smooth(0.5, 30);
  Trajectory with_apparent = with_true;
  for (std::size_t i = 0; i < 30; ++i) {
    const Vec2<double> apparent =
        apparent_wind(wind_from_vector(with_true[Channel::wind_speed][i], with_true[Channel::wind_dir][i]),
                      with_true[Channel::psi][i], with_true[Channel::u][i], with_true[Channel::vm][i]);
    with_apparent[Channel::app_wind_speed].push_back(apparent.norm());
    with_apparent[Channel::app_wind_dir].push_back(std::atan2(apparent(1), apparent(0)));
  }
  with_apparent[Channel::wind_speed].clear();
  with_apparent[Channel::wind_dir].clear();
  const Samples a = resample(with_true, {}, true, 1.0).at(0), b = resample(with_apparent, {}, true, 1.0).at(0);
  REQUIRE(a.size() == b.size());
  CHECK_THAT((a.true_wind - b.true_wind).cwiseAbs().maxCoeff(), WithinAbs(0.0, 1e-13));
  CHECK_THAT(a.true_wind(0, 3), WithinRel(4.0 * std::cos(1.1), 1e-14));
}

TEST_CASE("resample: wind from both sides of north averages to north", "[recording][resample]") {
  Trajectory trajectory = smooth(0.5, 21);
  for (std::size_t i = 0; i < 21; ++i) trajectory[Channel::wind_dir][i] = deg_to_rad(i % 2 == 0 ? 350.0 : 10.0);
  const Samples s = resample(trajectory, {}, true, 1.0).at(0);
  CHECK_THAT(s.true_wind(0, 2), WithinRel(4.0 * std::cos(deg_to_rad(10.0)), 1e-14));
  CHECK_THAT(s.true_wind(1, 2), WithinAbs(0.0, 1e-14));
}

TEST_CASE("resample: a missing channel is named", "[recording][resample]") {
  Trajectory trajectory = smooth(0.5, 21);
  trajectory[Channel::delta].clear();
  CHECK_THROWS_WITH(resample(trajectory, kRudder, false, 1.0), Catch::Contains("no column 'delta_deg'"));
  trajectory[Channel::wind_dir].clear();
  CHECK_THROWS_WITH(resample(trajectory, {}, true, 1.0), Catch::Contains("app_wind_speed_mps"));
  trajectory[Channel::psi].clear();
  trajectory[Channel::wind_dir].assign(21, 0.0);
  CHECK_THROWS_AS(resample(trajectory, {}, true, 1.0), InputError);
}

TEST_CASE("unwrap: a turning ship's heading goes on beyond half a turn, over missing samples too", "[recording]") {
  std::vector<double> wrapped, expected;
  for (int i = 0; i < 200; ++i) {
    const double psi = 0.3 + 0.11 * i;
    expected.push_back(psi);
    wrapped.push_back(wrap_angle(psi));
  }
  wrapped[57] = wrapped[58] = kMissing;
  unwrap(wrapped);
  for (std::size_t i = 0; i < 200; ++i) {
    if (i == 57 || i == 58) {
      CHECK(std::isnan(wrapped[i]));
    } else {
      REQUIRE_THAT(wrapped[i], WithinAbs(expected[i], 1e-12));
    }
  }
  const std::vector<double> once = wrapped;
  unwrap(wrapped);
  CHECK(wrapped[199] == once[199]);
}

TEST_CASE("windows: training windows cover every point, and only the last may overlap", "[recording][windows]") {
  for (const Eigen::Index K : {2, 7, 30})
    for (Eigen::Index points = 0; points < 100; ++points) {
      CAPTURE(K, points);
      std::vector<int> covered(static_cast<std::size_t>(points), 0);
      const auto windows = training_windows(points, K);
      for (std::size_t w = 0; w < windows.size(); ++w) {
        REQUIRE(windows[w].size == std::min(K, points));
        if (w + 1 < windows.size()) REQUIRE(windows[w].begin == static_cast<Eigen::Index>(w) * K);
        for (Eigen::Index k = 0; k < windows[w].size; ++k) ++covered.at(static_cast<std::size_t>(windows[w].begin + k));
      }
      for (const int c : covered) REQUIRE((c == 1 || c == 2));
    }
}

TEST_CASE("windows: test sequences lie side by side and leave out less than one of them", "[recording][windows]") {
  for (const Eigen::Index K : {2, 7, 30})
    for (Eigen::Index points = 0; points < 100; ++points) {
      const auto sequences = test_sequences(points, K);
      REQUIRE(sequences.size() == static_cast<std::size_t>(points / K));
      for (std::size_t n = 0; n < sequences.size(); ++n) {
        REQUIRE(sequences[n].begin == static_cast<Eigen::Index>(n) * K);
        REQUIRE(sequences[n].size == K);
      }
    }
}
