#include "io/channel_units.hpp"

#include "core/units.hpp"

namespace leeway::io {
namespace {

struct ListedUnit {
  Unit unit;
  bool is_in_names;  // of leeway's columns; the others stand in columns maps alone
};

constexpr double kMinute_s = 60.0, kHour_s = 3600.0;

constexpr ListedUnit kUnits[] = {
    {{Quantity::time, "s", 1.0, "s"}, true},
    {{Quantity::time, "ms", 1e-3, "ms"}, false},
    {{Quantity::time, "min", kMinute_s, "min"}, false},
    {{Quantity::time, "h", kHour_s, "h"}, false},
    {{Quantity::length, "m", 1.0, "m"}, true},
    {{Quantity::speed, "mps", 1.0, "m/s"}, true},
    {{Quantity::speed, "kn", kKnot, "kn"}, true},
    {{Quantity::speed, "kmh", kKilometerPerHour, "km/h"}, false},
    {{Quantity::angle, "deg", kDegree, "deg"}, true},
    {{Quantity::angle, "rad", 1.0, "rad"}, true},
    {{Quantity::angular_rate, "degps", kDegree, "deg/s"}, true},
    {{Quantity::angular_rate, "radps", 1.0, "rad/s"}, true},
    {{Quantity::angular_rate, "degpmin", kDegree / kMinute_s, "deg/min"}, false},
    {{Quantity::revolutions, "rps", 1.0, "1/s"}, true},
    {{Quantity::revolutions, "rpm", 1.0 / kMinute_s, "1/min"}, false},
    {{Quantity::ratio, "", 1.0, ""}, true},
};

constexpr std::string_view kWords[] = {"time", "length", "speed", "angle", "angular rate", "revolutions", "ratio"};

}  // namespace

std::optional<Unit> unit_of(Quantity quantity, std::string_view suffix) {
  for (const ListedUnit& listed : kUnits)
    if (listed.unit.quantity == quantity && listed.unit.suffix == suffix) return listed.unit;
  return std::nullopt;
}

std::vector<std::string_view> units_of(Quantity quantity) {
  std::vector<std::string_view> suffixes;
  for (const ListedUnit& listed : kUnits)
    if (listed.unit.quantity == quantity) suffixes.push_back(listed.unit.suffix);
  return suffixes;
}

std::string_view described(Quantity quantity) { return kWords[static_cast<std::size_t>(quantity)]; }

std::string_view quantity_measured_in(std::string_view suffix) {
  for (const ListedUnit& listed : kUnits)
    if (!suffix.empty() && listed.unit.suffix == suffix) return described(listed.unit.quantity);
  return "";
}

std::optional<KnownColumn> known_column(std::string_view name) {
  for (const ChannelInfo& channel : kChannels) {
    if (!name.starts_with(channel.name)) continue;
    std::string_view rest = name.substr(channel.name.size());
    if (!rest.empty() && rest.front() != '_') continue;
    if (!rest.empty()) rest.remove_prefix(1);
    for (const ListedUnit& listed : kUnits)
      if (listed.is_in_names && listed.unit.quantity == channel.quantity && listed.unit.suffix == rest &&
          name.size() == channel.name.size() + (rest.empty() ? 0 : rest.size() + 1))
        return KnownColumn{channel.channel, listed.unit};
  }
  return std::nullopt;
}

}  // namespace leeway::io
