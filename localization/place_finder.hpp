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

struct PlaceFinderParams {
  int keyframes = 40;  ///< look-alikes of an image that are asked where it is, > 0
  int places = 6;      ///< different places that come out at the most, > 0
  int marks = 3;       ///< further ones of which a single mark looks alike, >= 0
  /// Keyframes that say the same place, to this part of what an image spans ...
  double same_ratio = 0.1;
  double same_rad = 0.15;  ///< ... and this, count together. Both > 0.
  /// Places with less of the best one's votes are left out, [0, 1).
  double min_votes_ratio = 0.25;

  void Validate() const;  ///< throws InputError naming field, value and range
};

/// A place of the map that looks like an image.
struct PlaceProposal {
  Pose2 T_map_base;   ///< of the image's robot; to a few percent of the image's span
  double votes = 0;   ///< comparable within one search, > 0
  int keyframes = 0;  ///< that say so
  /// One mark alone looks alike: the robot is somewhere below it, its yaw is not known.
  bool any_yaw = false;
};

/// Finds places of a map that look like an image, wherever on the map it was taken: every window
/// of the image (PlaceDescriber) finds similar ones all over the map, the look-alikes of each
/// keyframe tell how that keyframe would lie to the image (PlaceIndex), and keyframes that say
/// the same place add up. On a ceiling that repeats itself many places get about as many votes; a
/// single mark on it cannot say how the robot is turned, but where to look.
///
/// The index is built from the map's descriptors in a thread of its own, beginning with the
/// constructor: 2 to 3 ms a keyframe. Find waits for it. A search takes 5 to 10 ms, nearly
/// independent of the map's size.
///
/// Not thread-safe.
class PlaceFinder {
 public:
  /// @param map  must outlive the object. @throws InputError when the view's scale is too
  /// far from the map's for its images to be described alike.
  PlaceFinder(const store::MapReader& map,
              const calib::CeilingView& view,
              const PlaceFinderParams& params = {});
  ~PlaceFinder();

  /// Another view of the same map, e.g. with a corrected scale; the index stays.
  void SetView(const calib::CeilingView& view);

  /// Places with most votes first; none for an image without marks.
  /// @param image  CV_8UC1, rectified, of the view's size.
  /// @throws InputError when the map's descriptors are damaged.
  /// @param wanted  false for places that cannot be (another heading, another part of the
  /// building); may be empty.
  [[nodiscard]] std::vector<PlaceProposal> Find(
      const cv::Mat& image, const std::function<bool(const PlaceProposal&)>& wanted = {});

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ceilmap::localization
