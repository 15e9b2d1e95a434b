#include "calib/rolling_shutter.hpp"

#include <optional>

namespace ceilmap::calib {

/// A point that the image of the middle row's moment shows at x was exposed at the time tau of
/// another row, and was then at x + tau * flow(x). Two rounds: the row depends on the time.
std::optional<cv::Point2d> RollingShutter::RawAt(const Eigen::Vector2d& pixel,
                                                 const ImageFlow& flow) const {
  constexpr int kRounds = 2;
  const cv::Size size = camera_.Size();
  const double last_row = camera_.RawSize().height - 1;
  const Eigen::Vector2d x =
      pixel - Eigen::Vector2d(0.5 * (size.width - 1), 0.5 * (size.height - 1));
  const Eigen::Vector2d velocity =
      flow.linear_px_s + flow.yaw_rad_s * Eigen::Vector2d(-x.y(), x.x());
  std::optional<cv::Point2d> raw = camera_.Raw(pixel.x(), pixel.y());
  for (int i = 0; i < kRounds && raw; ++i) {
    const double time_s = (raw->y / last_row - 0.5) * readout_time_s_;
    const Eigen::Vector2d at = pixel + time_s * velocity;
    raw = camera_.Raw(at.x(), at.y());
  }
  return raw;
}

cv::Vec2f RollingShutter::ShiftAt(const Eigen::Vector2d& pixel, const ImageFlow& flow) const {
  const std::optional<cv::Point2d> still = camera_.Raw(pixel.x(), pixel.y());
  const std::optional<cv::Point2d> now = RawAt(pixel, flow);
  if (!still || !now) return {0, 0};
  return {static_cast<float>(now->x - still->x), static_cast<float>(now->y - still->y)};
}

SourceShift RollingShutter::ShiftBy(const ImageFlow& flow) const {
  SourceShift shift;
  shift.nodes.create(SourceShift::NodesFor(camera_.Size()));
  for (int i = 0; i < shift.nodes.rows; ++i) {
    for (int j = 0; j < shift.nodes.cols; ++j) {
      shift.nodes(i, j) = ShiftAt({j * SourceShift::kSpacingPx, i * SourceShift::kSpacingPx}, flow);
    }
  }
  return shift;
}

}  // namespace ceilmap::calib
