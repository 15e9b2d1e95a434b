#include "tests/bench/registration_yardsticks.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "calib/base/pose2.hpp"
#include "tests/bench/registration_frames.hpp"

namespace ceilmap::bench {

using registration::ImageMotion;

namespace {

/// Rotation by phase correlation of the log amplitude spectra in polar coordinates, both half turns
/// turned back, translation by phase correlation.
class OpenCvPieces {
 public:
  explicit OpenCvPieces(const cv::Mat& reference) {
    cv::createHanningWindow(window_, kSize, CV_32F);
    reference.convertTo(reference_, CV_32F);
    reference_polar_ = Polar(reference_);
  }

  ImageMotion Register(const cv::Mat& grey) {
    cv::Mat current;
    grey.convertTo(current, CV_32F);
    const cv::Point2d polar_shift = cv::phaseCorrelate(reference_polar_, Polar(current));
    const double theta = polar_shift.y * std::numbers::pi / kAngles;
    double best = -1;
    ImageMotion motion;
    for (const double angle : {theta, theta + std::numbers::pi}) {
      const double cx = 0.5 * (kSize.width - 1);
      const double cy = 0.5 * (kSize.height - 1);
      const double c = std::cos(angle);
      const double s = std::sin(angle);
      const cv::Matx23d back(c, -s, cx - c * cx + s * cy, s, c, cy - s * cx - c * cy);
      cv::Mat turned;
      cv::warpAffine(current, turned, back, kSize, cv::INTER_LINEAR | cv::WARP_INVERSE_MAP);
      double response = 0;
      const cv::Point2d d = cv::phaseCorrelate(reference_, turned, window_, &response);
      if (response > best) {
        best = response;
        motion = {c * d.x - s * d.y, s * d.x + c * d.y, WrapAngle(angle), 1};
      }
    }
    return motion;
  }

 private:
  static constexpr int kAngles = 360;  // over the half turn
  static constexpr int kRadii = 256;

  [[nodiscard]] cv::Mat Polar(const cv::Mat& image) const {
    cv::Mat spectrum;
    cv::dft((image - cv::mean(image)).mul(window_), spectrum, cv::DFT_COMPLEX_OUTPUT);
    std::array<cv::Mat, 2> parts;
    cv::split(spectrum, parts.data());
    cv::Mat amplitude;
    cv::magnitude(parts[0], parts[1], amplitude);
    cv::log(amplitude + 1, amplitude);
    // Zero frequency to the middle, and bins of equal size on both axes.
    const int w = kSize.width;
    const int h = kSize.height;
    cv::Mat centred(kSize, CV_32FC1);
    for (const int x : {0, w / 2}) {
      for (const int y : {0, h / 2}) {
        amplitude(cv::Rect(x, y, w / 2, h / 2))
            .copyTo(centred(cv::Rect(w / 2 - x, h / 2 - y, w / 2, h / 2)));
      }
    }
    cv::Mat square;
    cv::resize(centred, square, {h, h});
    cv::Mat polar;
    cv::warpPolar(square,
                  polar,
                  {kRadii, 2 * kAngles},
                  cv::Point2f(0.5F * static_cast<float>(h), 0.5F * static_cast<float>(h)),
                  0.5 * h,
                  cv::INTER_LINEAR | cv::WARP_FILL_OUTLIERS);
    // A half turn, between 0.03 and 0.35 cycles per pixel.
    return polar(cv::Rect(15, 0, 163, kAngles)).clone();
  }

  cv::Mat window_;
  cv::Mat reference_;
  cv::Mat reference_polar_;
};

}  // namespace

void OpenCv(benchmark::State& state) {
  OpenCvPieces pieces(Frames().reference);
  RunFrames(state, "OpenCV pieces", [&](std::size_t i) {
    return MotionWithin(pieces.Register(Frames().frames[i]), 2, 0.5);
  });
}

void Orb(benchmark::State& state) {
  const auto orb = cv::ORB::create();
  const cv::BFMatcher matcher(cv::NORM_HAMMING, true);
  std::vector<cv::KeyPoint> reference_keys;
  cv::Mat reference_descriptors;
  orb->detectAndCompute(Frames().reference, cv::noArray(), reference_keys, reference_descriptors);
  RunFrames(state, "ORB", [&](std::size_t i) {
    std::vector<cv::KeyPoint> keys;
    cv::Mat descriptors;
    orb->detectAndCompute(Frames().frames[i], cv::noArray(), keys, descriptors);
    std::vector<cv::DMatch> matches;
    matcher.match(reference_descriptors, descriptors, matches);
    std::vector<cv::Point2f> from;
    std::vector<cv::Point2f> to;
    for (const cv::DMatch& match : matches) {
      from.push_back(reference_keys[static_cast<std::size_t>(match.queryIdx)].pt);
      to.push_back(keys[static_cast<std::size_t>(match.trainIdx)].pt);
    }
    const cv::Mat m = cv::estimateAffinePartial2D(from, to);
    ImageMotion motion{1e9, 1e9, 0, 1};
    if (!m.empty()) {
      const double cx = 0.5 * (kSize.width - 1);
      const double cy = 0.5 * (kSize.height - 1);
      const double a = m.at<double>(0, 0);
      const double b = m.at<double>(1, 0);
      motion = {m.at<double>(0, 2) + a * cx - b * cy - cx,
                m.at<double>(1, 2) + b * cx + a * cy - cy,
                std::atan2(b, a),
                std::hypot(a, b)};
    }
    return MotionWithin(motion, 2, 0.5);
  });
}

}  // namespace ceilmap::bench
