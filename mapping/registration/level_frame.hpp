#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "mapping/registration/frame_data.hpp"
#include "mapping/registration/plane_motion.hpp"
#include "mapping/registration/registration.hpp"

/// The levels of an image: copies at other resolutions, on which the stages after the coarse one
/// measure. Internal to the registrar.
namespace ceilmap::registration {

/// One reduced (or enlarged) image of the fine stage and its position in the full one: x_full =
/// factor * x_level + offset, both relative to the images' centres.
struct LevelFrame {
  /// @param full_px_per_level_px  A whole number, or one half.
  LevelFrame(cv::Size full, double full_px_per_level_px);
  [[nodiscard]] ImageMotion FromFull(const ImageMotion& full) const;
  [[nodiscard]] ImageMotion ToFull(const ImageMotion& level) const;
  /// The camera of the level. A plane motion is in units of the plane's distance: it is the same on
  /// every level, only the camera differs.
  [[nodiscard]] PlaneCamera CameraOf(const PlaneCamera& full) const;

  double factor = 1;
  cv::Size size;
  Eigen::Vector2d offset = Eigen::Vector2d::Zero();
};

/// Full pixels per pixel of the fine level (FineStage): a whole number, or one half.
double FineFactor(cv::Size full);
/// Fills the grey levels and the noise of a level. @param full  CV_8UC1. @param factor  as that of
/// LevelFrame. @param size  of the level. @param noise  of the full image.
void FillLevel(
    const cv::Mat& full, double factor, cv::Size size, const ImageNoise& noise, Level& level);
/// A mask at the size of a level: a pixel of the level has content only if all of its full pixels
/// do. Empty for an empty mask.
cv::Mat LevelMask(const cv::Mat& mask, cv::Size size);

/// Side of the blocks of the rough level, its pixels. 0.12 cycles per rough pixel are 0.06 per fine
/// pixel. Motion blur in one of two images inverts the sign of the spectrum above 1/length of the
/// blur, which splits a phase-only peak into two peaks beside the true one. This band is below that
/// limit for blurs up to about ten pixels, and it is the least sensitive to noise.
inline constexpr int kRoughBlockPx = 32;

}  // namespace ceilmap::registration
