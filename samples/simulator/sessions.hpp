#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calib/base/yaml_value.hpp"
#include "samples/simulator/scene.hpp"

namespace ceilmap::simulator {

/// A mover that is there in one session only.
struct SessionMover {
  int session = 0;
  Mover mover;
};

/// What happens to a scene from one session to the next. Session 0 is the scene as built; session N
/// has the changes of all sessions up to N. Each session is another drive with other noise.
struct Sessions {
  /// Of the ceiling's area: what changes from a session to the next.
  double changed_share_per_session = 0.02;
  // Parts of the changed area, relative to their sum.
  double panel_share = 0.5;
  double opening_share = 0.1;
  double lamp_share = 0.1;
  double banner_share = 0.3;
  int panel_max_tiles = 3;            ///< longest side of a replaced panel
  double panel_contrast = 0.1;        ///< standard deviation of the brightness of new panels
  double lamps_switched_share = 0.2;  ///< of the lamp changes; the rest is replaced or moved
  double lamps_moved_share = 0.4;     ///< likewise
  double banner_length_m = 3;         ///< mean; each is up to 30 % longer or shorter
  double banner_width_m = 1;
  double banner_drop_m = 0;  ///< below the ceiling; 0: flat on it
  // The drive.
  double path_jitter_m = 0;    ///< largest deviation of a corner of the path, in x and in y
  double exposure_spread = 0;  ///< standard deviation of the logarithm of the exposure
  double interval_s = 86400;   ///< from the start of a session to that of the next; not kTum
  // Night: the lamps are off and the camera's gain is higher.
  int night_every = 0;  ///< sessions n-1, 2n-1, ... are at night; 0: none
  std::vector<int> night_sessions;
  double night_lamps_on_share = 0.1;
  double night_gain = 4;              ///< of the camera, relative to day: more noise
  double night_exposure_ratio = 1;    ///< of the exposure time, relative to day
  double night_light_contrast = 0.1;  ///< of the uneven light, which has another pattern
  // In view, but no changes of the ceiling. From session 1 on.
  int sun_patches = 0;  ///< in a session by day
  double sun_gain = 0.6;
  int people = 0;  ///< that pass close to the robot, in a session
  int masts = 0;   ///< of fork lifts; each second one stands all the time
  std::vector<SessionMover> movers;

  [[nodiscard]] bool IsNight(int session) const;
};

/// The groups `sessions` and `session` of a scene file; nothing if it has none.
/// @param session  Set to that of the file unless it is given.
/// @throws InputError `FILE:LINE: KEY = VALUE, must be ...; how to fix it`
std::optional<Sessions> ReadSessionsOf(const YamlValue& root,
                                       const Path& path,
                                       std::optional<int>& session);

/// Puts the scene into the state of a session.
/// @param scene  As built, valid; of PathKind::kTum only without path_jitter_m, people and masts.
/// @throws InputError `KEY = VALUE, must be ...` when the session has too many changes.
void ApplySession(const Sessions& sessions, int session, Scene& scene);

/// changes.csv of a scene: the changes that it has,
/// `id,kind,detail,session,x_min,y_min,x_max,y_max,visible_share`, in map, metres. Empty when the
/// scene has no sessions.
std::string ChangesCsv(const Scene& scene);

/// disturbances.csv of a scene: what is in view but no change of the ceiling, sun and movers,
/// `kind,x,y,length,width,bottom,top,yaw_deg,velocity_x,velocity_y,from_s,to_s`, of the columns of
/// `movers`; those that sun does not have are empty. Empty when the scene has no sessions.
std::string DisturbancesCsv(const Scene& scene);

}  // namespace ceilmap::simulator
