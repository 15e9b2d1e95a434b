#include "localization/compass/colour/line_features.hpp"

namespace ceilmap::colour {

void CountTransitions(const cv::Mat& samples,
                      const ScanLines& lines,
                      const ColourClasses& classes,
                      LineFeatures& features) {
  const int k = classes.Count();
  features.setZero(samples.rows, Eigen::Index{k} * k);
  for (int i = 0; i < samples.rows; ++i) {
    const std::uint8_t* bgr = samples.ptr(i);
    const int n = lines.Length(static_cast<std::size_t>(i));
    const float share = 1.F / static_cast<float>(n - 1);
    float* row = features.row(i).data();
    int before = classes.Of(bgr);
    for (int u = 1; u < n; ++u) {
      bgr += 3;
      const int now = classes.Of(bgr);
      if (before < k && now < k) row[before * k + now] += share;
      before = now;
    }
  }
}

}  // namespace ceilmap::colour
