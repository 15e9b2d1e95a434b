#pragma once

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <memory>
#include <numbers>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <string>
#include <utility>
#include <vector>

#include "app/files/tum.hpp"
#include "calib/base/degrees.hpp"
#include "tests/support/child_process.hpp"
#include "tests/support/synthetic_recording.hpp"
#include "tests/support/test_folder.hpp"

namespace ceilmap::integration {

/// Coloured patches all around a robot, infinitely far: by azimuth, counter-clockwise from the left
/// edge on, and tangent of the elevation, from the top 2 down to -1.
class PaintedCylinder {
 public:
  PaintedCylinder() : panorama_(kRows, kColumns, CV_8UC3) {
    constexpr std::uint64_t kSeed = 2006;
    cv::RNG random(kSeed);
    for (int u = 0; u < kColumns; u += kPatchColumns) {
      for (int v = 0; v < kRows;) {
        const int height = random.uniform(8, 40);
        const cv::Rect patch =
            cv::Rect(u, v, kPatchColumns, height) & cv::Rect({}, panorama_.size());
        panorama_(patch) =
            cv::Scalar(random.uniform(0, 256), random.uniform(0, 256), random.uniform(0, 256));
        v += height;
      }
    }
    Foresee();
  }

  /// Image of a level robot with this yaw, by the camera of ForwardRig(kRaisedDeg).
  [[nodiscard]] cv::Mat Seen(double yaw_rad) const {
    const double turns = yaw_rad / (2 * std::numbers::pi);
    const cv::Mat map = ahead_ + cv::Scalar(kColumns * (turns - std::floor(turns)));
    cv::Mat image;
    cv::remap(panorama_, image, map, {}, cv::INTER_LINEAR, cv::BORDER_WRAP);
    return image;
  }

  static constexpr double kRaisedDeg = 14;
  static constexpr double kFocalPx = 277.128;  // 60 deg wide
  inline static const cv::Size kSize{320, 240};
  inline static const cv::Point2d kCentre{159.5, 119.5};

 private:
  // Direction of each pixel of a robot of yaw 0.
  void Foresee() {
    const double sine = std::sin(kRaisedDeg * kRadPerDeg);
    const double cosine = std::cos(kRaisedDeg * kRadPerDeg);
    ahead_.create(kSize, CV_32FC2);
    for (int v = 0; v < kSize.height; ++v) {
      for (int u = 0; u < kSize.width; ++u) {
        const double right = (u - kCentre.x) / kFocalPx;
        const double down = (v - kCentre.y) / kFocalPx;
        const double ahead = cosine + sine * down;
        const double tangent = (sine - cosine * down) / std::hypot(ahead, right);
        const double turns = std::atan2(-right, ahead) / (2 * std::numbers::pi);
        const double depth = (kTopTangent - tangent) / (kTopTangent - kBottomTangent);
        ahead_.at<cv::Vec2f>(v, u) = {static_cast<float>(kColumns * turns - 0.5),
                                      static_cast<float>(kRows * depth - 0.5)};
      }
    }
  }

  static constexpr int kColumns = 720;
  static constexpr int kRows = 240;
  static constexpr int kPatchColumns = 18;  // 9 deg
  static constexpr double kTopTangent = 2;
  static constexpr double kBottomTangent = -1;
  cv::Mat panorama_;
  cv::Mat ahead_;  // column and row of the panorama
};

/// A rig whose forward camera is raised from level.
inline std::string ForwardRig(double raised_deg, int width = 320) {
  const double half = 0.5 * (90 + raised_deg) * kRadPerDeg;
  const double a = std::cos(half) / std::sqrt(2.0);
  const double b = std::sin(half) / std::sqrt(2.0);
  return fmt::format(
      "a: 0.0\nd: 0.4\nh: 2.4\ncameras:\n  forward:\n    type: pinhole\n    image_width: {}\n"
      "    image_height: 240\n"
      "    camera_matrix: {{rows: 3, cols: 3, data: [{}, 0, {}, 0, {}, {}, 0, 0, 1]}}\n"
      "    distortion_model: none\n"
      "    base_link_to_camera: {{translation: [0, 0, 0.4], rotation_xyzw: [{:.12f}, {:.12f}, "
      "{:.12f}, {:.12f}]}}\n",
      width,
      PaintedCylinder::kFocalPx,
      PaintedCylinder::kCentre.x,
      PaintedCylinder::kFocalPx,
      PaintedCylinder::kCentre.y,
      -a,
      a,
      -b,
      b);
}

/// Motion JPEG of colour images.
inline void WriteColourVideo(const std::filesystem::path& file,
                             const std::vector<cv::Mat>& images) {
  cv::VideoWriter writer(file.string(),
                         cv::CAP_OPENCV_MJPEG,
                         cv::VideoWriter::fourcc('M', 'J', 'P', 'G'),
                         10,
                         images.front().size(),
                         true);
  writer.set(cv::VIDEOWRITER_PROP_QUALITY, 95);
  for (const cv::Mat& image : images) writer.write(image);
}

/// A robot that turns on the spot, ten frames a second.
struct Turn {
  int frames = 0;
  double first_deg = 0;
  double step_deg = 0;
  double first_s = 0;

  [[nodiscard]] double YawRad(int frame) const {
    return (first_deg + step_deg * frame) * kRadPerDeg;
  }
  [[nodiscard]] double Stamp(int frame) const { return first_s + 0.1 * frame; }

  [[nodiscard]] std::vector<cv::Mat> Images(const PaintedCylinder& world) const {
    std::vector<cv::Mat> images;
    for (int i = 0; i < frames; ++i) images.push_back(world.Seen(YawRad(i)));
    return images;
  }
  /// @param turned_deg  added to every yaw. @param pitch_deg  nose down, from the middle on.
  [[nodiscard]] std::string Poses(double turned_deg = 0, double pitch_deg = 0) const {
    std::vector<StampedPose> poses;
    for (int i = 0; i < frames; ++i) {
      Tilt tilt;
      if (i >= frames / 2) tilt.pitch_rad = pitch_deg * kRadPerDeg;
      const double yaw = WrapAngle(YawRad(i) + turned_deg * kRadPerDeg);
      poses.push_back(ToStampedPose(Stamp(i), {1.0, 0.5, yaw}, tilt));
    }
    return files::FormatTum(poses);
  }
  [[nodiscard]] std::string Stamps() const { return support::StampsCsv(frames, first_s, 0.1); }
};

/// A folder with recordings of turning robots, beside an empty one for results.
class CompassCommand : public testing::Test {
 protected:
  void SetUp() override { std::filesystem::copy(RecordedOnce().Path(), in_.Path()); }

  void Record(const std::string& name, const Turn& turn) const {
    RecordInto(in_, world_, name, turn);
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
    arguments.insert(arguments.begin(), "compass");
    return support::RunCeilmap(Resolve(std::move(arguments)), out_.Path().string());
  }
  /// `WHAT --rig --forward NAME.avi --stamps NAME.csv` and more.
  [[nodiscard]] static std::vector<std::string> Of(const std::vector<std::string>& what,
                                                   const std::string& name,
                                                   const std::vector<std::string>& more) {
    std::vector<std::string> arguments = what;
    for (const char* option : {"--rig=@rig.yaml", "--forward=@{}.avi", "--stamps=@{}.csv"}) {
      arguments.push_back(fmt::format(fmt::runtime(option), name));
    }
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
  /// Learns kLearn into a model, which is replaced. Without more options the model is always the
  /// same: learned once for all tests.
  void Learn(const std::string& model, const std::vector<std::string>& more = {}) const {
    static std::string usual;
    if (more.empty() && !usual.empty()) {
      out_.Write(model, usual);
      return;
    }
    std::vector<std::string> arguments =
        Of({"learn"}, "learn", {"--poses=@learn.tum", "-o", model, "--force"});
    arguments.insert(arguments.end(), more.begin(), more.end());
    const support::ProcessResult result = Run(arguments);
    ASSERT_EQ(result.exit_code, 0) << result.err;
    if (more.empty()) usual = support::ReadAll(out_ / model);
  }

  inline static const Turn kLearn{90, 0, 4, 1000};
  inline static const Turn kAgain{72, 100, 5, 2000};  // another one, begun elsewhere
  PaintedCylinder world_;
  support::TestFolder in_;
  support::TestFolder out_;

 private:
  static void RecordInto(const support::TestFolder& folder,
                         const PaintedCylinder& world,
                         const std::string& name,
                         const Turn& turn) {
    WriteColourVideo(folder / (name + ".avi"), turn.Images(world));
    folder.Write(name + ".csv", turn.Stamps());
    folder.Write(name + ".tum", turn.Poses());
  }
  /// Made once; each test has a copy, which it may change.
  static const support::TestFolder& RecordedOnce() {
    static const support::TestFolder folder;
    static const bool written = [] {
      const PaintedCylinder world;
      RecordInto(folder, world, "learn", kLearn);
      RecordInto(folder, world, "again", kAgain);
      folder.Write("rig.yaml", ForwardRig(PaintedCylinder::kRaisedDeg));
      return true;
    }();
    static_cast<void>(written);
    return folder;
  }
};

}  // namespace ceilmap::integration
