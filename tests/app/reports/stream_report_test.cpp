#include "app/reports/stream_report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace ceilmap::reports {
namespace {

using testing::ElementsAre;

recordings::FrameSourceReport LiveReport() {
  recordings::FrameSourceReport reading;
  reading.live = true;
  reading.decoded = 200;
  reading.dropped = 3;
  reading.missing = 5;
  reading.outages = {.count = 2, .seconds = 3.25};
  return reading;
}

LatencyMeter Latencies() {
  LatencyMeter latency;
  for (int i = 0; i < 90; ++i) latency.Add(12.2);
  for (int i = 0; i < 8; ++i) latency.Add(40);
  latency.Add(100);
  latency.Add(123.4);
  return latency;
}

TEST(LatencyMeter, QuantilesAndMaximum) {
  const LatencyMeter latency = Latencies();
  EXPECT_EQ(latency.Quantile(0.5), 12);
  EXPECT_EQ(latency.Quantile(0.9), 12);
  EXPECT_EQ(latency.Quantile(0.95), 40);
  EXPECT_EQ(latency.Quantile(1), 123);
  EXPECT_EQ(latency.MaxMs(), 123.4);
  EXPECT_EQ(latency.Late(), 1);
}

TEST(LatencyMeter, WithoutFramesAndBeyondTheScale) {
  LatencyMeter latency;
  EXPECT_EQ(latency.Quantile(0.5), 0);
  latency.Add(-1);
  EXPECT_EQ(latency.Quantile(0.5), 0);
  latency.Add(60000);
  EXPECT_EQ(latency.Quantile(1), 10000);
  EXPECT_EQ(latency.MaxMs(), 60000);
}

TEST(StreamReport, OfALiveSource) {
  EXPECT_EQ(
      StreamJson(LiveReport(), Latencies()).dump(),
      R"({"received":200,"dropped":3,"missing":5,"late":1,"late_ms":100.0,)"
      R"("latency_ms":{"median":12.0,"p95":40.0,"max":123.4},"reconnects":2,"outage_s":3.25})");
  terminal::Table table;
  AddStreamRows(LiveReport(), Latencies(), table);
  EXPECT_THAT(
      table.Rows(),
      ElementsAre(ElementsAre("received", "200", "frames of the live source"),
                  ElementsAre("dropped", "3", "1.5 %, for lack of time"),
                  ElementsAre("missing", "5", "did not arrive, by gaps in their times"),
                  ElementsAre("late", "1", "more than 100 ms from arrival to pose"),
                  ElementsAre("latency", "12", "ms, median; 95 % within 40, at the most 123"),
                  ElementsAre("reconnected", "2", "after 3.2 s without frames")));
}

TEST(StreamReport, WithoutTimesNothingIsKnownToBeMissing) {
  recordings::FrameSourceReport reading = LiveReport();
  reading.missing.reset();
  EXPECT_TRUE(StreamJson(reading, {})["missing"].is_null());
}

TEST(StreamReport, OfARecordingThereIsNone) {
  EXPECT_TRUE(StreamJson({}, {}).is_null());
  terminal::Table table;
  AddStreamRows({}, {}, table);
  EXPECT_TRUE(table.Rows().empty());
}

}  // namespace
}  // namespace ceilmap::reports
