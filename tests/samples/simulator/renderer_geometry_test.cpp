#include <gmock/gmock.h>

#include "calib/base/degrees.hpp"
#include "tests/samples/simulator/scenes.hpp"

namespace ceilmap::simulator {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kExactPx = 0.01;  // what "exact" means here

Scene MarkedScene(double x_m, double y_m, double radius_m = 0.05) {
  Scene scene = PlainScene();
  scene.ceiling.marks_at = {{x_m, y_m, radius_m, 0.0}};
  return scene;
}

Vector2d MarkInImage(const Scene& scene, const Isometry3d& T_map_base) {
  return CentreOfMark(Renderer(scene).RenderLight(T_map_base));
}

TEST(RendererGeometry, LampToTheLeftIsOnTheRightAndOneAheadIsAtTheTop) {
  // u = cx + f Y / Z, v = cy - f X / Z with 200 px a metre.
  const Vector2d left = MarkInImage(MarkedScene(6, 4.3), Level(6, 4, 0));
  EXPECT_NEAR(left.x(), 159.5 + 0.3 * 200, kExactPx);
  EXPECT_NEAR(left.y(), 119.5, kExactPx);
  const Vector2d ahead = MarkInImage(MarkedScene(6.25, 4), Level(6, 4, 0));
  EXPECT_NEAR(ahead.x(), 159.5, kExactPx);
  EXPECT_NEAR(ahead.y(), 119.5 - 0.25 * 200, kExactPx);
}

TEST(RendererGeometry, LeftTurnTurnsTheContentCounterClockwise) {
  const Scene scene = MarkedScene(6, 4.3);
  const Vector2d turned = MarkInImage(scene, Level(6, 4, 30));
  // From the right of the centre by 30 degrees towards the top.
  EXPECT_NEAR(turned.x(), 159.5 + 60 * std::cos(30 * kRadPerDeg), kExactPx);
  EXPECT_NEAR(turned.y(), 119.5 - 60 * std::sin(30 * kRadPerDeg), kExactPx);
}

TEST(RendererGeometry, MotionForwardMovesTheContentDownBySubpixels) {
  const Renderer renderer(MarkedScene(6.1, 4.2));
  const Vector2d before = CentreOfMark(renderer.RenderLight(Level(6, 4, 0)));
  for (int i = 1; i <= 20; ++i) {
    const double step_px = i * 0.17;
    const Vector2d after = CentreOfMark(renderer.RenderLight(Level(6 + step_px / 200, 4, 0)));
    EXPECT_NEAR(after.x() - before.x(), 0, kExactPx);
    EXPECT_NEAR(after.y() - before.y(), step_px, kExactPx);
  }
}

// A strip of rows shows the ceiling from the pose at its own time.
TEST(RendererGeometry, RowsOfARollingShutterHaveTheirOwnTime) {
  for (const double readout_time_s : {0.1, -0.1}) {
    Scene scene = PlainScene();
    scene.ceiling.marks_at = {{6, 4, 0.4, 0.0}, {6.3, 4.4, 0.1, 0.0}, {5.7, 4.1, 0.2, 0.9}};
    scene.camera.readout_time_s = readout_time_s;
    scene.camera.exposure_time_s = 0;
    Frame frame = StillFrame(0, {6, 4, 0.3});
    frame.T_map_base_open = Level(5.9, 4.05, 0.2 / kRadPerDeg);
    frame.T_map_base_close = Level(6.1, 3.95, 0.4 / kRadPerDeg);
    const cv::Mat rolling = Renderer(scene).Render(frame);
    scene.camera.readout_time_s = 0;
    const Renderer still(scene);
    for (const int first : {0, 64, 232}) {
      const double time = ((first + 3.5) / 239 - 0.5) * 2 * (readout_time_s > 0 ? 1 : -1);
      const Isometry3d there =
          Level(6 + 0.1 * time, 4 - 0.05 * time, (0.3 + 0.1 * time) / kRadPerDeg);
      Frame at = StillFrame(0, {6, 4, 0});
      at.T_map_base = at.T_map_base_open = at.T_map_base_close = there;
      const cv::Range rows(first, first + 8);
      EXPECT_LE(cv::norm(rolling.rowRange(rows), still.Render(at).rowRange(rows), cv::NORM_INF), 2);
    }
  }
}

TEST(RendererGeometry, MarkFollowsTheRigsCameraModelEverywhere) {
  Scene scene = MarkedScene(6.1, 4.2, 0.02);
  scene.camera.mount_x_m = 0.1;
  scene.camera.mount_y_m = -0.07;
  scene.camera.mount_yaw_deg = 10;
  scene.camera.distortion = {-0.2, 0.05, 0.001, -0.0007, 0.01};
  const Renderer renderer(scene);
  for (int i = 0; i < 24; ++i) {
    const Isometry3d T_map_base =
        Level(6.05 + 0.29 * std::cos(1.7 * i), 4.1 + 0.37 * std::sin(2.3 * i), 37.0 * i);
    const Vector2d expected = Pixel(renderer, T_map_base, {6.1, 4.2, 2.4});
    if (expected.x() < 8 || expected.x() > 311 || expected.y() < 8 || expected.y() > 231) continue;
    const Vector2d seen = CentreOfMark(renderer.RenderLight(T_map_base));
    EXPECT_LT((seen - expected).norm(), 0.02) << "pose " << i;
  }
}

// Up to 70 degrees from the axis, under an endless ceiling.
TEST(RendererGeometry, MarkFollowsAFisheyesModel) {
  Scene scene = MarkedScene(50.1, 50.2, 0.04);
  scene.camera.focal_px = 160;
  scene.room = {.length_m = 100, .width_m = 100, .height_m = 2.4};
  scene.camera.distortion_model = calib::LensModel::kEquidistant;
  scene.camera.distortion = {-0.03, 0.006, -0.001, 0.0001};
  scene.camera.mount_pitch_deg = 10;
  const Renderer renderer(scene);
  int seen_marks = 0;
  for (int i = 0; i < 24; ++i) {
    const Isometry3d T_map_base =
        Level(50.05 + 2 * std::cos(1.7 * i), 50.1 + std::sin(2.3 * i), 37.0 * i);
    const Vector2d expected = Pixel(renderer, T_map_base, {50.1, 50.2, 2.4});
    if (expected.x() < 8 || expected.x() > 311 || expected.y() < 8 || expected.y() > 231) continue;
    ++seen_marks;
    const Vector2d seen = CentreOfMark(renderer.RenderLight(T_map_base));
    EXPECT_LT((seen - expected).norm(), 0.05) << "pose " << i;
  }
  EXPECT_GT(seen_marks, 12);
}

TEST(RendererGeometry, TiltMovesTheMarkInTheImage) {
  const Renderer renderer(MarkedScene(6.1, 4.2, 0.01));
  Isometry3d T_map_base = Level(6, 4, 20);
  T_map_base.rotate(Eigen::AngleAxisd(-4 * kRadPerDeg, Vector3d::UnitY()));  // nose up
  T_map_base.rotate(Eigen::AngleAxisd(2 * kRadPerDeg, Vector3d::UnitX()));
  T_map_base.translation().z() = 0.02;
  const Vector2d expected = Pixel(renderer, T_map_base, {6.1, 4.2, 2.4});
  EXPECT_LT((CentreOfMark(renderer.RenderLight(T_map_base)) - expected).norm(), 0.02);
}

TEST(RendererGeometry, BoxShowsParallax) {
  Scene scene = PlainScene();
  // Only the bottom shows: the camera stands under it. Bottom 1 m above the camera: 400 px a metre.
  scene.ceiling.brightness = 0.5;  // exact in the texture's 16 bits
  scene.fixtures.boxes = {{6.02, 4.03, 0.1, 0.1, 1.4, 2.4, 15, 1.0}};
  const Renderer renderer(scene);
  const Isometry3d T_map_base = Level(6.02, 4.03, 0);
  const Vector2d centre = CentreOfMark(renderer.RenderLight(T_map_base), 0.5);
  EXPECT_NEAR(centre.x(), 159.5, kExactPx);
  EXPECT_NEAR(centre.y(), 119.5, kExactPx);
  const cv::Mat light = renderer.RenderLight(T_map_base);
  double area_px = 0;
  for (int v = 0; v < light.rows; ++v) {
    for (int u = 0; u < light.cols; ++u) area_px += (light.at<float>(v, u) - 0.5F) / 0.5F;
  }
  EXPECT_NEAR(area_px, 40 * 40, 1.6);
}

// The edge of a box along the image's columns, placed from 0 to 1 pixel, shows as the share of
// its pixel that it covers.
TEST(RendererGeometry, BoxEdgesLieWhereTheyAreToAHundredthOfAPixel) {
  Scene scene = PlainScene();
  scene.ceiling.brightness = 0;
  scene.fixtures.boxes = {{6, 4, 4, 0.4, 2.3, 2.4, 0, 1.0}};
  const Renderer renderer(scene);
  const double px_per_m = 400 / 1.9;
  for (int i = 0; i < 30; ++i) {
    const double offset_m = i * 0.23 / px_per_m;
    const cv::Mat light = renderer.RenderLight(Level(6, 4 - offset_m, 0));
    // Bottom's right edge at y = 4.2.
    const double edge = 159.5 + (0.2 + offset_m) * px_per_m;
    const int column = static_cast<int>(std::floor(edge + 0.5));
    double mean = 0;
    double inside = 0;
    for (int v = 20; v < 220; ++v) {
      mean += light.at<float>(v, column) / 200;
      inside += light.at<float>(v, column - 1) / 200;
    }
    EXPECT_NEAR(mean / inside, edge + 0.5 - column, kExactPx) << "edge at " << edge;
  }
}

TEST(RendererGeometry, SideFaceAppearsBetweenBottomAndTop) {
  Scene scene = PlainScene();
  scene.ceiling.brightness = 0;
  scene.fixtures.boxes = {{6, 4.5, 2, 0.2, 2.0, 2.4, 0, 1.0}};
  const cv::Mat light = Renderer(scene).RenderLight(Level(6, 4, 0));
  // The side towards the camera is at y = 4.4: the bottom begins at 0.4 m * 400 / 1.6 px, the side
  // meets the ceiling at 0.4 * 400 / 2 px.
  const int row = 119;
  EXPECT_NEAR(light.at<float>(row, 160 + 110), 1.0, 1e-6);
  EXPECT_NEAR(light.at<float>(row, 160 + 90), 0.75, 1e-6);
  EXPECT_NEAR(light.at<float>(row, 160 + 70), 0, 1e-3);
}

TEST(RendererGeometry, WallBeginsWhereTheCeilingEnds) {
  Scene scene = PlainScene();
  scene.ceiling.brightness = 0;
  scene.room.wall_brightness = 1;
  scene.room.wall_contrast = 0;
  const Renderer renderer(scene);
  // The wall y = 8 is 0.5 m to the left: 100 px to the right of the centre.
  const cv::Mat light = renderer.RenderLight(Level(6, 7.5, 0));
  EXPECT_FLOAT_EQ(light.at<float>(50, 250), 0);
  EXPECT_NEAR(light.at<float>(50, 265), 0.85, 1e-3);
  double covered = 0;  // columns right of 250
  for (int u = 250; u < 270; ++u) covered += light.at<float>(50, u) / 0.85;
  EXPECT_NEAR(covered, 269.5 - 259.5, kExactPx);
}

TEST(RendererGeometry, LensShowsNothingBeyondItsCircle) {
  Scene scene = PlainScene();
  scene.camera.focal_px = 120;
  scene.camera.distortion = {-0.35, 0, 0, 0, 0};  // turns back at r = 0.976
  scene.room = {.length_m = 200, .width_m = 200, .height_m = 2.4};
  const Renderer renderer(scene);
  const cv::Mat light = renderer.RenderLight(Level(100, 100, 0));
  EXPECT_NEAR(light.at<float>(120, 160), 0.4, 1e-3);
  EXPECT_EQ(light.at<float>(0, 0), 0);
  EXPECT_EQ(renderer.Render(StillFrame(0, {100, 100, 0})).at<std::uint8_t>(0, 0), 0);
}

}  // namespace
}  // namespace ceilmap::simulator
