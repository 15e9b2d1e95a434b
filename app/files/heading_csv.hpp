#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "app/evaluation/heading_errors.hpp"
#include "app/files/csv.hpp"
#include "localization/compass/compass.hpp"
#include "localization/heading_track.hpp"

namespace ceilmap::files {

/// Reads measured headings: a CSV file with the columns `timestamp` in seconds, rising,
/// `heading_deg`, counter-clockwise seen from above, and `sigma_deg`, > 0; others are ignored.
/// @return at least one. @throws InputError naming file and line.
std::vector<HeadingSample> ReadHeadings(const std::filesystem::path& file);

/// The same of a table that was read.
std::vector<HeadingSample> HeadingsIn(const CsvTable& table);

/// A heading that was measured, and the frame that told it.
struct MeasuredHeading {
  std::int64_t frame = 0;  ///< in the recording, from 0
  double stamp_s = 0;
  compass::HeadingEstimate estimate;
};

/// What ReadHeadings reads: `timestamp,heading_deg,sigma_deg,confidence`, headings in (-180, 180];
/// with errors also `true_heading_deg,error_deg`, empty where there is no true pose. sigma_deg is
/// at least 0.001, which no compass can tell from the 0 of its first frame.
/// @param errors  of these headings, or null.
std::string FormatHeadings(const std::vector<MeasuredHeading>& headings,
                           const evaluation::HeadingErrors* errors);

}  // namespace ceilmap::files
