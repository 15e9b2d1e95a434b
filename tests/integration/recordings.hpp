#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "tests/support/child_process.hpp"
#include "tests/support/synthetic_recording.hpp"
#include "tests/support/test_folder.hpp"

namespace ceilmap::integration {

/// A level upward camera of 320 x 240 px at 0.4 m under a ceiling at 2.4 m: 0.01 m per pixel. The
/// image's right is the robot's left, its top the robot's front.
inline const std::string kRig = R"(robot: "test robot"
a: 0.1
d: null
h: 2.4
frames: {map: map, base: base_link}
cameras:
  up:
    type: pinhole
    image_width: 320
    image_height: 240
    camera_name: up
    camera_matrix: {rows: 3, cols: 3, data: [200, 0, 159.5, 0, 200, 119.5, 0, 0, 1]}
    distortion_model: plumb_bob
    distortion_coefficients: {rows: 1, cols: 5, data: [0, 0, 0, 0, 0]}
    base_link_to_camera:
      frame: up_optical_frame
      translation: [0, 0, 0.4]
      rotation_xyzw: [0, 0, 0.707106781186548, 0.707106781186548]
)";

/// Files of a report without the folder of figures, which is there where gnuplot is.
inline std::vector<std::string> ReportFilesIn(const std::filesystem::path& report) {
  std::vector<std::string> names = support::NamesIn(report);
  std::erase(names, "figures");
  return names;
}

constexpr int kFrames = 24;
const cv::Size kImageSize(320, 240);
/// Image pixels from frame to frame: 0.06 m to the robot's left, 0.02 m backwards.
const cv::Point kStep(6, 2);

inline std::vector<cv::Mat> CeilingImages() {
  return support::CropAlong(support::SyntheticCeiling({520, 340}), kImageSize, kStep, kFrames);
}

/// The same of a place that is nowhere under that ceiling.
inline std::vector<cv::Mat> ImagesFromElsewhere() {
  std::vector<cv::Mat> images = CeilingImages();
  for (cv::Mat& image : images) {
    cv::Mat mirrored;  // no ceiling matches its mirror image
    cv::flip(image, mirrored, 0);
    image = mirrored;
  }
  return images;
}

/// Arguments of a localization, the poses in `t.tum` (replaced), and more of them.
inline std::vector<std::string> LocalizeArguments(const std::string& map,
                                                  const std::string& rig,
                                                  const std::string& up,
                                                  const std::vector<std::string>& more = {}) {
  std::vector<std::string> arguments{
      "localize", map, "--rig=" + rig, "--up=" + up, "-o", "t.tum", "--force"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

/// A folder with recordings beside an empty one for results, where the program runs.
class Recordings {
 public:
  Recordings() {
    std::filesystem::copy(
        RecordedOnce().Path(), in.Path(), std::filesystem::copy_options::recursive);
  }

  /// Runs ceilmap in the folder `out`; `@NAME` in an argument stands for NAME among the inputs.
  [[nodiscard]] support::ProcessResult Run(std::vector<std::string> arguments) const {
    return support::RunCeilmap(Resolve(std::move(arguments)), out.Path().string());
  }
  [[nodiscard]] std::vector<std::string> Resolve(std::vector<std::string> arguments) const {
    for (std::string& argument : arguments) {
      const std::size_t at = argument.find('@');
      if (at != std::string::npos) argument.replace(at, 1, in.Path().string() + "/");
    }
    return arguments;
  }

  support::TestFolder in;
  support::TestFolder out;

 private:
  /// Encoded once; each test has a copy, which it may change.
  static const support::TestFolder& RecordedOnce() {
    static const support::TestFolder folder;
    static const bool written = [] {
      const std::vector<cv::Mat> images = CeilingImages();
      support::WriteImages(folder / "run", images);
      support::WriteVideo(folder / "run.avi", images, 10);
      folder.Write("rig.yaml", kRig);
      folder.Write("stamps.csv", support::StampsCsv(kFrames, 100, 0.1));
      return true;
    }();
    static_cast<void>(written);
    return folder;
  }
};

}  // namespace ceilmap::integration
