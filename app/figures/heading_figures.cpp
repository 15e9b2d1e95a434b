#include "app/figures/heading_figures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "calib/base/degrees.hpp"
#include "calib/base/pose2.hpp"

namespace ceilmap::figures {
namespace {

// Turns continue beyond 180 degrees. Fields without a value are empty.
std::string HeadingData(const std::vector<files::MeasuredHeading>& headings,
                        const evaluation::HeadingErrors* errors) {
  std::string text = "time_s,frame,heading_deg,sigma_deg,confidence,true_heading_deg,error_deg\n";
  double heading_rad = headings.front().estimate.heading_rad;
  std::size_t next = 0;
  for (std::size_t i = 0; i < headings.size(); ++i) {
    const compass::HeadingEstimate& estimate = headings[i].estimate;
    heading_rad += WrapAngle(estimate.heading_rad - heading_rad);
    text += fmt::format("{:.6f},{},{:.5f},{:.5f},{:.4f},",
                        headings[i].stamp_s - headings.front().stamp_s,
                        headings[i].frame,
                        kDegPerRad * heading_rad,
                        kDegPerRad * std::sqrt(estimate.variance_rad2),
                        estimate.confidence);
    if (errors != nullptr && next < errors->of.size() && errors->of[next].heading == i) {
      const evaluation::HeadingError& error = errors->of[next++];
      text += fmt::format(
          "{:.5f},{:.5f}\n", kDegPerRad * heading_rad - error.error_deg, error.error_deg);
    } else {
      text += ",\n";
    }
  }
  return text;
}

constexpr std::string_view kHeadingPlot =
    R"(    'heading.csv' using 1:($3 - $4):($3 + $4) every ::1 \
      with filledcurves fc rgb '#0072B2' fs transparent solid 0.2 noborder title '± sigma', \
    'heading.csv' using 1:3 every ::1 with lines ls 1 title 'compass'
)";

constexpr std::string_view kErrorPlot =
    R"(    'heading.csv' using 1:7 every ::1 with lines ls 1 notitle
)";

// Shifts from -180 to 180 degrees.
std::string DistanceData(const compass::DistanceProfile& profile) {
  const auto columns = static_cast<std::int64_t>(profile.distance.size());
  std::string text = "shift_columns,turn_deg,distance\n";
  for (std::int64_t shift = -(columns / 2); shift < columns - columns / 2; ++shift) {
    const auto index = static_cast<std::size_t>((shift + columns) % columns);
    text += fmt::format("{},{:.6f},{:.6g}\n",
                        shift,
                        360.0 * static_cast<double>(shift) / static_cast<double>(columns),
                        profile.distance[index]);
  }
  return text;
}

}  // namespace

Figure HeadingFigure(const std::vector<files::MeasuredHeading>& headings,
                     const evaluation::HeadingErrors* errors) {
  Figure figure;
  figure.name = "heading";
  figure.data = {{"heading.csv", HeadingData(headings, errors)}};
  figure.settings = fmt::format("set xrange [0:{:.6g}]\n",
                                std::max(headings.back().stamp_s - headings.front().stamp_s, 1e-3));
  const std::string heading =
      "  set key top left\n"
      "  set ylabel 'heading (deg)'\n"
      "  plot \\\n";
  if (errors == nullptr) {
    figure.plot = "  set xlabel 'time (s)'\n" + heading + std::string(kHeadingPlot);
    return figure;
  }
  figure.height_px = 640;
  figure.plot =
      "  set multiplot layout 2,1 margins char 10,char 2,char 3.5,char 1.5 spacing char 0,char 3\n"
      "  unset xlabel\n" +
      heading + "    'heading.csv' using 1:6 every ::1 with lines ls 6 title 'truth', \\\n" +
      std::string(kHeadingPlot) +
      "  set xlabel 'time (s)'\n"
      "  set ylabel 'error (deg)'\n"
      "  plot \\\n" +
      std::string(kErrorPlot) + "  unset multiplot\n";
  return figure;
}

Figure DistanceFigure(std::int64_t frame,
                      const compass::DistanceProfile& profile,
                      const cv::Mat& panorama) {
  Figure figure;
  figure.name = fmt::format("distance-{}", frame);
  const std::string data = figure.name + ".csv";
  figure.data = {{data, DistanceData(profile)}};
  if (!panorama.empty()) {
    std::vector<unsigned char> png;
    cv::imencode(".png", panorama, png);
    figure.data.push_back({fmt::format("panorama-{}.png", frame), {png.begin(), png.end()}});
  }
  const double turn_deg =
      360 * profile.shift_columns / static_cast<double>(profile.distance.size());
  figure.settings = fmt::format(
      "set title {}\n"
      "set xrange [-180:180]\n"
      "set xtics 45\n"
      "set xlabel 'turn (deg), counter-clockwise'\n"
      "set ylabel 'distance (grey levels)'\n"
      "set arrow 1 from first {:.6g}, graph 0 to first {:.6g}, graph 1 nohead ls 7\n"
      "set label 1 '{:.2f} deg' at first {:.6g}, graph 0.96 offset char {},0 {}\n",
      GnuplotQuote(fmt::format("Frame {} against frame {}", frame, profile.reference_frame)),
      turn_deg,
      turn_deg,
      turn_deg,
      turn_deg,
      turn_deg > 90 ? -1 : 1,
      turn_deg > 90 ? "right" : "left");
  figure.plot = fmt::format("  plot '{}' using 2:3 every ::1 with lines ls 1 notitle\n", data);
  return figure;
}

}  // namespace ceilmap::figures
