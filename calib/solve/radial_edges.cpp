#include "calib/solve/radial_edges.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <opencv2/imgproc.hpp>

namespace ceilmap::calibration {
namespace {

using Eigen::Vector2d;

Vector2d Direction(int index, int count) {
  const double angle = 2 * std::numbers::pi * index / count;
  return {std::cos(angle), std::sin(angle)};
}

// Bilinear; nothing outside.
std::optional<double> Sample(const cv::Mat& map, const Vector2d& at) {
  const int u = static_cast<int>(std::floor(at.x()));
  const int v = static_cast<int>(std::floor(at.y()));
  if (u < 0 || v < 0 || u + 1 >= map.cols || v + 1 >= map.rows) return std::nullopt;
  const double x = at.x() - u;
  const double y = at.y() - v;
  const auto* top = map.ptr<float>(v) + u;
  const auto* low = map.ptr<float>(v + 1) + u;
  return (1 - y) * ((1 - x) * top[0] + x * top[1]) + y * ((1 - x) * low[0] + x * low[1]);
}

// A map along a ray, from `begin` on in steps.
struct Profile {
  double begin = 0;
  double step = 0.25;
  std::vector<double> values;

  [[nodiscard]] double RadiusAt(double index) const { return begin + step * index; }
  [[nodiscard]] double Median(double from, double to) const {
    const auto index = [&](double r) {
      const double i = (r - begin) / step;
      return static_cast<std::ptrdiff_t>(
          std::clamp(i, 0.0, static_cast<double>(values.size() - 1)));
    };
    std::vector<double> segment(values.begin() + index(from), values.begin() + index(to) + 1);
    const auto middle = segment.begin() + static_cast<std::ptrdiff_t>(segment.size() / 2);
    std::nth_element(segment.begin(), middle, segment.end());
    return *middle;
  }
};

Profile Along(
    const cv::Mat& map, const Vector2d& from, const Vector2d& out, double begin, double end) {
  Profile profile;
  profile.begin = begin;
  const int steps = static_cast<int>((end - begin) / profile.step);
  for (int i = 0; i <= steps; ++i) {
    const auto value = Sample(map, from + profile.RadiusAt(i) * out);
    if (!value) break;
    profile.values.push_back(*value);
  }
  return profile;
}

// Last position where the profile falls below a level.
std::optional<double> LastFall(const Profile& profile, double level) {
  for (std::size_t i = profile.values.size(); i-- > 1;) {
    const double inner = profile.values[i - 1];
    const double outer = profile.values[i];
    if (inner < level || outer >= level) continue;
    return profile.RadiusAt(static_cast<double>(i - 1) + (inner - level) / (inner - outer));
  }
  return std::nullopt;
}

}  // namespace

std::vector<Vector2d> FallingEdges(const cv::Mat& map, const Circle& circle, double reach_px) {
  constexpr double kBeside = 0.4;  // relative to the reach: nearer samples belong to the edge
  std::vector<Vector2d> points;
  for (int k = 0; k < kEdgeDirections; ++k) {
    const Vector2d out = Direction(k, kEdgeDirections);
    const double r = circle.radius;
    const Profile profile = Along(map, circle.centre, out, r - reach_px, r + reach_px);
    if (profile.RadiusAt(static_cast<double>(profile.values.size())) < r + 0.8 * reach_px) continue;
    const double inside = profile.Median(r - reach_px, r - kBeside * reach_px);
    const double outside = profile.Median(r + kBeside * reach_px, r + reach_px);
    constexpr double kClear = 3;
    if (!(inside > kClear * outside)) continue;
    if (const auto edge = LastFall(profile, 0.5 * (inside + outside))) {
      points.emplace_back(circle.centre + *edge * out);
    }
  }
  return points;
}

std::vector<Vector2d> FirstRisingEdges(const cv::Mat& map, const Circle& circle, double fraction) {
  std::vector<Vector2d> points;
  if (!Sample(map, circle.centre)) return points;
  // Static content in the middle gives the noise level.
  std::vector<Profile> profiles;
  std::vector<double> middle;
  for (int k = 0; k < kEdgeDirections; ++k) {
    profiles.push_back(
        Along(map, circle.centre, Direction(k, kEdgeDirections), 0, 0.7 * circle.radius));
    middle.push_back(profiles.back().Median(0, 0.08 * circle.radius));
  }
  std::nth_element(middle.begin(), middle.begin() + kEdgeDirections / 2, middle.end());
  const double low = middle[kEdgeDirections / 2];
  constexpr double kTimes = 2;
  constexpr double kMore = 0.4;
  const double high = kTimes * low + kMore;
  for (int k = 0; k < kEdgeDirections; ++k) {
    const Profile& profile = profiles[static_cast<std::size_t>(k)];
    constexpr std::size_t kRun = 20;  // samples above the level
    std::size_t run = 0;
    std::size_t i = 0;
    for (; i < profile.values.size() && run < kRun; ++i) {
      run = profile.values[i] > high ? run + 1 : 0;
    }
    if (run < kRun) continue;
    const double first = profile.RadiusAt(static_cast<double>(i - kRun));
    constexpr double kNearPx = 4;
    constexpr double kFarPx = 10;
    const double floor = profile.Median(first + kNearPx, first + kFarPx);
    const double level = low + fraction * (floor - low);
    // Back to the last sample below, then up to the level.
    std::size_t j = i - kRun;
    while (j > 1 && profile.values[j] > level) --j;
    while (j + 1 < profile.values.size() && profile.values[j + 1] < level) ++j;
    if (j + 1 == profile.values.size()) continue;
    const double rise = profile.values[j + 1] - profile.values[j];
    const double over = rise > 0 ? (level - profile.values[j]) / rise : 0;
    const double radius = profile.RadiusAt(static_cast<double>(j) + std::clamp(over, 0.0, 1.0));
    points.emplace_back(circle.centre + radius * Direction(k, kEdgeDirections));
  }
  return points;
}

std::vector<Vector2d> SteepestFalls(const cv::Mat& map, const Circle& circle, double reach_px) {
  constexpr double kMinFall = 12;   // grey levels
  constexpr std::size_t kSpan = 8;  // samples: 2 px
  std::vector<Vector2d> points;
  for (int k = 0; k < kEdgeDirections; ++k) {
    const Vector2d out = Direction(k, kEdgeDirections);
    const Profile profile =
        Along(map, circle.centre, out, circle.radius - reach_px - 1, circle.radius + reach_px + 1);
    double most = kMinFall;
    std::optional<double> at;
    for (std::size_t i = 0; i + kSpan < profile.values.size(); ++i) {
      const double fall = profile.values[i] - profile.values[i + kSpan];
      if (fall <= most) continue;
      most = fall;
      at = profile.RadiusAt(static_cast<double>(i) + 0.5 * kSpan);
    }
    if (at) points.emplace_back(circle.centre + *at * out);
  }
  return points;
}

namespace {

constexpr int kCoarseDirections = 72;

// Step of an image across a circle, outwards: the mean over directions, with a limit per direction,
// so that a few strong edges are not taken as a circle.
double FallAcross(const cv::Mat& map, const Circle& circle, double half_span, double limit) {
  double sum = 0;
  int seen = 0;
  for (int k = 0; k < kCoarseDirections; ++k) {
    const Vector2d out = Direction(k, kCoarseDirections);
    const auto inner = Sample(map, circle.centre + (circle.radius - half_span) * out);
    const auto outer = Sample(map, circle.centre + (circle.radius + half_span) * out);
    if (!inner || !outer) continue;
    ++seen;
    sum += std::clamp(*inner - *outer, -limit, limit);
  }
  constexpr double kMinSeen = 0.6;
  return seen < kMinSeen * kCoarseDirections ? -limit : sum / seen;
}

constexpr double kStepLimit = 40;  // grey levels

}  // namespace

std::optional<Circle> DarkeningCircle(const cv::Mat& grey) {
  constexpr double kCoarseSide = 160;
  const double scale = std::min(1.0, kCoarseSide / std::min(grey.cols, grey.rows));
  cv::Mat small;
  cv::resize(grey, small, {}, scale, scale, cv::INTER_AREA);
  small.convertTo(small, CV_32FC1);
  const double side = std::min(small.cols, small.rows);
  const Vector2d middle(0.5 * (small.cols - 1), 0.5 * (small.rows - 1));
  Circle best;
  double most = 0;
  const int reach = static_cast<int>(0.14 * side);
  const int least = static_cast<int>(0.3 * side);
  const int end = static_cast<int>(0.62 * side);
  for (int dv = -reach; dv <= reach; dv += 2) {
    for (int du = -reach; du <= reach; du += 2) {
      for (int radius = least; radius < end; ++radius) {
        const Circle circle{middle + Vector2d(du, dv), static_cast<double>(radius)};
        const double fall = FallAcross(small, circle, 1.5, kStepLimit);
        if (fall <= most) continue;
        most = fall;
        best = circle;
      }
    }
  }
  constexpr double kMinFall = 10;
  if (most < kMinFall) return std::nullopt;
  best.centre = (best.centre + Vector2d(0.5, 0.5)) / scale - Vector2d(0.5, 0.5);
  best.radius /= scale;
  return best;
}

std::optional<double> BrighteningRadius(const cv::Mat& grey, const Circle& circle) {
  cv::Mat map;
  grey.convertTo(map, CV_32FC1);
  double most = 0;
  std::optional<double> best;
  const int end = static_cast<int>(0.5 * circle.radius);
  for (int r = static_cast<int>(0.05 * circle.radius) + 1; r < end; ++r) {
    const double radius = r;
    const double rise =
        -FallAcross(map, {circle.centre, radius}, 0.015 * circle.radius, kStepLimit);
    if (rise <= most) continue;
    most = rise;
    best = radius;
  }
  constexpr double kMinRise = 10;
  return most < kMinRise ? std::nullopt : best;
}

}  // namespace ceilmap::calibration
