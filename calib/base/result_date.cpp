#include "calib/base/result_date.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cstdint>
#include <cstdlib>
#include <ctime>
#include <string_view>
#include <system_error>

namespace ceilmap {
namespace {

constexpr std::int64_t kEndOf9999 = 253402300799;

std::string InUtc(std::time_t seconds) {
  std::tm utc{};
  gmtime_r(&seconds, &utc);
  return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}Z",
                     utc.tm_year + 1900,
                     utc.tm_mon + 1,
                     utc.tm_mday,
                     utc.tm_hour,
                     utc.tm_min,
                     utc.tm_sec);
}

}  // namespace

std::optional<std::string> FixedResultDate() {
  const char* const variable = std::getenv("SOURCE_DATE_EPOCH");
  if (variable == nullptr) return std::nullopt;
  const std::string_view text = variable;
  std::int64_t seconds = 0;
  const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), seconds);
  const bool whole = error == std::errc{} && rest == text.data() + text.size();
  if (!whole || seconds < 0 || seconds > kEndOf9999) return std::nullopt;
  return InUtc(static_cast<std::time_t>(seconds));
}

std::string ResultDate() {
  if (std::optional<std::string> fixed = FixedResultDate()) return *std::move(fixed);
  return InUtc(std::time(nullptr));
}

}  // namespace ceilmap
