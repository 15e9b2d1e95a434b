// Places that look alike: what one pair of pictures says of a loop, another pair can contradict.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "mapping/loop_closer.hpp"
#include "tests/mapping/synthetic_drive.hpp"

namespace ceilmap::mapping {
namespace {

using synthetic::MotionAt;
using synthetic::SyntheticCeiling;

constexpr int kPlaces = 4;                      // of a room, without a view in common
constexpr std::int64_t kCarried = 2 * kPlaces;  // the keyframe after the robot was carried

/// A robot that drives through room A (keyframes 0..3) and room B (4..7), is then carried to
/// another place (8), and drives through room A again from there (9..12). All it knows from one
/// keyframe to the next is true to a few millimetres, but of the way that it was carried hardly
/// anything.
class CarriedBack {
 public:
  /// @param doubles  so many places of room B, the first ones, look exactly like those of room A.
  explicit CarriedBack(int doubles, const LoopCloserParams& params = ShortGap())
      : closer_(
            view_, [this](std::int64_t id) { return Picture(id); }, params) {
    for (int i = 0; i < kPlaces; ++i) Place({4.0 * i, 0, 0}, {4.0 * i, 0, 0});
    for (int i = 0; i < kPlaces; ++i) {
      const Pose2 T_map_base{4.0 * i, 6, 0};
      Place(T_map_base, i < doubles ? Pose2{4.0 * i, 0, 0} : T_map_base);
    }
    Place({-4, 0, 0}, {-4, 0, 0});
    for (int i = 0; i < kPlaces; ++i) {
      // Not quite where it was the first time.
      const Pose2 T_map_base{4.0 * i + 0.3, -0.2, 0.1};
      Place(T_map_base, T_map_base);
    }
  }

  /// Shows the places in their order, but of the second visit only so many.
  LoopCounts Visit(int again) {
    for (std::int64_t id = 0; id <= kCarried + again; ++id) Show(id);
    return closer_.Counts();
  }

  [[nodiscard]] double WorstClosure() const {
    double worst = 0;
    for (const Edge& edge : closer_.Graph().Edges()) {
      const Pose2 off = edge.T_from_to.Inverse() * Between(edge.from, edge.to);
      worst = std::max(worst, off.Translation().norm());
    }
    return worst;
  }

  /// Every earlier keyframe but the last two may be found again.
  static LoopCloserParams ShortGap() {
    LoopCloserParams params;
    params.candidates.looks_gap = 3;
    return params;
  }

 private:
  void Place(const Pose2& T_map_base, const Pose2& looks) {
    truth_.push_back(T_map_base);
    looks_.push_back(looks);
  }
  [[nodiscard]] Pose2 Between(std::int64_t from, std::int64_t to) const {
    return truth_[static_cast<std::size_t>(from)].Inverse() * truth_[static_cast<std::size_t>(to)];
  }
  [[nodiscard]] cv::Mat Picture(std::int64_t id) const {
    return ceiling_.Render(view_.Size(),
                           MotionAt(view_, looks_[static_cast<std::size_t>(id)]),
                           1.5,
                           static_cast<std::uint32_t>(id) + 1);
  }
  void Show(std::int64_t id) {
    Keyframe keyframe;
    keyframe.id = id;
    keyframe.pose.T_map_base = truth_[static_cast<std::size_t>(id)];
    std::vector<Edge> ties;
    if (id > 0) {
      const bool carried = id == kCarried;
      const double sigma = carried ? 3 : 0.002;
      const double sigma_rad = carried ? 0.1 : 0.0005;
      Edge tie{id - 1, id, Edge::Kind::kOdometry, Between(id - 1, id), {}};
      tie.information =
          Eigen::Vector3d(1 / (sigma * sigma), 1 / (sigma * sigma), 1 / (sigma_rad * sigma_rad))
              .asDiagonal();
      ties.push_back(tie);
    }
    closer_.Add(keyframe, {}, ties, describer_.Describe(Picture(id)));
    closer_.Close(id);
  }

  SyntheticCeiling ceiling_;
  calib::CeilingView view_ = synthetic::SmallView();
  PlaceDescriber describer_{view_.Size(),
                            view_.MetresPerPixel(),
                            PlaceDescriptorParams::ForCamera(view_.Size(), view_.MetresPerPixel())};
  std::vector<Pose2> truth_;
  std::vector<Pose2> looks_;  // where the ceiling looks like what is seen
  LoopCloser closer_;
};

TEST(LoopCloserDoubles, ASecondClosureConfirmsTheFirstWhereNothingContradicts) {
  const LoopCounts one = CarriedBack(0).Visit(1);
  EXPECT_EQ(one.accepted, 0);
  EXPECT_EQ(one.unconfirmed, 1);
  CarriedBack drive(0);
  const LoopCounts two = drive.Visit(2);
  EXPECT_EQ(two.accepted, 2);
  EXPECT_EQ(two.unconfirmed, 0);
  EXPECT_LT(drive.WorstClosure(), 0.01);
}

TEST(LoopCloserDoubles, ARoomThatIsThereTwiceIsNotRecognized) {
  // Each keyframe is found in both rooms; closures to one room contradict those to the other.
  const LoopCounts counts = CarriedBack(kPlaces).Visit(kPlaces);
  EXPECT_EQ(counts.accepted, 0);
  EXPECT_EQ(counts.unconfirmed, 2 * kPlaces);
}

TEST(LoopCloserDoubles, ManyThatAgreeOutweighOneThatDoesNot) {
  // Only the first place has a double: 1 against 1, 2, 3 others.
  const LoopCounts three = CarriedBack(1).Visit(3);
  EXPECT_EQ(three.accepted, 0);
  EXPECT_EQ(three.unconfirmed, 4);
  CarriedBack drive(1);
  const LoopCounts four = drive.Visit(4);
  EXPECT_EQ(four.accepted, 4);
  EXPECT_EQ(four.unconfirmed, 1) << "the one to the wrong room";
  EXPECT_LT(drive.WorstClosure(), 0.01);
}

TEST(LoopCloserDoubles, TheParameterSaysHowMuchContradictionIsBorne) {
  LoopCloserParams params = CarriedBack::ShortGap();
  params.judge.max_contradicting_part = 0.51;
  EXPECT_EQ(CarriedBack(1, params).Visit(2).accepted, 0);
  EXPECT_EQ(CarriedBack(1, params).Visit(3).accepted, 3) << "1 against 2";
  params.judge.max_contradicting_part = 0;
  EXPECT_EQ(CarriedBack(1, params).Visit(4).accepted, 0);
  EXPECT_EQ(CarriedBack(0, params).Visit(2).accepted, 2);
}

TEST(LoopCloserDoubles, AContradictionIsForgottenWithTheClosureThatMadeIt) {
  LoopCloserParams params = CarriedBack::ShortGap();
  params.judge.confirm_within = 2;
  CarriedBack drive(1, params);
  const LoopCounts counts = drive.Visit(4);
  EXPECT_EQ(counts.accepted, 3);
  EXPECT_EQ(counts.unconfirmed, 2) << "both that the first place was found by";
  EXPECT_LT(drive.WorstClosure(), 0.01);
}

}  // namespace
}  // namespace ceilmap::mapping
