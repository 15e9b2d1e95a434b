#pragma once

#include <cstddef>
#include <string>

#include "app/figures/figure.hpp"
#include "app/figures/trajectory_figures.hpp"

/// What figures of several runs have in common.
namespace ceilmap::figures {

namespace figure_runs {

/// Line styles of runs begin here, after those of the house.
inline constexpr int kFirstStyle = 11;
/// Settings that define a style for each run.
std::string RunStyles(std::size_t runs);

/// Name of a run's data, whatever the run is called.
std::string RunFile(std::size_t run);

/// One legend above all panels, with names as they are.
inline constexpr const char* kLegendAbove =
    "  set key at screen 0.5,0.995 center top horizontal maxrows 2 samplen 3 width 2 noenhanced\n";

/// How errors of a size are told.
struct LengthUnit {
  double per_unit = 1;  ///< of these in the trajectories' unit
  std::string name;
};
/// Millimetres, centimetres or metres; pixels stay pixels.
LengthUnit UnitFor(double largest, const std::string& unit);

}  // namespace figure_runs

/// `distribution` and `segments` of TrajectoryFigures.
Figure DistributionFigure(const TrajectoryComparison& comparison,
                          const figure_runs::LengthUnit& unit);
Figure SegmentFigure(const TrajectoryComparison& comparison);

}  // namespace ceilmap::figures
