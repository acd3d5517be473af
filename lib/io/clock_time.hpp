#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace leeway::io {

/// How a recording's clock is written.
enum class ClockFormat { iso8601, epoch, hms, pattern };

/// Reads clock times, one after the other, as seconds since the first one.
///   iso8601  2020-11-12T23:59:58.5+01:00, also with a blank for T and without zone, seconds or separators
///   epoch    seconds since 1970, with as many digits as there are
///   hms      23:59:58.5; what goes back by more than half a day has passed midnight, and so does a pattern without
///            date
///   pattern  as of strptime, with fractions of %S and zones by %z
/// Times with a zone are brought to UTC; without one they are as they stand, so that a change to or from summer time
/// shows as a jump.
class ClockReader {
 public:
  explicit ClockReader(ClockFormat format, std::string pattern = "");
  ~ClockReader();
  ClockReader(ClockReader&&) noexcept;
  ClockReader& operator=(ClockReader&&) noexcept;

  /// Nothing for what is no time in this format.
  std::optional<double> seconds(std::string_view text);
  /// What is expected, for messages.
  std::string expected() const;

 private:
  struct Pattern;

  std::optional<std::int64_t> nanoseconds(std::string_view text);

  ClockFormat format_;
  std::unique_ptr<Pattern> pattern_;
  bool has_date_;
  std::int64_t midnights_ = 0;
  std::optional<std::int64_t> first_, last_;
};

/// Whether a strptime pattern can be read at all: each % stands before a letter that is known, and there is a time of
/// day or a date in it.
bool is_clock_pattern(const std::string& pattern);

}  // namespace leeway::io
