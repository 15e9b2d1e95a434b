#include "calib/rig_facts.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "calib/base/degrees.hpp"
#include "tests/calib/rig_text.hpp"

namespace ceilmap::calib {
namespace {

constexpr double kHalfTurn = std::numbers::pi;

RigFacts FactsOf(const std::string& text) {
  return DescribeRig(ParseRig(text, "rig.yaml"));
}

// f = 320 px at 640 x 480: 2 atan(1), 2 atan(3/4), 2 atan(5/4).
TEST(RigFacts, FieldOfViewAndScaleOfAnUpwardCamera) {
  const RigFacts facts =
      FactsOf(Replaced(kMinimalRigText, "457, 0, 319.5, 0, 457", "320, 0, 319.5, 0, 320"));
  ASSERT_TRUE(facts.up && facts.up->field_of_view);
  EXPECT_FALSE(facts.forward || facts.omni);
  EXPECT_NEAR(facts.up->field_of_view->horizontal_rad, kHalfTurn / 2, 1e-9);
  EXPECT_NEAR(facts.up->field_of_view->vertical_rad, 2 * std::atan(0.75), 1e-9);
  EXPECT_NEAR(facts.up->field_of_view->diagonal_rad, 2 * std::atan(1.25), 1e-9);
  EXPECT_NEAR(facts.up->distance_m, 2.2, 1e-12);
  EXPECT_NEAR(facts.up->m_per_px, 2.2 / 320, 1e-12);
  EXPECT_NEAR(facts.up->ceiling_m.x(), 4.4, 1e-12);
  EXPECT_NEAR(facts.up->ceiling_m.y(), 3.3, 1e-12);
  EXPECT_EQ(facts.up->tilt_rad, 0);
}

// 640 px at f = 321 px: the corners are 71 deg from the axis. The view has f = 400 px / tan(65 deg)
// = 186.5 px; the raw image ends 319.5 / 321 rad and 239.5 / 321 rad from the axis, 287.4 px and
// 172.4 px in the view.
TEST(RigFacts, ViewOfAFisheye) {
  const RigFacts facts =
      FactsOf(Replaced(Replaced(kMinimalRigText, "457, 0, 319.5, 0, 457", "321, 0, 319.5, 0, 321"),
                       "    base_link",
                       "    distortion_model: equidistant\n"
                       "    distortion_coefficients: {rows: 1, cols: 4, data: [0, 0, 0, 0]}\n"
                       "    base_link"));
  EXPECT_NEAR(facts.up->field_of_view->horizontal_rad, 640.0 / 321, 1e-9);
  EXPECT_NEAR(facts.up->field_of_view->diagonal_rad, 800.0 / 321, 1e-9);
  EXPECT_EQ(facts.up->view_px, cv::Size(574, 344));
  EXPECT_NEAR(facts.up->view.horizontal_rad, 2 * std::atan(287.0 / 186.52), 1e-3);
  EXPECT_NEAR(facts.up->ceiling_m.x(), 574 * 2.2 / 186.52, 1e-3);
  EXPECT_NEAR(facts.up->corners_m->at(0).x(), 172.5 * 2.2 / 186.52, 1e-3);
}

// The top left corner shows the ceiling ahead (+x) and to the robot's right (-y).
TEST(RigFacts, CornersOfTheImageOnTheCeiling) {
  std::string text = Replaced(kMinimalRigText, "457, 0, 319.5, 0, 457", "320, 0, 319.5, 0, 320");
  text = Replaced(text, "[0, 0, 0.4]", "[0.1, 0, 0.4]");
  const RigFacts facts = FactsOf(text);
  ASSERT_TRUE(facts.up->corners_m);
  const auto& corners = *facts.up->corners_m;
  EXPECT_LT((corners[0] - Eigen::Vector2d(1.75, -2.2)).norm(), 1e-9);
  EXPECT_LT((corners[1] - Eigen::Vector2d(1.75, 2.2)).norm(), 1e-9);
  EXPECT_LT((corners[2] - Eigen::Vector2d(-1.55, 2.2)).norm(), 1e-9);
  EXPECT_LT((corners[3] - Eigen::Vector2d(-1.55, -2.2)).norm(), 1e-9);
}

// Seen from below, the right of an image with its top to the front is the robot's left.
TEST(RigFacts, DirectionsOfTheImage) {
  const RigFacts facts = FactsOf(kMinimalRigText);
  EXPECT_NEAR(facts.up->top_yaw_rad, 0, 1e-12);
  EXPECT_NEAR(facts.up->right_yaw_rad, kHalfTurn / 2, 1e-12);
  const RigFacts turned =
      FactsOf(Replaced(kMinimalRigText,
                       "translation: [0, 0, 0.4]",
                       "translation: [0, 0, 0.4], rotation_xyzw: [0, 0, 0, 1]"));
  EXPECT_NEAR(turned.up->top_yaw_rad, -kHalfTurn / 2, 1e-12);
  EXPECT_NEAR(turned.up->right_yaw_rad, 0, 1e-12);
}

TEST(RigFacts, TiltOfAnUpwardCamera) {
  const RigFacts facts = FactsOf(
      Replaced(kMinimalRigText,
               "translation: [0, 0, 0.4]",
               "translation: [0, 0, 0.4], rotation_xyzw: [0, 0.0871557427, 0, 0.996194698]"));
  EXPECT_NEAR(facts.up->tilt_rad * kDegPerRad, 10, 1e-6);
}

// A barrel distortion with k1 = -0.1 at f = 320: the edge's ray has r (1 - 0.1 r^2) = 1, r
// = 1.1531.
TEST(RigFacts, FieldOfViewThroughALens) {
  std::string text = Replaced(kMinimalRigText, "457, 0, 319.5, 0, 457", "320, 0, 319.5, 0, 320");
  text = Replaced(text,
                  "    base_link",
                  "    distortion_model: plumb_bob\n"
                  "    distortion_coefficients: {rows: 1, cols: 5, data: [-0.08, 0, 0, 0, 0]}\n"
                  "    base_link");
  const RigFacts facts = FactsOf(text);
  ASSERT_TRUE(facts.up->field_of_view);
  const double r = std::tan(facts.up->field_of_view->horizontal_rad / 2);
  EXPECT_NEAR(r * (1 - 0.08 * r * r), 1, 1e-9);
  // The model ends at r = sqrt(10 / 3), which appears at 1.217 focal lengths; the corner is
  // at 1.25.
  EXPECT_TRUE(!FactsOf(Replaced(text, "[-0.08,", "[-0.1,")).up->field_of_view);
}

TEST(RigFacts, ForwardCamera) {
  const RigFacts facts = FactsOf(kRigText);
  ASSERT_TRUE(facts.forward && facts.forward->horizon_row_px);
  EXPECT_EQ(facts.forward->height_m, 0.45);
  EXPECT_NEAR(facts.forward->yaw_rad, 0, 1e-12);
  EXPECT_NEAR(facts.forward->elevation_rad, 0, 1e-12);
  EXPECT_FALSE(facts.forward->upside_down);
  EXPECT_NEAR(*facts.forward->horizon_row_px, 119.5, 1e-9);
}

// Raised by 14 deg, the horizon is f tan(14 deg) below the middle.
TEST(RigFacts, HorizonOfARaisedForwardCamera) {
  const RigFacts facts =
      FactsOf(Replaced(kRigText,
                       "rotation_xyzw: [-0.5, 0.5, -0.5, 0.5]",
                       "rotation_xyzw: [-0.435338404, 0.435338404, -0.557207748, 0.557207748]"));
  EXPECT_NEAR(facts.forward->elevation_rad * kDegPerRad, 14, 1e-6);
  ASSERT_TRUE(facts.forward->horizon_row_px);
  EXPECT_NEAR(*facts.forward->horizon_row_px, 119.5 + 277 * std::tan(14 * kRadPerDeg), 1e-4);
}

TEST(RigFacts, MirrorCamera) {
  const RigFacts facts = FactsOf(kRigText);
  ASSERT_TRUE(facts.omni && facts.omni->rim_elevation_rad);
  EXPECT_EQ(facts.omni->height_m, 0.55);
  EXPECT_NEAR(facts.omni->top_yaw_rad, 0, 1e-12);
  EXPECT_EQ(facts.omni->centre_px, Eigen::Vector2d(239.5, 239.5));
  EXPECT_EQ(facts.omni->outer_radius_px, 225.623);
  EXPECT_FALSE(facts.omni->inner_radius_px);
  EXPECT_GT(*facts.omni->rim_elevation_rad, 0);
}

}  // namespace
}  // namespace ceilmap::calib
