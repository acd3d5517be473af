#include <algorithm>
#include <cstdlib>
#include <sstream>

#include <catch2/catch.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/units.hpp"
#include "gap/report/locate_json.hpp"
#include "gap/report/reasons.hpp"
#include "gap/report/report_html.hpp"
#include "gap/report/residual_csv.hpp"
#include "gap/report/summary.hpp"
#include "gap/report/words.hpp"
#include "gap/synthetic_findings.hpp"
#include "io/csv.hpp"
#include "io/trajectory_csv.hpp"
#include "temporary_folder.hpp"

using namespace leeway;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinRel;

namespace {

// What one multiplication and one division by the factor of a unit leave.
constexpr double kConverted = 1e-15;

std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + part.size())) ++n;
  return n;
}

std::vector<std::string> lines_of(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

io::Json data_of(const std::string& html) {
  const std::string mark = "<script type=\"application/json\" id=\"data\">";
  const std::size_t begin = html.find(mark) + mark.size();
  return io::parse_json(html.substr(begin, html.find("</script>", begin) - begin), "data");
}

}  // namespace

TEST_CASE("locate.json: verdict, place, faults and model error stand under the agreed keys", "[gap][report]") {
  const io::Json json = to_json(test::mismatch_findings());
  CHECK(json["verdict"] == "mismatch");
  CHECK(json["p_value"] == 0.0002);
  CHECK(json["located"]["dof"] == io::Json{{"surge", 0.06}, {"sway", 0.71}, {"yaw", 0.23}});
  const io::Json& interval = json["located"]["intervals"][1];
  CHECK(interval["file"] == "data/zigzag-3.csv");
  CHECK(interval["t_start_s"] == 40.0);
  CHECK(interval["t_end_s"] == 75.0);
  CHECK(interval["dof"] == "yaw");
  CHECK(interval["p_value"] == 0.008);
  CHECK_THAT(interval["mean_acceleration"]["yaw_degps2"].get<double>(), WithinRel(0.019, kConverted));
  const io::Json& regime = json["located"]["regime"][1];
  CHECK(regime["variable"] == "psi");
  CHECK(regime["relation"] == "linear");
  CHECK(regime["sentence"] == "the yaw residual turns with the heading");
  CHECK_THAT(regime["mean_degps2"][8].get<double>(), WithinRel(0.012, kConverted));
  CHECK_THAT(json["located"]["line_of_action"]["x_F_m"].get<double>(), WithinRel(-0.249, kConverted));
  CHECK_THAT(json["sigma_w"]["sway_mps2"].get<double>(), WithinRel(0.0019, kConverted));
  CHECK_THAT(json["sigma_w"]["yaw_degps2"].get<double>(), WithinRel(0.0113, kConverted));
  CHECK_THAT(json["sigma_w"]["surge_share_of_typical"].get<double>(), WithinRel(0.04, kConverted));
  CHECK(json["null_fit"]["converged"] == true);
  CHECK(json["detection"]["effects"][0]["name"] == "unmeasured-wind");
  CHECK(to_json(test::agreement_findings())["verdict"] == "no-mismatch");
  CHECK(gap::word(gap::Verdict::undecided) == "undecided");
}

TEST_CASE("locate.json: one parameter of a fault is a number, several are named", "[gap][report]") {
  const io::Json audit = to_json(test::mismatch_findings())["audit"];
  const io::Json &bias = audit["faults"][0], &lever = audit["hypotheses"][1];
  CHECK(bias["estimate"] == 2.97);
  CHECK(bias["sd"] == 0.21);
  CHECK(bias["parameters"]["heading_bias_deg"] == io::Json{{"estimate", 2.97}, {"sd", 0.21}, {"unit", "deg"}});
  CHECK(lever["estimate"] == io::Json{{"lever_x_m", 0.11}, {"lever_y_m", -0.02}});
  CHECK(lever["sd"]["lever_y_m"] == 0.04);
  CHECK(lever["heldout_gain"] == 0.4);
}

TEST_CASE("locate.json: a channel has the unit of its column", "[gap][report]") {
  const io::Json channels = to_json(test::mismatch_findings())["audit"]["channels"];
  CHECK(channels["u_mps"]["noise_sd"] == 0.0102);
  CHECK_THAT(channels["r_degps"]["noise_sd"].get<double>(), WithinRel(0.104, kConverted));
  CHECK_THAT(channels["psi_deg"]["resolution"].get<double>(), WithinRel(0.1, kConverted));
  CHECK(channels["r_degps"]["unit"] == "deg/s");
}

TEST_CASE("locate.json: what is not finite is null", "[gap][report]") {
  gap::Findings findings = test::mismatch_findings();
  findings.detection.p_value = kMissing;
  findings.fit.typical(0) = 0.0;
  findings.located.line_of_action.reset();
  findings.audit.log_through_water.reset();
  findings.fit.noise[0].sd = std::numeric_limits<double>::infinity();
  const io::Json json = io::parse_json(io::to_text(to_json(findings)), "locate.json");
  CHECK(json["p_value"].is_null());
  CHECK(json["sigma_w"]["surge_share_of_typical"].is_null());
  CHECK(json["located"]["line_of_action"].is_null());
  CHECK(json["audit"]["log_through_water"].is_null());
  CHECK(json["null_fit"]["noise"]["u_mps"]["sd"].is_null());
}

TEST_CASE("residual.csv: a trajectory with residuals, in the units of the names", "[gap][report]") {
  const test::TemporaryFolder folder;
  gap::Residual residual = test::mismatch_findings().residuals[1];
  residual.acceleration[5](1) = kMissing;
  const std::string path = folder.write("residual.csv", residual_text(residual));

  const Trajectory states = io::read_trajectory(path);
  REQUIRE(states.size() == residual.t_s.size());
  io::CsvReader csv(path);
  std::vector<std::string_view> fields;
  const auto number = [&](const char* column) { return csv.number(fields[csv.column(column)], column, ""); };
  for (std::size_t i = 0; csv.next(fields); ++i) {
    CAPTURE(i);
    CHECK(states[Channel::t][i] == residual.t_s[i]);
    CHECK(states[Channel::vm][i] == residual.nu[i](1));
    CHECK(states[Channel::y0][i] == residual.eta[i](1));
    CHECK_THAT(states[Channel::r][i], WithinRel(residual.nu[i](2), kConverted));
    CHECK_THAT(states[Channel::psi][i], WithinRel(residual.eta[i](2), kConverted));
    if (i == 5)
      CHECK(fields[csv.column("vm_dot_residual_mps2")].empty());
    else
      CHECK(number("vm_dot_residual_mps2") == residual.acceleration[i](1));
    CHECK_THAT(number("r_dot_residual_degps2"), WithinRel(rad_to_deg(residual.acceleration[i](2)), kConverted));
    CHECK_THAT(number("r_dot_residual_sd_degps2"), WithinRel(0.004, kConverted));
    CHECK(number("N_residual_Nm") == residual.force[i](2));
    CHECK(number("Y_residual_sd_N") == residual.force_sd[i](1));
  }
}

TEST_CASE("residual.csv: a recording without positions has none", "[gap][report]") {
  const test::TemporaryFolder folder;
  const gap::Residual residual = test::agreement_findings().residuals[0];
  const Trajectory states = io::read_trajectory(folder.write("residual.csv", residual_text(residual)));
  CHECK(std::all_of(states[Channel::x0].begin(), states[Channel::x0].end(), [](double x) { return std::isnan(x); }));
  CHECK(states[Channel::u][0] == residual.nu[0](0));
}

TEST_CASE("summary of gap-locate: says the verdict, the size, the place and the next step", "[gap][report]") {
  const std::string text = summary(test::mismatch_findings());
  CAPTURE(text);
  CHECK_THAT(text, Catch::Matchers::StartsWith("Verdict     MISMATCH (p-value 0.0002)."));
  CHECK_THAT(text, Contains("the heading is 2.97 deg (sd 0.21) too high"));
  CHECK_THAT(text, Contains("surge 0.42 +- 0.03 mm/s^2, 4.0 % of the typical acceleration"));
  CHECK_THAT(text, Contains("yaw 0.0113 +- 0.0009 deg/s^2"));
  CHECK_THAT(text, Contains("sway 71 %; yaw 23 %; surge 6.0 % of what is missing"));
  CHECK_THAT(text, Contains("0.083 +- 0.021 ship lengths astern of midship"));
  CHECK_THAT(text, Contains("120 to 260 s, sway"));
  CHECK_THAT(text, Contains("wind.k_Y x 0.64 (-3.0 sd)"));
  CHECK_THAT(text, !Contains("hull.N_v"));
  CHECK_THAT(text, Contains("gap-explain"));
  const std::string none = summary(test::agreement_findings());
  CHECK_THAT(none, Contains("NO MISMATCH (p-value 0.41)"));
  CHECK_THAT(none, !Contains("When") && !Contains("Goes with") && !Contains("Parameters"));
}

TEST_CASE("summary of gap-locate: stays on one screen however much was found", "[gap][report]") {
  gap::Findings findings = test::mismatch_findings();
  for (int i = 0; i < 40; ++i) {
    const std::string words = fmt::format(
        "finding {} of many, in a sentence that goes on for more than a line, "
        "in which the 3° of a heading stand, and a path like {}.csv",
        i, std::string(130, 'x'));
    findings.audit.faults.push_back({"heading-bias", {}, 1.0, 1.0, 0.1, words});
    findings.conventions.contradicted.push_back({"psi", "radians", words});
    findings.located.intervals.push_back({words, words, 0.0, 1.0, 0, 0.1, {}});
    findings.located.regimes.push_back(
        {.variable = "u", .relation = "linear", .sentence = words, .x = {}, .mean = {}, .mean_sd = {}, .x_label = {}});
    findings.fit.parameters.push_back({words, 2.0, 0.1, 0.1, 7.0});
    findings.notices.push_back(words);
    findings.detection.reason += words;
  }
  findings.located.line_of_action = gap::Estimate{"x_F_over_L_pp", 3.2, 0.41};
  const std::vector<std::string> lines = lines_of(summary(findings));
  CHECK(lines.size() <= 30);
  for (const std::string& line : lines) {
    CAPTURE(line);
    const auto characters = std::count_if(line.begin(), line.end(), [](char c) { return (c & 0xC0) != 0x80; });
    CHECK(characters <= 100);
  }
}

TEST_CASE("summary: limits of an interval are given as exactly as what lies between", "[gap][report]") {
  CHECK(gap::between(0.0399902, 0.0400068) == "0.039990 to 0.040007");
  CHECK(gap::between(69.989, 70.017) == "69.989 to 70.017");
  CHECK(gap::between(1.234, 5.678) == "1.2 to 5.7");
  CHECK(gap::between(-120.0, 340.0) == "-120 to 340");
  CHECK(gap::between(0.5, 0.5) == "0.5 to 0.5");
}

TEST_CASE("summary of gap-explain: where it cannot tell it says why, also of a ship file that is off",
          "[gap][report]") {
  gap::Explanation explanation;
  explanation.hypotheses.resize(2);
  explanation.hypotheses[0].probability = 0.3;
  explanation.hypotheses[1].probability = 0.6;
  explanation.hypotheses[1].effects = {"fouling"};
  gap::Decision decision;
  decision.p_value = 0.04;
  decision.reason = gap::Reason::likelier_than_not;
  explanation.reason = gap::reason_text(decision, {}, explanation.findings, explanation.hypotheses);
  for (const gap::ShipFileState state : {gap::ShipFileState::as_stated, gap::ShipFileState::off}) {
    explanation.ship_file.state = state;
    CHECK_THAT(gap::headline(explanation), Contains("Cannot tell whether physics is missing: fouling is likelier") &&
                                               Contains("(0.60)") && Contains(" 4 % of campaigns"));
  }
  CHECK_THAT(gap::headline(explanation), Contains("; the ship file is off"));
  decision.p_value = 0.0015;
  for (const auto& [reason, words] :
       {std::pair{gap::Reason::likelier_but_not_told_from_none,
                  "; but the strength of an effect is not told from none"},
        std::pair{gap::Reason::likelier_but_not_heldout, "; but it does not predict better what was left out"}}) {
    decision.reason = reason;
    CHECK_THAT(gap::reason_text(decision, {}, explanation.findings, explanation.hypotheses),
               Contains("(0.60), and chance alone shows as much in 0.15 % of campaigns") && Contains(words));
  }
}

TEST_CASE("thinning for the page: extremes, ends and holes stay", "[gap][report]") {
  std::vector<double> line(50000);
  for (std::size_t i = 0; i < line.size(); ++i) line[i] = std::sin(0.001 * static_cast<double>(i));
  line[31234] = 9.0;
  line[777] = -8.0;
  line[20000] = kMissing;
  const std::vector<std::size_t> kept = gap::thinned({&line, 1}, line.size(), 1500);
  CHECK(kept.size() <= 1503);  // with the hole and the ends
  CHECK(std::is_sorted(kept.begin(), kept.end()));
  for (const std::size_t i :
       {std::size_t{0}, std::size_t{777}, std::size_t{20000}, std::size_t{31234}, line.size() - 1})
    CHECK(std::count(kept.begin(), kept.end(), i) == 1);
  line.resize(1500);
  CHECK(gap::thinned({&line, 1}, line.size(), 1500).size() == 1500);
}

TEST_CASE("report.html: needs nothing from outside", "[gap][report]") {
  const std::string html = report_html(test::mismatch_findings(), "title", "provenance");
  CHECK_THAT(html, Contains("Chart.js v3."));
  CHECK_THAT(html, Contains("default-src 'none'"));
  for (const char* load : {"src=", "href=", "<link", "@import", "url(", "fetch(", "XMLHttpRequest", "import("}) {
    CAPTURE(load);
    CHECK(count_of(html, load) == 0);
  }
}

TEST_CASE("report.html: names from outside stay text", "[gap][report]") {
  gap::Findings findings = test::mismatch_findings();
  const std::string attack = "</script><script>alert(\"1\")</script> & {{script}} 'x'";
  findings.residuals[0].recording = attack;
  findings.notices.push_back(attack);
  findings.conventions.contradicted.push_back({"psi", "radians", attack, 12.0, 0.4});
  const std::string html = report_html(findings, attack, attack);
  CHECK(count_of(html, "<script>alert") == 0);
  CHECK(count_of(html, "</script>") == 3);
  CHECK_THAT(html, Contains("<title>&lt;/script&gt;&lt;script&gt;alert(&quot;1&quot;)&lt;/script&gt; &amp; {{script}} "
                            "&#39;x&#39;</title>"));
  const io::Json data = data_of(html);
  CHECK(data["recordings"][0]["recording"] == attack);
  CHECK(data["title"] == attack);
  CHECK(data["findings"]["notices"][1] == attack);
}

TEST_CASE("report.html: a long recording is thinned and keeps its peaks", "[gap][report]") {
  gap::Findings findings = test::mismatch_findings(50000);
  findings.residuals.resize(1);
  findings.residuals[0].acceleration[33333](0) = 0.1234;
  const std::string html = report_html(findings, "title", "provenance");
  CHECK(html.size() < 2000000);
  const io::Json surge = data_of(html)["recordings"][0]["lines"][0];
  CHECK(surge["t_s"].size() <= 1502);
  CHECK(surge["t_s"].size() == surge["value"].size());
  CHECK(std::count(surge["value"].begin(), surge["value"].end(), io::Json(0.1234)) == 1);
}
