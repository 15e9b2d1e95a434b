#include "samples/simulator/scene.hpp"

#include <gmock/gmock.h>

#include <filesystem>
#include <string>
#include <vector>

#include "calib/base/error.hpp"

namespace ceilmap::simulator {
namespace {

namespace fs = std::filesystem;

using ::testing::HasSubstr;

std::string ErrorOf(const std::string& text) {
  try {
    (void)ParseScene(text, "s.yaml");
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Scene, DefaultsAreValid) {
  EXPECT_NO_THROW(Scene().Validate());
  const Scene scene = ParseScene("seed: 5", "s.yaml");
  EXPECT_EQ(scene.seed, 5U);
  EXPECT_EQ(scene.ceiling.tile_length_m, Scene().ceiling.tile_length_m);
}

TEST(Scene, ReadsEveryGroup) {
  const Scene scene = ParseScene(R"(seed: 7
robot: "r"
axle_behind_mast_m: 0.2
room: {length_m: 20, width_m: 10, height_m: 3}
ceiling:
  kind: periodic
  tile_length_m: 0.5
  lamp_every_x: 4
  lamp_every_y: 3
  marks_at: [1, 2, 0.1, 0.2,
             3, 4, 0.3, 0.4]
fixtures:
  beam_every_m: 2.5
  boxes: [5, 6, 1, 0.2, 2.5, 2.8, 30, 0.7]
camera: {width_px: 800, focal_px: 500, distortion: [0.1, 0, 0, 0, 0]}
picture: {motion_blur: false, exposure_steps: [10, 1.5]}
path:
  kind: waypoints
  waypoints_m: [1, 1, 5, 1]
  max_frames: 9
forward: {focal_px: 300, mount_pitch_deg: 14}
debris:
  bumps: [0.5, 0.4, 2.4, 0,
          1.5, 0.6, -1, 2]
)",
                                 "s.yaml");
  EXPECT_EQ(scene.robot, "r");
  EXPECT_EQ(scene.axle_behind_mast_m, 0.2);
  EXPECT_EQ(scene.room.height_m, 3);
  EXPECT_EQ(scene.ceiling.kind, CeilingKind::kPeriodic);
  EXPECT_EQ(scene.ceiling.lamp_every_y, 3);
  ASSERT_EQ(scene.ceiling.marks_at.size(), 2U);
  EXPECT_EQ(scene.ceiling.marks_at[1].radius_m, 0.3);
  ASSERT_EQ(scene.fixtures.boxes.size(), 1U);
  EXPECT_EQ(scene.fixtures.boxes[0].top_m, 2.8);
  EXPECT_EQ(scene.fixtures.boxes[0].yaw_deg, 30);
  EXPECT_EQ(scene.camera.width_px, 800);
  EXPECT_EQ(scene.camera.distortion[0], 0.1);
  EXPECT_FALSE(scene.image.motion_blur);
  ASSERT_EQ(scene.image.exposure_steps.size(), 1U);
  EXPECT_EQ(scene.image.exposure_steps[0].frame, 10);
  EXPECT_EQ(scene.path.kind, PathKind::kWaypoints);
  EXPECT_EQ(scene.path.waypoints_m[1][0], 5);
  EXPECT_EQ(scene.path.max_frames, 9);
  ASSERT_TRUE(scene.forward.has_value());
  EXPECT_EQ(scene.forward->focal_px, 300);
  EXPECT_EQ(scene.forward->mount_pitch_deg, 14);
  EXPECT_EQ(scene.forward->mount_height_m, 0.45);  // a forward camera's own default
  ASSERT_EQ(scene.debris.bumps.size(), 2U);
  EXPECT_EQ(scene.debris.bumps[0].length_m, 0.4);
  EXPECT_EQ(scene.debris.bumps[1].pitch_deg, -1);
  EXPECT_EQ(scene.debris.bumps[1].roll_deg, 2);
}

TEST(Scene, ForwardCameraIsThereWhenItsGroupIs) {
  EXPECT_FALSE(ParseScene("seed: 5", "s.yaml").forward.has_value());
  const Scene scene = ParseScene("forward: {}", "s.yaml");
  ASSERT_TRUE(scene.forward.has_value());
  EXPECT_EQ(scene.forward->focal_px, 554);
  EXPECT_EQ(scene.forward->exposure_time_s, 0.008);
}

TEST(Scene, OmniCameraIsThereWhenItsGroupIs) {
  EXPECT_FALSE(ParseScene("seed: 5", "s.yaml").omni.has_value());
  const Scene scene = ParseScene(
      "omni: {focal_px: 500, centre_offset_px: [5, -1], centre_in_rig: false, "
      "exposure_steps: [3, 2]}",
      "s.yaml");
  ASSERT_TRUE(scene.omni.has_value());
  EXPECT_EQ(scene.omni->focal_px, 500);
  EXPECT_EQ(scene.omni->width_px, 480);
  EXPECT_EQ(scene.omni->centre_offset_px[1], -1);
  EXPECT_FALSE(scene.omni->centre_in_rig);
  ASSERT_EQ(scene.omni->exposure_steps.size(), 1U);
  EXPECT_EQ(scene.omni->exposure_steps[0].gain, 2);
}

TEST(Scene, ReadsMoversInTheOrderOfTheirColumns) {
  const Scene scene = ParseScene(
      "movers: [1, 2, 0.3, 0.4, 0.1, 1.5, 30, 0.9, 0.8, 0.7, 1.1, -1.2, 4, 6]", "s.yaml");
  ASSERT_EQ(scene.movers.size(), 1U);
  const Mover& mover = scene.movers[0];
  EXPECT_EQ(mover.y_m, 2);
  EXPECT_EQ(mover.width_m, 0.4);
  EXPECT_EQ(mover.top_m, 1.5);
  EXPECT_EQ(mover.yaw_deg, 30);
  EXPECT_EQ(mover.blue, 0.7);
  EXPECT_EQ(mover.velocity_y_m_s, -1.2);
  EXPECT_EQ(mover.from_s, 4);
  EXPECT_EQ(mover.to_s, 6);
}

TEST(Scene, FaultsOfOmniCameraAndMoversAreSaid) {
  EXPECT_THAT(ErrorOf("omni: {fokal_px: 3}"), HasSubstr("omni.fokal_px = 3 is an unknown key"));
  EXPECT_THAT(ErrorOf("omni:\n  saturation: 2"),
              HasSubstr("s.yaml:2: omni.saturation = 2, must be in [0, 1]"));
  EXPECT_THAT(ErrorOf("omni: {mount_height_m: 2.55}"),
              HasSubstr("omni.mount_height_m = 2.55, must be so low that the mirror's rim"));
  EXPECT_THAT(ErrorOf("movers: [1, 2, 3]"), HasSubstr("must be rows of 14 numbers (x_m, y_m"));
  EXPECT_THAT(ErrorOf("seed: 1\nmovers: [1, 2, 0.3, 0.4, 0, 1, 0, 9, 0, 0, 1, 0, 4, 6]"),
              HasSubstr("s.yaml:2: movers = [1, 2, 0.3"));
  EXPECT_THAT(ErrorOf("movers: [1, 2, 0.3, 0.4, 1, 1, 0, 1, 0, 0, 1, 0, 4, 6]"),
              HasSubstr("s.yaml: movers[0].top_m = 1, must be above bottom_m"));
  EXPECT_THAT(ErrorOf("movers: [1, 2, 0.3, 0.4, 0, 1, 0, 1, 0, 0, 1, 0, 4, 3]"),
              HasSubstr("movers[0].to_s = 3, must be not before from_s"));
  EXPECT_THAT(ErrorOf("ceiling: {kind: periodic, symmetric: true, tile_width_m: 0.5}"),
              HasSubstr("ceiling.tile_width_m = 0.5, must be tile_length_m"));
  EXPECT_THAT(ErrorOf("ceiling: {symmetric: true}"), HasSubstr("absent for kind tiles"));
}

TEST(Scene, WheelsAndGyroAreThereWhenTheirGroupsAre) {
  EXPECT_FALSE(ParseScene("seed: 5", "s.yaml").wheels.has_value());
  EXPECT_FALSE(ParseScene("seed: 5", "s.yaml").gyro.has_value());
  const Scene plain = ParseScene("wheels: {}\ngyro: {}", "s.yaml");
  ASSERT_TRUE(plain.wheels.has_value());
  ASSERT_TRUE(plain.gyro.has_value());
  EXPECT_EQ(plain.wheels->kind, WheelsKind::kPose);
  EXPECT_EQ(plain.wheels->translation_noise_per_sqrt_m, 0.01);
  EXPECT_EQ(plain.gyro->rate_hz, 100);
  const Scene scene = ParseScene(R"(wheels:
  kind: speeds
  track_width_m: 0.3
  slips: [10, 0.5, 0.4,  20, 1, -0.1]
  gaps: [3, 4]
gyro: {bias_deg_s: -0.5, bias_walk_deg_s_per_sqrt_s: 0.01}
)",
                                 "s.yaml");
  EXPECT_EQ(scene.wheels->kind, WheelsKind::kSpeeds);
  EXPECT_EQ(scene.wheels->track_width_m, 0.3);
  ASSERT_EQ(scene.wheels->slips.size(), 2U);
  EXPECT_EQ(scene.wheels->slips[1].at_s, 20);
  EXPECT_EQ(scene.wheels->slips[1].extra_m, -0.1);
  ASSERT_EQ(scene.wheels->gaps.size(), 1U);
  EXPECT_EQ(scene.wheels->gaps[0].to_s, 4);
  EXPECT_EQ(scene.gyro->bias_deg_s, -0.5);
  EXPECT_EQ(scene.gyro->bias_walk_deg_s_per_sqrt_s, 0.01);
}

TEST(Scene, ReadsDarkTimesPlainPartsAndWhereTheRobotIsCarried) {
  const Scene scene = ParseScene(
      "ceiling: {plain: [5, 4, 4, 2]}\npicture: {dark: [3, 4, 6, 9]}\n"
      "path: {carried: [7, 2, 3, 90]}",
      "s.yaml");
  ASSERT_EQ(scene.ceiling.plain.size(), 1U);
  EXPECT_EQ(scene.ceiling.plain[0].y_m, 4);
  EXPECT_EQ(scene.ceiling.plain[0].width_m, 2);
  ASSERT_EQ(scene.image.dark.size(), 2U);
  EXPECT_EQ(scene.image.dark[1].from_s, 6);
  ASSERT_EQ(scene.path.carried.size(), 1U);
  EXPECT_EQ(scene.path.carried[0].at_s, 7);
  EXPECT_EQ(scene.path.carried[0].yaw_deg, 90);
}

TEST(Scene, FaultsOfWheelsAndGyroAreSaid) {
  EXPECT_EQ(ErrorOf("wheels:\n  kind: pulses"),
            "s.yaml:2: wheels.kind = pulses, must be one of pose, speeds; correct it");
  EXPECT_EQ(ErrorOf("gyro: {rate_hz: 0}"),
            "s.yaml:1: gyro.rate_hz = 0, must be in [0.1, 1000]; correct the value");
  EXPECT_EQ(ErrorOf("wheels: {slips: [1, 0, 0.4]}"),
            "s.yaml:1: wheels.slips = [1, 0, 0.4], must be rows with duration_s in [0.001, 1e+06]; "
            "correct 0");
  EXPECT_EQ(ErrorOf("wheels: {gaps: [4, 3]}"),
            "s.yaml: wheels.gaps[0].to_s = 3, must be not before from_s");
  EXPECT_EQ(ErrorOf("picture: {dark: [4, 3]}"),
            "s.yaml: picture.dark[0].to_s = 3, must be not before from_s");
  EXPECT_EQ(ErrorOf("path: {carried: [4, 3, 3, 0, 4, 5, 5, 0]}"),
            "s.yaml: path.carried[1].at_s = 4, must be later than the row before");
  EXPECT_THAT(ErrorOf("wheels: {noise: 1}"), HasSubstr("wheels.noise = 1 is an unknown key"));
  EXPECT_THAT(ErrorOf("ceiling: {plain: [1, 2, 0, 1]}"), HasSubstr("rows with length_m in"));
}

TEST(Scene, ReadsStructuresWithTheDefaultsOfTheirKind) {
  const Scene scene = ParseScene(R"(structures:
  supply: {kind: duct, along: y, height_m: 2, at_m: 3, spacing_m: 4, runs: 2}
  fan: {kind: fan, height_m: 2.1, turn_rate_deg_s: -90}
)",
                                 "s.yaml");
  ASSERT_EQ(scene.structures.size(), 2U);
  const Structure& duct = scene.structures[0];
  EXPECT_EQ(duct.name, "supply");
  EXPECT_EQ(duct.kind, StructureKind::kDuct);
  EXPECT_EQ(duct.along, Axis::kY);
  EXPECT_EQ(duct.runs, 2);
  EXPECT_EQ(duct.width_m, 0.6);  // a duct's own default
  EXPECT_EQ(scene.structures[1].along, Axis::kX);
  EXPECT_EQ(scene.structures[1].turn_rate_deg_s, -90);
}

TEST(Scene, FaultsOfStructuresAreSaidWithTheirLine) {
  EXPECT_EQ(ErrorOf("structures:\n  a: {kind: wire}"),
            "s.yaml:2: structures.a.kind = wire, must be one of truss, duct, round_duct, tray, "
            "pipe, pendant, tube, skylight, fan, crane; correct it");
  EXPECT_THAT(ErrorOf("structures:\n  a: {height_m: 2}"), HasSubstr("s.yaml:2: structures.a.kind"));
  EXPECT_EQ(ErrorOf("structures:\n  a: {kind: pipe, depth_m: 0.1}"),
            "s.yaml:2: structures.a.depth_m = 0.1, must be absent for kind pipe; remove it, it "
            "would have no effect");
  EXPECT_EQ(ErrorOf("structures:\n  a: {kind: pipe, along: z}"),
            "s.yaml:2: structures.a.along = z, must be one of x, y; correct it");
  EXPECT_EQ(ErrorOf("structures:\n  a: {kind: duct, height_m: 2.5}"),
            "s.yaml: structures.a.height_m = 2.5, must be so low that its top, 0.35 m higher, is "
            "not above the ceiling (room.height_m)");
  EXPECT_EQ(ErrorOf("structures:\n  a: {kind: pipe, from_m: 3, to_m: 2}"),
            "s.yaml: structures.a.from_m = 3, must be less than the end of the runs, 2 (to_m, or "
            "the room's end)");
  EXPECT_EQ(ErrorOf("structures:\n  'a,b': {kind: pipe}"),
            "s.yaml: structures.a,b has a wrong name, must consist of letters, digits, '-' and "
            "'_'");
  EXPECT_THAT(ErrorOf("room: {length_m: 2000, width_m: 2000}\nstructures:\n"
                      "  a: {kind: tray, spacing_m: 1, every_m: 0.05}"),
              HasSubstr("structures.a.every_m = 0.05, must be greater"));
}

TEST(Scene, PathOfATumFileStartsAtTheScene) {
  const Scene scene = ParseScene("path: {kind: tum, tum_file: drive.tum}", "some/where/s.yaml");
  EXPECT_EQ(scene.path.tum_file, std::filesystem::path("some/where/drive.tum"));
}

TEST(Scene, SamplesAreValid) {
  const fs::path scenes = fs::path(CEILMAP_SOURCE_DIR) / "samples" / "scenes";
  for (const char* name :
       {"hall",           "warehouse",      "periodic",    "lights-off",    "corridor",
        "lens",           "debris",         "omni-dark",   "omni-rooms",    "passing-car",
        "periodic-turns", "dark-turn",      "colour-room", "colour-boards", "plant",
        "plant-debris",   "beams-corridor", "fans",        "living-room",   "wheels"}) {
    const fs::path file = scenes / (std::string(name) + ".yaml");
    EXPECT_NO_THROW((void)ReadScene(file)) << file;
  }
}

TEST(Scene, FaultsAreSaidWithTheirLine) {
  EXPECT_THAT(ErrorOf("seed: 1\nroom: {lenght_m: 3}"),
              HasSubstr("s.yaml:2: room.lenght_m = 3 is an unknown key, must be one of length_m"));
  EXPECT_EQ(ErrorOf("room:\n  height_m: tall"),
            "s.yaml:2: room.height_m = tall, must be a finite number; write it plainly, e.g. 0.45, "
            "without quotes or unit");
  EXPECT_EQ(ErrorOf("room:\n  height_m: 0.1"),
            "s.yaml:2: room.height_m = 0.1, must be in [0.5, 100]; correct the value");
  EXPECT_EQ(ErrorOf("camera: {width_px: 10.5}"),
            "s.yaml:1: camera.width_px = 10.5, must be a whole number in 16..8192; correct the "
            "value");
  EXPECT_EQ(ErrorOf("picture: {motion_blur: maybe}"),
            "s.yaml:1: picture.motion_blur = maybe, must be true or false; correct it");
  EXPECT_EQ(ErrorOf("ceiling:\n  kind: wood"),
            "s.yaml:2: ceiling.kind = wood, must be one of tiles, periodic, plaster, uniform; "
            "correct it");
  EXPECT_THAT(ErrorOf("seed: -1"), HasSubstr("s.yaml:1: seed = -1, must be a whole number"));
  EXPECT_THAT(ErrorOf("room: 5"), HasSubstr("s.yaml:1: room = 5, must be a map of keys"));
}

TEST(Scene, KeysOfAnotherKindAreRefused) {
  EXPECT_EQ(ErrorOf("ceiling:\n  kind: periodic\n  tile_contrast: 0.1"),
            "s.yaml:3: ceiling.tile_contrast = 0.1, must be absent for kind periodic; remove it, "
            "it would have no effect");
  EXPECT_EQ(ErrorOf("path: {laps: 3}"),
            "s.yaml:1: path.laps = 3, must be absent for kind lawnmower; remove it, it would have "
            "no effect");
  EXPECT_THAT(ErrorOf("path: {kind: tum, tum_file: a, area_m: [1, 1, 2, 2]}"),
              HasSubstr("path.area_m = [1, 1, 2, 2], must be absent for kind tum"));
  EXPECT_THAT(ErrorOf("path: {waypoints_m: [1, 1, 2, 2]}"), HasSubstr("must be absent for kind"));
}

TEST(Scene, FaultsOfDebrisAreSaidWithTheirLine) {
  EXPECT_EQ(ErrorOf("seed: 1\ndebris:\n  bumps: [1, 0, 2, 0]"),
            "s.yaml:3: debris.bumps = [1, 0, 2, 0], must be rows with length_m in [0.01, 1000]; "
            "correct 0");
  EXPECT_EQ(ErrorOf("debris: {bumps: [1, 1, 40, 0]}"),
            "s.yaml:1: debris.bumps = [1, 1, 40, 0], must be rows with pitch_deg in [-30, 30]; "
            "correct 40");
  EXPECT_EQ(ErrorOf("debris: {bumps: [1, 1, 2]}"),
            "s.yaml:1: debris.bumps = [1, 1, 2], must be rows of 4 numbers (start_m, length_m, "
            "pitch_deg, roll_deg), not 3 numbers; complete the last row");
  EXPECT_EQ(ErrorOf("path: {kind: tum, tum_file: a}\ndebris: {bumps: [1, 1, 2, 0]}"),
            "s.yaml:2: debris = {...}, must be absent for path.kind tum; remove it, "
            "the poses of the file hold the tilt");
  EXPECT_THAT(ErrorOf("debris: {bump: [1, 1, 2, 0]}"), HasSubstr("is an unknown key"));
}

TEST(Scene, FaultsOfTheForwardCameraAreSaidWithTheirLine) {
  EXPECT_EQ(ErrorOf("seed: 1\nforward: {focal_px: 1}"),
            "s.yaml:2: forward.focal_px = 1, must be in [8, 100000]; correct the value");
  EXPECT_THAT(ErrorOf("forward: {height: 1}"),
              HasSubstr("s.yaml:1: forward.height = 1 is an unknown key"));
  EXPECT_EQ(ErrorOf("forward: {mount_height_m: 2.6}"),
            "s.yaml: forward.mount_height_m = 2.6, must be below the ceiling (room.height_m)");
  EXPECT_EQ(ErrorOf("forward: {mount_height_m: 0}"),
            "s.yaml: forward.mount_height_m = 0, must be above the floor");
}

TEST(Scene, ListsComeInWholeRows) {
  EXPECT_EQ(ErrorOf("fixtures:\n  boxes: [1, 2, 3]"),
            "s.yaml:2: fixtures.boxes = [1, 2, 3], must be rows of 8 numbers (x_m, y_m, length_m, "
            "width_m, bottom_m, top_m, yaw_deg, brightness), not 3 numbers; complete the last row");
  EXPECT_THAT(ErrorOf("picture: {exposure_steps: [1.5, 2]}"), HasSubstr("whole frame numbers"));
}

TEST(Scene, PartsThatDoNotFitAreRefused) {
  EXPECT_EQ(ErrorOf("camera: {mount_height_m: 3}"),
            "s.yaml: camera.mount_height_m = 3, must be below the ceiling (room.height_m)");
  EXPECT_EQ(ErrorOf("room: {length_m: 5}"),
            "s.yaml: path.area_m = [1.5, 1.5, 10.5, 6.5], must be x_min, y_min, x_max, y_max "
            "inside of the room of 5 x 8 m");
  EXPECT_EQ(ErrorOf("fixtures: {boxes: [5, 5, 1, 1, 2.5, 2.4, 0, 1]}"),
            "s.yaml: fixtures.boxes[0].top_m = 2.4, must be above bottom_m and not above the "
            "ceiling");
  EXPECT_EQ(ErrorOf("path: {kind: waypoints, waypoints_m: [1, 1]}"),
            "s.yaml: path.waypoints_m is too short, must be at least two points");
  EXPECT_EQ(ErrorOf("path: {kind: waypoints, waypoints_m: [1, 1, 20, 1]}"),
            "s.yaml: path.waypoints_m[1].x = 20, must be in [0, 12]");
  EXPECT_EQ(ErrorOf("path: {kind: tum}"),
            "s.yaml: path.tum_file is missing, must be given for kind tum");
  EXPECT_EQ(ErrorOf("ceiling: {joint_m: 0.7}"),
            "s.yaml: ceiling.joint_m = 0.7, must be narrower than a tile");
  EXPECT_EQ(ErrorOf("ceiling: {marks_at: [13, 2, 0.1, 0.2]}"),
            "s.yaml: ceiling.marks_at[0].x_m = 13, must be in [0, 12]");
  EXPECT_EQ(ErrorOf("picture: {exposure_steps: [5, 1, 5, 2]}"),
            "s.yaml: picture.exposure_steps[1].frame = 5, must be later than the step before");
}

TEST(Scene, ValidateNamesTheField) {
  Scene scene;
  scene.path.speed_m_s = -1;
  try {
    scene.Validate();
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "path.speed_m_s = -1, must be in [0.001, 100]");
  }
  scene.path.speed_m_s = 1;
  scene.debris.bumps = {{1, 1, 2, 0}, {1, 1, 2, 31}};
  try {
    scene.Validate();
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "debris.bumps[1].roll_deg = 31, must be in [-30, 30]");
  }
}

}  // namespace
}  // namespace ceilmap::simulator
