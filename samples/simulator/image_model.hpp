#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "samples/simulator/path.hpp"
#include "samples/simulator/random.hpp"
#include "samples/simulator/scene.hpp"

namespace ceilmap::simulator {

/// Purpose of a camera's random numbers, so that two cameras have independent noise; and the colour
/// of its pixels.
struct PixelPurposes {
  Purpose gain = Purpose::kPixelGain;
  Purpose noise = Purpose::kPixelNoise;
  int warmth = 0;  ///< -1: blue, 0: green or grey, 1: red
};

/// Converts light to grey values as described in Image. Thread-safe.
class ImageModel {
 public:
  ImageModel(const Scene& scene, const Camera& camera, PixelPurposes purposes);

  /// @param light  CV_32FC1 of the camera's size, used as working memory.
  /// @return CV_8UC1. The noise depends only on the scene's seed and frame.index.
  [[nodiscard]] cv::Mat Develop(cv::Mat& light, const Frame& frame) const;

  /// Exposure factor of a frame: gain, drift, steps and automatic exposure; and white balance. 0 in
  /// the dark.
  [[nodiscard]] double Gain(const Frame& frame) const;

  /// Light of the lamps in an image row, relative to its mean over time.
  [[nodiscard]] double Flicker(const Frame& frame, int row) const;

 private:
  void AddGlare(cv::Mat& light) const;
  [[nodiscard]] cv::Mat Expose(const cv::Mat& light, const Frame& frame) const;

  Image image_;
  double start_stamp_s_;
  double scene_start_s_;  // of the dark times
  double phase_;          // of the exposure's slow sine, in turns, by the session
  double exposure_time_s_;
  double readout_time_s_;
  int warmth_;
  std::uint64_t noise_key_;
  cv::Mat sensitivity_;              // CV_32FC1: vignetting times the gain of each pixel
  std::vector<float> normal_;        // random numbers of standard deviation 1
  std::vector<float> noise_;         // standard deviation of the noise, by light
  std::vector<std::uint8_t> curve_;  // grey value, by light
};

/// The image of a camera with independent noise per colour: CV_8U.
/// @param planes  One for each channel of the light. @param light  CV_32F.
cv::Mat DevelopPlanes(std::span<const ImageModel> planes, const cv::Mat& light, const Frame& frame);

}  // namespace ceilmap::simulator
