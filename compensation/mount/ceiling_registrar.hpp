#pragma once

#include "calib/base/pose2.hpp"
#include "calib/ceiling_view.hpp"
#include "mapping/registration/plane_motion.hpp"
#include "mapping/registration/registrar.hpp"

namespace ceilmap::mount {

/// A registrar of the view's images, with its mask.
registration::Registrar CeilingRegistrar(const calib::CeilingView& view);

/// Motion of a level camera in units of the ceiling's distance.
registration::PlaneMotion LevelMotion(const Pose2& T_reference_current);

/// The same as the motion of the image.
registration::ImageMotion ImageMotionOf(const registration::PlaneCamera& camera,
                                        const Pose2& T_reference_current);

}  // namespace ceilmap::mount
