#include <sstream>
#include <string>

#include "app/recordings/mp4_rate.hpp"
#include "tests/fuzz/promise.hpp"
#include "tests/fuzz/targets.hpp"

namespace ceilmap::fuzz {

void ReadAsMp4(std::string_view bytes) {
  std::stringstream stream{std::string(bytes)};
  constexpr double kFactor = 0.5;
  const bool changed = recordings::SpeedUpMp4(stream, kFactor);
  Require(stream.str().size() == bytes.size(), "a video has another size");
  Require(changed || bytes.size() < 8 || !stream.str().empty(), "a video is lost");
}

}  // namespace ceilmap::fuzz
