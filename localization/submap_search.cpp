#include "localization/submap_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <thread>
#include <vector>

#include "calib/base/parallel.hpp"
#include "mapping/registration/fft.hpp"

namespace ceilmap::localization {

using registration::ComplexArray;
using registration::PlaneFft;
using registration::RealArray;

namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr int kRotations = 90;
constexpr double kMaxPixels = 2.5e5;  // of the map
// Travel that is searched with, and that the pose is found by, image spans. On a longer way the
// robot's own motion distorts the submap.
constexpr double kSearchedSpans = 2;
constexpr double kPlacedSpans = 1;
constexpr double kMinOverlap = 0.4;  // of the submap with the map
// Poses nearer to each other count as the same place.
constexpr int kSamePlacePx = 12;
constexpr double kSamePlaceRad = 12 * kDegree;
// Standard deviations of a pose found, of which most comes from the distortion of the submap.
constexpr double kPlaceSigmaPx = 3;
constexpr double kPlaceSigmaRad = 3 * kDegree;

struct Peak {
  double score = 0;
  double yaw = 0;
  cv::Point at;
};

bool SamePlace(const Peak& a, const Peak& b) {
  const cv::Point d = a.at - b.at;
  return d.dot(d) < kSamePlacePx * kSamePlacePx &&
         std::abs(WrapAngle(a.yaw - b.yaw)) < kSamePlaceRad;
}

ComplexArray Transform(PlaneFft& fft, const cv::Mat& plane) {
  ComplexArray out(fft.SpectrumSize());
  RealArray in(fft.RealSize());
  std::copy_n(plane.ptr<float>(), in.size(), in.data());
  fft.Forward({in.data(), in.size()}, {out.data(), out.size()});
  return out;
}

/// Correlation of a drawing with the map, both in a plane with room for the drawing around the map:
/// of the grey values, and of the directions of the edges. Their noise is independent, and each
/// tells what the other does not: the directions are the same under other light, which makes dark
/// of bright; the grey values are not the same in a room that is turned by half a circle.
class Correlation {
 public:
  Correlation(const FineStructure& map, const FineStructure& drawing)
      : drawn_detail_{drawing.detail},
        map_size_(map.detail.size()),
        size_(cv::getOptimalDFTSize(map_size_.width + drawing.detail.cols),
              cv::getOptimalDFTSize(map_size_.height + drawing.detail.rows)) {
    const auto to_planes = [](const std::array<cv::Mat, 2>& parts) -> Planes {
      return {parts[0], parts[1]};
    };
    drawn_directions_ = to_planes(drawing.Directions());
    const double known = cv::sum(map.known)[0];
    detail_ = Prepare({map.detail}, known, drawn_detail_);
    directions_ = Prepare(to_planes(map.Directions()), known, drawn_directions_);
  }

  /// Scores where the drawing's centre lies on each pixel of the map, turned by `yaw`: standard
  /// normal for structure that has nothing in common.
  [[nodiscard]] cv::Mat At(double yaw) const {
    const Planes directions = Turned(drawn_directions_, yaw);
    const double c = std::cos(2 * yaw);
    const double s = std::sin(2 * yaw);
    const cv::Mat sum =
        Score(detail_, Turned(drawn_detail_, yaw)) +
        Score(directions_,
              {c * directions[0] - s * directions[1], s * directions[0] + c * directions[1]});
    return std::sqrt(0.5) * sum;
  }

 private:
  using Planes = std::vector<cv::Mat>;
  /// One kind of structure of the map: of one plane or two.
  struct Kind {
    std::vector<ComplexArray> values;
    ComplexArray squares;
    double least_variance = 0;
  };

  static cv::Mat SquaresOf(const Planes& planes) {
    cv::Mat sum = cv::Mat::zeros(planes.front().size(), CV_32FC1);
    for (const cv::Mat& plane : planes) sum += plane.mul(plane);
    return sum;
  }

  /// @param known  Number of pixels of the map.
  [[nodiscard]] Kind Prepare(const Planes& map, double known, const Planes& drawn) const {
    PlaneFft fft(size_.height, size_.width);
    const cv::Size side = drawn.front().size();
    const auto transform = [&](const cv::Mat& plane) {
      cv::Mat padded = cv::Mat::zeros(size_, CV_32FC1);
      plane.copyTo(padded(cv::Rect({side.width / 2, side.height / 2}, map_size_)));
      return Transform(fft, padded);
    };
    Kind kind;
    kind.values.reserve(map.size());
    for (const cv::Mat& plane : map) kind.values.push_back(transform(plane));
    const cv::Mat squares = SquaresOf(map);
    kind.squares = transform(squares);
    const double variance = cv::sum(squares)[0] / known;
    kind.least_variance =
        kMinOverlap * variance * cv::sum(SquaresOf(drawn))[0] / static_cast<double>(map.size());
    return kind;
  }

  [[nodiscard]] static Planes Turned(const Planes& drawn, double yaw) {
    const double c = std::cos(yaw);
    const double s = std::sin(yaw);
    const double half = 0.5 * drawn.front().cols;
    const cv::Matx23d affine(c, -s, half - c * half + s * half, s, c, half - s * half - c * half);
    Planes turned(drawn.size());
    for (std::size_t i = 0; i < drawn.size(); ++i) {
      cv::warpAffine(drawn[i], turned[i], affine, drawn[i].size(), cv::INTER_LINEAR);
    }
    return turned;
  }

  [[nodiscard]] cv::Mat Score(const Kind& map, const Planes& turned) const {
    PlaneFft fft(size_.height, size_.width);
    const auto transform = [&](const cv::Mat& plane) {
      cv::Mat padded = cv::Mat::zeros(size_, CV_32FC1);
      plane.copyTo(padded(cv::Rect({0, 0}, plane.size())));
      return Transform(fft, padded);
    };
    ComplexArray sum = Product(map.values[0], transform(turned[0]));
    for (std::size_t plane = 1; plane < turned.size(); ++plane) {
      const ComplexArray more = Product(map.values[plane], transform(turned[plane]));
      for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += more[i];
    }
    const RealArray products = Inverse(fft, sum);
    ComplexArray squares = Product(map.squares, transform(SquaresOf(turned)));
    const RealArray variances = Inverse(fft, squares);
    const double norm = 1.0 / static_cast<double>(products.size());
    const double variance_norm = norm / static_cast<double>(turned.size());
    cv::Mat scores(map_size_, CV_32FC1);
    for (int y = 0; y < map_size_.height; ++y) {
      for (int x = 0; x < map_size_.width; ++x) {
        const std::size_t i = static_cast<std::size_t>(y) * size_.width + x;
        const double variance = variances[i] * variance_norm;
        scores.at<float>(y, x) = static_cast<float>(
            variance > map.least_variance ? products[i] * norm / std::sqrt(variance) : 0);
      }
    }
    return scores;
  }

  static ComplexArray Product(const ComplexArray& map, ComplexArray drawn) {
    for (std::size_t i = 0; i < drawn.size(); ++i) drawn[i] = map[i] * std::conj(drawn[i]);
    return drawn;
  }

  static RealArray Inverse(PlaneFft& fft, ComplexArray& spectrum) {
    RealArray out(fft.RealSize());
    fft.Inverse({spectrum.data(), spectrum.size()}, {out.data(), out.size()});
    return out;
  }

  Planes drawn_detail_;
  Planes drawn_directions_;
  cv::Size map_size_;
  cv::Size size_;
  Kind detail_;
  Kind directions_;
};

}  // namespace

struct SubmapSearch::Impl {
  explicit Impl(const store::MapReader& m) : map(m) {}

  const store::MapReader& map;
  FineStructure structure;  // of the map, rows along y
  double unit = 0;          // map units per pixel of it
  double min_x = 0;
  double min_y = 0;

  bool Read(double wanted_unit);
  [[nodiscard]] std::vector<Peak> SearchAll(const Submap::Drawing& drawing,
                                            const std::function<bool(double yaw)>& wanted) const;
  [[nodiscard]] Pose2 PoseAt(const Peak& peak) const;
  [[nodiscard]] Pose2 Refine(const Submap::Drawing& drawing, const Pose2& near) const;
};

/// False where the map has no mosaic, or is too large.
bool SubmapSearch::Impl::Read(double wanted_unit) {
  if (unit == wanted_unit) return !structure.detail.empty();
  unit = wanted_unit;
  structure = {};
  const store::MosaicGrid& grid = map.Grid();
  const cv::Size size(static_cast<int>(grid.width_px * grid.resolution / unit),
                      static_cast<int>(grid.height_px * grid.resolution / unit));
  if (size.empty() || static_cast<double>(size.area()) > kMaxPixels) return false;
  cv::Mat grey;
  cv::Mat alpha;
  const store::MosaicGrid overview =
      map.ReadOverview(2 * std::max(size.width, size.height), grey, alpha);
  // From the lower left corner: rows along y.
  cv::flip(grey, grey, 0);
  cv::flip(alpha, alpha, 0);
  min_x = overview.min_x;
  min_y = overview.max_y - overview.height_px * overview.resolution;
  const double scale = overview.resolution / unit;
  const cv::Matx23d affine(scale, 0, 0.5 * scale - 0.5, 0, scale, 0.5 * scale - 0.5);
  constexpr double kBlur = 0.5;  // of a pixel of the result
  cv::GaussianBlur(grey, grey, {}, std::max(0.3, kBlur / scale));
  cv::Mat reduced;
  cv::Mat known;
  cv::warpAffine(grey, reduced, affine, size, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  cv::warpAffine(alpha, known, affine, size, cv::INTER_LINEAR, cv::BORDER_CONSTANT, cv::Scalar(0));
  cv::threshold(known, known, 254, 255, cv::THRESH_BINARY);
  structure = FineStructure::Of(reduced, known);
  structure.Compress();
  structure.detail = structure.detail.mul(structure.known);
  return true;
}

SubmapSearch::SubmapSearch(const store::MapReader& map) : impl_(std::make_unique<Impl>(map)) {}
SubmapSearch::~SubmapSearch() = default;

double SubmapSearch::Result::Lead() const {
  constexpr double kMinSecond = 1e-9;
  return score / std::max(second, kMinSecond);
}

std::optional<SubmapSearch::Result> SubmapSearch::Find(
    const Submap& submap, const std::function<bool(double yaw)>& wanted) {
  Impl& me = *impl_;
  if (!me.Read(submap.Unit())) return std::nullopt;
  const Submap::Drawing drawing = submap.Draw(kSearchedSpans * submap.Span());
  const std::vector<Peak> peaks = me.SearchAll(drawing, wanted);
  if (peaks.empty()) return std::nullopt;
  const Peak& best = peaks.front();
  Result result;
  result.score = best.score;
  const auto other = std::find_if(
      peaks.begin(), peaks.end(), [&](const Peak& peak) { return !SamePlace(peak, best); });
  if (other != peaks.end()) result.second = other->score;
  result.pose.pose = me.Refine(submap.Draw(kPlacedSpans * submap.Span()),
                               me.PoseAt(best) * drawing.T_drawing_base);
  const double sigma = kPlaceSigmaPx * me.unit;
  result.pose.covariance.setZero();
  result.pose.covariance.diagonal() << sigma * sigma, sigma * sigma,
      kPlaceSigmaRad * kPlaceSigmaRad;
  return result;
}

/// Peaks of all rotations, the highest first.
std::vector<Peak> SubmapSearch::Impl::SearchAll(
    const Submap::Drawing& drawing, const std::function<bool(double yaw)>& wanted) const {
  const Correlation correlation(structure, drawing.structure);
  std::vector<Peak> peaks;
  std::mutex lock;
  const auto search = [&](int rotation) {
    const double yaw = WrapAngle(rotation * 2 * std::numbers::pi / kRotations);
    if (wanted && !wanted(WrapAngle(yaw + drawing.T_drawing_base.yaw))) return;
    cv::Mat scores = correlation.At(yaw);
    for (int k = 0; k < 2; ++k) {
      Peak peak;
      peak.yaw = yaw;
      cv::minMaxLoc(scores, nullptr, &peak.score, nullptr, &peak.at);
      if (peak.score <= 0) return;
      cv::circle(scores, peak.at, kSamePlacePx, cv::Scalar(0), cv::FILLED);
      const std::lock_guard guard(lock);
      peaks.push_back(peak);
    }
  };
  ParallelFor(kRotations, static_cast<int>(std::thread::hardware_concurrency()), search);
  std::sort(peaks.begin(), peaks.end(), [](const Peak& a, const Peak& b) {
    return a.score != b.score ? a.score > b.score : a.yaw < b.yaw;
  });
  return peaks;
}

Pose2 SubmapSearch::Impl::PoseAt(const Peak& peak) const {
  return {min_x + (peak.at.x + 0.5) * unit, min_y + (peak.at.y + 0.5) * unit, peak.yaw};
}

/// The best pose near one, in finer steps of the rotation.
Pose2 SubmapSearch::Impl::Refine(const Submap::Drawing& drawing, const Pose2& near) const {
  constexpr int kSteps = 6;
  constexpr double kStepRad = 1.5 * kDegree;
  const Pose2 T_map_drawing = near * drawing.T_drawing_base.Inverse();
  const auto pixel = [&](double at, double first) {
    return static_cast<int>(std::lround((at - first) / unit - 0.5));
  };
  const cv::Point centre(pixel(T_map_drawing.x, min_x), pixel(T_map_drawing.y, min_y));
  const cv::Point reach(kSamePlacePx, kSamePlacePx);
  const cv::Rect region =
      cv::Rect(centre - reach, centre + reach) & cv::Rect({0, 0}, structure.detail.size());
  if (region.empty()) return near;
  const Correlation correlation(structure, drawing.structure);
  Peak best;
  for (int step = -kSteps; step <= kSteps; ++step) {
    Peak peak;
    peak.yaw = WrapAngle(T_map_drawing.yaw + step * kStepRad);
    const cv::Mat scores = correlation.At(peak.yaw);
    cv::minMaxLoc(scores(region), nullptr, &peak.score, nullptr, &peak.at);
    peak.at += region.tl();
    if (peak.score > best.score) best = peak;
  }
  return best.score > 0 ? PoseAt(best) * drawing.T_drawing_base : near;
}

}  // namespace ceilmap::localization
