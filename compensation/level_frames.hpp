#pragma once

/// When a level frame becomes the keyframe against which tilts are measured, and what is assumed
/// where none was measured.
namespace ceilmap::compensation {

/// After this many consecutive level frames the one in their middle may become the keyframe. The
/// first and the last one are excluded, because a bump may begin or end there with a tilt below
/// detection.
inline constexpr int kLevelFrames = 3;
/// A new keyframe is needed when the zoom of the forward image has changed by more than this.
inline constexpr double kRenewZoom = 0.03;
/// After this many consecutive frames without a measurement the keyframe is discarded.
inline constexpr int kRestartAfter = 5;
/// Upper limit of the standard deviation of a tilt: debris is not higher, rad.
inline constexpr double kUnknownSigmaRad = 0.035;
/// Standard deviation of a keyframe that was assumed level without a measurement, rad.
inline constexpr double kAssumedSigmaRad = 0.002;

}  // namespace ceilmap::compensation
