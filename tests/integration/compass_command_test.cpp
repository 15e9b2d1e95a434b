// `ceilmap compass` through the real program, on robots that turn on the spot among colours.

#include <fmt/format.h>

#include <cmath>
#include <csignal>
#include <nlohmann/json.hpp>
#include <numeric>

#include "app/figures/gnuplot.hpp"
#include "app/files/csv.hpp"
#include "app/files/heading_csv.hpp"
#include "calib/base/degrees.hpp"
#include "calib/base/pose2.hpp"
#include "localization/compass/colour/colour_model_file.hpp"
#include "tests/integration/colour_recordings.hpp"
#include "tests/integration/endless_stream.hpp"

namespace ceilmap::integration {
namespace {

using support::ReadAll;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::UnorderedElementsAre;

constexpr double kLargestMeanRad = 0.05;

class CompassTest : public CompassCommand {
 protected:
  [[nodiscard]] nlohmann::json SummaryOf(const std::string& file) const {
    return nlohmann::json::parse(ReadAll(out_ / file));
  }
  /// Mean absolute error of the headings of a turn; their zero is that of the learned poses.
  [[nodiscard]] double MeanErrorRad(const std::string& file, const Turn& turn) const {
    const auto headings = files::ReadHeadings(out_ / file);
    EXPECT_EQ(headings.size(), static_cast<std::size_t>(turn.frames));
    double sum = 0;
    for (std::size_t i = 0; i < headings.size(); ++i) {
      const int frame = static_cast<int>(i);
      EXPECT_NEAR(headings[i].stamp_s, turn.Stamp(frame), 1e-6);
      sum += std::abs(WrapAngle(headings[i].heading_rad - turn.YawRad(frame)));
    }
    return sum / static_cast<double>(headings.size());
  }
  /// Asks a model about kAgain. @return the mean error, rad.
  [[nodiscard]] double AskAgain(const std::string& model,
                                const std::vector<std::string>& more = {}) const {
    std::vector<std::string> options = {"-o", "h.csv", "--summary=s.json", "--force"};
    options.insert(options.end(), more.begin(), more.end());
    const support::ProcessResult result = Run(Of({"query", model}, "again", options));
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(result.err, "");
    return MeanErrorRad("h.csv", kAgain);
  }
};

TEST_F(CompassTest, FindsTheHeadingInASecondTurn) {
  const support::ProcessResult learned =
      Run(Of({"learn"}, "learn", {"--poses=@learn.tum", "-o", "m", "--summary=l.json"}));
  EXPECT_EQ(learned.exit_code, 0) << learned.err;
  EXPECT_EQ(learned.err, "");
  EXPECT_THAT(learned.out, ContainsRegex("learned +90\n"));
  for (const char* text : {"of 15 seen from", "100.0", "written m"}) {
    EXPECT_THAT(learned.out, HasSubstr(text));
  }
  EXPECT_THAT(out_.Names(), UnorderedElementsAre("m", "l.json"));
  const auto summary = SummaryOf("l.json");
  EXPECT_EQ(summary["command"], "compass learn");
  EXPECT_EQ(summary["frames"], kLearn.frames);
  EXPECT_EQ(summary["quality"]["used"], kLearn.frames);
  EXPECT_EQ(summary["quality"]["model"]["bins_filled"], 180);
  EXPECT_EQ(summary["quality"]["model"]["frames"], kLearn.frames);
  EXPECT_THAT(colour::ReadColourModel(out_ / "m").provenance, HasSubstr("ceilmap compass learn"));

  EXPECT_LT(AskAgain("m"), kLargestMeanRad);
  EXPECT_THAT(ReadAll(out_ / "h.csv"),
              testing::StartsWith("timestamp,heading_deg,sigma_deg,confidence\n2000.000000,"));
}

TEST_F(CompassTest, ErrorsAgainstTheTruthAreAbsolute) {
  Learn("m");
  const support::ProcessResult result =
      Run(Of({"query", "m"}, "again", {"--truth=@again.tum", "-o", "h.csv", "--summary=s.json"}));
  EXPECT_EQ(result.exit_code, 0) << result.err;
  for (const char* text : {"mean error", "max error", "small errors", "frames/s"}) {
    EXPECT_THAT(result.out, HasSubstr(text));
  }
  const auto quality = SummaryOf("s.json")["quality"];
  EXPECT_NEAR(quality["errors"]["mean_rad"].get<double>(), MeanErrorRad("h.csv", kAgain), 1e-5);
  EXPECT_GT(quality["errors"]["below_0_1_rad"].get<double>(), 0.9);
  EXPECT_GT(quality["mean_sigma_deg"].get<double>(), 0);
  const files::CsvTable table = files::ReadCsv(out_ / "h.csv");
  const auto& first = table.rows.front().fields;
  EXPECT_NEAR(std::stod(first[table.Column("true_heading_deg")]), kAgain.first_deg, 1e-3);
  // Against a truth that is turned, all is wrong by that turn.
  in_.Write("turned.tum", kAgain.Poses(30));
  ASSERT_EQ(Run(Of({"query", "m"},
                   "again",
                   {"--truth=@turned.tum", "-o", "h.csv", "--summary=s.json", "--force"}))
                .exit_code,
            0);
  EXPECT_NEAR(SummaryOf("s.json")["quality"]["errors"]["signed_mean_deg"].get<double>(), -30, 5);
}

TEST_F(CompassTest, WithEveryKindOfModel) {
  for (const std::vector<std::string>& options :
       {std::vector<std::string>{"--method=sturm", "--clustering=mixture"},
        {"--method=victoria", "--clustering=mixture", "--classes=6"},
        {"--method=sturm", "--bins=90", "--lines=16", "--depth=5"},
        {"--method=victoria-2013"},
        {"--grid=0,0,2,1,2,1", "--fading=60", "--seed=5"}}) {
    Learn("m", options);
    EXPECT_LT(AskAgain("m"), kLargestMeanRad) << options.front();
  }
}

// As 'localize --hypotheses' writes them.
TEST_F(CompassTest, AtOneOfSeveralPlaces) {
  Learn("m", {"--grid=-3,-2,6,4,5,3"});
  std::string one = "timestamp,x,y,yaw_deg,weight\n";
  std::string two = one;
  for (int i = 0; i < kAgain.frames; ++i) {
    one += fmt::format("{},1,0.5,0,1\n", kAgain.Stamp(i));
    two += fmt::format("{0},1,0.5,0,0.6\n{0},0.7,0.2,0,0.4\n", kAgain.Stamp(i));
  }
  in_.Write("one.csv", one);
  in_.Write("two.csv", two);
  in_.Write("late.csv", "timestamp,x,y,yaw_deg,weight\n1,0,0,0,1\n");
  EXPECT_LT(AskAgain("m", {"--poses=@again.tum"}), kLargestMeanRad);
  const std::string by_poses = ReadAll(out_ / "h.csv");
  EXPECT_LT(AskAgain("m", {"--hypotheses=@one.csv"}), kLargestMeanRad);
  EXPECT_EQ(ReadAll(out_ / "h.csv"), by_poses);
  EXPECT_GE(AskAgain("m", {"--hypotheses=@two.csv"}), 0);
  EXPECT_NE(ReadAll(out_ / "h.csv"), by_poses);
  EXPECT_LT(AskAgain("m", {"--hypotheses=@two.csv", "--method=victoria-2013"}), kLargestMeanRad);
  const support::ProcessResult late =
      Run(Of({"query", "m"}, "again", {"--hypotheses=@late.csv", "-o", "no.csv"}));
  EXPECT_EQ(late.exit_code, 2);
  EXPECT_THAT(late.err, HasSubstr("late.csv: no pose within"));
}

// Two places in other cells, the likelier one that of the turn; its first frame has a pose.
TEST_F(CompassTest, LearnsWhereTheRobotMayBe) {
  std::string places = "timestamp,x,y,yaw_deg,weight\n";
  for (int i = 1; i < kLearn.frames; ++i) {
    places += fmt::format("{0},1,0.5,{1},0.6\n{0},-2.5,0.5,{1},0.4\n",
                          kLearn.Stamp(i),
                          kLearn.first_deg + kLearn.step_deg * i);
  }
  in_.Write("first.tum",
            files::FormatTum({ToStampedPose(kLearn.Stamp(0), {1, 0.5, kLearn.YawRad(0)}, {})}));
  in_.Write("places.csv", places);
  const support::ProcessResult learned = Run(Of({"learn"},
                                                "learn",
                                                {"--method=victoria-2013",
                                                 "--grid=-3,-2,6,4,5,3",
                                                 "--poses=@first.tum",
                                                 "--hypotheses=@places.csv",
                                                 "-o",
                                                 "m"}));
  EXPECT_EQ(learned.exit_code, 0) << learned.err;
  EXPECT_EQ(learned.err, "") << "each frame has a pose or places";
  const colour::ColourModel model = colour::ReadColourModel(out_ / "m");
  double most = 0;
  double sum = 0;
  for (const colour::AngleBin& bin : model.cells[model.grid.CellOf({1, 0.5})].bins) {
    most = std::max(most, bin.certainty);
    sum += bin.certainty;
  }
  EXPECT_GT(most, 0.9) << "of the pose";
  EXPECT_NEAR(sum / model.bins, 0.6, 0.1) << "the share of its cell";
  EXPECT_LT(AskAgain("m"), kLargestMeanRad);
}

TEST_F(CompassTest, WhiteBalanceIsMeasuredOnTheRecording) {
  Learn("m");
  EXPECT_LT(AskAgain("m", {"--white-balance"}), kLargestMeanRad);
  const auto gains = SummaryOf("s.json")["quality"]["gains_bgr"];
  ASSERT_EQ(gains.size(), 3U);
  for (const auto& gain : gains) EXPECT_NEAR(gain.get<double>(), 1, 0.05) << "the same camera";
}

TEST_F(CompassTest, ByTheQueryOfThePaper) {
  Learn("m");
  EXPECT_LT(AskAgain("m", {"--method=victoria-2013", "--poses=@again.tum"}), kLargestMeanRad);
  EXPECT_LT(AskAgain("m", {"--method=victoria-2013", "--previous=none"}), kLargestMeanRad);
  Learn("m", {"--method=victoria-2013"});
  EXPECT_LT(AskAgain("m", {"--method=bayes"}), kLargestMeanRad);
  const auto refused = [&](const std::vector<std::string>& options, const char* what) {
    std::vector<std::string> all = options;
    all.insert(all.end(), {"-o", "no.csv"});
    const support::ProcessResult result = Run(Of({"query", "m"}, "again", all));
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_THAT(result.err, HasSubstr(what));
  };
  refused({"--no-parallax"}, "victoria-2013 has no parallax");
  refused({"--method=bayes", "--previous=none"}, "option of --method victoria-2013");
  Learn("m", {"--method=sturm"});
  refused({"--method=victoria-2013"}, "needs a grid");
}

TEST_F(CompassTest, PlacesAreUsedAndTheirYawIsNot) {
  Learn("m");
  in_.Write("turned.tum", kAgain.Poses(77));
  EXPECT_LT(AskAgain("m", {"--poses=@turned.tum"}), kLargestMeanRad);
  EXPECT_LT(AskAgain("m", {"--poses=@again.tum", "--no-parallax"}), kLargestMeanRad);
}

// One robot has learned a half of what is around, another the rest: an update fills the model, and
// so does a merge.
TEST_F(CompassTest, UpdateAndMergeFillAModel) {
  const Turn half{46, 0, 4, 1000};
  const Turn rest{46, 180, 4, 1500};
  const Turn asked{24, 235, 2.5, 2000};  // without a view of that half
  Record("half", half);
  Record("rest", rest);
  Record("asked", asked);
  const auto ask = [&](const char* model) {
    const support::ProcessResult result =
        Run(Of({"query", model}, "asked", {"-o", "h.csv", "--force"}));
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return MeanErrorRad("h.csv", asked);
  };
  const auto learn = Run(Of({"learn"}, "half", {"--poses=@half.tum", "-o", "half"}));
  ASSERT_EQ(learn.exit_code, 0) << learn.err;
  EXPECT_GT(ask("half"), kLargestMeanRad);

  const std::string before = ReadAll(out_ / "half");
  const support::ProcessResult updated =
      Run(Of({"update", "half"}, "rest", {"--poses=@rest.tum", "-o", "both"}));
  EXPECT_EQ(updated.exit_code, 0) << updated.err;
  EXPECT_THAT(updated.out, HasSubstr("written both"));
  EXPECT_EQ(ReadAll(out_ / "half"), before);
  EXPECT_LT(ask("both"), kLargestMeanRad);
  const colour::ColourModel both = colour::ReadColourModel(out_ / "both");
  EXPECT_EQ(both.frames, half.frames + rest.frames);
  EXPECT_THAT(both.provenance, HasSubstr("compass learn"));
  EXPECT_THAT(both.provenance, HasSubstr("\nceilmap compass update"));

  const support::ProcessResult merged =
      Run({"merge", "half", "both", "-o", "all", "--summary=s.json"});
  EXPECT_EQ(merged.exit_code, 0) << merged.err;
  EXPECT_THAT(merged.out, HasSubstr("written all"));
  EXPECT_EQ(SummaryOf("s.json")["command"], "compass merge");
  EXPECT_LT(ask("all"), kLargestMeanRad);

  // Without -o the model itself is the result.
  ASSERT_EQ(Run(Of({"update", "half"}, "rest", {"--poses=@rest.tum", "--quiet"})).exit_code, 0);
  EXPECT_LT(ask("half"), kLargestMeanRad);
}

TEST_F(CompassTest, LearnsWhileItIsAsked) {
  Learn("m");
  EXPECT_LT(AskAgain("m", {"--poses=@again.tum", "--update", "--save=m2"}), kLargestMeanRad);
  const auto learned = SummaryOf("s.json")["quality"]["learned"].get<int>();
  EXPECT_GT(learned, kAgain.frames / 2);
  EXPECT_EQ(colour::ReadColourModel(out_ / "m2").frames, kLearn.frames + learned);
  EXPECT_LT(AskAgain("m2"), kLargestMeanRad);
}

TEST_F(CompassTest, FramesThatCannotBeUsedAreCounted) {
  // Nose down by 20 deg in the second half: most of these images is below the horizon.
  in_.Write("down.tum", kLearn.Poses(0, 20));
  const support::ProcessResult tilted =
      Run(Of({"learn"}, "learn", {"--poses=@down.tum", "-o", "m", "--summary=s.json"}));
  EXPECT_EQ(tilted.exit_code, 0) << tilted.err;
  EXPECT_EQ(tilted.err,
            "ceilmap: warning: 45 of 90 frames were skipped: too small a part of them is above the "
            "horizon\n");
  EXPECT_THAT(tilted.out, HasSubstr("skipped"));
  EXPECT_EQ(SummaryOf("s.json")["quality"]["below_horizon"], 45);
  // Poses of the first frames only.
  in_.Write("short.tum", Turn{40, 0, 4, 1000}.Poses());
  const support::ProcessResult few =
      Run(Of({"learn"}, "learn", {"--poses=@short.tum", "-o", "m", "--summary=s.json", "--force"}));
  EXPECT_EQ(few.exit_code, 0) << few.err;
  EXPECT_EQ(few.err, "ceilmap: warning: 50 of 90 frames have no pose within 0.05 s\n");
  EXPECT_EQ(SummaryOf("s.json")["quality"]["used"], 40);
  // A question about such frames has fewer answers.
  Learn("m");
  in_.Write("bow.tum", kAgain.Poses(0, 20));
  const support::ProcessResult asked =
      Run(Of({"query", "m"}, "again", {"--poses=@bow.tum", "-o", "h.csv"}));
  EXPECT_EQ(asked.exit_code, 0) << asked.err;
  EXPECT_EQ(files::ReadHeadings(out_ / "h.csv").size(), 36U);
  EXPECT_EQ(asked.err,
            "ceilmap: warning: 36 of 72 frames were skipped: too small a part of them is above the "
            "horizon\n");
}

// Colours of another order are other colours: all that is left is what is light and dark. The
// compass may use that or not, but it must not accept a wrong heading.
TEST_F(CompassTest, HasLowConfidenceForColoursInAnotherOrder) {
  Learn("m");
  ASSERT_LT(AskAgain("m"), kLargestMeanRad);
  const double usual_deg = SummaryOf("s.json")["quality"]["mean_sigma_deg"].get<double>();
  std::vector<cv::Mat> swapped = kAgain.Images(world_);
  for (cv::Mat& image : swapped) cv::cvtColor(image, image, cv::COLOR_BGR2RGB);
  WriteColourVideo(in_ / "swapped.avi", swapped);
  in_.Write("swapped.csv", kAgain.Stamps());
  const support::ProcessResult result =
      Run(Of({"query", "m"}, "swapped", {"-o", "h.csv", "--summary=s.json", "--force"}));
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_GT(SummaryOf("s.json")["quality"]["mean_sigma_deg"].get<double>(), 3 * usual_deg);
  const auto headings = files::ReadHeadings(out_ / "h.csv");
  for (std::size_t i = 0; i < headings.size(); ++i) {
    if (headings[i].sigma_rad > 3 * kRadPerDeg) continue;
    const double true_rad = kAgain.YawRad(static_cast<int>(i));
    EXPECT_LT(std::abs(WrapAngle(headings[i].heading_rad - true_rad)), 10 * kRadPerDeg) << i;
  }
}

TEST_F(CompassTest, Plots) {
  if (!figures::FindGnuplot()) GTEST_SKIP() << "gnuplot is not installed";
  Learn("m");
  EXPECT_EQ(Run(Of({"query", "m"},
                   "again",
                   {"--truth=@again.tum", "--plot=figures", "-o", "h.csv", "--quiet"}))
                .exit_code,
            0);
  EXPECT_THAT(support::NamesIn(out_ / "figures"),
              UnorderedElementsAre(
                  "heading.csv", "heading.gp", "heading.pdf", "heading.png", "heading.svg"));
}

TEST_F(CompassTest, ALiveQuestionEndsWithWhatItHas) {
  Learn("m");
  // A program that does not even open the pipe would leave its writer waiting.
  ASSERT_LT(AskAgain("m"), kLargestMeanRad);
  const EndlessStream stream(in_ / "pipe.mjpeg", kAgain.Images(world_));
  support::ChildProcess child(Resolve({CEILMAP_EXE,
                                       "compass",
                                       "query",
                                       "m",
                                       "--rig=@rig.yaml",
                                       "--forward=@pipe.mjpeg",
                                       "-o",
                                       "h.csv",
                                       "--force",
                                       "--verbose"}),
                              out_.Path());
  EXPECT_TRUE(child.WaitForErr("frame 20 at"));
  child.Send(SIGINT);
  const support::ProcessResult result = child.Wait();
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(out_.Names(), UnorderedElementsAre("m", "h.csv", "s.json"));
  const std::size_t kept = files::ReadHeadings(out_ / "h.csv").size();
  EXPECT_GE(kept, 21U);
  EXPECT_THAT(result.err, HasSubstr(fmt::format("interrupted: {} frames were used", kept)));
}

TEST_F(CompassTest, LearningEndsWithWhatItHas) {
  Learn("m");
  const EndlessStream stream(in_ / "pipe.mjpeg", kLearn.Images(world_));
  // A pose at any time: the robot stands still, as far as that matters here.
  std::vector<StampedPose> poses;
  for (int i = 0; i < 3000; ++i) poses.push_back(ToStampedPose(0.04 * i, {1, 0.5, 0}));
  in_.Write("still.tum", files::FormatTum(poses));
  support::ChildProcess child(Resolve({CEILMAP_EXE,
                                       "compass",
                                       "learn",
                                       "--rig=@rig.yaml",
                                       "--forward=@pipe.mjpeg",
                                       "--poses=@still.tum",
                                       "-o",
                                       "m",
                                       "--force",
                                       "--verbose"}),
                              out_.Path());
  EXPECT_TRUE(child.WaitForErr("frame 20 at"));
  child.Send(SIGINT);
  const support::ProcessResult result = child.Wait();
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("interrupted: "));
  EXPECT_GE(colour::ReadColourModel(out_ / "m").frames, 21);
}

}  // namespace
}  // namespace ceilmap::integration
