#include "app/recordings/message_times.hpp"

#include <algorithm>

namespace ceilmap::recordings {

double SecondsOf(std::int64_t ns) {
  constexpr std::int64_t kNsPerS = 1'000'000'000;
  const std::int64_t whole_s = ns / kNsPerS;  // exact, unlike 1e-9 * ns
  return static_cast<double>(whole_s) + 1e-9 * static_cast<double>(ns % kNsPerS);
}

std::optional<std::int64_t> MessageTimes::Of(std::int64_t header_ns, std::int64_t log_ns) {
  constexpr std::int64_t kMinNs = 1'000'000;  // much more than a double resolves
  constexpr std::int64_t kMaxLateNs = 1'000'000'000;
  std::int64_t stamp_ns = stamp_ == BagStamp::kHeader ? header_ns : log_ns;
  const bool missing = stamp_ == BagStamp::kHeader && header_ns == 0;
  if (stamp_ == BagStamp::kHeader && !missing && last_ns_) {
    set_back_ = header_ns < *last_ns_ && (set_back_ || log_ns - last_log_ns_ >= kMaxLateNs);
    if (header_ns < *last_ns_ && !set_back_) {
      ++late_;
      return std::nullopt;
    }
  }
  if (missing || (last_ns_ && stamp_ns <= *last_ns_)) {
    stamp_ns = last_ns_ ? *last_ns_ + std::max(log_ns - last_log_ns_, kMinNs) : log_ns;
    if (stamp_ == BagStamp::kHeader) ++replaced_;
  }
  last_ns_ = stamp_ns;
  last_log_ns_ = log_ns;
  return stamp_ns;
}

}  // namespace ceilmap::recordings
