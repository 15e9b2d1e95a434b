#include "ceilmap_ros/logic/health.hpp"

#include <gmock/gmock.h>

namespace ceilmap_ros {
namespace {

using Level = Health::Level;
using robot::TrackingStatus;
using testing::Contains;
using testing::Pair;

HealthFacts Good() {
  HealthFacts facts;
  facts.map = "lab.gpkg";
  facts.fix.emplace();
  facts.fix->stamp = 9 * kSecond;
  facts.fix->estimate.status = TrackingStatus::kTracking;
  facts.fix->pose.emplace();
  facts.fix->pose->covariance.diagonal() << 1e-4, 1e-4, 1e-4;
  facts.fix->map_to_odom.emplace();
  facts.fix->odometry = OdometryAnswer::Kind::kKnown;
  facts.processed_at = 9 * kSecond + kSecond / 4;
  return facts;
}

void ExpectVerdict(const HealthFacts& facts, Level level, const std::string& message) {
  const Health health = Judge(facts, 10 * kSecond);
  EXPECT_EQ(health.level, level) << message;
  EXPECT_EQ(health.message, message);
}

TEST(HealthTest, AllIsWell) {
  HealthFacts facts = Good();
  facts.counts.dropped = 7;
  ExpectVerdict(facts, Level::kOk, "tracking");
  const auto values = Judge(facts, 10 * kSecond).values;
  EXPECT_THAT(values, Contains(Pair("map", "lab.gpkg")));
  EXPECT_THAT(values, Contains(Pair("images dropped", "7")));
  EXPECT_THAT(values, Contains(Pair("position sigma (m)", "0.0100")));
  EXPECT_THAT(values, Contains(Pair("yaw sigma (deg)", "0.573")));
  EXPECT_THAT(values, Contains(Pair("age of the image (s)", "0.250")));
}

TEST(HealthTest, TheWorstIsReported) {
  HealthFacts facts = Good();
  facts.fix->estimate.status = TrackingStatus::kPredicted;
  ExpectVerdict(facts, Level::kWarn, "predicted");
  facts.fix->odometry = OdometryAnswer::Kind::kNotYet;
  facts.fix->map_to_odom.reset();
  ExpectVerdict(facts, Level::kWarn, "odometry ends before the image");
  facts.fix->pose.reset();
  facts.fix->estimate.status = TrackingStatus::kLost;
  ExpectVerdict(facts, Level::kWarn, "lost");
  facts.camera_mismatch = "differs";
  ExpectVerdict(facts, Level::kWarn, "differs");
  facts.processed_at = 8 * kSecond - 1;
  ExpectVerdict(facts, Level::kStale, "no images");
  facts.counts.unstamped = 1;
  ExpectVerdict(facts, Level::kError, "images have no stamp; let the camera's driver set it");
  facts.counts.future = 1;
  facts.counts.future_s = 0.25;
  ExpectVerdict(
      facts, Level::kError, "images are 0.250 s in the future; synchronize the camera's clock");
  facts.waits_for_camera = true;
  ExpectVerdict(facts, Level::kWarn, "waiting for camera_info");
  facts.map.clear();
  facts.map_error = "damaged";
  ExpectVerdict(facts, Level::kError, "damaged");
  facts.map_error.clear();
  ExpectVerdict(facts, Level::kError, "no map is loaded; call load_map");
  facts.error = "cropped";
  ExpectVerdict(facts, Level::kError, "cropped");
  facts.end = "saved";
  ExpectVerdict(facts, Level::kError, "saved");
  facts.ended_well = true;
  ExpectVerdict(facts, Level::kOk, "saved");
}

TEST(HealthTest, TheRecordCounts) {
  HealthRecord record;
  record.SetMap("a.gpkg");
  const Fix sure = *Good().fix;
  Fix untransformed = sure;
  untransformed.map_to_odom.reset();
  record.Note(sure, 1);
  record.Note(untransformed, 2);
  record.Note(Fix{}, 3);
  record.Note(std::nullopt, 4);
  const auto values = record.Judge({}, 5).values;
  EXPECT_THAT(values, Contains(Pair("images processed", "3")));
  EXPECT_THAT(values, Contains(Pair("images with a pose", "2")));
  EXPECT_THAT(values, Contains(Pair("poses without odometry", "1")));
  record.NoteError("bad");
  EXPECT_EQ(record.Judge({}, 5).message, "bad");
  record.Note(sure, 6);
  EXPECT_EQ(record.Judge({}, 7).message, "tracking");
}

}  // namespace
}  // namespace ceilmap_ros
