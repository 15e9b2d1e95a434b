#include "app/figures/figure_runs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace ceilmap::figures {
namespace figure_runs {
namespace {

// Okabe and Ito's colours, darkest first; further runs use them again with other dashes.
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

double Quantile(const std::vector<double>& sorted, double fraction) {
  const double at = fraction * static_cast<double>(sorted.size() - 1);
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

// One curve for each of these runs, from a file with one block each.
std::string BlockCurves(const TrajectoryComparison& comparison,
                        const std::vector<std::size_t>& runs,
                        const std::string& file,
                        const std::string& columns,
                        const std::string& with) {
  std::string text = "  plot ";
  for (std::size_t block = 0; block < runs.size(); ++block) {
    text += fmt::format("{}'{}' skip 1 index {} using {} with {} ls {} title {}",
                        block == 0 ? "" : ", \\\n    ",
                        file,
                        block,
                        columns,
                        with,
                        static_cast<std::size_t>(kFirstStyle) + runs[block],
                        GnuplotQuote(comparison.runs[runs[block]].name));
  }
  return text + "\n";
}

// For each run, one row per quantity with the quantiles of a box.
std::string BoxData(const std::vector<SortedErrors>& errors) {
  std::string text = "run,quantity,p5,p25,p50,p75,p95\n";
  for (std::size_t i = 0; i < errors.size(); ++i) {
    for (const auto& [what, sorted] :
         {std::pair{"position_m", &errors[i].position}, std::pair{"yaw_deg", &errors[i].yaw}}) {
      text += fmt::format("{},{}", i + 1, what);
      for (const double fraction : {0.05, 0.25, 0.5, 0.75, 0.95}) {
        text += fmt::format(",{:.7g}", Quantile(*sorted, fraction));
      }
      text += '\n';
    }
  }
  return text;
}

std::string CumulativeData(const std::vector<SortedErrors>& errors) {
  std::string text = "run,part,position_error_m,yaw_error_deg\n";
  for (std::size_t i = 0; i < errors.size(); ++i) {
    constexpr int kSteps = 200;
    for (int step = 0; step <= kSteps; ++step) {
      const double fraction = static_cast<double>(step) / kSteps;
      text += fmt::format("{},{:.4f},{:.7g},{:.7g}\n",
                          i + 1,
                          fraction,
                          Quantile(errors[i].position, fraction),
                          Quantile(errors[i].yaw, fraction));
    }
    text += "\n\n";
  }
  return text;
}

// Boxes of one quantity: quartiles with whiskers, and a thick median.
std::string Boxes(std::size_t runs, const std::string& quantity, double factor) {
  const std::string each = fmt::format(
      "for [i = 1:{}] 'boxes.csv' skip 1 using ($1 == i && strcol(2) eq '{}' ? i : NaN)",
      runs,
      quantity);
  const int before_first = kFirstStyle - 1;
  return fmt::format(
      "  plot {0}:({1:g} * $4):({1:g} * $3):({1:g} * $7):({1:g} * $6):(0.5) with candlesticks "
      "ls {2} + i fs transparent solid 0.25 whiskerbars, \\\n"
      "    {0}:({1:g} * $5):({1:g} * $5):({1:g} * $5):({1:g} * $5):(0.5) with candlesticks "
      "ls {2} + i lw 3\n",
      each,
      factor,
      before_first);
}

}  // namespace

Figure DistributionFigure(const TrajectoryComparison& comparison, const LengthUnit& unit) {
  Figure figure;
  figure.name = "distribution";
  figure.width_px = 1000;
  figure.height_px = 700;
  std::vector<SortedErrors> errors;
  std::vector<std::size_t> runs;
  std::string names;
  for (std::size_t i = 0; i < comparison.runs.size(); ++i) {
    errors.push_back(Sorted(comparison.runs[i]));
    runs.push_back(i);
    names +=
        fmt::format("{}{} {}", i == 0 ? "" : ", ", GnuplotQuote(comparison.runs[i].name), i + 1);
  }
  figure.data = {{"boxes.csv", BoxData(errors)}, {"cumulative.csv", CumulativeData(errors)}};
  figure.settings = RunStyles(runs.size());
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
        "  set xrange [0.4:{}.6]\n  set yrange [0:*]\n  set ylabel '{}'\n",
        names,
        runs.size(),
        label);
    figure.plot += Boxes(runs.size(), yaw ? "yaw_deg" : "position_m", factor);
    figure.plot += fmt::format(
        "  set title 'Fraction of the frames with at most this error'\n"
        "  set xtics autofreq\n  set xrange [0:*]\n  set yrange [0:1]\n"
        "  set xlabel '{}'\n  set ylabel 'fraction of the frames'\n"
        "  set key bottom right noenhanced\n",
        label);
    figure.plot += BlockCurves(comparison,
                               runs,
                               "cumulative.csv",
                               fmt::format("({:g} * ${}):2", factor, yaw ? 4 : 3),
                               "lines");
  }
  figure.plot += "  unset multiplot\n";
  return figure;
}

Figure SegmentFigure(const TrajectoryComparison& comparison) {
  Figure figure;
  figure.name = "segments";
  figure.width_px = 1000;
  std::string data = "run,length_m,translation_percent,rotation_deg_per_m\n";
  std::vector<std::size_t> runs;  // only those with segments
  for (std::size_t i = 0; i < comparison.runs.size(); ++i) {
    if (comparison.runs[i].segments.empty()) continue;
    runs.push_back(i);
    for (const SegmentError& segment : comparison.runs[i].segments) {
      data += fmt::format("{},{:.6g},{:.7g},{:.7g}\n",
                          i + 1,
                          segment.length_m,
                          100 * segment.translation_ratio,
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
    figure.plot +=
        BlockCurves(comparison, runs, "segments.csv", rotation ? "2:4" : "2:3", "linespoints");
  }
  figure.plot += "  unset multiplot\n";
  return figure;
}

}  // namespace ceilmap::figures
