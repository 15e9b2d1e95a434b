#include "app/files/control_points_csv.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calib/base/error.hpp"

namespace ceilmap::files {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

TEST(ControlPointsCsv, ReadsPlacesInTheMap) {
  const PickedPoints picked = ParseControlPoints(
      "name,x,y,site_x,site_y,sigma_m\n\"column A, 1\",1.5,-2,691000.25,5335000.5,0.004\n"
      "B,3,4,5,6,\n",
      "p.csv");
  ASSERT_EQ(picked.points.size(), 2U);
  EXPECT_FALSE(picked.in_pixels);
  EXPECT_EQ(picked.points[0].name, "column A, 1");
  EXPECT_EQ(picked.points[0].p_map, Eigen::Vector2d(1.5, -2));
  EXPECT_EQ(picked.points[0].p_site, Eigen::Vector2d(691000.25, 5335000.5));
  EXPECT_EQ(picked.points[0].sigma_m, 0.004);
  EXPECT_EQ(picked.points[1].sigma_m, 0);
}

TEST(ControlPointsCsv, ReadsPixels) {
  const PickedPoints picked =
      ParseControlPoints("name,col,row,site_x,site_y\nA,100,200,5,6\n", "p.csv");
  EXPECT_TRUE(picked.in_pixels);
  EXPECT_EQ(picked.points[0].p_map, Eigen::Vector2d(100, 200));
}

TEST(ControlPointsCsv, NamesFileLineAndCause) {
  const auto parse = [](const char* text) {
    return [text] { (void)ParseControlPoints(text, "p.csv"); };
  };
  EXPECT_THAT(parse("name,x,y,site_x,site_y\nA,1,b,3,4\n"),
              ThrowsMessage<InputError>(HasSubstr("p.csv:2")));
  EXPECT_THAT(parse("name,x,y,site_x,site_y\n,1,2,3,4\n"),
              ThrowsMessage<InputError>(HasSubstr("p.csv:2: the point has no name")));
  EXPECT_THAT(parse("name,x,y,site_x,site_y,sigma_m\nA,1,2,3,4,-1\n"),
              ThrowsMessage<InputError>(HasSubstr("sigma_m = -1")));
  EXPECT_THAT(parse("name,x,y,col,row,site_x,site_y\nA,1,2,3,4,5,6\n"),
              ThrowsMessage<InputError>(HasSubstr("not both")));
  EXPECT_THAT(parse("name,x,y,east,north\nA,1,2,3,4\n"),
              ThrowsMessage<InputError>(HasSubstr("site_x")));
  EXPECT_THAT(parse("name,x,y,site_x,site_y\n"), ThrowsMessage<InputError>(HasSubstr("no points")));
}

}  // namespace
}  // namespace ceilmap::files
