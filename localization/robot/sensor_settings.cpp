#include "localization/robot/sensor_settings.hpp"

#include "compensation/tilt_settings.hpp"

namespace ceilmap::robot {

void Describe(SensorsParams& params, const Settings& settings) {
  settings.Add("max_offset_s",
               params.max_offset_s,
               "s",
               SettingRange::Above(0),
               "Largest distance in time between an upward image and the image of another camera "
               "that is used with it.");
  compensation::Describe(params.tilt, settings.In("tilt"));
}

}  // namespace ceilmap::robot
