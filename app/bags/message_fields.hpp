#pragma once

#include <cstdint>

#include "app/bags/cdr.hpp"
#include "app/bags/messages.hpp"

/// Parts that messages of several types have in common.
namespace ceilmap::bags {

inline Header ReadHeader(CdrReader& reader) {
  constexpr std::int64_t kNsPerS = 1'000'000'000;
  Header header;
  std::int64_t seconds = 0;
  if (reader.Ros1()) {
    (void)reader.Number<std::uint32_t>();  // a counter
    seconds = reader.Number<std::uint32_t>();
  } else {
    seconds = reader.Number<std::int32_t>();
  }
  header.stamp_ns = seconds * kNsPerS + reader.Number<std::uint32_t>();
  header.frame_id = reader.Text();
  return header;
}

inline Transform ReadTransform(CdrReader& reader) {
  Transform transform;
  reader.Numbers(transform.translation);
  reader.Numbers(transform.rotation);
  return transform;
}

}  // namespace ceilmap::bags
