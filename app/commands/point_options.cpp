#include "app/commands/point_options.hpp"

#include <fmt/format.h>

#include "app/files/control_points_csv.hpp"
#include "calib/base/error.hpp"
#include "calib/base/one_line.hpp"
#include "mapping/store/crs.hpp"

namespace ceilmap::commands {

CLI::Option* PointOptions::AddTo(CLI::App& cli) {
  CLI::Option* option =
      cli.add_option("--points",
                     points,
                     "Points in the map and the building: name,x,y,site_x,site_y[,sigma_m], or "
                     "with pixels of the mosaic name,col,row,site_x,site_y[,sigma_m]")
          ->type_name("POINTS.csv");
  cli.add_option(
         "--crs", crs, "Coordinate reference system of the building, in metres [a local one]")
      ->needs(option)
      ->type_name("EPSG:N|WKT");
  cli.add_option("--sigma",
                 params.sigma_m,
                 "Standard deviation of points that state none: picking, survey and map together")
      ->capture_default_str()
      ->needs(option)
      ->type_name("M");
  return option;
}

void PointOptions::Check() const {
  params.Validate();
  (void)CrsWkt();  // checks it
}

std::string PointOptions::CrsWkt() const {
  return crs.empty() ? "" : store::ParseCrs(crs);
}

std::vector<survey::ControlPoint> PointOptions::Read(const store::MosaicGrid& grid) const {
  files::PickedPoints picked = files::ReadControlPoints(points);
  if (!picked.in_pixels) return std::move(picked.points);
  if (grid.width_px == 0) {
    throw InputError(
        fmt::format("{}: gives pixels (col,row), but the map holds no mosaic", points.string()));
  }
  for (survey::ControlPoint& point : picked.points) {
    const Eigen::Vector2d px = point.p_map;
    if (px.x() < -0.5 || px.y() < -0.5 || px.x() > grid.width_px - 0.5 ||
        px.y() > grid.height_px - 0.5) {
      throw InputError(fmt::format("{}: point '{}' lies outside the mosaic of {} x {} pixels",
                                   points.string(),
                                   Shown(point.name),
                                   grid.width_px,
                                   grid.height_px));
    }
    point.p_map = store::PixelToMap(grid, px);
  }
  return std::move(picked.points);
}

}  // namespace ceilmap::commands
