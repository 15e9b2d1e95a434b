#include "localization/localizer_settings.hpp"

namespace ceilmap::localization {

using Range = SettingRange;

void Describe(LocalizerParams& params, const Settings& settings) {
  const Settings heading = settings.In("heading");
  heading.Add("drift_rad2_per_s",
              params.heading.drift_rad2_per_s,
              "rad^2/s",
              Range::AtLeast(0),
              "Growth of the variance of the zero of relative headings.");
  heading.Add("noise_rad",
              params.heading.noise_rad,
              "rad",
              Range::Above(0),
              "Smallest standard deviation of a single heading.");
  const Settings motion = settings.In("motion");
  motion.Add("speed_noise",
             params.motion.speed_noise,
             "(m/s)^2/s",
             Range::Above(0),
             "Growth of the variance of the robot's speed.");
  motion.Add("turn_noise",
             params.motion.turn_noise,
             "(rad/s)^2/s",
             Range::Above(0),
             "Growth of the variance of the robot's turn rate.");
  const Settings hypotheses = settings.In("hypotheses");
  hypotheses.Add("confirmations",
                 params.hypotheses.confirmations,
                 "frames",
                 Range::AtLeast(1),
                 "Frames in which a place must be recognized before it is accepted.");
  hypotheses.Add("min_evidence",
                 params.hypotheses.min_evidence,
                 "nats",
                 Range::Above(0),
                 "A place is accepted when its evidence exceeds that of every other place by "
                 "this.");
  settings.Add("min_overlap",
               params.min_overlap,
               "",
               Range::Open(0, 1),
               "The next patch of the map is used when a smaller fraction of the current one is in "
               "view.");
  settings.Add("max_frames_at_start_prior",
               params.max_frames_at_start_prior,
               "frames",
               Range::AtLeast(1),
               "The whole map is searched after this many consecutive frames without a match near "
               "the start.");
  settings.Add("give_up_heading_after",
               params.give_up_heading_after,
               "frames",
               Range::AtLeast(1),
               "Relative headings exclude no place any more after this many consecutive frames "
               "without a place.");
  settings.Add("max_dropout_s",
               params.max_dropout_s,
               "s",
               Range::AtLeast(0),
               "Duration without visible texture during which the prediction remains valid.");
  settings.Add("speed_noise_when_lost_m_s",
               params.speed_noise_when_lost_m_s,
               "m/s",
               Range::Above(0),
               "Standard deviation of the speed of a robot while it cannot be measured.");
  settings.Add("scale_frames",
               params.scale_frames,
               "frames",
               Range::AtLeast(0),
               "Frames that measure the scale of the rig against the map; 0: the rig's scale is "
               "used.");
  settings.Add("tilt_checks",
               params.tilt_checks,
               "frames",
               Range::AtLeast(0),
               "Frames after the robot was found that are checked for residual tilt.");
  settings.Add("tilt_check_every",
               params.tilt_check_every,
               "frames",
               Range::AtLeast(0),
               "Later every frame of this number is checked; 0: none.");
}

}  // namespace ceilmap::localization
