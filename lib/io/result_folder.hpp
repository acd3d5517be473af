#pragma once

#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "io/json.hpp"

namespace leeway::io {

/// A folder of results that belong together and are described by one of them, its index (dataset.json, report.json).
/// The index goes before the first part is written, comes back after the last, and names all parts with their hashes:
/// wherever a run is killed, the folder holds one whole generation or no index. <index>.unfinished lists what a run in
/// progress replaces and writes, so that the next run clears up after one that was killed. It is locked as long as the
/// run lives, where the file system has locks: a run of another generation does not begin beside it.
class ResultFolder {
 public:
  /// Touches nothing.
  ///   parts       names of all files that will be written, relative to the folder
  ///   generation  files of runs with the same text may stand beside each other; "": they all are replaced
  ResultFolder(const std::string& folder, const std::string& index, const std::vector<std::string>& parts,
               const std::string& generation = "");
  /// Without commit() nothing of this run is left behind, and no index.
  ~ResultFolder();
  ResultFolder(const ResultFolder&) = delete;
  ResultFolder& operator=(const ResultFolder&) = delete;

  std::string path(const std::string& part) const;
  /// All that is written or removed: the index, the parts, and those of an earlier run. For require_apart().
  std::vector<std::string> outputs() const;

  /// Makes the folder and removes the earlier generation: first its index, then those of its files that still are as
  /// they were written. Throws IoError, also where another run writes the folder.
  void begin();
  /// Writes a part; any thread may.
  void write(const std::string& part, std::string_view text);
  /// Takes note of a part that was written to path().
  void add(const std::string& part);
  /// Writes `index` and in it "parts", the hash of each part by its name.
  void commit(Json index);

 private:
  /// What an index, or the list of an unfinished run, says of a folder.
  struct Listing {
    std::map<std::string, std::string> parts;     ///< hash by name, "" while it is unknown
    std::map<std::string, std::string> replaced;  ///< the same of an earlier generation, to be removed
    std::string generation, text;
  };

  std::optional<Listing> read_listing(const std::string& file) const;
  void take_over(const Listing& listing);
  void remove(const std::map<std::string, std::string>& parts) const;
  void refuse_other_run() const;
  void write_unfinished(const Json& listing);
  bool is_as_before() const;
  void restore_index() const;

  std::string folder_, index_, unfinished_;
  std::set<std::string> planned_;
  std::string generation_, index_before_;
  std::mutex mutex_;
  std::map<std::string, std::string> parts_;  ///< as in Listing
  bool begun_ = false, committed_ = false;
  int lock_ = -1;  ///< of <index>.unfinished
};

/// The parts that an index names, with their hashes; nothing where it names none.
std::map<std::string, std::string> parts_of(const JsonObject& index);

/// Throws InputError where the folder of an index was left by a run that was killed, or is being written.
void require_finished(const std::string& index_path);

/// Throws InputError where the file's hash is not the one that the index has.
void require_unchanged(const std::string& path, const std::string& sha256, const std::string& index_path);

}  // namespace leeway::io
