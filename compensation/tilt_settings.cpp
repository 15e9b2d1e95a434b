#include "compensation/tilt_settings.hpp"

namespace ceilmap::compensation {

using Range = SettingRange;

void Describe(TiltEstimatorParams& params, const Settings& settings) {
  settings.Add("level_sigmas",
               params.level_sigmas,
               "sigmas",
               Range::AtLeast(0),
               "A tilt within this many standard deviations of level is set to zero.");
  settings.Add("tilted_sigmas",
               params.tilted_sigmas,
               "sigmas",
               Range::Above(0),
               "A tilt beyond this many standard deviations is taken as measured; must be larger "
               "than `level_sigmas`.");
  const Settings solver = settings.In("solver");
  solver.Add("wall_per_m",
             params.solver.wall_per_m,
             "1/m",
             Range::Above(0),
             "Expected inverse distance of the wall ahead before any measurement.");
  solver.Add("wall_per_m_sigma",
             params.solver.wall_per_m_sigma,
             "1/m",
             Range::Above(0),
             "Its standard deviation.");
  solver.Add("ceiling_motion_sigma_m",
             params.solver.ceiling_motion_sigma_m,
             "m",
             Range::Above(0),
             "Standard deviation of the motion that the ceiling gives.");
  settings.In("filter").Add("acceleration",
                            params.filter.acceleration,
                            "rad/s^2",
                            Range::Above(0),
                            "Standard deviation of the angular acceleration of the tilt.");
}

}  // namespace ceilmap::compensation
