#include "gap/report/report_html.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/units.hpp"
#include "gap/policy/policy.hpp"
#include "gap/report/explain_json.hpp"
#include "gap/report/locate_json.hpp"
#include "gap/report/page/page_parts.hpp"
#include "gap/report/steps.hpp"
#include "gap/report/summary.hpp"

namespace leeway::gap {
namespace {

using io::Json;

std::string escaped(std::string_view text) {
  std::string result;
  for (const char c : text) {
    switch (c) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '"':
        result += "&quot;";
        break;
      case '\'':
        result += "&#39;";
        break;
      default:
        result += c;
    }
  }
  return result;
}

// JSON that can stand in a <script>: its '<' only occur in texts, where \u003c means the same.
std::string in_script(const Json& json) {
  const std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
  std::string result;
  result.reserve(text.size());
  for (const char c : text) {
    if (c == '<')
      result += "\\u003c";
    else
      result += c;
  }
  return result;
}

// Few digits, as a screen shows them.
Json in_digits(double value, int digits) {
  if (!std::isfinite(value)) return nullptr;
  const std::string text = fmt::format("{:.{}g}", value, digits);
  double result = value;
  std::from_chars(text.data(), text.data() + text.size(), result);
  return result;
}

Json picked(const std::vector<double>& values, const std::vector<std::size_t>& at, int digits) {
  Json result = Json::array();
  for (const std::size_t i : at) result.push_back(in_digits(values[i], digits));
  return result;
}

std::vector<double> component(const std::vector<Vec3<double>>& values, int c, std::size_t count, double factor = 1.0) {
  std::vector<double> result(count, kMissing);
  for (std::size_t i = 0; i < std::min(count, values.size()); ++i) result[i] = values[i](c) * factor;
  return result;
}

Json drawn(const Residual& residual, std::size_t limit) {
  const std::size_t count = residual.t_s.size();
  Json lines = Json::array();
  for (int axis = 0; axis < 3; ++axis) {
    const double factor = axis < 2 ? 1.0 : 1.0 / kDegree;
    const std::vector<double> value = component(residual.acceleration, axis, count, factor);
    const std::vector<double> sd = component(residual.acceleration_sd, axis, count, factor);
    const std::vector<std::size_t> at = thinned({&value, 1}, count, limit);
    lines.push_back({{"t_s", picked(residual.t_s, at, 8)}, {"value", picked(value, at, 4)}, {"sd", picked(sd, at, 3)}});
  }
  Json track = nullptr;
  if (residual.has_position && count > 0 && residual.eta.size() == count) {
    const std::array<std::vector<double>, 2> xy{component(residual.eta, 0, count), component(residual.eta, 1, count)};
    const std::vector<std::size_t> at = thinned(xy, count, limit);
    track = {{"t_s", picked(residual.t_s, at, 8)}, {"x0_m", picked(xy[0], at, 7)}, {"y0_m", picked(xy[1], at, 7)}};
  }
  return {{"recording", residual.recording},
          {"file", residual.file},
          {"thinned", count > limit},
          {"lines", lines},
          {"track", track}};
}

}  // namespace

std::vector<std::size_t> thinned(std::span<const std::vector<double>> lines, std::size_t count, std::size_t limit) {
  std::vector<std::size_t> kept;
  const std::size_t stretches = std::max<std::size_t>(1, limit / (2 * std::max<std::size_t>(1, lines.size())));
  if (count <= limit) {
    for (std::size_t i = 0; i < count; ++i) kept.push_back(i);
    return kept;
  }
  for (std::size_t s = 0; s < stretches; ++s) {
    const std::size_t begin = s * count / stretches, end = (s + 1) * count / stretches;
    for (const std::vector<double>& line : lines) {
      std::size_t lowest = end, highest = end, missing = end;
      for (std::size_t i = begin; i < end; ++i) {
        if (std::isnan(line[i])) {
          missing = std::min(missing, i);
          continue;
        }
        if (lowest == end || line[i] < line[lowest]) lowest = i;
        if (highest == end || line[i] > line[highest]) highest = i;
      }
      for (const std::size_t i : {lowest, highest, missing})
        if (i < end) kept.push_back(i);
    }
  }
  kept.push_back(0);
  kept.push_back(count - 1);
  std::sort(kept.begin(), kept.end());
  kept.erase(std::unique(kept.begin(), kept.end()), kept.end());
  return kept;
}

namespace {

// Runs and what was measured along them; rows of NaN between runs stay, as null.
Json drawn(const FreeTrack& track, std::size_t limit) {
  const std::size_t count = track.t_s.size();
  std::array<std::vector<double>, 4> lines;
  for (std::size_t i = 0; i < count; ++i) {
    lines[0].push_back(track.run[i](0));
    lines[1].push_back(track.run[i](1));
    lines[2].push_back(track.measured[i](0));
    lines[3].push_back(track.measured[i](1));
  }
  const std::vector<std::size_t> at = thinned(lines, count, limit);
  Json velocities = Json::array();
  for (int axis = 0; axis < 3; ++axis) {
    const double factor = axis < 2 ? 1.0 : 1.0 / kDegree;
    const std::array<std::vector<double>, 2> of{component(track.run_nu, axis, count, factor),
                                                component(track.measured_nu, axis, count, factor)};
    const std::vector<std::size_t> shown = thinned(of, count, limit);
    velocities.push_back({{"t_s", picked(track.t_s, shown, 8)},
                          {"run", picked(of[0], shown, 5)},
                          {"measured", picked(of[1], shown, 5)}});
  }
  return {{"t_s", picked(track.t_s, at, 8)},          {"x0_m", picked(lines[0], at, 7)},
          {"y0_m", picked(lines[1], at, 7)},          {"measured_x0_m", picked(lines[2], at, 7)},
          {"measured_y0_m", picked(lines[3], at, 7)}, {"velocities", velocities}};
}

std::string page_of(const Findings& findings, const Json& explanation, const std::vector<Step>& steps,
                    const std::string& summary, const std::string& title, const std::string& provenance) {
  Json to_do = Json::array();
  for (const Step& step : steps) to_do.push_back({{"text", step.text}, {"command", step.command}});
  Json recordings = Json::array();
  const std::size_t limit =
      std::min(kPolicy.report.points_per_line,
               kPolicy.report.points_in_all / std::max<std::size_t>(1, findings.residuals.size()));
  for (const Residual& residual : findings.residuals)
    recordings.push_back(drawn(residual, std::max<std::size_t>(limit, 50)));
  const std::string data = in_script({{"title", title},
                                      {"provenance", provenance},
                                      {"findings", to_json(findings)},
                                      {"explanation", explanation},
                                      {"steps", to_do},
                                      {"recordings", recordings}});
  const std::string escaped_title = escaped(title), escaped_summary = escaped(summary);
  const std::pair<std::string_view, std::string_view> parts[] = {
      {"title", escaped_title}, {"summary", escaped_summary}, {"style", kStyle},
      {"data", data},           {"charts", kCharts},          {"script", kScript},
  };
  // Each placeholder {{name}} of the page is filled once; what is filled in is not looked at again.
  std::string html;
  std::string_view rest = kPage;
  for (;;) {
    const std::size_t open = rest.find("{{");
    html += rest.substr(0, open);
    if (open == std::string_view::npos) return html;
    const std::size_t close = rest.find("}}", open);
    const std::string_view name = rest.substr(open + 2, close - open - 2);
    html +=
        std::find_if(std::begin(parts), std::end(parts), [&](const auto& part) { return part.first == name; })->second;
    rest.remove_prefix(close + 2);
  }
}

}  // namespace

std::string report_html(const Findings& findings, const std::string& title, const std::string& provenance) {
  return page_of(findings, nullptr, steps(findings), summary(findings), title, provenance);
}

std::string report_html(const Explanation& explanation, const std::string& title, const std::string& provenance) {
  Json json = to_json(explanation);
  const std::size_t limit =
      kPolicy.report.points_in_all /
      (4 * std::max<std::size_t>(1, explanation.tracks_after.size() + explanation.residuals_after.size()));
  json["tracks"] = Json::array();
  for (const FreeTrack& before : explanation.tracks_before)
    for (const FreeTrack& after : explanation.tracks_after)
      if (after.recording == before.recording)
        json["tracks"].push_back(
            {{"recording", before.recording},
             {"before", drawn(before, std::clamp<std::size_t>(limit, 100, kPolicy.report.points_per_line))},
             {"after", drawn(after, std::clamp<std::size_t>(limit, 100, kPolicy.report.points_per_line))}});
  json["residuals_after"] = Json::array();
  if (!explanation.effects.empty() || !explanation.effects_in.empty())
    for (const Residual& residual : explanation.residuals_after)
      json["residuals_after"].push_back(
          drawn(residual, std::clamp<std::size_t>(limit, 100, kPolicy.report.points_per_line)));
  return page_of(explanation.findings, json, steps(explanation), summary(explanation), title, provenance);
}

}  // namespace leeway::gap
