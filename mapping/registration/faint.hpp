#pragma once

namespace ceilmap::registration {

/// Under a ceiling with depth, a match or a motion of less agreement (Registration::peak) is faint.
/// Halls and rooms whose structure is clear have 0.15 and more. In noisy images of a plain ceiling
/// the few blocks that agree lie mostly at the rims of lamps, which tell no turn: motions were off
/// by 3 to 10 standard deviations, poses of a robot that was followed by 149 mm and 8 degrees. All
/// blocks jointly (RegisterJointly, CorrectJointly) state what is known there.
inline constexpr double kFaintDepthPeak = 0.13;

}  // namespace ceilmap::registration
