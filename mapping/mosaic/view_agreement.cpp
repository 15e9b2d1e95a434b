#include "mapping/mosaic/view_agreement.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "mapping/mosaic/levelling.hpp"

namespace ceilmap::mosaic {
namespace {

constexpr int kReduction = 8;  // reduction of the thumbnails
constexpr int kCellPx = 8;     // mosaic pixels
/// Relative differences from the median at which a view starts to be an outlier, and at which it is
/// one entirely. Levelled images of the same ceiling agree to one or two percent.
constexpr float kAgreementLimit = 0.1F;
constexpr float kOutlier = 0.2F;
constexpr float kDarkGrey = 32;  // lower bound of the grey value in relative differences
/// Small enough to outweigh any feather weight, but not 0: where no other view sees the ceiling,
/// the view still counts.
constexpr float kOutlierFactor = 1e-9F;
constexpr std::size_t kMinViews = 3;
constexpr float kMaxAgree = 0.6F;

int FloorDiv(int value, int divisor) {
  return value >= 0 ? value / divisor : -((divisor - 1 - value) / divisor);
}

float Factor(float grey, float median) {
  const float difference = std::abs(grey - median) / std::max(median, kDarkGrey);
  const float excess =
      std::clamp((difference - kAgreementLimit) / (kOutlier - kAgreementLimit), 0.0F, 1.0F);
  return std::max(1 - excess, kOutlierFactor);
}

float Median(std::vector<float>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return 0.5F * (*middle + *std::max_element(values.begin(), middle));
}

/// What the views show that agree: their median; where less than kMaxAgree of them agree with it,
/// the middle of the third that differs least. Blades of a fan may cover a place in more than half
/// of the images, but each image shows other parts of them in another light.
float Agreed(std::vector<float>& values) {
  const float median = Median(values);
  const auto agree = std::count_if(values.begin(), values.end(), [&](float value) {
    return std::abs(value - median) <= kAgreementLimit * std::max(median, kDarkGrey);
  });
  const std::size_t third = (values.size() + 2) / 3;
  if (third < kMinViews || static_cast<float>(agree) >= kMaxAgree * values.size()) return median;
  std::sort(values.begin(), values.end());
  const auto spread = [&](std::size_t i) {
    return (values[i + third - 1] - values[i]) / std::max(values[i], kDarkGrey);
  };
  std::size_t best = 0;
  for (std::size_t i = 1; i + third <= values.size(); ++i) {
    if (spread(i) <= spread(best)) best = i;
  }
  return values[best + third / 2];
}

}  // namespace

void Thumbnails::Add(const cv::Mat& image) {
  const cv::Size size(std::max(view_size_.width / kReduction, 1),
                      std::max(view_size_.height / kReduction, 1));
  cv::Mat small;
  cv::resize(image, small, size, 0, 0, cv::INTER_AREA);
  images_.push_back(small);
}

void Thumbnails::Level(const std::vector<float>& gain_factors, const cv::Mat& shading) {
  for (std::size_t k = 0; k < images_.size(); ++k) {
    cv::Mat& small = images_[k];
    for (int v = 0; v < small.rows; ++v) {
      const auto* row = shading.ptr<Shading>((2 * v + 1) * view_size_.height / (2 * small.rows));
      for (int u = 0; u < small.cols; ++u) {
        const Shading& shade = row[(2 * u + 1) * view_size_.width / (2 * small.cols)];
        auto& grey = small.at<unsigned char>(v, u);
        grey = cv::saturate_cast<unsigned char>(
            LevelGrey(static_cast<float>(grey), gain_factors[k] * shade[1]));
      }
    }
  }
}

float Thumbnails::At(int view, const cv::Point2d& pixel) const {
  if (!(pixel.x >= 0 && pixel.y >= 0 && pixel.x <= view_size_.width - 1 &&
        pixel.y <= view_size_.height - 1)) {
    return -1;
  }
  const cv::Mat& small = images_[static_cast<std::size_t>(view)];
  const double x = (pixel.x + 0.5) * small.cols / view_size_.width - 0.5;
  const double y = (pixel.y + 0.5) * small.rows / view_size_.height - 0.5;
  const int u = std::clamp(static_cast<int>(std::floor(x)), 0, std::max(small.cols - 2, 0));
  const int v = std::clamp(static_cast<int>(std::floor(y)), 0, std::max(small.rows - 2, 0));
  const auto fu = static_cast<float>(std::clamp(x - u, 0.0, 1.0));
  const auto fv = static_cast<float>(std::clamp(y - v, 0.0, 1.0));
  const int next_u = std::min(u + 1, small.cols - 1);
  const auto* top = small.ptr<unsigned char>(v);
  const auto* bottom = small.ptr<unsigned char>(std::min(v + 1, small.rows - 1));
  const float upper = (1 - fu) * top[u] + fu * top[next_u];
  const float lower = (1 - fu) * bottom[u] + fu * bottom[next_u];
  return (1 - fv) * upper + fv * lower;
}

float Agreement::At(int col, int row) const {
  const float x = (static_cast<float>(col) + 0.5F) / kCellPx - 0.5F;
  const float y = (static_cast<float>(row) + 0.5F) / kCellPx - 0.5F;
  const float u = std::floor(x);
  const float v = std::floor(y);
  const float fu = x - u;
  const float fv = y - v;
  const auto* top = cells_.ptr<float>(static_cast<int>(v) - first_cell_.y) +
                    (static_cast<int>(u) - first_cell_.x);
  const auto* bottom = top + cells_.step1();
  return (1 - fv) * ((1 - fu) * top[0] + fu * top[1]) +
         fv * ((1 - fu) * bottom[0] + fu * bottom[1]);
}

double AgreementAt(const cv::Point2d& p_map,
                   float rho,
                   const std::vector<ViewPlacement>& views,
                   const std::vector<int>& candidates,
                   const Thumbnails& thumbnails) {
  std::vector<float> seen;
  for (const int k : candidates) {
    const ViewPlacement& view = views[static_cast<std::size_t>(k)];
    const float grey = thumbnails.At(k, view.ToPixel(p_map.x, p_map.y, rho));
    if (grey >= 0) seen.push_back(grey);
  }
  if (seen.size() < kMinViews) return 1;
  const float agreed = Agreed(seen);
  const auto agree = std::count_if(
      seen.begin(), seen.end(), [&](float grey) { return Factor(grey, agreed) == 1; });
  return static_cast<double>(agree) / static_cast<double>(seen.size());
}

std::vector<Agreement> CompareViews(const cv::Rect& tile,
                                    const store::MosaicGrid& grid,
                                    const std::vector<ViewPlacement>& views,
                                    const std::vector<int>& candidates,
                                    const Thumbnails& thumbnails,
                                    const HeightMap& heights) {
  std::vector<Agreement> agreements(candidates.size());
  if (candidates.size() < (heights.empty() ? kMinViews : 2)) return agreements;
  // Cells around the tile: one more on each side for the interpolation, one for the erosion.
  const cv::Point first(FloorDiv(tile.x, kCellPx) - 2, FloorDiv(tile.y, kCellPx) - 2);
  const cv::Size size(FloorDiv(tile.br().x - 1, kCellPx) + 3 - first.x,
                      FloorDiv(tile.br().y - 1, kCellPx) + 3 - first.y);
  std::vector<float> greys(candidates.size());
  std::vector<float> seen;
  const auto set = [&](std::size_t i, int row, int col, float factor) {
    cv::Mat& cells = agreements[i].cells_;
    if (cells.empty()) cells = cv::Mat(size, CV_32FC1, cv::Scalar(1));
    cells.at<float>(row, col) = factor;
  };
  for (int row = 0; row < size.height; ++row) {
    const double y = grid.max_y - (first.y + row + 0.5) * kCellPx * grid.resolution;
    for (int col = 0; col < size.width; ++col) {
      const double x = grid.min_x + (first.x + col + 0.5) * kCellPx * grid.resolution;
      const float rho = heights.empty() ? 0 : heights.RatioAt(x, y);
      seen.clear();
      for (std::size_t i = 0; i < candidates.size(); ++i) {
        const int k = candidates[i];
        const ViewPlacement& view = views[static_cast<std::size_t>(k)];
        greys[i] = thumbnails.At(k, rho > 0 ? view.ToPixel(x, y, rho) : view.ToPixel(x, y));
        if (greys[i] >= 0 && rho > 0 && !heights.Sees(view, {x, y}, rho)) {
          set(i, row, col, kOutlierFactor);
          greys[i] = -1;
        }
        if (greys[i] >= 0) seen.push_back(greys[i]);
      }
      if (seen.size() < kMinViews) continue;
      const float agreed = Agreed(seen);
      for (std::size_t i = 0; i < candidates.size(); ++i) {
        const float factor = greys[i] < 0 ? 1 : Factor(greys[i], agreed);
        if (factor != 1) set(i, row, col, factor);
      }
    }
  }
  for (Agreement& agreement : agreements) {
    agreement.first_cell_ = first;
    if (agreement.IsFull()) continue;
    // A cell that an outlier covers by half shows half of the difference: the neighbours of outlier
    // cells are excluded as well.
    cv::erode(
        agreement.cells_, agreement.cells_, cv::Mat(), cv::Point(-1, -1), 1, cv::BORDER_REPLICATE);
  }
  return agreements;
}

}  // namespace ceilmap::mosaic
