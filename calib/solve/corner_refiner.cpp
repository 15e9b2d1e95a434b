#include "calib/solve/corner_refiner.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace ceilmap::calibration {
namespace {

constexpr double kReach = 2;  // of the weight function, in standard deviations
constexpr int kMinHalf = 2;

using Quadric = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

// The saddle of a x^2 + b x y + c y^2 + d x + e y + f; nothing for an extremum or a ridge.
std::optional<cv::Point2d> Saddle(const Quadric& quadric) {
  const double a = quadric[0];
  const double b = quadric[1];
  const double c = quadric[2];
  const double determinant = 4 * a * c - b * b;
  if (!(determinant < 0)) return std::nullopt;
  return cv::Point2d((b * quadric[4] - 2 * c * quadric[3]) / determinant,
                     (b * quadric[3] - 2 * a * quadric[4]) / determinant);
}

// The quadric around `centre` that fits the grey values; nothing when the window leaves the image.
std::optional<Quadric> FitQuadric(const cv::Mat& grey, cv::Point2d centre, double sigma_px) {
  const int half = std::max(kMinHalf, static_cast<int>(std::ceil(kReach * sigma_px)));
  const int u0 = cvRound(centre.x);
  const int v0 = cvRound(centre.y);
  if (u0 < half || v0 < half || u0 + half >= grey.cols || v0 + half >= grey.rows)
    return std::nullopt;
  Matrix6 normal = Matrix6::Zero();
  Quadric right = Quadric::Zero();
  for (int v = v0 - half; v <= v0 + half; ++v) {
    const auto* const row = grey.ptr<unsigned char>(v);
    for (int u = u0 - half; u <= u0 + half; ++u) {
      const double x = u - centre.x;
      const double y = v - centre.y;
      const double bell = std::exp(-(x * x + y * y) / (sigma_px * sigma_px));  // squared
      Quadric terms;
      terms << x * x, x * y, y * y, x, y, 1;
      normal.noalias() += (bell * terms) * terms.transpose();
      right += bell * row[u] * terms;
    }
  }
  return normal.ldlt().solve(right);
}

}  // namespace

std::optional<cv::Point2d> RefineCorner(const cv::Mat& grey,
                                        cv::Point2d start,
                                        double sigma_px,
                                        double farthest_px) {
  constexpr int kMaxSteps = 20;
  constexpr double kDonePx = 1e-4;
  cv::Point2d corner = start;
  for (int step = 0; step < kMaxSteps; ++step) {
    const std::optional<Quadric> quadric = FitQuadric(grey, corner, sigma_px);
    const std::optional<cv::Point2d> move = quadric ? Saddle(*quadric) : std::nullopt;
    if (!move) return std::nullopt;
    corner += *move;
    if (!(cv::norm(corner - start) < farthest_px)) return std::nullopt;
    if (cv::norm(*move) < kDonePx) break;
  }
  return corner;
}

}  // namespace ceilmap::calibration
