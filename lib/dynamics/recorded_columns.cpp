#include "dynamics/recorded_columns.hpp"

#include "ship/pitch_current.hpp"

namespace leeway {

const std::vector<std::string>& RecordedColumns::bow_thruster_words() {
  static const std::vector<std::string> words{"n_bt_rps", "i_bt"};
  return words;
}

const std::vector<std::string>& RecordedColumns::wind_words() {
  static const std::vector<std::string> words{"both", "true", "apparent"};
  return words;
}

RecordedColumns parse_recorded_columns(const io::JsonObject& json) {
  RecordedColumns columns;
  if (json.has("bow_thruster")) columns.bow_thruster = json.word("bow_thruster", RecordedColumns::bow_thruster_words());
  if (json.has("wind")) columns.wind = json.word("wind", RecordedColumns::wind_words());
  json.check_all_known();
  return columns;
}

void complete_truth(Trajectory& truth, const RecordedColumns& columns, const Ship& ship) {
  if (columns.bow_thruster == "i_bt") add_pitch_current(truth, ship);
}

void leave_recorded(Trajectory& recording, const RecordedColumns& columns) {
  if (columns.bow_thruster == "i_bt") recording[Channel::n_bt].clear();
  if (columns.wind == "apparent")
    for (const Channel channel : {Channel::wind_speed, Channel::wind_dir}) recording[channel].clear();
  if (columns.wind == "true")
    for (const Channel channel : {Channel::app_wind_speed, Channel::app_wind_dir}) recording[channel].clear();
}

}  // namespace leeway
