#pragma once

#include <memory>
#include <opencv2/core.hpp>

namespace ceilmap::places {

/// How images are described for place recognition. All images that are to be compared need the
/// same parameters, whatever their cameras: a map is described with one set, its visitors with the
/// same. "px" are pixels of the working image, into which every image is brought first.
struct PlaceDescriptorParams {
  /// Scale of the working image: units of length (metres; pixels without a rig) on the ceiling
  /// per working pixel, > 0. Half the resolution of the map's camera serves well, see ForCamera.
  double units_per_px = 0.01;

  /// Parameters for a map whose images have this size and scale: the working image has a
  /// longer side of 320 px. @throws InputError unless all are > 0.
  static PlaceDescriptorParams ForCamera(cv::Size image, double units_per_px);

  /// @throws InputError with the field, its value and what is allowed.
  void Validate() const;
};

/// Describes a piece of ceiling so that it is recognised at any rotation, when half of it is
/// outside the image, under other light, and by a camera with another height or field of view.
///
/// The image is scaled to a fixed resolution, its large-scale light is removed and values far above
/// the texture (lamps) are limited. Windows are centred on keypoints, the strongest dark or bright
/// spots with a minimum distance from each other: so two images of the same ceiling have windows at
/// the same places even with a small overlap. Each window is sampled on rings around its keypoint
/// and transformed along the angle. A rotation of the image by theta multiplies harmonic m of all
/// rings by the same exp(-i m theta); it cancels in a conj(b) / sqrt(|a b|) of two neighbouring
/// rings. These products and the rings' means form the vector: unlike amplitude spectra (Reddy &
/// Chatterji 1996) it contains the relative rotation of the rings, which is important on weak
/// plaster with noise.
///
/// Contains FFT plans and scratch memory: one object per thread. The result is deterministic on one
/// machine, to the last bit.
class PlaceDescriber {
 public:
  /// Columns of Describe's result.
  static int Dimension();

  /// @param image  size of the images. @param units_per_px  their scale, > 0 (CeilingView::
  /// MetresPerPixel). @param mask  CV_8UC1 of that size, 0 where images have no content
  /// (CeilingView::Mask); empty: content everywhere.
  /// @throws InputError on invalid arguments, or when the working image is too small for a single
  /// window.
  PlaceDescriber(cv::Size image,
                 double units_per_px,
                 const PlaceDescriptorParams& params = {},
                 const cv::Mat& mask = {});
  ~PlaceDescriber();
  PlaceDescriber(PlaceDescriber&&) noexcept;
  PlaceDescriber& operator=(PlaceDescriber&&) noexcept;

  /// One row per window, CV_32FC1 with Dimension() columns: first the window's position (x right, y
  /// down from the image's centre, in lengths of units_per_px), then a vector of length 1. Windows
  /// without texture have no row; a blank image has none at all (an empty matrix with Dimension()
  /// columns).
  /// @param grey  CV_8UC1 of the image's size. @throws InputError on another type or size.
  [[nodiscard]] cv::Mat Describe(const cv::Mat& grey);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ceilmap::places
