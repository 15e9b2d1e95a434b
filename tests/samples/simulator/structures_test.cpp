// Structures below the ceiling: they appear where their known points say, and hide each other.

#include "samples/simulator/structures.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "samples/simulator/fixtures.hpp"
#include "tests/samples/simulator/scenes.hpp"

namespace ceilmap::simulator {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using testing::Each;
using testing::SizeIs;
using testing::StartsWith;

constexpr double kKnownPointPx = 0.02;

/// One object or run without random deviations, texture, hangers and details.
Structure Plain(StructureKind kind) {
  Structure structure = DefaultStructure(kind);
  structure.name = "it";
  structure.contrast = 0;
  structure.hanger_every_m = 0;
  structure.details_per_10m = 0;
  return structure;
}

/// The dark room of 12 x 8 x 2.4 m with one lamp, 1.2 m above the camera.
Scene LampScene(StructureKind kind) {
  Scene scene = DarkScene();
  Structure lamp = Plain(kind);
  lamp.height_m = 1.6;
  lamp.at_m = 4;
  lamp.from_m = 5;
  lamp.to_m = 7;
  lamp.every_m = 2;  // one, at x = 6
  scene.structures = {lamp};
  return scene;
}

/// Centre of the light of the first structure. Only its underside may be visible.
Vector2d CentreOfLamp(Scene scene, const Isometry3d& T_map_base) {
  const cv::Mat on = Renderer(scene).RenderLight(T_map_base);
  scene.structures[0].brightness = 0;
  return CentreOfMark(on - Renderer(scene).RenderLight(T_map_base), 0);
}

/// Columns on which a row is lit, by the light that its pixels received.
double LitWidth(const cv::Mat& light, int row, double brightness) {
  return cv::sum(light.row(row))[0] / brightness;
}

TEST(Structures, LampsAppearAtTheirKnownPoints) {
  for (const StructureKind kind : {StructureKind::kPendant, StructureKind::kTube}) {
    Scene scene = LampScene(kind);
    scene.structures[0].width_m = 0.2;
    scene.structures[0].length_m = 0.2;
    const Renderer renderer(scene);
    Vector3d middle(0, 0, 0);
    const std::vector<NamedPoint>& points = renderer.GetObjects().points;
    for (const NamedPoint& point : points) {
      middle += point.p_map / static_cast<double>(points.size());
    }
    EXPECT_LT((middle - Vector3d(6, 4, 1.6)).norm(), 1e-9);
    for (int i = 0; i < 12; ++i) {
      const Isometry3d T_map_base =
          Level(6 + 0.09 * std::cos(2 * i), 4 + 0.09 * std::sin(3 * i), 31.0 * i);
      const Vector2d expected = Pixel(renderer, T_map_base, middle);
      EXPECT_LT((CentreOfLamp(scene, T_map_base) - expected).norm(), kKnownPointPx) << "pose " << i;
    }
  }
}

TEST(Structures, LampsAppearWhereTheTiltMovesThem) {
  for (int i = 1; i < 6; ++i) {
    Isometry3d T_map_base = Level(6, 4, 57.0 * i);
    T_map_base.rotate(Eigen::AngleAxisd(-0.02 * i, Vector3d::UnitY()));
    T_map_base.rotate(Eigen::AngleAxisd(0.012 * i, Vector3d::UnitX()));
    // Above the camera, so that only its underside is visible.
    const Vector3d camera = T_map_base * Vector3d(0, 0, 0.4);
    Scene scene = LampScene(StructureKind::kPendant);
    scene.structures[0].width_m = 0.03;
    scene.structures[0].at_m = camera.y();
    scene.structures[0].from_m = camera.x() - 1;
    scene.structures[0].to_m = camera.x() + 1;
    const Renderer renderer(scene);
    const NamedPoint& point = renderer.GetObjects().points.at(0);
    EXPECT_EQ(point.name, "it-1");
    const Vector2d expected = Pixel(renderer, T_map_base, point.p_map);
    EXPECT_GT((expected - Vector2d(159.5, 119.5)).norm(), 8 * i);
    EXPECT_LT((CentreOfLamp(scene, T_map_base) - expected).norm(), kKnownPointPx) << "tilt " << i;
  }
}

// A cylinder overhead is as wide as its tangents: f r / sqrt(z^2 - r^2) to each side.
TEST(Structures, PipeIsAsWideAsItsTangents) {
  Scene scene = DarkScene();
  scene.ceiling.brightness = 1;
  Structure pipe = Plain(StructureKind::kPipe);
  pipe.height_m = 1.4;
  pipe.width_m = 0.2;
  pipe.at_m = 4;
  pipe.every_m = 100;  // without couplings
  pipe.brightness = 0;
  scene.structures = {pipe};
  const Renderer renderer(scene);
  for (const double offset_m : {0.0, 0.013, 0.11}) {
    const cv::Mat light = renderer.RenderLight(Level(6, 4 - offset_m, 0));
    const double z = 1.4 + 0.1 - 0.4;
    const double distance = std::hypot(z, offset_m);
    const double middle = std::atan2(offset_m, z);
    const double half = std::asin(0.1 / distance);
    const double expected = 400 * (std::tan(middle + half) - std::tan(middle - half));
    EXPECT_NEAR(320 - LitWidth(light, 119, 1), expected, kKnownPointPx) << "offset " << offset_m;
  }
}

TEST(Structures, RoundSidesAreDarkerThanTheUnderside) {
  Scene scene = DarkScene();
  Structure duct = Plain(StructureKind::kRoundDuct);
  duct.height_m = 1.4;
  duct.width_m = 0.3;
  duct.at_m = 4;
  duct.every_m = 100;
  scene.structures = {duct};
  const cv::Mat light = Renderer(scene).RenderLight(Level(6, 4, 0));
  const float below = light.at<float>(119, 159);
  EXPECT_NEAR(below, duct.brightness, 0.08 * duct.brightness);  // random differences of sections
  const int edge = 159 + static_cast<int>(400 * 0.15 / std::sqrt(1.15 * 1.15 - 0.15 * 0.15)) - 2;
  EXPECT_LT(light.at<float>(119, edge), 0.85F * below);
  EXPECT_GT(light.at<float>(119, edge), 0.5F * below);
}

TEST(Structures, TheNearerHidesTheFarther) {
  Scene scene = DarkScene();
  Structure high = Plain(StructureKind::kDuct);
  high.height_m = 1.9;
  high.width_m = 0.2;
  high.at_m = 4;
  high.every_m = 100;
  high.brightness = 1;
  Structure low = high;
  low.along = Axis::kY;
  low.height_m = 1.4;
  low.at_m = 6;
  low.brightness = 0.5;
  const auto brightness_at = [](const Scene& of, int row, int column) {
    return Renderer(of).RenderLight(Level(6, 4, 0)).at<float>(row, column);
  };
  for (const bool reversed : {false, true}) {
    scene.structures = {high, low};
    if (reversed) std::swap(scene.structures[0], scene.structures[1]);
    EXPECT_NEAR(brightness_at(scene, 119, 159), 0.5, 0.05);  // where they cross
    EXPECT_NEAR(brightness_at(scene, 20, 159), 1, 0.1);      // only the high one
    EXPECT_NEAR(brightness_at(scene, 119, 60), 0.5, 0.05);   // only the low one
    EXPECT_EQ(brightness_at(scene, 20, 60), 0);              // the ceiling
  }
  // A robot in front sees the low one displaced: 400 / 1 px a metre.
  scene.structures = {low};
  const cv::Mat light = Renderer(scene).RenderLight(Level(5.9, 4, 0));
  const double brightness = light.at<float>(79, 159);
  EXPECT_NEAR(light.at<float>(119 - 40 - 38, 159), brightness, 1e-6);
  EXPECT_NEAR(light.at<float>(119 - 40 + 38, 159), brightness, 1e-6);
  EXPECT_EQ(light.at<float>(119 - 40 - 42, 159), 0);
}

TEST(Structures, KnownPointsAreVisibleCornersOfTheirKind) {
  Scene scene = PlainScene();
  scene.room = {.length_m = 12, .width_m = 8, .height_m = 5};
  for (const StructureKind kind : {StructureKind::kTruss,
                                   StructureKind::kDuct,
                                   StructureKind::kRoundDuct,
                                   StructureKind::kTray,
                                   StructureKind::kPipe,
                                   StructureKind::kPendant,
                                   StructureKind::kTube,
                                   StructureKind::kSkylight}) {
    Structure structure = Plain(kind);
    structure.hanger_every_m = 2;
    structure.height_m = 3.5;
    structure.at_m = 4;
    scene.structures = {structure};
    const Objects objects = MakeObjects(scene);
    EXPECT_FALSE(objects.points.empty()) << static_cast<int>(kind);
    for (const NamedPoint& point : objects.points) {
      EXPECT_THAT(point.name, StartsWith("it-"));
      EXPECT_NEAR(point.p_map.z(), 3.5, 0.05);
      // Nothing is below it, and some solid has it on its surface.
      bool on_surface = false;
      for (const Solid& solid : objects.solids) {
        const Vector3d p = solid.T_map_solid.inverse() * point.p_map;
        const bool inside =
            ((p - solid.low).array() > 1e-6).all() && ((solid.high - p).array() > 1e-6).all();
        EXPECT_FALSE(inside && !solid.is_round) << static_cast<int>(kind) << " " << point.name;
        on_surface |=
            ((p - solid.low).array() > -1e-6).all() && ((solid.high - p).array() > -1e-6).all();
      }
      EXPECT_TRUE(on_surface) << static_cast<int>(kind) << " " << point.name;
    }
  }
}

TEST(Structures, RunsFillTheRoomAtTheirSpacing) {
  Scene scene = PlainScene();
  Structure lamp = Plain(StructureKind::kPendant);
  lamp.at_m = 1;
  lamp.spacing_m = 2.5;
  lamp.every_m = 3;
  scene.structures = {lamp};
  // y = 1, 3.5, 6 below the ceiling of 12 x 8 m; x = 1.5, 4.5, 7.5, 10.5.
  EXPECT_THAT(MakeObjects(scene).points, SizeIs(12));
  EXPECT_EQ(MakeObjects(scene).points.back().p_map.head<2>(), Vector2d(10.5, 6));
  scene.structures[0].along = Axis::kY;  // x = 1, 3.5, 6, 8.5, 11; y = 1.5, 4.5, 7.5
  EXPECT_THAT(MakeObjects(scene).points, SizeIs(15));
  EXPECT_EQ(MakeObjects(scene).points.back().p_map.head<2>(), Vector2d(11, 7.5));
  scene.structures[0].runs = 2;
  EXPECT_THAT(MakeObjects(scene).points, SizeIs(6));
  scene.structures[0].runs = 0;
  scene.structures[0].share = 0.5;
  scene.structures[0].spacing_m = 0.5;
  const auto half = static_cast<double>(MakeObjects(scene).points.size());
  EXPECT_NEAR(half, 22 * 3 / 2.0, 12);
}

TEST(Structures, SeedAndNameDecideTheRest) {
  Scene scene = PlainScene();
  Structure lamp = Plain(StructureKind::kPendant);
  lamp.jitter_m = 0.3;
  scene.structures = {lamp};
  const Vector3d first = MakeObjects(scene).points[0].p_map;
  EXPECT_EQ(MakeObjects(scene).points[0].p_map, first);
  EXPECT_LT((first.head<2>() - Vector2d(1.5, 1)).lpNorm<Eigen::Infinity>(), 0.3);
  scene.seed = 2;
  EXPECT_NE(MakeObjects(scene).points[0].p_map, first);
}

TEST(Structures, BeamsOfTheFixturesHaveKnownPoints) {
  Scene scene = PlainScene();
  scene.fixtures.beam_every_m = 4;
  scene.fixtures.beam_width_m = 0.2;
  scene.fixtures.beam_depth_m = 0.3;
  const std::vector<NamedPoint> points = MakeObjects(scene).points;
  ASSERT_THAT(points, SizeIs(6));
  EXPECT_EQ(points[0].name, "beam-1");
  EXPECT_LT((points[1].p_map - Vector3d(2.1, 4, 2.1)).norm(), 1e-12);
}

TEST(Structures, FanTurnsLeftSeenFromAbove) {
  Scene scene = LampScene(StructureKind::kFan);
  scene.structures[0].turn_rate_deg_s = 90;
  // Four blades: after a second the same image, after a third of it they have turned by 30 degrees.
  const auto light_at = [&](double now_s, double yaw_deg) {
    const Renderer renderer(scene);
    return renderer.Render(StillFrame(0, {6, 4, yaw_deg * kRadPerDeg}, 100 + now_s));
  };
  const cv::Mat start = light_at(0, 0);
  EXPECT_GT(cv::countNonZero(start), 1000);
  EXPECT_LT(cv::norm(light_at(1, 0), start, cv::NORM_L1), 0.02 * cv::sum(start)[0]);
  EXPECT_GT(cv::norm(light_at(1 / 3.0, 0), start, cv::NORM_L1), 0.5 * cv::sum(start)[0]);
  EXPECT_LT(cv::norm(light_at(1 / 3.0, 30), start, cv::NORM_L1), 0.02 * cv::sum(start)[0]);
}

TEST(Structures, CraneMovesToAndFro) {
  Scene scene = DarkScene();
  Structure crane = Plain(StructureKind::kCrane);
  crane.height_m = 1.4;
  crane.at_m = 2;
  crane.speed_m_s = 0.5;
  crane.travel_m = 4;
  scene.structures = {crane};
  EXPECT_TRUE(MakeObjects(scene).solids.empty());
  const auto middle_y = [&](double now_s) {
    Eigen::AlignedBox3d bounds;
    for (const Solid& solid : MovingStructures(scene, now_s)) bounds.extend(Bounds(solid));
    return bounds.center().y();
  };
  EXPECT_NEAR(middle_y(0), 2, 1e-9);
  EXPECT_NEAR(middle_y(2), 3, 1e-9);
  EXPECT_NEAR(middle_y(8), 6, 1e-9);
  EXPECT_NEAR(middle_y(9), 5.5, 1e-9);
  EXPECT_NEAR(middle_y(17), 2.5, 1e-9);
}

TEST(Structures, MovingOnesBlur) {
  Scene scene = LampScene(StructureKind::kFan);
  EXPECT_EQ(MovingBlurLength(DarkScene(), scene.camera), 0);
  scene.structures[0].turn_rate_deg_s = 360;
  scene.structures[0].width_m = 1;
  // The ends of the blades move at pi m/s, 1.2 m above the camera, for 5 ms.
  EXPECT_NEAR(MovingBlurLength(scene, scene.camera), M_PI * 0.005 * 400 / 1.2, 1e-9);
}

}  // namespace
}  // namespace ceilmap::simulator
