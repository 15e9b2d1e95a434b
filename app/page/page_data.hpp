#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "mapping/graph/keyframe.hpp"

/// The page to look at: a map, the robots on it, and their figures, in one HTML file. What is on it
/// is said here; how it looks is in page.html, page.css and page.js.
namespace ceilmap::page {

/// A pose of a path. A frame without one has NaN for x, y and yaw, and its status tells why.
struct PagePose {
  double stamp_s = 0;
  double x = 0;  ///< in the page's frame, in its unit
  double y = 0;
  double yaw_rad = 0;
  graph::TrackingStatus status = graph::TrackingStatus::kTracking;
  /// Variance of x, covariance of x and y, variance of y, variance of yaw (rad^2); all 0 where
  /// nothing is known of them.
  std::array<double, 4> covariance{};
};

/// What a path is, which decides how it is drawn.
enum class PathRole {
  kTruth,   ///< a line under the others
  kRun,     ///< a coloured line with the robot on it
  kBefore,  ///< the same without tilt compensation: thin and dashed
};

/// A trajectory.
struct PagePath {
  std::string name;  ///< unique on the page
  PathRole role = PathRole::kRun;
  std::vector<PagePose> poses;  ///< stamps increase
  /// What the upward camera sees of the ceiling, corners in the robot's frame (base), in order
  /// around it; empty: nothing is drawn.
  std::vector<std::array<double, 2>> footprint;
};

struct PageKeyframe {
  std::int64_t id = 0;
  double x = 0;
  double y = 0;
  double yaw_rad = 0;
};

/// A measurement between two keyframes.
struct PageEdge {
  std::int64_t from = 0;  ///< ids of keyframes on the page
  std::int64_t to = 0;
  bool loop = false;  ///< the robot came back here; else: the way from one to the next
};

/// A place where the map deserves less trust.
struct PageSpot {
  std::string text;
  double x = 0;
  double y = 0;
};

/// A picture under the paths.
struct PagePicture {
  std::string mime;  ///< "image/jpeg", "image/png" or "image/webp"
  std::vector<unsigned char> bytes;
  double min_x = 0;  ///< extent in the page's frame: left edge of the leftmost pixels ...
  double min_y = 0;
  double max_x = 0;
  double max_y = 0;

  [[nodiscard]] bool empty() const { return bytes.empty(); }
};

/// A curve of a chart. Values that are not known are NaN: the line breaks there.
struct PageSeries {
  std::string name;              ///< as in PagePath::name where it belongs to one: same colour
  std::vector<double> x;         ///< never falls
  std::vector<double> y;         ///< as long as `x`
  std::vector<double> stamps_s;  ///< time of each point, for charts not over time; else empty
};

struct PageChart {
  std::string title;
  std::string x_label;  ///< with its unit, e.g. "time (s)"
  std::string y_label;
  bool over_time = true;  ///< x are stamps, shown from the page's first stamp on
  std::vector<PageSeries> series;
};

struct PageTable {
  std::string title;
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;  ///< each as long as `columns`
};

/// Everything on a page. All positions are in one frame, REP 103: x right, y up on the page.
struct PageData {
  std::string title;
  std::string note;        ///< a line under the title, e.g. what the page was made from
  std::string unit = "m";  ///< of lengths, "m" or "px"
  PagePicture picture;
  std::vector<PagePath> paths;
  std::vector<PageKeyframe> keyframes;
  std::vector<PageEdge> edges;
  std::vector<PageSpot> spots;
  std::vector<PageChart> charts;
  std::vector<PageTable> tables;

  /// @throws std::invalid_argument where anything said above does not hold.
  void Validate() const;
};

}  // namespace ceilmap::page
