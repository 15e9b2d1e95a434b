#include "app/page/plan_picture.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "app/page/picture_encoding.hpp"

namespace ceilmap::page {
namespace {

using Line = std::vector<std::array<double, 2>>;

/// Of a picture at its present size.
std::array<std::array<double, 2>, 3> Corners(const store::SitePlan& plan) {
  const auto at = [&t = plan.transform](double col, double row) {
    return std::array{t[0] + t[1] * col + t[2] * row, t[3] + t[4] * col + t[5] * row};
  };
  return {at(0, 0), at(plan.image.cols, 0), at(0, plan.image.rows)};
}

/// A line with few points that is nowhere farther away (Douglas and Peucker); empty where all of it
/// is in one place. Coordinates of a site have more digits than a float: differences have not.
Line Simplified(const std::vector<Eigen::Vector2d>& line, double tolerance) {
  std::vector<cv::Point2f> relative;
  relative.reserve(line.size());
  for (const Eigen::Vector2d& point : line) {
    const Eigen::Vector2d p = point - line.front();
    relative.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()));
  }
  const auto near_first = [&](const cv::Point2f& p) {
    return std::max(std::abs(p.x), std::abs(p.y)) <= tolerance;
  };
  if (std::all_of(relative.begin(), relative.end(), near_first)) return {};
  std::vector<cv::Point2f> kept;
  cv::approxPolyDP(relative, kept, tolerance, false);
  // Where a line ends at its begin, OpenCV leaves the second of the two points out.
  if (relative.front() == relative.back()) kept.push_back(kept.front());
  Line result;
  result.reserve(kept.size());
  for (const cv::Point2f& p : kept) {
    result.push_back(
        {line.front().x() + static_cast<double>(p.x), line.front().y() + static_cast<double>(p.y)});
  }
  return result;
}

/// Drawings of other programs may hold what is no number.
std::vector<Eigen::Vector2d> FinitePoints(const std::vector<Eigen::Vector2d>& line) {
  std::vector<Eigen::Vector2d> finite;
  finite.reserve(line.size());
  std::copy_if(line.begin(), line.end(), std::back_inserter(finite), [](const auto& point) {
    return point.allFinite();
  });
  return finite;
}

std::vector<Line> LinesOf(const store::SitePlan& plan, std::size_t max_points) {
  constexpr double kFinestM = 1e-3;
  for (double tolerance = kFinestM;; tolerance *= 2) {
    std::vector<Line> lines;
    lines.reserve(plan.lines.size());
    std::size_t points = 0;
    for (const std::vector<Eigen::Vector2d>& drawn : plan.lines) {
      const std::vector<Eigen::Vector2d> line = FinitePoints(drawn);
      if (line.size() < 2) continue;
      Line simple = Simplified(line, tolerance);
      points += simple.size();
      if (!simple.empty()) lines.push_back(std::move(simple));
    }
    if (points <= max_points) return lines;
  }
}

}  // namespace

PagePlan MakePlan(const store::SitePlan& plan, std::size_t max_bytes, std::size_t max_points) {
  PagePlan made;
  made.lines = LinesOf(plan, max_points);
  if (plan.image.empty()) return made;
  made.corners = Corners(plan);
  cv::Mat reduced = plan.image;
  const auto halve = [&reduced] {
    const cv::Size half(std::max(1, reduced.cols / 2), std::max(1, reduced.rows / 2));
    cv::Mat smaller;
    cv::resize(reduced, smaller, half, 0, 0, cv::INTER_AREA);
    reduced = smaller;
  };
  EncodedPicture encoded =
      EncodeWithin([&] { return reduced; }, halve, {kLossless, 85, 60, 30}, max_bytes);
  made.mime = std::move(encoded.mime);
  made.bytes = std::move(encoded.bytes);
  return made;
}

}  // namespace ceilmap::page
