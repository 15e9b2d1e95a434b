#include "app/figure_runs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace ceilmap::app {
namespace figure_runs {
namespace {

// Okabe and Ito's colours, darkest first; after all of them they come again with other dashes.
constexpr std::array<const char*, 7> kColours = {
    "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#882255"};
constexpr std::array<const char*, 4> kDashes = {"1", "(8,3)", "(2,3)", "(8,3,2,3)"};

}  // namespace

std::string RunStyles(std::size_t runs) {
  std::string text;
  for (std::size_t i = 0; i < runs; ++i) {
    text += fmt::format("set style line {} lc rgb '{}' lw 1.6 dt {} pt 7 ps 0.4\n",
                        static_cast<std::size_t>(kFirstStyle) + i,
                        kColours[i % kColours.size()],
                        kDashes[i / kColours.size() % kDashes.size()]);
  }
  return text;
}

std::string RunFile(std::size_t run) {
  return fmt::format("run-{}.csv", run + 1);
}

LengthUnit UnitFor(double largest, const std::string& unit) {
  if (unit != "m" || largest >= 1) return {1, unit};
  if (largest >= 0.01) return {100, "cm"};
  return {1000, "mm"};
}

}  // namespace figure_runs

namespace {

using figure_runs::kFirstStyle;
using figure_runs::kLegendAbove;
using figure_runs::LengthUnit;
using figure_runs::RunStyles;

double Quantile(const std::vector<double>& sorted, double part) {
  const double at = part * static_cast<double>(sorted.size() - 1);
  const auto low = static_cast<std::size_t>(at);
  const std::size_t high = std::min(low + 1, sorted.size() - 1);
  return sorted[low] + (at - static_cast<double>(low)) * (sorted[high] - sorted[low]);
}

struct SortedErrors {
  std::vector<double> position;
  std::vector<double> yaw;
};
SortedErrors Sorted(const FigureRun& run) {
  SortedErrors errors;
  for (const FigurePose& pose : run.poses) {
    errors.position.push_back(pose.position_error_m);
    errors.yaw.push_back(std::abs(pose.yaw_error_deg));
  }
  std::sort(errors.position.begin(), errors.position.end());
  std::sort(errors.yaw.begin(), errors.yaw.end());
  return errors;
}

}  // namespace

Figure DistributionFigure(const TrajectoryComparison& comparison, const LengthUnit& unit) {
  Figure figure;
  figure.name = "distribution";
  const std::size_t runs = comparison.runs.size();
  figure.width_px = 1000;
  figure.height_px = 700;
  std::string boxes = "run,name,quantity,p5,p25,p50,p75,p95\n";
  std::string cumulative = "run,part,position_error_m,yaw_error_deg\n";
  std::string tics;
  for (std::size_t i = 0; i < runs; ++i) {
    const SortedErrors errors = Sorted(comparison.runs[i]);
    for (const auto& [what, sorted] :
         {std::pair{"position_m", &errors.position}, std::pair{"yaw_deg", &errors.yaw}}) {
      boxes += fmt::format("{},{},{}", i + 1, i + 1, what);
      for (const double part : {0.05, 0.25, 0.5, 0.75, 0.95}) {
        boxes += fmt::format(",{:.7g}", Quantile(*sorted, part));
      }
      boxes += '\n';
    }
    constexpr int kSteps = 200;
    for (int step = 0; step <= kSteps; ++step) {
      const double part = static_cast<double>(step) / kSteps;
      cumulative += fmt::format("{},{:.4f},{:.7g},{:.7g}\n",
                                i + 1,
                                part,
                                Quantile(errors.position, part),
                                Quantile(errors.yaw, part));
    }
    cumulative += "\n\n";
    tics +=
        fmt::format("{}{} {}", i == 0 ? "" : ", ", GnuplotQuote(comparison.runs[i].name), i + 1);
  }
  figure.data = {{"boxes.csv", boxes}, {"cumulative.csv", cumulative}};
  figure.settings = RunStyles(runs);
  figure.plot =
      "  set multiplot layout 2,2 margins char 10,char 3,char 3.5,char 2 spacing char 12,char "
      "6.5\n";
  for (const bool yaw : {false, true}) {
    const std::string label =
        yaw ? std::string("yaw error (deg)") : fmt::format("position error ({})", unit.name);
    const double factor = yaw ? 1 : unit.per_unit;
    figure.plot += fmt::format(
        "  set title 'Median, quartiles, 5 and 95 %'\n"
        "  unset key\n  unset xlabel\n  set xtics ({}) noenhanced\n"
        "  set xrange [0.4:{}.6]\n  set yrange [0:*]\n  set ylabel '{}'\n"
        "  plot for [i = 1:{}] 'boxes.csv' skip 1 "
        "using ($1 == i && strcol(3) eq '{}' ? i : NaN):({:g} * $5):({:g} * $4):({:g} * $8):"
        "({:g} * $7):(0.5) with candlesticks ls {} + i fs transparent solid 0.25 whiskerbars, \\\n"
        "    for [i = 1:{}] 'boxes.csv' skip 1 "
        "using ($1 == i && strcol(3) eq '{}' ? i : NaN):({:g} * $6):({:g} * $6):({:g} * $6):"
        "({:g} * $6):(0.5) with candlesticks ls {} + i lw 3\n",
        tics,
        runs,
        label,
        runs,
        yaw ? "yaw_deg" : "position_m",
        factor,
        factor,
        factor,
        factor,
        kFirstStyle - 1,
        runs,
        yaw ? "yaw_deg" : "position_m",
        factor,
        factor,
        factor,
        factor,
        kFirstStyle - 1);
    figure.plot += fmt::format(
        "  set title 'Part of the frames with at most this error'\n"
        "  set xtics autofreq\n  set xrange [0:*]\n  set yrange [0:1]\n"
        "  set xlabel '{}'\n  set ylabel 'part of the frames'\n"
        "  set key bottom right noenhanced\n"
        "  plot ",
        label);
    for (std::size_t i = 0; i < runs; ++i) {
      figure.plot += fmt::format(
          "{}'cumulative.csv' {} index {} using ({:g} * ${}):2 with lines ls {} title {}",
          i == 0 ? "" : ", \\\n    ",
          "skip 1",
          i,
          factor,
          yaw ? 4 : 3,
          static_cast<std::size_t>(kFirstStyle) + i,
          GnuplotQuote(comparison.runs[i].name));
    }
    figure.plot += "\n";
  }
  figure.plot += "  unset multiplot\n";
  return figure;
}

Figure SegmentFigure(const TrajectoryComparison& comparison) {
  Figure figure;
  figure.name = "segments";
  figure.width_px = 1000;
  std::string data = "run,length_m,translation_percent,rotation_deg_per_m\n";
  for (std::size_t i = 0; i < comparison.runs.size(); ++i) {
    for (const SegmentError& segment : comparison.runs[i].segments) {
      data += fmt::format("{},{:.6g},{:.7g},{:.7g}\n",
                          i + 1,
                          segment.length_m,
                          100 * segment.translation_part,
                          segment.rotation_deg_per_m);
    }
    data += "\n\n";
  }
  figure.data = {{"segments.csv", data}};
  figure.settings =
      RunStyles(comparison.runs.size()) +
      fmt::format("set xlabel 'length of the segment ({})'\nset logscale x\n", comparison.unit);
  figure.plot =
      "  set multiplot layout 1,2 margins char 10,char 3,char 3.5,char 3 spacing char 12,char 5\n";
  for (const bool rotation : {false, true}) {
    figure.plot +=
        fmt::format("  set ylabel '{}'\n  set yrange [0:*]\n",
                    rotation ? "rotation error (deg/m)" : "translation error (% of the length)");
    figure.plot += rotation ? std::string("  unset key\n") : std::string(kLegendAbove);
    figure.plot += "  plot ";
    for (std::size_t i = 0; i < comparison.runs.size(); ++i) {
      figure.plot += fmt::format(
          "{}'segments.csv' {} index {} using 2:{} with linespoints ls {} "
          "title {}",
          i == 0 ? "" : ", \\\n    ",
          "skip 1",
          i,
          rotation ? 4 : 3,
          static_cast<std::size_t>(kFirstStyle) + i,
          GnuplotQuote(comparison.runs[i].name));
    }
    figure.plot += "\n";
  }
  figure.plot += "  unset multiplot\n";
  return figure;
}

}  // namespace ceilmap::app
