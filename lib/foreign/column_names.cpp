#include "foreign/column_names.hpp"

#include <algorithm>
#include <cctype>
#include <initializer_list>
#include <utility>
#include <vector>

#include "core/units.hpp"
#include "io/channel_units.hpp"

namespace leeway::foreign {
namespace {

std::string lower(std::string_view text) {
  std::string result;
  for (const char c : text) result += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return result;
}

struct UnitWord {
  std::string_view word, unit;
  double scale = 1.0;
};
constexpr double kNauticalMile_m = 1852.0;
constexpr UnitWord kUnitWords[] = {
    {"s", "s"},
    {"sec", "s"},
    {"seconds", "s"},
    {"ms", "ms"},
    {"msec", "ms"},
    {"min", "min"},
    {"minutes", "min"},
    {"h", "h"},
    {"hr", "h"},
    {"hours", "h"},
    {"d", "h", 24.0},
    {"days", "h", 24.0},
    {"m", "m"},
    {"meter", "m"},
    {"cm", "m", 0.01},
    {"mm", "m", 0.001},
    {"km", "m", 1000.0},
    {"ft", "m", kFoot_m},
    {"feet", "m", kFoot_m},
    {"nm", "m", kNauticalMile_m},
    {"nmi", "m", kNauticalMile_m},
    {"sm", "m", kNauticalMile_m},
    {"m/s", "mps"},
    {"mps", "mps"},
    {"m/sec", "mps"},
    {"m s-1", "mps"},
    {"cm/s", "mps", 0.01},
    {"mm/s", "mps", 0.001},
    {"ft/s", "mps", kFoot_m},
    {"fps", "mps", kFoot_m},
    {"m/min", "mps", 1.0 / 60.0},
    {"kn", "kn"},
    {"kt", "kn"},
    {"kts", "kn"},
    {"knots", "kn"},
    {"knot", "kn"},
    {"nm/h", "kn"},
    {"km/h", "kmh"},
    {"kmh", "kmh"},
    {"kph", "kmh"},
    {"mph", "kmh", 1.609344},
    {"deg", "deg"},
    {"degree", "deg"},
    {"degrees", "deg"},
    {"\xC2\xB0", "deg"},
    {"rad", "rad"},
    {"mrad", "rad", 0.001},
    {"deg/s", "degps"},
    {"degps", "degps"},
    {"deg/sec", "degps"},
    {"\xC2\xB0/s", "degps"},
    {"rad/s", "radps"},
    {"radps", "radps"},
    {"rad/sec", "radps"},
    {"mrad/s", "radps", 0.001},
    {"deg/min", "degpmin"},
    {"degpmin", "degpmin"},
    {"\xC2\xB0/min", "degpmin"},
    {"rpm", "rpm"},
    {"1/min", "rpm"},
    {"min-1", "rpm"},
    {"u/min", "rpm"},
    {"rev/min", "rpm"},
    {"rps", "rps"},
    {"1/s", "rps"},
    {"rev/s", "rps"},
    {"hz", "rps"},
    {"s-1", "rps"},
};

const UnitWord* unit_word(std::string_view text) {
  std::string word = lower(text);
  std::erase_if(word, [](char c) { return c == '[' || c == ']' || c == '(' || c == ')'; });
  while (!word.empty() && word.front() == ' ') word.erase(0, 1);
  while (!word.empty() && word.back() == ' ') word.pop_back();
  for (const UnitWord& known : kUnitWords)
    if (word == known.word) return &known;
  return nullptr;
}

// A name's words and its unit.
struct Words {
  std::vector<std::string> words;
  const UnitWord* unit = nullptr;
  std::string bracketed;  // what stands in brackets and is no unit that is known

  explicit Words(std::string_view name) {
    std::string rest(name);
    for (const auto& [open, close] : {std::pair{'[', ']'}, std::pair{'(', ')'}}) {
      const std::size_t from = rest.find(open), to = rest.find(close, from == std::string::npos ? 0 : from);
      if (from == std::string::npos || to == std::string::npos) continue;
      if (unit == nullptr) {
        unit = unit_word(rest.substr(from, to - from + 1));
        bracketed = unit == nullptr ? rest.substr(from + 1, to - from - 1) : "";
      }
      rest.erase(from, to - from + 1);
    }
    std::string word;
    const auto end_word = [&] {
      if (!word.empty()) words.push_back(lower(word));
      word.clear();
    };
    for (std::size_t i = 0; i < rest.size(); ++i) {
      const auto c = static_cast<unsigned char>(rest[i]);
      const bool is_hump = std::isupper(c) != 0 && i > 0 && std::islower(static_cast<unsigned char>(rest[i - 1])) != 0;
      if (is_hump || (std::isalnum(c) == 0 && c < 0x80)) end_word();
      if (std::isalnum(c) != 0 || c >= 0x80) word += rest[i];
    }
    end_word();
    if (unit == nullptr && words.size() > 1)  // "x_m", "n_rpm": letters alone are words as well
      if (unit = unit_word(words.back()); unit != nullptr) words.pop_back();
  }
  bool has(std::initializer_list<std::string_view> any) const {
    return std::any_of(words.begin(), words.end(),
                       [&](const std::string& word) { return std::find(any.begin(), any.end(), word) != any.end(); });
  }
  // Whether a word begins so.
  bool begins(std::initializer_list<std::string_view> any) const {
    return std::any_of(words.begin(), words.end(), [&](const std::string& word) {
      return std::any_of(any.begin(), any.end(), [&](std::string_view start) { return word.starts_with(start); });
    });
  }
};

NamedColumn of_channel(Channel channel, bool is_earth = false) { return {Meaning::channel, channel, "", is_earth}; }

NamedColumn wind(const Words& w) {
  const bool is_apparent = w.begins({"rel", "app", "aws", "awa", "awd"}),
             is_angle = w.begins({"dir", "ang", "twd", "awa", "awd", "from"});
  if (w.has({"twa"})) return {Meaning::other};
  if (is_apparent) return of_channel(is_angle ? Channel::app_wind_dir : Channel::app_wind_speed);
  return of_channel(is_angle ? Channel::wind_dir : Channel::wind_speed);
}

NamedColumn rudder(const Words& w) {
  if (w.begins({"cmd", "com", "ord", "set", "ref", "soll", "des"})) return {Meaning::other};
  if (w.has({"p", "port", "ps", "left", "bb"})) return of_channel(Channel::delta_p);
  if (w.has({"s", "starboard", "stbd", "sb", "right"})) return of_channel(Channel::delta_s);
  return of_channel(Channel::delta);
}

NamedColumn driven(const Words& w) {
  if (w.begins({"torque", "thrust", "power", "pitch", "cmd", "ord", "set", "load"}) && !w.begins({"thruster"}))
    return {Meaning::other};
  if (w.has({"bow", "bt"})) return of_channel(Channel::n_bt);
  if (w.has({"stern", "st"})) return of_channel(Channel::n_st);
  return of_channel(Channel::n_p);
}

NamedColumn meaning(const Words& w) {
  if (w.begins({"wind", "wnd", "tws", "twd", "twa", "aws", "awa", "awd"})) return wind(w);
  if (w.begins({"rudder", "rudd", "ruder", "helm", "delta"})) return rudder(w);
  if (w.begins({"prop", "rpm", "shaft", "engine", "screw", "revol", "drehzahl", "thruster", "nprop"}) ||
      w.has({"n", "bt"}))
    return driven(w);
  if (w.begins(
          {"roll", "pitch", "heave", "phi", "theta", "trim", "draft", "draught", "torque", "thrust", "power", "depth"}))
    return {Meaning::other};
  if (w.begins({"lat", "breite"}) && !w.begins({"lateral"})) return {Meaning::latitude};
  if (w.begins({"lon", "lng", "laenge"}) && !w.begins({"longitudinal"})) return {Meaning::longitude};
  if (w.has({"rot", "yawrate", "angvelo", "r", "yawvel", "gierrate", "drehrate"}) ||
      (w.begins({"rate"}) && w.begins({"turn", "yaw", "head"})) ||
      (w.has({"yaw"}) && w.begins({"vel", "speed", "rate"})))
    return of_channel(Channel::r);
  if (w.has({"psi", "heading", "hdg", "head", "yaw", "gyro", "hdt", "thdg", "gierwinkel"}))
    return of_channel(Channel::psi);
  if (w.has({"cog", "course", "track", "cmg"})) return {Meaning::course};
  if (w.has({"stw", "log"}) || (w.has({"water"}) && w.begins({"speed"}))) return {Meaning::other};
  if (w.has({"u", "surge"})) return of_channel(Channel::u);
  if (w.has({"v", "vm", "sway"})) return of_channel(Channel::vm);
  if (w.has({"vx", "vn", "xdot", "dx", "vnorth", "dxdt"}) || (w.begins({"vel", "speed"}) && w.has({"north", "x", "n"})))
    return of_channel(Channel::u, true);
  if (w.has({"vy", "ve", "ydot", "dy", "veast", "dydt"}) || (w.begins({"vel", "speed"}) && w.has({"east", "y", "e"})))
    return of_channel(Channel::vm, true);
  if (w.has({"sog", "speed", "smg"})) return {Meaning::speed};
  if (w.has({"x", "x0", "xpos", "north", "northing", "nord"})) return of_channel(Channel::x0);
  if (w.has({"y", "y0", "ypos", "east", "easting", "ost"})) return of_channel(Channel::y0);
  if (w.has({"date", "datum", "day"}) && !w.begins({"time"})) return {Meaning::date};
  if (w.has({"t", "time", "zeit", "timestamp", "utc", "clock", "uhrzeit", "elapsed", "date", "datetime"}))
    return {Meaning::clock};
  return {};
}

Quantity quantity_of(const NamedColumn& column) {
  switch (column.meaning) {
    case Meaning::latitude:
    case Meaning::longitude:
    case Meaning::course:
      return Quantity::angle;
    case Meaning::speed:
      return Quantity::speed;
    case Meaning::channel:
      return info(column.channel).quantity;
    default:
      return Quantity::time;
  }
}

}  // namespace

bool is_unit(std::string_view text) { return unit_word(text) != nullptr || text == "-" || text == "[-]"; }

NamedColumn meaning_of_name(std::string_view name, std::string_view unit_below) {
  if (const auto own = io::known_column(name)) {  // leeway's own names are meant as they stand
    NamedColumn column = own->channel == Channel::t ? NamedColumn{Meaning::clock} : of_channel(own->channel);
    column.unit = own->unit.suffix;
    column.is_own = true;
    return column;
  }
  const Words words(name);
  NamedColumn column = meaning(words);
  const UnitWord* unit = unit_below.empty() ? words.unit : unit_word(unit_below);
  const std::string text(unit_below.empty() ? words.bracketed : unit == nullptr ? unit_below : "");
  if (unit == nullptr && words.has({"rpm"})) unit = unit_word("rpm");
  if (unit != nullptr && unit->unit == "ms" && quantity_of(column) == Quantity::speed) unit = unit_word("m/s");
  const bool is_length = unit != nullptr && unit->unit == "m";
  if (is_length && words.has({"n"})) column = of_channel(Channel::x0);  // northing, and no revolutions
  if (is_length && words.has({"e"})) column = of_channel(Channel::y0);
  column.is_time_of_day = column.meaning == Meaning::clock && (words.has({"hhmmss"}) || text.starts_with("hhmmss"));
  if (unit != nullptr && io::unit_of(quantity_of(column), unit->unit)) {
    column.unit = unit->unit;
    column.scale = unit->scale;
  } else if (unit != nullptr && column.meaning != Meaning::unknown && column.meaning != Meaning::other) {
    return {.foreign_unit = std::string(unit->word)};  // a unit of something else: the name means something else
  } else if (!column.is_time_of_day && text != "-") {
    column.foreign_unit = text;
  }
  return column;
}

}  // namespace leeway::foreign
