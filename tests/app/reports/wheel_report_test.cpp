#include "app/reports/wheel_report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace ceilmap::reports {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using wheels::WheelsReport;

std::vector<std::vector<std::string>> RowsOf(const WheelsReport& wheels) {
  terminal::Table table;
  AddWheelRows(wheels, "the ceiling", table);
  return table.Rows();
}

TEST(WheelReport, WhatTheDriveDidNotShowIsLeftOut) {
  EXPECT_THAT(RowsOf({}), IsEmpty());
  WheelsReport wheels;
  wheels.samples = 100;
  EXPECT_THAT(RowsOf(wheels), IsEmpty());
}

TEST(WheelReport, AStuckGyroIsNamedWhereTheWheelsStoodIn) {
  WheelsReport wheels;
  wheels.gyro = true;
  wheels.gyro_stuck_s = 3.25;
  EXPECT_THAT(RowsOf(wheels), IsEmpty()) << "nothing stood in for it";
  wheels.samples = 100;
  EXPECT_THAT(
      RowsOf(wheels),
      ElementsAre(ElementsAre(
          "gyro stuck", "3.2", "s with one value exactly; there the wheels gave the turn")));
  EXPECT_EQ(WheelQuality(wheels)["gyro_stuck_s"], 3.25);
}

TEST(WheelReport, SlipsAreCounted) {
  WheelsReport wheels;
  wheels.samples = 100;
  wheels.pieces = 40;
  wheels.slips = 3;
  EXPECT_THAT(
      RowsOf(wheels),
      ElementsAre(ElementsAre("slips", "3", "of 40 pieces of the way contradict the ceiling")));
}

}  // namespace
}  // namespace ceilmap::reports
