#include "calib/remap_table.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "calib/base/hot.hpp"

namespace ceilmap::calib {
namespace {

constexpr int kPartBits = 11;
constexpr std::uint32_t kOne = 1U << kPartBits;
constexpr int kShift = 2 * kPartBits;
constexpr std::uint32_t kHalf = 1U << (kShift - 1);

}  // namespace

RemapTable::Tap RemapTable::MakeTap(cv::Point2d at, cv::Size raw) {
  constexpr double kRounding = 0.5 / kOne;  // rounding may place a border pixel outside the image
  const double right = raw.width - 1;
  const double bottom = raw.height - 1;
  if (!(at.x >= -kRounding && at.x <= right + kRounding && at.y >= -kRounding &&
        at.y <= bottom + kRounding)) {
    return {};
  }
  const double x = std::clamp(at.x, 0.0, right);
  const double y = std::clamp(at.y, 0.0, bottom);
  const double x0 = std::min(std::floor(x), right - 1);
  const double y0 = std::min(std::floor(y), bottom - 1);
  return {static_cast<std::int16_t>(x0),
          static_cast<std::int16_t>(y0),
          static_cast<std::uint16_t>(std::lround((x - x0) * kOne)),
          static_cast<std::uint16_t>(std::lround((y - y0) * kOne))};
}

RemapTable::RemapTable(cv::Size raw, cv::Size result, const Source& source)
    : raw_size_(raw), size_(result) {
  taps_.reserve(static_cast<std::size_t>(result.area()));
  for (int v = 0; v < result.height; ++v) {
    for (int u = 0; u < result.width; ++u) {
      const std::optional<cv::Point2d> at = source(u, v);
      taps_.push_back(at ? MakeTap(*at, raw) : Tap{});
    }
  }
}

cv::Mat RemapTable::Mask() const {
  cv::Mat mask(size_, CV_8UC1);
  std::transform(taps_.begin(), taps_.end(), mask.begin<std::uint8_t>(), [](const Tap& tap) {
    return static_cast<std::uint8_t>(tap.x < 0 ? 0 : 255);
  });
  return mask;
}

void RemapTable::Apply(const cv::Mat& raw, cv::Mat& result) const {
  CV_Assert((raw.type() == CV_8UC1 || raw.type() == CV_8UC3) && raw.size() == raw_size_);
  result.create(size_, raw.type());
  CV_Assert(result.data != raw.data);
  if (raw.channels() == 1) {
    GatherGrey(raw, result);
  } else {
    GatherColour(raw, result);
  }
}

/// In parts: first the neighbours, then the arithmetic, which the compiler vectorizes.
CEILMAP_HOT void RemapTable::GatherGrey(const cv::Mat& raw, cv::Mat& result) const {
  constexpr int kPart = 64;
  std::array<std::uint32_t, kPart> upper;  // left and right neighbour, in the low bytes
  std::array<std::uint32_t, kPart> lower;
  const std::size_t step = raw.step[0];
  const std::uint8_t* const pixels = raw.data;
  for (int v = 0; v < size_.height; ++v) {
    auto* out = result.ptr<std::uint8_t>(v);
    const Tap* taps = taps_.data() + static_cast<std::ptrdiff_t>(v) * size_.width;
    for (int first = 0; first < size_.width; first += kPart, taps += kPart, out += kPart) {
      const int count = std::min(kPart, size_.width - first);
      for (int i = 0; i < count; ++i) {
        const Tap& tap = taps[i];
        const std::size_t at =
            tap.x < 0 ? 0
                      : static_cast<std::size_t>(tap.y) * step + static_cast<std::size_t>(tap.x);
        const std::uint8_t* p = pixels + at;
        upper[i] = p[0] | static_cast<std::uint32_t>(p[1]) << 8U;
        lower[i] = p[step] | static_cast<std::uint32_t>(p[step + 1]) << 8U;
      }
      for (int i = 0; i < count; ++i) {
        const std::uint32_t right = taps[i].x_weight;
        const std::uint32_t below = taps[i].y_weight;
        const std::uint32_t above = (upper[i] & 255U) * (kOne - right) + (upper[i] >> 8U) * right;
        const std::uint32_t under = (lower[i] & 255U) * (kOne - right) + (lower[i] >> 8U) * right;
        const std::uint32_t grey = (above * (kOne - below) + under * below + kHalf) >> kShift;
        out[i] = static_cast<std::uint8_t>(taps[i].x < 0 ? 0 : grey);
      }
    }
  }
}

void RemapTable::GatherColour(const cv::Mat& raw, cv::Mat& result) const {
  constexpr int kChannels = 3;
  const std::size_t step = raw.step[0];
  const Tap* tap = taps_.data();
  for (int v = 0; v < size_.height; ++v) {
    auto* out = result.ptr<std::uint8_t>(v);
    for (int u = 0; u < size_.width; ++u, ++tap, out += kChannels) {
      if (tap->x < 0) {
        std::fill_n(out, kChannels, std::uint8_t{0});
        continue;
      }
      const std::uint8_t* p = raw.data + static_cast<std::size_t>(tap->y) * step +
                              static_cast<std::size_t>(tap->x) * kChannels;
      const std::uint32_t right = tap->x_weight;
      const std::uint32_t below = tap->y_weight;
      for (int c = 0; c < kChannels; ++c, ++p) {
        const std::uint32_t upper = p[0] * (kOne - right) + p[kChannels] * right;
        const std::uint32_t lower = p[step] * (kOne - right) + p[step + kChannels] * right;
        out[c] =
            static_cast<std::uint8_t>((upper * (kOne - below) + lower * below + kHalf) >> kShift);
      }
    }
  }
}

}  // namespace ceilmap::calib
