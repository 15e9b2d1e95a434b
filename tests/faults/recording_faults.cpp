#include "tests/faults/recording_faults.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <utility>

namespace ceilmap::faults {
namespace {

double Share(Random& random) {
  return std::uniform_real_distribution<double>(0, 1)(random);
}

std::size_t Below(std::size_t count, Random& random) {
  return std::uniform_int_distribution<std::size_t>(0, count - 1)(random);
}

cv::Mat Brighter(const cv::Mat& image, double factor) {
  cv::Mat changed;
  image.convertTo(changed, CV_8U, factor);
  return changed;
}

}  // namespace

Recording DropFrames(const Recording& good, double share, Random& random) {
  Recording faulty = {good.front()};
  for (std::size_t i = 1; i < good.size(); ++i) {
    if (Share(random) >= share) faulty.push_back(good[i]);
  }
  return faulty;
}

Recording DuplicateFrames(const Recording& good, double share, Random& random) {
  Recording faulty;
  for (std::size_t i = 0; i < good.size(); ++i) {
    faulty.push_back(good[i]);
    if (i + 1 == good.size() || Share(random) >= share) continue;
    faulty.push_back(good[i]);
    faulty.back().stamp_s = 0.5 * (good[i].stamp_s + good[i + 1].stamp_s);
  }
  return faulty;
}

Recording SwapFrames(const Recording& good, double share, Random& random) {
  Recording faulty = good;
  for (std::size_t i = 0; i + 1 < faulty.size(); ++i) {
    if (Share(random) >= share) continue;
    std::swap(faulty[i], faulty[i + 1]);
    std::swap(faulty[i].stamp_s, faulty[i + 1].stamp_s);
    ++i;
  }
  return faulty;
}

Recording Flicker(const Recording& good, double low) {
  Recording faulty = good;
  for (std::size_t i = 1; i < faulty.size(); i += 2) {
    faulty[i].image = Brighter(faulty[i].image, low);
  }
  return faulty;
}

Recording ExposureJumps(const Recording& good, int jumps, Random& random) {
  Recording faulty = good;
  std::vector<double> factors(good.size(), 0);
  for (int i = 0; i < jumps; ++i) {
    factors[Below(good.size(), random)] = 0.35 * std::pow(2.5 / 0.35, Share(random));
  }
  double factor = 1;
  for (std::size_t i = 0; i < faulty.size(); ++i) {
    if (factors[i] > 0) factor = factors[i];
    faulty[i].image = Brighter(faulty[i].image, factor);
  }
  return faulty;
}

Recording MotionBlur(const Recording& good, double share, int length_px, Random& random) {
  Recording faulty = good;
  for (Shot& shot : faulty) {
    if (Share(random) >= share) continue;
    cv::Mat kernel = cv::Mat::zeros(length_px, length_px, CV_32F);
    const double angle = std::numbers::pi * Share(random);
    const cv::Point2d half(0.5 * length_px * std::cos(angle), 0.5 * length_px * std::sin(angle));
    const cv::Point2d centre(0.5 * (length_px - 1), 0.5 * (length_px - 1));
    cv::line(kernel, centre - half, centre + half, 1);
    kernel /= cv::sum(kernel)[0];
    cv::Mat smeared;
    cv::filter2D(shot.image, smeared, CV_8U, kernel);
    shot.image = smeared;
  }
  return faulty;
}

Recording SaltNoise(const Recording& good, double share, Random& random) {
  Recording faulty = good;
  for (Shot& shot : faulty) {
    shot.image = shot.image.clone();
    const auto count = std::lround(share * static_cast<double>(shot.image.total()));
    for (long i = 0; i < count; ++i) {
      shot.image.data[Below(shot.image.total(), random)] = Share(random) < 0.5 ? 0 : 255;
    }
  }
  return faulty;
}

Recording DeadRows(const Recording& good, int rows, Random& random) {
  Recording faulty = good;
  for (Shot& shot : faulty) shot.image = shot.image.clone();
  for (int i = 0; i < rows; ++i) {
    const int row = static_cast<int>(Below(good.front().image.rows, random));
    const double value = Share(random) < 0.5 ? 0 : 255;
    for (Shot& shot : faulty) shot.image.row(row).setTo(value);
  }
  return faulty;
}

Recording CoveredHalf(const Recording& good) {
  Recording faulty = good;
  // A finger or tape near the lens: dark, its edge spread over a fifth of the image.
  cv::Mat light(good.front().image.size(), CV_32F);
  for (int u = 0; u < light.cols; ++u) {
    const double at = (u - 0.5 * light.cols) / (0.1 * light.cols);
    light.col(u).setTo(1 / (1 + std::exp(-2 * at)));
  }
  for (std::size_t i = faulty.size() / 2; i < faulty.size(); ++i) {
    cv::Mat covered;
    faulty[i].image.convertTo(covered, CV_32F);
    covered = covered.mul(light) + 12;
    faulty[i].image = cv::Mat();  // its pixels are those of the good one
    covered.convertTo(faulty[i].image, CV_8U);
  }
  return faulty;
}

Recording Dark(const Recording& good) {
  Recording faulty = good;
  for (std::size_t i = faulty.size() / 3; i < 2 * faulty.size() / 3; ++i) {
    faulty[i].image = cv::Mat(faulty[i].image.size(), CV_8U, cv::Scalar(0));
  }
  return faulty;
}

}  // namespace ceilmap::faults
