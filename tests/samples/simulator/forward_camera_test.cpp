// Images of a forward camera: objects at their positions by the rig, walls, posters and the floor.

#include <gmock/gmock.h>

#include "calib/base/degrees.hpp"
#include "calib/base/error.hpp"
#include "samples/simulator/paints.hpp"
#include "samples/simulator/wall_posters.hpp"
#include "tests/samples/simulator/scenes.hpp"

namespace ceilmap::simulator {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kExactForwardPx = 0.01;  // what "exact" means here

/// Nothing but black, and a camera of 400 px at 0.4 m pointing along base x.
Scene DarkForwardScene() {
  Scene scene = DarkScene();
  scene.forward = scene.camera;
  return scene;
}

/// A square on the wall x = 12 m; of the box behind it no side shows.
Scene SquareOnTheWall(double y_m, double z_m, double size_m = 0.05) {
  Scene scene = DarkForwardScene();
  scene.fixtures.boxes = {
      {12.00049, y_m, 0.001, size_m, z_m - size_m / 2, z_m + size_m / 2, 0, 1.0}};
  return scene;
}

Vector2d ForwardPixel(const Renderer& renderer,
                      const Isometry3d& T_map_base,
                      const Vector3d& p_map) {
  const calib::MountedCamera& forward = *renderer.GetRig().forward;
  return *forward.camera.Project((T_map_base * forward.T_base_cam).inverse() * p_map);
}

/// Where the rig puts the middle of what a square on that wall covers of the image.
Vector2d CentreOfSquare(const Renderer& renderer,
                        const Isometry3d& T_map_base,
                        const Vector3d& middle,
                        double size_m) {
  constexpr int kPerSide = 20;
  std::vector<Vector2d> outline;
  const std::array<Vector2d, 5> corners{
      Vector2d(-1, -1), Vector2d(1, -1), Vector2d(1, 1), Vector2d(-1, 1), Vector2d(-1, -1)};
  for (int i = 0; i < 4 * kPerSide; ++i) {
    const Vector2d& from = corners.at(i / kPerSide);
    const double part = static_cast<double>(i % kPerSide) / kPerSide;
    const Vector2d at = size_m / 2 * (from + part * (corners.at(i / kPerSide + 1) - from));
    outline.push_back(ForwardPixel(renderer, T_map_base, middle + Vector3d(0, at.x(), at.y())));
  }
  double area = 0;  // the centroid of a polygon
  Vector2d moment(0, 0);
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Vector2d a = outline[i] - outline[0];
    const Vector2d b = outline[(i + 1) % outline.size()] - outline[0];
    const double cross = a.x() * b.y() - a.y() * b.x();
    area += cross / 2;
    moment += cross / 6 * (a + b);
  }
  return outline[0] + moment / area;
}

TEST(ForwardCamera, WhatIsToTheLeftIsOnTheLeftAndWhatIsHigherIsAbove) {
  // u = cx - f Y / X, v = cy - f (Z - 0.4) / X with X = 4 m: 100 px a metre.
  const Renderer renderer(SquareOnTheWall(4.5, 1.1));
  const Vector2d seen = CentreOfMark(renderer.RenderForwardLight(Level(7.99999, 4, 0)), 0);
  EXPECT_NEAR(seen.x(), 159.5 - 0.5 * 100, kExactForwardPx);
  EXPECT_NEAR(seen.y(), 119.5 - 0.7 * 100, kExactForwardPx);
}

TEST(ForwardCamera, NoseUpMovesTheContentDown) {
  const Renderer renderer(SquareOnTheWall(4, 0.4));
  const Isometry3d level = Level(7.99999, 4, 0);
  Isometry3d nose_up = level;
  nose_up.rotate(Eigen::AngleAxisd(-4 * kRadPerDeg, Vector3d::UnitY()));
  const Vector2d before = CentreOfMark(renderer.RenderForwardLight(level), 0);
  const Vector2d after = CentreOfMark(renderer.RenderForwardLight(nose_up), 0);
  EXPECT_NEAR(after.x() - before.x(), 0, kExactForwardPx);
  EXPECT_GT(after.y() - before.y(), 400 * std::tan(4 * kRadPerDeg) - 0.5);
  EXPECT_LT((after - ForwardPixel(renderer, nose_up, {11.99999, 4, 0.4})).norm(), kExactForwardPx);
}

TEST(ForwardCamera, ThingsFollowTheRigsCameraModelEverywhere) {
  constexpr double kSize = 0.3;
  Scene scene = SquareOnTheWall(4.2, 0.9, kSize);
  scene.forward->mount_x_m = 0.1;
  scene.forward->mount_y_m = -0.07;
  scene.forward->mount_yaw_deg = 5;
  scene.forward->mount_pitch_deg = 8;
  scene.forward->mount_roll_deg = -3;
  scene.forward->distortion = {-0.2, 0.05, 0.001, -0.0007, 0.01};
  const Renderer renderer(scene);
  int seen_times = 0;
  for (int i = 0; i < 24; ++i) {
    Isometry3d T_map_base =
        Level(8 + 1.2 * std::cos(1.7 * i), 4 + 0.7 * std::sin(2.3 * i), 12 * std::sin(0.9 * i));
    T_map_base.rotate(Eigen::AngleAxisd(-4 * kRadPerDeg * std::cos(i), Vector3d::UnitY()));
    T_map_base.rotate(Eigen::AngleAxisd(2 * kRadPerDeg * std::sin(i), Vector3d::UnitX()));
    const Vector2d expected = CentreOfSquare(renderer, T_map_base, {11.99999, 4.2, 0.9}, kSize);
    if (expected.x() < 35 || expected.x() > 285 || expected.y() < 35 || expected.y() > 205)
      continue;
    const Vector2d seen = CentreOfMark(renderer.RenderForwardLight(T_map_base), 0);
    EXPECT_LT((seen - expected).norm(), kExactForwardPx) << "pose " << i;
    ++seen_times;
  }
  EXPECT_GE(seen_times, 12);
}

// A box corner before a black room: its upright edge lies to a hundredth of a pixel.
TEST(ForwardCamera, EdgesOfABoxLieWhereTheyAre) {
  Scene scene = DarkForwardScene();
  scene.fixtures.boxes = {{8, 4, 1, 0.8, 0, 1.2, 0, 1.0}};  // its front is at x = 7.5
  const Renderer renderer(scene);
  for (int i = 0; i < 12; ++i) {
    const double offset_m = 0.00137 * i;
    const cv::Mat light = renderer.RenderForwardLight(Level(5.5, 4 + offset_m, 0));
    double right_px = 0;  // of row 119, right of its centre
    for (int u = 160; u < 320; ++u) right_px += light.at<float>(119, u) / 0.6;
    EXPECT_NEAR(right_px, (0.4 + offset_m) * 200, kExactForwardPx);
  }
}

TEST(ForwardCamera, FloorBeginsWhereTheWallEnds) {
  Scene scene = DarkForwardScene();
  scene.room.floor_brightness = 0.5;
  const cv::Mat light = Renderer(scene).RenderForwardLight(Level(8, 4, 0));
  // 0.4 m below the camera, 4 m away: 40 px below the centre.
  double rows = 0;
  for (int v = 120; v < 240; ++v) rows += light.at<float>(v, 100) / 0.5;
  EXPECT_NEAR(rows, 239.5 - (119.5 + 40), kExactForwardPx);
  EXPECT_EQ(light.at<float>(150, 100), 0);
}

TEST(ForwardCamera, PostersAreInTheImageWhereTheyHang) {
  Scene scene = DarkForwardScene();
  scene.room.wall_brightness = 0.5;
  scene.room.wall_posters_per_100m2 = 200;
  const WallPosters posters(scene);
  const cv::Mat light = Renderer(scene).RenderForwardLight(Level(8, 4, 0));
  double least = 1;
  double most = 0;
  int edges = 0;
  for (int v = 4; v < 150; v += 5) {
    for (int u = 0; u < 320; ++u) {
      double expected = 0;  // the mean of 40 x 40 rays
      for (int i = 0; i < 1600; ++i) {
        const double y_m = 4 - 4 * ((u + (i % 40 - 19.5) / 40) - 159.5) / 400;
        const double z_m = 0.4 - 4 * ((v + (i / 40 - 19.5) / 40) - 119.5) / 400;
        const auto field = posters.At(1, y_m, z_m);
        expected += 0.5 * (field ? field->brightness : 1) / 1600;
      }
      EXPECT_NEAR(light.at<float>(v, u), expected, 0.02) << u << ' ' << v;
      least = std::min(least, expected);
      most = std::max(most, expected);
      if (u > 0 && std::abs(light.at<float>(v, u) - light.at<float>(v, u - 1)) > 0.1) ++edges;
    }
  }
  EXPECT_LT(least, 0.3);
  EXPECT_GT(most, 0.7);
  EXPECT_GT(edges, 50);
}

TEST(ForwardCamera, FloorHasATextureThatFadesFarAway) {
  Scene scene = DarkForwardScene();
  scene.room.floor_brightness = 0.5;
  scene.room.floor_contrast = 0.2;
  scene.room.length_m = 100;
  scene.room.width_m = 100;
  const cv::Mat light = Renderer(scene).RenderForwardLight(Level(6, 50, 0));
  const auto deviation = [&](int row) {
    cv::Scalar mean, spread;
    cv::meanStdDev(light.row(row), mean, spread);
    EXPECT_NEAR(mean[0], 0.5, 0.1) << row;
    return spread[0];
  };
  EXPECT_GT(deviation(230), 0.02);
  EXPECT_LT(deviation(124), 0.001);  // 35 m away a pixel spans 8 m
}

TEST(ForwardCamera, BlursByItsOwnExposure) {
  Scene scene = SquareOnTheWall(4, 0.4);
  scene.image.motion_blur = true;
  const Renderer renderer(scene);
  const Frame still = StillFrame(0, {7.99999, 4, 0});
  Frame turning = still;
  turning.T_map_base_forward_open = Level(7.99999, 4, -0.5);
  turning.T_map_base_forward_close = Level(7.99999, 4, 0.5);
  const auto spread = [](const cv::Mat& image) {
    cv::Mat columns;
    cv::reduce(image, columns, 0, cv::REDUCE_MAX);
    return cv::countNonZero(columns);
  };
  EXPECT_NEAR(spread(renderer.RenderForward(turning)) - spread(renderer.RenderForward(still)),
              400 * kRadPerDeg,
              2);
  EXPECT_EQ(cv::norm(renderer.Render(turning), renderer.Render(still), cv::NORM_INF), 0);
}

TEST(ForwardCamera, LeavesTheUpwardImagesAlone) {
  Scene scene;
  scene.camera.width_px = 320;
  scene.camera.height_px = 240;
  scene.camera.focal_px = 220;
  const Frame frame = StillFrame(3, {6, 4, 0.3});
  const cv::Mat alone = Renderer(scene).Render(frame);
  scene.forward = scene.camera;
  const Renderer both(scene);
  EXPECT_EQ(cv::norm(both.Render(frame), alone, cv::NORM_INF), 0);
}

TEST(ForwardCamera, HasNoiseOfItsOwn) {
  Scene scene = DarkForwardScene();
  scene.ceiling.brightness = 0.4;
  scene.fixtures.boxes = {{8, 4, 0.1, 8, 0, 2.4, 0, 0.4 / 0.6}};  // fills the forward image
  scene.image.shot_noise = 0.02;
  const Renderer renderer(scene);
  const Frame frame = StillFrame(0, {7, 4, 0});
  cv::Mat up, forward, difference;
  renderer.Render(frame).convertTo(up, CV_32F);
  renderer.RenderForward(frame).convertTo(forward, CV_32F);
  cv::Scalar mean, noise, together;
  cv::meanStdDev(up, mean, noise);
  cv::meanStdDev(up - forward, mean, together);
  EXPECT_NEAR(together[0], std::sqrt(2.0) * noise[0], 0.05 * noise[0]);
}

TEST(ForwardCamera, ColoursLeaveTheLuminanceAlone) {
  Scene scene = PlainScene();
  scene.room.wall_posters_per_100m2 = 150;
  scene.fixtures.boxes = {{9, 5, 1, 0.8, 0, 1.2, 20, 0.7}};
  scene.forward = scene.camera;
  scene.forward->mount_pitch_deg = 20;  // with a view of the ceiling too
  const cv::Mat grey = Renderer(scene).RenderForwardLight(Level(6, 4, 0));
  scene.forward->saturation = 1;
  const cv::Mat coloured = Renderer(scene).RenderForwardLight(Level(6, 4, 0));
  ASSERT_EQ(grey.type(), CV_32FC1);
  ASSERT_EQ(coloured.type(), CV_32FC3);
  int colourful = 0;
  for (int v = 0; v < grey.rows; ++v) {
    for (int u = 0; u < grey.cols; ++u) {
      const auto& c = coloured.at<cv::Vec3f>(v, u);
      ASSERT_NEAR(Luminance(c[2], c[1], c[0]), grey.at<float>(v, u), 1e-4) << u << ' ' << v;
      if (std::abs(c[2] - c[0]) > 0.1) ++colourful;
    }
  }
  EXPECT_GT(colourful, grey.rows * grey.cols / 50);
}

TEST(ForwardCamera, ShowsMoversInTheirColours) {
  Scene scene = DarkForwardScene();
  scene.movers = {{8, 4, 0.1, 2, 0, 2, 0, 1, 0.25, 0, 0, 0, -1e6, 1e6}};  // before it
  const Frame frame = StillFrame(0, {6, 4, 0});
  EXPECT_EQ(Renderer(scene).RenderForward(frame).type(), CV_8UC1);
  scene.forward->saturation = 1;
  const cv::Mat image = Renderer(scene).RenderForward(frame);
  ASSERT_EQ(image.type(), CV_8UC3);
  // Its ends shine with 0.6 of 1 and of 0.25: by the sRGB curve 0.798 and 0.425.
  const auto& seen = image.at<cv::Vec3b>(100, 160);
  EXPECT_NEAR(seen[2], 203, 1);
  EXPECT_NEAR(seen[1], 108, 1);
  EXPECT_EQ(seen[0], 0);
}

TEST(ForwardCamera, IsRefusedWhereTheSceneHasNone) {
  const Renderer renderer(PlainScene());
  EXPECT_FALSE(renderer.GetRig().forward.has_value());
  EXPECT_THAT(
      [&] {
        (void)renderer.RenderForward(StillFrame(0, {6, 4, 0}));
      },
      testing::ThrowsMessage<InputError>(
          "the scene has no forward camera; give it the group 'forward'"));
}

TEST(WallPosters, FollowTheSeedAndAreOptional) {
  Scene scene;
  const auto covered = [](const WallPosters& posters, const WallPosters& others) {
    int both = 0;
    int one = 0;
    for (int wall = 0; wall < 4; ++wall) {
      for (double along = 0.05; along < 8; along += 0.1) {
        const bool a = posters.At(wall, along, 1.2).has_value();
        const bool b = others.At(wall, along, 1.2).has_value();
        if (a && b) ++both;
        if (a) ++one;
      }
    }
    return std::pair(one, both);
  };
  EXPECT_EQ(covered(WallPosters(scene), WallPosters(scene)).first, 0);
  scene.room.wall_posters_per_100m2 = 40;
  const WallPosters posters(scene);
  const auto [one, both] = covered(posters, WallPosters(scene));
  EXPECT_EQ(one, both);
  EXPECT_GT(one, 40);
  scene.seed = 2;
  EXPECT_LT(covered(posters, WallPosters(scene)).second, one);
}

}  // namespace
}  // namespace ceilmap::simulator
