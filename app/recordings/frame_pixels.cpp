#include "app/recordings/frame_pixels.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <opencv2/imgproc.hpp>
#include <string_view>
#include <utility>

extern "C" {
#include <libavutil/frame.h>
#include <libavutil/pixdesc.h>
#include <libswscale/swscale.h>
}

#include "calib/base/error.hpp"

namespace ceilmap::recordings {
namespace {

constexpr int kMaxLumaBits = 16;

// A plane's luma: every `step` bytes from `first` on.
struct LumaPlane {
  const std::uint8_t* first = nullptr;
  std::ptrdiff_t row_bytes = 0;  // negative where rows are stored from bottom to top
  int step = 1;
  int depth = 8;
  int shift = 0;
  bool swapped = false;  // bytes of a sample in the other order
  bool full_range = false;
};

// Nothing where the pixels have no luma of their own, or not one sample per pixel.
std::optional<LumaPlane> LumaOf(const AVFrame& frame) {
  const auto format = static_cast<AVPixelFormat>(frame.format);
  const AVPixFmtDescriptor* const pixels = av_pix_fmt_desc_get(format);
  constexpr std::uint64_t kOther = AV_PIX_FMT_FLAG_RGB | AV_PIX_FMT_FLAG_PAL |
                                   AV_PIX_FMT_FLAG_BITSTREAM | AV_PIX_FMT_FLAG_HWACCEL |
                                   AV_PIX_FMT_FLAG_BAYER | AV_PIX_FMT_FLAG_FLOAT;
  if (pixels == nullptr || (pixels->flags & kOther) != 0 || format == AV_PIX_FMT_UYYVYY411) {
    return std::nullopt;
  }
  const AVComponentDescriptor& luma = pixels->comp[0];
  if (luma.plane != 0 || luma.depth < 8 || luma.depth > kMaxLumaBits) return std::nullopt;
  LumaPlane plane;
  plane.first = frame.data[0] + luma.offset;
  plane.row_bytes = frame.linesize[0];
  plane.step = luma.step;
  plane.depth = luma.depth;
  plane.shift = luma.shift;
  const bool big = (pixels->flags & AV_PIX_FMT_FLAG_BE) != 0;
  plane.swapped = big != (std::endian::native == std::endian::big);
  // As FFmpeg, which takes grey formats to be of full range whatever is stated.
  constexpr int kComponentsWithColour = 3;
  plane.full_range = frame.color_range == AVCOL_RANGE_JPEG ||
                     pixels->nb_components < kComponentsWithColour ||
                     std::string_view(pixels->name).starts_with("yuvj");
  return plane;
}

int Sample(const std::uint8_t* at, const LumaPlane& luma) {
  if (luma.depth <= 8) return *at;
  std::uint16_t stored = 0;
  std::memcpy(&stored, at, sizeof(stored));
  if (luma.swapped) stored = static_cast<std::uint16_t>(stored << 8 | stored >> 8);
  return (stored >> luma.shift) & ((1 << luma.depth) - 1);
}

// Grey levels of all luma values. Limited range is 16 to 235 at 8 bits.
cv::Mat GreyTable(int depth, bool full_range) {
  constexpr double kBlack = 16;
  constexpr double kWhite = 235;
  const double unit = std::exp2(depth - 8);
  const int count = 1 << depth;
  const double black = full_range ? 0 : kBlack * unit;
  const double white = full_range ? count - 1 : kWhite * unit;
  cv::Mat table(1, count, CV_8UC1);
  for (int i = 0; i < count; ++i) {
    table.at<uchar>(i) = cv::saturate_cast<uchar>(255 * (i - black) / (white - black));
  }
  return table;
}

cv::Size SquareSize(cv::Size stored, double sample_aspect) {
  constexpr double kMaxSide = 1e6;  // refused later
  const double width = std::clamp(std::round(stored.width * sample_aspect), 1.0, kMaxSide);
  return {static_cast<int>(width), stored.height};
}

void Turn(const cv::Mat& stored, const Orientation& orientation, cv::Mat& image) {
  constexpr int kExchangeRows = 0;
  constexpr int kExchangeColumns = 1;
  constexpr int kExchangeBoth = -1;
  if (orientation.transposed) cv::transpose(stored, image);
  const cv::Mat& before = orientation.transposed ? image : stored;
  if (orientation.mirrored_x && orientation.mirrored_y) {
    cv::flip(before, image, kExchangeBoth);
  } else if (orientation.mirrored_x) {
    cv::flip(before, image, kExchangeColumns);
  } else if (orientation.mirrored_y) {
    cv::flip(before, image, kExchangeRows);
  }
}

}  // namespace

std::optional<Orientation> OrientationOf(std::span<const std::int32_t, 9> matrix) {
  constexpr double kTolerance = 1e-3;
  // Stored (p, q) is displayed at x = a p + c q, y = b p + d q.
  const double length_p = std::hypot(matrix[0], matrix[1]);
  const double length_q = std::hypot(matrix[3], matrix[4]);
  if (length_p == 0 && length_q == 0) return Orientation{};
  if (length_p == 0 || length_q == 0) return std::nullopt;
  const double a = matrix[0] / length_p;
  const double b = matrix[1] / length_p;
  const double c = matrix[3] / length_q;
  const double d = matrix[4] / length_q;
  if (std::abs(b) < kTolerance && std::abs(c) < kTolerance) {
    return Orientation{.transposed = false, .mirrored_x = a < 0, .mirrored_y = d < 0};
  }
  if (std::abs(a) < kTolerance && std::abs(d) < kTolerance) {
    return Orientation{.transposed = true, .mirrored_x = c < 0, .mirrored_y = b < 0};
  }
  return std::nullopt;
}

cv::Size DisplaySize(cv::Size stored, const FrameGeometry& geometry) {
  const cv::Size square = SquareSize(stored, geometry.sample_aspect);
  return geometry.orientation.transposed ? cv::Size(square.height, square.width) : square;
}

void FramePixels::Release::operator()(SwsContext* scaler) const {
  sws_freeContext(scaler);
}

FramePixels::FramePixels(std::string name, Pixels pixels)
    : name_(std::move(name)), pixels_(pixels) {}
FramePixels::~FramePixels() = default;

void FramePixels::Convert(const AVFrame& frame, const FrameGeometry& geometry, cv::Mat& image) {
  const cv::Size stored(frame.width, frame.height);
  const cv::Size square = SquareSize(stored, geometry.sample_aspect);
  CheckImageSize(square, name_);
  const bool resampled = square != stored;
  const bool turned = geometry.orientation != Orientation{};
  ReadStored(frame, resampled || turned ? stored_ : image);
  if (resampled) {
    const auto method = square.width < stored.width ? cv::INTER_AREA : cv::INTER_CUBIC;
    cv::resize(stored_, turned ? square_ : image, square, 0, 0, method);
  }
  if (turned) Turn(resampled ? square_ : stored_, geometry.orientation, image);
}

void FramePixels::ReadStored(const AVFrame& frame, cv::Mat& image) {
  if (pixels_ == Pixels::kGrey && ReadLuma(frame, image)) return;
  cv::Mat bgr;
  ReadColour(frame, bgr);
  ConvertTo(pixels_, bgr, image, name_);
}

const cv::Mat& FramePixels::GreyLevels(int depth, bool full_range) {
  if (levels_.depth != depth || levels_.full_range != full_range) {
    levels_ = {depth, full_range, GreyTable(depth, full_range)};
  }
  return levels_.table;
}

bool FramePixels::ReadLuma(const AVFrame& frame, cv::Mat& grey) {
  const std::optional<LumaPlane> luma = LumaOf(frame);
  if (!luma) return false;
  const bool bytes = luma->depth == 8;
  if (bytes && luma->step == 1 && luma->row_bytes > 0) {
    const cv::Mat plane(frame.height,
                        frame.width,
                        CV_8UC1,
                        const_cast<std::uint8_t*>(luma->first),  // NOLINT: not written to
                        static_cast<std::size_t>(luma->row_bytes));
    if (luma->full_range) {
      plane.copyTo(grey);
    } else {
      cv::LUT(plane, GreyLevels(luma->depth, false), grey);
    }
    return true;
  }
  const auto* const levels = GreyLevels(luma->depth, luma->full_range).ptr<uchar>();
  grey.create(frame.height, frame.width, CV_8UC1);
  for (int v = 0; v < grey.rows; ++v) {
    const std::uint8_t* at = luma->first + v * luma->row_bytes;
    auto* const row = grey.ptr<uchar>(v);
    for (int u = 0; u < grey.cols; ++u, at += luma->step) row[u] = levels[Sample(at, *luma)];
  }
  return true;
}

// The rows are padded, because the scaler may write beyond their ends.
void FramePixels::ReadColour(const AVFrame& frame, cv::Mat& bgr) {
  constexpr int kPadding = 64;
  constexpr int kNeutral = 1 << 16;  // contrast and saturation
  const int width = frame.width;
  const int height = frame.height;
  const auto format = static_cast<AVPixelFormat>(frame.format);
  scaler_.reset(sws_getCachedContext(scaler_.release(),
                                     width,
                                     height,
                                     format,
                                     width,
                                     height,
                                     AV_PIX_FMT_BGR24,
                                     SWS_BICUBIC,
                                     nullptr,
                                     nullptr,
                                     nullptr));
  if (!scaler_) {
    const char* const pixels = av_get_pix_fmt_name(format);
    throw InputError(fmt::format("{}: its pixel format {} cannot be converted",
                                 name_,
                                 pixels != nullptr ? pixels : "(unknown)"));
  }
  // The matrix of BT.601, as OpenCV's: a robot's program that reads its camera by OpenCV and a
  // model of colours that was learned by this program then agree, whatever the video states.
  const std::optional<LumaPlane> luma = LumaOf(frame);
  const int* const matrix = sws_getCoefficients(SWS_CS_DEFAULT);
  sws_setColorspaceDetails(
      scaler_.get(), matrix, luma && luma->full_range ? 1 : 0, matrix, 1, 0, kNeutral, kNeutral);
  padded_.create(height + 1, (width + kPadding) / kPadding * kPadding, CV_8UC3);
  uint8_t* const rows = padded_.data;
  const int step = static_cast<int>(padded_.step);
  sws_scale(scaler_.get(), frame.data, frame.linesize, 0, height, &rows, &step);
  bgr = padded_(cv::Rect(0, 0, width, height));
}

}  // namespace ceilmap::recordings
