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
/// Every window of the query (PlaceDescriber) votes for the keyframes of the most similar stored
/// windows. The weight of a vote is the similarity relative to the last of them, so that windows
/// that are similar everywhere on the ceiling give no information. Of the keyframes with most
/// votes, those are preferred whose voting windows have the same arrangement as in the query, up to
/// a rotation and a shift. Neighbours are searched in an HNSW graph (Malkov & Yashunin 2020,
/// hnswlib): time grows with the logarithm of the map's size.
///
/// The same additions in the same order give the same results. Search may run in several threads at
/// a time; Add needs exclusive access.
class PlaceIndex {
 public:
  /// @param dimension  Columns of the descriptors (PlaceDescriber::Dimension()): two for the
  /// window's position, the rest for the vector; > 2. @throws InputError otherwise.
  explicit PlaceIndex(int dimension, const PlaceIndexParams& params = {});
  ~PlaceIndex();
  PlaceIndex(PlaceIndex&&) noexcept;
  PlaceIndex& operator=(PlaceIndex&&) noexcept;

  /// Copies the rows.
  /// @param descriptors  CV_32FC1 with `dimension` columns; without rows the keyframe is never
  /// found. @throws InputError on another type or width, on numbers that are not finite, and when
  /// the keyframe was already added.
  void Add(std::int64_t keyframe_id, const cv::Mat& descriptors);

  struct Match {
    std::int64_t keyframe_id = 0;
    double score = 0;  ///< comparable within one query, > 0
    /// Number of windows that correspond under one motion: 0, or at least 2.
    int windows = 0;
    /// That motion: p_stored = T_stored_query * p_query for positions in the two images (x right, y
    /// down from the centre, in lengths of units_per_px), to about tolerance_px. Without such
    /// windows, the position of the stored window with the strongest vote; the yaw is then unknown.
    Pose2 T_stored_query;
  };

  /// Keyframes that may show the same place, best first; equal scores by id. Fewer than `count`
  /// when no more have similar windows.
  /// @param exclude  True for excluded keyframes (e.g. the query's neighbours in time); may be
  /// empty.
  /// @throws InputError on descriptors of another type or width, or count < 1.
  [[nodiscard]] std::vector<Match> Search(
      const cv::Mat& descriptors,
      int count,
      const std::function<bool(std::int64_t)>& exclude = {}) const;

  [[nodiscard]] std::size_t KeyframeCount() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ceilmap::places
