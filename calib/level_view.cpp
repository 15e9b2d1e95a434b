#include "calib/level_view.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>

#include "calib/base/error.hpp"

namespace ceilmap::calib {
LevelView::LevelView(const CeilingView& view) : size_(view.Size()), focal_px_(view.FocalLength()) {
  if (!(focal_px_ > 0)) {
    throw InputError("a tilt can only be taken out of images of a camera whose rig is known");
  }
  distance_m_ = focal_px_ * view.MetresPerPixel();
  principal_px_ = view.PrincipalPoint();
  T_base_camera_ = view.T_base_camera();
  if (view.Mask().empty()) return;
  // A sample uses its right and lower neighbours.
  const cv::Mat reach(2, 2, CV_8UC1, cv::Scalar(1));
  cv::erode(view.Mask(), content_, reach, cv::Point(0, 0));
}

Eigen::Isometry3d LevelView::T_level_camera(const Tilt& tilt) const {
  return tilt.T_level_base() * T_base_camera_;
}

Eigen::Matrix3d LevelView::TiltedFromLevel(const Tilt& tilt) const {
  // In the frame of the level camera the ceiling is the plane z = distance; the point of pixel x of
  // the level image is distance * K^-1 x.
  const Eigen::Isometry3d T_tilted_level = T_level_camera(tilt).inverse() * T_base_camera_;
  Eigen::Matrix3d K = Eigen::Matrix3d::Identity();
  K(0, 0) = K(1, 1) = focal_px_;
  K.topRightCorner<2, 1>() = principal_px_;
  Eigen::Matrix3d induced = T_tilted_level.linear();
  induced.col(2) += T_tilted_level.translation() / distance_m_;
  return K * induced * K.inverse();
}

Eigen::Vector2d LevelView::CeilingShift(const Tilt& tilt) const {
  const Eigen::Isometry3d T = T_level_camera(tilt);
  const Eigen::Vector3d axis = T.linear().col(2);
  const double rise = T_base_camera_.translation().z() + distance_m_ - T.translation().z();
  const Eigen::Vector2d met = T.translation().head<2>() + rise / axis.z() * axis.head<2>();
  return met - T_base_camera_.translation().head<2>();
}

Pose2 LevelView::Uncompensated(const Pose2& T_map_base, const Tilt& tilt) const {
  if (tilt.IsLevel()) return T_map_base;
  const Eigen::Vector2d shift = CeilingShift(tilt);
  return T_map_base * Pose2{shift.x(), shift.y(), 0};
}

void LevelView::Draw(const cv::Mat& image, const Tilt& tilt, cv::Mat& level) const {
  CV_Assert(image.type() == CV_8UC1 && image.size() == size_ && level.data != image.data);
  level.create(size_, CV_8UC1);
  // cv::warpPerspective rounds to 1/32 px, see RemapTable.
  const Eigen::Matrix3f map = TiltedFromLevel(tilt).cast<float>();
  const auto right = static_cast<float>(size_.width - 1);
  const auto bottom = static_cast<float>(size_.height - 1);
  constexpr float kRounding = 5e-4F;  // px, of an image of a few thousand
  // Just before the last column and row, which are the right and lower neighbours there.
  const float max_x = std::nextafter(right, 0.0F);
  const float max_y = std::nextafter(bottom, 0.0F);
  for (int v = 0; v < size_.height; ++v) {
    const Eigen::Vector3f row = map.col(1) * static_cast<float>(v) + map.col(2);
    auto* out = level.ptr<std::uint8_t>(v);
    for (int u = 0; u < size_.width; ++u) {
      const auto column = static_cast<float>(u);
      const float scale = 1 / (map(2, 0) * column + row[2]);
      const float x = (map(0, 0) * column + row[0]) * scale;
      const float y = (map(1, 0) * column + row[1]) * scale;
      const bool inside =
          x >= -kRounding && x <= right + kRounding && y >= -kRounding && y <= bottom + kRounding;
      out[u] = inside ? Sample(image, std::clamp(x, 0.0F, max_x), std::clamp(y, 0.0F, max_y))
                      : std::uint8_t{0};
    }
  }
}

/// Bilinear interpolation with a result of at least 1; 0 where the image has no content.
std::uint8_t LevelView::Sample(const cv::Mat& image, float x, float y) const {
  const int x0 = static_cast<int>(x);
  const int y0 = static_cast<int>(y);
  if (!content_.empty() && content_.ptr<std::uint8_t>(y0)[x0] == 0) return 0;
  const auto* top = image.ptr<std::uint8_t>(y0) + x0;
  const auto* low = top + image.step[0];
  const float fraction = x - static_cast<float>(x0);
  const float upper = static_cast<float>(top[0]) + fraction * static_cast<float>(top[1] - top[0]);
  const float lower = static_cast<float>(low[0]) + fraction * static_cast<float>(low[1] - low[0]);
  const float grey = upper + (y - static_cast<float>(y0)) * (lower - upper);
  return static_cast<std::uint8_t>(std::max(1.0F, grey + 0.5F));
}

cv::Mat ContentMask(const cv::Mat& level) {
  if (cv::countNonZero(level) == level.size().area()) return {};
  constexpr int kReach = 5;
  // Pixels outside the image count as blank, so that a thin blank border is preserved.
  constexpr int kBeyond = kReach - 1;
  cv::Mat blank;
  cv::copyMakeBorder(
      level == 0, blank, kBeyond, kBeyond, kBeyond, kBeyond, cv::BORDER_CONSTANT, cv::Scalar(255));
  cv::morphologyEx(blank, blank, cv::MORPH_OPEN, cv::Mat(kReach, kReach, CV_8UC1, cv::Scalar(1)));
  blank = blank(cv::Rect(cv::Point(kBeyond, kBeyond), level.size()));
  if (cv::countNonZero(blank) == 0) return {};
  return ~blank;
}

}  // namespace ceilmap::calib
