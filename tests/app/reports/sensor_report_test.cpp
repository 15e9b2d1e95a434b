#include "app/reports/sensor_report.hpp"

#include "tests/support/synthetic_recording.hpp"
#include "tests/support/test_folder.hpp"

namespace ceilmap::reports {
namespace {

using compensation::TiltMethod;
using compensation::TiltReport;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// A run with a forward camera of 8 upward frames.
class SensorReportTest : public testing::Test {
 protected:
  SensorReportTest() {
    support::WriteImages(folder_ / "forward",
                         std::vector<cv::Mat>(3, cv::Mat(64, 96, CV_8UC1, cv::Scalar(9))));
    recordings::SensorFiles files;
    files.forward = (folder_ / "forward").string();
    files.tilt = TiltMethod::kFused;
    std::optional<calib::Rig> rig(std::in_place);
    rig->forward.emplace();
    rig->forward->camera = {96, 64, 80, 80, 47.5, 31.5, {}};
    inputs_.emplace(files, rig);
    result_.inputs = &*inputs_;
    result_.report.tilt_method = TiltMethod::kFused;
    TiltReport tilt;
    tilt.frames = 8;
    tilt.level = 4;
    tilt.by_forward = 6;
    tilt.largest_rad = 0.05;
    result_.report.tilt = tilt;
    result_.report.forward.matched = 8;
  }

  support::TestFolder folder_;
  std::optional<recordings::SensorInputs> inputs_;
  SensorResult result_;
};

TEST_F(SensorReportTest, ACameraOfAnotherSizeIsScaledInTheRig) {
  EXPECT_THAT(inputs_->Scalings(), IsEmpty());
  recordings::SensorFiles files;
  files.forward = (folder_ / "forward").string();
  files.tilt = TiltMethod::kForward;
  std::optional<calib::Rig> rig(std::in_place);
  rig->forward.emplace();
  rig->forward->camera = {192, 128, 160, 160, 95.5, 63.5, {}};
  const recordings::SensorInputs inputs(files, rig);
  ASSERT_EQ(inputs.Scalings().size(), 1U);
  EXPECT_EQ(inputs.Scalings().front().camera, "forward");
  EXPECT_EQ(rig->forward->camera.Matrix(), cv::Matx33d(80, 0, 47.5, 0, 80, 31.5, 0, 0, 1));
}

TEST_F(SensorReportTest, ASoundRunHasNoWarnings) {
  result_.report.tilt->by_forward = 8;
  EXPECT_THAT(Warnings(result_), IsEmpty());
}

TEST_F(SensorReportTest, WarnsOfFramesWithoutMeasurement) {
  result_.report.forward.missing = 2;
  result_.report.forward.matched = 6;
  result_.report.tilt->without_forward = 2;
  result_.report.tilt->by_forward = 5;
  result_.report.tilt->unknown = 5;
  EXPECT_THAT(
      Warnings(result_),
      ElementsAre(HasSubstr("2 of 8 upward frames have no forward frame at their time"),
                  HasSubstr("1 of 6 forward frames show no tilt (covered, dark, bare or crowded)"),
                  "the tilt of 5 frames is only a prediction: it was not measured"));
}

TEST_F(SensorReportTest, SummarizesTiltAndHeadings) {
  robot::HeadingReport heading;
  heading.sensor = robot::HeadingSensor::kColours;
  heading.headings = 8;
  heading.uncertain = 5;
  result_.report.heading = heading;
  terminal::Summary summary;
  Summarize(result_, summary);
  EXPECT_EQ(summary.quality["tilt"]["method"], "fused");
  EXPECT_EQ(summary.quality["tilt"]["tilted"], 4);
  EXPECT_EQ(summary.quality["heading"]["by"], "colours");
  EXPECT_EQ(summary.quality["heading"]["unsure"], 5);
  EXPECT_TRUE(summary.stages_ms.contains("tilt_forward"));
  EXPECT_TRUE(summary.stages_ms.contains("decode_forward"));
  EXPECT_FALSE(summary.stages_ms.contains("decode_omni"));
  EXPECT_THAT(Warnings(result_), testing::Contains(HasSubstr("5 of 8 forward images")));
  terminal::Table table;
  AddRows(result_, table);
  EXPECT_THAT(table.Format(), HasSubstr("by up to 2.86 deg; measured by fused"));
}

}  // namespace
}  // namespace ceilmap::reports
