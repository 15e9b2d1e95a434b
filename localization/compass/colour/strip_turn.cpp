#include "localization/compass/colour/strip_turn.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

namespace ceilmap::colour {
namespace {

constexpr int kColumns = 256;
constexpr int kRows = 24;
constexpr int kMaxShift = kColumns / 2;
constexpr double kMaxDifference = 0.5;

/// Columns of a strip.
struct Columns {
  int first = 0;
  int count = kColumns;
};

/// Mean squared difference of columns of `a` and those of `b` that lie `shift` to the right, where
/// they exist, as a ratio of the variance of both there.
double Difference(const cv::Mat& a, const cv::Mat& b, Columns of, int shift) {
  const int first = std::max(of.first, -shift);
  const int count = std::min(of.first + of.count, kColumns - shift) - first;
  float off = 0;
  float energy = 0;
  for (int v = 0; v < kRows; ++v) {
    const float* x = a.ptr<float>(v) + first;
    const float* y = b.ptr<float>(v) + first + shift;
    // Independent partial sums, because a compiler may not reorder floating-point additions itself.
    constexpr int kLanes = 16;
    float offs[kLanes] = {};
    float energies[kLanes] = {};
    for (int u = 0; u + kLanes <= count; u += kLanes) {
      for (int lane = 0; lane < kLanes; ++lane) {
        const float p = x[u + lane];
        const float q = y[u + lane];
        offs[lane] += (p - q) * (p - q);
        energies[lane] += p * p + q * q;
      }
    }
    for (int lane = 0; lane < kLanes; ++lane) {
      off += offs[lane];
      energy += energies[lane];
    }
  }
  constexpr float kNoise = 2.F * kRows * kColumns;  // of an image without content
  return static_cast<double>(off / (energy + kNoise));
}

struct BestShift {
  double columns = 0;  ///< with fraction
  double difference = 1;
};

/// @param from, to  Range of the shifts that are tried, at least three.
BestShift FindShift(const cv::Mat& a, const cv::Mat& b, Columns of, int from, int to) {
  std::array<double, 2 * kMaxShift + 1> difference{};
  const int count = to - from + 1;
  for (int i = 0; i < count; ++i) {
    difference[static_cast<std::size_t>(i)] = Difference(a, b, of, from + i);
  }
  const auto* least = std::min_element(difference.begin() + 1, difference.begin() + count - 1);
  const double before = *(least - 1);
  const double after = *(least + 1);
  const double bend = before - 2 * *least + after;
  const double fraction = bend > 0 ? std::clamp(0.5 * (before - after) / bend, -0.5, 0.5) : 0;
  return {from + static_cast<double>(least - difference.begin()) + fraction, *least};
}

/// Angle from the axis at a distance from the principal point, in focal lengths.
double HalfView(const calib::Lens& lens, double radius) {
  constexpr double kMax = 1.2;  // of wide lenses, the middle part is used
  return std::min(kMax, lens.Angle(radius).value_or(lens.ValidAngle()));
}

}  // namespace

StripTurn::StripTurn(const calib::MountedCamera& forward) {
  const calib::Lens& camera = forward.camera;
  const Eigen::Matrix3d R_cam_base = forward.T_base_cam.linear().transpose();
  const Eigen::Vector3d axis = R_cam_base.row(2).transpose();
  const double middle = std::atan2(axis.y(), axis.x());
  const double pitch = std::asin(std::clamp(axis.z(), -1.0, 1.0));
  const double half = 0.92 * HalfView(camera, 0.5 * camera.width_px / camera.fx);
  const double half_height = HalfView(camera, 0.5 * camera.height_px / camera.fy);
  // From the horizon upwards, or as near to it as the field of view allows.
  const double lowest = std::max(0.03, pitch - 0.85 * half_height);
  const double highest = std::max(lowest + 0.1, pitch + 0.7 * half_height);
  column_rad_ = 2 * half / (kColumns - 1);
  // An object at azimuth a moves by sin(a) times the distance travelled over its distance; the mean
  // over a half.
  ahead_per_rad_ = half / (2 * (1 - std::cos(half)));
  table_ = calib::RemapTable(
      camera.Size(), {kColumns, kRows}, [&](int u, int v) -> std::optional<cv::Point2d> {
        const double azimuth = middle + half - column_rad_ * u;
        const double elevation = highest + (lowest - highest) * v / (kRows - 1);
        const Eigen::Vector3d direction(std::cos(elevation) * std::cos(azimuth),
                                        std::cos(elevation) * std::sin(azimuth),
                                        std::sin(elevation));
        const auto pixel = camera.Project(R_cam_base * direction);
        if (!pixel) return std::nullopt;
        return cv::Point2d(pixel->x(), pixel->y());
      });
}

std::optional<MeasuredTurn> StripTurn::Next(const cv::Mat& bgr) {
  table_.Apply(bgr, colours_);
  cv::cvtColor(colours_, grey_, cv::COLOR_BGR2GRAY);
  grey_.convertTo(now_, CV_32F);
  for (int v = 0; v < kRows; ++v) {
    cv::Mat row = now_.row(v);
    row -= cv::mean(row)[0];
  }
  cv::swap(now_, before_);  // before_ is the newest frame from here on
  if (now_.size() != before_.size()) return std::nullopt;
  const BestShift all = FindShift(now_, before_, {}, -kMaxShift, kMaxShift);
  if (!(all.difference < kMaxDifference)) return std::nullopt;
  // After a turn to the left, objects on the left have moved to the right.
  MeasuredTurn turned{all.columns * column_rad_, 0, all.difference};
  const int middle = static_cast<int>(std::lround(all.columns));
  constexpr int kAround = 12;
  constexpr int kHalf = kColumns / 2;
  if (std::abs(middle) + kAround > kHalf / 2) return turned;  // too little of one half is left
  const auto half = [&](int first) {
    return FindShift(now_, before_, {first, kHalf}, middle - kAround, middle + kAround);
  };
  const BestShift left = half(0);
  const BestShift right = half(kHalf);
  if (left.difference < kMaxDifference && right.difference < kMaxDifference) {
    turned.ahead = ahead_per_rad_ * column_rad_ * (right.columns - left.columns);
  }
  return turned;
}

}  // namespace ceilmap::colour
