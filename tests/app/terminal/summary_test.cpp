#include "app/terminal/summary.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace ceilmap::terminal {
namespace {

TEST(Summary, IsOneJsonObject) {
  Summary summary;
  summary.frames = 30;
  summary.stages_ms["decode"] = 12.5;
  summary.quality["peak"] = std::numeric_limits<double>::quiet_NaN();
  summary.files = {"a.gpkg"};
  const auto json = nlohmann::json::parse(summary.ToJson("map", 2));
  EXPECT_EQ(json["command"], "map");
  EXPECT_EQ(json["version"], CEILMAP_VERSION);
  EXPECT_EQ(json["frames"], 30);
  EXPECT_EQ(json["seconds"], 2);
  EXPECT_EQ(json["frames_per_second"], 15);
  EXPECT_EQ(json["interrupted"], false);
  EXPECT_EQ(json["stages_ms"]["decode"], 12.5);
  EXPECT_TRUE(json["quality"]["peak"].is_null());
  EXPECT_EQ(json["files"], nlohmann::json({"a.gpkg"}));
}

}  // namespace
}  // namespace ceilmap::terminal
