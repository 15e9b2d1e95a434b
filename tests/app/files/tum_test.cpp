#include "app/files/tum.hpp"

#include <cmath>
#include <numbers>

#include "tests/support/test_folder.hpp"

namespace ceilmap::files {
namespace {

TEST(Tum, RoundTripKeepsPosesAndUnitQuaternions) {
  const support::TestFolder folder;
  std::vector<StampedPose> poses;
  for (int i = 0; i < 100; ++i) {
    StampedPose pose;
    pose.stamp_s = 1.7e9 + 0.1 * i;
    pose.position = {0.1 * i, -0.37 * i, 1e-6 * i};
    pose.orientation = Eigen::AngleAxisd(0.3 * i, Eigen::Vector3d::UnitZ()) *
                       Eigen::AngleAxisd(0.02 * i, Eigen::Vector3d::UnitY()) *
                       Eigen::AngleAxisd(-0.01 * i, Eigen::Vector3d::UnitX());
    poses.push_back(pose);
  }
  const auto read = ReadTum(folder.Write("t.tum", FormatTum(poses)));
  ASSERT_EQ(read.size(), poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    EXPECT_NEAR(read[i].stamp_s, poses[i].stamp_s, 6e-7);
    EXPECT_LT((read[i].position - poses[i].position).norm(), 1e-9);
    EXPECT_NEAR(read[i].orientation.norm(), 1, 1e-9);
    EXPECT_LT(read[i].orientation.angularDistance(poses[i].orientation), 1e-9);
  }
}

TEST(ReadTum, SkipsComments) {
  const support::TestFolder folder;
  const auto poses =
      ReadTum(folder.Write("t.tum", "# head\n\n1 0 0 0 0 0 0 1 # tail\n 2 1 0 0 0 0 1 0\r\n"));
  ASSERT_EQ(poses.size(), 2U);
  EXPECT_EQ(poses[1].position.x(), 1);
  EXPECT_NEAR(std::abs(YawOf(poses[1])), std::numbers::pi, 1e-15);
}

TEST(ReadTum, NamesEachFault) {
  const support::TestFolder folder;
  const auto expect = [&folder](const std::string& text, const std::vector<std::string>& parts) {
    SCOPED_TRACE(text);
    support::ExpectInputError([&] { ReadTum(folder.Write("t.tum", text)); }, parts);
  };
  expect("", {"t.tum", "no poses"});
  expect("# only a comment\n", {"no poses"});
  expect("1 0 0 0 0 0 0\n", {"t.tum:1", "7 fields"});
  expect("1 0 0 0 0 0 0 1 0\n", {"t.tum:1", "9 fields"});
  expect("1 0 0 0 0 0 0 1\n2 nan 0 0 0 0 0 1\n", {"t.tum:2", "'nan'"});
  expect("1 0 x 0 0 0 0 1\n", {"t.tum:1", "'x'"});
  expect("1 0 0 0 0 0 0 0\n", {"t.tum:1", "quaternion"});
  expect("1 0 0 0 0 0 0.1 1\n", {"t.tum:1", "quaternion"});
  expect("1 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n", {"t.tum:2", "not later"});
  support::ExpectInputError([&] { ReadTum(folder / "none.tum"); }, {"none.tum", "no such file"});
}

}  // namespace
}  // namespace ceilmap::files
