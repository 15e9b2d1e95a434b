#include "calib/solve/mirror_finder.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "calib/solve/circle_fit.hpp"
#include "calib/solve/radial_edges.hpp"

namespace ceilmap::calibration {
namespace {

using Eigen::Vector2d;

// Quantile of a map, from every fourth pixel.
double Quantile(const cv::Mat& map, double fraction) {
  std::vector<float> values;
  for (int v = 0; v < map.rows; v += 2) {
    for (int u = 0; u < map.cols; u += 2) values.push_back(map.at<float>(v, u));
  }
  const auto at = values.begin() +
                  static_cast<std::ptrdiff_t>(fraction * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

// The outline of the largest moving area.
std::vector<Vector2d> OutlineOf(const cv::Mat& moving) {
  constexpr double kPart = 0.12;  // relative to strong motion
  const cv::Mat mask = moving > kPart * Quantile(moving, 0.95);
  std::vector<std::vector<cv::Point>> outlines;
  cv::findContours(mask, outlines, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
  std::vector<Vector2d> points;
  if (outlines.empty()) return points;
  const auto& largest =
      *std::max_element(outlines.begin(), outlines.end(), [](const auto& a, const auto& b) {
        return cv::contourArea(a) < cv::contourArea(b);
      });
  for (const cv::Point& p : largest) {
    // The image's border is no rim.
    const bool inside = p.x > 1 && p.y > 1 && p.x < moving.cols - 2 && p.y < moving.rows - 2;
    if (inside) points.emplace_back(p.x, p.y);
  }
  return points;
}

// Circle of the rim, by alternating measurement and fit.
std::optional<CircleFit> FitRim(const cv::Mat& moving, Circle start) {
  std::optional<CircleFit> fit;
  for (const double reach : {0.06, 0.03, 0.0}) {
    constexpr double kMinReachPx = 10;
    const double reach_px = std::max(kMinReachPx, reach * start.radius);
    fit = FitCircle(FallingEdges(moving, start, reach_px), start);
    if (!fit) return fit;
    start = fit->circle;
  }
  return fit;
}

void TakeRim(const CircleFit& fit, const std::vector<Vector2d>& points, MirrorRingFit& result) {
  result.ring.centre_px = fit.circle.centre;
  result.ring.outer_radius_px = fit.circle.radius;
  // Systematic error by light that varies near the rim over wide parts of it, which residuals do
  // not show. As large as the errors on simulated mirrors.
  constexpr double kEdgeSigmaPx = 0.1;
  constexpr double kVariance = kEdgeSigmaPx * kEdgeSigmaPx;
  result.centre_covariance =
      fit.covariance.topLeftCorner<2, 2>() + kVariance * Eigen::Matrix2d::Identity();
  result.outer_sigma_px = std::sqrt(fit.covariance(2, 2) + kVariance);
  result.rim_sigma_px = fit.sigma;
  result.rim_ratio = fit.inlier_ratio * static_cast<double>(points.size()) / kEdgeDirections;
  result.rim = points;
}

// A few directions in which the floor is not visible are ignored; corners of the robot are
// included.
// @param corners  The same points at the blurred tip of a corner, which has a quarter of the
// contrast.
void TakeBody(const std::vector<Vector2d>& points,
              const std::vector<Vector2d>& corners,
              MirrorRingFit& result) {
  constexpr double kGuess = 0.15;  // relative to the outer radius
  result.body = points;
  result.ring.inner_radius_px = kGuess * result.ring.outer_radius_px;
  if (points.size() < kEdgeDirections / 4) return;
  std::vector<double> radii;
  radii.reserve(points.size());
  for (const Vector2d& p : points) radii.push_back((p - result.ring.centre_px).norm());
  std::sort(radii.begin(), radii.end());
  const double middle = radii[radii.size() / 2];
  std::vector<double> off;
  off.reserve(radii.size());
  for (const double radius : radii) off.push_back(std::abs(radius - middle));
  std::sort(off.begin(), off.end());
  const double spread = off[off.size() / 2] / 0.6745;
  result.body_seen = true;
  constexpr double kRound = 0.04;
  result.round_body = spread < kRound * middle;
  if (result.round_body) {
    constexpr double kIndependent = 36;  // number of independent sectors
    result.ring.inner_radius_px = middle;
    constexpr double kEdgeSigmaPx =
        0.25;  // the floor has less contrast than the content at the rim
    result.inner_sigma_px = std::hypot(1.25 * spread / std::sqrt(kIndependent), kEdgeSigmaPx);
    return;
  }
  double farthest = middle;
  for (const Vector2d& p : corners) {
    const double radius = (p - result.ring.centre_px).norm();
    if (radius < middle + 3 * spread) farthest = std::max(farthest, radius);
  }
  result.ring.inner_radius_px = farthest;
  constexpr double kCornerSigmaPx = 1;
  result.inner_sigma_px = kCornerSigmaPx;
}

cv::Mat GreyOf(const cv::Mat& image) {
  if (image.channels() == 1) return image;
  cv::Mat grey;
  cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  return grey;
}

// Linear light, mean of the channels.
cv::Mat LightOf(const cv::Mat& image) {
  static const cv::Mat kTable = [] {
    cv::Mat table(1, 256, CV_32FC1);
    for (int i = 0; i < 256; ++i) {
      const double v = i / 255.0;
      table.at<float>(i) =
          static_cast<float>(v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4));
    }
    return table;
  }();
  cv::Mat light;
  cv::LUT(image, kTable, light);
  if (light.channels() == 1) return light;
  cv::Mat mean;
  cv::transform(light, mean, cv::Matx13f(1 / 3.0F, 1 / 3.0F, 1 / 3.0F));
  return mean;
}

// Saturated pixels are brighter than their value: a blurred edge beside them appears too far
// outside.
cv::Mat NotSaturated(const cv::Mat& image) {
  constexpr int kLimit = 250;
  constexpr int kSpan = 9;  // px across
  cv::Mat brightest = image;
  if (image.channels() > 1) {
    cv::Mat channel;
    cv::extractChannel(image, brightest, 0);
    for (int c = 1; c < image.channels(); ++c) {
      cv::extractChannel(image, channel, c);
      brightest = cv::max(brightest, channel);
    }
  }
  cv::Mat sound;
  cv::erode(brightest < kLimit, sound, cv::Mat(kSpan, kSpan, CV_8UC1, cv::Scalar(1)));
  return sound;
}

// 0 where a pixel was valid in fewer than a quarter of the images.
cv::Mat Deviation(const cv::Mat& sum, const cv::Mat& squares, const cv::Mat& count, int images) {
  const cv::Mat some = cv::max(count, 1);
  const cv::Mat mean = sum / some;
  cv::Mat variance = squares / some - mean.mul(mean);
  variance = cv::max(variance, 0);
  variance.setTo(0, count < 0.25 * images);
  cv::Mat deviation;
  cv::sqrt(variance, deviation);
  deviation.convertTo(deviation, CV_32FC1);
  return deviation;
}

}  // namespace

void MirrorActivity::Add(const cv::Mat& image) {
  const cv::Mat light = LightOf(image);
  cv::Mat grey;
  constexpr double kBlurPx = 1.2;
  cv::GaussianBlur(GreyOf(image), grey, {}, kBlurPx);
  if (images_ == 0) {
    for (cv::Mat* sum : {&light_, &light_squares_, &grey_, &grey_squares_}) {
      *sum = cv::Mat::zeros(image.size(), CV_64FC1);
    }
    sound_ = cv::Mat::zeros(image.size(), CV_64FC1);
  }
  CV_Assert(image.size() == light_.size());
  const cv::Mat sound = NotSaturated(image);
  cv::accumulate(light, light_, sound);
  cv::accumulateSquare(light, light_squares_, sound);
  cv::add(sound_, 1, sound_, sound);
  cv::accumulate(grey, grey_, sound);
  cv::accumulateSquare(grey, grey_squares_, sound);
  ++images_;
}

cv::Mat MirrorActivity::OfLight() const {
  return Deviation(light_, light_squares_, sound_, images_);
}

cv::Mat MirrorActivity::OfGrey() const {
  return Deviation(grey_, grey_squares_, sound_, images_);
}

MirrorRingFit FindRing(const MirrorActivity& activity) {
  MirrorRingFit result;
  constexpr int kMinImages = 3;
  constexpr double kMinGrey =
      4;  // grey levels, at the strongest motion: above noise and flicker of lamps
  result.fault = MirrorFault::kNothingMoves;
  if (activity.Images() < kMinImages) return result;
  const cv::Mat grey = activity.OfGrey();
  if (Quantile(grey, 0.9) < kMinGrey) return result;
  result.fault = MirrorFault::kNoRim;
  const cv::Mat moving = activity.OfLight();
  const double side = std::min(moving.cols, moving.rows);
  const std::optional<Circle> rough = FindCircle(OutlineOf(moving), 0.01 * side);
  if (!rough || rough->radius > side || rough->radius < 0.1 * side) return result;
  const std::optional<CircleFit> fit = FitRim(moving, *rough);
  if (!fit) return result;
  constexpr double kMinReachPx = 10;
  TakeRim(*fit, FallingEdges(moving, fit->circle, kMinReachPx), result);
  constexpr double kMinRim = 0.35;
  if (result.rim_ratio < kMinRim) return result;
  result.fault = MirrorFault::kNone;
  constexpr double kEdge = 0.5;
  constexpr double kCorner = 0.75;
  TakeBody(FirstRisingEdges(grey, fit->circle, kEdge),
           FirstRisingEdges(grey, fit->circle, kCorner),
           result);
  return result;
}

MirrorRingFit FindRing(const cv::Mat& image) {
  MirrorRingFit result;
  result.fault = MirrorFault::kNoRim;
  const cv::Mat grey = GreyOf(image);
  const std::optional<Circle> rough = DarkeningCircle(grey);
  if (!rough) return result;
  cv::Mat smooth;
  constexpr double kBlurPx = 1;
  cv::GaussianBlur(grey, smooth, {}, kBlurPx);
  smooth.convertTo(smooth, CV_32FC1);
  const double reach_px = 0.05 * rough->radius;
  std::optional<CircleFit> fit;
  Circle circle = *rough;
  std::vector<Vector2d> points;
  constexpr int kRounds = 3;
  for (int round = 0; round < kRounds; ++round) {
    points = SteepestFalls(smooth, circle, reach_px / (1 + round));
    fit = FitCircle(points, circle);
    if (!fit) return result;
    circle = fit->circle;
  }
  TakeRim(*fit, points, result);
  // A dark object in the room along a part of the rim may also cause the change: on two real
  // mirrors the error was 0.6 and 1.9 % of the radius.
  constexpr double kPart = 0.01;
  const double sigma_px = kPart * circle.radius;
  result.centre_covariance += sigma_px * sigma_px * Eigen::Matrix2d::Identity();
  result.outer_sigma_px = std::hypot(result.outer_sigma_px, sigma_px);
  constexpr double kMinRim = 0.25;
  if (result.rim_ratio < kMinRim) return result;
  result.fault = MirrorFault::kNone;
  if (const auto inner = BrighteningRadius(grey, circle)) {
    result.body_seen = true;
    result.ring.inner_radius_px = *inner;
    result.inner_sigma_px = kPart * circle.radius;
  } else {
    TakeBody({}, {}, result);
  }
  return result;
}

}  // namespace ceilmap::calibration
