#include "localization/keyframe_drawing.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace ceilmap::localization {
namespace {

constexpr std::size_t kKeptImages = 24;  // in memory, 0.3 MB each for 640 x 480 px
constexpr int kMaxKeyframes = 8;         // of one view
// A keyframe that shows less of the view is not used for it, as a fraction.
constexpr double kMinShown = 0.01;
constexpr int kBlockPx = 8;      // parts of the view that are taken from one keyframe
constexpr double kBorderPx = 2;  // of an image, for the interpolation

}  // namespace

KeyframeDrawing::KeyframeDrawing(const store::MapReader& map, const DepthDrawing* depth)
    : map_(map), depth_(depth), images_(kKeptImages) {
  if (depth == nullptr || !depth->HasDepth()) return;
  const std::vector<graph::Keyframe> keyframes = map.ReadKeyframes();
  views_ = mosaic::PlaceViews(keyframes, map.Metadata());
  ids_.reserve(keyframes.size());
  for (const graph::Keyframe& keyframe : keyframes) ids_.push_back(keyframe.id);
  const cv::Size size = map.Metadata().view_size;
  span_ = std::max(size.width, size.height) * map.Metadata().view_units_per_px;
}

std::vector<std::size_t> KeyframeDrawing::Nearest(const cv::Point2d& foot) const {
  std::vector<std::pair<double, std::size_t>> near;
  for (std::size_t k = 0; k < views_.size(); ++k) {
    const double distance = cv::norm(views_[k].Foot() - foot);
    if (distance < span_) near.emplace_back(distance, k);
  }
  std::sort(near.begin(), near.end());
  std::vector<std::size_t> keyframes;
  keyframes.reserve(near.size());
  for (const auto& [distance, k] : near) keyframes.push_back(k);
  return keyframes;
}

/// Whether the keyframe's image has the complete block, and nothing hides its middle.
bool KeyframeDrawing::Shows(std::size_t keyframe,
                            const SeenSurface& seen,
                            const cv::Rect& block) const {
  const mosaic::ViewPlacement& view = views_[keyframe];
  const cv::Size size = map_.Metadata().view_size;
  const cv::Mat& content = map_.Metadata().view_mask;
  const auto place = [&](const cv::Point& at) {
    const auto& p = seen.places.at<cv::Vec2f>(at);
    return seen.origin + cv::Point2d(p[0], p[1]);
  };
  const auto has = [&](const cv::Point& at) {
    const cv::Point2d p = place(at);
    const cv::Point2d pixel = view.ToPixel(p.x, p.y, seen.ratios.at<float>(at));
    if (pixel.x < kBorderPx || pixel.y < kBorderPx || pixel.x > size.width - 1 - kBorderPx ||
        pixel.y > size.height - 1 - kBorderPx) {
      return false;
    }
    return content.empty() || content.at<unsigned char>(cv::Point(pixel)) != 0;
  };
  const cv::Point last = block.br() - cv::Point(1, 1);
  if (!has(block.tl()) || !has(last) || !has({last.x, block.y}) || !has({block.x, last.y})) {
    return false;
  }
  const cv::Point middle = (block.tl() + last) / 2;
  return depth_->Heights().Sees(view, place(middle), seen.ratios.at<float>(middle));
}

cv::Mat KeyframeDrawing::ImageOf(std::size_t keyframe, int factor) {
  if (factor != factor_) {
    images_ = LruCache<cv::Mat>(kKeptImages);
    factor_ = factor;
  }
  if (const cv::Mat* known = images_.Find(ids_[keyframe])) return *known;
  cv::Mat image = map_.ReadImage(ids_[keyframe]);
  if (factor > 1) {
    const int right = (factor - image.cols % factor) % factor;
    const int bottom = (factor - image.rows % factor) % factor;
    cv::copyMakeBorder(image, image, 0, bottom, 0, right, cv::BORDER_REPLICATE);
    cv::resize(image, image, image.size() / factor, 0, 0, cv::INTER_AREA);
  }
  images_.Insert(ids_[keyframe], image);
  return image;
}

void KeyframeDrawing::Draw(const mosaic::ViewPlacement& view,
                           double units_per_px,
                           const SeenSurface& seen,
                           cv::Mat& grey,
                           cv::Mat& mask) {
  const cv::Size size = seen.ratios.size();
  grey.create(size, CV_8UC1);
  grey.setTo(0);
  mask.create(size, CV_8UC1);
  mask.setTo(0);
  // For a camera of lower resolution, means of the map's pixels are used.
  const int factor =
      std::max(1, static_cast<int>(std::lround(units_per_px / map_.Metadata().view_units_per_px)));
  std::vector<cv::Rect> left;
  for (int v = 0; v < size.height; v += kBlockPx) {
    for (int u = 0; u < size.width; u += kBlockPx) {
      left.push_back(cv::Rect(u, v, kBlockPx, kBlockPx) & cv::Rect({0, 0}, size));
    }
  }
  cv::Mat sources(size, CV_32FC2);
  cv::Mat drawn;
  const auto few = static_cast<std::ptrdiff_t>(kMinShown * static_cast<double>(left.size()));
  int used = 0;
  for (const std::size_t k : Nearest(view.Foot())) {
    const auto shown = std::partition(
        left.begin(), left.end(), [&](const cv::Rect& block) { return !Shows(k, seen, block); });
    if (std::distance(shown, left.end()) <= few) continue;
    cv::Rect area = *shown;
    for (auto block = shown; block != left.end(); ++block) area |= *block;
    for (auto block = shown; block != left.end(); ++block) mask(*block).setTo(255);
    for (int v = area.y; v < area.br().y; ++v) {
      for (int u = area.x; u < area.br().x; ++u) {
        const auto& p = seen.places.at<cv::Vec2f>(v, u);
        const cv::Point2d at = views_[k].ToPixel(
            seen.origin.x + p[0], seen.origin.y + p[1], seen.ratios.at<float>(v, u));
        sources.at<cv::Vec2f>(v, u) = {static_cast<float>((at.x + 0.5) / factor - 0.5),
                                       static_cast<float>((at.y + 0.5) / factor - 0.5)};
      }
    }
    cv::remap(ImageOf(k, factor), drawn, sources(area), {}, cv::INTER_CUBIC, cv::BORDER_REPLICATE);
    for (auto block = shown; block != left.end(); ++block) {
      drawn(*block - area.tl()).copyTo(grey(*block));
    }
    left.erase(shown, left.end());
    if (++used == kMaxKeyframes || std::ssize(left) <= few) break;
  }
}

}  // namespace ceilmap::localization
