#include "gap/result/latent_force.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace leeway::gap {

std::string_view word(Dependence on) {
  switch (on) {
    case Dependence::place:
      return "place";
    case Dependence::heading:
      return "heading";
    case Dependence::period:
      return "period";
    case Dependence::memory:
      return "memory";
    case Dependence::states:
      return "states";
    case Dependence::time:
      break;
  }
  return "time";
}

namespace {

std::vector<std::string_view> words_of(const std::vector<Channel>& states) {
  std::vector<std::string_view> words;
  words.reserve(states.size());
  for (const Channel state : states)
    words.push_back(state == Channel::u      ? "speed ahead"
                    : state == Channel::vm   ? "speed athwart"
                    : state == Channel::r    ? "yaw rate"
                    : state == Channel::n_p  ? "revolutions"
                    : state == Channel::n_bt ? "thruster's revolutions"
                                             : "rudder angle");
  return words;
}

}  // namespace

std::string phrase(const LatentForce& force) {
  const bool in_surge = std::ranges::find(force.axes, 0) != force.axes.end(),
             in_sway = std::ranges::find(force.axes, 1) != force.axes.end(),
             in_yaw = std::ranges::find(force.axes, 2) != force.axes.end();
  const std::string what = in_surge && (in_sway || in_yaw) ? "a force"
                           : in_surge                      ? "a force in surge"
                           : in_sway && in_yaw             ? "a side force with a turning moment"
                           : in_sway                       ? "a side force"
                                                           : "a turning moment";
  switch (force.on) {
    case Dependence::place:
      return force.about ? fmt::format("{} about the place x0 = {:.3g} m, y0 = {:.3g} m", what, force.about->x(),
                                       force.about->y())
                         : what + " that depends on the place";
    case Dependence::heading:
      return what + " that depends on the heading";
    case Dependence::period:
      return fmt::format("{} with a period of {:.2g} s, whatever the ship does", what, force.argument);
    case Dependence::memory:
      return force.rings
                 ? fmt::format("{} that rings with a period of about {:.2g} s after what the ship did", what,
                               force.argument)
                 : fmt::format("{} that follows what the ship did up to about {:.2g} s before", what, force.argument);
    case Dependence::states:
      return force.states.empty()
                 ? what + " that depends on how the ship moves and on its orders"
                 : fmt::format("{} that depends on the {}", what, fmt::join(words_of(force.states), " and the "));
    case Dependence::time:
      break;
  }
  return what + " that comes and goes";
}

}  // namespace leeway::gap
