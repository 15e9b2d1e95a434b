#include "mapping/registration/periods.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "mapping/registration/aperiodic.hpp"

namespace ceilmap::registration {
namespace {

constexpr double kLongest = 0.55;  // period, per shorter side: so that it is seen twice
// Per longer side: grilles and slats of lamps have shorter ones, and are no grid.
constexpr double kShortest = 0.09;
constexpr std::size_t kMaxPeriods = 6;
// Autocorrelation from which a shift is a period. Grain and lamps leave 0.18 of a grid.
constexpr double kMinAutocorrelation = 0.12;
// Lines and edges alone are compared, and lamps do not outweigh them: what is broader than this is
// removed, and the rest is cut off at so many typical deviations.
constexpr double kLineSigmaPx = 3;
constexpr double kClip = 3;
// ... and this part of that of the clearest period: one set of lines alone agrees with itself under
// all shifts along them.
constexpr double kMinOfClearest = 0.75;
constexpr int kNeighbourhoodPx = 9;  // in which a peak is the highest

cv::Size PaddedFor(cv::Size size) {
  return {FastFftSize(2 * size.width), FastFftSize(2 * size.height)};
}

struct Peak {
  double height = 0;
  double rank = 0;  // height, times the root of the common area: less is by chance
  Eigen::Vector2d shift;
};

/// Vertex of the parabola through three samples, from the middle one.
double Vertex(double before, double at, double after) {
  const double curvature = before - 2 * at + after;
  return curvature < 0 ? std::clamp(0.5 * (before - after) / curvature, -0.5, 0.5) : 0.0;
}

/// Of one half plane: an autocorrelation is symmetric.
std::vector<Peak> PeaksOf(const cv::Mat& surface,
                          const cv::Mat& of_window,
                          int reach,
                          double shortest_px) {
  cv::Mat highest;
  cv::dilate(surface, highest, cv::Mat::ones(kNeighbourhoodPx, kNeighbourhoodPx, CV_8U));
  std::vector<Peak> peaks;
  for (int y = 0; y < reach; ++y) {
    for (int x = y == 0 ? 1 : 1 - reach; x < reach; ++x) {
      const int row = y + reach;
      const int column = x + reach;
      const double at = surface.at<float>(row, column);
      if (at < kMinAutocorrelation || at < highest.at<float>(row, column)) continue;
      if (std::hypot(x, y) < shortest_px) continue;
      const auto sample = [&](int dx, int dy) { return surface.at<float>(row + dy, column + dx); };
      peaks.push_back({at,
                       at * std::sqrt(std::max(0.0F, of_window.at<float>(row, column))),
                       {x + Vertex(sample(-1, 0), at, sample(1, 0)),
                        y + Vertex(sample(0, -1), at, sample(0, 1))}});
    }
  }
  std::sort(
      peaks.begin(), peaks.end(), [](const Peak& a, const Peak& b) { return a.rank > b.rank; });
  return peaks;
}

}  // namespace

PeriodFinder::PeriodFinder(cv::Size size)
    : size_(size),
      reach_(static_cast<int>(kLongest * std::min(size.width, size.height))),
      fft_(PaddedFor(size).height, PaddedFor(size).width),
      padded_(PaddedFor(size)),
      plane_(fft_.RealSize()),
      spectrum_(fft_.SpectrumSize()) {
  cv::createHanningWindow(window_, size, CV_32F);
  of_window_ = Autocorrelation(window_);
}

/// Shifts of -reach_ .. reach_ along both axes, zero shift in the middle.
cv::Mat PeriodFinder::Autocorrelation(const cv::Mat& weighted) {
  cv::Mat plane(padded_, CV_32FC1, plane_.data());
  plane.setTo(0);
  weighted.copyTo(plane(cv::Rect({0, 0}, size_)));
  fft_.Forward({plane_.data(), plane_.size()}, {spectrum_.data(), spectrum_.size()});
  for (std::size_t i = 0; i < spectrum_.size(); ++i) spectrum_[i] = std::norm(spectrum_[i]);
  fft_.Inverse({spectrum_.data(), spectrum_.size()}, {plane_.data(), plane_.size()});
  cv::Mat surface(2 * reach_ + 1, 2 * reach_ + 1, CV_32FC1);
  for (int y = -reach_; y <= reach_; ++y) {
    for (int x = -reach_; x <= reach_; ++x) {
      surface.at<float>(y + reach_, x + reach_) = plane.at<float>(
          (y + padded_.height) % padded_.height, (x + padded_.width) % padded_.width);
    }
  }
  return surface;
}

std::vector<Eigen::Vector2d> PeriodFinder::Find(const cv::Mat& image) {
  cv::Mat lines = image.clone();
  const cv::Mat unknown = image != image;
  lines.setTo(0, unknown);
  cv::Mat broad;
  cv::GaussianBlur(lines, broad, {}, kLineSigmaPx);
  lines -= broad;
  const double limit = kClip * TypicalDeviation(lines);
  const cv::Mat clipped = cv::max(cv::min(lines, limit), -limit);
  cv::Mat weighted = clipped.mul(window_);
  weighted.setTo(0, unknown);
  cv::Mat surface = Autocorrelation(weighted) / of_window_;
  const float itself = surface.at<float>(reach_, reach_);
  if (!(itself > 0)) return {};
  surface /= itself;
  std::vector<Eigen::Vector2d> periods;
  const std::vector<Peak> peaks =
      PeaksOf(surface, of_window_, reach_, kShortest * std::max(size_.width, size_.height));
  for (const Peak& peak : peaks) {
    if (periods.size() == kMaxPeriods) break;
    if (peak.height >= kMinOfClearest * peaks.front().height) periods.push_back(peak.shift);
  }
  return periods;
}

}  // namespace ceilmap::registration
