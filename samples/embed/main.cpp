// Maps the ceiling with the three cameras of a robot, then finds the robot on that map.
//   embed RIG.yaml FOLDER MAP.gpkg
// FOLDER holds up.mp4, forward.mp4 and omni.mp4, taken together at one rate.
// Prints per frame: seconds, status, x, y (m), yaw (deg), sigma (mm), pitch, heading (deg).

#include <cmath>
#include <cstdio>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <optional>
#include <string>

#include "localization/robot/robot.hpp"

namespace {

namespace robot = ceilmap::robot;

constexpr double kDegree = std::numbers::pi / 180;

/// On a robot: the driver of a camera, which knows when the exposure was.
class Camera {
 public:
  explicit Camera(const std::string& file) : video_(file) {}

  std::optional<robot::Image> Next() {
    const double seconds = index_ / video_.get(cv::CAP_PROP_FPS);
    robot::Image image{{}, seconds, index_++};
    return video_.read(image.pixels) ? std::optional(image) : std::nullopt;
  }

 private:
  cv::VideoCapture video_;
  int index_ = 0;
};

void Print(const robot::Estimate& estimate) {
  std::printf("%.3f %s", estimate.stamp_s, ceilmap::graph::ToString(estimate.status));
  if (estimate.HasPose()) {  // a lost or ambiguous robot has none
    const auto& [pose, covariance] = estimate.pose;
    const double sigma_m = std::sqrt(0.5 * covariance.topLeftCorner<2, 2>().trace());
    std::printf(" %.4f %.4f %.3f %.2f", pose.x, pose.y, pose.yaw / kDegree, 1e3 * sigma_m);
    std::printf(" %.2f", estimate.tilt.pitch_rad / kDegree);
    if (estimate.heading) std::printf(" %.2f", estimate.heading->heading_rad / kDegree);
  }
  std::printf("\n");
}

/// The same loop maps and localizes.
template <typename Robot>
void Drive(const std::string& folder, Robot& robot) {
  Camera up(folder + "/up.mp4");
  Camera forward(folder + "/forward.mp4");
  Camera omni(folder + "/omni.mp4");
  while (std::optional<robot::Image> image = up.Next()) {
    // What belongs to an upward image is added before it.
    if (const auto ahead = forward.Next()) robot.AddForward(*ahead);
    if (const auto around = omni.Next()) robot.AddOmni(*around);
    cv::cvtColor(image->pixels, image->pixels, cv::COLOR_BGR2GRAY);
    Print(robot.AddCeiling(*image));
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) return std::fprintf(stderr, "embed RIG.yaml FOLDER MAP.gpkg\n"), 2;
  try {
    const ceilmap::calib::Rig rig = ceilmap::calib::ReadRig(argv[1]);
    robot::CeilingMapper mapper(rig, argv[3]);
    Drive(argv[2], mapper);
    mapper.Finish();
    std::printf("map %s: %zu frames placed\n", argv[3], mapper.PlacedFrames());
    robot::CeilingLocalizer localizer(argv[3], rig);
    Drive(argv[2], localizer);
  } catch (const std::exception& error) {
    return std::fprintf(stderr, "embed: %s\n", error.what()), 1;
  }
}
