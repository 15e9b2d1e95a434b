#include "mapping/odometry.hpp"
#include "calib/base/degrees.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "calib/base/error.hpp"
#include "tests/mapping/odometry_drive.hpp"
#include "tests/mapping/registration/synthetic_ceiling.hpp"

namespace ceilmap::mapping {
namespace {

using calib::CeilingView;
using registration::Verdict;
using registration::synthetic::MotionAt;
using registration::synthetic::SyntheticCeiling;
using synthetic_drive::Drive;
using synthetic_drive::DriveEvenly;
using synthetic_drive::ExpectNear;
using synthetic_drive::MakeView;
using synthetic_drive::Placed;
constexpr double kMillimetre = 1e-3;

/// About 6 m: straight, a left turn, straight, a right turn.
void DrivePathWithTurns(Drive& drive) {
  drive.Process();
  const auto drive_on = [&](int frames, double forward_m, double turn_deg) {
    for (int i = 0; i < frames; ++i) {
      drive.Move(forward_m, turn_deg);
      drive.Process();
    }
  };
  drive_on(14, 0.12, 0);
  drive_on(14, 0.06, 7);
  drive_on(14, 0.12, 0.5);
  drive_on(10, 0.05, -9);
  drive_on(10, 0.12, -0.5);
}

class OdometryOnAPath : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    drive = std::make_unique<Drive>();
    DrivePathWithTurns(*drive);
  }
  static void TearDownTestSuite() { drive.reset(); }

  static inline std::unique_ptr<Drive> drive;
};

TEST_F(OdometryOnAPath, FollowsTheTruth) {
  int keyframes = 0;
  for (std::size_t i = 0; i < drive->Steps().size(); ++i) {
    const OdometryStep& step = drive->Steps()[i];
    ASSERT_EQ(step.pose.status, graph::TrackingStatus::kTracking) << i;
    EXPECT_EQ(step.pose.frame_index, static_cast<std::int64_t>(i));
    EXPECT_EQ(step.pose.stamp_s, 0.1 * static_cast<double>(i));
    EXPECT_EQ(step.registration.verdict, Verdict::kOk);
    ExpectNear(step.pose.T_map_base, drive->Truths()[i], "frame " + std::to_string(i));
    keyframes += step.new_keyframe ? 1 : 0;
  }
  EXPECT_GE(keyframes, 5);
  EXPECT_LE(keyframes, 20) << "a keyframe is not every third frame";
}

TEST_F(OdometryOnAPath, KeyframesCountFromZeroAndHoldTheirImage) {
  std::int64_t next = 0;
  for (const OdometryStep& step : drive->Steps()) {
    if (!step.new_keyframe) continue;
    EXPECT_EQ(step.new_keyframe->id, next++);
    EXPECT_EQ(step.new_keyframe->image.size(), drive->View().Size());
    ExpectNear(step.new_keyframe->pose.T_map_base,
               drive->Truths()[static_cast<std::size_t>(step.new_keyframe->pose.frame_index)],
               "keyframe");
    EXPECT_LT(step.pose.keyframe_id, next);
    EXPECT_GE(step.pose.keyframe_id, 0);
  }
}

TEST_F(OdometryOnAPath, CovarianceIsPositiveAndGrows) {
  double last_area = 0;
  double last_yaw = 0;
  for (std::size_t i = 1; i < drive->Steps().size(); ++i) {
    const Eigen::Matrix3d& c = drive->Steps()[i].pose.covariance;
    EXPECT_LT((c - c.transpose()).norm(), 1e-9 * c.norm());
    EXPECT_EQ(c.llt().info(), Eigen::Success) << i;
    if (!drive->Steps()[i].new_keyframe) continue;
    const Eigen::Matrix3d& k = drive->Steps()[i].new_keyframe->pose.covariance;
    const double area = k.topLeftCorner<2, 2>().determinant();
    EXPECT_GT(area, last_area) << i;
    EXPECT_GT(k(2, 2), last_yaw) << i;
    last_area = area;
    last_yaw = k(2, 2);
  }
  EXPECT_GT(last_yaw, 0);
  EXPECT_LT(std::sqrt(last_yaw), 0.05 * kRadPerDeg);
}

TEST_F(OdometryOnAPath, EdgesAreTrueWithinTheirInformation) {
  std::map<std::int64_t, std::size_t> frame_of;
  int edges = 0;
  int to_older = 0;
  for (const OdometryStep& step : drive->Steps()) {
    if (step.new_keyframe) {
      frame_of[step.new_keyframe->id] =
          static_cast<std::size_t>(step.new_keyframe->pose.frame_index);
      EXPECT_EQ(step.new_edges.empty(), step.new_keyframe->id == 0);
    }
    for (const graph::Edge& edge : step.new_edges) {
      ASSERT_TRUE(frame_of.contains(edge.from) && frame_of.contains(edge.to));
      EXPECT_LT(edge.from, edge.to);
      EXPECT_EQ(edge.kind, graph::Edge::Kind::kOdometry);
      to_older += edge.to - edge.from > 1 ? 1 : 0;
      const Pose2 truth =
          drive->Truths()[frame_of[edge.from]].Inverse() * drive->Truths()[frame_of[edge.to]];
      const Eigen::Vector3d error(edge.T_from_to.x - truth.x,
                                  edge.T_from_to.y - truth.y,
                                  WrapAngle(edge.T_from_to.yaw - truth.yaw));
      EXPECT_LT(error.head<2>().norm(), 0.5 * kMillimetre);
      EXPECT_LT(std::abs(error.z()), 0.015 * kRadPerDeg);
      EXPECT_LT(error.dot(edge.information * error), 36) << "six sigmas";
      ++edges;
    }
  }
  EXPECT_GE(edges, 5);
  EXPECT_GE(to_older, 1) << "ties skip a keyframe where the view still overlaps";
}

TEST(Odometry, StartsAtTheFirstFrameWithTexture) {
  const Pose2 origin{-1, 2, 2.5};
  Drive drive(origin);
  for (const int grey : {0, 0, 255, 90}) {
    const OdometryStep step = drive.SeeUniform(grey);
    EXPECT_EQ(step.pose.status, graph::TrackingStatus::kLost);
    EXPECT_EQ(step.registration.verdict, Verdict::kNoTexture);
    EXPECT_FALSE(step.new_keyframe);
  }
  const OdometryStep first = drive.Process();
  EXPECT_EQ(first.pose.status, graph::TrackingStatus::kTracking);
  ASSERT_TRUE(first.new_keyframe);
  EXPECT_EQ(first.new_keyframe->id, 0);
  EXPECT_EQ(first.new_keyframe->pose.frame_index, 4);
  EXPECT_EQ(first.pose.T_map_base.x, origin.x);
  EXPECT_EQ(first.pose.T_map_base.y, origin.y);
  EXPECT_EQ(first.pose.T_map_base.yaw, origin.yaw);
  drive.Move(0.1, 5);
  ExpectNear(drive.Process().pose.T_map_base, drive.Truth(), "second");
}

TEST(Odometry, FramesWithoutTextureAreLostAndThenFoundAgain) {
  Drive drive;
  drive.Process();
  for (int i = 0; i < 3; ++i) {
    drive.Move(0.1, 3);
    EXPECT_TRUE(Placed(drive.Process()));
  }
  for (const int grey : {0, 128, 255}) {
    drive.Move(0.1, 3);
    const OdometryStep lost = drive.SeeUniform(grey);
    EXPECT_EQ(lost.pose.status, graph::TrackingStatus::kLost);
    EXPECT_EQ(lost.pose.keyframe_id, -1);
    EXPECT_FALSE(lost.new_keyframe);
    EXPECT_TRUE(lost.new_edges.empty());
  }
  for (int i = 0; i < 4; ++i) {
    drive.Move(0.1, 3);
    const OdometryStep found = drive.Process();
    ASSERT_TRUE(Placed(found)) << i;
    ExpectNear(found.pose.T_map_base, drive.Truth(), "after the gap " + std::to_string(i));
  }
}

/// Of a robot of which nothing is taken for impossible.
OdometryParams Anywhere() {
  OdometryParams params;
  params.uneven_ratio = 100;
  params.uneven_rad = 4;
  return params;
}

TEST(Odometry, CarriedAwayIsLostAndBroughtBackIsRelocalized) {
  Drive drive({0, 0, 0}, Anywhere());
  drive.Process();
  std::vector<Pose2> visited;
  for (int i = 0; i < 16; ++i) {
    drive.Move(0.15, 2);
    ASSERT_TRUE(Placed(drive.Process())) << i;
    visited.push_back(drive.Truth());
  }
  for (int i = 0; i < 3; ++i) {
    drive.Jump({40 + 0.1 * i, -30, 1});
    EXPECT_FALSE(Placed(drive.Process())) << "a place it has never seen";
  }
  // Back over one of the older of the recent keyframes, turned around.
  drive.Jump(visited[6] * Pose2{0.1, 0.05, 2.8});
  const OdometryStep found = drive.Process();
  ASSERT_TRUE(Placed(found));
  ExpectNear(found.pose.T_map_base, drive.Truth(), "relocalized");
  drive.Move(0.1, -2);
  const OdometryStep next = drive.Process();
  ASSERT_TRUE(Placed(next));
  ExpectNear(next.pose.T_map_base, drive.Truth(), "after");
}

TEST(Odometry, AFastFrameIsBridgedByTheLastGoodOne) {
  // From the keyframe less than an eighth is in view, from the frame before about half.
  Drive drive({0.4, -0.3, 0.5}, Anywhere());
  drive.Process();
  drive.Move(0.9, 0);
  const OdometryStep good = drive.Process();
  ASSERT_TRUE(Placed(good));
  drive.Move(1.3, 0);
  const OdometryStep fast = drive.Process();
  ASSERT_TRUE(Placed(fast));
  ExpectNear(fast.pose.T_map_base, drive.Truth(), "fast");
}

TEST(Odometry, AJumpOfTheRobotIsNotAccepted) {
  // Images that a damaged stream shifted as a whole fit without a flaw.
  Drive drive;
  DriveEvenly(drive);
  drive.Move(-0.5, 0);
  for (int i = 1; i < OdometryParams().restart_after; ++i) {
    drive.Move(0.06, 0);
    EXPECT_EQ(drive.Process().pose.status, graph::TrackingStatus::kAmbiguous) << i;
  }
  drive.Move(0.06, 0);
  const OdometryStep anew = drive.Process();
  ASSERT_TRUE(anew.new_keyframe);
  EXPECT_TRUE(anew.new_edges.empty()) << "nothing ties it to the time before";
}

TEST(Odometry, OneFrameThatIsElsewhereCostsOnlyItself) {
  Drive drive;
  DriveEvenly(drive);
  const Pose2 truth = drive.Truth();
  drive.Jump(truth * Pose2{-0.5, 0, 0});
  EXPECT_FALSE(Placed(drive.Process()));
  drive.Jump(truth * Pose2{0.12, 0, 0});
  const OdometryStep after = drive.Process();
  ASSERT_TRUE(Placed(after));
  ExpectNear(after.pose.T_map_base, drive.Truth(), "after");
}

TEST(Odometry, AnUnevenStepHasALargerCovariance) {
  Drive even;
  DriveEvenly(even);
  even.Move(0.06, 0);
  const double usual = even.Process().pose.covariance(0, 0);
  Drive uneven;
  DriveEvenly(uneven);
  uneven.Move(0.06 - 0.08, 0);
  const OdometryStep step = uneven.Process();
  ASSERT_TRUE(Placed(step));
  EXPECT_GT(step.pose.covariance(0, 0), 100 * usual);
  EXPECT_GT(step.pose.covariance(0, 0), 0.08 * 0.08 / 16) << "within four standard deviations";
}

TEST(Odometry, CloseKeepsTheLastPlacedFrame) {
  Drive drive;
  EXPECT_FALSE(drive.Close().new_keyframe) << "nothing seen";
  drive.Process();
  EXPECT_FALSE(drive.Close().new_keyframe) << "the first frame is a keyframe already";
  drive.Move(0.2, 4);
  ASSERT_FALSE(drive.Process().new_keyframe);
  const OdometryStep end = drive.Close();
  ASSERT_TRUE(end.new_keyframe);
  EXPECT_EQ(end.new_keyframe->id, 1);
  EXPECT_EQ(end.new_keyframe->pose.frame_index, 1);
  EXPECT_FALSE(end.new_keyframe->image.empty());
  ExpectNear(end.new_keyframe->pose.T_map_base, drive.Truth(), "last keyframe");
  ASSERT_EQ(end.new_edges.size(), 1U);
  EXPECT_EQ(end.new_edges[0].from, 0);
  EXPECT_EQ(end.new_edges[0].to, 1);
  EXPECT_FALSE(drive.Close().new_keyframe) << "once";
}

TEST(Odometry, WorksInPixelsWithoutARig) {
  const CeilingView view = CeilingView::InPixels({320, 240});
  const SyntheticCeiling ceiling({.tile_px = 70});
  Odometry odometry(view, {});
  Pose2 truth;
  for (int i = 0; i < 8; ++i) {
    const OdometryStep step =
        odometry.Process(ceiling.Render(view.Size(), MotionAt(view, truth)), i, i);
    ASSERT_TRUE(Placed(step)) << i;
    EXPECT_LT((step.pose.T_map_base.Translation() - truth.Translation()).norm(), 0.1);
    EXPECT_LT(std::abs(WrapAngle(step.pose.T_map_base.yaw - truth.yaw)), 0.05 * kRadPerDeg);
    truth = truth * Pose2{25, 3, 0.1};
  }
}

TEST(Odometry, RefusesOtherImages) {
  const CeilingView view = MakeView();
  Odometry odometry(view, {});
  EXPECT_THROW(odometry.Process(cv::Mat::zeros(480, 640, CV_8UC3), 0, 0), InputError);
  EXPECT_THROW(odometry.Process(cv::Mat::zeros(240, 320, CV_8UC1), 0, 0), InputError);
}

TEST(OdometryParams, OutOfRange) {
  const auto message = [](const std::function<void(OdometryParams&)>& change) -> std::string {
    OdometryParams params;
    change(params);
    try {
      params.Validate();
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(message([](OdometryParams&) {}), "");
  EXPECT_EQ(message([](OdometryParams& p) { p.min_overlap = 1; }),
            "odometry: min_overlap = 1, must be in (0, 1)");
  EXPECT_EQ(message([](OdometryParams& p) { p.min_overlap = 0; }),
            "odometry: min_overlap = 0, must be in (0, 1)");
  EXPECT_EQ(message([](OdometryParams& p) { p.recent_keyframes = 0; }),
            "odometry: recent_keyframes = 0, must be at least 1");
  EXPECT_EQ(message([](OdometryParams& p) { p.local_keyframes = 0; }),
            "odometry: local_keyframes = 0, must be at least 1");
  EXPECT_EQ(message([](OdometryParams& p) { p.noise.systematic_px = 0; }),
            "odometry: noise.systematic_px = 0, must be > 0");
  EXPECT_EQ(message([](OdometryParams& p) { p.noise.systematic_rad = -1; }),
            "odometry: noise.systematic_rad = -1, must be > 0");
  OdometryParams bad;
  bad.min_overlap = 2;
  const CeilingView view = MakeView();
  EXPECT_THROW(Odometry(view, {}, bad), InputError);
}

}  // namespace
}  // namespace ceilmap::mapping
