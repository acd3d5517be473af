#include "io/byte_source.hpp"

#include <array>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <unistd.h>
#include <utility>
#include <zlib.h>

#include <fmt/format.h>

#include "core/errors.hpp"
#include "io/text_encoding.hpp"

namespace leeway::io {

struct ByteSource::Inflation {
  z_stream stream{};
  std::array<unsigned char, 1 << 16> input;  // filled by what is read alone
  bool is_within_member = true;

  Inflation() {
    constexpr int kGzipOnly = 16;
    if (inflateInit2(&stream, kGzipOnly + MAX_WBITS) != Z_OK) throw std::bad_alloc();
  }
  ~Inflation() { inflateEnd(&stream); }
  Inflation(const Inflation&) = delete;
  Inflation& operator=(const Inflation&) = delete;
};

ByteSource::ByteSource(std::string path) : path_(std::move(path)) {
  fd_ = path_ == "-" ? STDIN_FILENO : ::open(path_.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd_ < 0) throw IoError(path_, fmt::format("cannot be opened: {}", std::strerror(errno)));
}

ByteSource::~ByteSource() {
  if (fd_ != STDIN_FILENO) ::close(fd_);
}

std::size_t ByteSource::read_file(char* into, std::size_t room) {
  for (;;) {
    const ssize_t got = ::read(fd_, into, room);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw IoError(path_, fmt::format("cannot be read: {}", std::strerror(errno)));
    return static_cast<std::size_t>(got);
  }
}

// A pipe may give single bytes.
void ByteSource::begin() {
  has_begun_ = true;
  std::array<char, 2> first{};
  std::size_t known = 0;
  while (known < first.size()) {
    const std::size_t got = read_file(first.data() + known, first.size() - known);
    if (got == 0) break;
    known += got;
  }
  head_.assign(first.data(), known);
  if (begins_as_utf16(head_)) throw InputError(path_, "is UTF-16; expected UTF-8 or Latin-1");
  if (head_ != "\x1F\x8B") return;
  inflation_ = std::make_unique<Inflation>();
  std::memcpy(inflation_->input.data(), head_.data(), head_.size());
  inflation_->stream.next_in = inflation_->input.data();
  inflation_->stream.avail_in = static_cast<uInt>(head_.size());
  head_.clear();
}

std::size_t ByteSource::read(char* into, std::size_t room) {
  if (!has_begun_) begin();
  if (inflation_) return inflate_some(into, room);
  if (head_.empty()) return read_file(into, room);
  const std::size_t taken = std::min(room, head_.size());
  std::memcpy(into, head_.data(), taken);
  head_.erase(0, taken);
  return taken;
}

std::size_t ByteSource::inflate_some(char* into, std::size_t room) {
  z_stream& stream = inflation_->stream;
  stream.next_out = reinterpret_cast<unsigned char*>(into);
  stream.avail_out = static_cast<uInt>(std::min<std::size_t>(room, 1U << 30));
  const uInt offered = stream.avail_out;
  while (stream.avail_out == offered) {
    if (stream.avail_in == 0) {
      auto& input = inflation_->input;
      const std::size_t got = read_file(reinterpret_cast<char*>(input.data()), input.size());
      if (got == 0 && inflation_->is_within_member)
        throw InputError(path_, "the gzip file ends too early; expected a whole one");
      if (got == 0) return 0;
      stream.next_in = input.data();
      stream.avail_in = static_cast<uInt>(got);
    }
    if (!std::exchange(inflation_->is_within_member, true)) inflateReset(&stream);  // a file may have several members
    const int state = inflate(&stream, Z_NO_FLUSH);
    if (state == Z_STREAM_END)
      inflation_->is_within_member = false;
    else if (state != Z_OK && state != Z_BUF_ERROR)
      throw InputError(path_, fmt::format("not valid gzip: {}", stream.msg != nullptr ? stream.msg : "broken"));
  }
  return offered - stream.avail_out;
}

}  // namespace leeway::io
