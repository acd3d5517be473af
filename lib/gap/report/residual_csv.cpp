#include "gap/report/residual_csv.hpp"

#include <iterator>

#include <fmt/format.h>

#include "core/units.hpp"
#include "io/csv.hpp"

namespace leeway::gap {

std::string residual_text(const Residual& residual) {
  struct Column {
    const char* name;
    const std::vector<Vec3<double>>* values;
    int component;
    double divisor;  // SI to the unit of the name
  };
  const std::vector<Vec3<double>>&a = residual.acceleration, &a_sd = residual.acceleration_sd;
  const std::vector<Vec3<double>>&f = residual.force, &f_sd = residual.force_sd;
  const std::vector<Vec3<double>> nowhere;
  const auto& position = residual.has_position ? residual.eta : nowhere;
  const Column columns[] = {
      {"u_dot_residual_mps2", &a, 0, 1.0},
      {"u_dot_residual_sd_mps2", &a_sd, 0, 1.0},
      {"vm_dot_residual_mps2", &a, 1, 1.0},
      {"vm_dot_residual_sd_mps2", &a_sd, 1, 1.0},
      {"r_dot_residual_degps2", &a, 2, kDegree},
      {"r_dot_residual_sd_degps2", &a_sd, 2, kDegree},
      {"X_residual_N", &f, 0, 1.0},
      {"X_residual_sd_N", &f_sd, 0, 1.0},
      {"Y_residual_N", &f, 1, 1.0},
      {"Y_residual_sd_N", &f_sd, 1, 1.0},
      {"N_residual_Nm", &f, 2, 1.0},
      {"N_residual_sd_Nm", &f_sd, 2, 1.0},
      {"u_mps", &residual.nu, 0, 1.0},
      {"vm_mps", &residual.nu, 1, 1.0},
      {"r_degps", &residual.nu, 2, kDegree},
      {"x0_m", &position, 0, 1.0},
      {"y0_m", &position, 1, 1.0},
      {"psi_deg", &residual.eta, 2, kDegree},
  };
  std::string text = "t_s";
  for (const Column& column : columns) fmt::format_to(std::back_inserter(text), ",{}", column.name);
  text += '\n';
  for (std::size_t i = 0; i < residual.t_s.size(); ++i) {
    fmt::format_to(std::back_inserter(text), "{}", residual.t_s[i]);
    for (const Column& column : columns) {
      text += ',';
      if (i >= column.values->size()) continue;
      const double value = (*column.values)[i](column.component);
      io::append_number(text, value / column.divisor);
    }
    text += '\n';
  }
  return text;
}

}  // namespace leeway::gap
