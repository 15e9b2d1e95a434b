#pragma once

#include <deque>
#include <vector>

#include "mapping/registration/registrar.hpp"

namespace ceilmap::mapping {

/// Quality of the match of two images under the motion that was found between them.
struct MatchQuality {
  double inlier_ratio = 0;   ///< of the compared blocks, 0..1
  double peak = 0;           ///< Registration::peak, 0..1
  double dissimilarity = 0;  ///< Dissimilarity::mean, nats, >= 0
};

/// @param dissimilarity  of the same images under the registration's motion.
MatchQuality QualityOf(const registration::Registration& registration,
                       const registration::Dissimilarity& dissimilarity);

/// Median of each field separately; all fields 0 for an empty input. Takes a copy.
MatchQuality Median(std::vector<MatchQuality> matches);

/// Gate on match quality, learned from matches that are known to be correct: those between
/// neighbouring frames of the robot's path, taken by the same camera in the same light. On a tiled
/// ceiling the registration may accept a wrong place where joints and lamps coincide (perceptual
/// aliasing). There the images fit worse than those of neighbouring frames: grain, stains and
/// things that hang from the ceiling differ. The gate rejects most of these false matches, more
/// reliably where the grain of the tiles is visible, and accepts most true ones, fewer of them
/// under another exposure.
class MatchGate {
 public:
  /// Number of latest correct matches that are used, unless stated otherwise.
  static constexpr int kRemembered = 15;
  /// @param remembered  number of latest correct matches that are used, > 0.
  explicit MatchGate(int remembered = kRemembered) : remembered_(remembered) {}

  /// Adds a match that is known to be correct.
  void Add(const MatchQuality& right);
  /// Medians of the correct matches; all 0 without any.
  [[nodiscard]] MatchQuality Typical() const { return Median({right_.begin(), right_.end()}); }
  /// Whether a match is as good as the correct matches.
  [[nodiscard]] bool Accepts(const MatchQuality& match) const;

 private:
  int remembered_;
  std::deque<MatchQuality> right_;
};

}  // namespace ceilmap::mapping
