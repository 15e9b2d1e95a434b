// Heights of a map compared with known points of the ceiling:
//   ceilmap_heights_bench MAP.gpkg POINTS.csv TRUTH.tum [--all]
// POINTS.csv has the columns name,x,y,z in the frame of TRUTH.tum, metres above the floor. The map
// is aligned by its trajectory. The height of a point is that of the map's raster, as `export
// --format heights` and the page show it. Errors are those of the height above the camera, relative
// to it. `cells agree` is the fraction of the measured cells of all keyframes within half a cell of
// the point that have its height within 8 %: low where the point is missed in the images, not by
// the raster. `--all` lists each point. Exits with 1 when a bound is broken.

#include <fmt/format.h>

#include <algorithm>
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

constexpr double kMaxMedian = 0.03;
constexpr double kMaxError90 = 0.08;

struct Point {
  std::string name;
  Eigen::Vector2d p_map;
  double z_m = 0;  // above the floor
};

struct Result {
  std::optional<double> error;  // relative, with its sign; > 0: the map is too high
  int cells = 0;
  int agree = 0;
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
  std::vector<evaluation::PointPair> pairs;
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
    if (!std::isnan(height)) result.error = Error(height, point);
    for (std::size_t k = 0; k < keyframes_.size(); ++k) CountCells(k, point, result);
    return result;
  }

 private:
  [[nodiscard]] double Error(double height_m, const Point& point) const {
    return (height_m - point.z_m) / (point.z_m - camera_m_);
  }

  void CountCells(std::size_t k, const Point& point, Result& result) const {
    if (!keyframes_[k].heights) return;
    const heights::HeightField& field = *keyframes_[k].heights;
    const cv::Size size = metadata_.view_size;
    for (std::size_t i = 0; i < field.cells.size(); ++i) {
      const heights::HeightCell& cell = field.cells[i];
      if (cell.sigma >= heights::kMeasuredSigma) continue;
      const Eigen::Vector2d centre = field.Centre(i);
      const cv::Point2d at = views_[k].ToMap(
          (size.width - 1) / 2.0 + centre.x(), (size.height - 1) / 2.0 + centre.y(), cell.rho);
      const double reach = 0.5 * field.step_px.maxCoeff() * metadata_.view_units_per_px / cell.rho;
      if (std::hypot(at.x - point.p_map.x(), at.y - point.p_map.y()) > reach) continue;
      ++result.cells;
      const double error = Error(*store::HeightAboveFloor(metadata_, cell.rho), point);
      result.agree += std::abs(error) <= kMaxError90 ? 1 : 0;
    }
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

/// Of the sizes of errors; sets `good` to false when a bound is broken.
void Print(const std::string& kind, const std::vector<Result>& results, bool& good) {
  std::vector<double> sizes;
  std::vector<double> errors;
  int cells = 0;
  int agree = 0;
  for (const Result& result : results) {
    cells += result.cells;
    agree += result.agree;
    if (!result.error) continue;
    errors.push_back(*result.error);
    sizes.push_back(std::abs(*result.error));
  }
  const double part = cells > 0 ? 100.0 * agree / cells : 0;
  if (sizes.empty()) {
    fmt::print("{:<12} {:>7} {:>6}\n", kind, results.size(), 0);
    return;
  }
  const double median = Quantile(sizes, 0.5);
  const double error90 = Quantile(sizes, 0.9);
  fmt::print("{:<12} {:>7} {:>6} {:>+9.1f} {:>9.1f} {:>9.1f} {:>12.0f}\n",
             kind,
             results.size(),
             sizes.size(),
             100 * Quantile(errors, 0.5),
             100 * median,
             100 * error90,
             part);
  good = median <= kMaxMedian && error90 <= kMaxError90;
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
    fmt::print(
        "{:<14} at ({:6.2f}, {:6.2f}), {:.2f} m above the floor: error {:>+6.1f} %, {} of {} "
        "cells agree\n",
        point.name,
        point.p_map.x(),
        point.p_map.y(),
        point.z_m,
        100 * result.error.value_or(std::nan("")),
        result.agree,
        result.cells);
  }
  fmt::print("{:<12} {:>7} {:>6} {:>9} {:>9} {:>9} {:>12}\n",
             "",
             "points",
             "known",
             "median %",
             "|median|",
             "90th %",
             "cells agree %");
  bool good = false;
  for (const auto& [kind, results] : kinds) Print(kind, results, good);
  good = false;
  Print("all", all, good);
  return good ? 0 : 1;
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
