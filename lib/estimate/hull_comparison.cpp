#include "estimate/hull_comparison.hpp"

#include <cmath>

#include <nlohmann/json.hpp>

#include "dynamics/coefficient_law.hpp"
#include "estimate/ship_estimate.hpp"

namespace leeway::estimate {
namespace {

// In the errors of this kind.
double stated_sd(const CoefficientLaw& law, const MeasuredHull::Value& value, const ErrorKind& kind) {
  for (const UncertainCoefficient& c : law.coefficients)
    if (c.name == value.name)
      return c.is_absolute && !kind.is_absolute ? c.sd / std::abs(value.estimated)
                                                : c.sd;  // the formulas differ in sign
  return 0.0;
}

double width_of(const std::vector<Width>& widths, const std::string& name) {
  for (const Width& width : widths)
    if (width.name == name) return width.sd;
  return 0.0;
}

}  // namespace

io::Json compare_measured_hulls(const std::vector<MeasuredHull>& hulls) {
  constexpr double kNormal95 = 1.959963985;
  io::Json all = io::Json::array();
  int within = 0, count = 0;
  for (const MeasuredHull& hull : hulls) {
    const std::vector<Width> widths = fit_widths(hulls, {hull.name});
    const CoefficientEstimates estimates = estimate_coefficients(hull.hull);
    const CoefficientLaw law = coefficient_law(estimate_ship(hull.hull.given, widths).ship);  // as its file states it
    io::Json coefficients = io::Json::array();
    for (const MeasuredHull::Value& value : hull.values) {
      const ErrorKind& kind = *find_error_kind(value.name);
      const bool is_coefficient = value.name != kTacticalDiameter;
      const double sd = is_coefficient ? stated_sd(law, value, kind) : width_of(widths, value.name),
                   error = error_of(kind, value);
      const bool is_within = std::abs(error) <= kNormal95 * sd;  // a wrong sign of a certain one is none
      within += is_coefficient && is_within ? 1 : 0;
      count += is_coefficient ? 1 : 0;
      int others = 0;
      for (const Width& width : widths)
        if (width.name == value.name) others = width.hulls;
      coefficients.push_back({{"name", value.name},
                              {"estimated", value.estimated},
                              {"measured", value.measured},
                              {"error", std::isfinite(error) ? io::Json(error) : io::Json(nullptr)},
                              {"sd", sd},
                              {"is_absolute", kind.is_absolute},
                              {"hulls", others},
                              {"within_95", is_within}});
    }
    all.push_back({{"name", hull.name},
                   {"description", hull.description},
                   {"source", hull.source},
                   {"outside_of_ranges", estimates.warnings},
                   {"coefficients", coefficients}});
  }
  io::Json formulas = io::Json::array();
  for (const FormulaRange* formula : all_formulas())
    formulas.push_back({{"source", formula->source}, {"range", formula->text()}});
  return {{"hulls", all}, {"within_95", within}, {"coefficients", count}, {"formulas", formulas}};
}

}  // namespace leeway::estimate
