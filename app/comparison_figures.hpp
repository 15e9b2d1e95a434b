#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/evaluation/trajectory_errors.hpp"
#include "app/figure.hpp"
#include "app/trajectory_figures.hpp"
#include "mapping/map_file.hpp"

namespace ceilmap::app {

/// From errors against the truth to figures of them.

/// An estimate's errors, and what it is called.
struct ComparedRun {
  std::string name;
  const evaluation::TrajectoryErrors* errors = nullptr;
};

/// The frame in which a comparison is shown.
enum class ShownFrame {
  kTruth,
  kFirstRun  ///< of the first run's own coordinates: there a map made with it lies
};

/// @param truth  that the errors are of. @param runs  at least one.
TrajectoryComparison ComparisonFor(const std::vector<evaluation::StampedPose>& truth,
                                   const std::vector<ComparedRun>& runs,
                                   ShownFrame frame);

/// A trajectory alone, without a truth: the way is its own.
std::vector<FigurePose> FigurePoses(const std::vector<evaluation::StampedPose>& poses);

/// Writes the map's mosaic into a folder as mosaic.png, at most 1600 pixels a side, white where
/// nobody looked.
/// @return nothing for a map without a mosaic. @throws calib::RunError when the disk refuses.
std::optional<FigureMosaic> WriteMosaic(const mapping::MapReader& map,
                                        const std::filesystem::path& folder);

}  // namespace ceilmap::app
