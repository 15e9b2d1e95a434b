#include "app/heading_csv.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "app/csv.hpp"
#include "calib/error.hpp"

namespace ceilmap::app {
namespace {

double Number(const CsvTable& table, const CsvTable::Row& row, const char* column) {
  const std::string& field = row.fields[table.Column(column)];
  double number = 0;
  if (!ParseNumber(field, number) || !std::isfinite(number)) {
    throw calib::InputError(
        fmt::format("{}: {} '{}' is not a number", table.Place(row), column, field));
  }
  return number;
}

}  // namespace

std::vector<localization::HeadingSample> ReadHeadings(const std::filesystem::path& file) {
  constexpr double kRadPerDeg = std::numbers::pi / 180;
  const CsvTable table = ReadCsv(file);
  std::vector<localization::HeadingSample> samples;
  samples.reserve(table.rows.size());
  for (const CsvTable::Row& row : table.rows) {
    const localization::HeadingSample sample{Number(table, row, "timestamp"),
                                             kRadPerDeg * Number(table, row, "heading_deg"),
                                             kRadPerDeg * Number(table, row, "sigma_deg")};
    if (!(sample.sigma_rad > 0)) {
      throw calib::InputError(fmt::format("{}: sigma_deg must be > 0", table.Place(row)));
    }
    if (!samples.empty() && sample.stamp_s <= samples.back().stamp_s) {
      throw calib::InputError(fmt::format("{}: timestamp {} is not later than {} before it",
                                          table.Place(row),
                                          sample.stamp_s,
                                          samples.back().stamp_s));
    }
    samples.push_back(sample);
  }
  if (samples.empty()) throw calib::InputError(fmt::format("{}: holds no headings", table.name));
  return samples;
}

}  // namespace ceilmap::app
