#include "localization/compass/colour/strip_turn.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

namespace ceilmap::colour {
namespace {

constexpr int kColumns = 256;
constexpr int kRows = 24;
constexpr int kMostShift = kColumns / 2;
constexpr double kMostDifference = 0.5;

/// Mean squared difference of two strips where they overlap, `b` moved by `shift` columns to the
/// left, as a part of what both vary there.
double Difference(const cv::Mat& a, const cv::Mat& b, int shift) {
  const int first = std::max(0, -shift);
  const int count = kColumns - std::abs(shift);
  float off = 0;
  float energy = 0;
  for (int v = 0; v < kRows; ++v) {
    const float* x = a.ptr<float>(v) + first;
    const float* y = b.ptr<float>(v) + first + shift;
    // Sums side by side, which a compiler may not make of one by itself.
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
  constexpr float kNoise = 2.F * kRows * kColumns;  // of a picture with nothing in it
  return static_cast<double>(off / (energy + kNoise));
}

}  // namespace

StripTurn::StripTurn(const calib::MountedCamera& forward) {
  const calib::PinholeCamera& camera = forward.camera;
  const Eigen::Matrix3d R_cam_base = forward.T_base_cam.linear().transpose();
  const Eigen::Vector3d axis = R_cam_base.row(2).transpose();
  const double middle = std::atan2(axis.y(), axis.x());
  const double pitch = std::asin(std::clamp(axis.z(), -1.0, 1.0));
  const double half = 0.92 * std::atan(0.5 * camera.width_px / camera.fx);
  const double half_height = std::atan(0.5 * camera.height_px / camera.fy);
  // From the horizon up, or as near to it as the camera sees.
  const double lowest = std::max(0.03, pitch - 0.85 * half_height);
  const double highest = std::max(lowest + 0.1, pitch + 0.7 * half_height);
  column_rad_ = 2 * half / (kColumns - 1);
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

std::optional<SeenTurn> StripTurn::Next(const cv::Mat& bgr) {
  table_.Apply(bgr, colours_);
  cv::cvtColor(colours_, grey_, cv::COLOR_BGR2GRAY);
  grey_.convertTo(now_, CV_32F);
  for (int v = 0; v < kRows; ++v) {
    cv::Mat row = now_.row(v);
    row -= cv::mean(row)[0];
  }
  cv::swap(now_, before_);  // before_ is the newest from here on
  if (now_.size() != before_.size()) return std::nullopt;
  difference_.resize(2 * kMostShift + 1);
  for (int shift = -kMostShift; shift <= kMostShift; ++shift) {
    difference_[static_cast<std::size_t>(shift + kMostShift)] = Difference(now_, before_, shift);
  }
  const auto least = std::min_element(difference_.begin() + 1, difference_.end() - 1);
  if (!(*least < kMostDifference)) return std::nullopt;
  const double before = *(least - 1);
  const double after = *(least + 1);
  const double bend = before - 2 * *least + after;
  const double part = bend > 0 ? std::clamp(0.5 * (before - after) / bend, -0.5, 0.5) : 0;
  const double shift = static_cast<double>(least - difference_.begin()) - kMostShift + part;
  // Things that stood left are further right after a turn to the left.
  return SeenTurn{shift * column_rad_, *least};
}

}  // namespace ceilmap::colour
