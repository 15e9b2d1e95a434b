#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "samples/simulator/path.hpp"
#include "samples/simulator/random.hpp"
#include "samples/simulator/scene.hpp"

namespace ceilmap::simulator {

/// What the random numbers of a camera are drawn for, so that two cameras have noise of their own.
struct PixelPurposes {
  Purpose gain = Purpose::kPixelGain;
  Purpose noise = Purpose::kPixelNoise;
};

/// Turns light into grey values as Image describes. Thread-safe.
class ImageModel {
 public:
  ImageModel(const Scene& scene, const Camera& camera, PixelPurposes purposes);

  /// @param light  CV_32FC1 of the camera's size, consumed as working memory.
  /// @return CV_8UC1. The noise depends on the scene's seed and frame.index only.
  [[nodiscard]] cv::Mat Develop(cv::Mat& light, const Frame& frame) const;

  /// Exposure of a frame: gain, drift and steps.
  [[nodiscard]] double Gain(const Frame& frame) const;

 private:
  void AddGlare(cv::Mat& light) const;
  [[nodiscard]] cv::Mat Expose(const cv::Mat& light, float gain, std::int64_t index) const;

  Image image_;
  double start_stamp_s_;
  std::uint64_t noise_key_;
  cv::Mat sensitivity_;              // CV_32FC1: vignetting times the pixels' own gain
  std::vector<float> normal_;        // random numbers of deviation 1
  std::vector<float> noise_;         // deviation of the noise by light
  std::vector<std::uint8_t> curve_;  // grey value by light
};

/// The image of a camera whose colours have noise of their own: CV_8U.
/// @param planes  one of each channel of the light. @param light  CV_32F.
cv::Mat DevelopPlanes(std::span<const ImageModel> planes, const cv::Mat& light, const Frame& frame);

}  // namespace ceilmap::simulator
