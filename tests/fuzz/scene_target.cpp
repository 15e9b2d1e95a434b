#include <cmath>
#include <string>

#include "samples/simulator/scene.hpp"
#include "tests/fuzz/promise.hpp"
#include "tests/fuzz/targets.hpp"

namespace ceilmap::fuzz {

void ReadAsScene(std::string_view bytes) {
  const auto scene =
      Accepted([&] { return simulator::ParseScene(std::string(bytes), "/nowhere/scene.yaml"); });
  if (!scene) return;
  scene->Validate();  // throws nothing any more
  Require(scene->camera.width_px > 0 && scene->room.height_m > 0, "a scene that cannot be");
}

}  // namespace ceilmap::fuzz
