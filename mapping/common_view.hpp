#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "calib/ceiling_view.hpp"
#include "mapping/heights/height_field.hpp"
#include "mapping/store/map_file.hpp"

/// The geometry of the images of maps that are used together.
namespace ceilmap::mapping {

/// A map, and its name in messages.
struct NamedMap {
  const store::MapReader* map = nullptr;
  std::string name;
};

/// The geometry of a map's images.
calib::CeilingView ViewOf(const store::MapMetadata& metadata);

/// Why images of the two maps cannot be used together as they are, as a readable message; empty
/// when they can. Different mountings are allowed; different scales, focal lengths and image sizes
/// are not.
std::string Incompatibility(const store::MapMetadata& a, const store::MapMetadata& b);

/// One geometry for the images of maps that cameras of different size, height and lens made. It has
/// the coarsest scale of the maps and shows, about the centre of the image, what all of them show.
/// Images of all maps are drawn to it, so that they can be registered with each other and stored in
/// one map. Maps with images of one geometry keep them unchanged.
///
/// Drawing to another scale is exact for the plane of the ceiling. What is at another height moves
/// with the camera's distance from that plane: where a map has heights, all cameras must have the
/// same distance. Maps in pixels have no common scale: only images of one geometry go together.
class CommonView {
 public:
  /// @param maps  at least one; the first is the reference. @throws InputError with the names of
  /// two maps that do not go together, and the reason.
  explicit CommonView(const std::vector<NamedMap>& maps);

  /// Metadata of the reference, with the size, scale, mask, focal length and principal point of the
  /// common view, and T_base_view of the reference.
  [[nodiscard]] const store::MapMetadata& Metadata() const { return metadata_; }
  [[nodiscard]] const calib::CeilingView& View() const { return view_; }

  /// True when images with the geometry `from` are used as they are.
  [[nodiscard]] bool Keeps(const store::MapMetadata& from) const;
  /// Draws an image to the common view. The centres of both show the same point.
  /// @param image  CV_8UC1 of from.view_size, 0 exactly where there is no content.
  /// @return the same of Metadata().view_size; `image` itself when it is kept.
  [[nodiscard]] cv::Mat Resample(const cv::Mat& image, const store::MapMetadata& from) const;
  /// The heights of an image as heights of the drawn image.
  [[nodiscard]] heights::HeightField Resample(const heights::HeightField& heights,
                                              const store::MapMetadata& from) const;

 private:
  store::MapMetadata metadata_;
  calib::CeilingView view_;
};

}  // namespace ceilmap::mapping
