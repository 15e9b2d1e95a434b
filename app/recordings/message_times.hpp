#pragma once

#include <cstdint>
#include <optional>

namespace ceilmap::recordings {

/// Which time of a bag's messages is their stamp.
enum class BagStamp : std::uint8_t {
  kHeader,  ///< that of the message's header: when it was measured
  kLog,     ///< that of the bag: when it was recorded
};

/// Nanoseconds in seconds; exact to 2.4e-7 s for times of this century.
double SecondsOf(std::int64_t ns);

/// The stamps of a topic's messages, which increase strictly. A header without a time (0), or with
/// one that is not later than that of the message before, has the time since that message by the
/// log instead. A message that comes after later ones, by less than a second of the log, is left
/// out: it was only recorded late. After that the clock was set back.
class MessageTimes {
 public:
  explicit MessageTimes(BagStamp stamp) : stamp_(stamp) {}

  /// The stamp of the next message, nanoseconds; nothing: it is to be left out.
  std::optional<std::int64_t> Of(std::int64_t header_ns, std::int64_t log_ns);
  /// Messages whose stamp is not that of their header, although this was asked for.
  [[nodiscard]] std::int64_t Replaced() const { return replaced_; }
  /// Messages that were left out.
  [[nodiscard]] std::int64_t Late() const { return late_; }

 private:
  BagStamp stamp_;
  std::optional<std::int64_t> last_ns_;
  std::int64_t last_log_ns_ = 0;
  std::int64_t replaced_ = 0;
  std::int64_t late_ = 0;
  bool set_back_ = false;  // the headers' clock is behind the last stamp
};

}  // namespace ceilmap::recordings
