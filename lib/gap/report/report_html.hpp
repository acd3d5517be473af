#pragma once

#include <span>
#include <string>
#include <vector>

#include "gap/result/explanation.hpp"

namespace leeway::gap {

/// One page that shows the findings in charts and tables, for any browser, without network: Chart.js, style and data
/// are inside. Long recordings are thinned, extremes stay.
///   title       stands above the verdict and in the browser's tab
///   provenance  stands at the end, as it is
std::string report_html(const Findings& findings, const std::string& title, const std::string& provenance);
/// The same of gap-explain: what was named, how probable it is, and the fit before and after stand first.
std::string report_html(const Explanation& explanation, const std::string& title, const std::string& provenance);

/// Samples, in order, that draw lines of `count` points like all of them do: of equal stretches of time the extremes of
/// each line, the first missing one, and the ends. At most about `limit` where nothing is missing; all where that is
/// not less.
std::vector<std::size_t> thinned(std::span<const std::vector<double>> lines, std::size_t count, std::size_t limit);

}  // namespace leeway::gap
