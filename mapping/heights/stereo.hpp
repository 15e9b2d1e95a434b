#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "mapping/heights/height_field.hpp"

namespace ceilmap::heights {

/// An image prepared for stereo: half the resolution, without the local mean, CV_8UC1.
/// @param grey  CV_8UC1
cv::Mat ForStereo(const cv::Mat& grey);

/// Another image of the same ceiling and size, by the same level camera. A point of inverse height
/// ratio rho moves from x to R(rotation_rad) x + rho * shift_px, relative to the principal point.
struct StereoPartner {
  cv::Mat image;  ///< see ForStereo
  double rotation_rad = 0;
  Eigen::Vector2d shift_px = Eigen::Vector2d::Zero();  ///< not zero
};

/// An image whose heights are measured.
struct StereoReference {
  cv::Mat image;  ///< see ForStereo
  cv::Size size;  ///< of the image as the camera saw it
  cv::Mat mask;   ///< CV_8UC1 of `size`, 0 where the camera saw nothing; empty: it saw everything
  Eigen::Vector2d principal_px = Eigen::Vector2d::Zero();  ///< from the image's centre
};

/// Heights of the points of an image by dense stereo with other images (semi-global matching:
/// Hirschmueller, 2008; cv::StereoSGBM, at half the resolution), refined by least squares. Images
/// of a level camera are rectified by a rotation alone. Blocks measure heights over 32 px, which
/// widens what hangs below the ceiling by up to half a block; this follows its edges to a few
/// pixels.
///
/// @param known  heights of blocks: their range limits the search.
/// @param partners  at least one; those with the reference plane moved by 5 to 25 % of the image
///   are best. A height needs the agreement of two of them where there are more than one.
/// @return a field with cells of kStereoStepPx, kUnknown where nothing was found; the scale's
///   uncertainty is that of `known`.
/// Cost for 640 x 480 px: about 14 ms for each partner. Thread-safe.
HeightField MeasureByStereo(const StereoReference& reference,
                            const std::vector<StereoPartner>& partners,
                            const HeightField& known);

/// Distance of the cells' centres, pixels of the full image.
inline constexpr double kStereoStepPx = 6;

}  // namespace ceilmap::heights
