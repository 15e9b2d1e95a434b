// The entry of libFuzzer, for the target that CEILMAP_FUZZ_TARGET names.

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "tests/fuzz/targets.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  ceilmap::fuzz::CEILMAP_FUZZ_TARGET(
      std::string_view(reinterpret_cast<const char*>(data), size));  // empty: data may be null
  return 0;
}
