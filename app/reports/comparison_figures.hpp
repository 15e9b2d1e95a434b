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

/// Creates figures from errors.

/// Errors of an estimate, and its name.
struct ComparedRun {
  std::string name;
  const evaluation::TrajectoryErrors* errors = nullptr;
};

/// Frame of the figures of a comparison.
enum class ShownFrame {
  kTruth,
  kFirstRun  ///< frame of the first run, which is that of its map
};

/// The transform to that frame from the frame of the truth.
/// @param S_shown_run  With kFirstRun: and from there to the frame that is shown.
Similarity2 T_shown_truth(const std::vector<ComparedRun>& runs,
                          ShownFrame frame,
                          const Similarity2& S_shown_run = {});

/// @param truth  Reference of the errors. @param runs  At least one.
figures::TrajectoryComparison ComparisonFor(const std::vector<StampedPose>& truth,
                                            const std::vector<ComparedRun>& runs,
                                            const Similarity2& T_shown_truth);

/// Poses without tilt compensation, for TrajectoryComparison::before.
std::vector<figures::FigurePose> FigurePosesBefore(const std::vector<StampedPose>& truth,
                                                   const evaluation::Compensation& compensation,
                                                   const Similarity2& T_shown_truth);

/// A trajectory without a truth: distances are along its own path. Empty for none.
std::vector<figures::FigurePose> FigurePoses(const std::vector<StampedPose>& poses);

/// Writes the map's mosaic into a folder as mosaic.png, bright, at most 1600 pixels wide and high,
/// unmapped areas white.
/// @return nothing for a map without a mosaic. @throws RunError when the disk cannot be written.
std::optional<figures::FigureMosaic> WriteMosaic(const store::MapReader& map,
                                                 const std::filesystem::path& folder);

/// Draws TrajectoryFigures into a folder, over the map's mosaic.
/// @param map  Of all paths; null: no mosaic. @param summary  The files are added to it.
/// Without gnuplot there is a warning and no figure. @throws as FigureFolder.
void DrawTrajectoryFigures(figures::TrajectoryComparison comparison,
                           const store::MapReader* map,
                           const std::filesystem::path& folder,
                           terminal::Summary& summary);

}  // namespace ceilmap::reports
