#include "mapping/registration/level_frame.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "mapping/registration/kernels.hpp"

namespace ceilmap::registration {
namespace {

constexpr int kFineSide = 1200;  // maximum of the longer side of the fine level, approximately
constexpr int kSmallSide = 240;  // shorter side; from here on there are six rows of rough blocks

}  // namespace

void FillLevel(
    const cv::Mat& full, double factor, cv::Size size, const ImageNoise& noise, Level& level) {
  level.grey.Resize(static_cast<std::size_t>(size.area()));
  // An enlarged image has all its noise in a quarter of the band, twice as dense along each axis.
  level.noise = noise.Reduced(factor);
  if (factor < 1) {
    cv::Mat exact;
    full.convertTo(exact, CV_32F);
    cv::Mat enlarged(size, CV_32FC1, level.grey.data());
    cv::resize(exact, enlarged, size, 0, 0, cv::INTER_LANCZOS4);
    return;
  }
  kernels::ReduceArea(full.ptr<unsigned char>(),
                      full.step,
                      static_cast<int>(factor),
                      size.width,
                      size.height,
                      level.grey.data());
}

cv::Mat LevelMask(const cv::Mat& mask, cv::Size size) {
  if (mask.empty()) return {};
  cv::Mat reduced;
  cv::resize(mask, reduced, size, 0, 0, cv::INTER_AREA);
  return reduced;
}

double FineFactor(cv::Size full) {
  if (std::min(full.width, full.height) < kSmallSide) return 0.5;
  const int reduction = 1 + (std::max(full.width, full.height) - 1) / kFineSide;
  return reduction;
}

LevelFrame::LevelFrame(cv::Size full, double full_px_per_level_px)
    : factor(full_px_per_level_px),
      size(static_cast<int>(full.width / factor), static_cast<int>(full.height / factor)),
      offset(0.5 * (factor * size.width - full.width), 0.5 * (factor * size.height - full.height)) {
}

ImageMotion LevelFrame::FromFull(const ImageMotion& full) const {
  ImageMotion level = full;
  const Eigen::Vector2d t = (full.Apply(offset) - offset) / factor;
  level.tx_px = t.x();
  level.ty_px = t.y();
  return level;
}

ImageMotion LevelFrame::ToFull(const ImageMotion& level) const {
  ImageMotion full = level;
  full.tx_px = 0;
  full.ty_px = 0;
  const Eigen::Vector2d t =
      factor * Eigen::Vector2d(level.tx_px, level.ty_px) + offset - full.Apply(offset);
  full.tx_px = t.x();
  full.ty_px = t.y();
  return full;
}

PlaneCamera LevelFrame::CameraOf(const PlaneCamera& full) const {
  return {full.focal_px / factor, (full.principal_px - offset) / factor};
}

}  // namespace ceilmap::registration
