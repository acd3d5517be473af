#include <algorithm>
#include <filesystem>

#include <catch2/catch.hpp>

#include "run.hpp"

using namespace leeway;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;
using test::Outcome;
using test::run;
using test::TemporaryFolder;

namespace {

const std::string kTruth = "t_s,u_mps,vm_mps,r_degps\n0,1,0,0\n1,1,0,0\n";
const std::string kPrediction =
    "recording,sequence,step,t_s,particle,member,x0_m,y0_m,psi_deg,u_mps,vm_mps,r_degps\n"
    "rec,0,0,0,0,0,0,0,0,1,0,0\nrec,0,1,1,0,0,1,0,0,1,0,0\n";

// A tool that reads a file of the kind under test and would succeed if that file were good. A new tool is a line here.
struct Reader {
  std::string program, command;
};

// Reads rec.csv, a trajectory.
const std::vector<Reader> kTrajectoryReaders{
    {"eval-metrics", "eval-metrics good-prediction.csv --truth rec.csv"},
    {"ens-predict", "ens-predict --baseline hold rec.csv --steps 2"},
};
// Reads pred.csv, a prediction.
const std::vector<Reader> kPredictionReaders{
    {"eval-metrics", "eval-metrics pred.csv --truth good/rec.csv"},
    {"eval-metrics", "eval-metrics - --truth good/rec.csv < pred.csv"},
};
// Reads map.json, a columns map.
const std::vector<Reader> kColumnsReaders{
    {"eval-metrics", "eval-metrics good-prediction.csv --truth good/rec.csv --columns map.json"},
    {"ens-predict", "ens-predict --baseline hold good/rec.csv --steps 2 --columns map.json"},
};
// Reads dataset.json, whose recording is good/rec.csv.
const std::vector<Reader> kDatasetReaders{
    {"eval-metrics", "eval-metrics good-prediction.csv --truth dataset.json"},
    {"ens-predict", "ens-predict --baseline hold dataset.json --steps 2"},
};
// Writes a result to the file (or '-') that is appended.
const std::vector<Reader> kWriters{
    {"eval-metrics", "eval-metrics good-prediction.csv --truth good/rec.csv --quiet -o "},
    {"eval-metrics", "eval-metrics good-prediction.csv --truth good/rec.csv --quiet -o metrics.json --per-step "},
};

struct Case {
  std::string name, contents;
  int exit_code;
  std::string message;  ///< from the file's name on
};

void write_valid_inputs(const TemporaryFolder& folder) {
  folder.write("good/rec.csv", kTruth);
  folder.write("good-prediction.csv", kPrediction);
}

// One line that names the program, and nothing on the standard output.
void check_refused(const Outcome& outcome, const std::string& program, int exit_code, const std::string& message) {
  CHECK(outcome.exit_code == exit_code);
  CHECK(outcome.out.empty());
  CHECK_THAT(outcome.err, StartsWith(program + ": error: "));
  CHECK_THAT(outcome.err, Contains(message));
  CHECK(std::count(outcome.err.begin(), outcome.err.end(), '\n') == 1);
}

void check_all(const std::vector<Reader>& readers, const std::string& file, const std::vector<Case>& cases) {
  for (const Reader& reader : readers)
    for (const Case& c : cases) {
      CAPTURE(reader.command, c.name);
      const TemporaryFolder folder;
      write_valid_inputs(folder);
      folder.write(file, c.contents);
      const std::string before = folder.listing();
      const Outcome outcome = run(folder, reader.command);
      // The standard input has no name but '-'.
      const bool piped = reader.command.find('<') != std::string::npos;
      check_refused(outcome, reader.program, c.exit_code, (piped ? "-" : file) + c.message);
      CHECK(folder.listing() == before);
    }
}

}  // namespace

TEST_CASE("errors: a trajectory that is wrong ends with 3 and one line that says where", "[cli][errors]") {
  const std::string header = "t_s,u_mps,vm_mps,r_degps\n";
  check_all(
      kTrajectoryReaders, "rec.csv",
      {{"empty", "", 3, ":1: the file is empty; expected a header row"},
       {"header only", header, 3, ":2: no data row below the header"},
       {"no such column", "t_s,u,vm_mps,r_degps\n0,1,0,0\n", 3, ":1: no column 'u_mps'; found t_s, u, vm_mps, r_degps"},
       {"duplicate column", "t_s,u_mps,vm_mps,r_degps,u_mps\n", 3, ":1: column 'u_mps': stands twice"},
       {"one quantity twice", "t_s,u_mps,vm_mps,r_degps,u_kn\n", 3, ":1: column 'u_kn': holds the same quantity"},
       {"nan", header + "0,1,0,0\n1,nan,0,0\n", 3, ":3: column 'u_mps': expected a finite number [m/s], got 'nan'"},
       {"text", header + "0,1,0,fast\n", 3, ":2: column 'r_degps': expected a finite number [deg/s], got 'fast'"},
       {"two lines in a field", header + "0,1,0,\"two\nlines\"\n", 3,
        ":2: column 'r_degps': expected a finite number [deg/s], got 'two lines'"},
       {"not text at all",
        std::string("\x7f"
                    "ELF\x02\x01\x01\0\0\0\x1b[31m",
                    15),
        3, ":1: no column 't_s'; found  ELF"},
       {"row too short", header + "0,1,0,0\n1,1,0\n", 3, ":3: expected 4 fields, found 3"},
       {"row too long", header + "0,1,0,0\n1,1,0,0,9\n", 3, ":3: expected 4 fields, found 5"},
       {"time stands still", header + "0,1,0,0\n1,1,0,0\n1,1,0,0\n", 3,
        ":4: column 't_s': time must increase, but 1 s follows 1 s"},
       {"time goes back", header + "2,1,0,0\n1,1,0,0\n", 3,
        ":3: column 't_s': time must increase, but 1 s follows 2 s"},
       {"missing time", header + ",1,0,0\n", 3, ":2: column 't_s': expected a finite number [s], got ''"}});
}

TEST_CASE("errors: a prediction that is wrong ends with 3 and one line that says where", "[cli][errors]") {
  const std::string header = kPrediction.substr(0, kPrediction.find('\n') + 1);
  check_all(
      kPredictionReaders, "pred.csv",
      {{"empty", "", 3, ":1: the file is empty; expected a header row"},
       {"header only", header, 3, ":2: no data row below the header"},
       {"no such column", "recording,sequence,step\n", 3, ":1: no column 't_s'; found recording, sequence, step"},
       {"duplicate column", "recording,sequence,step,step\n", 3, ":1: column 'step': stands twice"},
       {"nan", kPrediction + "rec,1,0,0,0,0,0,0,0,1,nan,0\n", 3,
        ":4: column 'vm_mps': expected a finite number [m/s], got 'nan'"},
       {"fraction of a step", kPrediction + "rec,1,0.5,0,0,0,0,0,0,1,0,0\n", 3,
        ":4: column 'step': expected a whole number >= 0, got '0.5'"},
       {"row too short", kPrediction + "rec,1,0,0,0\n", 3, ":4: expected 12 fields, found 5"},
       {"row too long", kPrediction + "rec,1,0,0,0,0,0,0,0,1,0,0,0\n", 3, ":4: expected 12 fields, found 13"},
       {"another recording", kPrediction + "other,1,0,0,0,0,0,0,0,1,0,0\n", 3,
        ":4: column 'recording': no truth for 'other'"},
       {"particles differ", kPrediction + "rec,0,1,1,1,0,1,0,0,1,0,0\n", 3, ": recording 'rec', sequence 0, step 0"},
       {"cut off", kPrediction + "rec,1,0,0,0,0,0,0,0,1,0", 3, ":4: expected 12 fields, found 11"}});
}

TEST_CASE("errors: a JSON file that is wrong ends with 3 and points to the place", "[cli][errors]") {
  check_all(kColumnsReaders, "map.json",
            {{"empty", "", 3, ":1:1: not valid JSON: the file is empty"},
             {"syntax", "{\n  \"t_s\": ,\n}\n", 3, ":2:10: not valid JSON"},
             {"misspelled key", R"({"t_s": "t_s", "u_msp": "u_mps"})", 3, ": /u_msp: unknown column name"},
             {"misspelled inner key", R"({"u_mps": {"form": "u"}})", 3, ": /u_mps/from: missing, expected a text"},
             {"wrong type", R"({"u_mps": 5})", 3,
              ": /u_mps: expected a column's name, or {\"from\": 5} with its number, got 5"},
             {"key twice", R"({"u_mps": "a", "u_mps": "b"})", 3, ":1:16: /u_mps: the key stands twice"},
             {"not an object", "[1]", 3, ":1:1: expected an object, got [1]"}});
  check_all(kDatasetReaders, "dataset.json",
            {{"misspelled key", R"({"sets": [{"name": "a", "recordings": [{"file": "good/rec.csv", "thruth": "x"}]}]})",
              3, ": /sets/0/recordings/0/thruth: unknown key; known here: "},
             {"wrong type", R"({"sets": [{"name": "a", "recordings": "good/rec.csv"}]})", 3,
              ": /sets/0/recordings: expected an array of objects, got \"good/rec.csv\""},
             {"wrong type of a name", R"({"sets": [{"name": 7, "recordings": []}]})", 3,
              ": /sets/0/name: expected a text, got 7"}});
}

TEST_CASE("errors: CRLF, a byte-order mark and a last line without its end are accepted", "[cli][errors]") {
  for (const std::string text : {"\xEF\xBB\xBFt_s,u_mps,vm_mps,r_degps\r\n0,1,0,0\r\n1,1,0,0\r\n",
                                 "# by hand\nt_s,u_mps,vm_mps,r_degps\n0,1,0,0\n\n1,1,0,0"})
    for (const Reader& reader : kTrajectoryReaders) {
      const TemporaryFolder folder;
      write_valid_inputs(folder);
      folder.write("rec.csv", text);
      const Outcome outcome = run(folder, reader.command);
      CHECK(outcome.exit_code == 0);
      CHECK(outcome.err.find("error") == std::string::npos);
    }
}

TEST_CASE("errors: a file that cannot be read ends with 4", "[cli][errors]") {
  const auto check_unreadable = [](const std::vector<Reader>& readers, const std::string& file) {
    for (const Reader& reader : readers) {
      if (reader.command.find('<') != std::string::npos) continue;  // the shell's own error
      CAPTURE(reader.command);
      const TemporaryFolder folder;
      write_valid_inputs(folder);
      check_refused(run(folder, reader.command), reader.program, 4, file + ": cannot be opened: No such file");
    }
  };
  check_unreadable(kTrajectoryReaders, "rec.csv");
  check_unreadable(kPredictionReaders, "pred.csv");
  check_unreadable(kColumnsReaders, "map.json");
  check_unreadable(kDatasetReaders, "dataset.json");
  for (const Reader& reader : kTrajectoryReaders) {
    const TemporaryFolder folder;
    write_valid_inputs(folder);
    std::filesystem::create_directory(folder / "rec.csv");
    check_refused(run(folder, reader.command), reader.program, 4, "rec.csv: cannot be read: Is a directory");
  }
}

TEST_CASE("errors: an output that cannot be written ends with 4 and leaves nothing behind", "[cli][errors]") {
  for (const Reader& writer : kWriters) {
    CAPTURE(writer.command);
    const TemporaryFolder folder;
    write_valid_inputs(folder);
    const std::string before = folder.listing();
    check_refused(run(folder, writer.command + "no/such/folder.txt"), writer.program, 4,
                  "no/such/folder.txt: cannot be written: No such file or directory");
    check_refused(run(folder, writer.command + "good"), writer.program, 4, "good: is a folder, expected a file");
    CHECK(folder.listing() == before);
  }
}

TEST_CASE("errors: a full disk ends with 4", "[cli][errors]") {
  if (!std::filesystem::exists("/dev/full")) {
    WARN("SKIPPED: no /dev/full on this system");
    return;
  }
  for (const Reader& writer : kWriters) {
    CAPTURE(writer.command);
    const TemporaryFolder folder;
    write_valid_inputs(folder);
    const std::string before = folder.listing();
    check_refused(run(folder, writer.command + "/dev/full"), writer.program, 4,
                  "/dev/full: cannot be written: No space left on device");
    CHECK(folder.listing() == before);
    check_refused(run(folder, writer.command + "- > /dev/full"), writer.program, 4,
                  "standard output: cannot be written: No space left on device");
    check_refused(run(folder, writer.program + " --help > /dev/full"), writer.program, 4, "standard output");
  }
}

TEST_CASE("errors: a reader that goes away ends a tool quietly", "[cli][errors]") {
  const TemporaryFolder folder;
  write_valid_inputs(folder);
  // More than a pipe holds: 20,000 steps.
  std::string truth = "t_s,u_mps,vm_mps,r_degps\n", prediction = kPrediction.substr(0, kPrediction.find('\n') + 1);
  for (int k = 0; k < 20'000; ++k) {
    truth += fmt::format("{},1,0,0\n", k);
    prediction += fmt::format("rec,0,{0},{0},0,0,0,0,0,1.125,0.25,0.5\n", k);
  }
  folder.write("good/rec.csv", truth);
  folder.write("good-prediction.csv", prediction);
  const Outcome outcome =
      run(folder,
          "(eval-metrics good-prediction.csv --truth good/rec.csv --quiet -o metrics.json --per-step -; "
          "echo $? > code) | head -1");
  CHECK_THAT(outcome.out, StartsWith("recording,sequence,step,t_s,"));
  CHECK(outcome.err.empty());
  CHECK(io::read_text(folder / "code") == "0\n");
}

TEST_CASE("errors: a wrong command line ends with 2", "[cli][errors]") {
  const TemporaryFolder folder;
  write_valid_inputs(folder);
  const auto refused = [&](const std::string& command, const std::string& message) {
    CAPTURE(command);
    check_refused(run(folder, command), "eval-metrics", 2, message);
  };
  refused("eval-metrics good-prediction.csv", "--truth is required");
  refused("eval-metrics good-prediction.csv --truth good/rec.csv --sigma-u-mps -1", "expected a number > 0, got '-1'");
  refused("eval-metrics good-prediction.csv --truth good/rec.csv --sigma-u-mps nan",
          "expected a number > 0, got 'nan'");
  refused("eval-metrics good-prediction.csv --truth good/rec.csv --sigma", "--sigma");
  refused("eval-metrics good-prediction.csv --truth good/rec.csv --columns none-such", "shipped: frt-ds-esso");
  refused("eval-metrics - --truth -", "can be read only once");
  refused("eval-metrics good-prediction.csv --truth good/rec.csv --per-step -", "cannot both be '-'");
}

TEST_CASE("errors: a dataset without the set asked for, a recording without truth, two truths of a name",
          "[cli][errors]") {
  const TemporaryFolder folder;
  write_valid_inputs(folder);
  folder.write("again/rec.csv", kTruth);
  folder.write("other.csv", kTruth);
  folder.write("dataset.json", R"({"sets": [{"name": "test", "recordings": [{"file": "good/rec.csv"}]}]})");
  check_refused(run(folder, "eval-metrics good-prediction.csv --truth dataset.json#tset"), "eval-metrics", 3,
                "dataset.json: no set 'tset'; sets: test");
  check_refused(run(folder, "eval-metrics good-prediction.csv --truth other.csv"), "eval-metrics", 3,
                "good-prediction.csv:2: column 'recording': no truth for 'rec'");
  check_refused(run(folder, "eval-metrics good-prediction.csv --truth good/rec.csv again/rec.csv"), "eval-metrics", 3,
                "again/rec.csv: is the truth of recording 'rec', and so is good/rec.csv");
}
