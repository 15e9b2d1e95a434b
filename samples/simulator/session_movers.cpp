#include "samples/simulator/session_movers.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "calib/base/degrees.hpp"
#include "samples/simulator/drive.hpp"
#include "samples/simulator/motion.hpp"
#include "samples/simulator/path_points.hpp"
#include "samples/simulator/random.hpp"

namespace ceilmap::simulator {
namespace {

constexpr double kStep = 0.2;  // seconds

/// The robot's way over the floor, sampled.
std::vector<Pose2> SampleWay(const Scene& scene) {
  const double duration_s = Drive(PathPoints(scene), scene.path).Duration();
  const Motion motion(scene);
  constexpr double kMaxSamples = 20000;
  const auto count = static_cast<int>(std::min(duration_s / kStep, kMaxSamples)) + 1;
  std::vector<Pose2> way;
  way.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) way.push_back(motion.AxleAt(i * kStep));
  return way;
}

/// What moves beside the robot.
struct Passer {
  double length_m = 0.3;  ///< along its own motion
  double width_m = 0.5;
  double top_m = 1.75;
  double speed_m_s = 1;  ///< 0: stands all the time
  double during_s = 8;
  double least_offset_m = 0.55;  ///< beside the robot, of the centre
  double most_offset_m = 1.0;
};

class PasserPlacer {
 public:
  PasserPlacer(const Scene& scene, const std::vector<Pose2>& way) : scene_(scene), way_(way) {}

  /// A free place and time for a passer.
  [[nodiscard]] std::optional<Mover> Find(const Passer& passer, Random& random) const {
    constexpr int kMaxTries = 300;
    for (int i = 0; i < kMaxTries; ++i) {
      const Mover mover = Propose(passer, random);
      if (IsClear(mover)) return mover;
    }
    return std::nullopt;
  }

 private:
  [[nodiscard]] Mover Propose(const Passer& passer, Random& random) const {
    const std::size_t index = random.Bits() % way_.size();
    const Pose2& robot = way_[index];
    const double side = (random.Bits() & 1U) != 0 ? 1 : -1;
    const double offset_m = side * random.Uniform(passer.least_offset_m, passer.most_offset_m);
    const bool is_opposite = (random.Bits() & 1U) != 0;
    const double yaw_rad = robot.yaw + random.Uniform(-0.15, 0.15);
    const double speed = is_opposite ? -passer.speed_m_s : passer.speed_m_s;
    const double x_m = robot.x - offset_m * std::sin(robot.yaw);
    const double y_m = robot.y + offset_m * std::cos(robot.yaw);
    const double grey = random.Uniform(0.05, 0.8);
    Mover mover;
    mover.velocity_x_m_s = speed * std::cos(yaw_rad);
    mover.velocity_y_m_s = speed * std::sin(yaw_rad);
    const double half_s = passer.during_s / 2;
    const double now_s = static_cast<double>(index) * kStep;
    mover.from_s = speed == 0 ? 0 : now_s - half_s;
    mover.to_s = speed == 0 ? static_cast<double>(way_.size()) * kStep : now_s + half_s;
    mover.x_m = x_m - half_s * mover.velocity_x_m_s;
    mover.y_m = y_m - half_s * mover.velocity_y_m_s;
    mover.length_m = passer.length_m;
    mover.width_m = passer.width_m;
    mover.top_m = std::min(passer.top_m, scene_.room.height_m - 0.3);
    mover.yaw_deg = std::remainder(yaw_rad * kDegPerRad, 360);
    mover.red = mover.green = mover.blue = grey;
    return mover;
  }

  /// The robot never comes so close that a camera could be inside.
  [[nodiscard]] bool IsClear(const Mover& mover) const {
    const double least_m = std::hypot(mover.length_m, mover.width_m) / 2 + 0.2;
    for (std::size_t i = 0; i < way_.size(); ++i) {
      const double now_s = static_cast<double>(i) * kStep;
      if (now_s < mover.from_s || now_s > mover.to_s) continue;
      const double passed_s = now_s - mover.from_s;
      const double dx = mover.x_m + passed_s * mover.velocity_x_m_s - way_[i].x;
      const double dy = mover.y_m + passed_s * mover.velocity_y_m_s - way_[i].y;
      if (std::hypot(dx, dy) < least_m) return false;
    }
    return mover.top_m > mover.bottom_m;
  }

  const Scene& scene_;
  const std::vector<Pose2>& way_;
};

}  // namespace

void AddSessionMovers(const Sessions& sessions, Scene& scene) {
  if (sessions.people + sessions.masts == 0) return;
  const std::vector<Pose2> way = SampleWay(scene);
  const PasserPlacer placer(scene, way);
  Random random(DriveSeed(scene), Purpose::kSessionMovers);
  const auto add = [&](const Passer& passer) {
    const std::optional<Mover> mover = placer.Find(passer, random);
    if (mover) scene.movers.push_back(*mover);
  };
  for (int i = 0; i < sessions.people; ++i) add({});
  for (int i = 0; i < sessions.masts; ++i) {
    add({0.2, 0.9, 3.4, i % 2 == 0 ? 0.0 : 0.6, 12, 0.75, 1.4});
  }
}

}  // namespace ceilmap::simulator
