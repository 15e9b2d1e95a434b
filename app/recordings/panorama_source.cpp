#include "app/recordings/panorama_source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <map>
#include <opencv2/core.hpp>

#include "app/files/arguments.hpp"
#include "app/recordings/bag_rig.hpp"
#include "app/recordings/rig_warnings.hpp"
#include "app/terminal/clock.hpp"
#include "calib/base/error.hpp"
#include "localization/compass/labrosse/column_shift.hpp"

namespace ceilmap::recordings {
namespace {

constexpr int kMinColumns = 8;

const std::map<std::string, calib::PanoramaRows> kRowSpacings = {
    {"radius", calib::PanoramaRows::kRadius},
    {"pixel", calib::PanoramaRows::kPixelRadius},
    {"elevation", calib::PanoramaRows::kElevation},
    {"tangent", calib::PanoramaRows::kTanElevation}};

calib::MirrorViewParams ViewParams(const PanoramaOptions& options) {
  calib::MirrorViewParams params;
  if (options.columns) params.columns = *options.columns;
  if (options.rows) params.rows = *options.rows;
  if (options.interpolation == "nearest") params.interpolation = calib::Interpolation::kNearest;
  if (options.row_spacing) params.row_spacing = kRowSpacings.at(*options.row_spacing);
  return params;
}

struct PlacedView {
  calib::MirrorView view;
  Eigen::Vector2d position;  // base frame, m
  std::optional<calib::CameraScaling> scaling = {};
  std::optional<calib::Rig> rig = {};
};

PlacedView MakeView(const PanoramaOptions& options, const FrameSource& source) {
  const std::string place = options.ring.empty() ? options.rig.string() : "--ring " + options.ring;
  const calib::MirrorViewParams params = ViewParams(options);
  if (options.rig.empty()) {
    const calib::MirrorRing ring = ParseRing(options.ring, "--ring");
    try {
      return {calib::MirrorView(source.Size(), ring, params), Eigen::Vector2d::Zero()};
    } catch (const InputError& error) {
      throw InputError(fmt::format("{}: {}", place, error.what()));
    }
  }
  calib::Rig rig = calib::ReadRig(options.rig);
  const auto scaling = calib::FitOmniCamera(rig, source.Name(), source.Size());
  try {
    PlacedView placed{calib::MirrorView(*rig.omni, params),
                      rig.omni->T_base_cam.translation().head<2>(),
                      scaling};
    PrintRigWarnings(rig);
    PrintCameraDifference(options.omni, options.bags.Topic("omni"), "omni", *rig.omni, rig);
    placed.rig = std::move(rig);
    return placed;
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", place, error.what()));
  }
}

int CheckedFront(const PanoramaOptions& options, const FrameSource& source) {
  const int columns = source.Size().width;
  if (columns < kMinColumns || columns > compass::kMaxColumns) {
    throw InputError(fmt::format("{}: panoramas have {} columns, must be {} to {}",
                                 source.Name(),
                                 columns,
                                 kMinColumns,
                                 compass::kMaxColumns));
  }
  const int front = options.front_column.value_or(columns / 2);
  if (front < 0 || front >= columns) {
    throw InputError(fmt::format(
        "--front-column {}: must be in 0..{}, a column of {}", front, columns - 1, source.Name()));
  }
  return front;
}

}  // namespace

calib::MirrorRing ParseRing(const std::string& text, const std::string& option) {
  const std::optional<std::array<double, 4>> values = files::ParseFourNumbers(text);
  if (!values) {
    throw InputError(fmt::format(
        "{} {}: must be U,V,INNER,OUTER in pixels, e.g. 239.5,239.5,60,225", option, text));
  }
  const auto& [u, v, inner, outer] = *values;
  return {{u, v}, inner, outer};
}

void OrientPanorama(const cv::Mat& raw, bool rising, int front_column, cv::Mat& panorama) {
  const int columns = raw.cols;
  if (rising) {
    cv::flip(raw, panorama, 1);
    front_column = columns - 1 - front_column;
  } else {
    raw.copyTo(panorama);
  }
  const int right = (columns / 2 - front_column + columns) % columns;
  if (right == 0) return;
  const std::size_t pixel = panorama.elemSize();
  for (int v = 0; v < panorama.rows; ++v) {
    std::uint8_t* const row = panorama.ptr(v);
    std::rotate(row,
                row + static_cast<std::size_t>(columns - right) * pixel,
                row + static_cast<std::size_t>(columns) * pixel);
  }
}

void PanoramaOptions::AddTo(CLI::App& cli,
                            const std::string& input,
                            const std::string& unwrapping) {
  const auto add = [&cli](const char* name, auto& value, const char* text, const char* type) {
    return cli.add_option(name, value, text)->type_name(type);
  };
  add("--rig", rig, "The robot's cameras, including the mirror camera", "RIG.yaml")->group(input);
  add("--omni", omni, "Camera under a convex mirror", "SOURCE")->group(input);
  add("--panorama", panorama, "Instead of --omni: unwrapped images", "SOURCE")->group(input);
  add("--stamps", stamps, "Time of each frame: index,timestamp", "FRAMES.csv")->group(input);
  add("--azimuth",
      azimuth,
      "Counter-clockwise azimuth in --panorama, from left to right [falling]",
      "DIRECTION")
      ->check(CLI::IsMember({"falling", "rising"}))
      ->group(input);
  add("--front-column",
      front_column,
      "Column of --panorama that shows the robot's front [the middle]",
      "U")
      ->group(input);
  add("--ring", ring, "The mirror in the image, if there is no rig", "U,V,INNER,OUTER")
      ->group(unwrapping);
  add("--columns", columns, "Columns of the panorama [1080; labrosse: 360]", "N")
      ->group(unwrapping);
  add("--rows", rows, "Rows of the panorama [45]", "N")->group(unwrapping);
  add("--interpolation", interpolation, "nearest (\"not smooth\") or bilinear [bilinear]", "KIND")
      ->check(CLI::IsMember({"nearest", "bilinear"}))
      ->group(unwrapping);
  add("--row-spacing",
      row_spacing,
      "Quantity with equal steps per row; pixel: radius, a row per pixel; elevation and tangent "
      "need a mirror of known shape [elevation, radius]",
      "KIND")
      ->check(CLI::IsMember({"radius", "pixel", "elevation", "tangent"}))
      ->group(unwrapping);
}

void PanoramaOptions::Check() const {
  if (omni.empty() == panorama.empty()) {
    throw InputError(omni.empty() ? "no images: give --omni SOURCE or --panorama SOURCE"
                                  : "--omni and --panorama: give one of the two");
  }
  const auto refuse = [](bool given, const char* option, const char* why) {
    if (given) throw InputError(fmt::format("{}: {}; leave it out", option, why));
  };
  if (omni.empty()) {
    constexpr auto kWhy = "images of --panorama are already unwrapped";
    refuse(!rig.empty(), "--rig", kWhy);
    refuse(!ring.empty(), "--ring", kWhy);
    refuse(columns.has_value(), "--columns", kWhy);
    refuse(rows.has_value(), "--rows", kWhy);
    refuse(interpolation.has_value(), "--interpolation", kWhy);
    refuse(row_spacing.has_value(), "--row-spacing", kWhy);
    return;
  }
  refuse(azimuth.has_value(), "--azimuth", "is of --panorama");
  refuse(front_column.has_value(), "--front-column", "is of --panorama");
  refuse(rows && row_spacing == "pixel", "--rows", "follows from --row-spacing pixel");
  refuse(!ring.empty() && !rig.empty(), "--ring", "the mirror is described in --rig");
  if (ring.empty() && rig.empty()) {
    throw InputError("--omni: needs --rig RIG.yaml, or --ring U,V,INNER,OUTER without one");
  }
  if (!ring.empty()) ParseRing(ring, "--ring");
  const auto check_range =
      [](const char* option, const std::optional<int>& value, int least, int most) {
        if (!value || (*value >= least && *value <= most)) return;
        throw InputError(fmt::format("{} {}: must be in {}..{}", option, *value, least, most));
      };
  check_range("--columns", columns, kMinColumns, compass::kMaxColumns);
  check_range("--rows", rows, 1, 4096);
}

PanoramaSource::PanoramaSource(const PanoramaOptions& options)
    : source_(options.Source(),
              FrameSourceOptions{.pixels = Pixels::kColour,
                                 .stamps = options.stamps,
                                 .bag = options.bags.Topic("omni")}
                  .ForNewest()) {
  if (!options.omni.empty()) {
    PlacedView placed = MakeView(options, source_);
    view_ = std::move(placed.view);
    position_ = placed.position;
    scaling_ = placed.scaling;
    rig_ = std::move(placed.rig);
  } else {
    rising_ = options.azimuth == "rising";
    front_column_ = CheckedFront(options, source_);
  }
}

bool PanoramaSource::Read(const TiltAt& tilt_at) {
  if (!source_.Read(frame_)) return false;
  const auto start = std::chrono::steady_clock::now();
  if (view_) {
    const std::optional<Tilt> tilt = tilt_at ? tilt_at(frame_.stamp_s) : std::nullopt;
    if (tilt) {
      view_->Unwrap(frame_.image, *tilt, panorama_);
    } else {
      view_->Unwrap(frame_.image, panorama_);
    }
  } else {
    OrientPanorama(frame_.image, rising_, front_column_, panorama_);
  }
  unwrap_ms_ += terminal::MillisecondsSince(start);
  return true;
}

cv::Size PanoramaSource::Size() const {
  return view_ ? view_->Size() : source_.Size();
}

}  // namespace ceilmap::recordings
