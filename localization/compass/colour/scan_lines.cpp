#include "localization/compass/colour/scan_lines.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "calib/base/degrees.hpp"
#include "calib/base/error.hpp"

namespace ceilmap::colour {
namespace {

// Between samples of a line, > 0; adjacent pixels with the same content add no information.
constexpr double kStepPx = 3;

using std::numbers::pi;

/// Directions in the level frame of the robot (x ahead, z up), and their pixels.
class ViewRays {
 public:
  ViewRays(const calib::MountedCamera& forward, const Tilt& tilt)
      : camera_(forward.camera),
        R_cam_level_((tilt.T_level_base().linear() * forward.T_base_cam.linear()).transpose()) {}

  [[nodiscard]] std::optional<Eigen::Vector2d> Pixel(double azimuth, double elevation) const {
    const Eigen::Vector3d direction(std::cos(elevation) * std::cos(azimuth),
                                    std::cos(elevation) * std::sin(azimuth),
                                    std::sin(elevation));
    auto pixel = camera_.Project(R_cam_level_ * direction);
    if (!pixel || !Inside(*pixel)) return std::nullopt;
    return pixel;
  }
  [[nodiscard]] bool IsAbove(double u, double v) const {
    const auto ray = camera_.Ray({u, v});
    return ray && (R_cam_level_.transpose() * *ray).z() > 0;
  }
  /// Azimuth of the optical axis.
  [[nodiscard]] double Azimuth() const {
    const Eigen::Vector3d axis = R_cam_level_.row(2).transpose();
    return std::atan2(axis.y(), axis.x());
  }
  [[nodiscard]] double Elevation() const {
    return std::asin(std::clamp(R_cam_level_(2, 2), -1.0, 1.0));
  }

 private:
  [[nodiscard]] bool Inside(const Eigen::Vector2d& pixel) const {
    return pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() <= camera_.Size().width - 1 &&
           pixel.y() <= camera_.Size().height - 1;
  }

  calib::Lens camera_;
  Eigen::Matrix3d R_cam_level_;
};

/// Pixels of a line from the horizon upwards, `step` apart.
std::vector<cv::Point2d> Line(const ViewRays& rays, double azimuth, double step_px) {
  std::vector<cv::Point2d> line;
  constexpr double kFine = 0.0005;  // rad
  constexpr double kHighest = 1.3;
  for (int i = 0; i * kFine < kHighest; ++i) {
    const auto pixel = rays.Pixel(azimuth, i * kFine);
    if (!pixel) {
      if (line.empty()) continue;  // the line enters the image higher up
      break;
    }
    const cv::Point2d at(pixel->x(), pixel->y());
    if (line.empty() || cv::norm(at - line.back()) >= step_px) line.push_back(at);
  }
  return line;
}

double FractionAbove(const ViewRays& rays, cv::Size size) {
  constexpr int kGrid = 60;
  int above = 0;
  for (int j = 0; j < kGrid; ++j) {
    for (int i = 0; i < kGrid; ++i) {
      above +=
          rays.IsAbove((i + 0.5) * size.width / kGrid - 0.5, (j + 0.5) * size.height / kGrid - 0.5)
              ? 1
              : 0;
    }
  }
  return static_cast<double>(above) / (kGrid * kGrid);
}

/// Half of the field of view at an elevation: the smaller of the angles to the left and to the
/// right of the axis.
double HalfField(const ViewRays& rays, double elevation) {
  constexpr double kStep = 0.002;
  double half = 0;
  while (half < pi / 2 && rays.Pixel(rays.Azimuth() + half, elevation) &&
         rays.Pixel(rays.Azimuth() - half, elevation)) {
    half += kStep;
  }
  return half;
}

}  // namespace

void ScanLineParams::Validate() const {
  if (lines < 2 || lines > 1000) {
    throw InputError(fmt::format("lines = {}, must be 2 to 1000", lines));
  }
  if (!(min_above_horizon >= 0 && min_above_horizon <= 1)) {
    throw InputError(fmt::format("min_above_horizon = {}, must be in [0, 1]", min_above_horizon));
  }
}

ScanLines::ScanLines(const calib::MountedCamera& forward,
                     const ScanLineParams& params,
                     const Tilt& tilt)
    : size_(forward.camera.Size()) {
  params.Validate();
  const ViewRays rays(forward, tilt);
  constexpr double kSteepest = pi / 3;
  if (!(std::abs(rays.Elevation()) < kSteepest)) {
    throw InputError(
        fmt::format("the forward camera points {:.0f} deg above the horizon, must be within 60 deg",
                    rays.Elevation() * kDegPerRad));
  }
  above_horizon_ = FractionAbove(rays, size_);
  if (above_horizon_ < params.min_above_horizon) return;
  // The horizon of a camera that is pitched up far lies below its image.
  double base = std::max(0.0, rays.Elevation());
  while (base > 0 && rays.Pixel(rays.Azimuth(), base)) base -= 0.01;
  const double half = HalfField(rays, std::max(0.0, base + 0.01));
  std::vector<std::vector<cv::Point2d>> lines;
  for (int i = 0; i < params.lines; ++i) {
    const double azimuth = rays.Azimuth() + half * (1 - (2.0 * i + 1) / params.lines);
    std::vector<cv::Point2d> line = Line(rays, azimuth, kStepPx);
    constexpr std::size_t kMinSamples = 8;
    if (line.size() < kMinSamples) continue;
    azimuths_.push_back(azimuth);
    lengths_.push_back(static_cast<int>(line.size()));
    lines.push_back(std::move(line));
  }
  if (lines.size() < 2) return;
  usable_ = true;
  const int longest = *std::max_element(lengths_.begin(), lengths_.end());
  table_ = calib::RemapTable(size_,
                             {longest, static_cast<int>(lines.size())},
                             [&lines](int u, int v) -> std::optional<cv::Point2d> {
                               const auto& line = lines[static_cast<std::size_t>(v)];
                               if (u >= static_cast<int>(line.size())) return std::nullopt;
                               return line[static_cast<std::size_t>(u)];
                             });
}

void ScanLines::Sample(const cv::Mat& bgr, cv::Mat& samples) const {
  if (bgr.type() != CV_8UC3 || bgr.size() != size_) {
    throw InputError(
        fmt::format("an image of {} x {} pixels and {} channels, must be {} x {} and 3",
                    bgr.cols,
                    bgr.rows,
                    bgr.channels(),
                    size_.width,
                    size_.height));
  }
  table_.Apply(bgr, samples);
}

ScanLinesByTilt::ScanLinesByTilt(calib::MountedCamera forward, const ScanLineParams& params)
    : forward_(std::move(forward)), params_(params) {}

const std::shared_ptr<const ScanLines>& ScanLinesByTilt::For(const Tilt& tilt) {
  const bool same = tilt.pitch_rad == tilt_.pitch_rad && tilt.roll_rad == tilt_.roll_rad;
  if (!lines_ || !same) {
    lines_ = std::make_shared<const ScanLines>(forward_, params_, tilt);
    tilt_ = tilt;
  }
  return lines_;
}

}  // namespace ceilmap::colour
