#include "metrics/scores.hpp"

#include <cmath>
#include <filesystem>

#include <catch2/catch.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/errors.hpp"
#include "core/random.hpp"
#include "temporary_folder.hpp"

using namespace leeway;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

namespace fs = std::filesystem;

using Folder = test::TemporaryFolder;

const std::string kHeader = "recording,sequence,step,t_s,particle,member,x0_m,y0_m,psi_deg,u_mps,vm_mps,r_degps\n";

std::string row(const std::string& recording, int sequence, int step, double t_s, int particle, int member,
                const Vec3<double>& nu, double x0 = 0.0, double y0 = 0.0) {
  return fmt::format("{},{},{},{},{},{},{},{},0,{},{},{}\n", recording, sequence, step, t_s, particle, member, x0, y0,
                     nu(0), nu(1), rad_to_deg(nu(2)));
}

Evaluation evaluate_text(const Folder& folder, const std::string& rows, const std::vector<std::string>& truths) {
  const std::string file = folder.write("prediction.csv", kHeader + rows);
  return evaluate(find_predictions({file}), truths_by_name(truths), ScoreOptions{});
}

ParticleMoments moments_of(const std::vector<Vec3<double>>& particles) {
  ParticleMoments moments;
  for (const Vec3<double>& nu : particles) moments.add(nu, 0.0, 0.0);
  return moments;
}

// Particles at mean +- 0.1, +- 0.2, +- 0.05 along the axes: Sigma is diagonal, (1/6) (2 a^2) each.
const std::vector<Vec3<double>> kSixAround{{0.1, 0, 0},  {-0.1, 0, 0}, {0, 0.2, 0},
                                           {0, -0.2, 0}, {0, 0, 0.05}, {0, 0, -0.05}};

}  // namespace

TEST_CASE("scores: a case computed by hand", "[metrics]") {
  // One sequence of K = 3 points, six particles. At k = 0 they coincide. At k = 1 and 2 they stand around the mean
  // (1, -0.5, 0.2) as kSixAround: Sigma = diag(0.02, 0.08, 0.005)/6.
  //   k = 1: truth - mean = (0.1, 0.2, -0.05): eucl^2 = 0.01 + 0.04 + 0.0025 = 0.0525;
  //          maha^2 = 6 (0.01/0.02 + 0.04/0.08 + 0.0025/0.005) = 9
  //   k = 2: truth - mean = (0, 0.1, 0):       eucl^2 = 0.01, maha^2 = 6 0.01/0.08 = 0.75
  // L_eucl = 0.03125, L_maha = 4.875; two points: the correlation is 1. The truth is 3 m, then 5 m from the mean
  // position: rmse sqrt(17). L_fit with sigma (0.01, 0.01, 0.1 deg/s): the mean over k = 0, 1, 2 of (error^2 +
  // Sigma_ii)/sigma_i^2.
  const Folder folder;
  const Vec3<double> mean{1.0, -0.5, 0.2};
  std::string rows;
  for (int p = 0; p < 6; ++p) {
    rows += row("turn", 4, 0, 10.0, p, p % 5, mean);
    rows += row("turn", 4, 1, 11.0, p, p % 5, mean + kSixAround[static_cast<std::size_t>(p)], 0.0, 7.0);
    rows += row("turn", 4, 2, 12.0, p, p % 5, mean + kSixAround[static_cast<std::size_t>(p)], p - 2.5, 0.0);
  }
  const std::string truth = folder.write(
      "pond/turn.csv", fmt::format("t_s,u_mps,vm_mps,r_radps,x0_m,y0_m\n10,1,-0.5,0.2,0,0\n11,1.1,-0.3,0.15,3,7\n"
                                   "12,1,-0.4,0.2,4,-3\n"));
  const Evaluation evaluation = evaluate_text(folder, rows, {truth});
  REQUIRE(evaluation.datasets.size() == 1);
  const Scores& s = evaluation.datasets[0];
  CHECK(s.name == "pond");
  CHECK(s.sequences == 1);
  CHECK(s.steps == 3);
  CHECK(s.particles == 6U);
  CHECK(s.points == 2);
  CHECK(s.members == 5);
  CHECK(s.sampling == "ts-inf");
  CHECK(s.missing_truth == 0);
  CHECK_THAT(s.L_eucl, WithinRel(0.03125, 1e-12));
  CHECK_THAT(s.L_maha, WithinRel(4.875, 1e-12));
  CHECK(s.maha_undefined_fraction == 0.0);
  CHECK_THAT(s.correlation, WithinRel(1.0, 1e-12));
  CHECK_THAT(s.rmse(0), WithinRel(std::sqrt(0.01 / 2.0), 1e-12));
  CHECK_THAT(s.rmse(1), WithinRel(std::sqrt(0.05 / 2.0), 1e-12));
  CHECK_THAT(s.rmse(2), WithinRel(std::sqrt(0.0025 / 2.0), 1e-12));
  CHECK_THAT(s.rmse_position, WithinRel(std::sqrt((9.0 + 25.0) / 2.0), 1e-12));
  const std::vector<PointScore>& points = evaluation.recordings[0].points;
  CHECK(points[1].position_sd == 0.0);
  CHECK_THAT(points[2].position_sd, WithinRel(std::sqrt(2.0 * (0.25 + 2.25 + 6.25) / 6.0), 1e-12));
  // CRPS of u: at k = 1 particles at -0.1, 0.1 and four at 0 about the mean, the truth 0.1 above it; at k = 2 on it.
  //   mean |x - y| = (0.2 + 0 + 4 0.1)/6 = 0.1, and (0.1 + 0.1)/6; half of the mean distance apart (0.2 + 8 0.1)/36
  CHECK_THAT(s.crps(0), WithinRel((0.1 + 0.2 / 6.0) / 2.0 - 1.0 / 36.0, 1e-9));
  // PIT of u: 5 of 6 below and one equal; 1 below and 4 equal.
  CHECK_THAT(points[1].pit(0), WithinRel(5.5 / 6.0, 1e-12));
  CHECK_THAT(points[2].pit(0), WithinRel(0.5, 1e-12));
  CHECK(s.pit[0][9] == 0.5);
  CHECK(s.pit[0][5] == 0.5);
  const double sigma_r2 = std::pow(0.1 * kPi / 180.0, 2);
  const double fit_1 = (0.01 + 0.02 / 6.0 + 0.04 + 0.08 / 6.0) / 1e-4 + (0.0025 + 0.005 / 6.0) / sigma_r2;
  const double fit_2 = (0.02 / 6.0 + 0.01 + 0.08 / 6.0) / 1e-4 + 0.005 / 6.0 / sigma_r2;
  CHECK_THAT(s.L_fit, WithinRel((fit_1 + fit_2) / 3.0, 1e-12));
  CHECK_THAT(evaluation.overall.L_maha, WithinRel(4.875, 1e-12));
}

TEST_CASE("scores: covariance without full rank is undefined, however the spread compares with the mean", "[metrics]") {
  RandomStream stream(5, "degenerate");
  for (const double spread : {1.0, 1e-4, 1e-8, 1e-11})
    for (const std::size_t members : {1, 2, 3, 4, 6}) {
      CAPTURE(spread, members);
      std::vector<Vec3<double>> of_member(members);
      for (auto& nu : of_member)
        for (int i = 0; i < 3; ++i) nu(i) = (i + 1) * 0.7 + spread * stream.normal();
      // 100 particles with the members' values, as the ensemble draws them.
      std::vector<Vec3<double>> particles;
      for (int p = 0; p < 100; ++p) particles.push_back(of_member[stream.below(members)]);
      const Eigen::Matrix3d Sigma = moments_of(particles).covariance();
      CHECK(squared_mahalanobis({0.1, 0.2, 0.3}, Sigma).has_value() == (members > 3));
    }
}

TEST_CASE("scores: three members give null and count as undefined, in the JSON too", "[metrics]") {
  const Folder folder;
  std::string rows;
  for (int k = 0; k < 4; ++k)
    for (int p = 0; p < 9; ++p)
      rows +=
          row("a", 0, k, k, p, p % 3, {1.0 + 0.01 * k * (p % 3), 0.02 * k * ((p + 1) % 3), 0.1 - 0.003 * k * (p % 3)});
  const std::string truth = folder.write("t/a.csv", "t_s,u_mps,vm_mps,r_degps\n0,1,0,0\n1,1,0,0\n2,1,0.1,0\n3,1,0,1\n");
  const Evaluation evaluation = evaluate_text(folder, rows, {truth});
  CHECK(evaluation.overall.maha_undefined_fraction == 1.0);
  const io::Json json = to_json(evaluation)["datasets"][0];
  CHECK(json["L_maha"].is_null());
  CHECK(json["correlation_eucl_maha"].is_null());
  CHECK(json["coverage"]["90"].is_null());
  CHECK(json["rmse_position_m"].is_null());
  CHECK(json["L_eucl"].is_number());
  CHECK(json["members"] == 3);
  // Empty fields where the distance is undefined.
  CHECK(per_step_text(evaluation).find(",\n") != std::string::npos);
}

TEST_CASE("scores: the running covariance agrees with sums of squares in long double", "[metrics]") {
  RandomStream stream(9, "welford");
  std::vector<Vec3<double>> particles;
  for (int p = 0; p < 500; ++p) {
    const double common = stream.normal();
    const double a = stream.normal(), b = stream.normal();
    particles.push_back({7.0 + 0.01 * common, -3.0 + 0.02 * (common + a), 0.4 + 0.001 * (a - 2.0 * b)});
  }
  long double sum[3] = {}, product[3][3] = {};
  for (const Vec3<double>& nu : particles)
    for (int i = 0; i < 3; ++i) {
      sum[i] += nu(i);
      for (int j = 0; j < 3; ++j) product[i][j] += static_cast<long double>(nu(i)) * nu(j);
    }
  const ParticleMoments moments = moments_of(particles);
  const Eigen::Matrix3d Sigma = moments.covariance();
  for (int i = 0; i < 3; ++i) {
    CHECK_THAT(moments.mean()(i), WithinRel(static_cast<double>(sum[i] / 500.0L), 1e-14));
    for (int j = 0; j < 3; ++j) {
      const auto plain = static_cast<double>(product[i][j] / 500.0L - sum[i] / 500.0L * (sum[j] / 500.0L));
      // Long double loses (mean/sd)^2 of its 1e-19 to cancellation: 1e-12 of the variance is safe.
      CHECK_THAT(Sigma(i, j), WithinAbs(plain, 1e-11 * std::sqrt(Sigma(i, i) * Sigma(j, j))));
    }
  }
}

TEST_CASE("scores: the order of rows and of files does not matter", "[metrics]") {
  const Folder folder;
  RandomStream stream(2, "rows");
  std::vector<std::string> rows;
  std::string truth = "t_s,u_mps,vm_mps,r_degps,x0_m,y0_m\n";
  for (int t = 0; t < 20; ++t) truth += fmt::format("{},1,0.1,{},{},0\n", t, 0.1 * t, t);
  for (const char* name : {"a", "b"})
    for (int s = 0; s < 2; ++s)
      for (int k = 0; k < 10; ++k)
        for (int p = 0; p < 8; ++p) {
          Vec3<double> nu{1.0, 0.1, 0.01};
          for (int i = 0; i < 3; ++i) nu(i) += 0.01 * stream.normal();
          rows.push_back(row(name, s, k, 10 * s + k, p, p, nu));
        }
  const std::vector<std::string> truths{folder.write("set/a.csv", truth), folder.write("set/b.csv", truth)};
  const auto joined = [&] {
    std::string text;
    for (const std::string& one : rows) text += one;
    return text;
  };
  const Scores first = evaluate_text(folder, joined(), truths).overall;
  stream.shuffle(rows);
  const Scores second = evaluate_text(folder, joined(), {truths[1], truths[0]}).overall;
  CHECK_THAT(second.L_eucl, WithinRel(first.L_eucl, 1e-12));
  CHECK_THAT(second.L_maha, WithinRel(first.L_maha, 1e-12));
  CHECK_THAT(second.correlation, WithinRel(first.correlation, 1e-12));
  CHECK_THAT(second.L_fit, WithinRel(first.L_fit, 1e-12));
  CHECK(second.sequences == 4);
}

TEST_CASE("scores: sets are distinguished by folder and by dataset.json, and overall weighs points alike",
          "[metrics]") {
  const Folder folder;
  const std::string truth = "t_s,u_mps,vm_mps,r_degps\n0,1,0,0\n1,1,0,0\n2,1,0,0\n";
  const std::string in_test = folder.write("test/truth/a.csv", truth), in_train = folder.write("train/b.csv", truth);
  folder.write("other/c.csv", truth);
  folder.write("other/truth/c.csv", "t_s,u_mps,vm_mps,r_degps\n0,1.5,0,0\n1,1.5,0,0\n");
  const std::string dataset =
      folder.write("other/dataset.json",
                   R"({"sets": [{"name": "held", "recordings": [{"file": "c.csv", "truth": "truth/c.csv"}]},
                   {"name": "rest", "recordings": [{"file": "d.csv"}]}]})");
  std::string rows;
  for (int k = 0; k < 3; ++k) rows += row("a", 0, k, k, 0, 0, {1.1, 0, 0});
  for (int k = 0; k < 3; ++k) rows += row("b", 0, k, k, 0, 0, {1.2, 0, 0});
  for (int k = 0; k < 2; ++k) rows += row("c", 0, k, k, 0, 0, {1.1, 0, 0});
  const Evaluation e = evaluate_text(folder, rows, {in_test, in_train, dataset + "#held"});
  REQUIRE(e.datasets.size() == 3);
  CHECK(e.datasets[0].name == "held");
  CHECK_THAT(e.datasets[0].L_eucl, WithinRel(0.16, 1e-12));  // against truth/c.csv, not against c.csv
  CHECK(e.datasets[1].name == "test");
  CHECK_THAT(e.datasets[1].L_eucl, WithinRel(0.01, 1e-12));
  CHECK(e.datasets[2].name == "train");
  CHECK_THAT(e.datasets[2].L_eucl, WithinRel(0.04, 1e-12));
  CHECK_THAT(e.overall.L_eucl, WithinRel((2 * 0.01 + 2 * 0.04 + 0.16) / 5.0, 1e-12));
  CHECK(e.overall.sampling == "single");
  CHECK(e.overall.steps == 3);
}

TEST_CASE("scores: the truth is met exactly, between samples linearly, and never outside", "[metrics]") {
  Trajectory truth;
  truth.file = "truth.csv";
  truth[Channel::t] = {1.0, 2.0, 4.0, 5.0};
  truth[Channel::u] = {0.3, 0.7, 1.7, kMissing};
  truth[Channel::vm] = {0.1, 0.2, 0.3, 0.4};
  truth[Channel::r] = {0.0, -0.1, -0.2, 0.3};
  CHECK(truth_at(truth, 2.0).nu == Vec3<double>(0.7, 0.2, -0.1));
  CHECK(truth_at(truth, 2.0 + 9e-7).nu == Vec3<double>(0.7, 0.2, -0.1));
  CHECK_THAT(truth_at(truth, 2.5).nu(0), WithinRel(0.95, 1e-14));
  CHECK_THAT(truth_at(truth, 3.5).nu(2), WithinRel(-0.175, 1e-14));
  CHECK(std::isnan(truth_at(truth, 4.5).nu(0)));
  CHECK(truth_at(truth, 4.0).nu(0) == 1.7);
  CHECK(std::isnan(truth_at(truth, 4.0).position(0)));
  CHECK(truth_at(truth, 5.0 + 9e-7).nu(1) == 0.4);
  CHECK_THROWS_AS(truth_at(truth, 5.01), InputError);
  CHECK_THROWS_WITH(truth_at(truth, 0.99), Catch::Contains("truth.csv") && Catch::Contains("1 to 5 s"));
}

TEST_CASE("scores: points without a truth sample are left out and counted", "[metrics]") {
  const Folder folder;
  const std::string truth = folder.write("t/a.csv", "t_s,u_mps,vm_mps,r_degps\n0,1,0,0\n1,,0,0\n2,1,0,0\n3,1.3,0,0\n");
  std::string rows;
  for (int k = 0; k < 4; ++k) rows += row("a", 0, k, k, 0, 0, {1.1, 0, 0});
  const Evaluation evaluation = evaluate_text(folder, rows, {truth});
  CHECK(evaluation.overall.missing_truth == 1);
  CHECK(evaluation.overall.points == 2);
  CHECK_THAT(evaluation.overall.L_eucl, WithinRel((0.01 + 0.04) / 2.0, 1e-12));
  CHECK(notices(evaluation).size() == 1);
}

TEST_CASE("scores: the sampling follows from the members of the particles", "[metrics]") {
  const Folder folder;
  const std::string truth = folder.write("t/a.csv", "t_s,u_mps,vm_mps,r_degps\n0,1,0,0\n1,1,0,0\n2,1,0,0\n");
  const auto sampling = [&](auto member, int particles) {
    std::string rows;
    for (int k = 0; k < 3; ++k)
      for (int p = 0; p < particles; ++p) rows += row("a", 0, k, k, p, member(k, p), {1.1, 0, 0});
    return evaluate_text(folder, rows, {truth}).overall.sampling;
  };
  CHECK(sampling([](int, int p) { return p; }, 4) == "ts-inf");
  CHECK(sampling([](int k, int p) { return (k + p) % 4; }, 4) == "ts1");
  CHECK(sampling([](int, int) { return 3; }, 4) == "single");
  CHECK(sampling([](int, int) { return 3; }, 1) == "single");
}

TEST_CASE("scores: a prediction folder may describe itself", "[metrics]") {
  const Folder folder;
  const std::string truth = folder.write("t/a.csv", "t_s,u_mps,vm_mps,r_degps\n0,1,0,0\n1,1,0,0\n");
  folder.write("pred/a.csv", kHeader + row("a", 0, 0, 0, 0, 0, {1, 0, 0}) + row("a", 0, 1, 1, 0, 0, {1, 0, 0}));
  folder.write("pred/prediction.json", R"({"sampling": "ts1", "members": 1, "provenance": {"tool": "ens-predict"}})");
  const PredictionSource source = find_predictions({folder / "pred"});
  REQUIRE(source.files.size() == 1);
  CHECK(source.provenance[0]["tool"] == "ens-predict");
  const Evaluation evaluation = evaluate(source, truths_by_name({truth}), ScoreOptions{});
  CHECK(evaluation.overall.sampling == "ts1");
  CHECK(input_files(source, evaluation).size() == 3);
  fs::create_directories(folder / "empty");
  CHECK_THROWS_WITH(find_predictions({folder / "empty"}), Catch::Contains("no CSV file"));
}

TEST_CASE("scores: predictions that do not hold together are refused", "[metrics]") {
  const Folder folder;
  const std::string truth_text = "t_s,u_mps,vm_mps,r_degps\n0,1,0,0\n1,1,0,0\n2,1,0,0\n";
  const std::string truth = folder.write("t/a.csv", truth_text);
  const Vec3<double> nu{1, 0, 0};
  std::string good;
  for (int k = 0; k < 3; ++k)
    for (int p = 0; p < 3; ++p) good += row("a", 0, k, k, p, p, nu);
  CHECK_NOTHROW(evaluate_text(folder, good, {truth}));
  const auto refused = [&](const std::string& rows, const std::string& because) {
    CHECK_THROWS_WITH(evaluate_text(folder, rows, {truth}), Catch::Contains(because));
  };
  refused(good + row("b", 0, 0, 0, 0, 0, nu), "prediction.csv:11: column 'recording': no truth for 'b'");
  refused(good + row("a", 0, 3, 2, 0, 0, nu), "step 3: expected each of the sequence's 3 particles once, found 1");
  refused(good + row("a", 0, 1, 1, 2, 2, nu), "step 1: expected each of the sequence's 3 particles once, found 4");
  refused(good.substr(0, good.rfind("a,")), "step 2: expected each of the sequence's 3 particles once, found 2");
  refused(good + row("a", 1, 0, 0, 0, 0, nu) + row("a", 1, 0, 0, 1, 0, nu) + row("a", 1, 1, 1, 0, 0, nu) +
              row("a", 1, 1, 1, 0, 0, nu),
          "some of one particle");
  refused(good + row("a", 0, 1, 1.5, 3, 2, nu), "prediction.csv:11: column 't_s'");
  refused(good + row("a", 1, 0, 2.5, 0, 0, nu), "the truth lasts from 0 to 2 s");
  refused("", "no data row");
  // An empty sequence of steps from a number that no file means.
  refused(row("a", 0, 2'000'000'000, 0, 0, 0, nu), "column 'step'");

  const std::string same = folder.write("u/a.csv", truth_text);
  CHECK_THROWS_WITH(truths_by_name({truth, same}), Catch::Contains("is the truth of recording 'a', and so is"));
  const std::string one = folder.write("one.csv", kHeader + good), two = folder.write("two.csv", kHeader + good);
  CHECK_THROWS_WITH(evaluate(find_predictions({one, two}), truths_by_name({truth}), ScoreOptions{}),
                    Catch::Contains("two.csv: predicts recording 'a'"));
}

TEST_CASE("scores: the number of threads leaves every bit alone", "[metrics]") {
  const Folder folder;
  RandomStream stream(8, "jobs");
  std::vector<std::string> truths;
  for (const char* name : {"a", "b", "c", "d", "e"}) {
    truths.push_back(
        folder.write(fmt::format("set/{}.csv", name), "t_s,u_mps,vm_mps,r_degps\n0,1,0,0\n1,1,0.1,0\n2,1.2,0,0.3\n"));
    std::string rows = kHeader;
    for (int k = 0; k < 3; ++k)
      for (int p = 0; p < 7; ++p) {
        const double a = stream.normal(), b = stream.normal(), c = stream.normal();
        rows += row(name, 0, k, k, p, p, Vec3<double>(a, b, c));
      }
    folder.write(fmt::format("pred/{}.csv", name), rows);
  }
  const auto text = [&](std::size_t jobs) {
    ScoreOptions options;
    options.jobs = jobs;
    const Evaluation e = evaluate(find_predictions({folder / "pred"}), truths_by_name(truths), options);
    return io::to_text(to_json(e)) + per_step_text(e);
  };
  CHECK(text(1) == text(5));
}
