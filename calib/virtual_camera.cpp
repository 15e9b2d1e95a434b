#include "calib/virtual_camera.hpp"

#include <cmath>
#include <string>

#include "calib/base/error.hpp"
#include "calib/size_text.hpp"

namespace ceilmap::calib {
namespace {

/// A rectification that moves no pixel by more than this is omitted to avoid the interpolation.
constexpr double kUntouchedPx = 1e-3;

}  // namespace

VirtualCamera::VirtualCamera(const MountedCamera& mounted,
                             const Eigen::Matrix3d& R_base_view,
                             const ViewFrame& frame)
    : lens_(mounted.camera),
      frame_(frame),
      R_cam_view_(mounted.T_base_cam.linear().transpose() * R_base_view) {}

std::optional<cv::Point2d> VirtualCamera::Raw(double u, double v) const {
  const auto raw = RawPixel(lens_, R_cam_view_, frame_, {u, v});
  if (!raw) return std::nullopt;
  return cv::Point2d(raw->x(), raw->y());
}

/// Largest displacement over a grid of pixels that includes the borders.
bool VirtualCamera::MovesPixels() const {
  if (frame_.size != lens_.Size()) return true;
  constexpr int kSteps = 16;
  for (int i = 0; i <= kSteps; ++i) {
    for (int j = 0; j <= kSteps; ++j) {
      const double u = (frame_.size.width - 1.0) * i / kSteps;
      const double v = (frame_.size.height - 1.0) * j / kSteps;
      const auto raw = Raw(u, v);
      if (!raw || std::hypot(raw->x - u, raw->y - v) > kUntouchedPx) return true;
    }
  }
  return false;
}

RemapTable VirtualCamera::MakeTable() const {
  if (!MovesPixels()) return {};
  return {lens_.Size(), frame_.size, [this](int u, int v) { return Raw(u, v); }};
}

void CheckRaw(const cv::Mat& raw, cv::Size size) {
  if (raw.type() != CV_8UC1 || raw.size() != size) {
    throw InputError("image of " + SizeText(raw.size()) + " pixels" +
                     (raw.type() == CV_8UC1 ? "" : " that is not 8-bit grey") + ", must be " +
                     SizeText(size) + " and 8-bit grey; use the rig of the camera that took it");
  }
}

const cv::Mat& RectifyBy(const RemapTable& table,
                         cv::Size size,
                         const cv::Mat& raw,
                         cv::Mat& buffer) {
  CheckRaw(raw, size);
  if (table.empty()) return raw;
  const cv::Mat source = raw;  // keeps the pixels when raw and buffer are the same
  if (buffer.data == source.data) buffer.release();
  table.Apply(source, buffer);
  return buffer;
}

}  // namespace ceilmap::calib
