#include "mapping/places/place_fit.hpp"

#include <cstddef>
#include <optional>
#include <utility>

namespace ceilmap::places {
namespace {

// The motion of two pairs; none if they are too close together, or have different distances in the
// two images.
std::optional<PlaceMotion> MotionOf(const PlacePair& a, const PlacePair& b, float tolerance) {
  const ImagePoint in_query = b.query - a.query;
  const ImagePoint in_stored = b.stored - a.stored;
  const float length = std::abs(in_query);
  const float stored_length = std::abs(in_stored);
  if (length < 3 * tolerance || std::abs(length - stored_length) > 1.5F * tolerance) {
    return std::nullopt;
  }
  const ImagePoint turn = in_stored * std::conj(in_query) / (length * stored_length);
  return PlaceMotion{turn, 0.5F * (a.stored + b.stored) - turn * 0.5F * (a.query + b.query)};
}

// Whether a pair agrees with the motion of `a` and `b`. The effect of their errors increases with
// the distance from them.
bool Agrees(const PlacePair& pair,
            const PlaceMotion& motion,
            const PlacePair& a,
            const PlacePair& b,
            float tolerance) {
  const float arm = std::abs(pair.query - 0.5F * (a.query + b.query));
  const float allowed = tolerance * (1 + arm / std::abs(b.query - a.query));
  return std::norm(motion.turn * pair.query + motion.shift - pair.stored) < allowed * allowed;
}

PlaceFit Fit(std::span<const PlacePair> pairs, std::size_t i, std::size_t j, float tolerance) {
  PlaceFit fit;
  const std::optional<PlaceMotion> motion = MotionOf(pairs[i], pairs[j], tolerance);
  if (!motion) return fit;
  fit.motion = *motion;
  for (const PlacePair& pair : pairs) {
    if (!Agrees(pair, *motion, pairs[i], pairs[j], tolerance)) continue;
    fit.weight += pair.weight;
    ++fit.pairs;
  }
  return fit;
}

}  // namespace

PlaceFit BestFit(std::span<const PlacePair> pairs, float tolerance) {
  PlaceFit best;
  std::pair<std::size_t, std::size_t> defining;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    for (std::size_t j = i + 1; j < pairs.size(); ++j) {
      const PlaceFit fit = Fit(pairs, i, j, tolerance);
      if (fit.weight <= best.weight) continue;
      best = fit;
      defining = {i, j};
    }
  }
  if (best.pairs == 0) return best;
  // Weighted least squares over all pairs that agree.
  const PlacePair& a = pairs[defining.first];
  const PlacePair& b = pairs[defining.second];
  ImagePoint query_mean;
  ImagePoint stored_mean;
  ImagePoint turn;
  for (const bool means : {true, false}) {
    for (const PlacePair& pair : pairs) {
      if (!Agrees(pair, best.motion, a, b, tolerance)) continue;
      if (means) {
        query_mean += pair.query * (pair.weight / best.weight);
        stored_mean += pair.stored * (pair.weight / best.weight);
      } else {
        turn += pair.weight * (pair.stored - stored_mean) * std::conj(pair.query - query_mean);
      }
    }
  }
  if (std::abs(turn) > 0) {
    best.motion.turn = turn / std::abs(turn);
    best.motion.shift = stored_mean - best.motion.turn * query_mean;
  }
  return best;
}

}  // namespace ceilmap::places
