#pragma once

#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "app/recordings/sensor_stream.hpp"
#include "localization/robot/camera_stream.hpp"

namespace ceilmap::recordings {

/// Problems of matching a camera's recording with the upward frames, one line each.
/// @param source  The recording. @param camera  Name of the camera.
std::vector<std::string> MatchWarnings(const std::string& source,
                                       const std::string& camera,
                                       const robot::StreamReport& matches);

/// The images of a second camera that belong to those of the first, matched by time. It may have
/// another frame rate, begin later and end earlier.
class SynchronizedStream {
 public:
  struct Report {
    robot::StreamReport matches;
    FrameSourceReport reading;
  };

  /// @param stamps, bag  see SensorStream. @throws InputError when the source cannot be used.
  SynchronizedStream(const std::string& source,
                     const std::filesystem::path& stamps,
                     const BagTopic& bag = {});

  [[nodiscard]] cv::Size Size() const { return stream_.Size(); }
  [[nodiscard]] const std::string& Name() const { return stream_.Name(); }

  /// The image nearest in time, within 50 ms; empty if there is none. Stamps must not decrease.
  cv::Mat At(double stamp_s);

  [[nodiscard]] Report GetReport() const { return {images_.Report(), stream_.Reading()}; }
  /// Problems, one line each; complete at the end of the first recording.
  [[nodiscard]] std::vector<std::string> Warnings() const;

 private:
  SensorStream stream_;
  robot::CameraStream images_;
};

}  // namespace ceilmap::recordings
