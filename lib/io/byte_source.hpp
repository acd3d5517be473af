#pragma once

#include <cstddef>
#include <memory>
#include <string>

namespace leeway::io {

/// A file's bytes from front to back ("-": standard input). One that is compressed with gzip, which its first bytes
/// tell, gives the bytes that were compressed.
class ByteSource {
 public:
  /// Throws IoError.
  explicit ByteSource(std::string path);
  ~ByteSource();
  ByteSource(const ByteSource&) = delete;
  ByteSource& operator=(const ByteSource&) = delete;

  /// Reads at most `room` > 0 bytes; 0 at the end. Throws IoError, InputError for bad gzip.
  std::size_t read(char* into, std::size_t room);

 private:
  struct Inflation;

  std::size_t read_file(char* into, std::size_t room);
  std::size_t inflate_some(char* into, std::size_t room);
  void begin();

  std::string path_;
  int fd_ = -1;
  bool has_begun_ = false;
  std::string head_;  // bytes that were read to tell gzip from text
  std::unique_ptr<Inflation> inflation_;
};

}  // namespace leeway::io
