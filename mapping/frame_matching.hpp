#pragma once

#include <optional>

#include "calib/ceiling_view.hpp"
#include "mapping/frame_prediction.hpp"
#include "mapping/recent_keyframes.hpp"
#include "mapping/registration/registrar.hpp"

namespace ceilmap::mapping {

/// Registers a frame with a keyframe, in the order of what it takes for granted: as one plane; with
/// depth, where a plane does not explain the images; all blocks jointly, where neither finds a
/// motion (weak texture). The last two only near an expected pose. Internal to the odometry.
registration::Registration MatchFrame(const calib::CeilingView& view,
                                      const RecentKeyframe& reference,
                                      const registration::FrameSpectrum& spectrum,
                                      const std::optional<ExpectedPose>& expected,
                                      registration::Registrar& registrar);

/// Whether one of the images is blurred by motion, so that blocks may agree at one end of the blur,
/// and the motion that was found leaves much unexplained.
bool IsHiddenByBlur(const RecentKeyframe& reference,
                    const registration::FrameSpectrum& spectrum,
                    const registration::Registration& found,
                    registration::Registrar& registrar);

}  // namespace ceilmap::mapping
