#include "fuzz/readers.hpp"

#include <algorithm>
#include <functional>

#include <nlohmann/json.hpp>

#include "core/errors.hpp"

namespace leeway::test {
namespace {

// Pointers to all values of the wanted kind that a reader must look at.
void collect(const io::Json& json, const std::string& pointer, const std::vector<std::string>& free, bool objects,
             std::vector<std::string>& found) {
  if (objects ? json.is_object() : json.is_number()) found.push_back(pointer);
  if (!json.is_structured()) return;
  for (const auto& [key, value] : json.items()) {
    if (json.is_object() && std::find(free.begin(), free.end(), key) != free.end()) continue;
    std::string escaped;
    for (const char c : key) escaped += c == '~' ? "~0" : c == '/' ? "~1" : std::string(1, c);
    collect(value, pointer + "/" + escaped, free, objects, found);
  }
}

}  // namespace

std::vector<Reader> readers() {
  std::vector<Reader> all;
  for (const auto* some : {&csv_readers(), &json_readers(), &model_readers()})
    all.insert(all.end(), some->begin(), some->end());
  return all;
}

bool accepts(const Reader& reader, HostileFiles& files, std::string_view text) {
  const auto check_message = [&](const std::string& message, bool names_other = false) {
    expect(message.starts_with(files.folder() + "/") || message.starts_with("-:") || names_other,
           "a message does not begin with the file: " + message);
  };
  try {
    reader.read(files, text);
    return true;
  } catch (const Misread&) {
    throw;
  } catch (const InputError& error) {
    check_message(error.what());
  } catch (const IoError& error) {
    check_message(error.what(), true);  // of a file that the text names
  } catch (const std::exception& error) {
    throw Misread(fmt::format("refused, but not as a wrong file: {}", error.what()));
  }
  return false;
}

void expect_strict(const std::string& text, const std::vector<std::string>& free,
                   const std::function<void(const std::string&)>& read) {
  std::size_t draw = std::hash<std::string>()(text);
  if (draw % 4 != 0) return;  // reading twice takes twice as long
  draw /= 4;
  io::Json json = io::Json::parse(text);
  const bool adds_key = draw % 2 == 0;
  std::vector<std::string> places;
  collect(json, "", free, adds_key, places);
  if (places.empty()) return;
  const std::string& place = places[draw / 2 % places.size()];
  io::Json& value = json[io::Json::json_pointer(place)];
  if (adds_key)
    value["no such key"] = 1;
  else
    value = "no number";
  try {
    read(json.dump(-1, ' ', false, io::Json::error_handler_t::replace));
  } catch (const InputError&) {
    return;
  }
  throw Misread(fmt::format("{}: {} is accepted", place, adds_key ? "a key that nobody knows" : "a text as a number"));
}

}  // namespace leeway::test
