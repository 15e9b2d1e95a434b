#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/files/tum.hpp"
#include "app/recordings/frame_source.hpp"
#include "calib/base/tilt.hpp"
#include "calib/rig.hpp"
#include "localization/compass/colour/scan_lines.hpp"

namespace ceilmap::recordings {

/// Where the images of `compass learn|query|update` come from.
struct ForwardOptions {
  std::filesystem::path rig;
  std::string forward;
  std::filesystem::path stamps;

  void AddTo(CLI::App& cli, const std::string& group);
  /// That no result would take the place of what is read.
  /// @throws InputError
  void CheckResult(const std::filesystem::path& result) const;
};

/// The same for any files. @throws InputError
void CheckNotRead(const std::filesystem::path& result,
                  const std::vector<std::filesystem::path>& sources);

/// Options for the scan lines of frames.
void AddLineOptions(CLI::App& cli, colour::ScanLineParams& lines, const std::string& group);

/// Copies the values whose options of AddLineOptions are given on the command line.
void TakeLineOptions(const CLI::App& cli,
                     const colour::ScanLineParams& given,
                     colour::ScanLineParams& lines);

/// The colour images of the rig's forward camera.
class ForwardFrames {
 public:
  /// Opens recording and rig. @throws InputError also when the two do not fit, or the camera
  ///   looks up or down too much.
  explicit ForwardFrames(const ForwardOptions& options);

  /// The next one. @return as FrameSource::Read.
  /// @throws InputError when the images turn out to be grey: after 30 without a trace of
  ///   colour, and at the end where none has colours to speak of. Dark ones tell nothing.
  bool Read();
  [[nodiscard]] const Frame& Current() const { return frame_; }
  /// Read so far.
  [[nodiscard]] std::int64_t Count() const { return count_; }

  [[nodiscard]] const calib::MountedCamera& Camera() const { return *rig_.forward; }
  /// Of the camera, from the axle that the robot turns about: turns move it by that.
  [[nodiscard]] double AheadOfAxleM() const;
  [[nodiscard]] const FrameSource& Source() const { return source_; }

 private:
  void CheckColour();
  [[noreturn]] void RefuseGrey() const;

  FrameSource source_;
  calib::Rig rig_;
  Frame frame_;
  std::int64_t count_ = 0;
  std::int64_t grey_ = 0;  // bright, but without colours
  bool colour_seen_ = false;
  bool wall_seen_ = false;  // some colour, if not much
};

/// Part of the pixels that have a colour: whose brightest and darkest channels differ by 12 grey
/// levels. Encoders leave less than that on grey images. @param bgr  CV_8UC3.
double ColouredPart(const cv::Mat& bgr);

/// Poses of a trajectory by time.
class PosesByTime {
 public:
  static constexpr double kMaxDtS = 0.05;

  /// @throws as ReadTum.
  explicit PosesByTime(const std::filesystem::path& file) : poses_(files::ReadTum(file)) {}

  /// The nearest in time, not farther than kMaxDtS; null where there is none.
  [[nodiscard]] const StampedPose* Nearest(double stamp_s) const;

 private:
  std::vector<StampedPose> poses_;
};

/// Pitch and roll of a pose.
Tilt TiltOf(const StampedPose& pose);

/// Frames that a run over a recording could not use.
struct UnusedFrames {
  std::int64_t without_pose = 0;   ///< no pose at their time
  std::int64_t below_horizon = 0;  ///< too little of the image above it
};

/// What every run over a recording tells at its end: the recording's warnings, interruption,
/// missing stamps, and frames that were not used.
void ReportFrames(const ForwardFrames& frames, const UnusedFrames& unused);

/// When not one frame could be used.
/// @param poses  the file of poses; empty: there is none.
/// @throws InputError when the poses are of another time; else RunError.
[[noreturn]] void RefuseRecording(const ForwardFrames& frames,
                                  const UnusedFrames& unused,
                                  const std::filesystem::path& poses);

}  // namespace ceilmap::recordings
