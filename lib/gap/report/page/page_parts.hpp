#pragma once

#include <string_view>

/// The parts of report.html, which the build turns into texts: page.html with its placeholders, page.css, the files of
/// script/ one after another, and Chart.js as Debian packages it.
namespace leeway::gap {

extern const std::string_view kPage, kStyle, kScript, kCharts;

}  // namespace leeway::gap
