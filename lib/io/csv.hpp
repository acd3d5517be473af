#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/byte_source.hpp"

namespace leeway::io {

enum class Encoding { utf8, latin1 };

/// What a table of numbers looks like; by default as leeway's own CSV.
struct CsvForm {
  static constexpr char kBlank = ' ';
  char delimiter = ',';        ///< kBlank: fields are apart by any number of blanks and tabs, and nothing is quoted
  bool decimal_comma = false;  ///< 1,5 is one and a half
  bool has_header = true;      ///< else columns are called "1", "2", ...
  std::size_t skip_lines = 0;  ///< before the header
  Encoding encoding = Encoding::utf8;
  bool is_foreign = false;  ///< columns may lack a name or share one; lines of nothing but blanks are passed over
};

/// Reads CSV (RFC 4180, LF or CRLF, with or without a byte-order mark) row by row with a buffer of fixed size, so that
/// a stream of any length needs no more memory than its longest row. Lines beginning with '#' before the header and
/// empty lines are passed over. A field that begins with a quotation mark, blanks aside, ends with one; others hold
/// none. A file compressed with gzip is read as it lies.
class CsvReader {
 public:
  /// Opens a file ("-": standard input) and reads the header. Throws IoError, or InputError for an empty file, an
  /// empty or a repeated column name, a name that is not UTF-8, lines that end with CR alone.
  explicit CsvReader(const std::string& path, CsvForm form = {});

  const std::string& file() const { return file_; }
  const std::vector<std::string>& header() const { return header_; }
  /// Position of a column; throws InputError that lists the columns found.
  std::size_t column(std::string_view name) const;

  /// The next row's fields, valid until the next call; false at the end. Throws InputError for a row with more or
  /// fewer fields than the header.
  bool next(std::vector<std::string_view>& fields);
  /// Line of the row that next() gave, counted from 1 as an editor does.
  std::size_t line() const { return line_; }

  const CsvForm& form() const { return form_; }
  /// The column's name for messages: "column 'u'", "column 5" where columns have no names.
  std::string column_text(std::size_t column) const;

  /// Whether a field is a finite number; see parse_number().
  bool is_number(std::string_view field, double& value) const;
  /// A field of the current row as a finite number; throws InputError that names the column and `unit`.
  double number(std::string_view field, std::string_view column, std::string_view unit) const;
  /// A field of the current row as a whole number >= 0.
  std::size_t count(std::string_view field, std::string_view column) const;

 private:
  void pass_over_first_lines();
  void read_header();
  void check_name(const std::string& name) const;
  void refuse_lone_carriage_returns(std::string_view text, std::size_t line) const;
  bool next_record(std::vector<std::string_view>& fields);
  bool find_record(std::vector<std::string_view>& fields, std::size_t& length, bool& quoted);
  bool skip_line();
  void split(std::string_view record, std::vector<std::string_view>& fields) const;
  bool split_quoted(std::string_view record, std::vector<std::string_view>& fields);
  bool fill();

  std::string file_;
  CsvForm form_;
  ByteSource source_;
  std::vector<std::string> header_;
  std::vector<std::string_view> first_row_;  // read to count the columns of a file without header
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
/// The same with a decimal comma; a point is no part of such a number.
bool parse_number_with_comma(std::string_view field, double& value);

}  // namespace leeway::io
