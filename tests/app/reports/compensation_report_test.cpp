#include "app/reports/compensation_report.hpp"

#include <gtest/gtest.h>

#include "app/reports/evaluation_json.hpp"
#include "tests/app/evaluation/debris_drive.hpp"

namespace ceilmap::reports {
namespace {

using namespace evaluation;

TEST(CompensationReport, CentimetresForPeople) {
  const auto result =
      CompareCompensation(Truth(), Estimate(kBefore), Estimate(kAfter, {-3.9, 0.8}), kTruthMap);
  ASSERT_TRUE(result);
  const std::vector<ReportTable> tables = CompensationTables({{"fused", *result}});
  ASSERT_EQ(tables.size(), 2U);
  EXPECT_EQ(FormatPlain(tables[0]) + '\n' + FormatPlain(tables[1]),
            "compensation  along before cm  after  ratio  across before cm  after  ratio  "
            "rmse before cm  after  ratio\n"
            "fused                   20.00   2.00  0.100              5.00   1.00  0.200  "
            "         10.31   1.12  0.108\n"
            "\n"
            "tilt   pitch rmse deg  max    roll rmse deg  max\n"
            "fused           0.050  0.100          0.100  0.200\n");
}

TEST(CompensationReport, MetresInFiles) {
  const auto result =
      CompareCompensation(Truth(), Estimate(kBefore), Estimate(kAfter, {-3.9, 0.8}), kTruthMap);
  ASSERT_TRUE(result);
  EXPECT_EQ(FormatTableCsv({{"a, b", *result}}),
            "estimate,along_before_m,along_m,along_ratio,across_before_m,across_m,across_ratio,"
            "rmse_before_m,rmse_m,rmse_ratio,pitch_rmse_deg,pitch_max_deg,roll_rmse_deg,"
            "roll_max_deg\n"
            "\"a, b\",0.200000000,0.020000000,0.100000,0.050000000,0.010000000,0.200000,"
            "0.103077641,0.011180340,0.108465,0.050000,0.100000,0.100000,0.200000\n");
  const nlohmann::ordered_json json = ToJson(*result);
  EXPECT_NEAR(json["ratio"]["max_along"].get<double>(), 0.1, 1e-12);
  EXPECT_NEAR(json["after"]["max_across_m"].get<double>(), 0.01, 1e-14);
  EXPECT_NEAR(json["tilt_error_deg"]["roll"]["max"].get<double>(), 0.2, 1e-12);
}

TEST(CompensationReport, EmptyFieldsForMissingFrames) {
  Compensation compensation;
  compensation.frames.push_back(
      {2, {0, 2}, {-4, 1}, PlacedError{{0.05, 1.8}, -0.2, -0.05}, {}, {}});
  compensation.frames.push_back(
      {3, {0, 4}, {}, {}, PlacedError{{0, 4.5}, 0.5, 0}, TiltDegrees{0.25, 0}});
  EXPECT_EQ(CompensatedFrameColumns(),
            "along_before_m,across_before_m,along_m,across_m,true_pitch_deg,true_roll_deg,"
            "pitch_deg,roll_deg,true_x,true_y,before_x,before_y,x,y");
  EXPECT_EQ(FormatCompensatedFrame(compensation.frames[0]),
            "-0.200000000,-0.050000000,,,-4.000000,1.000000,,,0.000000000,2.000000000,"
            "0.050000000,1.800000000,,");
  EXPECT_EQ(FormatCompensatedFrame(compensation.frames[1]),
            ",,0.500000000,0.000000000,0.000000,0.000000,0.250000,0.000000,0.000000000,"
            "4.000000000,,,0.000000000,4.500000000");
}

}  // namespace
}  // namespace ceilmap::reports
