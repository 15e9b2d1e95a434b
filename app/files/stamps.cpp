#include "app/files/stamps.hpp"

#include <fmt/format.h>

#include <cmath>

#include "app/files/text_file.hpp"
#include "calib/base/error.hpp"
#include "calib/base/one_line.hpp"

namespace ceilmap::files {

std::vector<double> ReadStamps(const std::filesystem::path& file) {
  return StampsIn(ReadCsv(file));
}

std::vector<double> StampsIn(const CsvTable& table) {
  const std::size_t index_column = table.Column("index");
  const std::size_t stamp_column = table.Column("timestamp");
  std::vector<double> stamps_s;
  double previous_index = 0;
  for (const CsvTable::Row& row : table.rows) {
    double index = 0;
    double stamp_s = 0;
    if (!ParseNumber(row.fields[index_column], index) || !std::isfinite(index) ||
        index != std::floor(index)) {
      throw InputError(fmt::format("{}: index '{}' is not a whole number",
                                   table.Place(row),
                                   Shown(row.fields[index_column])));
    }
    if (!ParseNumber(row.fields[stamp_column], stamp_s) || !std::isfinite(stamp_s)) {
      throw InputError(fmt::format(
          "{}: timestamp '{}' is not a number", table.Place(row), Shown(row.fields[stamp_column])));
    }
    if (!stamps_s.empty() && index != previous_index + 1) {
      throw InputError(fmt::format("{}: index {} after {}; every frame needs one line",
                                   table.Place(row),
                                   index,
                                   previous_index));
    }
    if (!stamps_s.empty() && stamp_s <= stamps_s.back()) {
      throw InputError(fmt::format("{}: timestamp {} is not later than {} before it",
                                   table.Place(row),
                                   stamp_s,
                                   stamps_s.back()));
    }
    previous_index = index;
    stamps_s.push_back(stamp_s);
  }
  if (stamps_s.empty()) throw InputError(fmt::format("{}: holds no stamps", table.name));
  return stamps_s;
}

}  // namespace ceilmap::files
