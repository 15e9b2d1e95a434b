#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "app/files/csv.hpp"
#include "calib/base/weighted_pose.hpp"
#include "localization/robot/estimate.hpp"

namespace ceilmap::files {

/// The output of `localize --hypotheses`: `timestamp,x,y,yaw_deg,weight`, a line for each place
/// where the robot may be while its status is `ambiguous`; metres, weights of a time sum to 1.
std::string_view HypothesesHeader();
/// Lines of a frame; none for another status, or where no place fits.
std::string FormatHypotheses(const robot::Estimate& estimate);

/// Places of one time.
struct StampedHypotheses {
  double stamp_s = 0;
  std::vector<WeightedPose> places;  ///< at least one
};

/// Columns may have any order.
/// @return stamps strictly increasing; at least one.
/// @throws InputError naming file and line, also on a weight that is not > 0.
std::vector<StampedHypotheses> ReadHypotheses(const std::filesystem::path& file);

/// The same from a table.
std::vector<StampedHypotheses> HypothesesIn(const CsvTable& table);

}  // namespace ceilmap::files
