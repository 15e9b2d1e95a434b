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
constexpr int kPart = 64;  // pixels of a row that are drawn together

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
  if (raw.channels() == 3) {
    GatherColour(raw, result);
    return;
  }
  for (int v = 0; v < size_.height; ++v) {
    const Tap* taps = taps_.data() + static_cast<std::ptrdiff_t>(v) * size_.width;
    auto* out = result.ptr<std::uint8_t>(v);
    for (int u = 0; u < size_.width; u += kPart) {
      GatherGrey(raw, taps + u, std::min(kPart, size_.width - u), out + u);
    }
  }
}

void RemapTable::Apply(const cv::Mat& raw, const SourceShift& shift, cv::Mat& result) const {
  CV_Assert(raw.type() == CV_8UC1 && raw.size() == raw_size_);
  CV_Assert(shift.nodes.size() == SourceShift::NodesFor(size_));
  result.create(size_, CV_8UC1);
  CV_Assert(result.data != raw.data);
  std::array<Tap, kPart> shifted;
  for (int v = 0; v < size_.height; ++v) {
    auto* out = result.ptr<std::uint8_t>(v);
    for (int u = 0; u < size_.width; u += kPart) {
      const int count = std::min(kPart, size_.width - u);
      ShiftTaps(shift, {u, v}, count, shifted.data());
      GatherGrey(raw, shifted.data(), count, out + u);
    }
  }
}

/// Along a row the shift is linear between two nodes.
CEILMAP_HOT void RemapTable::ShiftTaps(const SourceShift& shift,
                                       cv::Point first,
                                       int count,
                                       Tap* shifted) const {
  constexpr int kSpacing = SourceShift::kSpacingPx;
  static_assert(kPart % kSpacing == 0);
  const Tap* taps = taps_.data() + static_cast<std::ptrdiff_t>(first.y) * size_.width + first.x;
  const int row = first.y / kSpacing;
  const float below = static_cast<float>(first.y % kSpacing) / kSpacing;
  const auto node = [&](int column) -> cv::Vec2f {
    return (shift.nodes(row, column) * (1 - below) + shift.nodes(row + 1, column) * below) *
           static_cast<float>(kOne);
  };
  const auto right = static_cast<float>((raw_size_.width - 1) * static_cast<int>(kOne));
  const auto bottom = static_cast<float>((raw_size_.height - 1) * static_cast<int>(kOne));
  constexpr float kHalfUnit = 0.5F;
  for (int i = 0; i < count; i += kSpacing) {
    const cv::Vec2f from = node((first.x + i) / kSpacing);
    const cv::Vec2f step = (node((first.x + i) / kSpacing + 1) - from) * (1.0F / kSpacing);
    for (int k = 0; k < std::min(kSpacing, count - i); ++k) {
      const Tap& tap = taps[i + k];
      const auto part = static_cast<float>(k);
      const auto at_x = static_cast<float>((tap.x << kPartBits) + tap.x_weight);
      const auto at_y = static_cast<float>((tap.y << kPartBits) + tap.y_weight);
      // Truncated below, which rounds them.
      const float x = std::clamp(at_x + from[0] + part * step[0] + kHalfUnit, 0.0F, right - 1);
      const float y = std::clamp(at_y + from[1] + part * step[1] + kHalfUnit, 0.0F, bottom - 1);
      const int xi = static_cast<int>(x);
      const int yi = static_cast<int>(y);
      constexpr int kWeights = static_cast<int>(kOne) - 1;
      shifted[i + k] = {static_cast<std::int16_t>(tap.x < 0 ? -1 : xi >> kPartBits),
                        static_cast<std::int16_t>(yi >> kPartBits),
                        static_cast<std::uint16_t>(xi & kWeights),
                        static_cast<std::uint16_t>(yi & kWeights)};
    }
  }
}

/// In parts: first the neighbours, then the arithmetic, which the compiler vectorizes.
CEILMAP_HOT void RemapTable::GatherGrey(const cv::Mat& raw,
                                        const Tap* taps,
                                        int count,
                                        std::uint8_t* out) {
  std::array<std::uint32_t, kPart> upper;  // left and right neighbour, in the low bytes
  std::array<std::uint32_t, kPart> lower;
  const std::size_t step = raw.step[0];
  const std::uint8_t* const pixels = raw.data;
  for (int i = 0; i < count; ++i) {
    const Tap& tap = taps[i];
    const std::size_t at =
        tap.x < 0 ? 0 : static_cast<std::size_t>(tap.y) * step + static_cast<std::size_t>(tap.x);
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
