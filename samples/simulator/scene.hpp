#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "calib/lens.hpp"
#include "samples/simulator/ceiling_change.hpp"
#include "samples/simulator/motion_sensors.hpp"
#include "samples/simulator/structure.hpp"

namespace ceilmap::simulator {

/// The simulated scene: a room, its ceiling and objects below it, a robot with an upward camera and
/// optionally a forward one and one under a mirror, its drive, obstacles on the floor, and the
/// image model. Every default gives a usable scene; the file format consists of these fields by
/// name (samples/simulator/README.md).
///
/// Frames as in CONTRIBUTING.md; the origin of `map` is a corner of the floor, x along the room's
/// length, y along its width, z up. Brightness is linear light, 1 = white in the image at exposure
/// gain 1. Fractions and contrasts are relative, e.g. 0.03 = 3 %.

/// The walls stand at x = 0, x = length, y = 0 and y = width.
struct Room {
  double length_m = 12;
  double width_m = 8;
  double height_m = 2.6;  ///< of the ceiling above the floor
  double wall_brightness = 0.3;
  double wall_contrast = 0.08;  ///< of the walls' weak texture
  /// Pictures, doors and panels at random positions of the walls: texture for a forward camera.
  double wall_posters_per_100m2 = 0;
  double floor_brightness = 0.1;
  double floor_contrast = 0;  ///< of the floor's texture
};

enum class CeilingKind {
  kTiles,     ///< tiles with joints, each with a texture of its own; stains, vents and lamps
  kPeriodic,  ///< identical tiles
  kPlaster,   ///< weak noise on several scales, no edges
  kUniform    ///< no texture
};

/// A unique disc on the ceiling, with an edge as sharp as the image resolution.
struct Mark {
  double x_m = 0;  ///< centre
  double y_m = 0;
  double radius_m = 0.05;
  double brightness = 0.1;
};

/// A rectangle of the ceiling, along its axes, of one brightness, Ceiling::brightness: it covers
/// the texture, joints, lamps and stains there, but no marks.
struct PlainPart {
  double x_m = 0;  ///< centre
  double y_m = 0;
  double length_m = 1;  ///< along x
  double width_m = 1;   ///< along y
};

struct Ceiling {
  CeilingKind kind = CeilingKind::kTiles;
  double brightness = 0.40;
  // Tiles, also periodic ones; the first tile's corner is the room's corner.
  double tile_length_m = 0.6;      ///< along x; for kPeriodic this is the period
  double tile_width_m = 0.6;       ///< along y
  double joint_m = 0.015;          ///< full width of the joint between two tiles
  double joint_contrast = 0.35;    ///< relative darkness of the joint
  double speckle_contrast = 0.05;  ///< standard deviation of a tile's grain or of the plaster
  /// A lamp instead of every n-th tile along x and y; 0: none. With kPeriodic this multiplies the
  /// period.
  int lamp_every_x = 0;
  int lamp_every_y = 0;
  double lamp_brightness = 2.5;
  /// Only for kPeriodic, with square tiles: the tile's image does not change with a quarter turn,
  /// so that the ceiling does not determine the quarter turn.
  bool symmetric = false;
  // Differences between places; not for kPeriodic.
  double tile_contrast = 0.02;   ///< standard deviation of the brightness from tile to tile
  double light_contrast = 0.05;  ///< slow variation of the light over metres (not for kUniform)
  double stains_per_100m2 = 4;   ///< water stains and scuffs
  double vents_per_100m2 = 1.5;  ///< tiles replaced by an air vent
  double lamps_off_share = 0.0;  ///< fraction of the lamps that are switched off
  /// Ribs of a corrugated deck, along x, at this spacing; 0: the ceiling is flat. The lower flanges
  /// are at room.height_m, the upper ones rib_depth_m higher.
  double rib_every_m = 0;
  double rib_depth_m = 0.05;
  /// Additional marks at random positions, of random size and shape (all kinds).
  int marks = 0;
  std::vector<Mark> marks_at;
  std::vector<PlainPart> plain;
  // The state of a session, by the group `sessions` of a scene file (sessions.hpp); no keys here.
  std::vector<CeilingChange> changes;
  double panel_contrast = 0.1;  ///< standard deviation of the brightness of new panels
  double banner_drop_m = 0;     ///< of the banners below the ceiling; 0: flat on it
  std::vector<SunPatch> sun;
  double lamps_lit_share = 1;  ///< of the lamps that are switched on, at night
  bool is_night = false;       ///< the uneven light has another pattern
};

/// A box with horizontal bottom, e.g. a lamp, a beam, a duct or a pillar.
struct Box {
  double x_m = 0;  ///< centre
  double y_m = 0;
  double length_m = 1;  ///< along the box's own x axis
  double width_m = 0.1;
  double bottom_m = 2.4;  ///< above the floor
  double top_m = 2.5;
  double yaw_deg = 0;       ///< of the box's x axis
  double brightness = 0.3;  ///< of the bottom; the sides are darker, with different values
};

/// Objects below the ceiling, which show parallax; random ones may touch each other.
struct Fixtures {
  double contrast = 0.04;   ///< of the weak texture of all boxes
  double beam_every_m = 0;  ///< beams across the room (along y) at this spacing; 0: none
  double beam_width_m = 0.2;
  double beam_depth_m = 0.25;
  double beam_brightness = 0.25;
  double pillar_every_m = 0;  ///< square pillars from floor to ceiling on a square grid; 0: none
  double pillar_width_m = 0.4;
  double lamps_per_100m2 = 0;  ///< long lamps slightly below the ceiling
  double lamp_drop_m = 0.15;   ///< from the ceiling to a lamp's bottom
  double lamp_brightness = 2.5;
  double ducts_per_100m2 = 0;       ///< air ducts and cable trays of 2 to 6 m
  double sprinklers_per_100m2 = 0;  ///< sprinklers and smoke detectors
  std::vector<Box> boxes;
};

/// A camera on the robot.
///
/// The upward camera, level and without yaw, has the robot's front at its image's top and the
/// robot's LEFT at its right (x_cam = +y_base, y_cam = -x_base, z_cam = +z_base). It is rotated by
/// its yaw, then about base y by its pitch, forward when positive, then about base x by its roll.
///
/// The forward camera, level and without yaw, points along base x (x_cam = -y_base, y_cam =
/// -z_base, z_cam = +x_base). It is rotated to the left by its yaw, then RAISED by its pitch, then
/// rolled about its optical axis, left side up.
struct Camera {
  int width_px = 640;
  int height_px = 480;
  double focal_px = 457.0;  ///< in both axes; the principal point is at the image's centre
  calib::LensModel distortion_model = calib::LensModel::kPlumbBob;
  std::array<double, 8> distortion{};  ///< coefficients of the model; the rest is zero
  double mount_x_m = 0;                ///< in base
  double mount_y_m = 0;
  double mount_height_m = 0.4;  ///< above the floor
  double mount_yaw_deg = 0;     ///< about the vertical
  double mount_pitch_deg = 0;   ///< deviation from level
  double mount_roll_deg = 0;
  double exposure_time_s = 0.005;
  /// Rolling shutter, upward camera only: from the exposure of the first row to that of the last
  /// one; < 0: the last row is first.
  double readout_time_s = 0;
  double saturation = 0;  ///< of the colours, forward camera only; 0: a grey camera
};

/// Half of the time from the beginning of the exposure of the first row to the end of that of the
/// last one.
inline double HalfExposure(const Camera& camera) {
  return (camera.exposure_time_s + std::abs(camera.readout_time_s)) / 2;
}

/// A forward camera with default values: 60 degrees wide, 0.45 m high.
inline Camera DefaultForwardCamera() {
  Camera camera;
  camera.focal_px = 554;
  camera.mount_height_m = 0.45;
  camera.exposure_time_s = 0.008;
  return camera;
}

/// From this frame on the exposure is multiplied by gain (which replaces that of the step before).
struct ExposureStep {
  std::int64_t frame = 0;
  double gain = 1;
};

/// A colour camera that points straight up at a convex hyperbolic mirror and has a view of 360
/// degrees: z^2/A^2 - r^2/B^2 = 1 (upper sheet), pinhole at (0, 0, -C), single viewpoint at (0, 0,
/// C), C^2 = A^2 + B^2, z upwards along the optical axis (calib::HyperbolicMirror). Without yaw,
/// its image's top is the robot's front and its right the robot's left. The exposure time is zero.
struct OmniCamera {
  int width_px = 480;
  int height_px = 480;
  double focal_px = 520;
  double mount_x_m = 0;  ///< of the pinhole, in base
  double mount_y_m = 0;
  double mount_height_m = 0.55;  ///< above the floor
  double mount_yaw_deg = 0;      ///< about the vertical
  double mirror_a_m = 0.028095;
  double mirror_b_m = 0.0234125;
  double rim_radius_m = 0.04;
  double body_below_deg = -60;  ///< below this elevation the robot itself is visible
  /// Image of the mirror's axis, relative to the image's centre, to the right and down.
  std::array<double, 2> centre_offset_px{};
  bool centre_in_rig = true;  ///< false: the rig states the axis at the image's centre
  double saturation = 1;      ///< of the colours; 0: grey
  // These replace the same fields of Image.
  double exposure_gain = 1;
  std::vector<ExposureStep> exposure_steps;

  /// Distance of the pinhole from the mirror's centre, and of the viewpoint on the other side.
  [[nodiscard]] double FocusM() const { return std::hypot(mirror_a_m, mirror_b_m); }
};

/// The image model from light to grey values, in this order: motion blur, glare, vignetting,
/// optical blur, exposure and flicker, noise, sRGB curve, 8 bit.
struct Image {
  bool motion_blur = true;  ///< by the true motion during the exposure
  double blur_px = 0.6;     ///< standard deviation of the optics' blur; 0: none
  double glare = 0.02;      ///< fraction of the light that spreads widely around bright areas
  double vignetting =
      0.3;  ///< relative loss of light in the corners; proportional to the squared radius
  double exposure_gain = 1;
  double exposure_drift = 0.0;    ///< amplitude of a slow sine
  double exposure_period_s = 30;  ///< of that sine
  std::vector<ExposureStep> exposure_steps;
  /// Times in which the light is out, for all cameras: their images show noise only. The middle of
  /// the exposure decides.
  std::vector<TimeSpan> dark;
  /// Time constant of an automatic exposure, which keeps the mean light of the upward images, cut
  /// off at white, at that of the first frame (FollowExposure); 0: none.
  double auto_exposure_lag_s = 0;
  /// Lamps on the mains: all light is 1 + flicker_depth * sin(2 pi flicker_hz t), t from
  /// path.start_stamp_s. Each row has its mean over the row's own exposure, so that a rolling
  /// shutter shows bands.
  double flicker_hz = 100;
  double flicker_depth = 0;
  /// Colour cameras only: amplitude of a slow sine of period exposure_period_s. Red is multiplied
  /// by 1 + it, blue by 1 - it.
  double white_balance_drift = 0;
  double shot_noise =
      0.008;  ///< standard deviation at white; proportional to the square root of the light
  double read_noise = 0.0005;  ///< standard deviation everywhere
  double gain_spread =
      0.003;  ///< standard deviation of the pixels' sensitivity, constant over time
};

enum class PathKind {
  kLawnmower,   ///< rows along x, `row_spacing_m` apart, from the area's lower left corner
  kLoops,       ///< `laps` times along the area's border, counter-clockwise
  kWaypoints,   ///< straight from point to point
  kRandomWalk,  ///< random points in the area until `length_m` is driven
  kTum          ///< the poses of a file
};

/// Pose of the robot at a time.
struct PathPose {
  double stamp_s = 0;
  Eigen::Isometry3d T_map_base = Eigen::Isometry3d::Identity();
};

/// The robot is lifted at a time and stands at another pose of base in map an instant later, from
/// where it goes on as if nothing had happened: its motion relative to itself is that of the path.
/// It does not depend on the rows before.
struct Carried {
  double at_s = 0;
  double x_m = 0;
  double y_m = 0;
  double yaw_deg = 0;
};

/// The robot's drive. All kinds but kTum start and end at rest and turn at corners: on the spot if
/// corner_radius_m is 0, else on arcs without stopping.
struct Path {
  PathKind kind = PathKind::kLawnmower;
  double frame_rate_hz = 10;
  double start_stamp_s = 100;
  int max_frames = 0;  ///< 0: the whole path
  /// Area of the drive of the axle: x_min, y_min, x_max, y_max.
  std::array<double, 4> area_m{1.5, 1.5, 10.5, 6.5};
  double row_spacing_m = 1.0;
  int laps = 2;
  double length_m = 50;
  std::vector<std::array<double, 2>> waypoints_m;
  std::filesystem::path tum_file;  ///< relative to the scene's file; ReadScene does not open it
  /// kTum: content of tum_file, stamps increasing. The caller reads it, as with files::ReadTum.
  std::vector<PathPose> poses;
  double corner_radius_m = 0;
  double speed_m_s = 0.8;
  double acceleration_m_s2 = 0.6;
  double turn_rate_deg_s = 45;
  double turn_acceleration_deg_s2 = 90;
  std::vector<Carried> carried;  ///< in the order of their times
  /// Largest deviation of a corner in x and in y, by session; no key here (sessions.path_jitter_m).
  double jitter_m = 0;
};

/// Debris on the floor that the robot drives over. Its tilt is a raised cosine of the axle's
/// distance travelled s: x * (1 - cos(2 pi (s - start) / length)) / 2. Tilts of overlapping bumps
/// are added.
struct Bump {
  double start_m = 0;  ///< distance travelled by the axle; turns on the spot add nothing
  double length_m = 0.4;
  double pitch_deg =
      0;  ///< at the top; positive: nose up, about the line where the axle's wheels stand
  double roll_deg = 0;  ///< at the top; positive: left side up, about base x
};

struct Debris {
  std::vector<Bump> bumps;
  /// Uneven ground, in addition: standard deviation of the random pitch and of the random roll,
  /// each in the middle of a bump (UnevenGround). 0: the floor is level.
  double uneven_deg = 0;
  double uneven_length_m = 1;  ///< of such a bump
};

/// A coloured box that moves straight through the room, visible in all cameras. It does not move
/// during an exposure.
struct Mover {
  double x_m = 0;  ///< centre, when it appears
  double y_m = 0;
  double length_m = 0.5;  ///< along the box's own x axis
  double width_m = 0.5;
  double bottom_m = 0;
  double top_m = 1.7;
  double yaw_deg = 0;
  double red = 1;  ///< light of its bottom, as Box::brightness
  double green = 0.2;
  double blue = 0.2;
  double velocity_x_m_s = 0;
  double velocity_y_m_s = 0;
  /// Time of its presence, from..to (StartStamp).
  double from_s = 0;
  double to_s = 0;
};

struct Scene {
  std::uint64_t seed = 1;  ///< of all random numbers
  /// The session that is shown, if the scene has the group `sessions`; 0: as built.
  std::optional<int> session;
  std::string robot = "simulated robot";
  /// Distance of the axle behind the camera mast: the robot turns about base x = -a, so base moves
  /// on circles.
  double axle_behind_mast_m = 0;
  Room room;
  Ceiling ceiling;
  Fixtures fixtures;
  Camera camera;                   ///< upward camera
  std::optional<Camera> forward;   ///< forward camera, with the same image times
  std::optional<OmniCamera> omni;  ///< omnidirectional camera, with the same image times
  Image image;                     ///< of all cameras
  std::vector<Structure> structures;
  std::vector<Mover> movers;
  Path path;
  std::optional<Wheels> wheels;  ///< recorded if present
  std::optional<Gyro> gyro;      ///< recorded if present
  Debris debris;                 ///< not with PathKind::kTum, whose poses contain the tilt

  /// @throws InputError `KEY = VALUE, must be ...` for the first field out of range, and for
  /// inconsistent parts (camera above the ceiling, area outside the room, ...).
  void Validate() const;
};

/// Stamp of the scene's time 0, from which movers, dark times, slips etc. count: the start of the
/// path; with PathKind::kTum 0, so that the times are the file's own.
inline double StartStamp(const Scene& scene) {
  return scene.path.kind == PathKind::kTum ? 0 : scene.path.start_stamp_s;
}

/// Seed of what differs between the sessions of a scene: noise, jitter of the path, wheels.
inline std::uint64_t DriveSeed(const Scene& scene) {
  return scene.seed + (static_cast<std::uint64_t>(scene.session.value_or(0)) << 32U);
}

/// Replaces what a scene file states.
struct SceneChoice {
  std::optional<std::uint64_t> seed;
  std::optional<int> session;  ///< 0..kMaxSession; the file must have the group `sessions`
};
inline constexpr int kMaxSession = 10000;

/// Reads a scene strictly: an unknown key, a key that the selected kind does not use, a wrong type
/// or an invalid value is an error. The result is valid.
/// @throws InputError `FILE:LINE: KEY = VALUE, must be ...; how to fix it`
Scene ReadScene(const std::filesystem::path& file);

/// The same from a text. @param file  its name in messages; relative paths start at its folder.
Scene ParseScene(const std::string& text,
                 const std::filesystem::path& file,
                 const SceneChoice& choice = {});

}  // namespace ceilmap::simulator
