#pragma once

#include <cmath>
#include <fstream>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "calib/rig.hpp"
#include "ceilmap_ros/logic/inbox.hpp"

namespace ceilmap_ros {

inline const std::string kSamples = std::string(CEILMAP_SOURCE_DIR) + "/samples/";

/// The first frames of samples/lab-map with their true poses.
struct LabDrive {
  explicit LabDrive(int count) {
    cv::VideoCapture video(kSamples + "lab-map/up.mp4");
    std::ifstream truth(kSamples + "lab-map/truth.tum");
    cv::Mat image;
    std::string line;
    while (static_cast<int>(images.size()) < count && video.read(image) &&
           std::getline(truth, line)) {
      images.emplace_back();
      cv::cvtColor(image, images.back(), cv::COLOR_BGR2GRAY);
      std::istringstream row(line);
      double stamp_s = 0;
      Pose2 T;
      double z = 0;
      double qx = 0;
      double qy = 0;
      double qz = 0;
      double qw = 1;
      row >> stamp_s >> T.x >> T.y >> z >> qx >> qy >> qz >> qw;
      T.yaw = 2 * std::atan2(qz, qw);
      truths.push_back(T);
    }
  }

  /// Stamps as of a robot's clock, 10 images a second.
  static Stamp StampOf(int i) { return 1'700'000'000'123'456'789 + i * (kSecond / 10); }
  [[nodiscard]] Pose2 T_map_base(int i) const {
    return truths[0].Inverse() * truths[static_cast<std::size_t>(i)];
  }
  /// Odometry without errors in a frame of its own.
  [[nodiscard]] Pose2 T_odom_base(int i) const {
    return T_odom_room * truths[static_cast<std::size_t>(i)];
  }
  [[nodiscard]] Pose2 T_map_odom() const { return truths[0].Inverse() * T_odom_room.Inverse(); }
  [[nodiscard]] const cv::Mat& Image(int i) const { return images[static_cast<std::size_t>(i)]; }

  static ceilmap::calib::Rig Rig() {
    return ceilmap::calib::ReadRig(kSamples + "lab-map/rig.yaml");
  }

  /// What arrives at the time of an image: it and the odometry.
  void Send(int i, Inbox& inbox) const {
    inbox.AddOdometry({StampOf(i), T_odom_base(i)});
    inbox.AddCeiling(Image(i), StampOf(i), StampOf(i));
  }

  std::vector<cv::Mat> images;
  std::vector<Pose2> truths;  // T_room_base
  Pose2 T_odom_room{3, -2, 0.7};
};

inline double Distance(const Pose2& a, const Pose2& b) {
  return (a.Translation() - b.Translation()).norm();
}
inline double Turn(const Pose2& a, const Pose2& b) {
  return std::abs(ceilmap::WrapAngle(a.yaw - b.yaw));
}

}  // namespace ceilmap_ros
