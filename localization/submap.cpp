#include "localization/submap.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "mapping/planar_motion.hpp"

namespace ceilmap::localization {

namespace {

constexpr int kReducedSide = 80;           // pixels of the longer side of a reduced image
constexpr double kViewSpacingRatio = 0.1;  // of the span, between kept images ...
constexpr double kViewSpacingRad = 0.15;   // ... unless the robot turns
constexpr std::size_t kMaxViews = 30;

// Band of the fine structure: standard deviations of the inner and outer Gaussian, pixels. With
// wider bands the shading of walls and lamps outweighs edges.
constexpr double kInnerPx = 0.6;
constexpr double kOuterPx = 1.6;
constexpr int kMarginPx = 2;  // structure at the border of what is known is not

/// Median of the values where `known` is not 0; both CV_32FC1.
double MedianWhere(const cv::Mat& known, const cv::Mat& all) {
  std::vector<float> values;
  values.reserve(all.total());
  for (int y = 0; y < all.rows; ++y) {
    const auto* value = all.ptr<float>(y);
    const auto* is_known = known.ptr<float>(y);
    for (int x = 0; x < all.cols; ++x) {
      if (is_known[x] > 0) values.push_back(value[x]);
    }
  }
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

FineStructure FineStructure::Of(const cv::Mat& grey, const cv::Mat& mask) {
  FineStructure result;
  cv::Mat weight;
  cv::Mat values;
  cv::Mat inside;
  cv::compare(mask, 0, inside, cv::CMP_NE);
  inside.convertTo(weight, CV_32F, 1.0 / 255);
  grey.convertTo(values, CV_32F);
  values = values.mul(weight);
  cv::Mat around;
  cv::Mat around_weight;
  cv::GaussianBlur(values, around, {}, kOuterPx);
  cv::GaussianBlur(weight, around_weight, {}, kOuterPx);
  constexpr double kMin = 1e-3;
  cv::divide(around, cv::max(around_weight, kMin), around);
  cv::Mat detail = (values - around).mul(weight);
  cv::GaussianBlur(detail, result.detail, {}, kInnerPx);
  cv::erode(inside, inside, cv::Mat(), {-1, -1}, kMarginPx, cv::BORDER_CONSTANT, cv::Scalar(0));
  inside.convertTo(result.known, CV_32F, 1.0 / 255);
  result.detail = result.detail.mul(result.known);
  return result;
}

std::array<cv::Mat, 2> FineStructure::Directions() const {
  cv::Mat gx;
  cv::Mat gy;
  constexpr double kPerPixel = 1.0 / 32;  // Scharr's weights add up to 32
  cv::Scharr(detail, gx, CV_32F, 1, 0, kPerPixel);
  cv::Scharr(detail, gy, CV_32F, 0, 1, kPerPixel);
  cv::Mat inside;
  cv::erode(known, inside, cv::Mat(), {-1, -1}, 1, cv::BORDER_CONSTANT, cv::Scalar(0));
  const cv::Mat squared = gx.mul(gx) + gy.mul(gy);
  cv::Mat length;
  cv::sqrt(squared, length);
  constexpr double kMin = 1e-3;
  const double typical = std::max(kMin, MedianWhere(inside, length));
  // g^2 / |g|^2 * |g| / (|g| + typical)
  const cv::Mat divisor = length.mul(length + typical) + kMin * kMin;
  std::array<cv::Mat, 2> directions;
  cv::divide(inside.mul(gx.mul(gx) - gy.mul(gy)), divisor, directions[0]);
  cv::divide(inside.mul(2 * gx.mul(gy)), divisor, directions[1]);
  return directions;
}

void FineStructure::Compress() {
  constexpr double kMin = 0.02;  // grey levels: less is rounding
  const double typical = std::max(kMin, MedianWhere(known, cv::abs(detail)));
  const cv::Mat size = cv::abs(detail) + typical;
  cv::divide(detail, size, detail);
}

Submap::Submap(const calib::CeilingView& view)
    : T_base_view_(view.T_base_view()),
      size_(view.Size()),
      mask_(view.Mask()),
      reduction_(
          std::max(1, (std::max(size_.width, size_.height) + kReducedSide / 2) / kReducedSide)),
      unit_(reduction_ * view.MetresPerPixel()),
      span_(mapping::SpanOf(view)) {}

void Submap::Clear() {
  views_.clear();
  T_submap_base_ = {};
  travelled_ = 0;
}

void Submap::Move(const Pose2& T_before_now) {
  T_submap_base_ = T_submap_base_ * T_before_now;
  travelled_ += T_before_now.Translation().norm();
}

void Submap::Add(const cv::Mat& image, const cv::Mat& mask) {
  const Pose2 T_submap_view = T_submap_base_ * T_base_view_;
  if (!views_.empty()) {
    const Pose2 moved = views_.back().T_submap_view.Inverse() * T_submap_view;
    if (moved.Translation().norm() < kViewSpacingRatio * span_ &&
        std::abs(moved.yaw) < kViewSpacingRad) {
      return;
    }
  }
  const cv::Size reduced(size_.width / reduction_, size_.height / reduction_);
  const cv::Rect whole(0, 0, reduced.width * reduction_, reduced.height * reduction_);
  cv::Mat content(size_, CV_8UC1, cv::Scalar(255));
  if (!mask_.empty()) mask_.copyTo(content);
  if (!mask.empty()) content.setTo(0, mask == 0);
  cv::Mat grey;
  cv::resize(image(whole), grey, reduced, 0, 0, cv::INTER_AREA);
  cv::resize(content(whole), content, reduced, 0, 0, cv::INTER_AREA);
  cv::threshold(content, content, 254, 255, cv::THRESH_BINARY);
  views_.push_back({FineStructure::Of(grey, content), T_submap_view, travelled_});
  if (views_.size() > kMaxViews) views_.pop_front();
}

double Submap::Length() const {
  return views_.empty() ? 0 : views_.back().travelled - views_.front().travelled;
}

Submap::Drawing Submap::Draw(double length) const {
  const auto begin = std::find_if(views_.begin(), views_.end(), [&](const View& view) {
    return travelled_ - view.travelled <= length;
  });
  Eigen::Vector2d low = Eigen::Vector2d::Constant(std::numeric_limits<double>::max());
  Eigen::Vector2d high = -low;
  for (auto view = begin; view != views_.end(); ++view) {
    low = low.cwiseMin(view->T_submap_view.Translation());
    high = high.cwiseMax(view->T_submap_view.Translation());
  }
  const Eigen::Vector2d centre =
      begin == views_.end() ? Eigen::Vector2d::Zero() : Eigen::Vector2d(0.5 * (low + high));
  double radius = 0;
  for (auto view = begin; view != views_.end(); ++view) {
    radius = std::max(radius, (view->T_submap_view.Translation() - centre).norm());
  }
  radius += 0.5 * std::hypot(size_.width, size_.height) / reduction_ * unit_;
  const int half = static_cast<int>(std::ceil(radius / unit_)) + 1;
  const cv::Size side(2 * half, 2 * half);
  Drawing drawing;
  drawing.T_drawing_base = Pose2{-centre.x(), -centre.y(), 0} * T_submap_base_;
  cv::Mat& sum = drawing.structure.detail;
  sum = cv::Mat::zeros(side, CV_32FC1);
  cv::Mat count = cv::Mat::zeros(side, CV_32FC1);
  cv::Mat drawn;
  for (auto view = begin; view != views_.end(); ++view) {
    const cv::Matx23d affine = OnDrawing(view->T_submap_view, centre, half);
    cv::warpAffine(view->structure.detail, drawn, affine, side, cv::INTER_LINEAR);
    sum += drawn;
    cv::warpAffine(view->structure.known, drawn, affine, side, cv::INTER_LINEAR);
    count += drawn;
  }
  constexpr double kMinCount = 0.9;
  drawing.structure.known = cv::Mat(count > kMinCount);
  drawing.structure.known.convertTo(drawing.structure.known, CV_32F, 1.0 / 255);
  cv::divide(sum, cv::max(count, kMinCount), sum);
  sum = sum.mul(drawing.structure.known);
  drawing.structure.Compress();
  return drawing;
}

/// From pixels of a reduced image to those of a drawing.
cv::Matx23d Submap::OnDrawing(const Pose2& T_submap_view,
                              const Eigen::Vector2d& centre,
                              int half) const {
  const double c = std::cos(T_submap_view.yaw);
  const double s = std::sin(T_submap_view.yaw);
  // Centre of the image, in reduced pixels.
  const double u = 0.5 * size_.width / reduction_ - 0.5;
  const double v = 0.5 * size_.height / reduction_ - 0.5;
  const Eigen::Vector2d at = (T_submap_view.Translation() - centre) / unit_;
  const double x = at.x() + half;
  const double y = at.y() + half;
  return {c, -s, x - c * u + s * v, s, c, y - s * u - c * v};
}

}  // namespace ceilmap::localization
