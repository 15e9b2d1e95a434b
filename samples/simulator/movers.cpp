#include "samples/simulator/movers.hpp"

#include "samples/simulator/paints.hpp"
#include "samples/simulator/structures.hpp"

namespace ceilmap::simulator {

std::vector<PaintedSolid> MoversAt(const Scene& scene, double stamp_s, double shift_s) {
  const double now_s = stamp_s - StartStamp(scene);
  std::vector<PaintedSolid> seen;
  for (const Mover& m : scene.movers) {
    if (now_s < m.from_s || now_s > m.to_s) continue;
    const double moved_s = now_s - m.from_s;
    const double brightness = Luminance(m.red, m.green, m.blue);
    const Box box{m.x_m + moved_s * m.velocity_x_m_s,
                  m.y_m + moved_s * m.velocity_y_m_s,
                  m.length_m,
                  m.width_m,
                  m.bottom_m,
                  m.top_m,
                  m.yaw_deg,
                  brightness};
    const cv::Vec3f colour(cv::Vec3d(m.blue, m.green, m.red));
    seen.push_back({SolidOf(box, scene.fixtures.contrast),
                    brightness > 0 ? colour / brightness : cv::Vec3f(1, 1, 1)});
  }
  for (const Solid& solid : MovingStructures(scene, now_s + shift_s)) {
    seen.push_back({solid, cv::Vec3f(1, 1, 1)});
  }
  return seen;
}

}  // namespace ceilmap::simulator
