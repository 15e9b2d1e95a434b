#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/evaluation/compensation.hpp"
#include "app/evaluation/trajectory_errors.hpp"
#include "app/figures/figure.hpp"
#include "app/figures/trajectory_figures.hpp"
#include "app/terminal/summary.hpp"
#include "mapping/store/map_file.hpp"

namespace ceilmap::reports {

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

/// That frame, from the frame of the truth.
evaluation::PlanarSimilarity T_shown_truth(const std::vector<ComparedRun>& runs, ShownFrame frame);

/// @param truth  that the errors are of. @param runs  at least one.
figures::TrajectoryComparison ComparisonFor(const std::vector<StampedPose>& truth,
                                            const std::vector<ComparedRun>& runs,
                                            ShownFrame frame);

/// Where the robot was without tilt compensation, for TrajectoryComparison::before.
std::vector<figures::FigurePose> FigurePosesBefore(
    const std::vector<StampedPose>& truth,
    const evaluation::Compensation& compensation,
    const evaluation::PlanarSimilarity& T_shown_truth);

/// A trajectory alone, without a truth: the way is its own. Empty for none.
std::vector<figures::FigurePose> FigurePoses(const std::vector<StampedPose>& poses);

/// Writes the map's mosaic into a folder as mosaic.png, pale, at most 1600 pixels a side, white
/// where nobody looked.
/// @return nothing for a map without a mosaic. @throws RunError when the disk refuses.
std::optional<figures::FigureMosaic> WriteMosaic(const store::MapReader& map,
                                                 const std::filesystem::path& folder);

/// Draws TrajectoryFigures into a folder, over the map's mosaic.
/// @param map  that all paths are on; null: paper. @param summary  gets the files.
/// Without gnuplot there is a warning and no figure. @throws as FigureFolder.
void DrawTrajectoryFigures(figures::TrajectoryComparison comparison,
                           const store::MapReader* map,
                           const std::filesystem::path& folder,
                           terminal::Summary& summary);

}  // namespace ceilmap::reports
