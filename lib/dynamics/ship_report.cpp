#include "dynamics/ship_report.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include <fmt/format.h>

#include "core/errors.hpp"
#include "core/units.hpp"
#include "dynamics/coefficient_law.hpp"
#include "dynamics/model.hpp"
#include "dynamics/straight_run.hpp"
#include "forces/inertia.hpp"
#include "forces/registry.hpp"
#include "io/files.hpp"

namespace leeway {
namespace {

using Text = fmt::memory_buffer;

template <typename... Arguments>
void print(Text& text, fmt::format_string<Arguments...> format, Arguments&&... arguments) {
  fmt::format_to(std::back_inserter(text), format, std::forward<Arguments>(arguments)...);
}

void print_particulars(Text& text, const Ship& ship) {
  const Particulars& p = ship.particulars;
  const Inertia<double> inertia(ship.inertia, p);
  const double Fr = ship.u0_mps / std::sqrt(kGravity_mps2 * p.L_pp);
  print(text, "\nparticulars\n");
  print(text, "  L_pp x B x d  {:.6g} x {:.6g} x {:.6g} m, in water of {:.6g} kg/m^3\n", p.L_pp, p.B, p.d, p.rho);
  print(text, "  scale         {:.6g} (length of the full-scale ship by this one's)\n", ship.scale);
  print(text, "  m             {:.6g} kg; C_b = m/(rho L_pp B d) = {:.3f}\n", inertia.m,
        inertia.m / (p.rho * p.L_pp * p.B * p.d));
  print(text, "  m_x, m_y      {:.6g}, {:.6g} kg\n", inertia.m_x, inertia.m_y);
  print(text, "  x_G           {:.6g} m ahead of midship\n", inertia.x_G);
  print(text, "  I_zG + J_z    {:.6g} kg m^2; about midship {:.6g} kg m^2\n", inertia.I_z,
        inertia.I_z + inertia.x_G * inertia.x_G * inertia.m);
  print(text, "  u0            {:.6g} m/s, {:.4g} kn at full scale; Fr {:.4f}\n", ship.u0_mps,
        ship.u0_mps * std::sqrt(ship.scale) / kKnot, Fr);
}

void print_actuators(Text& text, const Ship& ship) {
  print(text, "\nactuators\n");
  for (const Actuator& a : ship.actuators) {
    const char* unit = a.is_angle() ? "deg" : "1/s";
    const double k = a.is_angle() ? 1.0 / kDegree : 1.0;
    const std::string limits =
        a.turns_freely() ? "any angle" : fmt::format("{:g} .. {:g} {}", k * a.min, k * a.max, unit);
    print(text, "  {:<8} {}, at most {:g} {}, {}, initially {:g} {}\n", info(a.channel).name, limits, k * a.rate,
          a.is_angle() ? "deg/s" : "1/s^2",
          a.time_constant_s > 0.0 ? fmt::format("time constant {:g} s", a.time_constant_s) : "no lag", k * a.initial,
          unit);
    if (a.n_at_pitch_current_1 > 0.0)
      print(text, "           {} = {:g} 1/s times the pitch current {}\n", info(a.channel).name, a.n_at_pitch_current_1,
            info(Channel::i_bt).name);
  }
}

void print_sources(Text& text, const Ship& ship) {
  print(text, "\nmodules and sources\n");
  for (const PartSource& s : ship.sources)
    print(text, "  {}{}{}: {}\n", s.part, s.type.empty() ? "" : ", ", s.type, s.source);
}

// Each coefficient with its 95 % interval and where value and interval come from.
void print_coefficients(Text& text, const Ship& ship) {
  print(text,
        "\ncoefficients: value, 95 % interval (of a group: of its factor), source; * the interval is the module's "
        "default\n");
  for (const ReportedCoefficient& c : reported_coefficients(ship))
    print(text, "  {:<26} {:>10} {:>10.4g} .. {:<10.4g}{} {}\n", c.name,
          c.value ? fmt::format("{:.4g}", *c.value) : "x 1", c.low, c.high, c.is_stated ? " " : "*", c.source);
}

// What the file changes of the coefficients that its modules state; the values above have it.
void print_changes(Text& text, const Ship& ship) {
  if (ship.coefficient_factors.empty()) return;
  print(text, "\nchanged coefficients: the values above are those of the modules times this factor, plus this shift\n");
  for (const CoefficientFactor& by : ship.coefficient_factors)
    print(text, "  {:<26} x {:.6g}{}\n", by.name, by.factor,
          by.shift == 0.0 ? "" : fmt::format(" {} {:.4g}", by.shift < 0.0 ? "-" : "+", std::abs(by.shift)));
}

void print_joint_uncertainty(Text& text, const Ship& ship) {
  if (!ship.coefficient_covariance) return;
  const Ship::JointUncertainty& joint = *ship.coefficient_covariance;
  print(text, "\nposterior (coefficient_covariance): standard deviation of the logarithm, * of the value\n");
  for (std::size_t i = 0; i < joint.names.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    print(text, "  {:<26} {:>10.4g}{}\n", joint.names[i], std::sqrt(joint.matrix(k, k)),
          ship.is_absolute(joint.names[i]) ? " *" : "");
  }
  const std::vector<Correlation> correlations = strongest_correlations(joint);
  print(text, "  strongest correlations{}\n", correlations.empty() ? ": none of 0.1 or more" : "");
  for (const Correlation& c : correlations) print(text, "    {:+.2f}  {} and {}\n", c.value, c.a, c.b);
}

void print_residual_network(Text& text, const Ship& ship) {
  if (!ship.residual_network) return;
  const ResidualNetwork& network = *ship.residual_network;
  print(text, "\nresidual network: accelerations that it adds, whole within this domain\n  layers        ");
  for (const ResidualNetwork::Layer& layer : network.layers)
    print(text, "{} x {}; ", layer.weights.rows(), layer.weights.cols());
  print(text, "outputs by inputs\n");
  for (const ResidualNetwork::Input& input : network.inputs)
    print(text, "  {:<14}{:g} .. {:g}\n", input.name, input.low, input.high);
  print(text, "  source        {}\n", network.source);
}

void print_effects(Text& text, const Ship& ship) {
  const Model<double> check(ship);  // whatever is wrong with an entry is said here
  if (ship.effects.empty()) return;
  print(text, "\neffects\n");
  for (const EffectEntry& effect : ship.effects) {
    print(text, "  {}:", effect.type);
    for (const auto& [name, value] : effect.parameters)
      print(text, " {} {}", name, value ? fmt::format("{:g}", *value) : "null");
    print(text, "\n");
  }
}

void print_run(Text& text, const StraightRun& run, const Ship& ship) {
  print(text, "    u {:.6g} m/s (Fr {:.4f}), ", run.u, run.u / std::sqrt(kGravity_mps2 * ship.particulars.L_pp));
  if (ship.modules->propeller)
    print(text, "n_p {:.6g} 1/s, J {:.4f}, 1 - w_P {:.4f}, K_T {:.4f}\n", run.n, run.J, run.one_minus_w_P, run.K_T);
  else
    print(text, "{:.6g} 1/s of each thruster that drives\n", run.n);
  print(text, "    (1 - t_P) T {:.6g} N, hull {:.6g} N, rudders {:.6g} N, air {:.6g} N; sum {:.1g} N\n", run.X_P,
        run.X_H, run.X_R + 0.0, run.X_A + 0.0, run.X_P + run.X_H + run.X_R + run.X_A);
}

// Runs `compute`, or says why it cannot be done.
template <typename Compute>
void print_if_possible(Text& text, const Ship& ship, const Compute& compute) {
  try {
    print_run(text, compute(), ship);
  } catch (const NumericalError& e) {
    print(text, "    none: {}\n", e.what());
  }
}

}  // namespace

std::vector<ReportedCoefficient> reported_coefficients(const Ship& ship) {
  constexpr double kNormal95 = 1.959963985;
  const CoefficientLaw law = coefficient_law(ship);
  const std::vector<Coefficient> known = Model<double>(ship).coefficients();
  std::vector<ReportedCoefficient> result;
  for (std::size_t i = 0; i < known.size(); ++i) {
    const UncertainCoefficient& c = law.coefficients[i];
    const auto k = static_cast<Eigen::Index>(i);
    const double width = kNormal95 * std::sqrt(law.covariance(k, k));
    const double value = known[i].value.value_or(1.0);
    const double low = c.is_absolute ? value - width : value * std::exp(-width);
    const double high = c.is_absolute ? value + width : value * std::exp(width);
    const auto own = ship.coefficient_sources.find(known[i].name);
    result.push_back({known[i].name, known[i].value, std::min(low, high), std::max(low, high), c.is_stated,
                      c.is_absolute,
                      own == ship.coefficient_sources.end() ? std::string(known[i].reference) : own->second});
  }
  return result;
}

std::vector<Correlation> strongest_correlations(const Ship::JointUncertainty& joint, std::size_t most) {
  constexpr double kWeakest = 0.1;
  std::vector<Correlation> result;
  for (Eigen::Index i = 0; i < joint.matrix.rows(); ++i)
    for (Eigen::Index j = i + 1; j < joint.matrix.cols(); ++j) {
      const double value = joint.matrix(i, j) / std::sqrt(joint.matrix(i, i) * joint.matrix(j, j));
      if (std::abs(value) >= kWeakest)
        result.push_back({joint.names[static_cast<std::size_t>(i)], joint.names[static_cast<std::size_t>(j)], value});
    }
  std::ranges::stable_sort(result, [](const auto& a, const auto& b) { return std::abs(a.value) > std::abs(b.value); });
  if (result.size() > most) result.resize(most);
  return result;
}

std::string ship_list() {
  const std::vector<std::string> names = io::config_names("ships");
  std::size_t width = 4;
  for (const std::string& name : names) width = std::max(width, name.size());
  Text text;
  print(text, "{:<{}}  {:>8}  {}\n", "name", width, "L_pp [m]", "description");
  for (const std::string& name : names) {
    const Ship ship = read_ship(io::find_config("ships", name));
    print(text, "{:<{}}  {:>8g}  {}\n", name, width, ship.particulars.L_pp, ship.description);
  }
  return fmt::to_string(text);
}

std::string ship_report(const Ship& ship) {
  Text text;
  print(text, "{}: {}\n{}\n", ship.name, ship.description, ship.file);
  print_particulars(text, ship);
  print_actuators(text, ship);
  print_sources(text, ship);
  print_coefficients(text, ship);
  print_changes(text, ship);
  print_joint_uncertainty(text, ship);
  print_residual_network(text, ship);
  print_effects(text, ship);
  print(text, "\nstraight run: v_m = r = 0, rudders amidships, thrusters idle, calm air{}\n",
        ship.effects.empty() ? "" : ", effects on coefficients alone");
  const double n = ship.propulsion().front().initial;
  print(text, "  steady speed at the initial revolutions\n");
  print_if_possible(text, ship, [&] { return straight_run(ship, steady_speed(ship, n), n); });
  print(text, "  self-propulsion at u0\n");
  print_if_possible(text, ship, [&] { return straight_run(ship, ship.u0_mps, self_propulsion_n(ship, ship.u0_mps)); });
  return fmt::to_string(text);
}

}  // namespace leeway
