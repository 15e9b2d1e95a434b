#pragma once

#include <functional>
#include <future>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include "calib/ceiling_view.hpp"
#include "mapping/places/place_descriptor.hpp"
#include "mapping/places/place_index.hpp"
#include "mapping/store/map_file.hpp"

namespace ceilmap::localization {

/// A place of the map of similar appearance to an image.
struct PlaceProposal {
  Pose2 T_map_base;   ///< of the robot; exact to a few percent of the image's span
  double votes = 0;   ///< comparable within one search, > 0
  int keyframes = 0;  ///< that voted for it
  /// Found by a single local descriptor: the position is known roughly, the yaw is unknown.
  bool any_yaw = false;
};

/// Retrieves places of a map that are similar to an image, taken anywhere on the map. Every local
/// descriptor of the image (PlaceDescriber) retrieves similar ones from the whole map. The matches
/// of each keyframe determine the pose of that keyframe relative to the image (PlaceIndex), and the
/// votes of keyframes for the same place are added. On a periodic ceiling many places get about the
/// same number of votes. A single distinctive local descriptor does not determine the yaw, but it
/// determines where to search.
///
/// The index is built from the map's descriptors in a thread of its own, started by the
/// constructor: 2 to 3 ms per keyframe. Find waits for it. A search takes 5 to 10 ms, nearly
/// independent of the map's size.
///
/// Not thread-safe.
class PlaceFinder {
 public:
  /// Keyframes whose places agree within this fraction of an image's span are counted together.
  static constexpr double kSameRatio = 0.1;

  /// @param map  Must outlive the object.
  /// @throws InputError when the view's scale is too far from the map's for comparable descriptors.
  PlaceFinder(const store::MapReader& map, const calib::CeilingView& view);
  ~PlaceFinder();

  /// Sets another view of the same map, e.g. with a corrected scale; the index stays.
  void SetView(const calib::CeilingView& view);

  /// Places in decreasing order of votes; none for an image without local descriptors.
  /// @param image  CV_8UC1, rectified, of the view's size.
  /// @param wanted  Returns false for places that are impossible (another heading, another part of
  ///   the building); may be empty.
  /// @throws InputError when the map's descriptors are damaged.
  [[nodiscard]] std::vector<PlaceProposal> Find(
      const cv::Mat& image, const std::function<bool(const PlaceProposal&)>& wanted = {});

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ceilmap::localization
