#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include "calib/base/pose2.hpp"

namespace ceilmap::places {

struct PlaceIndexParams {
  int neighbours = 32;     ///< stored windows that a window of the query may vote for, [2, 1024]
  int build_effort = 48;   ///< HNSW: candidates while a window is linked, [16, 1024]
  int search_effort = 64;  ///< HNSW: candidates while searching, [16, 4096]

  /// @throws InputError with the field, its value and what is allowed.
  void Validate() const;
};

/// Finds keyframes that may show the same piece of ceiling as a query.
///
/// Every window of the query (PlaceDescriber) asks for the most similar stored windows and votes
/// for their keyframes, the more the more similar they are than the last of them: windows that
/// look alike all over the ceiling say nothing. Of the keyframes with most votes those are
/// preferred whose voting windows lie in the query as they lie in the keyframe, up to a rotation
/// and a shift. Neighbours are looked up in an HNSW graph (Malkov & Yashunin 2020, hnswlib): time
/// grows with the logarithm of the map.
///
/// Same additions in the same order, same answers. Search may run in several threads at a time; Add
/// needs the index for itself.
class PlaceIndex {
 public:
  /// @param dimension  columns of the descriptors (PlaceDescriber::Dimension()): two for the
  /// window's place, the rest the vector; > 2. @throws InputError otherwise.
  explicit PlaceIndex(int dimension, const PlaceIndexParams& params = {});
  ~PlaceIndex();
  PlaceIndex(PlaceIndex&&) noexcept;
  PlaceIndex& operator=(PlaceIndex&&) noexcept;

  /// Takes a copy of the rows.
  /// @param descriptors  CV_32FC1 with `dimension` columns; no rows: the keyframe will never be
  /// found. @throws InputError on another type or width, on numbers that are not finite, and
  /// when the keyframe is known already.
  void Add(std::int64_t keyframe_id, const cv::Mat& descriptors);

  struct Match {
    std::int64_t keyframe_id = 0;
    double score = 0;  ///< comparable within one query, > 0
    /// Windows that lie in both images alike, under one motion: 0, or at least 2.
    int windows = 0;
    /// That motion: p_stored = T_stored_query * p_query for places in the two images (x right,
    /// y down from the centre, in lengths of units_per_px), to about tolerance_px. Without such
    /// windows the place of the stored window with the strongest vote, the yaw being unknown.
    Pose2 T_stored_query;
  };

  /// Keyframes that may show the same place, best first; equal scores by id. Fewer than `count`
  /// when no more have anything in common with the query.
  /// @param exclude  true for keyframes that are not wanted (e.g. the query's neighbours in time);
  /// may be empty.
  /// @throws InputError on descriptors of another type or width, or count < 1.
  [[nodiscard]] std::vector<Match> Search(
      const cv::Mat& descriptors,
      int count,
      const std::function<bool(std::int64_t)>& exclude = {}) const;

  [[nodiscard]] std::size_t KeyframeCount() const;
  [[nodiscard]] std::size_t WindowCount() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ceilmap::places
