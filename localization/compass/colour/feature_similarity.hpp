#pragma once

#include <Eigen/Core>
#include <limits>

namespace ceilmap::colour {

/// Smallest values of the three differences. The paper divides by each of them and states nothing
/// about a difference of zero; smaller ones count as these.
struct SimilarityLimits {
  /// > 0. About half a cell, the accuracy of a localization that is worth a grid of cells. Features
  /// of the robot's own cell then count alike; those of other cells count less.
  double distance_m = 0.5;
  double angle_rad = 0.02;  ///< > 0. The query takes half the width of a bin, its resolution
  /// > 0. Two images of one line differ by about this. With 0.01, one line of bare wall, which is
  /// equal everywhere, outweighs all others.
  double difference = 0.1;

  void Validate() const;  ///< throws InputError naming field, value and range
};

/// diff(f1, f2) of Methenitis et al. 2013, section 3.4: the difference of two features.
///
/// "The color transition frequencies are subtracted from one", so that frequent transitions (a bare
/// wall) count less than rare ones (a stripe on it). The paper prints no formula. If the
/// frequencies themselves were replaced by 1 - f, their differences would not change. Here the
/// absolute differences are weighted by one minus the frequency, which is the mean of the two
/// features:
///
///     diff(f1, f2) = sum of (1 - (f1 + f2) / 2) |f1 - f2|        in [0, 2)
///
/// @param f1, f2  k x k frequencies in [0, 1], of equal size.
double FeatureDifference(const Eigen::Ref<const Eigen::VectorXf>& f1,
                         const Eigen::Ref<const Eigen::VectorXf>& f2);

/// The three differences of two features and their certainties.
struct FeaturePair {
  /// Between the positions of both features. Not known: unset, the factor is 1.
  double distance_m = std::numeric_limits<double>::quiet_NaN();
  /// Between their directions, >= 0. Not known: unset, the factor is 1.
  double angle_rad = std::numeric_limits<double>::quiet_NaN();
  double difference = 0;   ///< FeatureDifference
  double certainty_1 = 1;  ///< m(f1)
  double certainty_2 = 1;  ///< m(f2)
};

/// sim(f1, f2) = 1 / diff(l_f1, l_f2) * 1 / diff(alpha_f1, alpha_f2) * 1 / diff(f1, f2) * m(f1) *
/// m(f2), the first equation of section 3.4; the unit of time, length and angle is a common factor.
double Similarity(const FeaturePair& pair, const SimilarityLimits& limits);

}  // namespace ceilmap::colour
