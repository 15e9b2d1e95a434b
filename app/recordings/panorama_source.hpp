#pragma once

#include <CLI/CLI.hpp>
#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/recordings/bag_options.hpp"
#include "app/recordings/frame_source.hpp"
#include "calib/base/tilt.hpp"
#include "calib/mirror_view.hpp"
#include "calib/robot_rig.hpp"

namespace ceilmap::recordings {

/// Options of a command that reads panoramas: their source, and the unwrapping of mirror images.
struct PanoramaOptions {
  std::filesystem::path rig;
  std::string omni;      ///< mirror images
  std::string panorama;  ///< or unwrapped images
  std::filesystem::path stamps;
  BagOptions bags;  ///< added by the command

  std::string ring;  ///< U,V,INNER,OUTER: the mirror, if there is no rig
  std::optional<int> columns;
  std::optional<int> rows;
  std::optional<std::string> interpolation;  ///< nearest or bilinear
  std::optional<std::string> row_spacing;    ///< radius, pixel, elevation or tangent

  std::optional<std::string> azimuth;  ///< of --panorama from left to right: falling or rising
  std::optional<int> front_column;     ///< of --panorama, column of the robot's front

  void AddTo(CLI::App& cli, const std::string& input, const std::string& unwrapping);
  /// Checks everything that can be checked without files. @throws InputError
  void Check() const;
  [[nodiscard]] const std::string& Source() const { return omni.empty() ? panorama : omni; }
};

/// `U,V,INNER,OUTER` in pixels. @throws InputError
calib::MirrorRing ParseRing(const std::string& text, const std::string& option);

/// Converts a panorama to the convention of compass::PanoramaFrame.
/// @param rising  Azimuth of `raw` increases from left to right. @param front_column  Of `raw`, in
/// 0 .. W-1; becomes W/2. @param panorama  Must not share memory with `raw`; its memory is reused.
void OrientPanorama(const cv::Mat& raw, bool rising, int front_column, cv::Mat& panorama);

/// Panoramas of a recording, as for compass::PanoramaFrame, in colour.
class PanoramaSource {
 public:
  /// Opens recording and rig. @throws InputError also when they do not fit each other.
  explicit PanoramaSource(const PanoramaOptions& options);

  /// Tilt of the robot at a time; nothing: it is not known.
  using TiltAt = std::function<std::optional<Tilt>(double stamp_s)>;

  /// Reads the next panorama; its memory is reused by the following one. @return as
  /// FrameSource::Read.
  /// @param tilt_at  A tilt that is known is taken out of the panorama; only for a mirror of known
  /// shape. Null: none is known.
  bool Read(const TiltAt& tilt_at = nullptr);
  [[nodiscard]] const Frame& Raw() const { return frame_; }
  [[nodiscard]] const cv::Mat& Panorama() const { return panorama_; }

  /// Size of the panoramas.
  [[nodiscard]] cv::Size Size() const;
  /// Nothing: there is none, its panoramas have no place on the robot.
  [[nodiscard]] const std::optional<calib::Rig>& Rig() const { return rig_; }
  /// Position of the mirror on the robot, base frame, m; (0, 0) without a rig.
  [[nodiscard]] const Eigen::Vector2d& Position() const { return position_; }
  [[nodiscard]] const FrameSource& Source() const { return source_; }
  [[nodiscard]] double UnwrapMs() const { return unwrap_ms_; }
  /// How the rig's camera was scaled to the recording; nothing: it was not.
  [[nodiscard]] const std::optional<calib::CameraScaling>& Scaling() const { return scaling_; }

 private:
  FrameSource source_;
  std::optional<calib::MirrorView> view_;  // unset if the images are panoramas
  std::optional<calib::Rig> rig_;
  Eigen::Vector2d position_ = Eigen::Vector2d::Zero();
  std::optional<calib::CameraScaling> scaling_;
  bool rising_ = false;
  int front_column_ = 0;
  Frame frame_;
  cv::Mat panorama_;
  double unwrap_ms_ = 0;
};

}  // namespace ceilmap::recordings
