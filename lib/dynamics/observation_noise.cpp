#include "dynamics/observation_noise.hpp"

#include <utility>

#include <nlohmann/json.hpp>

#include "core/units.hpp"
#include "io/files.hpp"

namespace leeway {

ObservationNoise parse_noise(const io::JsonObject& json) {
  const auto sd = [&](const char* key) { return json.number_or(key, 0.0, io::kNotNegative); };
  json.text_or("source", "");
  ObservationNoise noise;
  noise.x0 = sd("x0_m");
  noise.y0 = sd("y0_m");
  noise.psi = deg_to_rad(sd("psi_deg"));
  noise.u = sd("u_mps");
  noise.vm = sd("vm_mps");
  noise.r = deg_to_rad(sd("r_degps"));
  json.check_all_known();
  return noise;
}

ObservationNoise read_noise(const std::string& name_or_path) {
  const std::string path = io::find_config("noise", name_or_path);
  const io::Json json = io::read_json(path);
  return parse_noise(io::JsonObject(json, path));
}

io::Json to_json(const ObservationNoise& noise) {
  return {{"x0_m", noise.x0}, {"y0_m", noise.y0},   {"psi_deg", rad_to_deg(noise.psi)},
          {"u_mps", noise.u}, {"vm_mps", noise.vm}, {"r_degps", rad_to_deg(noise.r)}};
}

Trajectory observed(const Trajectory& truth, const ObservationNoise& noise, RandomStream stream) {
  Trajectory result = truth;
  const std::pair<Channel, double> channels[] = {{Channel::x0, noise.x0},   {Channel::y0, noise.y0},
                                                 {Channel::psi, noise.psi}, {Channel::u, noise.u},
                                                 {Channel::vm, noise.vm},   {Channel::r, noise.r}};
  for (std::size_t i = 0; i < truth.size(); ++i)
    for (const auto& [channel, sd] : channels) {
      const double draw = stream.normal();
      if (result.has(channel)) result[channel][i] += sd * draw;
    }
  return result;
}

}  // namespace leeway
