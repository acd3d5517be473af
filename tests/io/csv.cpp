#include "io/csv.hpp"

#include <cmath>
#include <limits>

#include <catch2/catch.hpp>

#include "core/errors.hpp"
#include "temporary_folder.hpp"

using namespace leeway;
using Catch::Matchers::Contains;

namespace {

using Rows = std::vector<std::vector<std::string>>;

Rows read_all(const std::string& path) {
  io::CsvReader csv(path);
  Rows rows{csv.header()};
  std::vector<std::string_view> fields;
  while (csv.next(fields)) rows.emplace_back(fields.begin(), fields.end());
  return rows;
}

}  // namespace

TEST_CASE("csv: line ends, byte-order mark, comments and empty lines make no difference", "[io][csv]") {
  const test::TemporaryFolder folder;
  const Rows expected{{"a", "b c"}, {"1", "2"}, {"", "-3.5"}};
  for (const std::string text : {"a,b c\n1,2\n,-3.5\n", "a,b c\r\n1,2\r\n,-3.5\r\n", "a,b c\n1,2\n,-3.5",
                                 "\xEF\xBB\xBF"
                                 "a,b c\r\n1,2\r\n,-3.5",
                                 "# made by hand\n#\na, b c\n\n1,2\n\r\n,-3.5\n\n"})
    CHECK(read_all(folder.write("x.csv", text)) == expected);
}

TEST_CASE("csv: quoted fields hold commas, quotation marks and line ends", "[io][csv]") {
  const test::TemporaryFolder folder;
  const std::string path = folder.write("x.csv", "\"a,1\",b\n\"say \"\"go\"\"\",\"two\nlines\"\n3,4\n5\n");
  io::CsvReader csv(path);
  CHECK(csv.header() == std::vector<std::string>{"a,1", "b"});
  std::vector<std::string_view> fields;
  REQUIRE(csv.next(fields));
  CHECK(fields[0] == "say \"go\"");
  CHECK(fields[1] == "two\nlines");
  CHECK(csv.line() == 2);
  REQUIRE(csv.next(fields));
  CHECK(csv.line() == 4);
  // Lines are counted as an editor does, also behind a field of two lines.
  CHECK_THROWS_WITH(csv.next(fields), Contains("x.csv:5: expected 2 fields, found 1"));
  CHECK_THROWS_WITH(read_all(folder.write("y.csv", "a,b\n1,\"2\n3,4\n")), Contains("y.csv:2: a quotation mark"));
}

TEST_CASE("csv: a quotation mark that is not one of a quoted field is an error", "[io][csv]") {
  const test::TemporaryFolder folder;
  const auto refused = [&](const std::string& rows, const std::string& because) {
    CAPTURE(rows);
    CHECK_THROWS_WITH(read_all(folder.write("x.csv", "a,b\n" + rows)), Contains(because));
  };
  const std::string within = "a quotation mark within a field", behind = "text behind the closing quotation mark";
  refused("\"1\"2,3\n", "x.csv:2: column 'a': " + behind);
  refused("1,2\"3\"\n", "x.csv:2: column 'b': " + within);
  refused("1,2\"3\n4,5\n", "x.csv:2: column 'b': " + within);
  refused("1,\"2\" \"3\"\n", "x.csv:2: column 'b': " + within);
  refused("1,2,3\"\n", "x.csv:2: field 3: " + within);
  refused("1,\"2\n3\"4\n", "x.csv:2: column 'b': " + behind);
  CHECK_THROWS_WITH(read_all(folder.write("x.csv", "a,\"b\"c\n")), Contains("x.csv:1: field 2: " + behind));
  // Nothing is read in search of the end of a quotation that never began.
  const std::string rest(8U << 20, 'x');
  refused("1,2\"3\n" + rest, within);
  CHECK(read_all(folder.write("x.csv", "a, \"b\" \n 1 ,\t\"2\"\n\"\",\"\"\"\"")) ==
        Rows{{"a", "b"}, {" 1 ", "2"}, {"", "\""}});
}

TEST_CASE("csv: lines that end with CR alone are named", "[io][csv]") {
  const test::TemporaryFolder folder;
  for (const std::string text : {"a,b\r1,2\r3,4\r", "a\r1\r",
                                 "\xEF\xBB\xBF"
                                 "a,b\r1,2"})
    CHECK_THROWS_WITH(read_all(folder.write("x.csv", text)), Contains("x.csv:1: a carriage return within a line"));
  CHECK_THROWS_WITH(read_all(folder.write("x.csv", "# one\n# two\ra,b\r1,2\r")),
                    Contains("x.csv:2: a carriage return"));
  CHECK(read_all(folder.write("x.csv", "# one\r\n\"a\r\nb\",c\r\n1,2\r\n")).size() == 2);
}

TEST_CASE("csv: many columns cost time in proportion, and a message lists a few", "[io][csv]") {
  const test::TemporaryFolder folder;
  std::string header, row;
  for (int i = 0; i < 60'000; ++i) {
    header += fmt::format("{}column-{}", i > 0 ? "," : "", i);
    row += i > 0 ? ",1" : "1";
  }
  const io::CsvReader csv(folder.write("x.csv", header + "\n" + row + "\n"));
  CHECK(csv.header().size() == 60'000);
  try {
    csv.column("t_s");
    FAIL("a column that is not there was found");
  } catch (const InputError& error) {
    const std::string what = error.what();
    CHECK_THAT(what, Contains("found column-0, column-1, ") && Contains(" and 59970 more"));
    CHECK(what.size() < 1000);
  }
  CHECK(io::listed(std::vector<std::string>{"a", std::string(100, 'b')}) == "a, " + std::string(60, 'b') + "...");
}

TEST_CASE("csv: a number that is not finite is an empty field", "[io][csv]") {
  std::string text;
  for (const double x : {0.1, std::numeric_limits<double>::infinity(), std::nan(""), -1e308}) {
    io::append_number(text, x);
    text += ',';
  }
  CHECK(text == "0.1,,,-1e+308,");
}

TEST_CASE("csv: rows are the same wherever the buffer ends", "[io][csv]") {
  // Rows of a prime length, some quoted, over several buffers of 1 MiB.
  const test::TemporaryFolder folder;
  std::string text = "n,text\n";
  const int n = 70'001;
  for (int i = 0; i < n; ++i)
    text += fmt::format("{},{}\n", i,
                        i % 3 == 0 ? fmt::format("\"line {0}\nand, \"\"{0}\"\"\"", i)
                                   : std::string(static_cast<std::size_t>(i % 101), 'x'));
  REQUIRE(text.size() > 3U << 20);
  io::CsvReader csv(folder.write("long.csv", text));
  std::vector<std::string_view> fields;
  int i = 0;
  for (; csv.next(fields); ++i) {
    REQUIRE(csv.count(fields[0], "n") == static_cast<std::size_t>(i));
    if (i % 3 == 0) {
      REQUIRE(fields[1] == fmt::format("line {0}\nand, \"{0}\"", i));
    } else {
      REQUIRE(fields[1].size() == static_cast<std::size_t>(i % 101));
    }
  }
  CHECK(i == n);
  // Header, rows, and a line end inside every third row.
  CHECK(csv.line() == static_cast<std::size_t>(1 + n + (n + 2) / 3));
}

TEST_CASE("csv: a field longer than the buffer is read", "[io][csv]") {
  const test::TemporaryFolder folder;
  const std::string longest(3U << 20, 'y');
  const Rows rows = read_all(folder.write("x.csv", "a,b\n\"" + longest + "\",2\n3,4\n"));
  REQUIRE(rows.size() == 3);
  CHECK(rows[1][0] == longest);
  CHECK(rows[2][1] == "4");
}

TEST_CASE("csv: a header that does not do is named with its line", "[io][csv]") {
  const test::TemporaryFolder folder;
  CHECK_THROWS_WITH(read_all(folder.write("x.csv", "")), Contains("x.csv:1: the file is empty"));
  CHECK_THROWS_WITH(read_all(folder.write("x.csv", "\n\r\n")), Contains("the file is empty"));
  CHECK_THROWS_WITH(read_all(folder.write("x.csv", "# only this")), Contains("the file is empty"));
  CHECK_THROWS_WITH(read_all(folder.write("x.csv", "# one\na,b,a\n")), Contains("x.csv:2: column 'a': stands twice"));
  CHECK_THROWS_WITH(read_all(folder.write("x.csv", "a,,b\n")), Contains("column 2 has no name"));
  CHECK_THROWS_WITH(io::CsvReader(folder.write("x.csv", "a,b\n")).column("c"), Contains("no column 'c'; found a, b"));
  CHECK_THROWS_AS(io::CsvReader(folder / "absent.csv"), IoError);
  CHECK_THROWS_AS(io::CsvReader(folder.path().string()), IoError);
}

TEST_CASE("csv: a number fills its field and is finite", "[io][csv]") {
  double value = 0.0;
  const std::pair<const char*, double> good[] = {{"1", 1.0},  {" -2.5e3\t", -2500.0}, {"+7", 7.0},
                                                 {".5", 0.5}, {"1e-3", 0.001},        {"4.", 4.0},
                                                 {"-0", 0.0}, {"5e-324", 5e-324}};
  for (const auto& [text, expected] : good) {
    CAPTURE(text);
    CHECK(io::parse_number(text, value));
    CHECK(value == expected);
  }
  for (const char* text :
       {"", " ", "nan", "NaN", "inf", "-Infinity", "1,5", "1.5 m", "0x10", "--1", "+-1", "1e999", "e3", "1 2"}) {
    CAPTURE(text);
    CHECK_FALSE(io::parse_number(text, value));
  }
}
