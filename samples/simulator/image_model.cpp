#include "samples/simulator/image_model.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

namespace ceilmap::simulator {
namespace {

constexpr int kNormalBits = 14;
constexpr int kCurveSteps = 1 << 14;  // of light 0..1
constexpr int kNoiseSteps = 1 << 10;

/// IEC 61966-2-1.
double SrgbCurve(double light) {
  return light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055;
}

std::vector<float> NormalNumbers(Random random) {
  std::vector<float> numbers(std::size_t{1} << kNormalBits);
  for (std::size_t i = 0; i < numbers.size(); i += 2) {
    numbers[i] = static_cast<float>(random.Normal());
    numbers[i + 1] = -numbers[i];  // so the mean is exactly 0
  }
  return numbers;
}

cv::Mat Sensitivity(const Image& image, const Camera& camera, Random random) {
  cv::Mat sensitivity(camera.height_px, camera.width_px, CV_32FC1);
  const double cx = (camera.width_px - 1) / 2.0;
  const double cy = (camera.height_px - 1) / 2.0;
  for (int v = 0; v < sensitivity.rows; ++v) {
    for (int u = 0; u < sensitivity.cols; ++u) {
      const double r2 = ((u - cx) * (u - cx) + (v - cy) * (v - cy)) / (cx * cx + cy * cy);
      const double own = 1 + image.gain_spread * random.Normal();
      sensitivity.at<float>(v, u) = static_cast<float>((1 - image.vignetting * r2) * own);
    }
  }
  return sensitivity;
}

}  // namespace

ImageModel::ImageModel(const Scene& scene, const Camera& camera, PixelPurposes purposes)
    : image_(scene.image),
      start_stamp_s_(scene.path.start_stamp_s),
      scene_start_s_(StartStamp(scene)),
      phase_(scene.session.value_or(0) * 0.381966),
      exposure_time_s_(camera.exposure_time_s),
      readout_time_s_(camera.readout_time_s),
      warmth_(purposes.warmth),
      noise_key_(Random(DriveSeed(scene), purposes.noise).Bits()),
      sensitivity_(Sensitivity(scene.image, camera, {scene.seed, purposes.gain})),
      normal_(NormalNumbers({scene.seed, purposes.noise})) {
  for (int i = 0; i <= kNoiseSteps; ++i) {
    const double light = (i + 0.5) / kNoiseSteps;
    noise_.push_back(
        static_cast<float>(std::hypot(image_.shot_noise * std::sqrt(light), image_.read_noise)));
  }
  for (int i = 0; i <= kCurveSteps; ++i) {
    const double grey = 255 * SrgbCurve(static_cast<double>(i) / kCurveSteps);
    curve_.push_back(static_cast<std::uint8_t>(std::lround(grey)));
  }
}

double ImageModel::Gain(const Frame& frame) const {
  for (const TimeSpan& dark : image_.dark) {
    if (dark.Contains(frame.stamp_s - scene_start_s_)) return 0;
  }
  const double turns = (frame.stamp_s - start_stamp_s_) / image_.exposure_period_s + phase_;
  const double slow = std::sin(2 * std::numbers::pi * turns);
  const double drift = 1 + image_.exposure_drift * slow;
  const double balance = 1 + warmth_ * image_.white_balance_drift * slow;
  double step_gain = 1;
  for (const ExposureStep& step : image_.exposure_steps) {
    if (frame.index >= step.frame) step_gain = step.gain;
  }
  return image_.exposure_gain * drift * step_gain * balance * frame.auto_gain;
}

double ImageModel::Flicker(const Frame& frame, int row) const {
  if (image_.flicker_depth == 0) return 1;
  const int last = sensitivity_.rows - 1;
  const double after_middle_s = readout_time_s_ * (static_cast<double>(row) / last - 0.5);
  const double t = frame.stamp_s - start_stamp_s_ + after_middle_s;
  // Mean of the sine over the exposure.
  const double half = std::numbers::pi * image_.flicker_hz * exposure_time_s_;
  const double left = half > 0 ? std::sin(half) / half : 1;
  return 1 + image_.flicker_depth * left * std::sin(2 * std::numbers::pi * image_.flicker_hz * t);
}

void ImageModel::AddGlare(cv::Mat& light) const {
  // Wide and smooth, so a small image is sufficient. Light above white is spread too.
  constexpr int kShrink = 8;
  const cv::Size small(std::max(1, light.cols / kShrink), std::max(1, light.rows / kShrink));
  cv::Mat spread;
  cv::resize(light, spread, small, 0, 0, cv::INTER_AREA);
  const double sigma = 0.06 * small.width;
  cv::GaussianBlur(spread, spread, {}, sigma, sigma, cv::BORDER_REPLICATE);
  cv::resize(spread, spread, light.size(), 0, 0, cv::INTER_LINEAR);
  cv::addWeighted(light, 1 - image_.glare, spread, image_.glare, 0, light);
}

cv::Mat ImageModel::Expose(const cv::Mat& light, const Frame& frame) const {
  cv::Mat grey(light.size(), CV_8UC1);
  const std::uint64_t key = Mix(noise_key_ ^ static_cast<std::uint64_t>(frame.index));
  const double frame_gain = Gain(frame);
  for (int v = 0; v < light.rows; ++v) {
    const auto gain = static_cast<float>(frame_gain * Flicker(frame, v));
    const auto* in = light.ptr<float>(v);
    const auto* sensitivity = sensitivity_.ptr<float>(v);
    auto* out = grey.ptr<std::uint8_t>(v);
    std::uint64_t bits = 0;
    for (int u = 0; u < light.cols; ++u) {
      bits = u % 4 == 0 ? HashAt(key, v, u) : bits >> kNormalBits;
      const float random = normal_[bits & ((std::uint64_t{1} << kNormalBits) - 1)];
      const float seen = in[u] * sensitivity[u] * gain;
      const float noise = noise_[static_cast<std::size_t>(std::min(seen, 1.0F) * kNoiseSteps)];
      const float noisy = std::clamp(seen + noise * random, 0.0F, 1.0F);
      constexpr float kHalf = 0.5F;  // rounding; lround would be slower than all other work
      out[u] = curve_[static_cast<std::size_t>(noisy * kCurveSteps + kHalf)];
    }
  }
  return grey;
}

cv::Mat ImageModel::Develop(cv::Mat& light, const Frame& frame) const {
  if (image_.glare > 0) AddGlare(light);
  if (image_.blur_px > 0) {
    const int size = 2 * static_cast<int>(std::ceil(3 * image_.blur_px)) + 1;
    cv::GaussianBlur(
        light, light, {size, size}, image_.blur_px, image_.blur_px, cv::BORDER_REPLICATE);
  }
  return Expose(light, frame);
}

cv::Mat DevelopPlanes(std::span<const ImageModel> planes,
                      const cv::Mat& light,
                      const Frame& frame) {
  std::vector<cv::Mat> channels;
  cv::split(light, channels);
  for (std::size_t i = 0; i < channels.size(); ++i) {
    channels[i] = planes[i].Develop(channels[i], frame);
  }
  cv::Mat image;
  cv::merge(channels, image);
  return image;
}

}  // namespace ceilmap::simulator
