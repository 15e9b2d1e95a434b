#include "calib/mirror_view.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "calib/base/degrees.hpp"
#include "calib/base/error.hpp"
#include "calib/size_text.hpp"

namespace ceilmap::calib {
namespace {

constexpr double kPi = std::numbers::pi;

std::string Degrees(double angle_rad) {
  return fmt::format("{:.4g} deg", angle_rad / kRadPerDeg);
}

void CheckRange(const char* name, int value, int least, int most) {
  if (value >= least && value <= most) return;
  throw InputError(
      fmt::format("MirrorViewParams.{} = {}, must be in {}..{}", name, value, least, most));
}

void CheckElevation(const char* name, const std::optional<double>& elevation_rad) {
  if (!elevation_rad || std::abs(*elevation_rad) < kPi / 2) return;
  throw InputError(fmt::format("MirrorViewParams.{} = {}, must be above -90 deg and below 90 deg",
                               name,
                               Degrees(*elevation_rad)));
}

/// @throws InputError unless the camera points up.
double TiltOf(const MountedCamera& omni) {
  const double cosine = omni.T_base_cam.linear()(2, 2);
  if (cosine > std::numbers::sqrt2 / 2) return std::acos(std::min(cosine, 1.0));
  throw InputError(
      "mirror camera: its optical axis must point upwards (within 45 deg); correct the camera's "
      "pose in the rig");
}

/// Azimuth of a column in base, as in the class comment.
double Azimuth(int u, int columns) {
  return kPi - 2 * kPi * u / columns;
}

/// A quantity that changes linearly from the upper to the lower edge of the panorama.
struct Edges {
  double upper = 0;
  double lower = 0;
  int rows = 1;

  [[nodiscard]] double At(double row) const { return upper + (lower - upper) * (row + 0.5) / rows; }
  /// The row at which the quantity has that value.
  [[nodiscard]] double RowOf(double value) const {
    return rows * (value - upper) / (lower - upper) - 0.5;
  }
};

/// One row for each pixel of the radius.
int RowsFor(double radius_px) {
  return std::max(1, static_cast<int>(std::lround(radius_px)));
}

/// Elevations of the rows of a panorama from a mirror of known shape.
class RowElevations {
 public:
  RowElevations(const MountedCamera& omni, double tilt_rad, const MirrorViewParams& params)
      : mirror_(*omni.mirror), spacing_(params.row_spacing.value_or(PanoramaRows::kElevation)) {
    const HyperbolicMirror& mirror = mirror_;
    constexpr double kMinBelow = 15 * kRadPerDeg;
    constexpr double kMaxBelow = 30 * kRadPerDeg;
    const double highest_rad =
        params.highest_elevation_rad.value_or(mirror.RimElevation() - tilt_rad);
    const double lowest_rad =
        params.lowest_elevation_rad.value_or(-std::clamp(highest_rad, kMinBelow, kMaxBelow));
    if (!(lowest_rad < highest_rad)) {
      throw InputError(fmt::format(
          "mirror camera: the panorama's lowest elevation {} must be below its highest, "
          "{}; the maximum of the mirror is {}",
          Degrees(lowest_rad),
          Degrees(highest_rad),
          Degrees(mirror.RimElevation() - tilt_rad)));
    }
    edges_ = {ToSpacing(highest_rad), ToSpacing(lowest_rad), params.rows};
    if (spacing_ == PanoramaRows::kPixelRadius) {
      edges_.rows = RowsFor((edges_.upper - edges_.lower) * omni.camera.fx);
    }
  }

  [[nodiscard]] int Rows() const { return edges_.rows; }

  [[nodiscard]] double At(int row) const { return FromSpacing(edges_.At(row)); }
  [[nodiscard]] double HorizonRow() const { return edges_.RowOf(ToSpacing(0)); }

 private:
  [[nodiscard]] double ToSpacing(double elevation_rad) const {
    switch (spacing_) {
      case PanoramaRows::kRadius:
      case PanoramaRows::kPixelRadius:
        return mirror_.CameraSlope(elevation_rad);
      case PanoramaRows::kTanElevation:
        return std::tan(elevation_rad);
      default:
        return elevation_rad;
    }
  }
  [[nodiscard]] double FromSpacing(double value) const {
    switch (spacing_) {
      case PanoramaRows::kRadius:
      case PanoramaRows::kPixelRadius:
        return mirror_.Elevation(value);
      case PanoramaRows::kTanElevation:
        return std::atan(value);
      default:
        return value;
    }
  }

  HyperbolicMirror mirror_;
  PanoramaRows spacing_;
  Edges edges_;
};

void CheckRing(const MirrorRing& ring, const MirrorViewParams& params) {
  if (!ring.centre_px.allFinite() || !(ring.inner_radius_px > 0) ||
      !(ring.outer_radius_px > ring.inner_radius_px && std::isfinite(ring.outer_radius_px))) {
    throw InputError(fmt::format(
        "mirror ring: inner radius {} px, outer {} px, must be 0 < inner < outer about a "
        "centre in the image",
        ring.inner_radius_px,
        ring.outer_radius_px));
  }
  const PanoramaRows spacing = params.row_spacing.value_or(PanoramaRows::kRadius);
  if ((spacing != PanoramaRows::kRadius && spacing != PanoramaRows::kPixelRadius) ||
      params.highest_elevation_rad || params.lowest_elevation_rad) {
    throw InputError(
        "mirror ring: elevations are not known of a mirror without its shape; leave them out, or "
        "give the mirror's A, B and C in the rig");
  }
}

int RowsOf(const MirrorRing& ring, const MirrorViewParams& params) {
  if (params.row_spacing != PanoramaRows::kPixelRadius) return params.rows;
  return RowsFor(ring.outer_radius_px - ring.inner_radius_px);
}

/// Samples along the scan lines of a ring. The camera may be rotated about its axis.
RemapTable::Source RingSource(const MirrorRing& ring,
                              const Eigen::Matrix3d& R_base_cam,
                              const MirrorViewParams& params) {
  const Edges radii{ring.outer_radius_px, ring.inner_radius_px, RowsOf(ring, params)};
  return [=, columns = params.columns](int u, int v) -> std::optional<cv::Point2d> {
    const double azimuth = Azimuth(u, columns);
    const Eigen::Vector3d level_base(std::cos(azimuth), std::sin(azimuth), 0);
    const Eigen::Vector2d direction = (R_base_cam.transpose() * level_base).head<2>().normalized();
    const Eigen::Vector2d at = ring.centre_px + radii.At(v) * direction;
    return cv::Point2d(at.x(), at.y());
  };
}

/// A direction of the camera's frame, lowered to the mirror's rim where it is above it.
Eigen::Vector3d BelowRim(const HyperbolicMirror& mirror, const Eigen::Vector3d& direction_cam) {
  constexpr double kInsideRad = 1e-6;
  const double level = direction_cam.head<2>().norm();
  const double highest = mirror.RimElevation() - kInsideRad;
  if (!(level > 0) || std::atan2(direction_cam.z(), level) <= highest) return direction_cam;
  Eigen::Vector3d lowered;
  lowered << std::cos(highest) / level * direction_cam.head<2>(), std::sin(highest);
  return lowered;
}

/// Samples directions of the level robot through mirror and lens.
RemapTable::Source MirrorSource(const MountedCamera& omni,
                                const RowElevations& elevations,
                                const MirrorViewParams& params,
                                const std::optional<Tilt>& tilt = std::nullopt) {
  Eigen::Matrix3d R_cam_base = omni.T_base_cam.linear().transpose();
  if (tilt) R_cam_base = R_cam_base * tilt->T_level_base().linear().transpose();
  return [=, mirror = *omni.mirror, camera = omni.camera, columns = params.columns](
             int u, int v) -> std::optional<cv::Point2d> {
    const double azimuth = Azimuth(u, columns);
    const double elevation = elevations.At(v);
    const Eigen::Vector3d direction_base(std::cos(elevation) * std::cos(azimuth),
                                         std::cos(elevation) * std::sin(azimuth),
                                         std::sin(elevation));
    const Eigen::Vector3d direction_cam = R_cam_base * direction_base;
    const auto p_cam = mirror.Reflection(tilt ? BelowRim(mirror, direction_cam) : direction_cam);
    if (!p_cam) return std::nullopt;
    const auto at = camera.Project(*p_cam);
    if (!at) return std::nullopt;
    return cv::Point2d(at->x(), at->y());
  };
}

/// For a camera that points up: x_cam = y_base, y_cam = -x_base.
Eigen::Matrix3d FrontAtTop() {
  Eigen::Matrix3d R_base_cam;
  R_base_cam << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  return R_base_cam;
}

RemapTable TableFor(cv::Size raw,
                    cv::Size size,
                    const RemapTable::Source& source,
                    Interpolation interpolation) {
  return {raw, size, [&, nearest = interpolation == Interpolation::kNearest](int u, int v) {
            std::optional<cv::Point2d> at = source(u, v);
            if (at && nearest) at = {std::round(at->x), std::round(at->y)};
            return at;
          }};
}

}  // namespace

void MirrorViewParams::Validate() const {
  CheckRange("columns", columns, 8, 16384);
  CheckRange("rows", rows, 1, 4096);
  CheckElevation("highest_elevation_rad", highest_elevation_rad);
  CheckElevation("lowest_elevation_rad", lowest_elevation_rad);
}

MirrorView::MirrorView(const MountedCamera& omni, const MirrorViewParams& params)
    : raw_size_(omni.camera.Size()), size_(params.columns, params.rows) {
  params.Validate();
  const double tilt_rad = TiltOf(omni);
  if (omni.mirror_ring) {
    CheckRing(*omni.mirror_ring, params);
    size_.height = RowsOf(*omni.mirror_ring, params);
    MakeTable(RingSource(*omni.mirror_ring, omni.T_base_cam.linear(), params),
              params.interpolation);
    return;
  }
  if (!omni.mirror) {
    throw InputError("mirror camera: has no mirror; describe it in the rig (calib/README.md)");
  }
  const RowElevations elevations(omni, tilt_rad, params);
  size_.height = elevations.Rows();
  horizon_row_ = elevations.HorizonRow();
  MakeTable(MirrorSource(omni, elevations, params), params.interpolation);
  tilted_table_ = [=, raw = raw_size_, size = size_](const Tilt& tilt) {
    const RemapTable::Source source = MirrorSource(omni, elevations, params, tilt);
    return TableFor(raw, size, source, params.interpolation);
  };
}

MirrorView::MirrorView(cv::Size raw, const MirrorRing& ring, const MirrorViewParams& params)
    : raw_size_(raw), size_(params.columns, params.rows) {
  params.Validate();
  CheckRing(ring, params);
  size_.height = RowsOf(ring, params);
  MakeTable(RingSource(ring, FrontAtTop(), params), params.interpolation);
}

void MirrorView::MakeTable(const RemapTable::Source& source, Interpolation interpolation) {
  constexpr int kMaxImagePx = 16384;
  if (raw_size_.width < 2 || raw_size_.height < 2 || raw_size_.width > kMaxImagePx ||
      raw_size_.height > kMaxImagePx) {
    throw InputError(fmt::format("mirror camera: images of {} pixels, must be 2 x 2 to {} x {}",
                                 SizeText(raw_size_),
                                 kMaxImagePx,
                                 kMaxImagePx));
  }
  table_ = TableFor(raw_size_, size_, source, interpolation);
  if (cv::countNonZero(table_.Mask()) == size_.area()) return;
  throw InputError(
      fmt::format("mirror camera: parts of the panorama lie outside the mirror or the image of {} "
                  "pixels; take a smaller outer radius or a lower highest elevation",
                  SizeText(raw_size_)));
}

void MirrorView::CheckRaw(const cv::Mat& raw) const {
  if ((raw.type() != CV_8UC1 && raw.type() != CV_8UC3) || raw.size() != raw_size_) {
    throw InputError(
        fmt::format("mirror image of {} pixels, {}, must be {} and CV_8UC1 or CV_8UC3; use the rig "
                    "or ring of the camera that took it",
                    SizeText(raw.size()),
                    cv::typeToString(raw.type()),
                    SizeText(raw_size_)));
  }
}

void MirrorView::Unwrap(const cv::Mat& raw, cv::Mat& panorama) const {
  CheckRaw(raw);
  table_.Apply(raw, panorama);
}

void MirrorView::Unwrap(const cv::Mat& raw, const Tilt& tilt, cv::Mat& panorama) const {
  CheckRaw(raw);
  if (!tilted_table_) {
    throw InputError(
        "mirror camera: a tilt can be taken out only with a mirror of known shape; give its A, B "
        "and C in the rig");
  }
  if (tilt.pitch_rad == 0 && tilt.roll_rad == 0) {
    table_.Apply(raw, panorama);
  } else {
    tilted_table_(tilt).Apply(raw, panorama);
  }
}

}  // namespace ceilmap::calib
