// What a registration says of the images: its verdict, and whether the ceiling is one plane.

#include "mapping/registration/registrar.hpp"

namespace ceilmap::registration {
namespace {

// Part of the blocks that agree with one plane, where the ceiling is one.
constexpr double kPlaneInlierRatio = 0.75;
// Unknown heights are believed where this part of the blocks, or of their texture, agrees, with
// this mean evidence, ...
constexpr double kBelievedInliers = 0.6;
constexpr double kBelievedPeak = 0.25;
// ... and this part of the measured heights is off most of the others. Level frames of flat
// ceilings have up to 0.06.
constexpr double kMinUnevenRatio = 0.15;
// Where one plane explains nothing, less is sufficient. In a plain room right motions had 0.56 and
// 0.18 and more. From starts that were 16 px away, most wrong ones had up to 0.5 and 0.16, some
// with errors of 4 px and half a degree up to 0.64 and 0.23.
constexpr double kGuessedInliers = 0.55;
constexpr double kGuessedPeak = 0.17;

}  // namespace

const char* ToString(Verdict verdict) {
  switch (verdict) {
    case Verdict::kOk:
      return "ok";
    case Verdict::kNoTexture:
      return "no texture";
    case Verdict::kNoMatch:
      return "no match";
    case Verdict::kAmbiguous:
      return "ambiguous";
  }
  return "?";
}

bool Registration::IsPlane() const {
  return ok() && inliers >= kPlaneInlierRatio * blocks;
}

bool Registration::IsBestGuess() const {
  return ok() && textured_peak >= kGuessedPeak && textured_inliers >= kGuessedInliers;
}

bool Registration::ShowsDepth() const {
  const bool believed = (peak >= kBelievedPeak && inliers >= kBelievedInliers * blocks) ||
                        (textured_peak >= kBelievedPeak && textured_inliers >= kBelievedInliers);
  return ok() && heights && believed && heights->UnevenRatio() >= kMinUnevenRatio;
}

}  // namespace ceilmap::registration
