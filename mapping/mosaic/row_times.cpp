#include "mapping/mosaic/row_times.hpp"

#include <cmath>
#include <optional>

#include "calib/base/error.hpp"
#include "calib/ceiling_view.hpp"
#include "calib/rig.hpp"

namespace ceilmap::mosaic {
namespace {

constexpr double kMinReadoutS = 0.004;  // less than half a band of the mains
constexpr int kSpacing = 8;             // pixels; lenses are smooth

std::optional<calib::Rig> RigOf(const store::MapMetadata& metadata) {
  if (metadata.rig_yaml.empty()) return std::nullopt;
  try {
    calib::Rig rig = calib::ParseRig(metadata.rig_yaml, "rig.yaml");
    if (!rig.up || std::abs(rig.up->readout_time_s) < kMinReadoutS) return std::nullopt;
    return rig;
  } catch (const InputError&) {
    return std::nullopt;  // of another version of the program
  }
}

}  // namespace

cv::Mat RowTimes(const store::MapMetadata& metadata) {
  const std::optional<calib::Rig> rig = RigOf(metadata);
  if (!rig) return {};
  const calib::CeilingView view(*rig->up, metadata.ceiling_height_m);
  if (view.Size() != metadata.view_size) return {};
  const double last_row = view.RawSize().height - 1;
  const cv::Size size = view.Size();
  cv::Mat_<float> nodes(size.height / kSpacing + 2, size.width / kSpacing + 2, 0.F);
  for (int j = 0; j < nodes.rows; ++j) {
    for (int i = 0; i < nodes.cols; ++i) {
      const auto raw = view.RawPixel(Eigen::Vector2d(i * kSpacing, j * kSpacing));
      if (!raw) continue;
      nodes(j, i) = static_cast<float>(rig->up->readout_time_s * (raw->y() / last_row - 0.5));
    }
  }
  cv::Mat_<float> times(size);
  for (int v = 0; v < size.height; ++v) {
    const int j = v / kSpacing;
    const float fv = static_cast<float>(v % kSpacing) / kSpacing;
    for (int u = 0; u < size.width; ++u) {
      const int i = u / kSpacing;
      const float fu = static_cast<float>(u % kSpacing) / kSpacing;
      times(v, u) = (1 - fv) * ((1 - fu) * nodes(j, i) + fu * nodes(j, i + 1)) +
                    fv * ((1 - fu) * nodes(j + 1, i) + fu * nodes(j + 1, i + 1));
    }
  }
  return times;
}

}  // namespace ceilmap::mosaic
