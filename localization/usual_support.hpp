#pragma once

namespace ceilmap::localization {

/// A pose must be supported by this part of the blocks that agreed before: a match that confirms a
/// trusted place alone, and one that contradicts the wheels. At other places of a hall with equal
/// tiles matches had up to 0.83; wheels slip less often than a robot that was carried sees a
/// ceiling like the one that it left.
inline constexpr double kUsualSupport = 0.85;

}  // namespace ceilmap::localization
