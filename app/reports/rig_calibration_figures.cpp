#include "app/reports/rig_calibration_figures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>

#include "calib/base/degrees.hpp"
#include "calib/ceiling_view.hpp"

namespace ceilmap::reports {
namespace {

using Eigen::Vector2d;

// Residuals are drawn with a factor so that the largest is a fifth of the circle.
double Exaggeration(const std::vector<Pose2>& spin, double radius) {
  double largest = 1e-9;
  for (const Pose2& view : spin) largest = std::max(largest, view.Translation().norm());
  const double most = 0.2 * radius / largest;
  return std::max(1.0, std::pow(10, std::floor(std::log10(most))));
}

figures::Figure SpinFigure(const mount::UpMount& result) {
  const calibration::RigSolution& solution = result.solution;
  const double mm = 1000 * result.distance_m.value;
  const double radius_mm = mm * solution.mount.centre.norm();
  const double times = Exaggeration(solution.spin, solution.mount.centre.norm());
  figures::Figure figure;
  figure.name = "spin";
  figure.height_px = 640;
  std::string data = "camera_x_mm,camera_y_mm,axle_off_x_mm,axle_off_y_mm,heading_deg\n";
  for (const Pose2& view : solution.spin) {
    const Vector2d camera = mm * (view * solution.mount.centre - view.Translation());
    const Vector2d off = mm * view.Translation();
    data += fmt::format("{:.4f},{:.4f},{:.4f},{:.4f},{:.3f}\n",
                        camera.x(),
                        camera.y(),
                        off.x(),
                        off.y(),
                        kDegPerRad * view.yaw);
  }
  figure.data = {{"spin.csv", data}};
  figure.settings = fmt::format(
      "set size ratio -1\n"
      "set xlabel 'x (mm), of the image'\n"
      "set ylabel 'y (mm)'\n"
      "set object 1 circle at 0,0 size {:.5g} fs empty border rgb '#AAAAAA' lw 3\n"
      "set title 'The camera around the rotation centre; errors of views {:g} "
      "times as large'\n",
      radius_mm,
      times);
  figure.plot = fmt::format(
      "  plot 'spin.csv' using 1:2:({0:g}*$3):({0:g}*$4) every ::1 with vectors nohead ls 2 "
      "notitle, \\\n"
      "    '' using 1:2 every ::1 with points ls 1 title 'views', \\\n"
      "    '+' using (0):(0) every ::0::0 with points ls 7 title 'rotation centre'\n",
      times);
  return figure;
}

figures::Figure StraightFigure(const mount::UpMount& result) {
  const calibration::RigSolution& solution = result.solution;
  const double Z = result.distance_m.value;
  // Base x is (cos yaw, -sin yaw) in the first view's axes.
  const Pose2 T_base_twin{0, 0, solution.mount.yaw_rad};
  figures::Figure figure;
  figure.name = "straight";
  figure.height_px = 640;
  std::string data = "way_m,aside_mm,heading_deg\n";
  for (const Pose2& view : solution.straight) {
    const Vector2d at = Z * (T_base_twin * view.Translation());
    data += fmt::format("{:.5f},{:.4f},{:.5f}\n", at.x(), 1000 * at.y(), kDegPerRad * view.yaw);
  }
  figure.data = {{"straight.csv", data}};
  figure.plot =
      "  set multiplot layout 2,1 margins char 11,char 2,char 3.5,char 1.5 spacing char 0,char 3\n"
      "  unset xlabel\n"
      "  set ylabel 'lateral position of the axle (mm)'\n"
      "  plot 'straight.csv' using 1:2 every ::1 with linespoints ls 1 notitle\n"
      "  set xlabel 'distance ahead (m)'\n"
      "  set ylabel 'heading (deg)'\n"
      "  plot 'straight.csv' using 1:3 every ::1 with linespoints ls 1 notitle\n"
      "  unset multiplot\n";
  return figure;
}

figures::Figure ResidualFigure(const mount::UpMount& result) {
  figures::Figure figure;
  figure.name = "residuals";
  const auto data = [](const std::vector<calibration::ViewError>& errors) {
    std::string text = "view,rms_px,places\n";
    for (std::size_t i = 0; i < errors.size(); ++i) {
      text += fmt::format("{},{:.5f},{}\n", i, errors[i].rms_px, errors[i].places);
    }
    return text;
  };
  figure.data = {{"residuals-spin.csv", data(result.solution.spin_errors)},
                 {"residuals-straight.csv", data(result.solution.straight_errors)}};
  figure.settings =
      "set xlabel 'view'\n"
      "set ylabel 'RMS of its points (px)'\n"
      "set yrange [0:*]\n";
  figure.plot =
      "  plot 'residuals-spin.csv' using 1:2 every ::1 with linespoints ls 1 title 'spin', \\\n"
      "    'residuals-straight.csv' using 1:2 every ::1 with linespoints ls 2 title 'straight "
      "drive'\n";
  return figure;
}

}  // namespace

std::vector<figures::Figure> RigFigures(const mount::UpMount& result) {
  return {SpinFigure(result), StraightFigure(result), ResidualFigure(result)};
}

cv::Mat SpinMosaic(const mount::CeilingRecording& spin,
                   const std::vector<Pose2>& headings,
                   const calib::MountedCamera& up,
                   double ceiling_height_m,
                   double axle_behind_mast_m) {
  const calib::CeilingView view(up, ceiling_height_m);
  const double m_per_px = view.MetresPerPixel();
  const int side = static_cast<int>(std::hypot(view.Size().width, view.Size().height)) + 2;
  const Pose2 T_axle_base{axle_behind_mast_m, 0, 0};
  cv::Mat sum = cv::Mat::zeros(side, side, CV_32FC1);
  cv::Mat count = cv::Mat::zeros(side, side, CV_32FC1);
  cv::Mat buffer;
  for (std::size_t i = 0; i < spin.keyframes.size() && i < headings.size(); ++i) {
    const cv::Mat& level = view.Rectify(spin.keyframes[i].image, buffer);
    const Pose2 T_middle_view = Pose2{0, 0, headings[i].yaw} * T_axle_base * view.T_base_view();
    // x right and y down, from the centre, as in the camera's image of the first view.
    const Pose2 T_mosaic_view = Pose2{0, 0, -view.T_base_view().yaw} * T_middle_view;
    const double c = std::cos(T_mosaic_view.yaw);
    const double s = std::sin(T_mosaic_view.yaw);
    const double u = 0.5 * (level.cols - 1);
    const double v = 0.5 * (level.rows - 1);
    const cv::Matx23d warp(c,
                           -s,
                           0.5 * side + T_mosaic_view.x / m_per_px - c * u + s * v,
                           s,
                           c,
                           0.5 * side + T_mosaic_view.y / m_per_px - s * u - c * v);
    cv::Mat turned;
    cv::Mat seen;
    const cv::Mat all(level.size(), CV_8UC1, cv::Scalar(255));
    cv::warpAffine(level, turned, warp, sum.size(), cv::INTER_LINEAR);
    cv::warpAffine(
        view.Mask().empty() ? all : view.Mask(), seen, warp, sum.size(), cv::INTER_NEAREST);
    cv::accumulate(turned, sum, seen);
    cv::add(count, 1, count, seen);
  }
  cv::Mat mean;
  cv::divide(sum, cv::max(count, 1), mean);
  mean.convertTo(mean, CV_8UC1);
  return mean;
}

}  // namespace ceilmap::reports
