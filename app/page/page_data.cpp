#include "app/page/page_data.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>
#include <string_view>

namespace ceilmap::page {
namespace {

void Require(bool holds, const std::string& what) {
  if (!holds) throw std::invalid_argument("page: " + what);
}

std::string Quoted(const std::string& name) {
  return "'" + name + "'";
}

bool IsFinite(double a, double b, double c = 0) {
  return std::isfinite(a) && std::isfinite(b) && std::isfinite(c);
}

void ValidateMime(const std::string& mime) {
  constexpr std::string_view kKnown[] = {"image/jpeg", "image/png", "image/webp"};
  Require(std::count(std::begin(kKnown), std::end(kKnown), mime) > 0,
          "picture of type " + Quoted(mime) + ", must be image/jpeg, image/png or image/webp");
}

void ValidatePlan(const PagePlan& plan) {
  for (const auto& line : plan.lines) {
    for (const auto& [x, y] : line) Require(IsFinite(x, y), "a point of the plan is not finite");
  }
  if (plan.bytes.empty()) return;
  ValidateMime(plan.mime);
  for (const auto& [x, y] : plan.corners) {
    Require(IsFinite(x, y), "a corner of the plan is not finite");
  }
}

void ValidatePlacement(const Similarity2& S_page_map) {
  const Pose2& motion = S_page_map.motion;
  Require(IsFinite(motion.x, motion.y, motion.yaw) && std::isfinite(S_page_map.scale) &&
              S_page_map.scale > 0,
          "the place of the map on the page is not finite");
}

void ValidatePicture(const PagePicture& picture) {
  if (picture.empty()) return;
  ValidateMime(picture.mime);
  Require(IsFinite(picture.min_x, picture.min_y) && IsFinite(picture.max_x, picture.max_y) &&
              picture.min_x < picture.max_x && picture.min_y < picture.max_y,
          "extent of the picture is empty or not finite");
}

void ValidateHeights(const PageHeights& heights) {
  if (heights.empty()) return;
  Require(heights.columns > 0 && heights.rows > 0 &&
              heights.metres.size() == static_cast<std::size_t>(heights.columns) *
                                           static_cast<std::size_t>(heights.rows),
          "the heights are not as many as the cells of their grid");
  Require(IsFinite(heights.min_x, heights.max_y, heights.cell) && heights.cell > 0,
          "grid of the heights is empty or not finite");
  for (const float metres : heights.metres) {
    Require(!std::isinf(metres), "a height is infinite");
  }
}

void ValidatePose(const PagePose& pose, const std::string& where) {
  const bool none = std::isnan(pose.x) && std::isnan(pose.y) && std::isnan(pose.yaw_rad);
  Require(none || IsFinite(pose.x, pose.y, pose.yaw_rad),
          where + ": x, y and yaw must all be finite, or all NaN where there is no pose");
  const auto& [xx, xy, yy, yaw] = pose.covariance;
  Require(IsFinite(xx, xy, yy) && std::isfinite(yaw) && xx >= 0 && yy >= 0 && yaw >= 0,
          where + ": variances must be finite and not negative");
}

void ValidatePath(const PagePath& path) {
  const std::string where = "path " + Quoted(path.name);
  double last_s = -std::numeric_limits<double>::infinity();
  for (const PagePose& pose : path.poses) {
    Require(std::isfinite(pose.stamp_s) && pose.stamp_s > last_s,
            where + ": stamps must be finite and increase");
    ValidatePose(pose, where);
    last_s = pose.stamp_s;
  }
  Require(path.footprint.empty() || path.footprint.size() >= 3,
          where + ": a footprint has three corners or more");
  for (const auto& [x, y] : path.footprint) {
    Require(IsFinite(x, y), where + ": a corner of the footprint is not finite");
  }
}

void ValidatePaths(const std::vector<PagePath>& paths) {
  std::set<std::string> names;
  for (const PagePath& path : paths) {
    Require(!path.name.empty(), "a path without a name");
    Require(names.insert(path.name).second, "two paths are named " + Quoted(path.name));
    ValidatePath(path);
  }
}

void ValidateGraph(const std::vector<PageKeyframe>& keyframes, const std::vector<PageEdge>& edges) {
  std::set<std::int64_t> ids;
  for (const PageKeyframe& keyframe : keyframes) {
    const std::string where = "keyframe " + std::to_string(keyframe.id);
    Require(ids.insert(keyframe.id).second, where + " is there twice");
    Require(IsFinite(keyframe.x, keyframe.y, keyframe.yaw_rad), where + ": pose is not finite");
  }
  for (const PageEdge& edge : edges) {
    Require(ids.count(edge.from) > 0 && ids.count(edge.to) > 0,
            "edge from keyframe " + std::to_string(edge.from) + " to " + std::to_string(edge.to) +
                ": one of them is not on the page");
  }
}

void ValidateSeries(const PageSeries& series, bool over_time, const std::string& where) {
  Require(series.x.size() == series.y.size(), where + ": x and y differ in length");
  double last = -std::numeric_limits<double>::infinity();
  for (const double x : series.x) {
    Require(std::isfinite(x) && x >= last, where + ": x must be finite and never fall");
    last = x;
  }
  for (const double y : series.y) Require(!std::isinf(y), where + ": y is infinite");
  if (series.stamps_s.empty()) return;
  Require(!over_time, where + ": over time, x are the stamps already");
  Require(series.stamps_s.size() == series.x.size(), where + ": x and stamps differ in length");
  Require(std::all_of(series.stamps_s.begin(),
                      series.stamps_s.end(),
                      [](double stamp_s) { return std::isfinite(stamp_s); }),
          where + ": a stamp is not finite");
}

void ValidateTable(const PageTable& table) {
  for (const std::vector<std::string>& row : table.rows) {
    Require(row.size() == table.columns.size(),
            "table " + Quoted(table.title) + ": a row has " + std::to_string(row.size()) +
                " cells for " + std::to_string(table.columns.size()) + " columns");
  }
}

}  // namespace

void PageData::Validate() const {
  Require(unit == "m" || unit == "px", "unit " + Quoted(unit) + ", must be m or px");
  ValidatePlacement(S_page_map);
  ValidatePlan(plan);
  ValidatePicture(picture);
  ValidatePicture(before);
  ValidateHeights(heights);
  ValidatePaths(paths);
  ValidateGraph(keyframes, edges);
  for (const PageSpot& spot : spots) {
    Require(IsFinite(spot.x, spot.y), "spot " + Quoted(spot.text) + ": place is not finite");
  }
  for (const PageArea& area : areas) {
    for (const auto& ring : area.rings) {
      Require(
          std::all_of(ring.begin(), ring.end(), [](const auto& p) { return IsFinite(p[0], p[1]); }),
          "area " + Quoted(area.text) + ": a point is not finite");
    }
  }
  for (const PageChart& chart : charts) {
    for (const PageSeries& series : chart.series) {
      ValidateSeries(series,
                     chart.over_time,
                     "chart " + Quoted(chart.title) + ", curve " + Quoted(series.name));
    }
  }
  for (const PageTable& table : tables) ValidateTable(table);
}

}  // namespace ceilmap::page
