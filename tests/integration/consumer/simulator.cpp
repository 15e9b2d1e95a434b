// Renders an image of a simulated ceiling with the installed library.

#include <cstdlib>

#include "samples/simulator/path.hpp"
#include "samples/simulator/renderer.hpp"

int main() {
  const ceilmap::simulator::Renderer renderer({});
  const auto frames = ceilmap::simulator::MakePath(renderer.GetScene());
  const cv::Mat image = renderer.Render(frames.front());
  return image.size() == cv::Size(640, 480) ? EXIT_SUCCESS : EXIT_FAILURE;
}
