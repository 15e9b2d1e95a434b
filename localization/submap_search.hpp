#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "calib/base/pose_with_covariance.hpp"
#include "localization/submap.hpp"
#include "mapping/store/map_file.hpp"

namespace ceilmap::localization {

/// Finds a submap on the map: correlation of the fine structure of both, at all rotations and
/// places. What no single image shows, the ceiling of the last metres may: under plain plaster,
/// with noise, 2 to 3 m of travel were enough where single images matched nothing.
///
/// The score of a place is the correlation there divided by its standard deviation for structure
/// that has nothing in common, of grey values and of directions of edges together. How much it
/// exceeds that of any other place tells whether it is the robot's (SubmapEvidence); a periodic
/// ceiling gives 1.
///
/// A search costs 5 x 90 transforms of the map's size at the submap's resolution (8 pixels of 640
/// across): 0.5 s for a home on two cores, on all cores of the machine. Maps of more than a
/// quarter of a million such pixels (260 m2 for a camera 2 m below the ceiling) are not searched.
class SubmapSearch {
 public:
  /// @param map  Must outlive the object. Its mosaic is read at the first search.
  explicit SubmapSearch(const store::MapReader& map);
  ~SubmapSearch();

  struct Result {
    PoseWithCovariance pose;  ///< of the robot
    double score = 0;         ///< of the submap there ...
    double second = 0;        ///< ... and the largest at any other place or heading

    /// Score of the best place, of the second one's; 1 and more.
    [[nodiscard]] double Lead() const;
  };
  /// @param wanted  Returns false for a yaw on the map that is impossible; may be empty.
  /// @return nothing where the map is too large, or has nothing in common with the submap.
  [[nodiscard]] std::optional<Result> Find(const Submap& submap,
                                           const std::function<bool(double yaw)>& wanted = {});

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ceilmap::localization
