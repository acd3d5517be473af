#include "foreign/proposal.hpp"

#include <algorithm>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/errors.hpp"
#include "foreign/clock_columns.hpp"
#include "foreign/column_roles.hpp"
#include "foreign/motion_fit.hpp"
#include "foreign/raw_table.hpp"
#include "io/files.hpp"

namespace leeway::foreign {
namespace {

using io::Json;

// The column's name where that is enough to find it.
Json reference(const RawTable& table, std::size_t column) {
  const bool is_unique = table.form.has_header && !table.names[column].empty() &&
                         std::count(table.names.begin(), table.names.end(), table.names[column]) == 1;
  return is_unique ? Json(table.names[column]) : Json(column + 1);
}

Json entry(const RawTable& table, const RoleColumn& role, const std::string& key_unit) {
  const Json from = reference(table, role.column);
  Json json{{"from", from}};
  if (!role.unit.empty() && role.unit != key_unit) json["unit"] = role.unit;
  if (role.scale != 1.0) json["scale"] = role.scale;
  if (role.sign < 0.0) json["sign"] = -1;
  return json.size() == 1 && from.is_string() ? from : json;
}

Json file_json(const RawTable& table, const FoundClock& clock, const Roles& roles) {
  Json file = Json::object();
  const char delimiter = table.form.delimiter;
  if (delimiter != ',')
    file["delimiter"] = delimiter == '\t' ? "tab" : delimiter == io::CsvForm::kBlank ? "blank" : ";";
  if (table.form.decimal_comma) file["decimal"] = ",";
  if (table.form.skip_lines > 0) file["skip_lines"] = table.form.skip_lines;
  if (!table.form.has_header) file["header"] = false;
  if (table.form.encoding == io::Encoding::latin1) file["encoding"] = "latin-1";
  if (clock.sample_interval_s) file["sample_interval_s"] = *clock.sample_interval_s;
  if (!clock.format.empty()) {
    Json from = Json::array();
    for (const std::size_t c : clock.columns) from.push_back(reference(table, c));
    file["time"] = {{"from", from.size() == 1 ? from[0] : from}, {"format", clock.format}};
  }
  if (roles.frame != io::VelocityFrame::ship)
    file["velocity_frame"] = roles.frame == io::VelocityFrame::earth ? "earth" : "course-and-speed";
  if (roles.position == io::PositionForm::latitude_longitude) file["position"] = "latitude-longitude";
  return file;
}

// The key of a channel, and the unit that it has by itself.
std::pair<std::string, std::string> key_of(Channel channel, const Roles& roles) {
  const bool is_course = roles.frame == io::VelocityFrame::course_and_speed;
  if (is_course && channel == Channel::u) return {"speed_mps", "mps"};
  if (is_course && channel == Channel::vm) return {"course_deg", "deg"};
  if (roles.position == io::PositionForm::latitude_longitude && channel == Channel::x0) return {"latitude_deg", "deg"};
  if (roles.position == io::PositionForm::latitude_longitude && channel == Channel::y0) return {"longitude_deg", "deg"};
  return {column_name(channel), std::string(info(channel).unit)};
}

void derive_what_lacks(const Roles& roles, Proposal& proposal) {
  const auto has = [&](Channel channel) { return roles.channels.contains(channel); };
  const bool has_pose = has(Channel::x0) && has(Channel::y0) && has(Channel::psi);
  for (const DerivableChannel& derivable : kDerivableChannels) {
    if (has(derivable.channel)) continue;
    const std::string key = column_name(derivable.channel);
    if (derivable.channel == Channel::r ? has(Channel::psi) : has_pose)
      proposal.map[key] = {{"derive", column_name(derivable.of)}};
    else
      proposal.unknowable.push_back(
          fmt::format("no column is found for {}, which every recording needs: the map is not complete", key));
  }
}

void note_unread(const RawTable& table, const FoundClock& clock, const Roles& roles, std::vector<std::string>& notes) {
  std::set<std::size_t> read(clock.columns.begin(), clock.columns.end());
  for (const auto& [channel, role] : roles.channels) read.insert(role.column);
  std::string unread;
  for (std::size_t c = 0; c < table.columns.size(); ++c)
    if (!read.contains(c))
      unread += (unread.empty() ? "" : ", ") +
                (c < table.names.size() && !table.names[c].empty() ? table.names[c] : fmt::format("{}", c + 1));
  if (!unread.empty()) notes.push_back("not read: " + unread);
}

// Roles with the clock that makes positions and velocities, or heading and yaw rate, fit each other: as it is, unless
// another reading fits twice as well.
Roles roles_by(const RawTable& table, const std::vector<NamedColumn>& meanings, FoundClock& clock) {
  constexpr double kMuchBetter = 0.5;
  Roles roles = find_roles(table, meanings, clock);
  if (!clock.is_assumed) return roles;
  if (!roles.misfit) {
    clock.note = "the unit of time: seconds are assumed, and nothing is there to compare with";
    return roles;
  }
  if (meanings.empty()) return roles;  // recognized by this clock
  for (FoundClock& other : other_readings(table, clock)) {
    Roles read = find_roles(table, meanings, other);
    if (!read.misfit || *read.misfit > kFits || *read.misfit > kMuchBetter * *roles.misfit) continue;
    read.findings.push_back(fmt::format("time is in {}: otherwise the motion fits to {:.0f} % alone",
                                        other.format == "hms" ? std::string("hhmmss")
                                        : other.scale != 1.0  ? std::string("days")
                                                              : other.unit,
                                        100.0 * *roles.misfit));
    clock = std::move(other);
    roles = std::move(read);
  }
  return roles;
}

// A map that the reader does not take is not complete: the note says why.
void check_map(Proposal& proposal) {
  try {
    io::columns_map_of(proposal.map, "map");
  } catch (const InputError& error) {
    proposal.unknowable.push_back(fmt::format("the map is not complete: {}", error.what()));
  }
}

}  // namespace

Proposal propose_columns_map(const std::string& path) {
  const RawTable table = read_raw_table(path);
  std::vector<NamedColumn> meanings;
  for (std::size_t c = 0; c < table.names.size(); ++c)
    meanings.push_back(meaning_of_name(table.names[c], c < table.units.size() ? table.units[c] : ""));
  const bool has_meaning = std::any_of(meanings.begin(), meanings.end(), [](const NamedColumn& named) {
    return named.meaning != Meaning::unknown && named.meaning != Meaning::clock;
  });
  if (!has_meaning) meanings.clear();
  Proposal proposal;
  std::optional<FoundClock> clock = find_clock(table, meanings);
  if (!clock) {
    clock.emplace();
    clock->sample_interval_s = 1.0;
    for (std::size_t i = 0; i < table.rows(); ++i) clock->t.push_back(static_cast<double>(i));
    clock->note = "no column is a clock: 1 s from row to row stands in its place; put the right interval there";
  }
  const Roles roles = roles_by(table, meanings, *clock);
  if (!clock->note.empty()) proposal.unknowable.push_back(clock->note);
  proposal.unknowable.insert(proposal.unknowable.end(), roles.unknowable.begin(), roles.unknowable.end());
  proposal.map["description"] =
      fmt::format("proposed for {}: to be checked by somebody who knows the recording", io::stem(path));
  proposal.map["notes"] = Json::array();
  if (!table.missing.empty()) proposal.map["missing"] = table.missing;
  if (const Json file = file_json(table, *clock, roles); !file.empty()) proposal.map["file"] = file;
  if (clock->format.empty() && !clock->sample_interval_s)
    proposal.map["t_s"] = entry(table, {clock->columns.front(), clock->unit, 1.0, clock->scale}, "s");
  for (const ChannelInfo& channel : kChannels) {
    const auto role = roles.channels.find(channel.channel);
    if (role == roles.channels.end()) continue;
    const auto [key, unit] = key_of(channel.channel, roles);
    proposal.map[key] = entry(table, role->second, unit);
  }
  derive_what_lacks(roles, proposal);
  check_map(proposal);
  std::vector<std::string> notes = roles.findings;
  note_unread(table, *clock, roles, notes);
  for (const std::string& note : proposal.unknowable) notes.push_back("not known: " + note);
  proposal.map["notes"] = notes;
  return proposal;
}

std::string map_text(const Proposal& proposal) {
  std::string text = "{\n";
  for (const auto& [key, value] : proposal.map.items()) {
    text += text.size() > 2 ? ",\n" : "";
    text += "  " + Json(key).dump() + ": ";
    if (key == "notes") {
      text += "[";
      for (std::size_t i = 0; i < value.size(); ++i) text += (i > 0 ? ",\n    " : "\n    ") + value[i].dump();
      text += value.empty() ? "]" : "\n  ]";
    } else {
      text += value.dump();
    }
  }
  return text + "\n}\n";
}

}  // namespace leeway::foreign
