#pragma once

#include <cstdint>
#include <optional>

#include "calib/ceiling_view.hpp"
#include "calib/wheels/relative_motion.hpp"
#include "mapping/frame_prediction.hpp"
#include "mapping/graph/keyframe.hpp"
#include "mapping/registration/registrar.hpp"

namespace ceilmap::mapping {

// When and how the odometry begins a new segment (mapping/README.md). Internal to it.

/// An image that cannot be registered against itself has too little texture for a map.
registration::Registration RegisterWithItself(const registration::FrameSpectrum& spectrum,
                                              registration::Registrar& registrar);

/// Whether an image shows what the image before it showed. Noise in the dark fits to itself only.
/// @param before  Empty: there was none, and nothing persists.
/// @param step  Motion since that image, if it is known.
bool Persists(const calib::CeilingView& view,
              const registration::FrameSpectrum& before,
              const registration::FrameSpectrum& spectrum,
              const std::optional<Pose2>& step,
              registration::Registrar& registrar);

/// From the latest keyframe to the next one, where the wheels know the way since the last placed
/// frame. That frame was measured against a keyframe, exactly in comparison.
/// @param T_map_placed  Its pose. @param motion  Since then. @param to  Id of the next keyframe.
graph::Edge EdgeByWheels(const graph::Keyframe& from,
                         const Pose2& T_map_placed,
                         const wheels::RelativeMotion& motion,
                         std::int64_t to);

/// Whether little of a keyframe is in view at an expected pose.
bool LeavesBehind(const calib::CeilingView& view,
                  const graph::Keyframe& keyframe,
                  const ExpectedPose& expected);

}  // namespace ceilmap::mapping
