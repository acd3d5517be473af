#pragma once

#include <cmath>
#include <string>

#include <nlohmann/json.hpp>

#include "core/random.hpp"
#include "io/files.hpp"
#include "io/json.hpp"
#include "ship/ship.hpp"
#include "temporary_folder.hpp"

namespace leeway::test {

/// A shipped ship whose coefficients are wrong: each hull derivative, the added masses, the thrust, the rudder area,
/// the thrusters and the windage areas by a factor of their own, exp(N(0, log_sd)).
inline Ship perturbed_ship(const std::string& name, double log_sd, std::uint64_t seed) {
  io::Json json = io::read_json(io::find_config("ships", name));
  RandomStream stream(seed, "wrong coefficients");
  const auto factor = [&] { return std::exp(log_sd * stream.normal()); };
  const auto change = [](io::Json& value, double by) {
    if (value.is_number()) value = value.get<double>() * by;
    if (value.is_array())
      for (io::Json& item : value) item = item.get<double>() * by;
  };
  for (const auto& [key, value] : json["hull"].items())
    if (value.is_number()) change(json["hull"][key], factor());
  for (const char* key : {"m_x", "m_y"})
    if (json["inertia"].contains(key)) change(json["inertia"][key], factor());
  const double thrust = factor();
  for (const char* key : {"K_T", "K_T_ahead"})
    if (json["propeller"].contains(key)) change(json["propeller"][key], thrust);
  if (json["rudder"].contains("A_R_m2")) change(json["rudder"]["A_R_m2"], factor());
  if (json.contains("thrusters"))
    for (io::Json& thruster : json["thrusters"]) {
      const double by = factor();
      for (const char* key : {"K_T_positive", "K_T_negative"})
        if (thruster.contains(key)) change(thruster[key], by);
    }
  for (const char* key : {"A_T_m2", "A_L_m2"})
    if (json["wind"].contains(key)) change(json["wind"][key], factor());
  const TemporaryFolder folder;
  const std::string path = folder / "ship.json";
  io::write_text(path, io::to_text(json));
  return read_ship(path);
}

}  // namespace leeway::test
