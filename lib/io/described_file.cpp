#include "io/described_file.hpp"

#include <filesystem>

#include <nlohmann/json.hpp>

#include "io/files.hpp"

namespace leeway::io {
namespace fs = std::filesystem;

std::string provenance_path(const std::string& file) {
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (file.empty() || file == "-" || (fs::exists(status) && !fs::is_regular_file(status))) return "";
  return file + ".provenance.json";
}

void write_described(const std::string& file, std::string_view text, const Json& provenance) {
  const std::string beside = provenance_path(file);
  if (beside.empty()) return write_text(file, text);
  OutputFile result(file);
  result.write(text);
  OutputFile description(beside);
  description.write(to_text({{"sha256", sha256(text)}, {"provenance", provenance}}));
  result.commit([&] { remove_output(beside); });
  description.commit();
}

void remove_described(const std::string& file) {
  if (const std::string beside = provenance_path(file); !beside.empty()) remove_output(beside);
  remove_output(file);
}

}  // namespace leeway::io
