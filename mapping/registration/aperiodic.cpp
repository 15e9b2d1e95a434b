#include "mapping/registration/aperiodic.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

namespace ceilmap::registration {
namespace {

constexpr float kNothing = std::numeric_limits<float>::quiet_NaN();

// The median of fewer copies shows what a place has of its own.
constexpr std::size_t kMinCopies = 4;
// What sticks out by so many typical deviations and grey levels is a thing, not grain.
constexpr float kThing = 4;
constexpr float kThingGrey = 2;
constexpr int kAroundPx = 5;  // side of the square by which things are enlarged
// A thing of this part of the shortest period fills a tile.
constexpr double kPanel = 0.85;
// Lines of the grid: where the periodic part sticks out by so many of its typical deviations.
constexpr float kLine = 3;
constexpr float kLineGrey = 4;
constexpr double kGrainSigmaPx = 5;  // slower changes are removed

/// Median of up to a few values; NaN where they are too few.
template <std::size_t N>
float Median(std::array<float, N>& values, std::size_t count) {
  if (count < kMinCopies) return kNothing;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(count / 2);
  std::nth_element(values.begin(), middle, values.begin() + static_cast<std::ptrdiff_t>(count));
  return *middle;
}

cv::Mat PeriodicPart(const cv::Mat& image, const std::vector<Eigen::Vector2d>& periods) {
  std::vector<cv::Mat> copies{image};
  for (const Eigen::Vector2d& period : periods) {
    copies.push_back(ShiftedBy(image, period));
    copies.push_back(ShiftedBy(image, -period));
  }
  constexpr std::size_t kMaxCopies = 16;
  copies.resize(std::min(copies.size(), kMaxCopies));
  cv::Mat part(image.size(), CV_32FC1);
  std::array<float, kMaxCopies> values{};
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      std::size_t count = 0;
      for (const cv::Mat& copy : copies) {
        const float grey = copy.at<float>(y, x);
        if (!std::isnan(grey)) values[count++] = grey;
      }
      part.at<float>(y, x) = Median(values, count);
    }
  }
  return part;
}

/// 255 where the absolute value exceeds a limit.
cv::Mat Exceeding(const cv::Mat& image, float limit) {
  cv::Mat exceeding = cv::abs(image) > limit;  // false of NaN
  return exceeding;
}

/// 255 where the image is NaN, and on its border.
cv::Mat Outside(const cv::Mat& image) {
  cv::Mat outside = image != image;
  cv::dilate(outside, outside, cv::Mat::ones(3, 3, CV_8U));
  cv::rectangle(outside, cv::Rect({0, 0}, image.size()), cv::Scalar(255));
  return outside;
}

/// Sorts things into marks and panels. @param things  255 on things.
void SortThings(const cv::Mat& things, double shortest_px, AperiodicPart& part) {
  part.marks = cv::Mat::zeros(things.size(), CV_8UC1);
  part.panels = things.clone();
  const cv::Mat outside = Outside(part.residual);
  cv::Mat labels;
  cv::Mat stats;
  cv::Mat centres;
  const int count = cv::connectedComponentsWithStats(things, labels, stats, centres);
  for (int i = 1; i < count; ++i) {
    const cv::Rect box(stats.at<int>(i, cv::CC_STAT_LEFT),
                       stats.at<int>(i, cv::CC_STAT_TOP),
                       stats.at<int>(i, cv::CC_STAT_WIDTH),
                       stats.at<int>(i, cv::CC_STAT_HEIGHT));
    const cv::Mat thing = labels(box) == i;
    std::vector<cv::Point> points;
    cv::findNonZero(thing, points);
    const cv::Size2f sides = cv::minAreaRect(points).size;
    const double length = std::max(sides.width, sides.height) - (kAroundPx - 1);
    if (length > kPanel * shortest_px || cv::countNonZero(outside(box) & thing) > 0) continue;
    part.marks(box).setTo(255, thing);
    part.panels(box).setTo(0, thing);
  }
}

/// Without changes that are slower than grain; NaN is left out.
cv::Mat WithoutSlowChanges(const cv::Mat& image) {
  const cv::Mat known = image == image;
  cv::Mat weight;
  known.convertTo(weight, CV_32F, 1.0 / 255);
  cv::Mat mean = image.clone();
  mean.setTo(0, ~known);
  cv::GaussianBlur(mean, mean, {}, kGrainSigmaPx);
  cv::GaussianBlur(weight, weight, {}, kGrainSigmaPx);
  constexpr double kMinWeight = 1e-3;
  return image - mean / cv::max(weight, kMinWeight);
}

}  // namespace

double ShortestOf(const std::vector<Eigen::Vector2d>& periods) {
  double shortest_px = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector2d& period : periods) shortest_px = std::min(shortest_px, period.norm());
  return shortest_px;
}

cv::Mat ShiftedBy(const cv::Mat& image, const Eigen::Vector2d& shift) {
  const cv::Matx23d from(1, 0, shift.x(), 0, 1, shift.y());
  cv::Mat shifted;
  cv::warpAffine(image,
                 shifted,
                 from,
                 image.size(),
                 cv::INTER_CUBIC | cv::WARP_INVERSE_MAP,
                 cv::BORDER_CONSTANT,
                 cv::Scalar(kNothing));
  return shifted;
}

float TypicalDeviation(const cv::Mat& image) {
  std::vector<float> values;
  values.reserve(image.total());
  for (int y = 0; y < image.rows; ++y) {
    const auto* row = image.ptr<float>(y);
    for (int x = 0; x < image.cols; ++x) {
      if (!std::isnan(row[x])) values.push_back(std::abs(row[x]));
    }
  }
  if (values.empty()) return kNothing;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  constexpr float kSigmaPerMedian = 1.4826F;
  return kSigmaPerMedian * *middle;
}

AperiodicPart SplitAperiodic(const cv::Mat& image, const std::vector<Eigen::Vector2d>& periods) {
  const cv::Mat periodic = PeriodicPart(image, periods);
  AperiodicPart part;
  part.residual = image - periodic;
  part.deviation = TypicalDeviation(part.residual);
  if (std::isnan(part.deviation)) return part;
  cv::Mat things = Exceeding(part.residual, kThing * part.deviation + kThingGrey);
  cv::morphologyEx(things, things, cv::MORPH_OPEN, cv::Mat::ones(2, 2, CV_8U));
  cv::dilate(things, things, cv::Mat::ones(kAroundPx, kAroundPx, CV_8U));
  SortThings(things, ShortestOf(periods), part);
  part.grain = part.residual.clone();
  part.grain.setTo(kNothing, things);
  part.grain = WithoutSlowChanges(part.grain);
  part.grain.setTo(kNothing, Exceeding(periodic, kLine * TypicalDeviation(periodic) + kLineGrey));
  return part;
}

}  // namespace ceilmap::registration
