#pragma once

#include <deque>
#include <vector>

#include "mapping/registration/registrar.hpp"

namespace ceilmap::mapping {

/// How well two images fit under the motion that was found between them.
struct MatchQuality {
  double inlier_ratio = 0;   ///< of the compared blocks, 0..1
  double peak = 0;           ///< Registration::peak, 0..1
  double dissimilarity = 0;  ///< Dissimilarity::mean, nats, >= 0
};

/// @param unlike  of the same images under the registration's motion.
MatchQuality QualityOf(const registration::Registration& registration,
                       const registration::Dissimilarity& dissimilarity);

/// Each number by itself; all 0 of none. Takes a copy.
MatchQuality Median(std::vector<MatchQuality> matches);

struct MatchGateParams {
  int remembered = 15;                    ///< matches that are known to be right, the last ones
  double min_inlier_ratio = 0.93;         ///< of what is typical of them
  double min_peak_ratio = 0.87;           ///< the same
  double max_dissimilarity_ratio = 1.25;  ///< the same
  /// Never worse than this, whatever is typical; alone as long as nothing is known to be right.
  double max_dissimilarity = 1.6;
};

/// What matches look like that are known to be right: of neighbours on the robot's way, taken by
/// the same camera in the same light. On a tiled ceiling the registration takes another place for
/// the right one where joints and lamps fit (210 of 1600 pairs that had nothing but the grid in
/// common, 40 simulated rooms). There the images fit worse than neighbours do: grain, stains and
/// what hangs from the ceiling do not. Of 343 such false matches 33 met this standard (1 of 134
/// where the tiles' grain can be seen), of true ones 349 of 389, and 147 of 191 under another
/// exposure.
class MatchGate {
 public:
  explicit MatchGate(const MatchGateParams& params = {}) : params_(params) {}

  /// A match that is known to be right.
  void Add(const MatchQuality& right);
  /// Does a match look as those do?
  [[nodiscard]] bool Meets(const MatchQuality& match) const;

 private:
  MatchGateParams params_;
  std::deque<MatchQuality> right_;
};

}  // namespace ceilmap::mapping
