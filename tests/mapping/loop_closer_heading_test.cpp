// Loop closing with a compass, in a hall whose arms look alike after a quarter turn.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "mapping/loop_closer.hpp"
#include "tests/mapping/synthetic_drive.hpp"

namespace ceilmap::mapping {
namespace {

using synthetic::FourArms;
using synthetic::MotionAt;
using synthetic::SyntheticCeiling;

constexpr int kPlaces = 5;  // of an arm

/// A robot that drives along one arm (keyframes 0..4) and again along one (5..9). From one keyframe
/// to the next its odometry is true to millimetres, but of the way between the two drives it knows
/// hardly anything, not even how it turned.
class TwoDrives {
 public:
  TwoDrives(const Pose2& T_first_second, bool compass)
      : closer_(
            view_, [this](std::int64_t id) { return Picture(id); }, ShortGap()) {
    for (int i = 0; i < kPlaces; ++i) truth_.push_back({2.5 + 1.0 * i, 0, 0});
    for (int i = 0; i < kPlaces; ++i) {
      truth_.push_back(T_first_second * Pose2{2.6 + 1.0 * i, 0.1, 0.05});
    }
    for (std::int64_t id = 0; id < 2 * kPlaces; ++id) Show(id, compass);
  }

  [[nodiscard]] LoopCounts Counts() const { return closer_.Counts(); }
  [[nodiscard]] double WorstEdge() const {
    double worst = 0;
    for (const Edge& edge : closer_.Graph().Edges()) {
      const Pose2 off = edge.T_from_to.Inverse() * Between(edge.from, edge.to);
      worst = std::max(worst, off.Translation().norm());
    }
    return worst;
  }

 private:
  static LoopCloserParams ShortGap() {
    LoopCloserParams params;
    params.candidates.looks_gap = 3;
    return params;
  }
  [[nodiscard]] Pose2 Between(std::int64_t from, std::int64_t to) const {
    return truth_[static_cast<std::size_t>(from)].Inverse() * truth_[static_cast<std::size_t>(to)];
  }
  [[nodiscard]] cv::Mat Picture(std::int64_t id) const {
    return ceiling_.Render(view_.Size(),
                           MotionAt(view_, truth_[static_cast<std::size_t>(id)]),
                           1.5,
                           static_cast<std::uint32_t>(id) + 1);
  }
  void Show(std::int64_t id, bool compass) {
    Keyframe keyframe;
    keyframe.id = id;
    keyframe.pose.T_map_base = truth_[static_cast<std::size_t>(id)];
    if (compass) {
      const double yaw = calib::WrapAngle(keyframe.pose.T_map_base.yaw + 2);
      keyframe.pose.heading = {yaw, 1e-6 + 1e-4 * static_cast<double>(id)};
    }
    std::vector<Edge> ties;
    if (id > 0) {
      const bool unknown = id == kPlaces;
      const double sigma = unknown ? 5 : 0.002;
      const double sigma_rad = unknown ? 1.5 : 0.0005;
      Edge tie{id - 1, id, Edge::Kind::kOdometry, Between(id - 1, id), {}};
      tie.information =
          Eigen::Vector3d(1 / (sigma * sigma), 1 / (sigma * sigma), 1 / (sigma_rad * sigma_rad))
              .asDiagonal();
      ties.push_back(tie);
    }
    closer_.Add(keyframe, {}, ties, describer_.Describe(Picture(id)));
    closer_.Close(id);
  }

  SyntheticCeiling ceiling_{FourArms()};
  calib::CeilingView view_ = synthetic::SmallView();
  PlaceDescriber describer_{view_.Size(),
                            view_.MetresPerPixel(),
                            PlaceDescriptorParams::ForCamera(view_.Size(), view_.MetresPerPixel())};
  std::vector<Pose2> truth_;
  LoopCloser closer_;
};

const Pose2 kQuarterTurn{0, 0, std::numbers::pi / 2};

TEST(LoopCloserWithCompass, AnotherArmIsNotTakenForTheSame) {
  const TwoDrives without(kQuarterTurn, false);
  EXPECT_GE(without.Counts().accepted, 2) << "nothing speaks against it";
  EXPECT_GT(without.WorstEdge(), 1);
  const TwoDrives with(kQuarterTurn, true);
  EXPECT_EQ(with.Counts().accepted, 0);
  EXPECT_GE(with.Counts().off_prediction, 2);
}

TEST(LoopCloserWithCompass, TheSameArmIs) {
  const TwoDrives drives({}, true);
  EXPECT_GE(drives.Counts().accepted, 2);
  EXPECT_LT(drives.WorstEdge(), 0.05) << "a few soft spots tell no more";
}

}  // namespace
}  // namespace ceilmap::mapping
