#include "tests/bench/panorama_metrics.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <opencv2/imgproc.hpp>

namespace ceilmap::bench {
namespace {

/// Calls f(reference value, current value) for each pixel and channel.
template <typename F>
void ForEachPair(const cv::Mat& reference,
                 const cv::Mat& current,
                 std::span<const int> columns,
                 int shift,
                 const F& f) {
  const int width = current.cols;
  const int channels = current.channels();
  for (int v = 0; v < current.rows; ++v) {
    const float* a = reference.ptr<float>(v);
    const float* b = current.ptr<float>(v);
    for (const int u : columns) {
      const int from = ((u - shift) % width + width) % width;
      for (int c = 0; c < channels; ++c) f(c, a[from * channels + c], b[u * channels + c]);
    }
  }
}

struct Moments {
  double n = 0;
  double a = 0;
  double b = 0;
  double aa = 0;
  double bb = 0;
  double ab = 0;

  void Add(double x, double y) {
    ++n;
    a += x;
    b += y;
    aa += x * x;
    bb += y * y;
    ab += x * y;
  }
  [[nodiscard]] double VarianceA() const { return aa - a * a / n; }
  [[nodiscard]] double VarianceB() const { return bb - b * b / n; }
  [[nodiscard]] double Covariance() const { return ab - a * b / n; }
};

double MutualInformation(const cv::Mat& reference,
                         const cv::Mat& current,
                         std::span<const int> columns,
                         int shift) {
  constexpr int kLevels = 16;
  std::array<double, kLevels> of_a{};
  std::array<double, kLevels> of_b{};
  std::array<double, kLevels * kLevels> of_both{};
  double count = 0;
  const auto level = [](float value) {
    return std::clamp(static_cast<int>(value / 256 * kLevels), 0, kLevels - 1);
  };
  ForEachPair(reference, current, columns, shift, [&](int, float a, float b) {
    const int i = level(a);
    const int j = level(b);
    ++of_a.at(i);
    ++of_b.at(j);
    ++of_both.at(i * kLevels + j);
    ++count;
  });
  double information = 0;
  for (int i = 0; i < kLevels; ++i) {
    for (int j = 0; j < kLevels; ++j) {
      const double both = of_both.at(i * kLevels + j);
      if (both > 0)
        information += both / count * std::log(both * count / (of_a.at(i) * of_b.at(j)));
    }
  }
  return information;
}

}  // namespace

const std::vector<NamedMetric>& Metrics() {
  static const std::vector<NamedMetric> metrics = {{Metric::kL1, "L1"},
                                                   {Metric::kL2, "L2"},
                                                   {Metric::kZssd, "ZSSD"},
                                                   {Metric::kZncc, "ZNCC"},
                                                   {Metric::kMutualInformation, "MI"}};
  return metrics;
}

cv::Mat InSpace(const cv::Mat& panorama, const std::string& space) {
  cv::Mat result;
  if (space == "grey") {
    cv::cvtColor(panorama, result, cv::COLOR_BGR2GRAY);
    result.convertTo(result, CV_32F);
  } else if (space == "Lab") {
    panorama.convertTo(result, CV_32F, 1.0 / 255);
    cv::cvtColor(result, result, cv::COLOR_BGR2Lab);  // L in 0..100
    result *= 2.55;
  } else {
    panorama.convertTo(result, CV_32F);
  }
  return result;
}

double Distance(const cv::Mat& reference,
                const cv::Mat& current,
                std::span<const int> columns,
                int shift,
                Metric metric) {
  if (metric == Metric::kMutualInformation) {
    return -MutualInformation(reference, current, columns, shift);
  }
  if (metric == Metric::kL1) {
    double sum = 0;
    ForEachPair(
        reference, current, columns, shift, [&](int, float a, float b) { sum += std::abs(a - b); });
    return sum;
  }
  std::array<Moments, 3> moments;
  ForEachPair(reference, current, columns, shift, [&](int c, float a, float b) {
    moments.at(c).Add(a, b);
  });
  double squares = 0;
  double covariance = 0;
  double variances_a = 0;
  double variances_b = 0;
  for (const Moments& m : moments) {
    if (m.n == 0) continue;
    if (metric == Metric::kL2) {
      squares += m.aa + m.bb - 2 * m.ab;
      continue;
    }
    squares += m.VarianceA() + m.VarianceB() - 2 * m.Covariance();
    covariance += m.Covariance();
    variances_a += m.VarianceA();
    variances_b += m.VarianceB();
  }
  if (metric != Metric::kZncc) return std::sqrt(std::max(squares, 0.0));
  const double scale = std::sqrt(variances_a * variances_b);
  return scale > 0 ? 1 - covariance / scale : 1;
}

}  // namespace ceilmap::bench
