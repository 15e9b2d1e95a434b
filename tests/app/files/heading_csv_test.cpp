#include "app/files/heading_csv.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "calib/base/error.hpp"
#include "tests/support/test_folder.hpp"

namespace ceilmap::files {
namespace {

TEST(ReadHeadings, InRadiansInAnyColumnOrder) {
  const support::TestFolder folder;
  folder.Write("h.csv", "confidence,sigma_deg,timestamp,heading_deg\n0.9,2,10,90\n,1,10.5,-180\n");
  const auto samples = ReadHeadings(folder / "h.csv");
  ASSERT_EQ(samples.size(), 2U);
  EXPECT_EQ(samples[0].stamp_s, 10);
  EXPECT_NEAR(samples[0].heading_rad, std::numbers::pi / 2, 1e-12);
  EXPECT_NEAR(samples[0].sigma_rad, std::numbers::pi / 90, 1e-12);
  EXPECT_NEAR(samples[1].heading_rad, -std::numbers::pi, 1e-12);
}

TEST(ReadHeadings, NamesWhatIsWrongAndWhere) {
  const support::TestFolder folder;
  const auto message = [&](const std::string& text) -> std::string {
    folder.Write("h.csv", text);
    try {
      (void)ReadHeadings(folder / "h.csv");
    } catch (const InputError& error) {
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

MeasuredHeading Heading(double stamp_s, double heading_rad, double sigma_rad, double confidence) {
  return {0,
          stamp_s,
          {.heading_rad = heading_rad,
           .variance_rad2 = sigma_rad * sigma_rad,
           .confidence = confidence}};
}

TEST(FormatHeadings, AreReadBackInDegrees) {
  constexpr double kPi = std::numbers::pi;
  const support::TestFolder folder;
  const std::string text = FormatHeadings({Heading(1.5, 0, 0, 1),
                                           Heading(2, -kPi / 2, kPi / 180, 0.25),
                                           Heading(2.5, -kPi + 1e-9, 0.1, 0),
                                           Heading(3, -1e-9, 0.1, 0)},
                                          nullptr);
  EXPECT_EQ(text,
            "timestamp,heading_deg,sigma_deg,confidence\n"
            "1.500000,0.00000,0.00100,1.0000\n"
            "2.000000,-90.00000,1.00000,0.2500\n"
            "2.500000,180.00000,5.72958,0.0000\n"
            "3.000000,0.00000,5.72958,0.0000\n");
  folder.Write("h.csv", text);
  const auto samples = ReadHeadings(folder / "h.csv");
  ASSERT_EQ(samples.size(), 4U);
  EXPECT_NEAR(samples[1].heading_rad, -kPi / 2, 1e-7);
}

TEST(FormatHeadings, WithErrorsWhereThereIsATruth) {
  evaluation::HeadingErrors errors;
  errors.of = {{.heading = 1, .true_deg = 355, .error_deg = 2.5}};
  EXPECT_EQ(FormatHeadings({Heading(1, 0, 0.1, 1), Heading(2, 0, 0.1, 1)}, &errors),
            "timestamp,heading_deg,sigma_deg,confidence,true_heading_deg,error_deg\n"
            "1.000000,0.00000,5.72958,1.0000,,\n"
            "2.000000,0.00000,5.72958,1.0000,-5.00000,2.50000\n");
}

}  // namespace
}  // namespace ceilmap::files
