#pragma once

#include <cstddef>
#include <string>

#include "app/figures/figure.hpp"
#include "app/figures/trajectory_figures.hpp"

/// Common parts of figures of several runs.
namespace ceilmap::figures {

namespace figure_runs {

/// First line style of runs, after the common ones.
inline constexpr int kFirstStyle = 11;
/// Settings that define a line style for each run.
std::string RunStyles(std::size_t runs);

/// File name of a run's data, for any name of the run.
std::string RunFile(std::size_t run);

/// One legend above all panels, with unchanged names.
inline constexpr const char* kLegendAbove =
    "  set key at screen 0.5,0.995 center top horizontal maxrows 2 samplen 3 width 2 noenhanced\n";

/// Unit for errors of a certain size.
struct LengthUnit {
  double per_unit = 1;  ///< of these in the trajectories' unit
  std::string name;
};
/// Millimetres, centimetres or metres; pixels for pixels.
LengthUnit UnitFor(double largest, const std::string& unit);

}  // namespace figure_runs

/// `distribution` and `segments` of TrajectoryFigures.
Figure DistributionFigure(const TrajectoryComparison& comparison,
                          const figure_runs::LengthUnit& unit);
Figure SegmentFigure(const TrajectoryComparison& comparison);

}  // namespace ceilmap::figures
