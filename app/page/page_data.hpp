#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "calib/base/similarity2.hpp"
#include "mapping/graph/keyframe.hpp"

/// Data of the page of a report: a map, the robots on it, and charts, in one HTML file. The layout
/// is defined in page.html, page.css and page.js.
namespace ceilmap::page {

/// A pose of a path. A frame without a pose has NaN for x, y and yaw; its status gives the reason.
struct PagePose {
  double stamp_s = 0;
  double x = 0;  ///< in the page's frame, in its unit
  double y = 0;
  double yaw_rad = 0;
  graph::TrackingStatus status = graph::TrackingStatus::kTracking;
  /// Variance of x, covariance of x and y, variance of y, variance of yaw (rad^2); all 0 if
  /// unknown.
  std::array<double, 4> covariance{};
};

/// Type of a path, which determines how it is drawn.
enum class PathRole {
  kTruth,   ///< a line below the others
  kRun,     ///< a coloured line with the robot
  kBefore,  ///< the same without tilt compensation: thin and dashed
};

/// A trajectory.
struct PagePath {
  std::string name;  ///< unique on the page
  PathRole role = PathRole::kRun;
  std::vector<PagePose> poses;  ///< stamps increase
  /// Outline of the ceiling in the upward camera's image, in the robot's frame (base), in order;
  /// empty: not drawn.
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
  bool loop = false;  ///< true: loop closure; false: between consecutive keyframes
};

/// A place where the map is less reliable.
struct PageSpot {
  std::string text;
  double x = 0;
  double y = 0;
};

/// A picture below the paths, in the map's frame.
struct PagePicture {
  std::string mime;  ///< "image/jpeg", "image/png" or "image/webp"
  std::vector<unsigned char> bytes;
  double min_x = 0;  ///< extent in the map's frame: left edge of the leftmost pixels ...
  double min_y = 0;
  double max_x = 0;
  double max_y = 0;

  [[nodiscard]] bool empty() const { return bytes.empty(); }
};

/// A part of the ceiling, outlined over the picture.
struct PageArea {
  std::string text;
  std::vector<std::vector<std::array<double, 2>>> rings;  ///< of polygons with holes, even-odd
};

/// The floor plan of the building: a picture or lines, below all else.
struct PagePlan {
  std::string mime;  ///< as PagePicture
  std::vector<unsigned char> bytes;
  /// Upper left, upper right and lower left corner of the picture, in the page's frame.
  std::array<std::array<double, 2>, 3> corners{};
  std::vector<std::vector<std::array<double, 2>>> lines;  ///< of a drawing, in the page's frame

  [[nodiscard]] bool empty() const { return bytes.empty() && lines.empty(); }
};

/// Heights of the ceiling above the floor, on a grid of square cells over the map.
struct PageHeights {
  int columns = 0;
  int rows = 0;
  double min_x = 0;           ///< left edge of the first column, in the map's frame
  double max_y = 0;           ///< upper edge of the first row
  double cell = 0;            ///< side of a cell, > 0
  std::vector<float> metres;  ///< row by row, columns * rows; NaN where not known

  [[nodiscard]] bool empty() const { return metres.empty(); }
};

/// A curve of a chart. Unknown values are NaN: the line is interrupted there.
struct PageSeries {
  std::string name;              ///< as PagePath::name if it belongs to a path: same colour
  std::vector<double> x;         ///< never decreasing
  std::vector<double> y;         ///< as long as `x`
  std::vector<double> stamps_s;  ///< time of each point, for charts not over time; else empty
};

struct PageChart {
  std::string title;
  std::string x_label;  ///< with its unit, e.g. "time (s)"
  std::string y_label;
  bool over_time = true;  ///< x are stamps, shown relative to the page's first stamp
  std::vector<PageSeries> series;
};

struct PageTable {
  std::string title;
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;  ///< each as long as `columns`
};

/// Everything on a page. Positions are in the page's frame, REP 103: x right, y up on the page;
/// only `picture` and heights are in the map's frame, because their pixels stay as they are.
struct PageData {
  std::string title;
  std::string note;        ///< a line below the title, e.g. the source of the page
  std::string unit = "m";  ///< of lengths, "m" or "px"
  /// The map in the page's frame: p_page = S_page_map * p_map. Another one than the map's where the
  /// page has the coordinates of the building.
  Similarity2 S_page_map;
  PagePlan plan;
  PagePicture picture;
  /// How the ceiling looked before, in the page's frame: shown left of a divider that the user
  /// moves.
  PagePicture before;
  PageHeights heights;
  std::vector<PagePath> paths;
  std::vector<PageKeyframe> keyframes;
  std::vector<PageEdge> edges;
  std::vector<PageSpot> spots;
  std::vector<PageArea> areas;
  std::vector<PageChart> charts;
  std::vector<PageTable> tables;

  /// @throws std::invalid_argument when a condition above is not met.
  void Validate() const;
};

}  // namespace ceilmap::page
