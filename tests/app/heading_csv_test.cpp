#include "app/heading_csv.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "calib/error.hpp"
#include "tests/app/test_folder.hpp"

namespace ceilmap::app {
namespace {

TEST(ReadHeadings, InRadiansInAnyColumnOrder) {
  const TestFolder folder;
  folder.Write("h.csv", "confidence,sigma_deg,timestamp,heading_deg\n0.9,2,10,90\n,1,10.5,-180\n");
  const auto samples = ReadHeadings(folder / "h.csv");
  ASSERT_EQ(samples.size(), 2U);
  EXPECT_EQ(samples[0].stamp_s, 10);
  EXPECT_NEAR(samples[0].heading_rad, std::numbers::pi / 2, 1e-12);
  EXPECT_NEAR(samples[0].sigma_rad, std::numbers::pi / 90, 1e-12);
  EXPECT_NEAR(samples[1].heading_rad, -std::numbers::pi, 1e-12);
}

TEST(ReadHeadings, NamesWhatIsWrongAndWhere) {
  const TestFolder folder;
  const auto message = [&](const std::string& text) -> std::string {
    folder.Write("h.csv", text);
    try {
      (void)ReadHeadings(folder / "h.csv");
    } catch (const calib::InputError& error) {
      return error.what();
    }
    return "";
  };
  const std::string header = "timestamp,heading_deg,sigma_deg\n";
  EXPECT_THAT(message(header), testing::HasSubstr("no headings"));
  EXPECT_THAT(message(header + "1,x,1\n"), testing::HasSubstr("h.csv:2: heading_deg 'x'"));
  EXPECT_THAT(message(header + "1,1,1\n1,1,1\n"), testing::HasSubstr("h.csv:3"));
  EXPECT_THAT(message(header + "1,1,-1\n"), testing::HasSubstr("sigma_deg must be > 0"));
  EXPECT_THAT(message("timestamp,heading_deg\n1,1\n"), testing::HasSubstr("'sigma_deg'"));
  EXPECT_EQ(message(header + "1,1,1\n"), "");
}

}  // namespace
}  // namespace ceilmap::app
