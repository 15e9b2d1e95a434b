#include "app/files/control_points_csv.hpp"

#include <fmt/format.h>

#include "app/files/csv.hpp"
#include "app/files/text_file.hpp"
#include "calib/base/error.hpp"

namespace ceilmap::files {

PickedPoints ReadControlPoints(const std::filesystem::path& file) {
  return ParseControlPoints(ReadTextFile(file), file.string());
}

PickedPoints ParseControlPoints(const std::string& text, const std::string& name) {
  const CsvTable table = ParseCsv(text, name);
  PickedPoints picked;
  picked.in_pixels = table.Has("col") || table.Has("row");
  if (picked.in_pixels && (table.Has("x") || table.Has("y"))) {
    throw InputError(
        fmt::format("{}: has columns x,y and col,row; give the places in the map or the pixels of "
                    "its mosaic, not both",
                    name));
  }
  const std::size_t label = table.Column("name");
  const std::size_t x = table.Column(picked.in_pixels ? "col" : "x");
  const std::size_t y = table.Column(picked.in_pixels ? "row" : "y");
  const std::size_t site_x = table.Column("site_x");
  const std::size_t site_y = table.Column("site_y");
  for (const CsvTable::Row& row : table.rows) {
    survey::ControlPoint point;
    point.name = row.fields[label];
    if (point.name.empty()) {
      throw InputError(fmt::format("{}: the point has no name", table.Place(row)));
    }
    point.p_map = {table.Number(row, x), table.Number(row, y)};
    point.p_site = {table.Number(row, site_x), table.Number(row, site_y)};
    if (table.Has("sigma_m") && !row.fields[table.Column("sigma_m")].empty()) {
      point.sigma_m = table.Number(row, table.Column("sigma_m"));
      if (!(point.sigma_m > 0)) {
        throw InputError(fmt::format(
            "{}: sigma_m = {}, must be > 0 metres, or empty", table.Place(row), point.sigma_m));
      }
    }
    picked.points.push_back(std::move(point));
  }
  if (picked.points.empty()) {
    throw InputError(fmt::format("{}: holds no points, only the header", name));
  }
  return picked;
}

}  // namespace ceilmap::files
