// Where am I? A program that has a camera and a map, and asks ceilmap for its pose frame by frame.
//   where_am_i MAP.gpkg RIG.yaml VIDEO|/dev/videoN
// Prints a line for each frame: seconds, status, x, y in metres, yaw in degrees, sigma in
// millimetres.

#include <cmath>
#include <cstdio>
#include <exception>
#include <numbers>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "calib/rig.hpp"
#include "localization/localizer.hpp"
#include "mapping/store/map_file.hpp"

namespace {

void Print(const ceilmap::localization::Location& location) {
  const ceilmap::graph::FramePose& pose = location.pose;
  std::printf("%.3f %s", pose.stamp_s, ceilmap::graph::ToString(pose.status));
  // A pose means something only when the robot is placed: lost and ambiguous are answers too.
  if (location.Placed()) {
    const double variance = 0.5 * (pose.covariance(0, 0) + pose.covariance(1, 1));
    std::printf(" %.4f %.4f %.3f %.2f",
                pose.T_map_base.x,
                pose.T_map_base.y,
                180 / std::numbers::pi * pose.T_map_base.yaw,
                1e3 * std::sqrt(variance));
  }
  std::printf("\n");
}

void Run(const char* map_file, const char* rig_file, const char* source) {
  const ceilmap::calib::Rig rig = ceilmap::calib::ReadRig(rig_file);
  const ceilmap::store::MapReader map(map_file);  // outlives the localizer
  ceilmap::localization::Localizer localizer(map, rig.up.value());
  cv::VideoCapture camera(source);
  const double fps = camera.get(cv::CAP_PROP_FPS);
  const double period_s = fps > 0 ? 1 / fps : 0.1;
  cv::Mat image;
  ceilmap::localization::CeilingFrame frame;
  while (camera.read(image)) {
    cv::cvtColor(image, frame.grey, cv::COLOR_BGR2GRAY);
    // On a robot: the middle of the exposure. A compass or wheel odometry would set frame.heading.
    frame.stamp_s = static_cast<double>(frame.index) * period_s;
    Print(localizer.Locate(frame));
    ++frame.index;
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fprintf(stderr, "where_am_i MAP.gpkg RIG.yaml VIDEO\n");
    return 2;
  }
  try {
    Run(argv[1], argv[2], argv[3]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "where_am_i: %s\n", error.what());
    return 1;
  }
  return 0;
}
