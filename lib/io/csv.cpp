#include "io/csv.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <iterator>
#include <unordered_set>
#include <utility>

#include <fmt/format.h>

#include "core/errors.hpp"
#include "io/text_encoding.hpp"

namespace leeway::io {
namespace {

constexpr std::size_t kFirstChunk = 1 << 15, kLargestChunk = 1 << 20;

}  // namespace

std::string_view trim(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
  return text;
}

bool parse_number(std::string_view field, double& value) {
  field = trim(field);
  if (field.size() > 1 && field.front() == '+' && field[1] != '-') field.remove_prefix(1);
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  return error == std::errc() && end == field.data() + field.size() && std::isfinite(value);
}

bool parse_number_with_comma(std::string_view field, double& value) {
  constexpr std::size_t kLongest = 400;  // no number of a recording has as many digits
  std::array<char, kLongest> text;       // filled as far as the field reaches
  field = trim(field);
  if (field.size() > kLongest || field.find('.') != std::string_view::npos) return false;
  std::replace_copy(field.begin(), field.end(), text.begin(), ',', '.');
  return parse_number({text.data(), field.size()}, value);
}

CsvReader::CsvReader(const std::string& path, CsvForm form) : file_(path), form_(form), source_(path) {
  while (end_ < 3 && fill()) {  // a pipe may give single bytes
  }
  if (end_ >= 3 && buffer_.compare(0, 3, "\xEF\xBB\xBF") == 0) begin_ = 3;
  pass_over_first_lines();
  read_header();
}

// The line from begin_ on; false where there is none.
bool CsvReader::skip_line() {
  if (begin_ == end_ && !fill()) return false;
  std::size_t newline = 0, searched = 0;
  while ((newline = buffer_.find('\n', begin_ + searched)) == std::string::npos || newline >= end_) {
    searched = end_ - begin_;
    if (!fill()) {
      newline = end_ - 1;
      break;
    }
  }
  refuse_lone_carriage_returns({buffer_.data() + begin_, newline - begin_}, lines_read_ + 1);
  begin_ = newline + 1;
  ++lines_read_;
  return true;
}

// Those that the form tells, then comments.
void CsvReader::pass_over_first_lines() {
  for (std::size_t i = 0; i < form_.skip_lines; ++i)
    if (!skip_line())
      throw InputError(file_, lines_read_ + 1, "",
                       fmt::format("the file ends here; expected {} lines before the table", form_.skip_lines));
  while ((begin_ < end_ || fill()) && buffer_[begin_] == '#') skip_line();
}

void CsvReader::read_header() {
  std::vector<std::string_view> fields;
  if (!next_record(fields)) {
    const bool is_empty = lines_read_ == 0 || form_.has_header;
    throw InputError(file_, lines_read_ + 1, "",
                     is_empty ? "the file is empty; expected a header row" : "expected a row of numbers, found none");
  }
  if (!form_.has_header) {
    for (std::size_t i = 0; i < fields.size(); ++i) header_.push_back(fmt::format("{}", i + 1));
    first_row_ = std::move(fields);
    return;
  }
  std::unordered_set<std::string> taken;
  for (const std::string_view field : fields) {
    const std::string name =
        form_.encoding == Encoding::latin1 ? utf8_of_latin1(trim(field)) : std::string(trim(field));
    check_name(name);
    if (!form_.is_foreign && !taken.insert(name).second)
      throw InputError(file_, line_, fmt::format("column '{}'", name), "stands twice");
    header_.push_back(name);
  }
}

void CsvReader::check_name(const std::string& name) const {
  refuse_lone_carriage_returns(name, line_);
  if (name.empty() && !form_.is_foreign)
    throw InputError(file_, line_, "", fmt::format("column {} has no name", header_.size() + 1));
  if (!is_utf8(name))
    throw InputError(file_, line_, fmt::format("column {}", header_.size() + 1),
                     "its name holds bytes that are not UTF-8; expected UTF-8, or a columns map that says "
                     "\"encoding\": \"latin-1\"");
}

std::string CsvReader::column_text(std::size_t column) const {
  return form_.has_header && !header_[column].empty() ? fmt::format("column '{}'", header_[column])
                                                      : fmt::format("column {}", column + 1);
}

bool CsvReader::is_number(std::string_view field, double& value) const {
  return form_.decimal_comma ? parse_number_with_comma(field, value) : parse_number(field, value);
}

// A file whose lines all end with CR alone is one long line to us.
void CsvReader::refuse_lone_carriage_returns(std::string_view text, std::size_t line) const {
  for (std::size_t at = 0; (at = text.find('\r', at)) != std::string_view::npos; ++at)
    if (at + 1 < text.size() && text[at + 1] != '\n')
      throw InputError(
          file_, line, "",
          "a carriage return within a line: lines that end with CR alone are not read; expected LF or CRLF");
}

std::size_t CsvReader::column(std::string_view name) const {
  const auto found = std::find(header_.begin(), header_.end(), name);
  if (found == header_.end())
    throw InputError(file_, 1, "", fmt::format("no column '{}'; found {}", name, listed(header_)));
  return static_cast<std::size_t>(found - header_.begin());
}

// Moves the unread rest to the front and appends what the file gives; false at its end.
bool CsvReader::fill() {
  if (at_end_) return false;
  if (begin_ > 0) {
    std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
    end_ -= begin_;
    begin_ = 0;
  }
  const std::size_t chunk = std::clamp(buffer_.size(), kFirstChunk, kLargestChunk);  // most files are short
  if (buffer_.size() < end_ + chunk / 2) buffer_.resize(end_ + chunk);
  const std::size_t got = source_.read(buffer_.data() + end_, buffer_.size() - end_);
  if (got == 0) at_end_ = true;
  end_ += got;
  return got > 0;
}

bool CsvReader::next(std::vector<std::string_view>& fields) {
  if (!first_row_.empty()) {
    fields = std::exchange(first_row_, {});
    return true;
  }
  if (!next_record(fields)) return false;
  if (fields.size() != header_.size())
    throw InputError(file_, line_, "", fmt::format("expected {} fields, found {}", header_.size(), fields.size()));
  return true;
}

// The length of the record from begin_ on, up to the first line end outside quotes; false at the end of the file.
bool CsvReader::find_record(std::vector<std::string_view>& fields, std::size_t& length, bool& quoted) {
  const bool has_quotes = form_.delimiter != CsvForm::kBlank;
  std::size_t search = begin_;
  std::size_t quotes_seen = 0, counted = 0;  // quotation marks in the first `counted` bytes of the record
  for (;;) {
    const void* newline = search < end_ ? std::memchr(buffer_.data() + search, '\n', end_ - search) : nullptr;
    if (newline != nullptr) {
      length = static_cast<std::size_t>(static_cast<const char*>(newline) - buffer_.data()) - begin_;
    } else {
      const std::size_t searched = end_ - begin_;
      if (fill()) {
        search = begin_ + searched;
        continue;
      }
      length = end_ - begin_;
      if (length == 0) return false;
    }
    if (!has_quotes) return true;
    const std::string_view fresh(buffer_.data() + begin_ + counted, length - counted);
    if (std::memchr(fresh.data(), '"', fresh.size()) != nullptr) {
      quotes_seen += static_cast<std::size_t>(std::count(fresh.begin(), fresh.end(), '"'));
      quoted = true;
    }
    if (newline == nullptr || quotes_seen % 2 == 0) return true;
    // The line end belongs to a quoted field, unless the quotation mark is wrong: then no more is read for it.
    line_ = lines_read_ + 1;
    if (counted == 0) split_quoted({buffer_.data() + begin_, length}, fields);
    search = begin_ + length + 1;
    counted = length;
  }
}

bool CsvReader::next_record(std::vector<std::string_view>& fields) {
  for (;;) {
    std::size_t length = 0;
    bool quoted = false;
    if (!find_record(fields, length, quoted)) return false;
    std::string_view record(buffer_.data() + begin_, length);
    begin_ = std::min(begin_ + length + 1, end_);
    line_ = lines_read_ + 1;
    lines_read_ += 1 + (quoted ? static_cast<std::size_t>(std::count(record.begin(), record.end(), '\n')) : 0);
    if (!record.empty() && record.back() == '\r') record.remove_suffix(1);
    if (record.empty() || (form_.is_foreign && trim(record).empty())) continue;
    if (quoted) {  // rare
      if (split_quoted(record, fields)) return true;
      throw InputError(file_, line_, "", "a quotation mark is not closed");
    }
    split(record, fields);
    return true;
  }
}

void CsvReader::split(std::string_view record, std::vector<std::string_view>& fields) const {
  fields.clear();
  if (form_.delimiter == CsvForm::kBlank) {
    const auto is_blank = [](char c) { return c == ' ' || c == '\t'; };
    for (record = trim(record); !record.empty();) {
      const auto end = std::find_if(record.begin(), record.end(), is_blank);
      const auto width = static_cast<std::size_t>(end - record.begin());
      fields.push_back(record.substr(0, width));
      record.remove_prefix(width);
      while (!record.empty() && is_blank(record.front())) record.remove_prefix(1);
    }
    return;
  }
  for (;;) {
    const void* delimiter = std::memchr(record.data(), form_.delimiter, record.size());
    if (delimiter == nullptr) break;
    const auto width = static_cast<std::size_t>(static_cast<const char*>(delimiter) - record.data());
    fields.push_back(record.substr(0, width));
    record.remove_prefix(width + 1);
  }
  fields.push_back(record);
}

// The fields of a record with quotation marks: their text is copied without these. False where the last one is open.
bool CsvReader::split_quoted(std::string_view record, std::vector<std::string_view>& fields) {
  enum class In { bare, quotes, after_quotes };
  fields.clear();
  unquoted_.clear();
  unquoted_.reserve(record.size());
  std::size_t start = 0;
  In in = In::bare;
  const auto refuse = [&](const char* problem) {
    const std::size_t n = fields.size();
    throw InputError(file_, line_, n < header_.size() ? column_text(n) : fmt::format("field {}", n + 1), problem);
  };
  const auto end_field = [&] {
    fields.emplace_back(unquoted_.data() + start, unquoted_.size() - start);
    start = unquoted_.size();
    in = In::bare;
  };
  for (std::size_t i = 0; i < record.size(); ++i) {
    const char c = record[i];
    if (in == In::quotes) {
      if (c != '"') {
        unquoted_ += c;
      } else if (i + 1 < record.size() && record[i + 1] == '"') {
        unquoted_ += record[++i];
      } else {
        in = In::after_quotes;
      }
    } else if (c == form_.delimiter) {
      end_field();
    } else if (c == '"') {
      if (in == In::after_quotes || !trim({unquoted_.data() + start, unquoted_.size() - start}).empty())
        refuse("a quotation mark within a field; one that holds any stands in quotation marks, and doubles them");
      unquoted_.resize(start);  // blanks before
      in = In::quotes;
    } else if (in == In::bare) {
      unquoted_ += c;
    } else if (c != ' ' && c != '\t') {
      refuse(form_.delimiter == ',' ? "text behind the closing quotation mark; expected a comma or the end of the line"
                                    : "text behind the closing quotation mark; expected the next field");
    }
  }
  const bool is_closed = in != In::quotes;
  end_field();
  return is_closed;
}

std::string listed(std::span<const std::string> names) {
  constexpr std::size_t kMost = 30, kLongest = 60;
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), kMost); ++i)
    text += (i > 0 ? ", " : "") + (names[i].size() > kLongest ? names[i].substr(0, kLongest) + "..." : names[i]);
  if (names.size() > kMost) text += fmt::format(" and {} more", names.size() - kMost);
  return text;
}

void append_number(std::string& text, double value) {
  if (std::isfinite(value)) fmt::format_to(std::back_inserter(text), "{}", value);
}

std::string csv_field(std::string_view text) {
  if (text.find_first_of(",\"\n\r") == std::string_view::npos) return std::string(text);
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + '"';
}

double CsvReader::number(std::string_view field, std::string_view column, std::string_view unit) const {
  double value = 0.0;
  if (is_number(field, value)) return value;
  throw InputError(file_, line_, fmt::format("column '{}'", column),
                   fmt::format("expected a finite number{}{}, got '{}'", unit.empty() ? "" : fmt::format(" [{}]", unit),
                               form_.decimal_comma ? " with a decimal comma" : "", field.substr(0, 40)));
}

std::size_t CsvReader::count(std::string_view field, std::string_view column) const {
  std::size_t value = 0;
  const std::string_view digits = trim(field);
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error == std::errc() && end == digits.data() + digits.size()) return value;
  throw InputError(file_, line_, fmt::format("column '{}'", column),
                   fmt::format("expected a whole number >= 0, got '{}'", field.substr(0, 40)));
}

}  // namespace leeway::io
