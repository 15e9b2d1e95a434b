#include "app/files/estimate_file.hpp"

#include <fmt/format.h>

#include "app/bags/bag_reader.hpp"
#include "app/files/bag_estimate.hpp"
#include "app/files/csv.hpp"
#include "app/files/tum.hpp"
#include "calib/base/degrees.hpp"
#include "calib/base/error.hpp"

namespace ceilmap::files {
namespace {

std::vector<evaluation::StampedHeading> StampedHeadings(const CsvTable& table) {
  const std::size_t stamp_column = table.Column("timestamp");
  const std::size_t heading_column = table.Column("heading_deg");
  std::vector<evaluation::StampedHeading> headings;
  headings.reserve(table.rows.size());
  for (const CsvTable::Row& row : table.rows) {
    const double stamp_s = table.Number(row, stamp_column);
    if (!headings.empty() && stamp_s <= headings.back().stamp_s) {
      throw InputError(fmt::format("{}: timestamp {} is not later than {} before it",
                                   table.Place(row),
                                   stamp_s,
                                   headings.back().stamp_s));
    }
    headings.push_back({stamp_s, kRadPerDeg * table.Number(row, heading_column)});
  }
  if (headings.empty()) throw InputError(fmt::format("{}: holds no headings", table.name));
  return headings;
}

Estimate ReadCsvEstimate(const std::filesystem::path& file) {
  Estimate estimate;
  const CsvTable table = ReadCsv(file);
  if (table.Has("heading_deg")) {
    estimate.headings = StampedHeadings(table);
    return estimate;
  }
  if (!table.Has("status") || !table.Has("yaw_deg")) {
    throw InputError(
        fmt::format("{}: has neither the columns of a status file (timestamp,status,x,y,yaw_deg, "
                    "...) nor of headings (timestamp,heading_deg)",
                    file.string()));
  }
  StatusRecord record = StatusIn(table);
  estimate.poses = std::move(record.poses);
  estimate.covariances.assign(record.covariances.begin(), record.covariances.end());
  estimate.frames_of_status = std::move(record.frames);
  estimate.placed = std::move(record.placed);
  estimate.unplaced = std::move(record.unplaced);
  if (estimate.poses.empty()) {
    throw InputError(fmt::format("{}: holds no poses", file.string()));
  }
  return estimate;
}

}  // namespace

void Estimate::Delay(double offset_s) {
  for (StampedPose& pose : poses) pose.stamp_s += offset_s;
  for (evaluation::StampedHeading& heading : headings) heading.stamp_s += offset_s;
  for (FrameStatus& frame : placed) frame.stamp_s += offset_s;
  for (FrameStatus& frame : unplaced) frame.stamp_s += offset_s;
}

Estimate ReadEstimate(const std::filesystem::path& file) {
  Estimate estimate;
  if (file.extension() == ".csv") {
    estimate = ReadCsvEstimate(file);
  } else if (bags::BagReader::IsBag(file)) {
    estimate = ReadBagEstimate(file);
  } else {
    estimate.poses = ReadTum(file);
  }
  if (!estimate.poses.empty()) estimate.headings = evaluation::HeadingsOf(estimate.poses);
  return estimate;
}

}  // namespace ceilmap::files
