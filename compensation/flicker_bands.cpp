#include "compensation/flicker_bands.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>

namespace ceilmap::compensation {
namespace {

// Bands are a tenth of the image wide and more: it is looked at in about this many columns.
constexpr int kSmallColumns = 160;
constexpr int kLatticeColumns = 26;
constexpr int kLatticeRows = 20;
// An image is compared with the latest one from which the robot moved by this part of the view's
// shorter side, or turned by this angle; there, bands that stand still in the rows differ.
constexpr double kMinMotion = 0.12;
constexpr double kMinTurnRad = 0.15;
constexpr std::size_t kKept = 16;  // images, of which the oldest is used by a slow robot
constexpr std::size_t kMaxWaiting = 8;
constexpr double kMaxPauseS = 1;  // between two images
// Grey values of which only the brightness counts.
constexpr float kDark = 10;
constexpr float kBright = 235;

constexpr int kParts = 256;  // of a grey level

/// What the rows of a band become, in parts of a grey level. Saturated pixels remain: their
/// brightness is not known.
std::array<std::uint16_t, 256> TableOf(double factor) {
  constexpr double kSaturationStart = 240;
  constexpr double kSaturationEnd = 252;
  std::array<std::uint16_t, 256> table{};
  for (int grey = 1; grey < 256; ++grey) {
    const double saturated =
        std::clamp((grey - kSaturationStart) / (kSaturationEnd - kSaturationStart), 0.0, 1.0);
    const double level = grey * (factor + saturated * (1 - factor));
    table[static_cast<std::size_t>(grey)] =
        static_cast<std::uint16_t>(std::clamp(std::lround(kParts * level), 256L, 255L * kParts));
  }
  return table;
}

/// Rounds up or down at random, in the mean to the level of the table. Without that, all pixels of
/// a row would be rounded alike, because those of the image are whole grey levels already: the
/// bands would become steps of one grey level.
void LevelRow(const std::array<std::uint16_t, 256>& table,
              std::uint32_t random,
              const cv::Mat& raw,
              int v,
              cv::Mat& even) {
  const auto* in = raw.ptr<std::uint8_t>(v);
  auto* out = even.ptr<std::uint8_t>(v);
  for (int u = 0; u < raw.cols; ++u) {
    random = random * 1664525U + 1013904223U;  // Numerical Recipes
    out[u] = static_cast<std::uint8_t>((table[in[u]] + (random >> 24U)) / kParts);
  }
}

}  // namespace

bool FlickerBands::Visible(double readout_time_s) {
  constexpr double kMinReadoutS = 0.004;  // less than half a band: a gradient of the whole image
  return std::abs(readout_time_s) >= kMinReadoutS;
}

FlickerBands::FlickerBands(const calib::CeilingView& view, double readout_time_s)
    : view_(view),
      readout_time_s_(readout_time_s),
      factor_(std::max(1, view.RawSize().width / kSmallColumns)) {
  const cv::Size size = view_.Size();
  for (int j = 0; j < kLatticeRows; ++j) {
    for (int i = 0; i < kLatticeColumns; ++i) {
      const Eigen::Vector2d pixel((i + 0.5) / kLatticeColumns * (size.width - 1),
                                  (j + 0.5) / kLatticeRows * (size.height - 1));
      if (RawAt(pixel)) lattice_.push_back(pixel);
    }
  }
}

std::optional<FlickerBands::RawPoint> FlickerBands::RawAt(const Eigen::Vector2d& pixel) const {
  const std::optional<Eigen::Vector2d> raw = view_.RawPixel(pixel);
  if (!raw) return std::nullopt;
  const double margin = factor_;
  const cv::Size size = view_.RawSize();
  if (raw->x() < margin || raw->y() < margin || raw->x() > size.width - 1 - margin ||
      raw->y() > size.height - 1 - margin) {
    return std::nullopt;
  }
  return RawPoint{raw->x(), raw->y()};
}

cv::Mat FlickerBands::Reduce(const cv::Mat& raw) const {
  cv::Mat small;
  cv::resize(raw, small, {raw.cols / factor_, raw.rows / factor_}, 0, 0, cv::INTER_AREA);
  small.convertTo(small, CV_32F);
  cv::blur(small, small, {3, 3});
  return small;
}

std::optional<double> FlickerBands::LogGrey(const Seen& seen, const RawPoint& at) const {
  const double u = (at.u + 0.5) / factor_ - 0.5;
  const double v = (at.v + 0.5) / factor_ - 0.5;
  const int col = static_cast<int>(u);
  const int row = static_cast<int>(v);
  if (u < 0 || v < 0 || col + 1 >= seen.small.cols || row + 1 >= seen.small.rows) {
    return std::nullopt;
  }
  const auto* above = seen.small.ptr<float>(row) + col;
  const auto* below = seen.small.ptr<float>(row + 1) + col;
  const auto [least, most] = std::minmax({above[0], above[1], below[0], below[1]});
  if (least < kDark || most > kBright) return std::nullopt;
  const double fu = u - col;
  const double fv = v - row;
  return std::log((1 - fv) * ((1 - fu) * above[0] + fu * above[1]) +
                  fv * ((1 - fu) * below[0] + fu * below[1]));
}

double FlickerBands::RowTime(double v) const {
  return readout_time_s_ * (v / (view_.RawSize().height - 1) - 0.5);
}

double FlickerBands::Radius2(const RawPoint& at) const {
  const double cu = (view_.RawSize().width - 1) / 2.0;
  const double cv = (view_.RawSize().height - 1) / 2.0;
  return ((at.u - cu) * (at.u - cu) + (at.v - cv) * (at.v - cv)) / (cu * cu + cv * cv);
}

std::vector<BandSample> FlickerBands::Compare(const Seen& later, const Seen& earlier) const {
  const Pose2 T_earlier_later = view_.T_base_view().Inverse() * earlier.T_odom_base.Inverse() *
                                later.T_odom_base * view_.T_base_view();
  const Eigen::Vector2d centre(0.5 * (view_.Size().width - 1), 0.5 * (view_.Size().height - 1));
  std::vector<BandSample> samples;
  samples.reserve(lattice_.size());
  for (const Eigen::Vector2d& pixel : lattice_) {
    const Eigen::Vector2d p_later = view_.MetresPerPixel() * (pixel - centre);
    const Eigen::Vector2d seen_at = centre + (T_earlier_later * p_later) / view_.MetresPerPixel();
    const std::optional<RawPoint> now = RawAt(pixel);
    const std::optional<RawPoint> then = RawAt(seen_at);
    if (!now || !then) continue;
    const std::optional<double> grey = LogGrey(later, *now);
    const std::optional<double> earlier_grey = LogGrey(earlier, *then);
    if (!grey || !earlier_grey) continue;
    samples.push_back(
        {*grey - *earlier_grey, RowTime(now->v), RowTime(then->v), Radius2(*now), Radius2(*then)});
  }
  return samples;
}

const FlickerBands::Seen* FlickerBands::Partner(const Pose2& T_odom_base) const {
  const double min_travel =
      kMinMotion * std::min(view_.Size().width, view_.Size().height) * view_.MetresPerPixel();
  for (auto seen = placed_.rbegin(); seen != placed_.rend(); ++seen) {
    const Pose2 motion = seen->T_odom_base.Inverse() * T_odom_base;
    if (motion.Translation().norm() > min_travel || std::abs(motion.yaw) > kMinTurnRad) {
      return &*seen;
    }
  }
  return placed_.empty() ? nullptr : &placed_.front();
}

cv::Mat FlickerBands::Remove(const cv::Mat& raw, double stamp_s) {
  if (raw.type() != CV_8UC1 || raw.size() != view_.RawSize()) return raw;  // refused later
  waiting_.push_back({stamp_s, Reduce(raw), {}});
  if (waiting_.size() > kMaxWaiting) waiting_.pop_front();
  return found_ ? Without(*found_, raw, stamp_s) : raw;
}

cv::Mat FlickerBands::Without(const Bands& bands, const cv::Mat& raw, double stamp_s) {
  ++removed_;
  cv::Mat even(raw.size(), CV_8UC1);
  for (int v = 0; v < raw.rows; ++v) {
    const auto seed = static_cast<std::uint32_t>(v) * 2654435761U + removed_ * 40503U;
    LevelRow(TableOf(std::exp(-bands.LogGain(stamp_s + RowTime(v)))), seed, raw, v, even);
  }
  return even;
}

void FlickerBands::Place(double stamp_s, const std::optional<Pose2>& T_map_base) {
  while (!waiting_.empty() && waiting_.front().stamp_s < stamp_s) waiting_.pop_front();
  const std::optional<Pose2> before = std::exchange(T_map_base_, T_map_base);
  const std::optional<Twist2> velocity = std::exchange(velocity_, std::nullopt);
  if (waiting_.empty() || waiting_.front().stamp_s != stamp_s) return;
  Seen now = std::move(waiting_.front());
  waiting_.pop_front();
  if (!placed_.empty()) {
    const double pause_s = stamp_s - placed_.back().stamp_s;
    const bool known = (before && T_map_base) || velocity;
    if (!known || pause_s > kMaxPauseS) {
      placed_.clear();
    } else {
      const Pose2 step =
          before && T_map_base ? before->Inverse() * *T_map_base : velocity->Over(pause_s);
      now.T_odom_base = placed_.back().T_odom_base * step;
    }
  }
  if (const Seen* const partner = Partner(now.T_odom_base)) {
    fit_.Add(stamp_s, partner->stamp_s, Compare(now, *partner));
    found_ = fit_.Solve(found_.has_value());
  }
  placed_.push_back(std::move(now));
  if (placed_.size() > kKept) placed_.pop_front();
}

}  // namespace ceilmap::compensation
