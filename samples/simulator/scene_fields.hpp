#pragma once

#include <array>
#include <limits>
#include <string>
#include <string_view>
#include <variant>

#include "samples/simulator/scene.hpp"
#include "samples/simulator/sessions.hpp"

namespace ceilmap::simulator {

/// The plain fields of a scene with their ranges, shared by the reader, the checks and the
/// messages. Lists of numbers are handled in scene.cpp and scene_reader.cpp.

/// Bit of a kind in Field::kinds.
template <typename Kind>
constexpr unsigned Only(Kind kind) {
  return 1U << static_cast<unsigned>(kind);
}
inline constexpr unsigned kEveryKind = ~0U;

template <typename Group>
struct Field {
  std::string_view key;
  std::variant<double Group::*, int Group::*, bool Group::*> member;
  double least = 0;
  double most = 0;
  unsigned kinds = kEveryKind;  ///< kinds of the group that use the field
};

inline constexpr double kNoLimit = std::numeric_limits<double>::infinity();

inline constexpr std::array kRoomFields{
    Field<Room>{"length_m", &Room::length_m, 0.5, 2000},
    Field<Room>{"width_m", &Room::width_m, 0.5, 2000},
    Field<Room>{"height_m", &Room::height_m, 0.5, 100},
    Field<Room>{"wall_brightness", &Room::wall_brightness, 0, 7},
    Field<Room>{"wall_contrast", &Room::wall_contrast, 0, 0.3},
    Field<Room>{"wall_posters_per_100m2", &Room::wall_posters_per_100m2, 0, 500},
    Field<Room>{"floor_brightness", &Room::floor_brightness, 0, 7},
    Field<Room>{"floor_contrast", &Room::floor_contrast, 0, 0.3},
};

inline constexpr unsigned kTiled = Only(CeilingKind::kTiles) | Only(CeilingKind::kPeriodic);
inline constexpr unsigned kTilesOnly = Only(CeilingKind::kTiles);
inline constexpr unsigned kUneven = kTilesOnly | Only(CeilingKind::kPlaster);

inline constexpr std::array kCeilingFields{
    Field<Ceiling>{"brightness", &Ceiling::brightness, 0, 7},
    Field<Ceiling>{"tile_length_m", &Ceiling::tile_length_m, 0.05, 20, kTiled},
    Field<Ceiling>{"tile_width_m", &Ceiling::tile_width_m, 0.05, 20, kTiled},
    Field<Ceiling>{"joint_m", &Ceiling::joint_m, 0, 1, kTiled},
    Field<Ceiling>{"joint_contrast", &Ceiling::joint_contrast, 0, 1, kTiled},
    Field<Ceiling>{"speckle_contrast",
                   &Ceiling::speckle_contrast,
                   0,
                   0.3,
                   kTiled | Only(CeilingKind::kPlaster)},
    Field<Ceiling>{"lamp_every_x", &Ceiling::lamp_every_x, 0, 1000, kTiled},
    Field<Ceiling>{"lamp_every_y", &Ceiling::lamp_every_y, 0, 1000, kTiled},
    Field<Ceiling>{"lamp_brightness", &Ceiling::lamp_brightness, 0, 7, kTiled},
    Field<Ceiling>{"symmetric", &Ceiling::symmetric, 0, 0, Only(CeilingKind::kPeriodic)},
    Field<Ceiling>{"tile_contrast", &Ceiling::tile_contrast, 0, 0.3, kTilesOnly},
    Field<Ceiling>{"light_contrast", &Ceiling::light_contrast, 0, 0.3, kUneven},
    Field<Ceiling>{"stains_per_100m2", &Ceiling::stains_per_100m2, 0, 500, kTilesOnly},
    Field<Ceiling>{"vents_per_100m2", &Ceiling::vents_per_100m2, 0, 500, kTilesOnly},
    Field<Ceiling>{"lamps_off_share", &Ceiling::lamps_off_share, 0, 1, kTilesOnly},
    Field<Ceiling>{"rib_every_m", &Ceiling::rib_every_m, 0, 10},
    Field<Ceiling>{"rib_depth_m", &Ceiling::rib_depth_m, 0.001, 1},
    Field<Ceiling>{"marks", &Ceiling::marks, 0, 100000},
};

inline constexpr std::array kFixtureFields{
    Field<Fixtures>{"contrast", &Fixtures::contrast, 0, 0.3},
    Field<Fixtures>{"beam_every_m", &Fixtures::beam_every_m, 0, 1000},
    Field<Fixtures>{"beam_width_m", &Fixtures::beam_width_m, 0.01, 10},
    Field<Fixtures>{"beam_depth_m", &Fixtures::beam_depth_m, 0.01, 10},
    Field<Fixtures>{"beam_brightness", &Fixtures::beam_brightness, 0, 7},
    Field<Fixtures>{"pillar_every_m", &Fixtures::pillar_every_m, 0, 1000},
    Field<Fixtures>{"pillar_width_m", &Fixtures::pillar_width_m, 0.01, 10},
    Field<Fixtures>{"lamps_per_100m2", &Fixtures::lamps_per_100m2, 0, 200},
    Field<Fixtures>{"lamp_drop_m", &Fixtures::lamp_drop_m, 0.02, 20},
    Field<Fixtures>{"lamp_brightness", &Fixtures::lamp_brightness, 0, 7},
    Field<Fixtures>{"ducts_per_100m2", &Fixtures::ducts_per_100m2, 0, 200},
    Field<Fixtures>{"sprinklers_per_100m2", &Fixtures::sprinklers_per_100m2, 0, 200},
};

inline constexpr std::array kCameraFields{
    Field<Camera>{"width_px", &Camera::width_px, 16, 8192},
    Field<Camera>{"height_px", &Camera::height_px, 16, 8192},
    Field<Camera>{"focal_px", &Camera::focal_px, 8, 100000},
    Field<Camera>{"mount_x_m", &Camera::mount_x_m, -10, 10},
    Field<Camera>{"mount_y_m", &Camera::mount_y_m, -10, 10},
    Field<Camera>{"mount_height_m", &Camera::mount_height_m, 0, 100},
    Field<Camera>{"mount_yaw_deg", &Camera::mount_yaw_deg, -360, 360},
    Field<Camera>{"mount_pitch_deg", &Camera::mount_pitch_deg, -30, 30},
    Field<Camera>{"mount_roll_deg", &Camera::mount_roll_deg, -30, 30},
    Field<Camera>{"exposure_time_s", &Camera::exposure_time_s, 0, 10},
};

/// Of the upward camera, in addition to those of all cameras.
inline constexpr std::array kUpFields{
    Field<Camera>{"readout_time_s", &Camera::readout_time_s, -0.2, 0.2},
};

/// The same of the forward camera.
inline constexpr std::array kForwardFields{
    Field<Camera>{"saturation", &Camera::saturation, 0, 1},
};

inline constexpr std::array kOmniFields{
    Field<OmniCamera>{"width_px", &OmniCamera::width_px, 16, 8192},
    Field<OmniCamera>{"height_px", &OmniCamera::height_px, 16, 8192},
    Field<OmniCamera>{"focal_px", &OmniCamera::focal_px, 8, 100000},
    Field<OmniCamera>{"mount_x_m", &OmniCamera::mount_x_m, -10, 10},
    Field<OmniCamera>{"mount_y_m", &OmniCamera::mount_y_m, -10, 10},
    Field<OmniCamera>{"mount_height_m", &OmniCamera::mount_height_m, 0, 100},
    Field<OmniCamera>{"mount_yaw_deg", &OmniCamera::mount_yaw_deg, -360, 360},
    Field<OmniCamera>{"mirror_a_m", &OmniCamera::mirror_a_m, 1e-4, 10},
    Field<OmniCamera>{"mirror_b_m", &OmniCamera::mirror_b_m, 1e-4, 10},
    Field<OmniCamera>{"rim_radius_m", &OmniCamera::rim_radius_m, 1e-4, 10},
    Field<OmniCamera>{"body_below_deg", &OmniCamera::body_below_deg, -90, 0},
    Field<OmniCamera>{"centre_in_rig", &OmniCamera::centre_in_rig},
    Field<OmniCamera>{"saturation", &OmniCamera::saturation, 0, 1},
    Field<OmniCamera>{"exposure_gain", &OmniCamera::exposure_gain, 0.001, 1000},
};

inline constexpr std::array kMoverFields{
    Field<Mover>{"x_m", &Mover::x_m, -1e4, 1e4},
    Field<Mover>{"y_m", &Mover::y_m, -1e4, 1e4},
    Field<Mover>{"length_m", &Mover::length_m, 1e-3, 1e4},
    Field<Mover>{"width_m", &Mover::width_m, 1e-3, 1e4},
    Field<Mover>{"bottom_m", &Mover::bottom_m, 0, 100},
    Field<Mover>{"top_m", &Mover::top_m, 0, 100},
    Field<Mover>{"yaw_deg", &Mover::yaw_deg, -360, 360},
    Field<Mover>{"red", &Mover::red, 0, 7},
    Field<Mover>{"green", &Mover::green, 0, 7},
    Field<Mover>{"blue", &Mover::blue, 0, 7},
    Field<Mover>{"velocity_x_m_s", &Mover::velocity_x_m_s, -100, 100},
    Field<Mover>{"velocity_y_m_s", &Mover::velocity_y_m_s, -100, 100},
    Field<Mover>{"from_s", &Mover::from_s, -1e10, 1e10},
    Field<Mover>{"to_s", &Mover::to_s, -1e10, 1e10},
};

inline constexpr unsigned kCrane = Only(StructureKind::kCrane);
inline constexpr unsigned kFan = Only(StructureKind::kFan);
inline constexpr unsigned kLongLamps = Only(StructureKind::kTube) | Only(StructureKind::kSkylight);
inline constexpr unsigned kRoundStructures =
    Only(StructureKind::kRoundDuct) | Only(StructureKind::kPipe);
inline constexpr unsigned kDetailed = kRoundStructures | Only(StructureKind::kDuct);
inline constexpr unsigned kHanging = kDetailed | Only(StructureKind::kTray);

inline constexpr std::array kStructureFields{
    Field<Structure>{"height_m", &Structure::height_m, 0, 100},
    Field<Structure>{"width_m", &Structure::width_m, 0.01, 50},
    Field<Structure>{"depth_m", &Structure::depth_m, 0.01, 20, ~kRoundStructures},
    Field<Structure>{"length_m", &Structure::length_m, 0.1, 100, kLongLamps},
    Field<Structure>{"at_m", &Structure::at_m, 0, 2000},
    Field<Structure>{"spacing_m", &Structure::spacing_m, 0, 2000},
    Field<Structure>{"runs", &Structure::runs, 0, 100000},
    Field<Structure>{"from_m", &Structure::from_m, 0, 2000},
    Field<Structure>{"to_m", &Structure::to_m, 0, 2000},
    Field<Structure>{"every_m", &Structure::every_m, 0.05, 2000},
    Field<Structure>{"hanger_every_m", &Structure::hanger_every_m, 0, 2000, kHanging},
    Field<Structure>{"jitter_m", &Structure::jitter_m, 0, 100},
    Field<Structure>{"share", &Structure::share, 0, 1},
    Field<Structure>{"details_per_10m", &Structure::details_per_10m, 0, 100, kDetailed},
    Field<Structure>{"brightness", &Structure::brightness, 0, 7},
    Field<Structure>{"contrast", &Structure::contrast, 0, 0.3},
    Field<Structure>{"turn_rate_deg_s", &Structure::turn_rate_deg_s, -3600, 3600, kFan},
    Field<Structure>{"speed_m_s", &Structure::speed_m_s, 0, 100, kCrane},
    Field<Structure>{"travel_m", &Structure::travel_m, 0, 2000, kCrane},
};

inline constexpr std::array kImageFields{
    Field<Image>{"motion_blur", &Image::motion_blur},
    Field<Image>{"blur_px", &Image::blur_px, 0, 20},
    Field<Image>{"glare", &Image::glare, 0, 1},
    Field<Image>{"vignetting", &Image::vignetting, 0, 1},
    Field<Image>{"exposure_gain", &Image::exposure_gain, 0.001, 1000},
    Field<Image>{"exposure_drift", &Image::exposure_drift, 0, 0.9},
    Field<Image>{"exposure_period_s", &Image::exposure_period_s, 0.01, 1e6},
    Field<Image>{"auto_exposure_lag_s", &Image::auto_exposure_lag_s, 0, 1000},
    Field<Image>{"flicker_hz", &Image::flicker_hz, 0, 1e5},
    Field<Image>{"flicker_depth", &Image::flicker_depth, 0, 1},
    Field<Image>{"white_balance_drift", &Image::white_balance_drift, 0, 0.9},
    Field<Image>{"shot_noise", &Image::shot_noise, 0, 1},
    Field<Image>{"read_noise", &Image::read_noise, 0, 1},
    Field<Image>{"gain_spread", &Image::gain_spread, 0, 0.3},
};

inline constexpr unsigned kPlanned = ~Only(PathKind::kTum);
inline constexpr unsigned kLawnmowerOnly = Only(PathKind::kLawnmower);

inline constexpr std::array kPathFields{
    Field<Path>{"frame_rate_hz", &Path::frame_rate_hz, 0.01, 10000},
    Field<Path>{"start_stamp_s", &Path::start_stamp_s, -1e10, 1e10, kPlanned},
    Field<Path>{"max_frames", &Path::max_frames, 0, 10000000},
    Field<Path>{"row_spacing_m", &Path::row_spacing_m, 0.01, 2000, kLawnmowerOnly},
    Field<Path>{"laps", &Path::laps, 1, 100000, Only(PathKind::kLoops)},
    Field<Path>{"length_m", &Path::length_m, 0.01, 1e6, Only(PathKind::kRandomWalk)},
    Field<Path>{"corner_radius_m", &Path::corner_radius_m, 0, 1000, kPlanned},
    Field<Path>{"speed_m_s", &Path::speed_m_s, 0.001, 100, kPlanned},
    Field<Path>{"acceleration_m_s2", &Path::acceleration_m_s2, 0.001, 100, kPlanned},
    Field<Path>{"turn_rate_deg_s", &Path::turn_rate_deg_s, 0.1, 3600, kPlanned},
    Field<Path>{"turn_acceleration_deg_s2", &Path::turn_acceleration_deg_s2, 0.1, 36000, kPlanned},
};

inline constexpr std::array kBumpFields{
    Field<Bump>{"start_m", &Bump::start_m, 0, 1e6},
    Field<Bump>{"length_m", &Bump::length_m, 0.01, 1000},
    Field<Bump>{"pitch_deg", &Bump::pitch_deg, -30, 30},
    Field<Bump>{"roll_deg", &Bump::roll_deg, -30, 30},
};

inline constexpr std::array kDebrisFields{
    Field<Debris>{"uneven_deg", &Debris::uneven_deg, 0, 10},
    Field<Debris>{"uneven_length_m", &Debris::uneven_length_m, 0.05, 1000},
};

inline constexpr std::array kCarriedFields{
    Field<Carried>{"at_s", &Carried::at_s, -1e10, 1e10},
    Field<Carried>{"x_m", &Carried::x_m, 0, 2000},
    Field<Carried>{"y_m", &Carried::y_m, 0, 2000},
    Field<Carried>{"yaw_deg", &Carried::yaw_deg, -360, 360},
};

inline constexpr std::array kPlainFields{
    Field<PlainPart>{"x_m", &PlainPart::x_m, -1e4, 1e4},
    Field<PlainPart>{"y_m", &PlainPart::y_m, -1e4, 1e4},
    Field<PlainPart>{"length_m", &PlainPart::length_m, 1e-3, 1e4},
    Field<PlainPart>{"width_m", &PlainPart::width_m, 1e-3, 1e4},
};

inline constexpr std::array kTimeSpanFields{
    Field<TimeSpan>{"from_s", &TimeSpan::from_s, -1e10, 1e10},
    Field<TimeSpan>{"to_s", &TimeSpan::to_s, -1e10, 1e10},
};

inline constexpr std::array kSlipFields{
    Field<Slip>{"at_s", &Slip::at_s, -1e10, 1e10},
    Field<Slip>{"duration_s", &Slip::duration_s, 0.001, 1e6},
    Field<Slip>{"extra_m", &Slip::extra_m, -1000, 1000},
};

/// An error of -2 reverses the sign, one of 999 gives millimetres.
inline constexpr double kMinError = -10;
inline constexpr double kMaxError = 10000;

inline constexpr std::array kWheelsFields{
    Field<Wheels>{"rate_hz", &Wheels::rate_hz, 0.1, 1000},
    Field<Wheels>{"track_width_m", &Wheels::track_width_m, 0.01, 10},
    Field<Wheels>{"scale_error_ratio", &Wheels::scale_error_ratio, kMinError, kMaxError},
    Field<Wheels>{
        "track_width_error_ratio", &Wheels::track_width_error_ratio, kMinError, kMaxError},
    Field<Wheels>{"translation_noise_per_sqrt_m", &Wheels::translation_noise_per_sqrt_m, 0, 1},
    Field<Wheels>{"yaw_noise_deg_per_sqrt_m", &Wheels::yaw_noise_deg_per_sqrt_m, 0, 180},
    Field<Wheels>{"yaw_noise_ratio", &Wheels::yaw_noise_ratio, 0, 1},
    Field<Wheels>{"encoder_step_m", &Wheels::encoder_step_m, 0, 1},
    Field<Wheels>{"clock_offset_s", &Wheels::clock_offset_s, -1e10, 1e10},
};

inline constexpr std::array kGyroFields{
    Field<Gyro>{"rate_hz", &Gyro::rate_hz, 0.1, 1000},
    Field<Gyro>{"noise_deg_s", &Gyro::noise_deg_s, 0, 1000},
    Field<Gyro>{"bias_deg_s", &Gyro::bias_deg_s, -1000, 1000},
    Field<Gyro>{"bias_walk_deg_s_per_sqrt_s", &Gyro::bias_walk_deg_s_per_sqrt_s, 0, 100},
    Field<Gyro>{"scale_error_ratio", &Gyro::scale_error_ratio, kMinError, kMaxError},
    Field<Gyro>{"clock_offset_s", &Gyro::clock_offset_s, -1e10, 1e10},
};

inline constexpr std::array kSessionsFields{
    Field<Sessions>{"changed_share_per_session", &Sessions::changed_share_per_session, 0, 0.5},
    Field<Sessions>{"panel_share", &Sessions::panel_share, 0, 1},
    Field<Sessions>{"opening_share", &Sessions::opening_share, 0, 1},
    Field<Sessions>{"lamp_share", &Sessions::lamp_share, 0, 1},
    Field<Sessions>{"banner_share", &Sessions::banner_share, 0, 1},
    Field<Sessions>{"panel_max_tiles", &Sessions::panel_max_tiles, 1, 20},
    Field<Sessions>{"panel_contrast", &Sessions::panel_contrast, 0, 0.3},
    Field<Sessions>{"lamps_switched_share", &Sessions::lamps_switched_share, 0, 1},
    Field<Sessions>{"lamps_moved_share", &Sessions::lamps_moved_share, 0, 1},
    Field<Sessions>{"banner_length_m", &Sessions::banner_length_m, 0.3, 20},
    Field<Sessions>{"banner_width_m", &Sessions::banner_width_m, 0.3, 20},
    Field<Sessions>{"banner_drop_m", &Sessions::banner_drop_m, 0, 10},
    Field<Sessions>{"path_jitter_m", &Sessions::path_jitter_m, 0, 100},
    Field<Sessions>{"exposure_spread", &Sessions::exposure_spread, 0, 1},
    Field<Sessions>{"interval_s", &Sessions::interval_s, 0, 1e6},
    Field<Sessions>{"night_every", &Sessions::night_every, 0, kMaxSession},
    Field<Sessions>{"night_lamps_on_share", &Sessions::night_lamps_on_share, 0, 1},
    Field<Sessions>{"night_gain", &Sessions::night_gain, 0.1, 1000},
    Field<Sessions>{"night_exposure_ratio", &Sessions::night_exposure_ratio, 0.1, 100},
    Field<Sessions>{"night_light_contrast", &Sessions::night_light_contrast, 0, 0.3},
    Field<Sessions>{"sun_patches", &Sessions::sun_patches, 0, 1000},
    Field<Sessions>{"sun_gain", &Sessions::sun_gain, 0, 10},
    Field<Sessions>{"people", &Sessions::people, 0, 100},
    Field<Sessions>{"masts", &Sessions::masts, 0, 100},
};

/// Names of the kinds in files, in the order of the enumerators.
inline constexpr std::array<std::string_view, 4> kCeilingKinds{
    "tiles", "periodic", "plaster", "uniform"};
inline constexpr std::array<std::string_view, 5> kPathKinds{
    "lawnmower", "loops", "waypoints", "random_walk", "tum"};
inline constexpr std::array<std::string_view, 10> kStructureKinds{
    "truss", "duct", "round_duct", "tray", "pipe", "pendant", "tube", "skylight", "fan", "crane"};
inline constexpr std::array<std::string_view, 2> kAxes{"x", "y"};
inline constexpr std::array<std::string_view, 2> kWheelsKinds{"pose", "speeds"};

/// Columns of the lists, for messages.
inline constexpr std::string_view kMarkColumns = "x_m, y_m, radius_m, brightness";
inline constexpr std::string_view kBoxColumns =
    "x_m, y_m, length_m, width_m, bottom_m, top_m, yaw_deg, brightness";
inline constexpr std::string_view kStepColumns = "frame, gain";
inline constexpr std::string_view kPointColumns = "x, y";
inline constexpr std::string_view kBumpColumns = "start_m, length_m, pitch_deg, roll_deg";
inline constexpr std::string_view kCarriedColumns = "at_s, x_m, y_m, yaw_deg";
inline constexpr std::string_view kPlainColumns = "x_m, y_m, length_m, width_m";
inline constexpr std::string_view kTimeSpanColumns = "from_s, to_s";
inline constexpr std::string_view kSlipColumns = "at_s, duration_s, extra_m";
inline constexpr std::string_view kMoverColumns =
    "x_m, y_m, length_m, width_m, bottom_m, top_m, yaw_deg, red, green, blue, velocity_x_m_s, "
    "velocity_y_m_s, from_s, to_s";

inline constexpr std::string_view kSessionMoverColumns =
    "session, x_m, y_m, length_m, width_m, bottom_m, top_m, yaw_deg, red, green, blue, "
    "velocity_x_m_s, velocity_y_m_s, from_s, to_s";

/// `in [LEAST, MOST]`.
std::string RangeText(double least, double most);

}  // namespace ceilmap::simulator
