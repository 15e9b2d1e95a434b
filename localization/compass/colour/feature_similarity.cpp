#include "localization/compass/colour/feature_similarity.hpp"

#include <algorithm>
#include <cmath>

#include "calib/base/field_check.hpp"

namespace ceilmap::colour {
namespace {

double Inverse(double difference, double least) {
  return std::isnan(difference) ? 1 : 1 / std::max(difference, least);
}

}  // namespace

void SimilarityLimits::Validate() const {
  const FieldCheck require("similarity");
  require(distance_m > 0, "distance_m", distance_m, "> 0");
  require(angle_rad > 0, "angle_rad", angle_rad, "> 0");
  require(difference > 0, "difference", difference, "> 0");
}

double FeatureDifference(const Eigen::Ref<const Eigen::VectorXf>& f1,
                         const Eigen::Ref<const Eigen::VectorXf>& f2) {
  return double{((1 - 0.5F * (f1 + f2).array()) * (f1 - f2).array().abs()).sum()};
}

double Similarity(const FeaturePair& pair, const SimilarityLimits& limits) {
  return Inverse(pair.distance_m, limits.distance_m) * Inverse(pair.angle_rad, limits.angle_rad) *
         Inverse(pair.difference, limits.difference) * pair.certainty_1 * pair.certainty_2;
}

}  // namespace ceilmap::colour
