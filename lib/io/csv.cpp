#include "io/csv.hpp"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fcntl.h>
#include <iterator>
#include <unistd.h>
#include <unordered_set>

#include <fmt/format.h>

#include "core/errors.hpp"

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

CsvReader::CsvReader(const std::string& path) : file_(path) {
  fd_ = path == "-" ? STDIN_FILENO : ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd_ < 0) throw IoError(path, fmt::format("cannot be opened: {}", std::strerror(errno)));
  try {
    while (end_ < 3 && fill()) {  // a pipe may give single bytes
    }
    if (end_ >= 3 && buffer_.compare(0, 3, "\xEF\xBB\xBF") == 0) begin_ = 3;
    for (;;) {  // comments before the header
      if (begin_ == end_ && !fill()) break;
      if (buffer_[begin_] != '#') break;
      std::size_t newline = 0;
      while ((newline = buffer_.find('\n', begin_)) == std::string::npos || newline >= end_) {
        if (!fill()) {
          newline = end_ - 1;
          break;
        }
      }
      refuse_lone_carriage_returns({buffer_.data() + begin_, newline - begin_}, lines_read_ + 1);
      begin_ = newline + 1;
      ++lines_read_;
    }
    read_header();
  } catch (...) {
    if (fd_ != STDIN_FILENO) ::close(fd_);
    throw;
  }
}

void CsvReader::read_header() {
  std::vector<std::string_view> fields;
  if (!next_record(fields)) throw InputError(file_, 1, "", "the file is empty; expected a header row");
  std::unordered_set<std::string> taken;
  for (const std::string_view field : fields) {
    const std::string name{trim(field)};
    refuse_lone_carriage_returns(name, line_);
    if (name.empty()) throw InputError(file_, line_, "", fmt::format("column {} has no name", header_.size() + 1));
    if (!taken.insert(name).second) throw InputError(file_, line_, fmt::format("column '{}'", name), "stands twice");
    header_.push_back(name);
  }
}

// A file whose lines all end with CR alone is one long line to us.
void CsvReader::refuse_lone_carriage_returns(std::string_view text, std::size_t line) const {
  for (std::size_t at = 0; (at = text.find('\r', at)) != std::string_view::npos; ++at)
    if (at + 1 < text.size() && text[at + 1] != '\n')
      throw InputError(
          file_, line, "",
          "a carriage return within a line: lines that end with CR alone are not read; expected LF or CRLF");
}

CsvReader::~CsvReader() {
  if (fd_ != STDIN_FILENO) ::close(fd_);
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
  for (;;) {
    const ssize_t got = ::read(fd_, buffer_.data() + end_, buffer_.size() - end_);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw IoError(file_, fmt::format("cannot be read: {}", std::strerror(errno)));
    if (got == 0) at_end_ = true;
    end_ += static_cast<std::size_t>(got);
    return got > 0;
  }
}

bool CsvReader::next(std::vector<std::string_view>& fields) {
  if (!next_record(fields)) return false;
  if (fields.size() != header_.size())
    throw InputError(file_, line_, "", fmt::format("expected {} fields, found {}", header_.size(), fields.size()));
  return true;
}

bool CsvReader::next_record(std::vector<std::string_view>& fields) {
  for (;;) {
    // One record: up to the first line end outside quotes.
    std::size_t search = begin_, length = 0;
    bool complete = false, quoted = false;
    std::size_t quotes_seen = 0, counted = 0;  // quotation marks in the first `counted` bytes of the record
    while (!complete) {
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
      const std::string_view fresh(buffer_.data() + begin_ + counted, length - counted);
      const auto quotes = static_cast<std::size_t>(std::count(fresh.begin(), fresh.end(), '"'));
      quoted = quoted || quotes > 0;
      quotes_seen += quotes;
      if (newline == nullptr || quotes_seen % 2 == 0) {
        complete = true;
      } else {
        // The line end belongs to a quoted field, unless the quotation mark is wrong: then no more is read for it.
        line_ = lines_read_ + 1;
        if (counted == 0) split_quoted({buffer_.data() + begin_, length}, fields);
        search = begin_ + length + 1;
      }
      counted = length;
    }
    std::string_view record(buffer_.data() + begin_, length);
    begin_ = std::min(begin_ + length + 1, end_);
    line_ = lines_read_ + 1;
    lines_read_ += 1 + (quoted ? static_cast<std::size_t>(std::count(record.begin(), record.end(), '\n')) : 0);
    if (!record.empty() && record.back() == '\r') record.remove_suffix(1);
    if (record.empty()) continue;
    if (quoted) {  // rare
      if (split_quoted(record, fields)) return true;
      throw InputError(file_, line_, "", "a quotation mark is not closed");
    }
    fields.clear();
    for (;;) {
      const void* comma = std::memchr(record.data(), ',', record.size());
      if (comma == nullptr) break;
      const auto width = static_cast<std::size_t>(static_cast<const char*>(comma) - record.data());
      fields.push_back(record.substr(0, width));
      record.remove_prefix(width + 1);
    }
    fields.push_back(record);
    return true;
  }
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
    throw InputError(file_, line_,
                     n < header_.size() ? fmt::format("column '{}'", header_[n]) : fmt::format("field {}", n + 1),
                     problem);
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
    } else if (c == ',') {
      end_field();
    } else if (c == '"') {
      if (in == In::after_quotes || !trim({unquoted_.data() + start, unquoted_.size() - start}).empty())
        refuse("a quotation mark within a field; one that holds any stands in quotation marks, and doubles them");
      unquoted_.resize(start);  // blanks before
      in = In::quotes;
    } else if (in == In::bare) {
      unquoted_ += c;
    } else if (c != ' ' && c != '\t') {
      refuse("text behind the closing quotation mark; expected a comma or the end of the line");
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
  if (parse_number(field, value)) return value;
  throw InputError(file_, line_, fmt::format("column '{}'", column),
                   fmt::format("expected a finite number{}, got '{}'", unit.empty() ? "" : fmt::format(" [{}]", unit),
                               field.substr(0, 40)));
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
