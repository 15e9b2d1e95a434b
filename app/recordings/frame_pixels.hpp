#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <string>

#include "app/recordings/images.hpp"

struct AVFrame;
struct SwsContext;

namespace ceilmap::recordings {

/// How stored images are turned and mirrored for display: first transposed (rows become columns),
/// then mirrored.
struct Orientation {
  bool transposed = false;
  bool mirrored_x = false;  ///< left and right exchanged
  bool mirrored_y = false;  ///< top and bottom exchanged

  bool operator==(const Orientation&) const = default;
};

/// The orientation of a display matrix (FFmpeg's libavutil/display.h). Its scale is ignored, and a
/// matrix of zeros is the identity.
/// @return nothing unless the matrix consists of quarter turns and reflections.
std::optional<Orientation> OrientationOf(std::span<const std::int32_t, 9> matrix);

/// Geometry of a frame for display.
struct FrameGeometry {
  /// Width of a stored sample relative to its height, > 0.
  double sample_aspect = 1;
  Orientation orientation = {};
};

/// Size of a frame's image: the stored width times the sample aspect, then turned.
cv::Size DisplaySize(cv::Size stored, const FrameGeometry& geometry);

/// Converts decoded frames to images as players show them: turned upright, with square pixels, and
/// with grey levels and colours of full range.
///
/// Grey images are the luma of the video, whatever its subsampling: 8 bits as they are, more bits
/// rounded to 8, limited range expanded to 0 to 255. Videos with RGB or palettes are converted as
/// image files are (ConvertTo). A frame of 8 bits luma that needs no change is copied once.
class FramePixels {
 public:
  /// @param name  of the video, for messages.
  FramePixels(std::string name, Pixels pixels);
  ~FramePixels();

  /// @param image  its memory is reused. @throws InputError when the pixel format is not supported
  /// or the image would be too large.
  void Convert(const AVFrame& frame, const FrameGeometry& geometry, cv::Mat& image);

 private:
  // For the luma of one pixel format.
  struct Levels {
    int depth = 0;
    bool full_range = false;
    cv::Mat table;  // CV_8UC1, one row
  };

  void ReadStored(const AVFrame& frame, cv::Mat& image);
  bool ReadLuma(const AVFrame& frame, cv::Mat& grey);
  void ReadColour(const AVFrame& frame, cv::Mat& bgr);
  const cv::Mat& GreyLevels(int depth, bool full_range);

  std::string name_;
  Pixels pixels_;
  Levels levels_;
  struct Release {
    void operator()(SwsContext* scaler) const;
  };
  std::unique_ptr<SwsContext, Release> scaler_;
  cv::Mat padded_;
  cv::Mat stored_;
  cv::Mat square_;
};

}  // namespace ceilmap::recordings
