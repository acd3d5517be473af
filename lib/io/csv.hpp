#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace leeway::io {

/// Reads CSV (RFC 4180, LF or CRLF, with or without a byte-order mark) row by row with a buffer of fixed size, so that
/// a stream of any length needs no more memory than its longest row. Lines beginning with '#' before the header and
/// empty lines are passed over. A field that begins with a quotation mark, blanks aside, ends with one; others hold
/// none.
class CsvReader {
 public:
  /// Opens a file ("-": standard input) and reads the header. Throws IoError, or InputError for an empty file, an
  /// empty or a repeated column name, lines that end with CR alone.
  explicit CsvReader(const std::string& path);
  ~CsvReader();
  CsvReader(const CsvReader&) = delete;
  CsvReader& operator=(const CsvReader&) = delete;

  const std::string& file() const { return file_; }
  const std::vector<std::string>& header() const { return header_; }
  /// Position of a column; throws InputError that lists the columns found.
  std::size_t column(std::string_view name) const;

  /// The next row's fields, valid until the next call; false at the end. Throws InputError for a row with more or
  /// fewer fields than the header.
  bool next(std::vector<std::string_view>& fields);
  /// Line of the row that next() gave, counted from 1 as an editor does.
  std::size_t line() const { return line_; }

  /// A field of the current row as a finite number; throws InputError that names the column and `unit`.
  double number(std::string_view field, std::string_view column, std::string_view unit) const;
  /// A field of the current row as a whole number >= 0.
  std::size_t count(std::string_view field, std::string_view column) const;

 private:
  void read_header();
  void refuse_lone_carriage_returns(std::string_view text, std::size_t line) const;
  bool next_record(std::vector<std::string_view>& fields);
  bool split_quoted(std::string_view record, std::vector<std::string_view>& fields);
  bool fill();

  std::string file_;
  int fd_ = -1;
  std::vector<std::string> header_;
  std::string buffer_;
  std::size_t begin_ = 0, end_ = 0;
  bool at_end_ = false;
  std::size_t line_ = 0, lines_read_ = 0;
  std::string unquoted_;
};

/// A text as it stands in a row: in quotation marks where it holds a comma, a quotation mark or a line end.
std::string csv_field(std::string_view text);

/// "a, b, c and 59997 more": names in a message, as many and as much of them as somebody reads.
std::string listed(std::span<const std::string> names);

/// Appends a number as it stands in a row: the fewest digits that read back to the same bits; nothing for one that is
/// not finite, since a field that is empty is missing and no reader takes `inf` or `nan`.
void append_number(std::string& text, double value);

/// Without the blanks around it.
std::string_view trim(std::string_view text);

/// A finite number that fills the whole field (surrounding blanks allowed), the same in every locale.
bool parse_number(std::string_view field, double& value);

}  // namespace leeway::io
