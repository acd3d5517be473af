#include <algorithm>
#include <set>

#include <nlohmann/json.hpp>

#include "core/units.hpp"
#include "gap/report/browser.hpp"
#include "gap/report/report_html.hpp"
#include "gap/synthetic_explanation.hpp"

using namespace leeway;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinAbs;

namespace {

using Row = std::vector<std::string>;

// Every page: drawn without an error, no wider than the window, nothing done that a page must not do.
void check_drawn(const io::Json& page, std::size_t charts) {
  CAPTURE(page["errors"].dump(), page["seen"].dump());
  REQUIRE(page["is_ready"] == true);
  CHECK(page["errors"] == "");
  CHECK(page["seen"].empty());
  CHECK(page["scrolls_sideways"] == false);
  CHECK(page["charts"] == charts);
  std::size_t drawn = 0;
  for (const io::Json& section : page["sections"])
    for (const io::Json& chart : section["charts"]) {
      CAPTURE(chart["label"].dump());
      CHECK(chart["is_drawn"] == true);
      ++drawn;
    }
  CHECK(drawn == charts);
}

const io::Json& section_of(const io::Json& page, const std::string& heading) {
  CAPTURE(heading);
  const auto found = std::find_if(page["sections"].begin(), page["sections"].end(),
                                  [&](const io::Json& section) { return section["heading"] == heading; });
  REQUIRE(found != page["sections"].end());
  return *found;
}

bool has_section(const io::Json& page, const std::string& heading) {
  return std::any_of(page["sections"].begin(), page["sections"].end(),
                     [&](const io::Json& section) { return section["heading"] == heading; });
}

std::set<std::string> texts_of(const io::Json& values) {
  std::set<std::string> texts;
  for (const io::Json& value : values) texts.insert(value.get<std::string>());
  return texts;
}

// Where the line of this name ends in the map of a choice, its last chart: the planted tracks are longer to the north
// than to the east, so that the map has north to the right.
Vec2<double> end_of(const io::Json& choice, const std::string& line) {
  for (const io::Json& drawn : choice["charts"].back())
    if (drawn["label"] == line) return {drawn["last"][0].get<double>(), drawn["last"][1].get<double>()};
  FAIL("no line " << line);
  return {};
}

// A name cannot hold a slash where it is a file's; one that stands in JSON can.
test::Names hostile_names() {
  test::Names names;
  names.ship = "</script><script>alert(1)</script>\"'\\ 船";
  names.ensemble = "<svg onload=alert(2)> & {{script}} \u00fc";
  names.recordings = {"<script>alert(1)</script>", "a \"quoted\" 'name' \\ back\\slash </title></noscript><b>&amp;",
                      "旋回試験 Übergröße <img src=x onerror=alert(3)> <!--"};
  return names;
}

bool skip_without_browser() {
  if (test::Browser::is_installed()) return false;
  WARN("SKIPPED: chromium is not installed");
  return true;
}

}  // namespace

TEST_CASE("report.html of gap-locate in a browser: every chart draws", "[gap][report][long]") {
  if (skip_without_browser()) return;
  const test::Browser browser;
  struct Case {
    const char* name;
    gap::Findings findings;
    std::size_t charts;  // time lines, track, shares, ship, frames, modules, two regimes, effects, parameters
  };
  gap::Findings undecided;
  undecided.detection.reason = "Too few samples.";
  for (const Case& c :
       {Case{"mismatch", test::mismatch_findings(), 12}, Case{"agreement", test::agreement_findings(), 4},
        Case{"ensemble", test::with_ensemble(test::mismatch_findings(), "five-members"), 12},
        Case{"undecided", undecided, 0}}) {
    CAPTURE(c.name);
    check_drawn(browser.read(report_html(c.findings, "gap-locate", "leeway")), c.charts);
  }
  const std::string png = browser.picture(report_html(test::mismatch_findings(), "gap-locate", "leeway"));
  CHECK(png.substr(1, 3) == "PNG");
  CHECK(png.size() > 150000);  // a blank page of this size has less than 30 kB, this one more than 400 kB
}

TEST_CASE("report.html of gap-locate in a browser: a reader finds place, size and faults", "[gap][report]") {
  if (skip_without_browser()) return;
  const test::Browser browser;
  const io::Json page =
      browser.read(report_html(test::with_ensemble(test::mismatch_findings(), "five-members"), "gap-locate", "leeway"));
  const io::Json& verdict = page["sections"][0];
  CHECK_THAT(verdict["text"], Contains("The ensemble five-members and the recordings differ by more than noise"));
  CHECK_THAT(verdict["text"], Contains("0.42 ± 0.03 mm/s²") && Contains("4.0 % of the typical acceleration"));
  CHECK_THAT(verdict["text"],
             Contains("0.0113 ± 0.0009 deg/s²") && Contains("unseen data predicted better by 21 ± 4 (log-likelihood)"));
  CHECK_THAT(verdict["text"], Contains("surge 0.31, sway 0.72 mm/s², yaw 0.021 deg/s²"));
  CHECK_THAT(verdict["text"], Contains("the heading is 2.97 deg (sd 0.21) too high") && Contains("before the fit)"));

  const io::Json& intervals = section_of(page, "Located intervals")["tables"][0];
  CHECK(intervals[1] ==
        Row{"zigzag <2> & \"gust\"", "120 – 260", "sway", "3.1 mm/s²", "0.0004", "82 %", "3.1", "untrained region"});
  CHECK(intervals[2] == Row{"zigzag-3", "40 – 75", "yaw", "0.019 deg/s²", "0.008", "0.0 %", "15", "not known"});
  CHECK(page["picked_by_rows"] == Row{"zigzag <2> & \"gust\"  (1 located)", "zigzag-3  (1 located)"});

  const io::Json& where = section_of(page, "Where it acts on the ship");
  CHECK_THAT(where["text"], Contains("0.083 ± 0.021 ship lengths astern of midship (0.249 m)"));
  CHECK(where["charts"][0]["tips"] == Row{"surge\n6.0 %", "sway\n71 %", "yaw\n23 %"});
  CHECK(section_of(page, "Known effects that would fit")["charts"][0]["tips"][0] ==
        "unmeasured-wind\n21 ± 4 (log-likelihood), p 0.0002, log Bayes factor 38.1");
  const io::Json& sensors = section_of(page, "Sensors and conventions")["tables"];
  CHECK(sensors[0][1][1] == "2.97 ± 0.21 deg");
  CHECK(sensors[1][3] == Row{"r_degps", "0.1 deg/s", "1.8 s", "0.9 s", "none", "1.3 %", "continuous"});
  CHECK(sensors[2][2][1] == "lever_x_m 0.11 ± 0.05 m, lever_y_m −0.02 ± 0.04 m");
  CHECK_THAT(browser.read(report_html(test::agreement_findings(), "gap-locate", "leeway")).dump(),
             Contains("Nothing to locate"));
}

TEST_CASE("report.html: what is not known is a dash in the browser, not a zero", "[gap][report]") {
  if (skip_without_browser()) return;
  gap::Findings findings = test::mismatch_findings();
  findings.fit.sigma_w(1) = findings.fit.typical(0) = kMissing;
  findings.located.intervals[0].acceleration(1) = kMissing;
  findings.audit.faults[0].parameters[0].value = kMissing;
  findings.detection.whiteness_p_value = kMissing;
  const io::Json page = test::Browser().read(report_html(findings, "gap-locate", "leeway"));
  check_drawn(page, 12);
  CHECK_THAT(page["sections"][0]["text"], Contains("– mm/s²") && Contains("– of the typical acceleration"));
  CHECK(section_of(page, "Located intervals")["tables"][0][1][3] == "– mm/s²");
  CHECK(section_of(page, "Sensors and conventions")["tables"][0][1][1] == "– deg");
  CHECK(section_of(page, "The fit")["tables"][0][8][1] == "–");
}

TEST_CASE("report.html of gap-explain in a browser: a reader finds what is missing, and how certain that is",
          "[gap][report]") {
  if (skip_without_browser()) return;
  const io::Json page =
      test::Browser().read(report_html(test::current_explanation(), "What esso-osaka-3m lacks", "gap-explain -o DIR"));
  check_drawn(page, 22);  // three of them velocities before and after
  CHECK(page["title"] == "What esso-osaka-3m lacks");
  const io::Json& verdict = page["sections"][0];
  CHECK(verdict["heading"] == "mismatchA current of 0.0999 m/s towards -89.8 deg explains the difference.");
  CHECK_THAT(verdict["text"], Contains("What esso-osaka-3m lacks") && Contains("< 0.0001"));
  CHECK_THAT(verdict["text"], Contains("unseen data predicted better by 480 ± 83 (log-likelihood)"));
  CHECK_THAT(verdict["text"],
             Contains("What to do: repair the sensor, or correct its recordings as said above, and run again"));

  const io::Json& missing = section_of(page, "What is missing");
  const io::Json& probabilities = missing["charts"][0];
  CHECK(probabilities["labels"] == Row{"steady-current", "unmeasured-wind", "nothing"});
  CHECK(probabilities["values"] == std::vector<double>{0.857, 0.1429, 1e-9});
  CHECK(probabilities["axes"][0] == "probability");
  CHECK(probabilities["tips"][0] ==
        "steady-current\n0.857: The water moves as a whole, steadily and everywhere alike.");
  CHECK(probabilities["tips"][2] == "nothing\n1.00e-9: Nothing is missing.");
  CHECK(missing["tables"][0] ==
        std::vector<Row>{
            {"Missing", "Probability", "Evidence", "Fit", "Unseen data", "Parameter", "Estimate", "95 %"},
            {"steady-current", "0.86", "477", "converged", "480 ± 83", "current_speed_mps", "0.0999 ± 0.0012 m/s",
             "0.0975 to 0.1023"},
            {"", "", "", "", "", "current_set_deg", "−89.78 ± 0.26 deg", "−90.29 to −89.27"},
            {"unmeasured-wind", "0.14", "476", "converged", "12 ± 4", "wind_speed_mps", "2.7 ± 0.5 m/s", "1.7 to 3.7"},
            {"nothing", "1.0e-9", "0", "not converged", "0", "", "", ""}});
  const io::Json& each = missing["charts"][1];
  CHECK(each["labels"] == Row{"steady-current", "unmeasured-wind"});
  CHECK(each["tips"][0] == "steady-current\n0.857: steady-current acts, alone or beside others");
  // Of what was chosen alone, as shares of what was believed before.
  const io::Json& learnt = missing["charts"][2];
  CHECK(learnt["labels"] == Row{"current_speed_mps", "current_set_deg"});
  CHECK_THAT(learnt["values"][0][0].get<double>(), WithinAbs(0.0975 / 0.4, 1e-12));
  CHECK_THAT(learnt["values"][1][1].get<double>(), WithinAbs((180.0 - 89.27) / 360.0, 1e-12));
  CHECK(learnt["tips"][0] == "current_speed_mps\n0.0999 ± 0.0012 m/s, 95 % 0.0975 to 0.1023; before 0 to 0.4");

  const io::Json& alike = section_of(page, "What looks alike in these recordings")["charts"][0];
  CHECK(alike["tips"][1] == "steady-current by unmeasured-wind: 62 %");
  CHECK(alike["tips"][5] == "unmeasured-wind by rudder-stall: 0.4 %");
  const io::Json& next = section_of(page, "What would distinguish them");
  CHECK_THAT(next["text"], Contains("Now it is 0.86;"));
  CHECK(next["charts"][0]["labels"] == Row{"turning circles, 35 deg to both sides (600 s)", "crash stop (240 s)"});
  CHECK(next["charts"][0]["values"] == std::vector<double>{0.987, 0.91});
  CHECK(next["charts"][0]["tips"][0] ==
        "turning circles, 35 deg to both sides (600 s)\n0.987: mmg-sim turning --rudder-deg 35 --ship SHIP.json "
        "-o planned.csv");
}

TEST_CASE("report.html of gap-explain in a browser: a reader sees the fit before and after, by recording",
          "[gap][report]") {
  if (skip_without_browser()) return;
  const io::Json page =
      test::Browser().read(report_html(test::current_explanation(), "What esso-osaka-3m lacks", "gap-explain -o DIR"));
  const io::Json& fit = section_of(page, "Fit before and after");
  CHECK_THAT(fit["text"], Contains("each part of the recordings with what was fitted to the others"));
  CHECK(fit["tables"][0][2] ==
        Row{"held out", "100", "0.0305 → 0.00305", "0.0772 → 0.00772", "0.891 → 0.0891", "10.5 → 1.05"});
  CHECK(fit["tables"][0].size() == 7);
  CHECK(fit["charts"][0]["labels"] ==
        Row{"zigzag-1 before", "after", "zigzag-2 before", "after", "zigzag-3 before", "after"});
  CHECK_THAT(fit["charts"][0]["values"][4].get<double>(), WithinAbs(10.0, 1e-12));
  CHECK_THAT(fit["charts"][0]["values"][5].get<double>(), WithinAbs(1.0, 1e-12));

  // Each choice shows its own recording, before and after: runs end as far from the recorded track as was planted.
  const io::Json& tracks = section_of(page, "What was left out in turn, before and after")["choices"];
  REQUIRE(tracks.size() == 3);
  for (std::size_t k = 0; k < 3; ++k) {
    CAPTURE(k);
    CHECK(tracks[k]["text"] == fmt::format("zigzag-{}", k + 1));
    const Vec2<double> recorded = end_of(tracks[k], "recorded"), before = end_of(tracks[k], "before"),
                       after = end_of(tracks[k], "after");
    // The page carries seven digits.
    CHECK_THAT((recorded - test::planted_end(k)).norm(), WithinAbs(0.0, 1e-4));
    CHECK_THAT((before - recorded - Vec2<double>(9.0, -9.0)).norm(), WithinAbs(0.0, 1e-4));
    CHECK_THAT((after - recorded - Vec2<double>(0.8, -0.8)).norm(), WithinAbs(0.0, 1e-4));
  }
  const io::Json& when = section_of(page, "When: residual acceleration");
  CHECK_THAT(when["text"], Contains("with what was missing"));
  REQUIRE(when["choices"].size() == 3);
  const io::Json& sway = when["choices"][1]["charts"][1];
  CHECK(sway[3]["label"] == "with what was missing");
  // Four digits each.
  CHECK_THAT(sway[3]["last"][1].get<double>() / sway[2]["last"][1].get<double>(), WithinAbs(0.1, 1e-4));
}

TEST_CASE("report.html of gap-explain in a browser: nothing missing leaves out what would be empty", "[gap][report]") {
  if (skip_without_browser()) return;
  const io::Json page = test::Browser().read(report_html(test::nothing_explanation(), "What kvlcc2 lacks", "leeway"));
  check_drawn(page, 6);
  CHECK_THAT(page["sections"][0]["text"], Contains("no mismatch") &&
                                              Contains("No missing physics that these recordings could show") &&
                                              Contains("0.41"));
  CHECK(section_of(page, "What is missing")["charts"][0]["labels"] == Row{"nothing"});
  for (const char* heading : {"What would distinguish them", "What was left out in turn, before and after",
                              "Located intervals", "Track", "What looks alike in these recordings"}) {
    CAPTURE(heading);
    CHECK_FALSE(has_section(page, heading));
  }
}

TEST_CASE("report.html in a browser: hostile names of ships and files are read as they are and do nothing",
          "[gap][report]") {
  if (skip_without_browser()) return;
  const test::Browser browser;
  const test::Names plain, hostile = hostile_names();
  const auto located = [&](const test::Names& names) {
    return browser.read(
        report_html(test::with_ensemble(test::renamed(test::mismatch_findings(), names), names.ensemble),
                    "Recordings against " + names.ship, "gap-locate " + names.recordings[2]));
  };
  const auto explained = [&](const test::Names& names) {
    return browser.read(report_html(test::current_explanation(names), "What " + names.ship + " lacks",
                                    "gap-explain " + names.recordings[2]));
  };
  const io::Json locate = located(hostile), explain = explained(hostile);
  check_drawn(locate, 12);
  check_drawn(explain, 22);
  // Not one element or attribute more than under harmless names.
  CHECK(locate["structure"] == located(plain)["structure"]);
  CHECK(explain["structure"] == explained(plain)["structure"]);

  CHECK(locate["title"] == "Recordings against " + hostile.ship);
  CHECK_THAT(locate["sections"][0]["text"], Contains("Recordings against " + hostile.ship));
  CHECK_THAT(locate["sections"][0]["text"], Contains("The ensemble " + hostile.ensemble + " and the recordings"));
  CHECK_THAT(locate["sections"].back()["text"], Contains("gap-locate " + hostile.recordings[2]));
  const io::Json& intervals = section_of(locate, "Located intervals")["tables"][0];
  CHECK(intervals[1][0] == hostile.recordings[1]);
  CHECK(intervals[2][0] == hostile.recordings[2]);
  CHECK(locate["picked_by_rows"] ==
        Row{hostile.recordings[1] + "  (1 located)", hostile.recordings[2] + "  (1 located)"});

  CHECK(explain["title"] == "What " + hostile.ship + " lacks");
  CHECK_THAT(explain["sections"][0]["text"], Contains("What " + hostile.ship + " lacks"));
  const std::set<std::string> labels = texts_of(section_of(explain, "Fit before and after")["charts"][0]["labels"]);
  const io::Json& tracks = section_of(explain, "What was left out in turn, before and after")["choices"];
  const io::Json& notices = section_of(explain, "To keep in mind")["items"];
  CHECK(texts_of(notices).count("data/" + hostile.recordings[0] + ".csv: the first 3 s are not used") == 1);
  for (std::size_t k = 0; k < 3; ++k) {
    CAPTURE(hostile.recordings[k]);
    CHECK(labels.count(hostile.recordings[k] + " before") == 1);
    CHECK(tracks[k]["text"] == hostile.recordings[k]);
    CHECK_THAT((end_of(tracks[k], "recorded") - test::planted_end(k)).norm(), WithinAbs(0.0, 1e-4));
  }
}
