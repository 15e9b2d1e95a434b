#pragma once

#include <opencv2/core.hpp>
#include <span>
#include <string>
#include <vector>

namespace ceilmap::bench {

/// How unlike two panoramas are, as Labrosse 2006, section 5, lists the candidates.
enum class Metric {
  kL1,                 ///< sum of absolute differences
  kL2,                 ///< root of the sum of squared differences, the paper's
  kZssd,               ///< kL2 of channels from which their means over the fields are taken
  kZncc,               ///< 1 - zero-mean normalised cross-correlation
  kMutualInformation,  ///< -mutual information of the grey values, 16 levels each, nats
};

struct NamedMetric {
  Metric metric;
  std::string name;
};
const std::vector<NamedMetric>& Metrics();

/// A panorama in a colour space, CV_32F with one or three channels of similar range.
/// @param space  "RGB", "Lab" (CIE L*a*b*) or "grey". @param panorama  CV_8UC3, BGR.
cv::Mat InSpace(const cv::Mat& panorama, const std::string& space);

/// The distance when the reference's content is moved to the right by `shift` columns, over the
/// columns of `current` that are listed. @param reference, current  Of InSpace, of one size.
double Distance(const cv::Mat& reference,
                const cv::Mat& current,
                std::span<const int> columns,
                int shift,
                Metric metric);

}  // namespace ceilmap::bench
