#include "app/files/hypotheses_csv.hpp"

#include <fmt/format.h>

#include "calib/base/degrees.hpp"
#include "calib/base/error.hpp"

namespace ceilmap::files {

std::string_view HypothesesHeader() {
  return "timestamp,x,y,yaw_deg,weight\n";
}

std::string FormatHypotheses(const robot::Estimate& estimate) {
  std::string text;
  if (estimate.status != robot::TrackingStatus::kAmbiguous) return text;
  for (const WeightedPose& place : estimate.places) {
    text += fmt::format("{:.6f},{:.6f},{:.6f},{:.5f},{:.3g}\n",
                        estimate.stamp_s,
                        place.pose.x,
                        place.pose.y,
                        kDegPerRad * place.pose.yaw,
                        place.weight);
  }
  return text;
}

std::vector<StampedHypotheses> ReadHypotheses(const std::filesystem::path& file) {
  return HypothesesIn(ReadCsv(file));
}

std::vector<StampedHypotheses> HypothesesIn(const CsvTable& table) {
  const std::size_t stamp = table.Column("timestamp");
  const std::size_t x = table.Column("x");
  const std::size_t y = table.Column("y");
  const std::size_t yaw = table.Column("yaw_deg");
  const std::size_t weight = table.Column("weight");
  std::vector<StampedHypotheses> all;
  for (const CsvTable::Row& row : table.rows) {
    const double stamp_s = table.Number(row, stamp);
    const WeightedPose place{
        {table.Number(row, x), table.Number(row, y), kRadPerDeg * table.Number(row, yaw)},
        table.Number(row, weight)};
    if (!(place.weight > 0)) {
      throw InputError(fmt::format("{}: weight must be > 0", table.Place(row)));
    }
    if (all.empty() || stamp_s > all.back().stamp_s) {
      all.push_back({stamp_s, {}});
    } else if (stamp_s < all.back().stamp_s) {
      throw InputError(fmt::format("{}: timestamp {} is earlier than {} before it",
                                   table.Place(row),
                                   stamp_s,
                                   all.back().stamp_s));
    }
    all.back().places.push_back(place);
  }
  if (all.empty()) throw InputError(fmt::format("{}: holds no hypotheses", table.name));
  return all;
}

}  // namespace ceilmap::files
