#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/files/hypotheses_csv.hpp"
#include "app/files/tum.hpp"
#include "app/recordings/bag_options.hpp"
#include "app/recordings/frame_source.hpp"
#include "calib/base/tilt.hpp"
#include "calib/rig.hpp"
#include "calib/robot_rig.hpp"
#include "localization/compass/colour/scan_lines.hpp"

namespace ceilmap::recordings {

/// Input options of `compass learn|query|update`.
struct ForwardOptions {
  std::filesystem::path rig;
  std::string forward;
  std::filesystem::path stamps;
  BagOptions bags;

  void AddTo(CLI::App& cli, const std::string& group);
  /// Checks that no result replaces an input.
  /// @throws InputError
  void CheckResult(const std::filesystem::path& result) const;
};

/// The same for any files. @throws InputError
void CheckNotRead(const std::filesystem::path& result,
                  const std::vector<std::filesystem::path>& sources);

/// Options of the scan lines of frames.
void AddLineOptions(CLI::App& cli, colour::ScanLineParams& lines, const std::string& group);

/// Copies the values whose options of AddLineOptions are given on the command line.
void TakeLineOptions(const CLI::App& cli,
                     const colour::ScanLineParams& given,
                     colour::ScanLineParams& lines);

/// The colour images of the rig's forward camera.
class ForwardFrames {
 public:
  /// Opens recording and rig. @throws InputError also when they do not fit each other, or the
  /// camera is pitched up or down too much.
  explicit ForwardFrames(const ForwardOptions& options);

  /// Reads the next frame. @return as FrameSource::Read.
  /// @throws InputError when the images are grey: after 30 images without any colour, or at the end
  /// when none has sufficient colour. Dark images are not counted.
  bool Read();
  [[nodiscard]] const Frame& Current() const { return frame_; }
  /// Number of frames read so far.
  [[nodiscard]] std::int64_t Count() const { return count_; }

  [[nodiscard]] const calib::MountedCamera& Camera() const { return *rig_.forward; }
  /// Distance of the camera ahead of the axle about which the robot turns.
  [[nodiscard]] double AheadOfAxleM() const;
  [[nodiscard]] const FrameSource& Source() const { return source_; }
  /// How the rig's camera was scaled to the recording; nothing: it was not.
  [[nodiscard]] const std::optional<calib::CameraScaling>& Scaling() const { return scaling_; }

 private:
  void CheckColour();
  [[noreturn]] void RefuseGrey() const;

  FrameSource source_;
  calib::Rig rig_;
  std::optional<calib::CameraScaling> scaling_;
  Frame frame_;
  std::int64_t count_ = 0;
  std::int64_t grey_ = 0;  // bright images without colours
  bool has_colour_ = false;
  bool has_some_colour_ = false;  // at least a little colour
};

/// Fraction of the pixels that have a colour: the largest and smallest channel differ by at least
/// 12 grey levels. Encoders cause smaller differences in grey images. @param bgr  CV_8UC3.
double ColouredRatio(const cv::Mat& bgr);

/// Poses of a trajectory by time.
class PosesByTime {
 public:
  static constexpr double kMaxDtS = 0.05;

  /// @throws as ReadTum.
  explicit PosesByTime(const std::filesystem::path& file) : poses_(files::ReadTum(file)) {}

  /// The nearest pose in time, within kMaxDtS; null if there is none.
  [[nodiscard]] const StampedPose* Nearest(double stamp_s) const;

 private:
  std::vector<StampedPose> poses_;
};

/// Position hypotheses by time.
class HypothesesByTime {
 public:
  /// @throws as ReadHypotheses.
  explicit HypothesesByTime(const std::filesystem::path& file)
      : hypotheses_(files::ReadHypotheses(file)) {}

  /// Those nearest in time, within PosesByTime::kMaxDtS; null if there are none.
  [[nodiscard]] const files::StampedHypotheses* Nearest(double stamp_s) const;

 private:
  std::vector<files::StampedHypotheses> hypotheses_;
};

/// Pitch and roll of a pose.
Tilt TiltOf(const StampedPose& pose);

/// Frames of a recording that could not be used.
struct UnusedFrames {
  std::int64_t without_pose = 0;   ///< without a pose at their time
  std::int64_t below_horizon = 0;  ///< with too little of the image above the horizon
};

/// Prints the messages at the end of a run over a recording: its warnings, interruption, scaling of
/// the camera, missing stamps, and unused frames.
void ReportFrames(const ForwardFrames& frames, const UnusedFrames& unused);

/// Throws the error for a run in which no frame could be used.
/// @param poses  The file of poses; empty: none.
/// @throws InputError when the poses are of another time; else RunError.
[[noreturn]] void RefuseRecording(const ForwardFrames& frames,
                                  const UnusedFrames& unused,
                                  const std::filesystem::path& poses);

}  // namespace ceilmap::recordings
