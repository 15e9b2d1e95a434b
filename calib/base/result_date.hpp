#pragma once

#include <optional>
#include <string>

namespace ceilmap {

/// The date that results carry when the environment variable SOURCE_DATE_EPOCH states one (seconds
/// since 1970, https://reproducible-builds.org/docs/source-date-epoch/), as `2026-11-27T21:00:00Z`:
/// the same run then writes the same bytes at any time. Nothing without the variable, and when it
/// is not a whole number of seconds up to the year 9999.
std::optional<std::string> FixedResultDate();

/// That date, or else this moment by the machine's clock.
std::string ResultDate();

}  // namespace ceilmap
