#include "cli/messages.hpp"

#include <array>
#include <cerrno>
#include <fcntl.h>
#include <memory>
#include <mutex>
#include <unistd.h>

#include <fmt/format.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>

namespace leeway::cli {
namespace {

class MessageSink final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  MessageSink() : colored_(::isatty(STDERR_FILENO) == 1) {}

 private:
  void sink_it_(const spdlog::details::log_msg& message) override {
    const std::string payload = one_line({message.payload.data(), message.payload.size()});
    spdlog::details::log_msg cleaned = message;
    cleaned.payload = payload;
    spdlog::memory_buf_t text;
    formatter_->format(cleaned, text);
    const std::string_view line(text.data(), text.size());
    const std::size_t begin = cleaned.color_range_start, end = cleaned.color_range_end;
    if (!colored_ || end <= begin || end > line.size()) return say(line);
    const std::string_view color = message.level >= spdlog::level::err    ? "\x1b[31m\x1b[1m"
                                   : message.level >= spdlog::level::warn ? "\x1b[33m\x1b[1m"
                                                                          : "\x1b[32m";
    say(fmt::format("{}{}{}\x1b[m{}", line.substr(0, begin), color, line.substr(begin, end - begin), line.substr(end)));
  }
  void flush_() override {}

  bool colored_;
};

}  // namespace

void say(std::string_view text) noexcept {
  const int before = errno;
  while (!text.empty()) {
    const ssize_t written = ::write(STDERR_FILENO, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) break;
    text.remove_prefix(static_cast<std::size_t>(written));
  }
  errno = before;
}

std::string one_line(std::string text) {
  constexpr std::size_t kStart = 1200, kEnd = 800;  // where something is, and what
  if (text.size() > kStart + kEnd) text = text.substr(0, kStart) + "..." + text.substr(text.size() - kEnd);
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  return text;
}

void keep_closed_streams_closed() {
  // The lowest free number is taken: in this order each gets its own.
  constexpr std::array kModes{O_WRONLY, O_RDONLY, O_WRONLY};
  for (int stream = 0; stream < 3; ++stream)
    if (::fcntl(stream, F_GETFD) < 0 && errno == EBADF)
      if (const int fd = ::open("/dev/null", kModes[static_cast<std::size_t>(stream)]); fd > stream) ::close(fd);
}

void log_to_messages(const std::string& program, bool verbose, bool quiet) {
  auto logger = std::make_shared<spdlog::logger>("leeway", std::make_shared<MessageSink>());
  logger->set_pattern(program + ": %^%l%$: %v");
  logger->set_level(quiet ? spdlog::level::err : verbose ? spdlog::level::debug : spdlog::level::info);
  spdlog::set_default_logger(logger);
}

}  // namespace leeway::cli
