#include "calib/level_view.hpp"

#include <Eigen/LU>
#include <opencv2/imgproc.hpp>

#include "calib/error.hpp"

namespace ceilmap::calib {
namespace {

cv::Matx33d ToMatx(const Eigen::Matrix3d& m) {
  return {m(0, 0), m(0, 1), m(0, 2), m(1, 0), m(1, 1), m(1, 2), m(2, 0), m(2, 1), m(2, 2)};
}

}  // namespace

LevelView::LevelView(const CeilingView& view) : size_(view.Size()), focal_px_(view.FocalLength()) {
  if (!(focal_px_ > 0)) {
    throw InputError("a tilt can only be taken out of pictures of a camera whose rig is known");
  }
  distance_m_ = focal_px_ * view.MetresPerPixel();
  principal_px_ = view.PrincipalPoint();
  T_base_camera_ = view.T_base_camera();
  // A cubic sample reaches two pixels beyond its place: content ends there.
  constexpr int kReach = 2;
  content_ = cv::Mat(size_, CV_8UC1, cv::Scalar(0));
  const cv::Rect inside(kReach, kReach, size_.width - 2 * kReach, size_.height - 2 * kReach);
  if (view.Mask().empty()) {
    content_(inside).setTo(255);
  } else {
    const cv::Mat reach(2 * kReach + 1, 2 * kReach + 1, CV_8UC1, cv::Scalar(1));
    cv::Mat eroded;
    cv::erode(view.Mask(), eroded, reach);
    eroded(inside).copyTo(content_(inside));
  }
}

Eigen::Isometry3d LevelView::T_level_camera(const Tilt& tilt) const {
  return tilt.T_level_base() * T_base_camera_;
}

Eigen::Matrix3d LevelView::TiltedFromLevel(const Tilt& tilt) const {
  // In the level camera's frame the ceiling is the plane z = distance; a pixel x of the level
  // picture is there distance * K^-1 x.
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

void LevelView::Draw(const cv::Mat& picture, const Tilt& tilt, cv::Mat& level) const {
  CV_Assert(picture.type() == CV_8UC1 && picture.size() == size_ && level.data != picture.data);
  const cv::Matx33d map = ToMatx(TiltedFromLevel(tilt));
  constexpr int kHow = cv::INTER_CUBIC | cv::WARP_INVERSE_MAP;
  cv::warpPerspective(picture, level, map, size_, kHow, cv::BORDER_REPLICATE);
  cv::Mat mask;
  cv::warpPerspective(content_,
                      mask,
                      map,
                      size_,
                      cv::INTER_NEAREST | cv::WARP_INVERSE_MAP,
                      cv::BORDER_CONSTANT,
                      cv::Scalar(0));
  cv::max(level, 1, level);
  cv::bitwise_and(level, mask, level);
}

cv::Mat ContentMask(const cv::Mat& level) {
  if (cv::countNonZero(level) == level.size().area()) return {};
  cv::Mat blank = level == 0;
  const cv::Mat reach(5, 5, CV_8UC1, cv::Scalar(1));
  // What lies beyond the picture counts as blank: a thin blank border stays one.
  constexpr int kOutside = 255;
  cv::morphologyEx(blank,
                   blank,
                   cv::MORPH_OPEN,
                   reach,
                   cv::Point(-1, -1),
                   1,
                   cv::BORDER_CONSTANT,
                   cv::Scalar(kOutside));
  if (cv::countNonZero(blank) == 0) return {};
  return ~blank;
}

}  // namespace ceilmap::calib
