// Readers of CSV: recordings, schedules, predictions.

#include <cmath>
#include <cstdlib>
#include <optional>
#include <set>

#include "core/errors.hpp"
#include "core/units.hpp"
#include "dynamics/schedule.hpp"
#include "fuzz/readers.hpp"
#include "io/prediction_csv.hpp"
#include "io/trajectory_csv.hpp"
#include "metrics/particle_moments.hpp"

namespace leeway::test {
namespace {

std::vector<std::string> split(const std::string& text, char at) {
  std::vector<std::string> parts(1);
  for (const char c : text)
    if (c == at)
      parts.emplace_back();
    else
      parts.back() += c;
  return parts;
}

std::string trimmed(const std::string& text) {
  const std::size_t first = text.find_first_not_of(" \t");
  return first == std::string::npos ? "" : text.substr(first, text.find_last_not_of(" \t") + 1 - first);
}

// What the simplest of readers makes of a text without quotation marks, comments, CR and byte-order mark: the numbers
// of a column, NaN for empty fields, and how many of its rows have another number of fields than the header.
struct PlainColumn {
  std::vector<double> numbers;
  std::size_t crooked_rows = 0;
};

std::optional<PlainColumn> plain_column(std::string_view text, const std::string& name) {
  if (text.find_first_of("\"#\r\xEF") != std::string_view::npos) return std::nullopt;
  PlainColumn column;
  std::vector<std::string> header;
  std::size_t place = 0;
  for (const std::string& line : split(std::string(text), '\n')) {
    if (line.empty()) continue;
    const std::vector<std::string> fields = split(line, ',');
    if (header.empty()) {
      header = fields;
      while (place < header.size() && trimmed(header[place]) != name) ++place;
      if (place == header.size()) return std::nullopt;
      continue;
    }
    column.crooked_rows += fields.size() != header.size() ? 1 : 0;
    const std::string field = place < fields.size() ? trimmed(fields[place]) : "";
    const bool is_row_of_blanks = line.find_first_not_of(" \t,") == std::string::npos;
    if (!is_row_of_blanks) column.numbers.push_back(field.empty() ? kMissing : std::strtod(field.c_str(), nullptr));
  }
  return column;
}

void expect_plain(std::string_view text, const std::string& name, const std::vector<double>& read, double factor) {
  const auto plain = plain_column(text, name);
  if (!plain) return;
  expect(plain->crooked_rows == 0, "a row with more or fewer fields than the header is accepted");
  expect(plain->numbers.size() == read.size(), "another number of rows than there are");
  for (std::size_t i = 0; i < read.size(); ++i)
    expect(same(plain->numbers[i] * factor, read[i]), "column " + name + ": another number than stands there");
}

void expect_sound(const Trajectory& read) {
  expect(read.size() > 0 && read.has(Channel::u) && read.has(Channel::vm) && read.has(Channel::r), "columns lack");
  const std::vector<double>& t = read[Channel::t];
  for (std::size_t i = 0; i < t.size(); ++i)
    expect(std::abs(t[i]) <= kFarthestTime_s && (i == 0 || t[i] > t[i - 1]), "times do not increase");
  for (const ChannelInfo& channel : kChannels) {
    const std::vector<double>& values = read[channel.channel];
    expect(values.empty() || values.size() == t.size(), "columns differ in length");
    for (const double value : values) expect(!std::isinf(value), "an infinite number is accepted");
  }
}

void expect_same(const Trajectory& a, const Trajectory& b) {
  for (const ChannelInfo& channel : kChannels) {
    const auto &x = a[channel.channel], &y = b[channel.channel];
    expect(x.size() == y.size(), "written and read again, columns or rows differ");
    // Of a step of just half a turn rounding decides the side.
    const bool is_unwrapped = channel.channel == Channel::psi || channel.role == Role::azimuth;
    for (std::size_t i = 0; i < x.size(); ++i)
      expect(same(x[i], y[i]) || (is_unwrapped && std::abs(std::remainder(x[i] - y[i], 2.0 * kPi)) <=
                                                      1e-14 * std::max(std::abs(x[i]), std::abs(y[i])) + 1e-14),
             fmt::format("written and read again, {} differs: {} and {}", channel.name, x[i], y[i]));
  }
  expect(a.ignored_columns == b.ignored_columns && a.ignored_texts == b.ignored_texts,
         "written and read again, unknown columns differ");
}

void expect_copied(HostileFiles& files, const Trajectory& read) {
  std::string written;
  try {
    written = io::trajectory_text(read);
  } catch (const NumericalError&) {  // too large for the unit of the column that is written
    return;
  }
  try {
    expect_same(read, io::read_trajectory(files.write("written.csv", written), nullptr, true));
  } catch (const InputError& error) {
    throw Misread(fmt::format("what was written is refused: {}", error.what()));
  }
}

void read_recording(HostileFiles& files, std::string_view text) {
  const Trajectory read = io::read_trajectory(files.write("rec.csv", text), nullptr, true);
  expect_sound(read);
  expect_plain(text, "t_s", read[Channel::t], 1.0);
  expect_plain(text, "vm_mps", read[Channel::vm], 1.0);
  expect_plain(text, "r_degps", read[Channel::r], kDegree);
  expect_copied(files, read);
}

void read_foreign_recording(HostileFiles& files, std::string_view text) {
  static const io::ColumnsMap map = [] {
    io::ColumnsMap made;
    const auto add = [&](Channel channel, const char* name, const char* unit) {
      const io::Unit known = *io::unit_of(info(channel).quantity, unit);
      made.columns.push_back({channel, {name, 0}, known, known.factor, 0.0});
    };
    add(Channel::t, "time", "s");
    add(Channel::u, "speed [kn]", "kn");
    add(Channel::vm, "v", "mps");
    add(Channel::r, "yaw rate", "radps");
    add(Channel::psi, "heading", "deg");
    made.missing = {"NaN", "-9999"};
    return made;
  }();
  const Trajectory read = io::read_trajectory(files.write("rec.csv", text), &map);
  expect_sound(read);
  if (text.find("-9999.") == std::string_view::npos && text.find("-9999e") == std::string_view::npos)
    for (const double v : read[Channel::vm]) expect(v != -9999.0, "a mark of missing samples is read as a number");
}

// A log of a ship: semicolons, decimal commas, Latin-1, date and time, latitude and longitude, course and speed.
void read_log(HostileFiles& files, std::string_view text) {
  static const io::ColumnsMap map = io::read_columns_map(files.write("map.json", R"({
    "file": {"delimiter": ";", "decimal": ",", "encoding": "latin-1", "skip_lines": 1,
             "time": {"from": ["Datum", 2], "format": "%d.%m.%Y %H:%M:%S"}, "velocity_frame": "course-and-speed",
             "position": "latitude-longitude", "scale_factor": 4},
    "latitude_deg": {"from": 3}, "longitude_deg": {"from": 4}, "speed_kn": "SOG", "course_deg": "COG",
    "psi_deg": {"from": "Kurs", "sign": -1, "offset": 3}, "r_degps": {"derive": "psi_deg"}})"));
  const Trajectory read = io::read_trajectory(files.write("rec.csv", text), &map);
  expect_sound(read);
  expect(read.is_derived(Channel::r), "a derived channel counts as measured");
  for (std::size_t i = 0; i < read.size(); ++i)
    expect(std::isnan(read[Channel::x0][i]) || std::abs(read[Channel::x0][i]) < 1e7, "a position beyond the earth");
}

// Times of day beside numbers, without a header.
void read_clock_text(HostileFiles& files, std::string_view text) {
  static const io::ColumnsMap map = io::read_columns_map(files.write("map.json", R"({
    "file": {"delimiter": "blank", "header": false, "time": {"from": 1, "format": "hms"}, "velocity_frame": "earth"},
    "u_mps": {"from": 2}, "vm_mps": {"from": 3}, "psi_deg": {"from": 4}, "r_degps": {"from": 5, "unit": "degpmin"}})"));
  expect_sound(io::read_trajectory(files.write("rec.txt", text), &map));
}

void read_schedule_text(HostileFiles& files, std::string_view text) {
  static const Ship ship = read_ship("vectwin-3m");
  const Schedule read = read_schedule(files.write("orders.csv", text), ship);
  expect(!read.channels.empty() && !read.rows.empty(), "no order");
  double before_s = -1.0;
  for (const Schedule::Row& row : read.rows) {
    expect(row.t_s >= 0.0 && row.t_s > before_s, "times do not increase");
    expect(row.orders.size() == read.channels.size(), "rows differ in length");
    for (const double order : row.orders) expect(!std::isinf(order), "an infinite order is accepted");
    before_s = row.t_s;
  }
}

struct StoredRow {
  std::string recording;
  io::PredictionRow row;
};

std::vector<StoredRow> all_rows(const std::string& path) {
  io::PredictionReader reader(path);
  std::vector<StoredRow> rows;
  for (io::PredictionRow row; reader.next(row);) rows.push_back({std::string(row.recording), row});
  return rows;
}

void read_prediction_text(HostileFiles& files, std::string_view text) {
  const std::string path = files.write("pred.csv", text);
  const std::vector<StoredRow> rows = all_rows(path);
  std::set<std::string> known;
  std::vector<double> times, speeds;
  for (const StoredRow& stored : rows) {
    known.insert(stored.recording);
    times.push_back(stored.row.t_s);
    speeds.push_back(stored.row.nu(0));
  }
  expect_plain(text, "t_s", times, 1.0);
  expect_plain(text, "u_mps", speeds, 1.0);
  if (known.size() > 1) known.erase(known.begin());  // and one that has no truth
  std::size_t particles = 0;
  for (const PredictedRecording& recording : read_prediction(path, known)) {
    expect(known.contains(recording.name), "a recording without truth is accepted");
    for (const auto& [number, sequence] : recording.sequences)
      for (const PredictedSequence::Step& step : sequence.steps) particles += step.moments.count();
  }
  expect(particles == rows.size(), "particles are lost");
}

}  // namespace

const std::vector<Reader>& csv_readers() {
  static const std::vector<Reader> all{
      {"recording", "", read_recording},    {"foreign-recording", "", read_foreign_recording},
      {"ship-log", "", read_log},           {"clock-times", "", read_clock_text},
      {"schedule", "", read_schedule_text}, {"prediction", "", read_prediction_text}};
  return all;
}

}  // namespace leeway::test
