#include "foreign/raw_table.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "core/errors.hpp"
#include "foreign/column_names.hpp"
#include "io/byte_source.hpp"
#include "io/text_encoding.hpp"
#include "recording/trajectory.hpp"

namespace leeway::foreign {
namespace {

constexpr std::size_t kHeadBytes = 1 << 17, kMostHeadBytes = 1 << 25, kHeadLines = 64, kMostRows = 200'000,
                      kMostNumbers = 20'000'000, kLongestMark = 10;

std::string head_of(const std::string& path) {
  io::ByteSource source(path);
  std::string head;
  bool has_more = true;
  std::size_t lines = 0;
  for (std::size_t length = 0; has_more && (length < kHeadBytes || (lines < kHeadLines && length < kMostHeadBytes));) {
    head.resize(length + kHeadBytes);
    const std::size_t got = source.read(head.data() + length, kHeadBytes);
    has_more = got > 0;
    head.resize(length + got);
    lines += static_cast<std::size_t>(std::count(head.begin() + static_cast<std::ptrdiff_t>(length), head.end(), '\n'));
    length += got;
  }
  if (has_more) head.resize(head.find_last_of('\n') + 1);  // whole lines alone
  if (head.starts_with("\xEF\xBB\xBF")) head.erase(0, 3);  // byte-order mark
  return head;
}

std::vector<std::string_view> lines_of(std::string_view text) {
  std::vector<std::string_view> lines;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    lines.push_back(line);
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

std::vector<std::string_view> split(std::string_view line, char delimiter) {
  std::vector<std::string_view> fields;
  if (delimiter == io::CsvForm::kBlank) {
    for (line = io::trim(line); !line.empty(); line = io::trim(line)) {
      const std::size_t end = std::min(line.find_first_of(" \t"), line.size());
      fields.push_back(line.substr(0, end));
      line.remove_prefix(end);
    }
    return fields;
  }
  for (;;) {
    const std::size_t mark = std::min(line.find_first_not_of(' '), line.size());
    const bool is_quoted = mark < line.size() && line[mark] == '"';
    std::size_t close = mark;  // of a quoted field; two marks in a row are one in it
    if (is_quoted) do
        close = line.find('"', close + 1);
      while (close != std::string_view::npos && close + 1 < line.size() && line[close + 1] == '"' && ++close > 0);
    const bool is_closed = is_quoted && close != std::string_view::npos;
    const std::size_t end = std::min(line.find(delimiter, is_closed ? close : 0), line.size());
    fields.push_back(is_closed ? line.substr(mark + 1, close - mark - 1) : io::trim(line.substr(0, end)));
    if (end == line.size()) return fields;
    line.remove_prefix(end + 1);
  }
}

bool is_number(std::string_view field, bool decimal_comma) {
  double value = 0.0;
  return decimal_comma ? io::parse_number_with_comma(field, value) : io::parse_number(field, value);
}

// A line of the table: as many fields as most have, and more numbers than anything else.
struct Layout {
  char delimiter;
  bool decimal_comma;
  std::size_t width = 0;
  double score = 0.0;  // fields that are numbers, by line

  bool is_row(std::string_view line) const {
    const std::vector<std::string_view> fields = split(line, delimiter);
    const auto numbers = std::count_if(fields.begin(), fields.end(),
                                       [&](std::string_view field) { return is_number(field, decimal_comma); });
    const auto empty =
        std::count_if(fields.begin(), fields.end(), [](std::string_view field) { return field.empty(); });
    return fields.size() == width && numbers > 0 && 2 * numbers >= static_cast<std::ptrdiff_t>(width) - empty;
  }
};

Layout layout_of(const std::vector<std::string_view>& lines) {
  Layout best{',', false};
  const std::size_t first = lines.size() > 400 ? lines.size() - 400 : lines.size() / 2;
  for (const char delimiter : {',', ';', '\t', io::CsvForm::kBlank})
    for (const bool decimal_comma : {false, true}) {
      if (decimal_comma && delimiter == ',') continue;
      std::map<std::size_t, std::size_t> widths;
      for (std::size_t i = first; i < lines.size(); ++i)
        if (const std::size_t n = split(lines[i], delimiter).size(); n > 1) ++widths[n];
      Layout layout{delimiter, decimal_comma};
      std::size_t most = 0;
      for (const auto& [width, count] : widths)
        if (count > most) {
          most = count;
          layout.width = width;
        }
      double numbers = 0.0;
      for (std::size_t i = first; i < lines.size(); ++i) {
        const std::vector<std::string_view> fields = split(lines[i], delimiter);
        if (fields.size() != layout.width) continue;
        for (const std::string_view field : fields) numbers += is_number(field, decimal_comma) ? 1.0 : 0.0;
      }
      layout.score = numbers / static_cast<double>(std::max<std::size_t>(1, lines.size() - first));
      if (layout.width >= 2 && layout.score > best.score * 1.01) best = layout;
    }
  return best;
}

// Where the table begins, and what its columns are called.
void find_header(const std::vector<std::string_view>& lines, const Layout& layout, RawTable& table) {
  std::size_t data = 0;
  while (data < lines.size() && !layout.is_row(lines[data])) ++data;
  const auto fields_of = [&](std::size_t line) {
    std::string_view text = lines[line];
    if (text.starts_with('#')) text.remove_prefix(1);
    std::vector<std::string> fields;
    for (const std::string_view field : split(text, layout.delimiter)) {
      const std::string name(field);
      fields.push_back(table.form.encoding == io::Encoding::latin1 ? io::utf8_of_latin1(name) : name);
    }
    return fields.size() == layout.width ? fields : std::vector<std::string>{};
  };
  table.form.has_header = false;
  table.form.skip_lines = data;
  if (data == 0) return;
  table.names = fields_of(data - 1);
  if (table.names.empty()) return;
  const bool are_units = data > 1 && std::all_of(table.names.begin(), table.names.end(),
                                                 [](const std::string& text) { return text.empty() || is_unit(text); });
  if (are_units) {
    table.units = table.names;
    table.names = fields_of(data - 2);
    return;
  }
  if (lines[data - 1].starts_with('#')) return;  // a comment to the reader
  table.form.has_header = true;
  table.form.skip_lines = data - 1;
}

void note_missing(std::string_view text, std::set<std::string>& marks) {
  if (!text.empty() && text.size() <= kLongestMark && marks.size() < 8) marks.emplace(text);
}

// A number far beyond all others that stands again and again marks missing samples.
void find_marks(std::vector<double>& column, std::set<std::string>& marks) {
  for (const double mark : {-9999.0, -999.0, 9999.0, 99999.0, -99999.0}) {
    if (std::count(column.begin(), column.end(), mark) < 2) continue;
    double largest = 0.0;
    for (const double value : column)
      if (!std::isnan(value) && value != mark) largest = std::max(largest, std::abs(value));
    if (largest * 2.0 >= std::abs(mark)) continue;
    std::replace(column.begin(), column.end(), mark, kMissing);
    std::string text;
    io::append_number(text, mark);
    marks.insert(text);
  }
}

bool has_number(const io::CsvReader& csv, const std::vector<std::string_view>& fields) {
  return std::any_of(fields.begin(), fields.end(), [&](std::string_view field) {
    double value = 0.0;
    return csv.is_number(field, value);
  });
}

void read_texts(const std::string& path, const std::vector<std::size_t>& columns, RawTable& table) {
  io::CsvReader csv(path, table.form);
  std::vector<std::string_view> fields;
  const std::size_t most_rows = std::min(kMostRows, kMostNumbers / std::max<std::size_t>(1, table.texts.size()));
  for (std::size_t row = 0; row < most_rows && csv.next(fields); ++row)
    for (const std::size_t c : columns)
      if (has_number(csv, fields)) table.texts[c].emplace_back(io::trim(fields[c]));
}

void read_numbers(const std::string& path, RawTable& table) {
  io::CsvReader csv(path, table.form);
  const std::size_t width = csv.header().size();
  table.columns.resize(width);
  table.texts.resize(width);
  std::vector<std::size_t> others(width);
  std::vector<std::set<std::string>> marks(width);
  std::vector<std::string_view> fields;
  const std::size_t most_rows = std::min(kMostRows, kMostNumbers / std::max<std::size_t>(1, width));
  for (std::size_t row = 0; row < most_rows && csv.next(fields); ++row) {
    if (!has_number(csv, fields)) {  // passed over by the reader as well
      for (const std::string_view field : fields) note_missing(io::trim(field), marks.front());
      continue;
    }
    for (std::size_t c = 0; c < width; ++c) {
      double value = kMissing;
      if (!csv.is_number(fields[c], value)) {
        value = kMissing;
        const std::string_view text = io::trim(fields[c]);
        others[c] += text.empty() ? 0 : 1;
        note_missing(text, marks[c]);
      }
      table.columns[c].push_back(value);
    }
  }
  std::set<std::string> all;
  std::vector<std::size_t> text_columns;
  for (std::size_t c = 0; c < width; ++c) {
    if (2 * others[c] > table.rows()) {
      text_columns.push_back(c);
      continue;
    }
    find_marks(table.columns[c], marks[c]);
    all.insert(marks[c].begin(), marks[c].end());
  }
  table.missing.assign(all.begin(), all.end());
  if (!text_columns.empty()) read_texts(path, text_columns, table);
}

}  // namespace

RawTable read_raw_table(const std::string& path) {
  const std::string head = head_of(path);
  RawTable table;
  table.form.is_foreign = true;
  table.form.encoding = io::is_utf8(head) ? io::Encoding::utf8 : io::Encoding::latin1;
  const std::vector<std::string_view> lines = lines_of(head);
  const Layout layout = layout_of(lines);
  if (layout.width < 2)
    throw InputError(path,
                     "no table of numbers is found, by comma, semicolon, tab or blanks; expected two columns or more");
  table.form.delimiter = layout.delimiter;
  table.form.decimal_comma = layout.decimal_comma;
  find_header(lines, layout, table);
  read_numbers(path, table);
  return table;
}

}  // namespace leeway::foreign
