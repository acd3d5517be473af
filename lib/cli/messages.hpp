#pragma once

#include <string>
#include <string_view>

/// Messages on the standard error. They are best effort: whether somebody can read them never decides whether a tool
/// does its work or how it ends. All messages of all tools go through here.
namespace leeway::cli {

/// Writes a text as it is; what cannot be written is lost without a word. Safe to call from several threads.
void say(std::string_view text) noexcept;

/// A text that may quote a file that is not text at all: without control characters, and not a megabyte.
std::string one_line(std::string text);

/// Opens /dev/null in the place of standard streams that are closed, so that no file of the tool's own takes it and
/// gets what belongs into the stream. Reading the standard input, or writing the standard output, then fails.
void keep_closed_streams_closed();

/// Sends what spdlog logs to say(), a line each: "program: warning: what", colored on a terminal.
void log_to_messages(const std::string& program, bool verbose, bool quiet);

}  // namespace leeway::cli
