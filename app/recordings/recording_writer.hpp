#pragma once

#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>
#include <string_view>
#include <vector>

namespace ceilmap::recordings {

/// How a camera's images are stored.
enum class RecordingFormat {
  kVideo,          ///< NAME.mp4, H.264 of high quality, a quarter of the size
  kLosslessVideo,  ///< NAME.mkv, FFV1
  kImages          ///< the folder NAME with 000000.png, 000001.png, ...
};

/// What a recording is called in its folder: `up.mp4`, `up.mkv` or `up`.
std::filesystem::path RecordingName(std::string_view camera, RecordingFormat format);

/// Stores the images of one camera. Nothing stands under the recording's name until Commit();
/// without it the destructor removes all that was written.
class RecordingWriter {
 public:
  /// An image made ready for Write().
  struct Prepared {
    cv::Mat pixels;
    std::vector<unsigned char> code;
  };

  /// @param target  as RecordingName says, in a folder that exists.
  /// @param rate_hz  frames per second, for videos. @param is_colour  of all images.
  /// @throws InputError when the folder takes no files, or a video cannot have the size;
  ///   RunError when OpenCV has no encoder.
  static std::unique_ptr<RecordingWriter> Create(RecordingFormat format,
                                                 const std::filesystem::path& target,
                                                 cv::Size size,
                                                 double rate_hz,
                                                 bool is_colour = false);
  virtual ~RecordingWriter() = default;
  RecordingWriter(const RecordingWriter&) = delete;
  RecordingWriter& operator=(const RecordingWriter&) = delete;

  /// The part of the work that needs no order. Thread-safe.
  /// @param pixels  of the recording's size, CV_8UC1, or with colours CV_8UC3 (blue, green, red).
  [[nodiscard]] virtual Prepared Prepare(cv::Mat pixels) const;
  /// Adds an image at the end. @throws RunError when the disk refuses.
  virtual void Write(const Prepared& image) = 0;
  /// Gives the recording its name, with what was written so far; an older one is replaced.
  /// @throws RunError when the disk refuses.
  virtual void Commit() = 0;

 protected:
  RecordingWriter() = default;
};

}  // namespace ceilmap::recordings
