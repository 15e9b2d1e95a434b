// Heights of a map compared with known points of the ceiling:
//   ceilmap_heights_bench MAP.gpkg POINTS.csv TRUTH.tum [--all]
// POINTS.csv has the columns name,x,y,z in the frame of TRUTH.tum, metres above the floor. The map
// is aligned by its trajectory. Errors are those of the height above the camera, relative to it:
//   images  where a point is seen in the keyframes' images: the median of the cells there, each
//           weighted by its accuracy
//   raster  at the point's place in the plan, as `export --format heights` and the page show it:
//   the
//           lowest of several things one above the other
// `--all` lists each point. Exits with 1 when a bound of `images` is broken.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "app/evaluation/alignment.hpp"
#include "app/evaluation/association.hpp"
#include "app/files/csv.hpp"
#include "app/files/tum.hpp"
#include "calib/base/error.hpp"
#include "mapping/mosaic/floor_heights.hpp"

namespace ceilmap::bench {
namespace {

constexpr double kMaxMedian = 3;  // per cent
constexpr double kMaxError90 = 8;

struct Point {
  std::string name;
  Eigen::Vector2d p_map;
  double z_m = 0;  // above the floor
};

struct Result {
  std::optional<double> in_images;  // relative error, with its sign; > 0: the map is too high
  std::optional<double> in_raster;
  int images = 0;  // with a measured cell at the point
};

std::string KindOf(const std::string& name) {
  return name.substr(0, name.find_last_not_of("0123456789-_") + 1);
}

/// T_map_truth by the trajectories.
Pose2 AlignMap(const store::MapReader& map, const std::vector<StampedPose>& truth) {
  std::vector<StampedPose> mapped;
  for (const graph::FramePose& frame : map.ReadTrajectory()) {
    mapped.push_back(ToStampedPose(frame.stamp_s, frame.T_map_base, frame.tilt));
  }
  constexpr double kMaxGap_s = 0.002;
  std::vector<PointPair> pairs;
  for (const auto& [t, m] : evaluation::MatchStamps(truth, mapped, kMaxGap_s)) {
    pairs.push_back({mapped[m].position.head<2>(), truth[t].position.head<2>()});
  }
  if (pairs.empty()) throw InputError("no stamps in common with the truth");
  return evaluation::FitPlanarMotion(pairs);
}

std::vector<Point> ReadPoints(const std::string& file, const Pose2& T_map_truth) {
  const files::CsvTable table = files::ReadCsv(file);
  const std::size_t name = table.Column("name");
  std::vector<Point> points;
  for (const files::CsvTable::Row& row : table.rows) {
    const Eigen::Vector2d p_truth(table.Number(row, table.Column("x")),
                                  table.Number(row, table.Column("y")));
    points.push_back(
        {row.fields[name], T_map_truth * p_truth, table.Number(row, table.Column("z"))});
  }
  return points;
}

class Comparison {
 public:
  explicit Comparison(const store::MapReader& map)
      : metadata_(map.Metadata()),
        keyframes_(map.ReadKeyframes()),
        views_(mosaic::PlaceViews(keyframes_, metadata_)),
        raster_(keyframes_, metadata_),
        camera_m_(metadata_.ceiling_height_m -
                  metadata_.view_focal_px * metadata_.view_units_per_px) {
    if (raster_.empty()) throw InputError("the map has no heights in metres");
  }

  [[nodiscard]] Result Compare(const Point& point) const {
    Result result;
    const store::MosaicGrid pixel{point.p_map.x() - 0.5e-3, point.p_map.y() + 0.5e-3, 1e-3, 1, 1};
    const float height = raster_.Window(pixel, {0, 0, 1, 1}).at<float>(0, 0);
    if (!std::isnan(height)) result.in_raster = Error(height, point);
    std::vector<std::array<double, 2>> seen;  // height, weight
    for (std::size_t k = 0; k < keyframes_.size(); ++k) {
      const std::optional<heights::HeightCell> cell = CellAt(k, point);
      if (!cell) continue;
      seen.push_back({*store::HeightAboveFloor(metadata_, cell->rho), 1 / cell->sigma});
    }
    result.images = static_cast<int>(seen.size());
    if (!seen.empty()) result.in_images = Error(WeightedMedian(seen), point);
    return result;
  }

 private:
  [[nodiscard]] double Error(double height_m, const Point& point) const {
    return (height_m - point.z_m) / (point.z_m - camera_m_);
  }

  static double WeightedMedian(std::vector<std::array<double, 2>>& values) {
    std::sort(values.begin(), values.end());
    double half = 0;
    for (const auto& [value, weight] : values) half += 0.5 * weight;
    for (const auto& [value, weight] : values) {
      half -= weight;
      if (half <= 0) return value;
    }
    return values.back()[0];
  }

  /// The measured cell of a keyframe in which the point is seen.
  [[nodiscard]] std::optional<heights::HeightCell> CellAt(std::size_t k, const Point& point) const {
    if (!keyframes_[k].heights) return std::nullopt;
    const heights::HeightField& field = *keyframes_[k].heights;
    const double rho =
        metadata_.view_focal_px * metadata_.view_units_per_px / (point.z_m - camera_m_);
    const cv::Point2d at = views_[k].ToPixel(point.p_map.x(), point.p_map.y(), rho);
    const cv::Size size = metadata_.view_size;
    const std::optional<std::size_t> cell =
        field.CellAt({at.x - (size.width - 1) / 2.0, at.y - (size.height - 1) / 2.0});
    if (!cell || field.cells[*cell].sigma >= heights::kMeasuredSigma) return std::nullopt;
    return field.cells[*cell];
  }

  store::MapMetadata metadata_;
  std::vector<graph::Keyframe> keyframes_;
  std::vector<mosaic::ViewPlacement> views_;
  mosaic::FloorHeights raster_;
  double camera_m_;
};

double Quantile(std::vector<double> values, double part) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(part * static_cast<double>(values.size() - 1) + 0.5)];
}

struct Sizes {
  double median = 0;
  double largest90 = 0;  // 90th percentile
};

/// Of the known errors; prints them.
Sizes Print(const std::vector<Result>& results, std::optional<double> Result::*error) {
  std::vector<double> sizes;
  for (const Result& result : results) {
    if (result.*error) sizes.push_back(100 * std::abs(*(result.*error)));
  }
  if (sizes.empty()) {
    fmt::print("{:>7} {:>9} {:>9}", 0, "", "");
    return {};
  }
  const Sizes all = {Quantile(sizes, 0.5), Quantile(sizes, 0.9)};
  fmt::print("{:>7} {:>9.1f} {:>9.1f}", sizes.size(), all.median, all.largest90);
  return all;
}

Sizes PrintRow(const std::string& name, const std::vector<Result>& results) {
  fmt::print("{:<12} {:>7} ", name, results.size());
  const Sizes in_images = Print(results, &Result::in_images);
  fmt::print("  ");
  Print(results, &Result::in_raster);
  fmt::print("\n");
  return in_images;
}

int Run(const std::string& map_file,
        const std::string& points_file,
        const std::string& truth,
        bool list) {
  const store::MapReader map(map_file);
  const Comparison comparison(map);
  std::map<std::string, std::vector<Result>> kinds;
  std::vector<Result> all;
  for (const Point& point : ReadPoints(points_file, AlignMap(map, files::ReadTum(truth)))) {
    all.push_back(comparison.Compare(point));
    const Result& result = all.back();
    kinds[KindOf(point.name)].push_back(result);
    if (!list) continue;
    const double unknown = std::nan("");
    fmt::print(
        "{:<14} at ({:6.2f}, {:6.2f}), {:.2f} m: error in {:2} images {:>+6.1f} %, in the "
        "raster {:>+6.1f} %\n",
        point.name,
        point.p_map.x(),
        point.p_map.y(),
        point.z_m,
        result.images,
        100 * result.in_images.value_or(unknown),
        100 * result.in_raster.value_or(unknown));
  }
  const std::string names = fmt::format("{:>7} {:>9} {:>9}", "known", "median", "90th");
  fmt::print("{:<12} {:>7} {:>27}  {:>27}\n", "", "", "images: error, %", "raster: error, %");
  fmt::print("{:<12} {:>7} {}  {}\n", "", "points", names, names);
  for (const auto& [kind, results] : kinds) PrintRow(kind, results);
  const Sizes sizes = PrintRow("all", all);
  return sizes.median <= kMaxMedian && sizes.largest90 <= kMaxError90 ? 0 : 1;
}

}  // namespace
}  // namespace ceilmap::bench

int main(int argc, char** argv) {
  const bool list = argc == 5 && std::string(argv[4]) == "--all";
  if (argc != 4 && !list) {
    fmt::print(stderr, "usage: ceilmap_heights_bench MAP.gpkg POINTS.csv TRUTH.tum [--all]\n");
    return 2;
  }
  try {
    return ceilmap::bench::Run(argv[1], argv[2], argv[3], list);
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 2;
  }
}
