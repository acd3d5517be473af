#include "io/columns_map.hpp"

#include <zlib.h>

#include <catch2/catch.hpp>

#include "core/errors.hpp"
#include "core/units.hpp"
#include "io/trajectory_csv.hpp"
#include "temporary_folder.hpp"

using namespace leeway;
using Catch::Matchers::Contains;

namespace {

std::string gzipped(const std::string& text) {
  z_stream stream{};
  REQUIRE(deflateInit2(&stream, 6, Z_DEFLATED, 16 + MAX_WBITS, 8, Z_DEFAULT_STRATEGY) == Z_OK);
  std::string packed(text.size() + 1000, '\0');
  std::string input = text;
  stream.next_in = reinterpret_cast<unsigned char*>(input.data());
  stream.avail_in = static_cast<uInt>(input.size());
  stream.next_out = reinterpret_cast<unsigned char*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  REQUIRE(deflate(&stream, Z_FINISH) == Z_STREAM_END);
  deflateEnd(&stream);
  return packed.substr(0, stream.total_out);
}

}  // namespace

TEST_CASE("columns map: what contradicts itself is refused with the pointer to the place", "[io][columns]") {
  const test::TemporaryFolder folder;
  const auto refused = [&](const std::string& text, const std::string& because) {
    CAPTURE(text);
    const std::string path = folder.write("map.json", text);
    CHECK_THROWS_AS(io::read_columns_map(path), InputError);
    CHECK_THROWS_WITH(io::read_columns_map(path), Contains(because));
  };
  refused(R"({"psi_deg": {"from": "h", "unit": "kn"}})",
          "map.json: /psi_deg/unit: 'kn' is a unit of speed, expected one of angle: deg, rad");
  refused(R"({"u_mps": {"from": 0}})", "/u_mps/from: expected a column's name or its number from 1, got 0");
  refused(R"({"u_mps": {"from": 2.5}})", "/u_mps/from: expected a column's name or its number from 1, got 2.5");
  refused(R"({"u_mps": {"from": "u", "scale": 0}})", "/u_mps/scale: expected a number from 1e-12 to 1e+12");
  refused(R"({"u_mps": {"from": "u", "sign": 2}})", "/u_mps/sign: expected 1 or -1, got 2");
  refused(R"({"u_mps": {"from": 2}, "vm_mps": {"from": 2}})", "/vm_mps: the column 2 is already taken by 'u_mps'");
  refused(R"({"u_mps": 5})", "/u_mps: expected a column's name, or {\"from\": 5} with its number, got 5");
  refused(R"({"file": {"time": {"from": "a", "format": "%s"}}})", "/file/time/format: expected iso8601");
  refused(R"({"u_mps": "a", "u_kn": "b"})", "/u_kn: 'u' is already given by the column 'a'");
  refused(R"({"t_s": "a", "file": {"time": {"from": "b", "format": "hms"}}})", "/t_s: stands beside /file/time");
  refused(R"({"u_mps": "b", "file": {"time": {"from": "b", "format": "hms"}}})", "/u_mps: the column 'b' is already");
  refused(R"({"file": {"time": {"from": ["a", "a"], "format": "iso8601"}}})", "/file/time/from: the column 'a' stands");
  refused(R"({"file": {"time": {"from": "a", "format": "hours"}}})", "/file/time/format: expected iso8601, epoch, hms");
  refused(R"({"file": {"time": {"from": "a", "format": "%H:%Q"}}})", "/file/time/format: expected iso8601");
  refused(R"({"file": {"delimiter": "|"}})", "/file/delimiter");
  refused(R"({"file": {"decimal": ","}})", "/file/decimal: a decimal comma needs another delimiter");
  refused(R"({"file": {"separator": ","}})", "/file/separator: unknown key");
  refused(R"({"file": {"scale_factor": 0}})", "/file/scale_factor: expected a number");
  refused(R"({"file": {"sample_interval_s": -1}})", "/file/sample_interval_s: expected a number");
  refused(R"({"file": {"velocity_frame": "body"}})", "/file/velocity_frame");
  refused(R"({"u_mps": {"from": 1}, "vm_mps": {"from": 2}, "file": {"velocity_frame": "earth", "header": false}})",
          "/psi_deg: missing");
  refused(R"({"latitude_deg": "a"})", "/latitude_deg: unknown column name");
  refused(R"({"latitude_deg": "a", "file": {"position": "latitude-longitude"}})", "/longitude_deg: missing");
  refused(R"({"r_degps": {"derive": "u_mps"}})", "/r_degps/derive: expected u_mps derived from x0_m");
  refused(R"({"r_degps": {"derive": "psi_deg"}, "file": {"header": false}})",
          "/r_degps: is derived from psi_deg, which has no column");
  refused(R"({"psi_deg": "h", "r_degps": {"derive": "psi_deg", "from": "r"}})", "/r_degps/from: unknown key");
}

TEST_CASE("columns map: what is wrong in a foreign file is named with line and column", "[io][columns]") {
  const test::TemporaryFolder folder;
  const auto refused = [&](const std::string& map, const std::string& text, const std::string& because) {
    CAPTURE(map, text);
    const io::ColumnsMap columns = io::read_columns_map(folder.write("map.json", map));
    const std::string path = folder.write("raw.txt", text);
    CHECK_THROWS_AS(io::read_trajectory(path, &columns), InputError);
    CHECK_THROWS_WITH(io::read_trajectory(path, &columns), Contains(because));
  };
  const std::string four = R"("t_s": {"from": 1}, "u_mps": {"from": 2}, "vm_mps": {"from": 3}, "r_degps": {"from": 4})";
  const std::string bare = "{" + four + R"(, "file": {"delimiter": "blank", "header": false, "skip_lines": 1}})";
  refused(bare, "text\n0 1 0 0\n2 1 0 0\n1.5 1 0 0\n",
          "raw.txt:4: column 1: time must increase, but 1.5 s follows 2 s");
  refused(bare, "text\n0 1 0 0\n1 1 0 x\n", "raw.txt:3: column 4: expected a finite number [deg/s], got 'x'");
  refused(bare, "text\n0 1 0\n", "raw.txt:2: no column 4; found 3 columns");
  refused(bare, "text\n0 1 0 0\n1 1 0\n", "raw.txt:3: expected 4 fields, found 3");
  refused(bare, "", "raw.txt:1: the file ends here; expected 1 lines before the table");
  refused("{" + four + R"(, "psi_deg": "u"})", "t,u,v,r\n0,1,0,0\n", "column 'u': the map names it twice");
  refused("{" + four + R"(, "psi_deg": "h"})", "t,u,v,r,h,h\n0,1,0,0,0,0\n", "column 'h': stands twice");
  refused("{" + four + "}", "t\xFCr,u,v,r\n0,1,0,0\n", "raw.txt:1: column 1: its name holds bytes that are not UTF-8");
  refused(R"({"u_mps": "u", "vm_mps": "v", "r_degps": "r"})", "u,v,r\n1,0,0\n", "the columns map has no time");
  refused(R"({"t_s": "t", "u_mps": "u", "vm_mps": "v"})", "t,u,v\n1,0,0\n", R"("r_degps": {"derive": "psi_deg"})");
  const std::string comma = "{" + four + R"(, "file": {"delimiter": ";", "decimal": ","}})";
  refused(comma, "t;u;v;r\n0;1.5;0;0\n", "column 'u': expected a finite number [m/s] with a decimal comma, got '1.5'");
  const std::string clock =
      R"({"u_mps": "u", "vm_mps": "v", "r_degps": "r", "file": {"time": {"from": "t", "format": "hms"}}})";
  refused(clock, "t,u,v,r\n10:00:00,1,0,0\n24:00:00,1,0,0\n",
          "raw.txt:3: column 't': expected a time of day (23:59:58.5)");
  refused(clock, "t,u,v,r\n10:00:05,1,0,0\n10:00:00,1,0,0\n",
          "raw.txt:3: column 't': time must increase, but -5 s follows 0 s");
}

TEST_CASE("columns map: a file may lack what a map names, but not what the rest needs", "[io][columns]") {
  const test::TemporaryFolder folder;
  const std::string raw = folder.write("raw.csv", "t,u,v,r\n0,1,0,0\n1,1,0,0\n");
  const std::string four = R"({"t_s": "t", "u_mps": "u", "vm_mps": "v", "r_degps": "r", "psi_deg": "heading")";
  const io::ColumnsMap more = io::read_columns_map(folder.write("map.json", four + "}"));
  CHECK_FALSE(io::read_trajectory(raw, &more).has(Channel::psi));
  const io::ColumnsMap earth =
      io::read_columns_map(folder.write("map.json", four + R"(, "file": {"velocity_frame": "earth"}})"));
  CHECK_THROWS_WITH(io::read_trajectory(raw, &earth), Contains("no column 'heading'; found t, u, v, r"));
}

TEST_CASE("columns map: a channel that it leaves out is read by leeway's own name", "[io][columns]") {
  const test::TemporaryFolder folder;
  const auto read = [&](const std::string& map, const std::string& raw) {
    const io::ColumnsMap columns = io::read_columns_map(folder.write("map.json", map));
    return io::read_trajectory(folder.write("raw.csv", raw), &columns);
  };
  const std::string two = R"({"t_s": "t", "u_mps": "u")";
  const std::string raw = "t,u,vm_mps,r_radps,psi_deg,wind_speed_mps,u_kn,r_derived\n0,1,2,0.5,90,3,7,1\n";
  const Trajectory plain = read(two + "}", raw);
  CHECK(plain[Channel::u] == std::vector<double>{1.0});  // the map's column counts
  CHECK(plain[Channel::vm] == std::vector<double>{2.0});
  CHECK(plain[Channel::r] == std::vector<double>{0.5});
  CHECK(plain.is_derived(Channel::r));
  CHECK(plain.has(Channel::psi));
  CHECK_FALSE(plain.has(Channel::wind_speed));  // half a wind is none
  CHECK(plain.ignored_columns == std::vector<std::string>{"wind_speed_mps", "u_kn"});
  // Time and all: a map of one column.
  CHECK(read(R"({"n_p_rps": "rev"})", "t_s,u_mps,vm_mps,r_degps,rev\n0,1,2,0,8\n")[Channel::n_p][0] == 8.0);
  // A column that the map takes for something else is that, and one that it derives is derived.
  CHECK_THROWS_WITH(read(two + R"(, "vm_mps": "r_degps"})", "t,u,r_degps\n0,1,0\n"), Contains("has no r_degps"));
  CHECK(read(two + R"(, "psi_deg": "h", "r_degps": {"derive": "psi_deg"}})",
             "t,u,vm_mps,h,r_degps\n0,1,0,0,50\n1,1,0,1,50\n2,1,0,2,50\n3,1,0,3,50\n4,1,0,4,50\n")[Channel::r][2] <
        0.1);
  // Where the file's axes are others, leeway's names would mean another thing.
  CHECK_THROWS_WITH(read(R"({"t_s": "t", "u_mps": "north", "psi_deg": "h", "file": {"velocity_frame": "earth"}})",
                         "t,north,vm_mps,r_degps,h\n0,1,0,0,0\n"),
                    Contains("has no vm_mps"));
  // What others are computed from may be unnamed as well, and is missed where it is nowhere.
  const std::string derived = R"({"t_s": "t", "u_mps": "u", "vm_mps": "v", "r_degps": {"derive": "psi_deg"}})";
  const std::string five_rows = "0,1,0,0\n1,1,0,2\n2,1,0,4\n3,1,0,6\n4,1,0,8\n";
  CHECK(read(derived, "t,u,v,psi_deg\n" + five_rows)[Channel::r][2] == Approx(2.0 * kDegree));
  CHECK_THROWS_WITH(read(derived, "t,u,v,heading\n" + five_rows),
                    Contains("r_degps is derived from psi_deg, which neither the columns map nor the file has"));
  const std::string earth = R"({"t_s": "t", "u_mps": "u", "vm_mps": "v", "file": {"velocity_frame": "earth"}})";
  CHECK(read(earth, "t,u,v,psi_deg,r_degps\n0,0,2,90,0\n")[Channel::u][0] == Approx(2.0));
  CHECK_THROWS_WITH(read(earth, "t,u,v,r_degps\n0,0,2,0\n"), Contains("nor the file has psi_deg"));
  // Two columns for one quantity are refused, as without a map.
  CHECK_THROWS_WITH(read(two + "}", "t,u,vm_mps,vm_kn,r_degps\n0,1,0,0,0\n"), Contains("holds the same quantity"));
  CHECK_THROWS_WITH(read(R"({"u_mps": "u"})", "u,vm_mps,r_degps\n1,0,0\n"), Contains("the columns map has no time"));
}

TEST_CASE("columns map: gzip is read as it lies, in several members too, and broken gzip is refused", "[io][columns]") {
  const test::TemporaryFolder folder;
  const std::string head = "t_s,u_mps,vm_mps,r_degps\n0,1,0,0\n", tail = "1,1,0,0\n2,1,0,0\n";
  const std::string packed = gzipped(head) + gzipped(tail);
  const Trajectory read = io::read_trajectory(folder.write("run.csv.gz", packed));
  CHECK(read.name == "run");
  CHECK(read[Channel::t] == std::vector<double>{0.0, 1.0, 2.0});
  const std::string whole = gzipped(head + tail);
  CHECK_THROWS_WITH(io::read_trajectory(folder.write("cut.csv.gz", whole.substr(0, whole.size() - 9))),
                    Contains("cut.csv.gz: the gzip file ends too early"));
  std::string bad = whole;
  bad[14] = static_cast<char>(~bad[14]);
  CHECK_THROWS_AS(io::read_trajectory(folder.write("bad.csv.gz", bad)), InputError);
}

TEST_CASE("columns map: AM and PM of a clock pattern are read", "[io][columns]") {
  io::ClockReader reader(io::ClockFormat::pattern, "%m/%d/%Y %I:%M:%S %p");
  CHECK(reader.seconds("03/04/2021 11:59:30 AM") == 0.0);
  CHECK(reader.seconds("03/04/2021 12:00:30 PM") == 60.0);
  CHECK(reader.seconds("03/04/2021 01:00:30 pm") == 3660.0);
  CHECK(reader.seconds("03/05/2021 12:00:30 AM") == 12.0 * 3600.0 + 60.0);
  CHECK_FALSE(reader.seconds("03/05/2021 12:00:30").has_value());
  io::ClockReader whole(io::ClockFormat::pattern, "%c");
  CHECK(whole.seconds("Thu Mar  4 23:55:00 2021") == 0.0);
  CHECK(whole.seconds("Fri Mar  5 00:05:00 2021") == 600.0);
}
