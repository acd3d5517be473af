#include "gap/gap_explain.hpp"

#include <cmath>
#include <limits>
#include <map>
#include <set>

#include <catch2/catch.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "core/distributions.hpp"
#include "core/linear_algebra.hpp"
#include "core/random.hpp"
#include "core/units.hpp"
#include "dynamics/coefficient_law.hpp"
#include "dynamics/model_parts.hpp"
#include "gap/compare/comparison.hpp"
#include "gap/compare/current_course.hpp"
#include "gap/compare/terms.hpp"
#include "gap/perturbed_ship.hpp"
#include "gap/report/explain_json.hpp"
#include "gap/report/summary.hpp"
#include "gap/report/words.hpp"
#include "gap/show/free_runs.hpp"
#include "gap/show/next_maneuver.hpp"
#include "gap/simulated_campaign.hpp"

using namespace leeway;
using Catch::Matchers::Contains;

namespace {

gap::GapExplainOptions two_jobs() {
  gap::GapExplainOptions options;
  options.locate.jobs = 2;
  return options;
}

EffectEntry effect(std::string type, std::vector<std::pair<std::string, std::optional<double>>> parameters) {
  return {std::move(type), std::move(parameters), "ship.json", "/effects/0"};
}

// How far the tracks reach in a direction [m].
double farthest_towards(double direction_deg, const std::vector<Trajectory>& tracks) {
  const double along_x = std::cos(direction_deg * kDegree), along_y = std::sin(direction_deg * kDegree);
  double farthest = -std::numeric_limits<double>::infinity();
  for (const Trajectory& run : tracks)
    for (std::size_t i = 0; i < run.size(); ++i)
      farthest = std::max(farthest, along_x * run[Channel::x0][i] + along_y * run[Channel::y0][i]);
  return farthest;
}

const gap::Explained& found(const gap::Explanation& explanation, const std::string& name) {
  for (const gap::Explained& hypothesis : explanation.hypotheses)
    if (hypothesis.name == name) return hypothesis;
  FAIL("no hypothesis " << name);
  throw 0;
}

}  // namespace

TEST_CASE("gap-explain: a planted current is named, measured, and shown to help on other recordings", "[gap][long]") {
  Ship truth = test::perturbed_ship("esso-osaka-3m", 0.05, 1);
  truth.effects.push_back(effect("steady-current", {{"current_speed_mps", 0.05}, {"current_set_deg", 140.0}}));
  std::vector<Trajectory> recordings = test::recorded({"esso-osaka-3m", 1, 4, 200.0, 1.0, 0.5}, truth);
  std::vector<Trajectory> heldout = test::recorded({"esso-osaka-3m", 91, 2, 200.0, 1.0, 0.5}, truth);
  const Ship stated = read_ship("esso-osaka-3m");
  const gap::Explanation explanation = gap::gap_explain(stated, recordings, heldout, two_jobs());

  CHECK(explanation.verdict == gap::Verdict::mismatch);
  CHECK(explanation.chosen == std::vector<std::string>{"steady-current"});
  CHECK(explanation.hypotheses.front().name == "steady-current");
  CHECK(explanation.hypotheses.front().probability > 0.7);  // something else may act that does not show
  const gap::Explained& current = found(explanation, "steady-current");
  REQUIRE(current.parameters.size() == 2);
  CHECK(current.parameters[0].low < 0.05);
  CHECK(current.parameters[0].high > 0.05);
  CHECK(current.parameters[0].estimate == Approx(0.05).epsilon(0.05));
  // As far as Student's with four degrees of freedom.
  CHECK(current.parameters[0].high - current.parameters[0].low ==
        Approx(2.0 * 2.776 * current.parameters[0].sd).epsilon(0.1));
  CHECK(current.parameters[1].estimate == Approx(140.0).margin(5.0));
  // The simulator with the current follows recordings that nothing was fitted to.
  CHECK(explanation.heldout_is_given);
  const gap::Scores &before = explanation.heldout.before, &after = explanation.heldout.after;
  CHECK(after.free_runs.at(100).rmse_position_m < 0.5 * before.free_runs.at(100).rmse_position_m);
  CHECK(after.log_likelihood_per_sample > before.log_likelihood_per_sample);
  CHECK(explanation.heldout_gain > 2.0 * explanation.heldout_gain_sd);

  // ship.json is the ship's own with one effect more, and makes a model.
  REQUIRE(explanation.effects.size() == 1);
  const io::Json with = gap::ship_with(io::read_json(stated.file), explanation);
  CHECK(with["name"] == "esso-osaka-3m, fitted");
  CHECK(with["effects"].back()["type"] == "steady-current");
  CHECK(with["effects"].back()["current_speed_mps"].get<double>() == current.parameters[0].estimate);

  const std::string text = gap::summary(explanation);
  CHECK_THAT(text, Contains("MISMATCH"));
  CHECK_THAT(text, Contains("A current of 0.0500 m/s towards 140 deg"));
  CHECK_THAT(text, Contains("current_speed_mps"));
  const io::Json json = gap::to_json(explanation);
  CHECK(json["chosen"] == io::Json{"steady-current"});
  CHECK(json["fit"]["heldout"]["after"]["rmse_position_m"].get<double>() == after.free_runs.at(100).rmse_position_m);
  CHECK(json["hypotheses"][0]["parameters"]["current_set_deg"]["unit"] == "deg");
  REQUIRE(json["sets"].size() > json["hypotheses"].size());
  CHECK(json["sets"][0]["names"] == io::Json{"steady-current"});
  CHECK(json["sets"][0]["in_95"] == true);
  // What was not fitted is one of these with one effect more, which has a name.
  double included = 0.0, fitted = 0.0;
  for (const io::Json& hypothesis : json["hypotheses"]) {
    fitted += hypothesis["probability"].get<double>();
    for (const io::Json& name : hypothesis["effects"])
      if (name == "steady-current") included += hypothesis["probability"].get<double>();
  }
  CHECK(fitted < 0.99);
  const double with_more = json["inclusion"]["steady-current"].get<double>();
  CHECK(with_more > included);
  CHECK(with_more <= 1.0);
  double others = 0.0;
  for (const auto& [name, probability] : json["inclusion"].items())
    if (name != "steady-current" && !name.starts_with("coefficient:")) others += probability.get<double>();
  CHECK(others > 1.0 - fitted);
  for (const auto& [module, gain] : json["modules"].items()) CHECK(module != "steady-current");
}

TEST_CASE("gap-explain: where nothing is missing nothing is chosen, and wrong coefficients alone are mended",
          "[gap][long]") {
  std::vector<Trajectory> none;
  std::vector<Trajectory> recordings =
      test::recorded({"esso-osaka-3m", 3, 4, 200.0, 1.0, 0.5}, test::perturbed_ship("esso-osaka-3m", 0.1, 9));
  const Ship stated = read_ship("esso-osaka-3m");
  const gap::Explanation explanation = gap::gap_explain(stated, recordings, none, two_jobs());
  CHECK(explanation.verdict == gap::Verdict::no_mismatch);
  CHECK(explanation.chosen.empty());
  CHECK(explanation.effects.empty());
  CHECK(explanation.hypotheses.front().name == "none");
  io::Json with = gap::ship_with(io::read_json(stated.file), explanation);
  CHECK(with.contains("coefficient_factors"));
  with.erase("coefficient_factors");
  CHECK(with["name"] == "esso-osaka-3m, fitted");
  with["name"] = stated.name;
  CHECK(with == io::read_json(stated.file));
  const double before = explanation.heldout.before.free_runs.at(100).rmse_position_m;
  CHECK(explanation.heldout.after.free_runs.at(100).rmse_position_m < 0.8 * before);
}

TEST_CASE("gap-explain: a resistance that is off is told as such, and nothing where the file is right", "[gap][long]") {
  const Ship stated = read_ship("esso-osaka-3m");
  Ship truth = stated;
  truth.multiply({{"hull.resistance", 0.8}});
  for (const bool is_off : {true, false}) {
    CAPTURE(is_off);
    std::vector<Trajectory> none,
        recordings = test::recorded({"esso-osaka-3m", 5, 4, 200.0, 1.0, 0.5}, is_off ? truth : stated);
    const gap::Explanation explanation = gap::gap_explain(stated, recordings, none, two_jobs());
    CHECK(explanation.verdict == gap::Verdict::no_mismatch);
    const gap::ShipFile& file = explanation.ship_file;
    CAPTURE(file.sentence);
    CHECK(file.modules.size() == 6);  // inertia, hull, propeller, rudder, thruster, wind
    if (!is_off) {
      CHECK(file.state == gap::ShipFileState::as_stated);
      CHECK(file.findings.empty());
      CHECK_THAT(gap::headline(explanation), Contains("the ship file agrees"));
      continue;
    }
    CHECK(file.state == gap::ShipFileState::off);
    // Resistance or thrust: from recordings of a ship that keeps its revolutions nobody knows.
    REQUIRE(!file.off.empty());
    const gap::CalibratedModule& module = file.off.front();
    CHECK((module.name == "hull" || module.name == "propeller"));
    const auto change = std::find_if(module.changes.begin(), module.changes.end(), [](const gap::ModuleChange& c) {
      return c.quantity == "resistance" || c.quantity == "thrust";
    });
    REQUIRE(change != module.changes.end());
    const double truly = change->quantity == "resistance" ? 0.8 : 1.25;
    CHECK(change->by.low < 1.02 * truly);
    CHECK(change->by.high > 0.98 * truly);
    CHECK_THAT(gap::headline(explanation),
               Contains("No missing physics; the ship file is off") && Contains("with ship.json errors fall"));
    const io::Json json = to_json(explanation);
    CHECK(json["ship_file"]["state"] == "off");
    CHECK(json["modules"]["hull"].get<double>() > 10.0);
  }
}

TEST_CASE("gap-explain: coefficients with which held-out recordings get worse are not written", "[gap][long]") {
  std::vector<Trajectory> recordings =
      test::recorded({"esso-osaka-3m", 3, 4, 200.0, 1.0, 0.5}, test::perturbed_ship("esso-osaka-3m", 0.1, 9));
  const Ship stated = read_ship("esso-osaka-3m");
  std::vector<Trajectory> of_stated = test::recorded({"esso-osaka-3m", 91, 2, 200.0, 1.0, 0.5}, stated);
  const gap::Explanation explanation = gap::gap_explain(stated, recordings, of_stated, two_jobs());
  CHECK(explanation.coefficient_factors.empty());
  CHECK(gap::ship_with(io::read_json(stated.file), explanation) == io::read_json(stated.file));
  CHECK(gap::log_error(explanation.heldout.after) == gap::log_error(explanation.heldout.before));
  CHECK_THAT(fmt::format("{}", fmt::join(explanation.notices, "\n")), Contains("no coefficients fitted anew"));
}

TEST_CASE("gap-explain: an effect with which held-out recordings get worse is named and not written", "[gap][long]") {
  const Ship stated = read_ship("esso-osaka-3m");
  Ship pushed = stated;
  pushed.effects.push_back(effect("body-force", {{"X_N", 0.0}, {"Y_N", 0.6}, {"N_Nm", 0.3}}));
  std::vector<Trajectory> recordings = test::recorded({"esso-osaka-3m", 3, 4, 200.0, 1.0, 0.5}, pushed);
  std::vector<Trajectory> of_stated = test::recorded({"esso-osaka-3m", 91, 2, 200.0, 1.0, 0.5}, stated);
  const gap::Explanation explanation = gap::gap_explain(stated, recordings, of_stated, two_jobs());
  CHECK(explanation.verdict == gap::Verdict::mismatch);
  CHECK(explanation.chosen == std::vector<std::string>{"body-force"});
  CHECK(explanation.withheld == explanation.chosen);
  CHECK(explanation.effects.empty());
  CHECK(gap::log_error(explanation.heldout.after) < gap::log_error(explanation.heldout.before) + 0.06);
  CHECK_THAT(fmt::format("{}", fmt::join(explanation.notices, "\n")), Contains("ship.json has no body-force"));
  CHECK_THAT(gap::summary(explanation), Contains("what was different in the held-out recordings"));
}

TEST_CASE("gap-explain: a calibration has the coefficients of the true ship within what it leaves open",
          "[gap][long]") {
  const Ship stated = read_ship("esso-osaka-3m");
  RandomStream random(4, "a ship of the stated law");
  Ship truth = stated;
  std::map<std::string, double> planted;
  for (const UncertainCoefficient& c : coefficient_law(stated).coefficients) {
    if (c.is_absolute) continue;
    planted[c.name] = c.sd * random.normal();
    truth.multiply({{c.name, std::exp(planted[c.name])}});
  }
  std::vector<Trajectory> none, recordings = test::recorded({"esso-osaka-3m", 5, 4, 200.0, 1.0, 0.5}, truth);
  gap::GapExplainOptions options = two_jobs();
  options.calibrates = true;
  const gap::Explanation explanation = gap::gap_explain(stated, recordings, none, options);
  CHECK(explanation.chosen.empty());
  CHECK(explanation.hypotheses.empty());  // none was asked for
  REQUIRE(explanation.calibration);
  CHECK(explanation.calibration->scale > 0.5);
  CHECK(explanation.calibration->scale < 2.0);
  CHECK_THAT(gap::headline(explanation), Contains("coefficients were fitted") && Contains("errors of free runs fall"));

  const io::Json json = gap::ship_with(io::read_json(stated.file), explanation);
  const Ship fitted = parse_ship(json, "ship.json");
  REQUIRE(fitted.coefficient_covariance);
  const Ship::JointUncertainty& joint = *fitted.coefficient_covariance;
  REQUIRE(joint.names.size() == coefficient_law(stated).coefficients.size());
  const auto n = static_cast<Eigen::Index>(joint.names.size());
  Eigen::VectorXd off(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const std::string& name = joint.names[static_cast<std::size_t>(i)];
    const io::Json& factors = json["coefficient_factors"];
    off[i] = std::log(factors.value(name, 1.0)) - planted[name];
  }
  // Chi-squared with n degrees of freedom if the posterior is right; far more if it claims too much.
  CHECK(off.dot(joint.matrix.llt().solve(off)) < 2.0 * static_cast<double>(n));
  CHECK(joint.matrix.diagonal().minCoeff() < 1e-3);  // and it knows something
}

TEST_CASE("free runs: a simulator follows its own recordings as well as their noise lets it start", "[gap][long]") {
  const Ship ship = read_ship("esso-osaka-3m");
  gap::Campaign campaign = gap::prepare(ship, test::recorded({"esso-osaka-3m", 5, 1, 310.0, 1.0, 0.5}, ship), {});
  gap::FitOptions options;
  const gap::FittedNull fit = gap::fit_null(campaign, options);
  const std::vector<gap::Run> runs = gap::whole_runs(campaign);
  const gap::Scores exact = gap::free_runs(campaign, fit.smoothed, {{ship, runs}}, 1);
  CHECK(exact.free_runs.at(30).rmse_u_mps == Approx(0.01).epsilon(0.2));  // the noise of the recording
  CHECK(exact.free_runs.at(30).rmse_r_degps == Approx(0.1).epsilon(0.25));
  CHECK(exact.free_runs.at(100).rmse_position_m < 0.5);
  Ship other = ship;
  other.effects.push_back(effect("steady-current", {{"current_speed_mps", 0.1}, {"current_set_deg", 0.0}}));
  const gap::Scores wrong = gap::free_runs(campaign, fit.smoothed, {{other, runs}}, 1);
  CHECK(wrong.free_runs.at(100).rmse_position_m > 3.0 * exact.free_runs.at(100).rmse_position_m);
  CHECK(wrong.by_recording.size() == 1);
  CHECK(gap::coverage(fit.smoothed, runs).at(95) == Approx(0.95).margin(0.02));
  CHECK(gap::coverage(fit.smoothed, runs).at(50) == Approx(0.5).margin(0.05));
}

TEST_CASE("next maneuver: the certainty to be expected of two equal alternatives is the normal distribution's",
          "[gap]") {
  for (const double distance : {0.0, 1.0, 2.0, 4.0, 10.0}) {
    CAPTURE(distance);
    Eigen::MatrixXd apart = Eigen::MatrixXd::Zero(2, 2);
    apart(0, 1) = apart(1, 0) = distance * distance;
    // The more probable one is right as often as noise does not carry it over the middle.
    const double right = 0.5 * std::erfc(-0.5 * distance / std::sqrt(2.0));
    CHECK(gap::expected_certainty(apart, {0.5, 0.5}, 1) == Approx(right).margin(0.01));
  }
  // Where nothing can be distinguished it stays as it is.
  CHECK(gap::expected_certainty(Eigen::MatrixXd::Zero(3, 3), {0.2, 0.7, 0.1}, 1) == Approx(0.7).epsilon(1e-9));
}

TEST_CASE("next maneuver: a crash stop, no zigzag, shows whether a propeller gives less or a hull resists more",
          "[gap][long]") {
  Ship truth = read_ship("esso-osaka-3m");
  truth.effects.push_back(effect("fouling", {{"resistance_increase", 0.5}}));
  const Ship stated = read_ship("esso-osaka-3m");
  gap::Campaign campaign = gap::prepare(stated, test::recorded({"esso-osaka-3m", 4, 2, 200.0, 1.0, 0.5}, truth), {});
  gap::FitOptions options;
  options.jobs = 2;
  gap::Comparison comparison(campaign, gap::fit_null(campaign, options), {0.01, 2});
  std::vector<const gap::Fitted*> possible;
  for (const char* name : {"fouling", "thrust-loss"}) comparison.add(0, comparison.starts_with(0, name, {}));
  REQUIRE(comparison.all().size() == 3);
  for (std::size_t i : {1, 2}) possible.push_back(&comparison.all()[i]);
  // A fifth of the probability is of what was not fitted.
  const gap::NextPlan plan = gap::plan_maneuvers(campaign, possible, {0.4, 0.4}, {}, 2, 1);
  REQUIRE(plan.maneuvers.size() >= 12);
  CHECK(plan.p_reachable == Approx(0.8));
  std::map<std::string, double> right;
  for (const gap::NextManeuver& maneuver : plan.maneuvers) {
    CHECK(maneuver.p_right >= 0.4 - 1e-9);
    CHECK(maneuver.p_right <= 0.8 + 1e-9);
    right[maneuver.name] = maneuver.p_right;
    CHECK_THAT(maneuver.command, Contains(" --duration-s "));
  }
  for (const char* zigzag : {"a zigzag 10/10", "a zigzag 20/20"}) CHECK(right.at("a crash stop") > right.at(zigzag));
  CHECK(right.contains("astern from rest, rudders amidships"));
  CHECK(right.contains("a straight run and its reciprocal, at 50 % speed"));
  for (const gap::NextSequence& both : plan.sequences) {
    const auto [first, second] = both.maneuvers;
    CHECK(both.p_right > std::max(plan.maneuvers[first].p_right, plan.maneuvers[second].p_right));
    CHECK(both.duration_s == plan.maneuvers[first].duration_s + plan.maneuvers[second].duration_s);
  }
  // Both can be told by something that was not recorded.
  REQUIRE_FALSE(plan.records.empty());
  std::set<std::string> told;
  for (const gap::NextRecord& record : plan.records) {
    told.insert(record.what);
    CHECK(record.p_right == Approx(0.8).epsilon(1e-6));
  }
  CHECK(told == std::set<std::string>{"how fouled the hull is", "the propeller's thrust"});
}

TEST_CASE("next maneuver: limits of area, rudder, time and depth hold in what is advised", "[gap][show][long]") {
  const Ship ship = read_ship("esso-osaka-3m");
  Ship truth = ship;
  truth.effects.push_back(effect("shallow-water", {{"h_over_T", 1.4}}));
  const gap::Campaign campaign =
      gap::prepare(ship, test::recorded({"esso-osaka-3m", 4, 2, 200.0, 1.0, 0.5}, truth), {});
  gap::FitOptions options;
  options.jobs = 2;
  gap::Comparison comparison(campaign, gap::fit_null(campaign, options), {0.01, 2});
  std::vector<const gap::Fitted*> possible;
  for (const char* name : {"shallow-water", "draft"}) comparison.add(0, comparison.starts_with(0, name, {}));
  for (std::size_t i : {1, 2}) possible.push_back(&comparison.all()[i]);
  const auto planned = [&](const gap::NextLimits& limits) {
    return gap::plan_maneuvers(campaign, possible, {0.5, 0.5}, limits, 2, 1);
  };
  const auto named = [](const gap::NextPlan& plan, const std::string& part) {
    const auto found =
        std::ranges::find_if(plan.maneuvers, [&](const gap::NextManeuver& one) { return one.name == part; });
    return found == plan.maneuvers.end() ? nullptr : &*found;
  };
  const gap::NextPlan free = planned({});
  const double L = ship.particulars.L_pp, straight_s = named(free, "a straight run and its reciprocal")->duration_s;

  gap::NextLimits area;
  area.length_m = 8.0 * L, area.width_m = 2.0 * L;
  const gap::NextPlan small = planned(area);
  const gap::NextManeuver* straight = named(small, "a straight run and its reciprocal");
  REQUIRE(straight != nullptr);
  CHECK(straight->duration_s < straight_s);
  CHECK(straight->duration_s > straight_s / 4.0);
  for (const gap::NextManeuver& one : small.maneuvers) CHECK(one.duration_s <= named(free, one.name)->duration_s);

  gap::NextLimits time;
  time.time_s = 150.0;
  const gap::NextPlan fast = planned(time);
  REQUIRE_FALSE(fast.maneuvers.empty());
  for (const gap::NextManeuver& one : fast.maneuvers) CHECK(one.duration_s <= 150.0);
  for (const gap::NextSequence& both : fast.sequences) CHECK(both.duration_s <= 150.0);

  gap::NextLimits rudder;
  rudder.rudder_deg = 15.0;
  const gap::NextPlan gentle = planned(rudder);
  CHECK(named(gentle, "turning circles, 15 deg to both sides") != nullptr);
  CHECK(named(gentle, "turning circles, 35 deg to both sides") == nullptr);
  CHECK(named(gentle, "a zigzag 15/15") != nullptr);

  // In deep water a ship that was slow by its depth is as its file says, and one that is deeper is not.
  gap::NextLimits deep;
  deep.depth_m = 30.0 * ship.particulars.d;
  CHECK(planned(deep).maneuvers.front().p_right > 0.98);
}

TEST_CASE("gap-explain: a wind that nobody recorded is another one in each recording", "[gap][slow]") {
  // Of zigzags alone, and of four kinds of maneuvers.
  const bool are_zigzags = GENERATE(true, false);
  CAPTURE(are_zigzags);
  std::vector<Trajectory> recordings, none;
  const std::pair<double, double> winds[] = {{2.5, 30.0}, {1.5, 200.0}, {3.0, 300.0}, {2.0, 120.0}};
  for (std::uint64_t i = 0; i < std::size(winds); ++i) {
    Ship truth = test::perturbed_ship("vectwin-3m", 0.05, 7);
    truth.effects.push_back(
        effect("unmeasured-wind", {{"wind_speed_mps", winds[i].first}, {"wind_dir_deg", winds[i].second}}));
    std::vector<Trajectory> runs =
        test::recorded({"vectwin-3m", 20 + i, are_zigzags ? 1U : 4U, 200.0, 1.0, 0.0}, truth);
    Trajectory& recording = runs[are_zigzags ? 0 : i];
    recording.name = recording.file = "run" + std::to_string(i);
    recordings.push_back(std::move(recording));
  }
  const gap::Explanation explanation = gap::gap_explain(read_ship("vectwin-3m"), recordings, none, two_jobs());
  CHECK(explanation.chosen == std::vector<std::string>{"unmeasured-wind"});
  const gap::Explained& wind = found(explanation, "unmeasured-wind");
  REQUIRE(explanation.effects_in.size() == 4);
  for (std::size_t i = 0; i < std::size(winds); ++i)
    for (const gap::ExplainedParameter& p : wind.parameters)
      if (p.recording == "run" + std::to_string(i)) {
        CAPTURE(p.recording, p.name, p.estimate, p.sd);
        if (p.name == "wind_speed_mps") CHECK(std::abs(p.estimate - winds[i].first) < 4.0 * p.sd + 0.1);
        if (p.name == "wind_dir_deg")
          CHECK(std::abs(std::remainder(p.estimate - winds[i].second, 360.0)) < 4.0 * p.sd + 5.0);
      }
}

TEST_CASE("gap-explain: a current that varies is named, and its path is what it was", "[gap][slow]") {
  Ship truth = read_ship("vectwin-3m");
  truth.effects.push_back(effect("varying-current", {{"current_sd_mps", 0.05}, {"tau_s", 200.0}, {"seed", 3.0}}));
  std::vector<Trajectory> none, recordings = test::recorded({"vectwin-3m", 11, 3, 300.0, 1.0, 0.5}, truth);
  const gap::Explanation explanation = gap::gap_explain(read_ship("vectwin-3m"), recordings, none, two_jobs());
  REQUIRE(explanation.chosen == std::vector<std::string>{"varying-current"});
  const std::vector<gap::ExplainedParameter>& process = found(explanation, "varying-current").parameters;
  REQUIRE(process.size() == 2);
  CHECK(process[0].name == "current_sd_mps");
  CHECK((process[0].low < 0.05 && 0.05 < process[0].high));
  CHECK(process[1].name == "tau_s");
  CHECK((process[1].low < 200.0 && 200.0 < process[1].high));

  REQUIRE(explanation.current_paths.size() == recordings.size());
  const Effects<double> effects(truth);
  for (const gap::CurrentPath& path : explanation.current_paths) {
    double squares = 0.0;
    for (std::size_t i = 0; i < path.t_s.size(); ++i) {
      Situation<double> at{path.t_s[i],          Vec3<double>::Zero(), 1.0, 0.0, Vec3<double>::Zero(),
                           Vec3<double>::Zero(), Vec2<double>::Zero()};
      squares += (effects.water(at).velocity - path.velocity_mps[i]).squaredNorm() / 2.0;
    }
    CHECK(std::sqrt(squares / static_cast<double>(path.t_s.size())) < 0.015);
  }
  CHECK_THAT(gap::path_text(explanation.current_paths.front()), Contains("t_s,current_north_mps,current_east_mps,"));
}

TEST_CASE("current course: the process is that of the courses", "[gap]") {
  const Ship ship = read_ship("esso-osaka-3m");
  gap::Campaign campaign;
  campaign.ship = ship;
  campaign.stretches.resize(1);
  for (int k = 0; k <= 300; ++k) campaign.stretches[0].t_s.push_back(1000.0 + k);
  const gap::FreeEffect course("varying-current", ship, gap::current_course(campaign));
  CHECK(course.size() == 8);
  // What is believed before: the prior's own median.
  const auto before = gap::current_process(ship, {}, {}, {});
  CHECK(before[0].estimate == Approx(0.04 * std::sqrt(2.0 * std::log(2.0))).epsilon(0.05));
  CHECK(before[1].estimate == Approx(450.0).epsilon(0.05));
  // Courses of a process, known to a mm/s; the second is far faster than was believed before.
  const auto [sd_mps, tau_s] = GENERATE(std::pair(0.05, 100.0), std::pair(0.01, 25.0));
  CAPTURE(sd_mps, tau_s);
  int sd_covered = 0, tau_covered = 0;
  for (int n = 0; n < 20; ++n) {
    const std::vector<gap::FreeEffect> courses(3, course);
    Eigen::VectorXd mean(24);
    const Eigen::VectorXd unit = [&] {
      const std::vector<double> values = course.values(Eigen::VectorXd::Ones(8));
      return Eigen::VectorXd(Eigen::Map<const Eigen::VectorXd>(values.data() + 5, 8));
    }();
    for (int c = 0; c < 3; ++c) {
      const Effects<double> effects([&] {
        Ship with = ship;
        with.effects.push_back(
            effect("varying-current", {{"current_sd_mps", sd_mps}, {"tau_s", tau_s}, {"seed", 1.0 + 3 * n + c}}));
        return with;
      }());
      Eigen::VectorXd cosines = Eigen::VectorXd::Zero(8);
      for (int i = 0; i < 300; ++i) {
        Situation<double> at{
            i + 0.5, Vec3<double>::Zero(), 1.0, 0.0, Vec3<double>::Zero(), Vec3<double>::Zero(), Vec2<double>::Zero()};
        for (int k = 0; k < 4; ++k)
          cosines.segment<2>(2 * k) +=
              (k == 0 ? 1.0 : 2.0) / 300.0 * std::cos(kPi * k * (i + 0.5) / 300.0) * effects.water(at).velocity;
      }
      mean.segment<8>(8 * c) = cosines.cwiseQuotient(unit);
    }
    const Eigen::MatrixXd covariance =
        (0.001 * unit.cwiseInverse()).replicate(3, 1).cwiseAbs2().asDiagonal().toDenseMatrix();
    const auto process = gap::current_process(ship, courses, mean, covariance);
    sd_covered += process[0].low < sd_mps && sd_mps < process[0].high;
    tau_covered += process[1].low < tau_s && tau_s < process[1].high;
  }
  CHECK(sd_covered >= 17);
  CHECK(tau_covered >= 17);
}

TEST_CASE("gap-explain: a tug beside another effect is named, and known when it pulled", "[gap][slow]") {
  std::vector<Trajectory> recordings, none;
  for (std::uint64_t i = 0; i < 3; ++i) {
    Ship truth = test::perturbed_ship("vectwin-3m", 0.05, 9);
    truth.effects.push_back(effect("rudder-offset", {{"rudder_offset_deg", 3.0}}));
    if (i == 1)
      truth.effects.push_back(effect(
          "tug", {{"force_N", 1.0}, {"direction_deg", 290.0}, {"x_m", 1.2}, {"t_start_s", 71.0}, {"t_end_s", 113.0}}));
    for (Trajectory& recording : test::recorded({"vectwin-3m", 50 + i, 1, 200.0, 1.0, 0.0}, truth)) {
      recording.name = recording.file = "run" + std::to_string(i);
      recordings.push_back(std::move(recording));
    }
  }
  const gap::Explanation explanation = gap::gap_explain(read_ship("vectwin-3m"), recordings, none, two_jobs());
  const std::set<std::string> chosen(explanation.chosen.begin(), explanation.chosen.end());
  CHECK(chosen == std::set<std::string>{"rudder-offset", "tug"});
  const auto in = explanation.effects_in.find("run1");
  REQUIRE(in != explanation.effects_in.end());
  for (const EffectEntry& entry : in->second)
    for (const auto& [name, value] : entry.parameters) {
      CAPTURE(entry.type, name, *value);
      if (name == "force_N") CHECK(*value == Approx(1.0).epsilon(0.2));
      if (name == "direction_deg") CHECK(*value == Approx(290.0).margin(15.0));
      if (name == "t_start_s") CHECK(*value == Approx(71.0).margin(4.0));
      if (name == "t_end_s") CHECK(*value == Approx(113.0).margin(4.0));
    }
}

TEST_CASE("gap-explain: a tug in each recording is reported by recording, and leaves nothing", "[gap][slow]") {
  std::vector<Trajectory> recordings, none;
  const double directions_deg[] = {80.0, 120.0, 80.0}, ends_s[] = {150.0, 133.0, 162.0};
  for (std::uint64_t i = 0; i < 3; ++i) {
    Ship truth = test::perturbed_ship("esso-osaka-3m", 0.05, 9);
    truth.effects.push_back(effect("tug", {{"force_N", 1.0},
                                           {"direction_deg", directions_deg[i]},
                                           {"x_m", 1.0},
                                           {"t_start_s", 100.0},
                                           {"t_end_s", ends_s[i]}}));
    for (Trajectory& recording : test::recorded({"esso-osaka-3m", 70 + i, 1, 200.0, 1.0, 0.0}, truth)) {
      recording.name = recording.file = "run" + std::to_string(i);
      recordings.push_back(std::move(recording));
    }
  }
  const gap::Explanation explanation = gap::gap_explain(read_ship("esso-osaka-3m"), recordings, none, two_jobs());
  CHECK(explanation.chosen == std::vector<std::string>{"tug"});
  std::size_t directions = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string run = "run" + std::to_string(i);
    for (const gap::ExplainedParameter& p : found(explanation, "tug").parameters)
      if (p.recording == run && p.name == "direction_deg") {
        CAPTURE(run, p.estimate);
        CHECK(std::abs(std::remainder(p.estimate - directions_deg[i], 360.0)) < 8.0);
        ++directions;
      } else if (p.recording == run && p.name == "t_end_s") {
        CHECK(p.estimate == Approx(ends_s[i]).margin(2.0));
      }
    for (const EffectEntry& entry : explanation.effects_in.at(run))
      for (const auto& [name, value] : entry.parameters) {
        CAPTURE(run, name, *value);
        if (name == "t_start_s") CHECK(*value == Approx(100.0).margin(2.0));
        if (name == "t_end_s") CHECK(*value == Approx(ends_s[i]).margin(2.0));
      }
  }
  CHECK(directions == 3);
}

TEST_CASE("gap-explain: a quay that the hull touches is found where it is", "[gap][slow]") {
  Ship truth = test::perturbed_ship("esso-osaka-3m", 0.05, 4);
  const Ship stated = read_ship("esso-osaka-3m");
  const test::SimulatedCampaign campaign{"esso-osaka-3m", 61, 3, 200.0, 1.0, 0.0};
  // Where some hull goes farthest in a direction that is none of those that are tried, 0.3 m before that.
  const double direction_deg = 97.0, farthest = farthest_towards(direction_deg, test::fine_truth(campaign, truth));
  const double wall_m = farthest - 0.3;
  truth.effects.push_back(
      effect("fender", {{"wall_distance_m", wall_m}, {"wall_direction_deg", direction_deg}, {"stiffness_npm", 200.0}}));
  std::vector<Trajectory> recordings = test::recorded(campaign, truth), none;
  const gap::Explanation explanation = gap::gap_explain(stated, recordings, none, two_jobs());
  CHECK(explanation.chosen == std::vector<std::string>{"fender"});
  for (const gap::ExplainedParameter& p : found(explanation, "fender").parameters) {
    CAPTURE(p.name, p.estimate, p.sd);
    if (p.name == "wall_distance_m") CHECK(p.estimate == Approx(wall_m).margin(0.1));
    if (p.name == "wall_direction_deg") {
      CHECK(p.estimate == Approx(direction_deg).margin(2.0));
      CHECK(std::abs(p.estimate - direction_deg) < 8.0 * p.sd);  // the sd is not of a wall that leaves the hull
    }
    // A contact of a second between two samples says little: it comes out too soft.
    if (p.name == "stiffness_npm") CHECK(p.estimate == Approx(200.0).epsilon(0.3));
  }
}

TEST_CASE("gap-explain: a bank that is passed once is found where it is", "[gap][slow]") {
  Ship truth = test::perturbed_ship("vectwin-3m", 0.05, 4);
  const test::SimulatedCampaign campaign{"vectwin-3m", 61, 3, 200.0, 1.0, 0.0};
  const double direction_deg = 32.0, farthest = farthest_towards(direction_deg, test::fine_truth(campaign, truth));
  truth.effects.push_back(effect(
      "bank",
      {{"wall_distance_m", farthest + 1.0}, {"wall_direction_deg", direction_deg}, {"C_Y", 0.5}, {"C_N", 0.08}}));
  std::vector<Trajectory> recordings = test::recorded(campaign, truth), none;
  const gap::Explanation explanation = gap::gap_explain(read_ship("vectwin-3m"), recordings, none, two_jobs());
  CHECK(explanation.chosen == std::vector<std::string>{"bank"});
  for (const gap::ExplainedParameter& p : found(explanation, "bank").parameters) {
    CAPTURE(p.name, p.estimate, p.sd);
    if (p.name == "wall_distance_m") CHECK(p.estimate == Approx(farthest + 1.0).margin(1.5));
    if (p.name == "wall_direction_deg") CHECK(p.estimate == Approx(direction_deg).margin(4.0));
  }
}

TEST_CASE("gap-explain: a mooring line is found with its anchor and its slack", "[gap][slow]") {
  Ship truth = test::perturbed_ship("esso-osaka-3m", 0.05, 4);
  truth.effects.push_back(effect("mooring", {{"anchor_x_m", 10.0},
                                             {"anchor_y_m", 8.0},
                                             {"stiffness_npm", 0.2},
                                             {"slack_length_m", 6.0},
                                             {"attach_x_m", 0.0},
                                             {"attach_y_m", 0.0}}));
  std::vector<Trajectory> recordings = test::recorded({"esso-osaka-3m", 62, 3, 200.0, 1.0, 0.0}, truth), none;
  const gap::Explanation explanation = gap::gap_explain(read_ship("esso-osaka-3m"), recordings, none, two_jobs());
  CHECK(explanation.chosen == std::vector<std::string>{"mooring"});
  for (const gap::ExplainedParameter& p : found(explanation, "mooring").parameters) {
    CAPTURE(p.name, p.estimate, p.sd);
    if (p.name == "anchor_x_m") CHECK(p.estimate == Approx(10.0).margin(1.0));
    if (p.name == "anchor_y_m") CHECK(p.estimate == Approx(8.0).margin(1.0));
    if (p.name == "slack_length_m") CHECK(p.estimate == Approx(6.0).margin(1.0));
    if (p.name == "stiffness_npm") CHECK(p.estimate == Approx(0.2).epsilon(0.1));
  }
}

TEST_CASE("gap-explain: a filter is told from a latency where it is long enough, and else not stated as one of them",
          "[gap][long]") {
  const Ship ship = read_ship("vectwin-3m");
  for (const double filter_s : {0.25, 0.75}) {
    CAPTURE(filter_s);
    test::Injected fault;
    fault.filter_s = filter_s;
    std::vector<Trajectory> recordings = test::recorded({.seed = 41, .recordings = 3}, ship, fault), none;
    const gap::Explanation explanation = gap::gap_explain(ship, recordings, none, two_jobs());
    REQUIRE(explanation.chosen.size() == 1);
    const bool is_filter = explanation.chosen.front() == "sensor-filter";
    const gap::Explained& best = explanation.hypotheses.front();
    CHECK(best.effects == explanation.chosen);
    CHECK(best.separating_maneuver.find("zigzags") != std::string::npos);
    CHECK(best.parameters.front().estimate == Approx(filter_s).margin(0.1));
    CHECK_THAT(best.sentence, Contains(fmt::format("{:.2f} s (sd", best.parameters.front().estimate)));
    if (filter_s == 0.75) {
      CHECK(is_filter);
      continue;
    }
    if (!is_filter) CHECK(explanation.chosen.front() == "velocity-latency");
    const gap::Explained& other = found(explanation, is_filter ? "velocity-latency" : "sensor-filter");
    CHECK(other.probability > 0.05);
    CHECK(other.parameters.front().estimate == Approx(filter_s).margin(0.1));
    CHECK(explanation.p_right < 0.8);
  }
}

TEST_CASE("gap-explain: what the catalogue does not hold is not called by the name of what is next to it",
          "[gap][slow]") {
  Ship truth = test::perturbed_ship("esso-osaka-3m", 0.05, 3);
  truth.effects.push_back(effect("unknown", {{"X_sqrt_u", -0.004}}));  // a drag that a constant force nearly explains
  std::vector<Trajectory> recordings = test::recorded({"esso-osaka-3m", 31, 4, 250.0, 1.0, 0.5}, truth), none;
  const gap::Explanation explanation = gap::gap_explain(read_ship("esso-osaka-3m"), recordings, none, two_jobs());
  CHECK(explanation.verdict == gap::Verdict::mismatch);
  CHECK(explanation.chosen == std::vector<std::string>{"unknown"});
  CHECK(explanation.hypotheses.front().name == "unknown");
  CHECK(explanation.hypotheses.front().parameters.size() <= 3);
}
