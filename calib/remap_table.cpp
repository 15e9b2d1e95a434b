#include "calib/remap_table.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "calib/base/hot.hpp"

namespace ceilmap::calib {
namespace {

constexpr int kPartBits = 11;
constexpr std::int32_t kOne = 1 << kPartBits;
constexpr std::int32_t kNoSource = -1;
constexpr int kPart = 64;  // pixels of a row that are drawn together

/// Sources of a part of a row, in 1/2048 px.
struct Sources {
  std::array<std::int32_t, kPart> x;
  std::array<std::int32_t, kPart> y;
};

/// Where to read: the upper left of four neighbours, and the weights of the right and lower ones.
struct Taps {
  std::array<std::int32_t, kPart> at;  // bytes from the first pixel
  std::array<std::int32_t, kPart> right;
  std::array<std::int32_t, kPart> below;
};

/// The neighbours of a source at the right or lower border lie inside the image. Pixels without a
/// source read the first pixel.
CEILMAP_HOT void MakeTaps(const std::int32_t* x,
                          const std::int32_t* y,
                          int count,
                          const cv::Mat& raw,
                          int pixel_bytes,
                          Taps& taps) {
  const auto step = static_cast<std::int32_t>(raw.step[0]);
  const std::int32_t last_column = raw.cols - 2;
  const std::int32_t last_row = raw.rows - 2;
  for (int i = 0; i < count; ++i) {
    const std::int32_t left = std::max(x[i], 0);
    const std::int32_t column = std::min(left >> kPartBits, last_column);
    const std::int32_t row = std::min(y[i] >> kPartBits, last_row);
    taps.at[i] = row * step + column * pixel_bytes;
    taps.right[i] = left - (column << kPartBits);
    taps.below[i] = y[i] - (row << kPartBits);
  }
}

std::int32_t Interpolate(std::int32_t from, std::int32_t to, std::int32_t weight) {
  return (from << kPartBits) + (to - from) * weight;
}

std::int32_t Rounded(std::int32_t grey) {
  constexpr int kShift = 2 * kPartBits;
  return (grey + (1 << (kShift - 1))) >> kShift;
}

/// In parts: first the neighbours, then the arithmetic, which the compiler vectorizes.
CEILMAP_HOT void GatherGrey(
    const cv::Mat& raw, const std::int32_t* x, const Taps& taps, int count, std::uint8_t* out) {
  constexpr std::uint32_t kByte = 255;
  std::array<std::uint16_t, kPart> upper;  // left and right neighbour
  std::array<std::uint16_t, kPart> lower;
  const std::size_t step = raw.step[0];
  const std::uint8_t* const pixels = raw.data;
  for (int i = 0; i < count; ++i) {
    const std::uint8_t* p = pixels + taps.at[i];
    upper[i] = static_cast<std::uint16_t>(p[0] | static_cast<std::uint32_t>(p[1]) << 8U);
    lower[i] = static_cast<std::uint16_t>(p[step] | static_cast<std::uint32_t>(p[step + 1]) << 8U);
  }
  for (int i = 0; i < count; ++i) {
    const auto above = Interpolate(upper[i] & kByte, upper[i] >> 8U, taps.right[i]);
    const auto under = Interpolate(lower[i] & kByte, lower[i] >> 8U, taps.right[i]);
    const std::int32_t grey = Rounded(Interpolate(above, under, taps.below[i]));
    out[i] = static_cast<std::uint8_t>(x[i] < 0 ? 0 : grey);
  }
}

/// Sources of `count` pixels of the result from `first` on, displaced. Along a row the shift is
/// linear between two nodes.
CEILMAP_HOT void ShiftSources(const SourceShift& shift,
                              cv::Size raw,
                              cv::Point first,
                              const std::int32_t* x,
                              const std::int32_t* y,
                              int count,
                              Sources& shifted) {
  constexpr int kSpacing = SourceShift::kSpacingPx;
  static_assert(kPart % kSpacing == 0);
  const int row = first.y / kSpacing;
  const float below = static_cast<float>(first.y % kSpacing) / kSpacing;
  const auto node = [&](int column) -> cv::Vec2f {
    return (shift.nodes(row, column) * (1 - below) + shift.nodes(row + 1, column) * below) *
           static_cast<float>(kOne);
  };
  const auto right = static_cast<float>((raw.width - 1) * kOne);
  const auto bottom = static_cast<float>((raw.height - 1) * kOne);
  constexpr float kHalfUnit = 0.5F;  // truncated below, which rounds
  for (int i = 0; i < count; i += kSpacing) {
    const cv::Vec2f from = node((first.x + i) / kSpacing);
    const cv::Vec2f step = (node((first.x + i) / kSpacing + 1) - from) * (1.0F / kSpacing);
    for (int k = 0; k < std::min(kSpacing, count - i); ++k) {
      const auto part = static_cast<float>(k);
      const float at_x = static_cast<float>(x[i + k]) + from[0] + part * step[0] + kHalfUnit;
      const float at_y = static_cast<float>(y[i + k]) + from[1] + part * step[1] + kHalfUnit;
      shifted.x[i + k] =
          x[i + k] < 0 ? kNoSource : static_cast<std::int32_t>(std::clamp(at_x, 0.0F, right));
      shifted.y[i + k] = static_cast<std::int32_t>(std::clamp(at_y, 0.0F, bottom));
    }
  }
}

}  // namespace

RemapTable::RemapTable(cv::Size raw, cv::Size result, const Source& source)
    : raw_size_(raw), size_(result) {
  constexpr double kRounding = 0.5 / kOne;  // rounding may place a border pixel outside the image
  const auto inside = [](double at, int size) {
    return at >= -kRounding && at <= size - 1 + kRounding;
  };
  const auto count = static_cast<std::size_t>(result.area());
  x_.assign(count, kNoSource);
  y_.assign(count, 0);
  std::size_t index = 0;
  for (int v = 0; v < result.height; ++v) {
    for (int u = 0; u < result.width; ++u, ++index) {
      const std::optional<cv::Point2d> at = source(u, v);
      if (!at || !inside(at->x, raw.width) || !inside(at->y, raw.height)) continue;
      x_[index] =
          static_cast<std::int32_t>(std::lround(std::clamp(at->x, 0.0, raw.width - 1.0) * kOne));
      y_[index] =
          static_cast<std::int32_t>(std::lround(std::clamp(at->y, 0.0, raw.height - 1.0) * kOne));
    }
  }
}

cv::Mat RemapTable::Mask() const {
  cv::Mat mask(size_, CV_8UC1);
  std::transform(x_.begin(), x_.end(), mask.begin<std::uint8_t>(), [](std::int32_t x) {
    return static_cast<std::uint8_t>(x < 0 ? 0 : 255);
  });
  return mask;
}

void RemapTable::Apply(const cv::Mat& raw, cv::Mat& result) const {
  CV_Assert((raw.type() == CV_8UC1 || raw.type() == CV_8UC3) && raw.size() == raw_size_);
  result.create(size_, raw.type());
  CV_Assert(result.data != raw.data);
  if (raw.channels() == 3) {
    FillColour(raw, result);
  } else {
    FillGrey(raw, nullptr, result);
  }
}

void RemapTable::Apply(const cv::Mat& raw, const SourceShift& shift, cv::Mat& result) const {
  CV_Assert(raw.type() == CV_8UC1 && raw.size() == raw_size_);
  CV_Assert(shift.nodes.size() == SourceShift::NodesFor(size_));
  result.create(size_, CV_8UC1);
  CV_Assert(result.data != raw.data);
  FillGrey(raw, &shift, result);
}

void RemapTable::FillGrey(const cv::Mat& raw, const SourceShift* shift, cv::Mat& result) const {
  Sources shifted;
  Taps taps;
  for (int v = 0; v < size_.height; ++v) {
    auto* out = result.ptr<std::uint8_t>(v);
    for (int u = 0; u < size_.width; u += kPart) {
      const int count = std::min(kPart, size_.width - u);
      const std::ptrdiff_t first = static_cast<std::ptrdiff_t>(v) * size_.width + u;
      const std::int32_t* x = x_.data() + first;
      const std::int32_t* y = y_.data() + first;
      if (shift != nullptr) {
        ShiftSources(*shift, raw_size_, {u, v}, x, y, count, shifted);
        x = shifted.x.data();
        y = shifted.y.data();
      }
      MakeTaps(x, y, count, raw, 1, taps);
      GatherGrey(raw, x, taps, count, out + u);
    }
  }
}

void RemapTable::FillColour(const cv::Mat& raw, cv::Mat& result) const {
  constexpr int kChannels = 3;
  const std::size_t step = raw.step[0];
  Taps taps;
  for (int v = 0; v < size_.height; ++v) {
    auto* out = result.ptr<std::uint8_t>(v);
    for (int u = 0; u < size_.width; ++u, out += kChannels) {
      const std::ptrdiff_t index = static_cast<std::ptrdiff_t>(v) * size_.width + u;
      if (u % kPart == 0) {
        const int count = std::min(kPart, size_.width - u);
        MakeTaps(x_.data() + index, y_.data() + index, count, raw, kChannels, taps);
      }
      if (x_[index] < 0) {
        std::fill_n(out, kChannels, std::uint8_t{0});
        continue;
      }
      const int i = u % kPart;
      const std::uint8_t* p = raw.data + taps.at[i];
      for (int c = 0; c < kChannels; ++c, ++p) {
        const auto above = Interpolate(p[0], p[kChannels], taps.right[i]);
        const auto under = Interpolate(p[step], p[step + kChannels], taps.right[i]);
        out[c] = static_cast<std::uint8_t>(Rounded(Interpolate(above, under, taps.below[i])));
      }
    }
  }
}

}  // namespace ceilmap::calib
