// Frames of a ceiling with depth on their way into the map.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "mapping/mapper.hpp"
#include "tests/mapping/depth_drive.hpp"
#include "tests/mapping/map_files.hpp"

namespace ceilmap::mapping {
namespace {

TEST(MapperDepth, FramesThatWerePlacedTakeTheScaleThatLaterOnesFind) {
  // Most of the image hangs below the plane, so that the first frames follow the strips.
  const registration::synthetic::SyntheticDepth ceiling(1.35, 0.62);
  const calib::CeilingView view = synthetic::CentredView();
  const support::TempFolder folder;
  store::MapWriter writer(folder / "map.gpkg", synthetic::MetadataOf(view));
  MapperParams params;
  params.odometry = synthetic::DepthParams(view);
  Mapper mapper(view, writer, synthetic::MetadataOf(view), params);
  constexpr int kFrames = 14;
  const auto true_x = [](std::int64_t frame) { return 0.005 * static_cast<double>(frame * frame); };
  double first_error = 0;
  for (int i = 0; i < kFrames; ++i) {
    const cv::Mat image = synthetic::DepthImage(ceiling, view, {true_x(i), 0, 0}, i);
    const graph::FramePose pose = mapper.Process(image, i, 0.1 * i);
    ASSERT_EQ(pose.status, graph::TrackingStatus::kTracking) << i;
    if (i > 1) first_error = std::max(first_error, std::abs(pose.T_map_base.x / true_x(i) - 1));
  }
  EXPECT_GT(first_error, 0.12);
  ASSERT_EQ(mapper.Trajectory().size(), static_cast<std::size_t>(kFrames));
  for (const graph::FramePose& frame : mapper.Trajectory()) {
    const double x = true_x(frame.frame_index);
    constexpr double kPixel = 0.005;
    EXPECT_NEAR(frame.T_map_base.x, x, std::max(0.06 * x, 0.2 * kPixel)) << frame.frame_index;
  }
}

}  // namespace
}  // namespace ceilmap::mapping
