// Images of a camera under a mirror: objects at their positions in the mirror, in colour, and
// movers.

#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <opencv2/imgproc.hpp>

#include "calib/base/degrees.hpp"
#include "calib/base/error.hpp"
#include "samples/simulator/mirror_rays.hpp"
#include "samples/simulator/paints.hpp"
#include "tests/samples/simulator/scenes.hpp"

namespace ceilmap::simulator {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kFocal = 520;
constexpr double kA = 0.028095;
constexpr double kB = 0.0234125;
const double kC = std::hypot(kA, kB);
constexpr double kCentre = 239.5;

/// Radius in the image of a direction `elevation` above the horizon: the ray from the viewpoint
/// meets the mirror at distance t, the root on its upper sheet, and the pinhole's image of that
/// point.
double Rho(double elevation) {
  const double c = std::cos(elevation);
  const double s = std::sin(elevation);
  const double p = s * s / (kA * kA) - c * c / (kB * kB);
  const double q = 2 * kC * s / (kA * kA);
  const double r = kC * kC / (kA * kA) - 1;
  for (const double sign : {-1.0, 1.0}) {
    const double t = (-q + sign * std::sqrt(q * q - 4 * p * r)) / (2 * p);
    if (t > 0 && kC + t * s > 0) return kFocal * t * c / (2 * kC + t * s);
  }
  return -1;
}

/// Where a direction shows: azimuth 0 in front, positive to the robot's left.
Vector2d OmniPixel(double azimuth, double elevation) {
  const double rho = Rho(elevation);
  return {kCentre + rho * std::sin(azimuth), kCentre - rho * std::cos(azimuth)};
}

Vector2d OmniPixel(const Isometry3d& T_map_base, const Vector3d& p_map) {
  const Vector3d p = T_map_base.inverse() * p_map - Vector3d(0, 0, 0.55 + 2 * kC);
  return OmniPixel(std::atan2(p.y(), p.x()), std::atan2(p.z(), std::hypot(p.x(), p.y())));
}

/// Nothing but black, grey things, and the mirror.
Scene DarkOmniScene() {
  Scene scene = DarkScene();
  scene.omni = OmniCamera{};
  scene.omni->saturation = 0;
  return scene;
}

/// Centre of what is brighter than the robot.
Vector2d CentreOfLight(const cv::Mat& light) {
  cv::Mat grey;
  cv::cvtColor(light, grey, cv::COLOR_BGR2GRAY);
  grey.setTo(0, grey < 0.01F);
  cv::circle(grey, {240, 240}, 46, 0, -1);
  return CentreOfMark(grey, 0);
}

cv::Mat LightAt(const Renderer& renderer, const Pose2& T_map_base, double stamp_s = 100) {
  return renderer.RenderOmniLight(StillFrame(0, T_map_base, stamp_s));
}

/// A small cube at a place; its centre of light is that of its visible sides within 0.1 px.
Box SmallBox(const Vector3d& at) {
  constexpr double kHalf = 0.01;
  return {at.x(), at.y(), 2 * kHalf, 2 * kHalf, at.z() - kHalf, at.z() + kHalf, 0, 2.0};
}

TEST(MirrorRays, ARayAndThePixelOfItsDirectionAreInverse) {
  const MirrorRays rays(OmniCamera{});
  for (int i = 0; i < 97; ++i) {
    const double elevation = -1.5 + 0.02 * i;
    for (int k = 0; k < 17; ++k) {
      const double azimuth = -3 + 0.37 * k;
      const Vector2d pixel = OmniPixel(azimuth, elevation);
      const auto d_cam = rays.Direction(pixel.x(), pixel.y());
      ASSERT_TRUE(d_cam.has_value()) << elevation;
      const Vector3d d = rays.R_base_cam() * *d_cam;
      EXPECT_NEAR(std::asin(d.z()), elevation, 1e-9);
      EXPECT_NEAR(std::atan2(d.y(), d.x()), azimuth, 1e-9);
    }
  }
  EXPECT_FALSE(rays.Direction(kCentre + 226, kCentre).has_value());
}

// The radii that lab-omni-circle's rig states for this mirror.
TEST(MirrorRays, RimAndHorizonAreWhereTheLabRigHasThem) {
  const MirrorRays rays(OmniCamera{});
  EXPECT_NEAR(rays.RimRadiusPx(), 225.623, 5e-4);
  EXPECT_NEAR(rays.HorizonRadiusPx(), 138.707, 5e-4);
  EXPECT_NEAR(rays.HorizonRadiusPx(), Rho(1e-9), 1e-4);
  EXPECT_NEAR(rays.RimRadiusPx(), Rho(rays.RimElevation()), 1e-6);
  EXPECT_NEAR(rays.ViewpointInBase().z(), 0.623142988, 1e-8);
}

TEST(OmniCamera, ThingsShowWhereTheMirrorPutsThem) {
  for (const Vector3d& at :
       {Vector3d(7.2, 4.3, 0.62), Vector3d(5.1, 5.4, 1.1), Vector3d(6.6, 3.1, 0.2)}) {
    Scene scene = DarkOmniScene();
    scene.fixtures.boxes = {SmallBox(at)};
    const Renderer renderer(scene);
    for (const double yaw : {0.0, 1.1, -2.5}) {
      const Pose2 T_map_base{6, 4, yaw};
      const Vector2d seen = CentreOfLight(LightAt(renderer, T_map_base));
      const Vector2d expected = OmniPixel(Level(6, 4, yaw / kRadPerDeg), at);
      EXPECT_LT((seen - expected).norm(), 0.25) << at.transpose() << " yaw " << yaw;
    }
  }
}

TEST(OmniCamera, FollowsTheRobotsTilt) {
  Scene scene = DarkOmniScene();
  scene.fixtures.boxes = {SmallBox({7.5, 4.4, 0.9})};
  const Renderer renderer(scene);
  Frame frame = StillFrame(0, {6, 4, 0.2});
  frame.T_map_base.rotate(Eigen::AngleAxisd(-5 * kRadPerDeg, Vector3d::UnitY()));
  frame.T_map_base.rotate(Eigen::AngleAxisd(3 * kRadPerDeg, Vector3d::UnitX()));
  const Vector2d seen = CentreOfLight(renderer.RenderOmniLight(frame));
  EXPECT_LT((seen - OmniPixel(frame.T_map_base, {7.5, 4.4, 0.9})).norm(), 0.25);
}

// The edge of a wall-high pillar, row by row below the mirror's axis: exact to a twelfth of a
// pixel.
TEST(OmniCamera, EdgesLieWhereTheyAre) {
  Scene scene = DarkOmniScene();
  scene.fixtures.boxes = {{8, 4, 1, 0.8, 0, 2.4, 0, 1.0}};  // its front is at x = 7.5
  const Renderer renderer(scene);
  for (int i = 0; i < 10; ++i) {
    const double offset_m = 0.0137 * i;
    const cv::Mat light = LightAt(renderer, {5.5, 4 + offset_m, 0});
    // Row v shows the face where rho cos(phi) = 239.5 - v; on its left edge tan(phi) = y / 2.
    const int v = 100;
    const double right_px = (kCentre - v) * (0.4 - offset_m) / 2;
    double covered_px = 0;  // right of the axis
    for (int u = 240; u < 320; ++u) covered_px += light.at<cv::Vec3f>(v, u)[1] / 0.6;
    EXPECT_NEAR(covered_px, right_px, 0.08);
  }
}

// Unwrapped with azimuth falling from left to right, a left turn moves the panorama to the right.
TEST(OmniCamera, ALeftTurnMovesThePanoramaToTheRight) {
  Scene scene = DarkOmniScene();
  scene.room.wall_brightness = 0.4;
  scene.room.wall_posters_per_100m2 = 60;
  const Renderer renderer(scene);
  const auto panorama = [&](double yaw) {
    const cv::Mat light = LightAt(renderer, {6, 4, yaw});
    cv::Mat row(1, 720, CV_32FC1);
    for (int i = 0; i < 720; ++i) {
      const Vector2d at = OmniPixel(M_PI - i * M_PI / 360, 0.1);
      row.at<float>(0, i) = light.at<cv::Vec3f>(static_cast<int>(std::lround(at.y())),
                                                static_cast<int>(std::lround(at.x())))[1];
    }
    return row;
  };
  const cv::Mat before = panorama(0);
  const cv::Mat after = panorama(20 * kRadPerDeg);
  int best = 0;
  double least = 1e9;
  for (int shift = 0; shift < 720; ++shift) {
    double sum = 0;
    for (int i = 0; i < 720; ++i) {
      sum += std::abs(after.at<float>(0, (i + shift) % 720) - before.at<float>(0, i));
    }
    if (sum < least) {
      least = sum;
      best = shift;
    }
  }
  EXPECT_NEAR(best, 40, 1);
}

TEST(OmniCamera, ShowsTheRobotInTheMiddleAndDarkAround) {
  Scene scene = DarkOmniScene();
  scene.room.wall_brightness = 0.5;
  scene.room.floor_brightness = 0.5;
  const cv::Mat light = LightAt(Renderer(scene), {6, 4, 0});
  EXPECT_LT(light.at<cv::Vec3f>(240, 240)[1], 0.02);               // the camera
  EXPECT_NEAR(light.at<cv::Vec3f>(240, 240 + 30)[1], 0.14, 1e-3);  // the robot
  EXPECT_NEAR(light.at<cv::Vec3f>(240, 240 + 45)[1], 0.5, 1e-3);   // the floor
  EXPECT_NEAR(light.at<cv::Vec3f>(240 - 150, 240)[1], 0.5, 1e-3);  // the wall in front
  EXPECT_LT(light.at<cv::Vec3f>(240, 240 + 228)[1], 0.01);         // beside the mirror
  EXPECT_LT(light.at<cv::Vec3f>(0, 0)[1], 0.01);
}

TEST(OmniCamera, ColoursFollowTheSeedAndLeaveTheLightAlone) {
  Scene scene = DarkOmniScene();
  scene.room.wall_brightness = 0.4;
  scene.room.wall_posters_per_100m2 = 60;
  scene.room.floor_brightness = 0.3;
  scene.fixtures.boxes = {{8, 4, 1, 0.8, 0, 1.2, 0, 0.6}};
  const cv::Mat grey = LightAt(Renderer(scene), {6, 4, 0});
  scene.omni->saturation = 1;
  const cv::Mat coloured = LightAt(Renderer(scene), {6, 4, 0});
  double max_colour = 0;
  for (int v = 0; v < 480; v += 3) {
    for (int u = 0; u < 480; u += 3) {
      const auto& g = grey.at<cv::Vec3f>(v, u);
      const auto& c = coloured.at<cv::Vec3f>(v, u);
      EXPECT_NEAR(Luminance(c[2], c[1], c[0]), Luminance(g[2], g[1], g[0]), 1e-4);
      EXPECT_TRUE(c[0] >= 0 && c[1] >= 0 && c[2] >= 0);
      max_colour = std::max<double>(max_colour, std::abs(c[0] - c[2]));
    }
  }
  EXPECT_GT(max_colour, 0.2);
}

TEST(OmniCamera, MirrorOffCentreMovesTheImageAndOptionallyTheRig) {
  Scene scene = DarkOmniScene();
  scene.fixtures.boxes = {SmallBox({7.2, 4.3, 0.62})};
  const Vector2d centred = CentreOfLight(LightAt(Renderer(scene), {6, 4, 0}));
  scene.omni->centre_offset_px = {5, -2};
  const Renderer known(scene);
  const Vector2d moved = CentreOfLight(LightAt(known, {6, 4, 0}));
  EXPECT_LT((moved - centred - Vector2d(5, -2)).norm(), 0.1);
  EXPECT_EQ(known.GetRig().omni->camera.cx, kCentre + 5);
  EXPECT_EQ(known.GetRig().omni->camera.cy, kCentre - 2);
  scene.omni->centre_in_rig = false;
  const Renderer unknown(scene);
  EXPECT_EQ(unknown.GetRig().omni->camera.cx, kCentre);
  EXPECT_EQ(unknown.GetRig().omni->camera.cy, kCentre);
  EXPECT_EQ(cv::norm(LightAt(unknown, {6, 4, 0}), LightAt(known, {6, 4, 0}), cv::NORM_INF), 0);
}

TEST(OmniCamera, RigReadsBackAsTheMirror) {
  Scene scene;
  scene.omni = OmniCamera{};
  scene.omni->mount_x_m = 0.05;
  scene.omni->mount_yaw_deg = 30;
  const calib::Rig rig = calib::ParseRig(RigYaml(scene), "rig.yaml");
  ASSERT_TRUE(rig.omni.has_value());
  const calib::MountedCamera& omni = *rig.omni;
  EXPECT_EQ(omni.camera.Size(), cv::Size(480, 480));
  EXPECT_EQ(omni.camera.fx, kFocal);
  EXPECT_EQ(omni.camera.cx, kCentre);
  EXPECT_FALSE(omni.camera.IsDistorted());
  EXPECT_EQ(omni.T_base_cam.translation(), Vector3d(0.05, 0, 0.55));
  EXPECT_NEAR(std::atan2(omni.T_base_cam(1, 0), omni.T_base_cam(0, 0)), 120 * kRadPerDeg, 1e-8);
  ASSERT_TRUE(omni.mirror.has_value());
  EXPECT_EQ(omni.mirror->A_m, kA);
  EXPECT_EQ(omni.mirror->B_m, kB);
  EXPECT_NEAR(omni.mirror->C_m, kC, 1e-12);
  EXPECT_EQ(omni.mirror->rim_radius_m, 0.04);
  EXPECT_NEAR(omni.mirror->rim_radius_px, 225.623, 5e-4);
  EXPECT_NEAR(omni.mirror->horizon_radius_px, 138.707, 5e-4);
}

TEST(OmniCamera, HasExposureStepsOfItsOwn) {
  Scene scene = DarkOmniScene();
  scene.ceiling.brightness = 0.4;
  scene.room.wall_brightness = 0.4;
  scene.image.exposure_steps = {{2, 0.01}};
  scene.omni->exposure_steps = {{4, 2}};
  const Renderer renderer(scene);
  const auto up = [&](int i) { return cv::mean(renderer.Render(StillFrame(i, {6, 4, 0})))[0]; };
  const auto omni = [&](int i) {
    return cv::mean(renderer.RenderOmni(StillFrame(i, {6, 4, 0})))[0];
  };
  EXPECT_LT(up(2), 0.2 * up(1));
  EXPECT_EQ(omni(2), omni(1));
  EXPECT_GT(omni(4), 1.1 * omni(1));
}

TEST(OmniCamera, LeavesTheOtherImagesAlone) {
  Scene scene;
  scene.camera.width_px = 160;
  scene.camera.height_px = 120;
  scene.camera.focal_px = 110;
  scene.forward = scene.camera;
  const Frame frame = StillFrame(3, {6, 4, 0.3});
  const Renderer without(scene);
  scene.omni = OmniCamera{};
  const Renderer with(scene);
  EXPECT_EQ(cv::norm(with.Render(frame), without.Render(frame), cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(with.RenderForward(frame), without.RenderForward(frame), cv::NORM_INF), 0);
  const cv::Mat image = with.RenderOmni(frame);
  EXPECT_EQ(image.type(), CV_8UC3);
  EXPECT_EQ(cv::norm(with.RenderOmni(frame), image, cv::NORM_INF), 0);
}

TEST(OmniCamera, IsRefusedWhereTheSceneHasNone) {
  const Renderer renderer(PlainScene());
  EXPECT_FALSE(renderer.GetRig().omni.has_value());
  EXPECT_THAT(
      [&] {
        (void)renderer.RenderOmni(StillFrame(0, {6, 4, 0}));
      },
      testing::ThrowsMessage<InputError>(
          "the scene has no omnidirectional camera; give it the group 'omni'"));
}

/// A red column of 0.3 m that passes in front of the robot, 1.5 m away, from its right to its left.
Scene MoverScene() {
  Scene scene = DarkOmniScene();
  scene.movers = {{7.5, 3, 0.3, 0.3, 0, 1.5, 0, 2, 0.1, 0.1, 0, 0.5, 1, 5}};
  return scene;
}

TEST(Movers, AreWhereTheyAreWhenTheyAre) {
  const Renderer renderer(MoverScene());
  for (const double t : {1.0, 2.0, 3.5, 5.0}) {
    const cv::Mat light = LightAt(renderer, {6, 4, 0}, 100 + t);
    const Vector2d seen = CentreOfLight(light) - Vector2d(kCentre, kCentre);
    const double azimuth = std::atan2(0.5 * (t - 1) - 1, 1.5);  // of its centre
    EXPECT_NEAR(std::atan2(seen.x(), -seen.y()), azimuth, 2.5 * kRadPerDeg) << t;
  }
  EXPECT_LT(cv::norm(LightAt(renderer, {6, 4, 0}, 100.9), LightAt(renderer, {6, 4, 0}, 105.1)),
            1e-9);
  const auto at = LightAt(renderer, {6, 4, 0}, 103).at<cv::Vec3f>(240 - 120, 240);
  EXPECT_GT(at[2], 15 * at[0]);  // red
}

TEST(Movers, CoverWhatIsBehindThemAndHideBehindWhatIsBeforeThem) {
  Scene scene = MoverScene();
  scene.fixtures.boxes = {{8.5, 4, 0.5, 0.5, 0, 2, 0, 0.5}};
  const auto colour = [](const Scene& s, double stamp_s) {
    return LightAt(Renderer(s), {6, 4, 0}, stamp_s).at<cv::Vec3f>(240 - 125, 240);
  };
  EXPECT_NEAR(colour(scene, 100)[2], 0.3, 1e-3);  // the grey box's side
  EXPECT_NEAR(colour(scene, 103)[2], 1.2, 1e-3);  // the mover's: 0.6 of 2
  scene.fixtures.boxes = {{7, 4, 0.1, 0.5, 0, 2, 0, 0.5}};
  EXPECT_NEAR(colour(scene, 103)[2], 0.3, 1e-3);
}

TEST(Movers, ShowInTheForwardImageToo) {
  Scene scene = MoverScene();
  scene.forward = scene.camera;
  const Renderer renderer(scene);
  const auto grey = [&](double stamp_s) {
    return renderer.RenderForward(StillFrame(0, {6, 4, 0}, stamp_s)).at<std::uint8_t>(120, 160);
  };
  EXPECT_LT(grey(100), 5);
  EXPECT_GT(grey(103), 100);
}

}  // namespace
}  // namespace ceilmap::simulator
