#pragma once

#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>
#include <string_view>
#include <vector>

namespace ceilmap::recordings {

/// Format of a camera's images.
enum class RecordingFormat {
  kVideo,          ///< NAME.mp4, H.264 of high quality, a quarter of the size
  kLosslessVideo,  ///< NAME.mkv, FFV1
  kImages          ///< the folder NAME with 000000.png, 000001.png, ...
};

/// Name of a recording in its folder: `up.mp4`, `up.mkv` or `up`.
std::filesystem::path RecordingName(std::string_view camera, RecordingFormat format);

/// Stores the images of one camera. The recording becomes visible with Commit(); without it, the
/// destructor removes all data.
class RecordingWriter {
 public:
  /// An image prepared for Write().
  struct Prepared {
    cv::Mat pixels;
    std::vector<unsigned char> code;
  };

  /// @param target  A RecordingName in an existing folder.
  /// @param rate_hz  Frames per second, for videos. @param is_colour  For all images.
  /// @throws InputError when the folder cannot be written, or a video cannot have the size;
  /// RunError when OpenCV has no encoder.
  static std::unique_ptr<RecordingWriter> Create(RecordingFormat format,
                                                 const std::filesystem::path& target,
                                                 cv::Size size,
                                                 double rate_hz,
                                                 bool is_colour = false);
  virtual ~RecordingWriter() = default;
  RecordingWriter(const RecordingWriter&) = delete;
  RecordingWriter& operator=(const RecordingWriter&) = delete;

  /// The part of the work that needs no order. Thread-safe.
  /// @param pixels  Of the recording's size, CV_8UC1, or in colour CV_8UC3 (blue, green, red).
  [[nodiscard]] virtual Prepared Prepare(cv::Mat pixels) const;
  /// Adds an image at the end. @throws RunError when the disk cannot be written.
  virtual void Write(const Prepared& image) = 0;
  /// Gives the recording its name; an older one is replaced.
  /// @throws RunError when the disk cannot be written.
  virtual void Commit() = 0;

 protected:
  RecordingWriter() = default;
};

}  // namespace ceilmap::recordings
