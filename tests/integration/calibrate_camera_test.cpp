// `ceilmap calibrate camera` on painted boards: what it writes, and the one line that it ends with
// where images or arguments are of no use.

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "app/figures/gnuplot.hpp"
#include "calib/camera_info.hpp"
#include "tests/calib/solve/painted_board.hpp"
#include "tests/support/child_process.hpp"
#include "tests/support/synthetic_recording.hpp"
#include "tests/support/test_folder.hpp"

namespace ceilmap::integration {
namespace {

namespace fs = std::filesystem;
using calib::Lens;
using calibration::Board;
using calibration::BoardPainter;
using calibration::BoardPose;
using support::ReadAll;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

Board Chessboard(int columns = 9) {
  Board board;
  board.columns = columns;
  board.square_m = 0.025;
  return board;
}

Board Charuco() {
  Board board = Chessboard();
  board.kind = calibration::BoardKind::kCharuco;
  board.marker_m = 0.018;
  return board;
}

// Recordings of a camera that is known, painted once for all tests.
class Recordings {
 public:
  Recordings() {
    const Lens lens = calibration::TestLens();
    const std::vector<BoardPose> poses = GoodPoses(Chessboard(), lens);
    const BoardPainter painter(Chessboard(), lens);
    const std::vector<cv::Mat> good = PaintAll(painter, poses);
    support::WriteImages(folder_ / "good", good);
    support::WriteImages(folder_ / "one", {good[0]});
    support::WriteImages(folder_ / "similar", {good[1], good[1], good[1], good[1]});
    support::WriteImages(folder_ / "grey",
                         std::vector<cv::Mat>(3, cv::Mat(360, 480, CV_8U, cv::Scalar(90))));
    support::WriteImages(folder_ / "sizes", {good[0], good[1].colRange(0, 400).clone()});
    support::WriteImages(folder_ / "blurred", Changed(good, [](const cv::Mat& from, cv::Mat& to) {
                           cv::GaussianBlur(from, to, {}, 5);
                         }));
    WriteLevel(painter, lens);
    WriteVideo(painter, poses);
    const std::vector<BoardPose> few(poses.begin(), poses.begin() + 4);
    support::WriteImages(folder_ / "other", PaintAll(BoardPainter(Chessboard(8), lens), few));
    const std::vector<cv::Mat> charuco = PaintAll(BoardPainter(Charuco(), lens), poses);
    support::WriteImages(folder_ / "charuco", charuco);
    support::WriteImages(
        folder_ / "mirrored",
        Changed(charuco, [](const cv::Mat& from, cv::Mat& to) { cv::flip(from, to, 1); }));
    fs::create_directory(folder_ / "empty");
    folder_.Write("text.mp4", "this is no video\n");
    folder_.Write("text.png", "this is no image\n");
  }
  [[nodiscard]] const fs::path& Path() const { return folder_.Path(); }

 private:
  static std::vector<cv::Mat> PaintAll(const BoardPainter& painter,
                                       const std::vector<BoardPose>& poses) {
    std::vector<cv::Mat> images;
    for (const BoardPose& pose : poses) images.push_back(painter.Paint(pose));
    return images;
  }
  template <typename Change>
  static std::vector<cv::Mat> Changed(const std::vector<cv::Mat>& images, const Change& change) {
    std::vector<cv::Mat> changed(images.size());
    for (std::size_t i = 0; i < images.size(); ++i) change(images[i], changed[i]);
    return changed;
  }
  void WriteLevel(const BoardPainter& painter, const Lens& lens) const {
    std::vector<BoardPose> poses;
    for (const double x : {0.3, 0.5, 0.7}) {
      poses.push_back(PoseAt(Chessboard(), lens, {x, 0.5}, 0, 0, 0, 0.5));
      poses.push_back(PoseAt(Chessboard(), lens, {x, 0.4}, 0, 0, 0.1, 0.45));
    }
    support::WriteImages(folder_ / "level", PaintAll(painter, poses));
  }
  // Each view three times, the second as a camera that moves would show it.
  void WriteVideo(const BoardPainter& painter, const std::vector<BoardPose>& poses) const {
    std::vector<cv::Mat> frames;
    for (const BoardPose& pose : poses) {
      const cv::Mat image = painter.Paint(pose);
      cv::Mat moved;
      cv::blur(image, moved, {41, 1});
      frames.insert(frames.end(), {image, moved, image});
    }
    support::WriteVideo(folder_ / "walk.avi", frames, 10);
  }

  support::TestFolder folder_;
};

class CalibrateCamera : public testing::Test {
 protected:
  static const Recordings& Inputs() {
    static const Recordings recordings;
    return recordings;
  }
  // `@NAME` in an argument stands for NAME among the inputs.
  support::ProcessResult Run(std::vector<std::string> arguments) const {
    for (std::string& argument : arguments) {
      const std::size_t at = argument.find('@');
      if (at != std::string::npos) argument.replace(at, 1, Inputs().Path().string() + "/");
    }
    arguments.insert(arguments.begin(), {"calibrate", "camera"});
    return support::RunCeilmap(arguments, out_.Path().string());
  }
  void ExpectTestLens(const std::string& file, double focal_ratio, double centre_px) const {
    const Lens lens = calibration::TestLens();
    const Lens camera = calib::ReadCameraInfo(out_ / file);
    EXPECT_EQ(camera.Size(), lens.Size());
    EXPECT_NEAR(camera.fx / lens.fx, 1, focal_ratio);
    EXPECT_NEAR(camera.fy / lens.fy, 1, focal_ratio);
    EXPECT_NEAR(camera.cx, lens.cx, centre_px);
    EXPECT_NEAR(camera.cy, lens.cy, centre_px);
    EXPECT_NEAR(camera.distortion[0], lens.distortion[0], 0.02);
  }
  support::TestFolder out_;
};

const std::vector<std::string> kBoard = {"--corners=9x6", "--square=0.025"};

std::vector<std::string> With(std::vector<std::string> a, const std::vector<std::string>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

TEST_F(CalibrateCamera, WritesACameraThatIsReadBack) {
  const auto result =
      Run(With(kBoard, {"@good", "-o", "up.yaml", "--name=up", "--summary=s.json"}));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  EXPECT_THAT(result.out, HasSubstr("15 with a chessboard of 9x6 corners, 15 used"));
  EXPECT_THAT(result.out, HasSubstr("not estimated: it does not differ from 0 significantly"));
  ExpectTestLens("up.yaml", 0.002, 0.6);
  EXPECT_THAT(ReadAll(out_ / "up.yaml"), HasSubstr("camera_name: \"up\"\n"));
  const auto summary = nlohmann::json::parse(ReadAll(out_ / "s.json"));
  EXPECT_EQ(summary["command"], "calibrate camera");
  EXPECT_EQ(summary["frames"], 15);
  const auto& quality = summary["quality"];
  EXPECT_LT(quality["rms_px"], 0.1);
  EXPECT_EQ(quality["views"].size(), 15U);
  EXPECT_GT(quality["coverage"], 0.5);
  EXPECT_GT(quality["sigmas"]["fx"], 0);
  EXPECT_LT(quality["sigmas"]["fx"], 1);
}

TEST_F(CalibrateCamera, TheSameImagesGiveTheSameCamera) {
  ASSERT_EQ(Run(With(kBoard, {"@good", "-o", "a.yaml", "--quiet"})).exit_code, 0);
  const auto again = Run(With(kBoard, {"@good", "-o", "b.yaml", "--quiet"}));
  EXPECT_EQ(again.out + again.err, "");
  EXPECT_EQ(ReadAll(out_ / "a.yaml"), ReadAll(out_ / "b.yaml"));
}

TEST_F(CalibrateCamera, TakesImagesByName) {
  std::vector<std::string> arguments = kBoard;
  for (const int i : {0, 1, 2, 3, 4, 5, 8, 9}) {
    arguments.push_back((Inputs().Path() / "good" /
                         support::NamesIn(Inputs().Path() / "good")[static_cast<std::size_t>(i)])
                            .string());
  }
  const auto result = Run(With(arguments, {"-o", "up.yaml"}));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("8 with a chessboard of 9x6 corners, 8 used"));
}

TEST_F(CalibrateCamera, ChoosesViewsOfAVideo) {
  const auto result = Run(With(kBoard, {"@walk.avi", "-o", "up.yaml", "--views=12", "--verbose"}));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr(" 12 used"));
  EXPECT_THAT(result.out,
              testing::ContainsRegex("left out +[0-9]+  less informative than the others"));
  EXPECT_THAT(result.out, testing::ContainsRegex("frame [0-9]+ +less informative than the others"));
  ExpectTestLens("up.yaml", 0.004, 1);
}

TEST_F(CalibrateCamera, CharucoBoards) {
  const auto result =
      Run(With(kBoard, {"@charuco", "-o", "up.yaml", "--board=charuco", "--marker=0.018"}));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  ExpectTestLens("up.yaml", 0.003, 1);
}

TEST_F(CalibrateCamera, WritesAReport) {
  const auto result =
      Run(With(kBoard, {"@good", "-o", "up.yaml", "--report=report", "--name=<up>"}));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto names = support::NamesIn(out_ / "report");
  for (const char* name : {"after.jpg", "before.jpg", "index.html", "metrics.json", "tables.md"}) {
    EXPECT_THAT(names, testing::Contains(name));
  }
  EXPECT_THAT(ReadAll(out_ / "report" / "index.html"), HasSubstr("Camera &lt;up&gt;"));
  EXPECT_EQ(cv::imread((out_ / "report" / "after.jpg").string()).size(), cv::Size(480, 360));
  if (!figures::FindGnuplot()) return;
  for (const char* name : {"coverage.svg", "residuals.png", "views.pdf"}) {
    EXPECT_GT(fs::file_size(out_ / "report" / "figures" / name), 1000U) << name;
  }
}

TEST_F(CalibrateCamera, OtherModelsAreReadBack) {
  const auto result = Run(With(kBoard, {"@good", "-o", "up.yaml", "--model=equidistant"}));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Lens lens = calib::ReadCameraInfo(out_ / "up.yaml");
  EXPECT_EQ(lens.model, calib::LensModel::kEquidistant);
  EXPECT_NEAR(lens.fx / calibration::TestLens().fx, 1, 0.1);
}

TEST_F(CalibrateCamera, PrintsBoards) {
  ASSERT_EQ(Run(With(kBoard, {"--print-board=b.svg"})).exit_code, 0);
  ASSERT_EQ(Run(With(kBoard, {"--print-board=b.pdf", "--paper=letter"})).exit_code, 0);
  EXPECT_THAT(ReadAll(out_ / "b.svg"), testing::StartsWith("<svg "));
  EXPECT_THAT(ReadAll(out_ / "b.pdf"), testing::StartsWith("%PDF-"));
}

struct BadCalibration {
  std::string name;
  std::vector<std::string> arguments;
  std::string message;  // part of it
};

std::ostream& operator<<(std::ostream& stream, const BadCalibration& input) {
  return stream << input.name;
}

class BadCalibrationTest : public CalibrateCamera,
                           public testing::WithParamInterface<BadCalibration> {};

TEST_P(BadCalibrationTest, IsOneLineAndLeavesNothing) {
  std::vector<std::string> arguments = GetParam().arguments;
  const auto has = [&](const char* option) {
    return std::any_of(arguments.begin(), arguments.end(), [&](const std::string& argument) {
      return argument.starts_with(option);
    });
  };
  if (!has("--corners")) arguments.emplace_back("--corners=9x6");
  if (!has("--square")) arguments.emplace_back("--square=0.025");
  if (!has("--print")) arguments.insert(arguments.end(), {"-o", "up.yaml"});
  const support::ProcessResult result = Run(arguments);
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  EXPECT_THAT(result.err, testing::StartsWith("ceilmap: "));
  EXPECT_THAT(result.err, HasSubstr(GetParam().message));
  EXPECT_EQ(result.out, "");
  EXPECT_THAT(out_.Names(), IsEmpty());
}

const std::vector<std::string> kCharuco = {"--board=charuco", "--marker=0.018"};

const std::vector<BadCalibration> kBadCalibrations = {
    {"NoSource", {}, "no images; give a folder of images, a video, or several images"},
    {"EmptyFolder", {"@empty"}, "empty: holds no images"},
    {"NoSuchFile", {"@none.mp4"}, "none.mp4: no such file"},
    {"NotAVideo", {"@text.mp4"}, "text.mp4: is not a video"},
    {"NotAnImage", {"@text.png"}, "text.png: is not an image"},
    {"NoBoard", {"@grey"}, "grey: no chessboard of 9x6 corners in any of 3 images; is it whole"},
    {"SmallerBoard",
     {"@other"},
     "other: the images show a chessboard of 8x6 corners, not 9x6; give 8x6 corners"},
    {"LargerBoard",
     {"@good", "--corners=8x5"},
     "good: the images show a chessboard of 9x6 corners, not 8x5; give 9x6 corners"},
    {"Mirrored",
     With(kCharuco, {"@mirrored"}),
     "mirrored: the board appears mirrored, by a mirror"},
    {"NoMarkers", With(kCharuco, {"@good"}), "good: the images show a chessboard of 9x6 corners"},
    {"OtherMarkers",
     With(kCharuco, {"@charuco", "--corners=5x8"}),
     "there are markers of 4x4_50 but no ChArUco board of 5x8 corners; check the counts of "
     "corners"},
    {"Blurred", {"@blurred"}, "blurred: the board is blurred in all of 15 images; hold it still"},
    {"OneView", {"@one"}, "one: 1 of 1 images shows the board sharp and whole, at least 3"},
    {"AlikeViews",
     {"@similar"},
     "similar: the 4 views of the board are too similar (1 different one), at least 3 are needed; "
     "show"},
    {"LevelViews", {"@level"}, "level: no view with the board tilted by more than"},
    {"SizesDiffer",
     {"@sizes"},
     "is 400x360 px, those before it 480x360; calibrate with images of one size"},
    {"NoSize", {"@good", "--corners=9"}, "--corners 9: must be COLUMNSxROWS of inner corners"},
    {"FewCorners", {"@good", "--corners=9x2"}, "--corners 9x2: each count must be 3 to 60"},
    {"NoSquare", {"@good", "--square=0"}, "--square 0: must be the side of a square in metres"},
    {"LargeMarker",
     {"@good", "--board=charuco", "--marker=0.03"},
     "--marker 0.03: must be the side"},
    {"FewMarkers",
     With(kCharuco, {"@good", "--corners=12x9"}),
     "--dictionary 4x4_50: has 50 markers, the board needs 65"},
    {"NoDictionary",
     With(kCharuco, {"@good", "--dictionary=3x3"}),
     "--dictionary 3x3: must be 4x4"},
    {"NoKind", {"@good", "--board=circles"}, "--board circles: must be chessboard or charuco"},
    {"NoModel", {"@good", "--model=ftheta"}, "--model ftheta: must be plumb_bob, rational"},
    {"FewViews", {"@good", "--views=2"}, "--views 2: must be at least 3"},
    {"NotOnPaper",
     {"--square=0.05", "--print-board=b.pdf"},
     "does not fit on a4; take squares of at most"},
    {"NoPaper", {"--print-board=b.pdf", "--paper=b5"}, "--paper b5: must be a4, a3 or letter"},
    {"NoFormat", {"--print-board=b.png"}, "--print-board b.png: must end in .pdf or .svg"},
    {"PrintAndCalibrate", {"@good", "--print-board=b.pdf"}, "print the board first"},
};

INSTANTIATE_TEST_SUITE_P(Inputs,
                         BadCalibrationTest,
                         testing::ValuesIn(kBadCalibrations),
                         [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace ceilmap::integration
