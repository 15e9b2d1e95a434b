#pragma once

#include <fmt/format.h>

#include <cmath>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "app/files/heading_csv.hpp"
#include "calib/base/degrees.hpp"
#include "tests/support/child_process.hpp"
#include "tests/support/synthetic_panorama.hpp"
#include "tests/support/synthetic_recording.hpp"
#include "tests/support/test_folder.hpp"

namespace ceilmap::integration {
constexpr int kTurnFrames = 16;
constexpr int kDarkFrom = 5;  // in `dark`, frames without light
constexpr int kDarkTo = 9;
const cv::Size kMirrorImage(240, 240);
const calib::MirrorRing kMirrorRing{{121, 118}, 30, 110};

/// Columns of 1 deg that the robot has turned to the left at a frame: there, and farther back.
inline int TurnAt(int frame) {
  return frame < 10 ? 3 * frame : 27 - 4 * (frame - 9);
}

/// A camera under a mirror of unknown shape, mounted turned by a yaw.
inline std::string OmniRig(double yaw_deg) {
  const double half = 0.5 * (90 + yaw_deg) * kRadPerDeg;
  return fmt::format(
      "a: 0.1\nh: 2.4\ncameras:\n  omni:\n    type: mirror\n    image_width: 240\n"
      "    image_height: 240\n"
      "    base_link_to_camera: {{translation: [0, 0, 0.5], rotation_xyzw: [0, 0, {:.12f}, "
      "{:.12f}]}}\n"
      "    mirror: {{inner_radius_px: 30, outer_radius_px: 110, centre_px: [121, 118]}}\n",
      std::sin(half),
      std::cos(half));
}

/// A folder with recordings of a robot that turns on the spot, beside an empty one for results.
class HeadingCommand : public testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::copy(
        RecordedOnce().Path(), in_.Path(), std::filesystem::copy_options::recursive);
  }
  /// Made once; each test has a copy, which it may change.
  static const support::TestFolder& RecordedOnce() {
    static const support::TestFolder folder;
    static const bool written = (WriteAll(folder), true);
    static_cast<void>(written);
    return folder;
  }

  static void WriteAll(const support::TestFolder& in) {
    const cv::Mat world = support::SyntheticPanorama({360, 45});
    std::vector<cv::Mat> omni;
    std::vector<cv::Mat> panoramas;
    std::vector<cv::Mat> rising;
    std::string truth;
    for (int i = 0; i < kTurnFrames; ++i) {
      const double turn = TurnAt(i) * kRadPerDeg;
      omni.push_back(support::MirrorImage(world, kMirrorImage, kMirrorRing, turn));
      panoramas.push_back(support::TurnedPanorama(world, TurnAt(i)));
      cv::flip(panoramas.back(), rising.emplace_back(), 1);
      truth += fmt::format("{:.6f} {} 0 0 0 0 {:.9f} {:.9f}\n",
                           100 + 0.1 * i,
                           0.05 * i,
                           std::sin(0.5 * turn + 1),
                           std::cos(0.5 * turn + 1));
    }
    support::WriteImages(in / "omni", omni);
    support::WriteImages(in / "panoramas", panoramas);
    std::vector<cv::Mat> dark = omni;
    for (int i = kDarkFrom; i < kDarkTo; ++i)
      dark[i] = cv::Mat::zeros(omni[i].size(), omni[i].type());
    support::WriteImages(in / "dark", dark);
    support::WriteImages(in / "rising", rising);
    WriteDamaged(in, panoramas);
    in.Write("truth.tum", truth);
    in.Write("sideways.tum", Sideways(0.1));
    in.Write("dense.tum", Sideways(0.02));
    in.Write("later.tum", "500 0 0 0 0 0 0 1\n");
    in.Write("rig.yaml", OmniRig(0));
    in.Write("turned.yaml", OmniRig(35));
    in.Write("gyro.csv", Gyro());
    in.Write("wheels.csv", Wheels());
    in.Write("stamps.csv", support::StampsCsv(kTurnFrames, 100, 0.1));
  }

  /// A gyro at 100 Hz with a bias of 0.01 rad/s.
  static std::string Gyro() {
    std::string samples = "timestamp,omega_z\n";
    for (int i = -20; i <= 10 * kTurnFrames + 20; ++i) {
      const int frame = static_cast<int>(std::floor(0.1 * i));
      const double rate = frame < 0 || frame + 1 >= kTurnFrames
                              ? 0
                              : 10 * (TurnAt(frame + 1) - TurnAt(frame)) * kRadPerDeg;
      samples += fmt::format("{:.6f},{:.9f}\n", 100 + 0.01 * i + 0.005, rate + 0.01);
    }
    return samples;
  }
  /// Wheels that roll and turn, as poses.
  static std::string Wheels() {
    std::string poses = "timestamp,x,y,yaw_deg\n";
    for (int i = 0; i < kTurnFrames; ++i) {
      poses += fmt::format("{:.6f},0,0,{}\n", 100 + 0.1 * i, TurnAt(i));
    }
    return poses + "101.6,0,0,0\n";
  }

  /// Poses of a robot that always travels to its left, with this period in seconds.
  static std::string Sideways(double period_s) {
    std::string poses;
    for (double t = 0; t < 0.1 * kTurnFrames; t += period_s) {
      poses += fmt::format("{:.6f} 2 {:.6f} 0 0 0 0 1\n", 100 + t, 0.5 * t);
    }
    return poses;
  }

  static void WriteDamaged(const support::TestFolder& in, const std::vector<cv::Mat>& panoramas) {
    support::WriteVideo(in / "grey.avi",
                        {cv::Mat(48, 320, CV_8U, cv::Scalar(90)),
                         cv::Mat(48, 320, CV_8U, cv::Scalar(90)),
                         cv::Mat(48, 320, CV_8U, cv::Scalar(90))},
                        10);
    support::WriteImages(in / "narrow", {panoramas[0].colRange(0, 7).clone()});
    support::WriteImages(in / "sizes",
                         {panoramas[0], panoramas[1], panoramas[2].colRange(0, 200).clone()});
    support::WriteImages(in / "small", {cv::Mat(80, 100, CV_8UC3, cv::Scalar(1, 2, 3))});
    in.Write("text.mp4", "this is no video\n");
    in.Write("short.csv", support::StampsCsv(kTurnFrames - 1, 100, 0.1));
    in.Write("back.csv", "index,timestamp\n0,1\n1,0.5\n");
    in.Write("blind.yaml",
             "a: 0.1\nh: 2.4\ncameras: {forward: {type: pinhole, image_width: 240, image_height: "
             "240, camera_matrix: {rows: 3, cols: 3, data: [200, 0, 119.5, 0, 200, 119.5, 0, 0, "
             "1]}, distortion_model: none, base_link_to_camera: {translation: [0, 0, 0.4], "
             "rotation_xyzw: [-0.5, 0.5, -0.5, 0.5]}}}\n");
  }

  // `@NAME` in an argument stands for NAME among the inputs.
  [[nodiscard]] std::vector<std::string> Resolve(std::vector<std::string> arguments) const {
    for (std::string& argument : arguments) {
      const std::size_t at = argument.find('@');
      if (at != std::string::npos) argument.replace(at, 1, in_.Path().string() + "/");
    }
    return arguments;
  }
  [[nodiscard]] support::ProcessResult Run(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "heading");
    return support::RunCeilmap(Resolve(std::move(arguments)), out_.Path().string());
  }

  // The turns of the robot, counter-clockwise from the first frame.
  void ExpectTurns(const std::string& file, double first_s, double period_s, int step = 1) const {
    const auto headings = files::ReadHeadings(out_ / file);
    ASSERT_EQ(headings.size(), static_cast<std::size_t>((kTurnFrames + step - 1) / step));
    for (std::size_t i = 0; i < headings.size(); ++i) {
      const int frame = step * static_cast<int>(i);
      EXPECT_NEAR(headings[i].stamp_s, first_s + period_s * frame, 1e-6);
      EXPECT_NEAR(headings[i].heading_rad / kRadPerDeg, TurnAt(frame), 0.6) << frame;
    }
  }

  support::TestFolder in_;
  support::TestFolder out_;
};

}  // namespace ceilmap::integration
