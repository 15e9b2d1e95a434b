#include "app/figures/trajectory_figures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/figures/figure_runs.hpp"

namespace ceilmap::figures {

using figure_runs::kFirstStyle;
using figure_runs::kLegendAbove;
using figure_runs::LengthUnit;
using figure_runs::RunFile;
using figure_runs::RunStyles;
using figure_runs::UnitFor;

namespace {

double LargestError(const TrajectoryComparison& comparison) {
  double largest = 0;
  for (const FigureRun& run : comparison.runs) {
    for (const FigurePose& pose : run.poses) largest = std::max(largest, pose.position_error_m);
  }
  return largest;
}

// Time without a pose after which a line is interrupted, s.
double GapOf(const std::vector<FigurePose>& poses) {
  std::vector<double> steps;
  steps.reserve(poses.size());
  for (std::size_t i = 1; i < poses.size(); ++i) {
    steps.push_back(poses[i].time_s - poses[i - 1].time_s);
  }
  if (steps.empty()) return 0;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  constexpr double kMissing = 5.5;
  return kMissing * *middle;
}

std::string PoseLine(const FigurePose& pose) {
  return fmt::format("{:.6f},{:.4f},{:.6f},{:.6f},{:.5f},{:.5f},{:.5f},{:.7f},{:.6f}\n",
                     pose.time_s,
                     pose.distance_m,
                     pose.x,
                     pose.y,
                     pose.yaw_deg,
                     pose.pitch_deg,
                     pose.roll_deg,
                     pose.position_error_m,
                     pose.yaw_error_deg);
}

std::string PosesData(const std::vector<FigurePose>& poses) {
  std::string text = "time_s,way_m,x,y,yaw_deg,pitch_deg,roll_deg,position_error_m,yaw_error_deg\n";
  constexpr std::size_t kMaxStretches = 2000;
  const std::size_t length = (poses.size() + kMaxStretches - 1) / kMaxStretches;
  const double gap_s = GapOf(poses);
  for (std::size_t first = 0; first < poses.size(); first += length) {
    const std::size_t end = std::min(first + length, poses.size());
    const auto begin = poses.begin() + static_cast<std::ptrdiff_t>(first);
    const auto worst = std::max_element(begin,
                                        poses.begin() + static_cast<std::ptrdiff_t>(end),
                                        [](const FigurePose& a, const FigurePose& b) {
                                          return a.position_error_m < b.position_error_m;
                                        });
    // A blank line interrupts a line in gnuplot.
    if (first > 0 && poses[first].time_s - poses[first - 1].time_s > gap_s) text += '\n';
    text += PoseLine(*begin);
    if (worst != begin) text += PoseLine(*worst);
  }
  return text;
}

// Curves below the runs.
struct Under {
  bool truth = false;
  bool before = false;
};

// These, then one curve per run. @param columns  For gnuplot's using.
std::string Curves(const TrajectoryComparison& comparison,
                   const std::string& columns,
                   Under under,
                   bool titles) {
  std::string text = "  plot \\\n";
  if (under.truth && !comparison.truth.empty()) {
    text += fmt::format("    'truth.csv' skip 1 using {} with lines ls 6 {}, \\\n",
                        columns,
                        titles ? "title 'truth'" : "notitle");
  }
  if (under.before && !comparison.before.empty()) {
    text += fmt::format(
        "    'before.csv' skip 1 using {} with lines lc rgb '#666666' lw 1.6 dt (6,4) {}, \\\n",
        columns,
        titles ? "title 'before compensation'" : "notitle");
  }
  for (std::size_t i = 0; i < comparison.runs.size(); ++i) {
    text += fmt::format("    '{}' skip 1 using {} with lines ls {} {}{}\n",
                        RunFile(i),
                        columns,
                        static_cast<std::size_t>(kFirstStyle) + i,
                        titles ? "title " + GnuplotQuote(comparison.runs[i].name) : "notitle",
                        i + 1 < comparison.runs.size() ? ", \\" : "");
  }
  return text;
}

struct Extent {
  double min_x = 0;
  double max_x = 0;
  double min_y = 0;
  double max_y = 0;
};
Extent ExtentOf(const TrajectoryComparison& comparison) {
  const FigurePose& first = comparison.runs.front().poses.front();
  Extent extent{first.x, first.x, first.y, first.y};
  const auto take = [&extent](const std::vector<FigurePose>& poses) {
    for (const FigurePose& pose : poses) {
      extent.min_x = std::min(extent.min_x, pose.x);
      extent.max_x = std::max(extent.max_x, pose.x);
      extent.min_y = std::min(extent.min_y, pose.y);
      extent.max_y = std::max(extent.max_y, pose.y);
    }
  };
  take(comparison.truth);
  take(comparison.before);
  for (const FigureRun& run : comparison.runs) take(run.poses);
  const double margin =
      0.06 * std::max({extent.max_x - extent.min_x, extent.max_y - extent.min_y, 1e-3});
  return {
      extent.min_x - margin, extent.max_x + margin, extent.min_y - margin, extent.max_y + margin};
}

// Settings and size of a figure with equal scales of both axes.
struct MapFrame {
  int width_px = 0;
  int height_px = 0;
  std::string settings;
};
MapFrame FrameFor(const Extent& extent, const std::string& unit) {
  constexpr double kAside = 90;
  constexpr double kLongest = 800;
  const double span_x = extent.max_x - extent.min_x;
  const double span_y = extent.max_y - extent.min_y;
  const double scale = kLongest / std::max(span_x, span_y);
  constexpr double kMin = 260;
  return {static_cast<int>(kAside + std::max(kMin, scale * span_x)),
          static_cast<int>(kAside + std::max(kMin, scale * span_y)),
          fmt::format("set size ratio -1\nset xrange [{:.6g}:{:.6g}]\nset yrange [{:.6g}:{:.6g}]\n"
                      "set xlabel 'x ({})'\nset ylabel 'y ({})'\n",
                      extent.min_x,
                      extent.max_x,
                      extent.min_y,
                      extent.max_y,
                      unit,
                      unit)};
}

std::string MosaicUnder(const std::optional<FigureMosaic>& mosaic) {
  if (!mosaic) return "";
  const double half = 0.5 * mosaic->metres_per_px;
  return fmt::format(
      "    '{}' binary filetype=png origin=({:.9g}, {:.9g}) dx={:.9g} dy={:.9g} \\\n"
      "      with rgbimage notitle, \\\n",
      mosaic->file,
      mosaic->min_x + half,
      mosaic->min_y + half,
      mosaic->metres_per_px,
      mosaic->metres_per_px);
}

std::vector<Figure::Data> AllPoses(const TrajectoryComparison& comparison) {
  std::vector<Figure::Data> data;
  if (!comparison.truth.empty()) data.push_back({"truth.csv", PosesData(comparison.truth)});
  if (!comparison.before.empty()) data.push_back({"before.csv", PosesData(comparison.before)});
  for (std::size_t i = 0; i < comparison.runs.size(); ++i) {
    data.push_back({RunFile(i), PosesData(comparison.runs[i].poses)});
  }
  return data;
}

Figure Trajectories(const TrajectoryComparison& comparison) {
  Figure figure;
  figure.name = "trajectories";
  figure.data = AllPoses(comparison);
  const MapFrame frame = FrameFor(ExtentOf(comparison), comparison.unit);
  figure.width_px = frame.width_px;
  figure.height_px = frame.height_px;
  figure.settings = RunStyles(comparison.runs.size()) + frame.settings +
                    "set key outside top center horizontal maxrows 2 samplen 3 noenhanced\n";
  std::string curves = Curves(comparison, "3:4", {.truth = true, .before = true}, true);
  curves.insert(curves.find('\n') + 1, MosaicUnder(comparison.mosaic));
  figure.plot = curves;
  return figure;
}

// Panels below each other, with a common axis.
struct Panel {
  std::string label;
  std::string columns;
  Under under;
};
Figure Panels(const TrajectoryComparison& comparison,
              const std::string& name,
              const std::string& x_label,
              const std::vector<Panel>& panels) {
  Figure figure;
  figure.name = name;
  constexpr int kPanelPx = 190;
  figure.height_px = 80 + kPanelPx * static_cast<int>(panels.size());
  figure.settings = RunStyles(comparison.runs.size());
  figure.plot = fmt::format(
      "  set multiplot layout {},1 margins char 10,char 2,char 3.5,char 3.5 spacing char 0,char "
      "1.5\n"
      "  unset xlabel\n  set format x ''\n",
      panels.size());
  for (std::size_t i = 0; i < panels.size(); ++i) {
    figure.plot += i == 0 ? kLegendAbove : "  unset key\n";
    if (i + 1 == panels.size()) {
      figure.plot += fmt::format("  set xlabel '{}'\n  set format x '% h'\n", x_label);
    }
    figure.plot += fmt::format("  set ylabel '{}'\n", panels[i].label);
    figure.plot += Curves(comparison, panels[i].columns, panels[i].under, i == 0);
  }
  figure.plot += "  unset multiplot\n";
  return figure;
}

bool Tilted(const TrajectoryComparison& comparison) {
  constexpr double kLevelDeg = 1e-6;
  const auto tilted = [](const FigurePose& pose) {
    return std::abs(pose.pitch_deg) > kLevelDeg || std::abs(pose.roll_deg) > kLevelDeg;
  };
  return std::any_of(comparison.truth.begin(), comparison.truth.end(), tilted) ||
         std::any_of(comparison.runs.begin(), comparison.runs.end(), [&](const FigureRun& run) {
           return std::any_of(run.poses.begin(), run.poses.end(), tilted);
         });
}

Figure Poses(const TrajectoryComparison& comparison) {
  constexpr Under kTruth{.truth = true};
  std::vector<Panel> panels = {{fmt::format("x ({})", comparison.unit), "1:3", kTruth},
                               {fmt::format("y ({})", comparison.unit), "1:4", kTruth},
                               {"yaw (deg)", "1:5", kTruth}};
  if (Tilted(comparison)) {
    panels.push_back({"pitch (deg)", "1:6", kTruth});
    panels.push_back({"roll (deg)", "1:7", kTruth});
  }
  return Panels(comparison, "poses", "time (s)", panels);
}

Figure Errors(const TrajectoryComparison& comparison, const LengthUnit& unit, bool over_distance) {
  const int x = over_distance ? 2 : 1;
  const std::string label =
      over_distance ? fmt::format("true path ({})", comparison.unit) : std::string("time (s)");
  return Panels(comparison,
                over_distance ? "errors-way" : "errors",
                label,
                {{fmt::format("position error ({})", unit.name),
                  fmt::format("{}:({:g} * $8)", x, unit.per_unit),
                  {.before = true}},
                 {"yaw error (deg)", fmt::format("{}:9", x), {}}});
}

Figure ErrorMap(const TrajectoryComparison& comparison, const LengthUnit& unit) {
  Figure figure;
  figure.name = "error-map";
  const MapFrame frame = FrameFor(ExtentOf(comparison), comparison.unit);
  const std::size_t runs = comparison.runs.size();
  const int columns = runs == 1 ? 1 : 2;
  const int rows = static_cast<int>((runs + 1) / 2);
  const double scale = columns == 1 ? 1 : 0.6;
  figure.width_px = static_cast<int>(scale * columns * frame.width_px) + 80;
  figure.height_px = static_cast<int>(scale * (columns == 1 ? 1 : rows) * frame.height_px) + 30;
  // Viridis, which is ordered for colour-blind readers and in grey.
  figure.settings =
      frame.settings +
      "set palette defined (0 '#440154', 0.25 '#3B528B', 0.5 '#21918C', 0.75 '#5EC962', "
      "1 '#FDE725')\n" +
      fmt::format("set cbrange [0:{:.6g}]\nset cblabel 'position error ({})'\nunset key\n",
                  std::max(unit.per_unit * LargestError(comparison), 1e-9),
                  unit.name);
  figure.plot = fmt::format("  set multiplot layout {},{}\n", columns == 1 ? 1 : rows, columns);
  for (std::size_t i = 0; i < runs; ++i) {
    figure.plot += fmt::format(
        "  set title {} noenhanced\n"
        "  plot \\\n{}"
        "    '{}' skip 1 using 3:4 with lines lc rgb '#FFFFFF' lw 6, \\\n"
        "    '{}' skip 1 using 3:4:({:g} * $8) with lines lc palette lw 4\n",
        GnuplotQuote(comparison.runs[i].name),
        MosaicUnder(comparison.mosaic),
        RunFile(i),
        RunFile(i),
        unit.per_unit);
  }
  figure.plot += "  unset multiplot\n";
  return figure;
}

bool HasSegments(const TrajectoryComparison& comparison) {
  return std::any_of(comparison.runs.begin(), comparison.runs.end(), [](const FigureRun& run) {
    return !run.segments.empty();
  });
}

}  // namespace

std::vector<Figure> TrajectoryFigures(const TrajectoryComparison& comparison) {
  std::vector<Figure> figures = {Trajectories(comparison), Poses(comparison)};
  if (comparison.truth.empty()) return figures;
  const LengthUnit unit = UnitFor(LargestError(comparison), comparison.unit);
  figures.push_back(Errors(comparison, unit, false));
  figures.push_back(Errors(comparison, unit, true));
  figures.push_back(ErrorMap(comparison, unit));
  figures.push_back(DistributionFigure(comparison, unit));
  if (HasSegments(comparison)) figures.push_back(SegmentFigure(comparison));
  return figures;
}

}  // namespace ceilmap::figures
