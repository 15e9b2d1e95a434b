#include "samples/simulator/sessions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

#include "calib/base/degrees.hpp"
#include "calib/base/error.hpp"
#include "samples/simulator/change_schedule.hpp"
#include "samples/simulator/random.hpp"
#include "samples/simulator/session_movers.hpp"

namespace ceilmap::simulator {
namespace {

/// Lamps off, and a camera that makes up for it by its gain: brightness remains relative to its
/// exposure.
void MakeNight(const Sessions& sessions, Scene& scene) {
  Ceiling& ceiling = scene.ceiling;
  ceiling.is_night = true;
  ceiling.lamps_lit_share = sessions.night_lamps_on_share;
  if (ceiling.light_contrast > 0) ceiling.light_contrast = sessions.night_light_contrast;
  const double off = 0.5 * ceiling.brightness;
  scene.fixtures.lamp_brightness = std::min(scene.fixtures.lamp_brightness, off);
  for (Structure& structure : scene.structures) {
    const bool is_lamp = structure.kind == StructureKind::kPendant ||
                         structure.kind == StructureKind::kTube ||
                         structure.kind == StructureKind::kSkylight;
    if (is_lamp) structure.brightness = std::min(structure.brightness, off);
  }
  scene.image.shot_noise *= std::sqrt(sessions.night_gain);
  scene.image.read_noise *= sessions.night_gain;
  scene.camera.exposure_time_s *= sessions.night_exposure_ratio;
}

std::vector<SunPatch> MakeSun(const Sessions& sessions, const Scene& scene) {
  Random random(DriveSeed(scene), Purpose::kSun);
  const double direction_rad = random.Uniform(0, std::numbers::pi);
  std::vector<SunPatch> patches;
  patches.reserve(static_cast<std::size_t>(sessions.sun_patches));
  for (int i = 0; i < sessions.sun_patches; ++i) {
    SunPatch patch;
    patch.x_m = random.Uniform(0, scene.room.length_m);
    patch.y_m = random.Uniform(0, scene.room.width_m);
    patch.length_m = random.Uniform(0.8, 3);
    patch.width_m = random.Uniform(0.3, 1);
    patch.yaw_rad = direction_rad + random.Uniform(-0.1, 0.1);
    patch.gain = sessions.sun_gain * random.Uniform(0.6, 1.2);
    patches.push_back(patch);
  }
  return patches;
}

void MakeDrive(const Sessions& sessions, Scene& scene) {
  Random random(DriveSeed(scene), Purpose::kSessionDrive);
  scene.path.jitter_m = sessions.path_jitter_m;
  scene.image.exposure_gain *= std::exp(sessions.exposure_spread * random.Normal());
  if (scene.path.kind != PathKind::kTum) {
    scene.path.start_stamp_s += *scene.session * sessions.interval_s;
  }
}

}  // namespace

bool Sessions::IsNight(int session) const {
  const bool listed =
      std::find(night_sessions.begin(), night_sessions.end(), session) != night_sessions.end();
  return listed || (night_every > 0 && session % night_every == night_every - 1);
}

void ApplySession(const Sessions& sessions, int session, Scene& scene) {
  if (!(sessions.banner_drop_m + 0.01 < scene.room.height_m)) {
    throw InputError(fmt::format("sessions.banner_drop_m = {:g}, must be less than room.height_m",
                                 sessions.banner_drop_m));
  }
  scene.session = session;
  scene.ceiling.panel_contrast = sessions.panel_contrast;
  scene.ceiling.banner_drop_m = sessions.banner_drop_m;
  scene.ceiling.changes = ScheduleChanges(scene, sessions, session);
  const bool is_night = sessions.IsNight(session);
  if (is_night) MakeNight(sessions, scene);
  for (const SessionMover& of : sessions.movers) {
    if (of.session == session) scene.movers.push_back(of.mover);
  }
  if (session == 0) return;
  MakeDrive(sessions, scene);
  if (!is_night) scene.ceiling.sun = MakeSun(sessions, scene);
  AddSessionMovers(sessions, scene);
}

std::string ChangesCsv(const Scene& scene) {
  if (!scene.session) return {};
  std::string text = "id,kind,detail,session,x_min,y_min,x_max,y_max,visible_share\n";
  const std::vector<CeilingChange>& changes = scene.ceiling.changes;
  for (std::size_t i = 0; i < changes.size(); ++i) {
    const CeilingChange& change = changes[i];
    const Eigen::Vector2d& low = change.area_m.min();
    const Eigen::Vector2d& high = change.area_m.max();
    fmt::format_to(std::back_inserter(text),
                   "{},{},{},{},{:.6f},{:.6f},{:.6f},{:.6f},{:.6f}\n",
                   change.id,
                   NameOf(change.kind),
                   NameOf(change.detail),
                   change.session,
                   low.x(),
                   low.y(),
                   high.x(),
                   high.y(),
                   VisibleShare(changes, i));
  }
  return text;
}

std::string DisturbancesCsv(const Scene& scene) {
  if (!scene.session) return {};
  std::string text = "kind,x,y,length,width,bottom,top,yaw_deg,velocity_x,velocity_y,from_s,to_s\n";
  for (const SunPatch& sun : scene.ceiling.sun) {
    fmt::format_to(std::back_inserter(text),
                   "sun,{:.6f},{:.6f},{:.6f},{:.6f},,,{:.6f},,,,\n",
                   sun.x_m,
                   sun.y_m,
                   sun.length_m,
                   sun.width_m,
                   sun.yaw_rad * kDegPerRad);
  }
  for (const Mover& mover : scene.movers) {
    fmt::format_to(std::back_inserter(text),
                   "mover,{:.6f},{:.6f},{:.6f},{:.6f},{:.6f},{:.6f},{:.6f},{:.6f},{:.6f},{:.6f},"
                   "{:.6f}\n",
                   mover.x_m,
                   mover.y_m,
                   mover.length_m,
                   mover.width_m,
                   mover.bottom_m,
                   mover.top_m,
                   mover.yaw_deg,
                   mover.velocity_x_m_s,
                   mover.velocity_y_m_s,
                   mover.from_s,
                   mover.to_s);
  }
  return text;
}

}  // namespace ceilmap::simulator
