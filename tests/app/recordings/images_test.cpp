#include "app/recordings/images.hpp"

#include <algorithm>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <optional>

#include "tests/support/test_folder.hpp"

namespace ceilmap::recordings {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;

std::vector<std::string> NamesOf(const std::vector<fs::path>& files) {
  std::vector<std::string> names;
  names.reserve(files.size());
  for (const fs::path& file : files) names.push_back(file.filename().string());
  return names;
}

TEST(NaturalLess, CountsAsPeopleDo) {
  std::vector<std::string> names = {
      "b1", "a10", "a9", "a", "a9b", "a010", "a09", "A1", "a1.2", "a1.10"};
  std::sort(names.begin(), names.end(), NaturalLess);
  EXPECT_THAT(names,
              ElementsAre("A1", "a", "a1.2", "a1.10", "a09", "a9", "a9b", "a010", "a10", "b1"));
}

TEST(NaturalLess, TakesNumbersBeyondAnyIntegerType) {
  EXPECT_TRUE(NaturalLess("f99999999999999999999998", "f99999999999999999999999"));
  EXPECT_TRUE(NaturalLess("f00000000000000000000000000002", "f10"));
  EXPECT_FALSE(NaturalLess("f1", "f1"));
  EXPECT_TRUE(NaturalLess("f0", "f00") != NaturalLess("f00", "f0"));
}

TEST(ListFolder, TakesImagesOnlyInNaturalOrder) {
  const support::TestFolder folder;
  for (const char* name : {"f10.png", "f9.PNG", "f1.jpeg", "notes.txt", ".hidden.png", "png"}) {
    folder.Write(name, "x");
  }
  fs::create_directory(folder / "folder.png");
  EXPECT_THAT(NamesOf(ListFolder(folder.Path())), ElementsAre("f1.jpeg", "f9.PNG", "f10.png"));
}

TEST(ListFolder, RefusesAFolderWithoutImages) {
  const support::TestFolder folder;
  folder.Write("notes.txt", "x");
  support::ExpectInputError([&] { ListFolder(folder.Path()); }, {"holds no images"});
}

TEST(IsPattern, RecognisesPrintfNumbers) {
  for (const char* name : {"f%d.png", "f%04d.png", "%3d", "/a/b/f%06d_x.jpg"}) {
    EXPECT_TRUE(IsPattern(name)) << name;
  }
  for (const char* name : {"f.png", "f%s.png", "f%d%d.png", "100%.png", "/a%d/b.png", "f%1000d"}) {
    EXPECT_FALSE(IsPattern(name)) << name;
  }
}

TEST(ListPattern, StartsAtTheFirstThatExists) {
  const support::TestFolder folder;
  for (const char* name :
       {"f0003.png", "f0004.png", "f0007.png", "f12345.png", "f5.png", "g0001.png"}) {
    folder.Write(name, "x");
  }
  const PatternImages images = ListPattern(folder / "f%04d.png");
  EXPECT_THAT(NamesOf(images.files),
              ElementsAre("f0003.png", "f0004.png", "f0007.png", "f12345.png"));
  EXPECT_EQ(images.missing, 12345U - 3 + 1 - 4);
  EXPECT_THAT(NamesOf(ListPattern(folder / "f%d.png").files), ElementsAre("f5.png", "f12345.png"));
  support::ExpectInputError([&] { ListPattern(folder / "h%d.png"); }, {"h%d.png", "no file"});
  support::ExpectInputError([&] { ListPattern(folder / "none/h%d.png"); }, {"no file"});
}

TEST(ToGrey, ConvertsEveryUsualKind) {
  cv::Mat grey;
  ToGrey(cv::Mat(2, 3, CV_8UC1, cv::Scalar(77)), grey, "x");
  EXPECT_EQ(grey.at<uchar>(1, 2), 77);
  ToGrey(cv::Mat(2, 3, CV_16UC1, cv::Scalar(65535)), grey, "x");
  EXPECT_EQ(grey.type(), CV_8UC1);
  EXPECT_EQ(grey.at<uchar>(1, 2), 255);
  ToGrey(cv::Mat(2, 3, CV_16UC3, cv::Scalar::all(257 * 100)), grey, "x");
  EXPECT_EQ(grey.at<uchar>(1, 2), 100);
  // 0.114 B + 0.587 G + 0.299 R
  ToGrey(cv::Mat(2, 3, CV_8UC3, cv::Scalar(0, 200, 0)), grey, "x");
  EXPECT_EQ(grey.at<uchar>(1, 2), 117);
  ToGrey(cv::Mat(2, 3, CV_8UC4, cv::Scalar(0, 0, 200, 0)), grey, "x");
  EXPECT_EQ(grey.at<uchar>(1, 2), 60);
  support::ExpectInputError(
      [&] { ToGrey(cv::Mat(2, 3, CV_32FC1, cv::Scalar(1)), grey, "deep.tif"); },
      {"deep.tif", "CV_32FC1"});
}

TEST(ConvertTo, ColourOfEveryUsualKind) {
  cv::Mat colour;
  const auto convert = [&](const cv::Mat& image) {
    ConvertTo(Pixels::kColour, image, colour, "x");
    EXPECT_EQ(colour.type(), CV_8UC3);
    EXPECT_NE(colour.data, image.data);
    return colour.at<cv::Vec3b>(1, 2);
  };
  EXPECT_EQ(convert(cv::Mat(2, 3, CV_8UC1, cv::Scalar(77))), cv::Vec3b(77, 77, 77));
  EXPECT_EQ(convert(cv::Mat(2, 3, CV_16UC1, cv::Scalar(65535))), cv::Vec3b(255, 255, 255));
  EXPECT_EQ(convert(cv::Mat(2, 3, CV_8UC3, cv::Scalar(1, 2, 3))), cv::Vec3b(1, 2, 3));
  EXPECT_EQ(convert(cv::Mat(2, 3, CV_16UC3, cv::Scalar(257, 514, 771))), cv::Vec3b(1, 2, 3));
  EXPECT_EQ(convert(cv::Mat(2, 3, CV_8UC4, cv::Scalar(1, 2, 3, 4))), cv::Vec3b(1, 2, 3));
  support::ExpectInputError([&] { convert(cv::Mat(2, 3, CV_32FC1, cv::Scalar(1))); },
                            {"x: ", "CV_32FC1"});
}

TEST(ToGrey, NeverSharesMemoryWithTheImage) {
  const cv::Mat image(2, 3, CV_8UC1, cv::Scalar(1));
  cv::Mat grey;
  ToGrey(image, grey, "x");
  EXPECT_NE(grey.data, image.data);
}

TEST(ReadGreyImage, RefusesWhatIsNone) {
  const support::TestFolder folder;
  support::ExpectInputError([&] { ReadGreyImage(folder / "none.png"); },
                            {"none.png", "no such file"});
  support::ExpectInputError([&] { ReadGreyImage(folder.Write("t.png", "hello")); },
                            {"t.png", "image"});
  support::ExpectInputError([&] { ReadGreyImage(folder.Path()); }, {"not an image"});
}

TEST(ReadGreyImage, RefusesAnAbsurdSizeInTheHeader) {
  const support::TestFolder folder;
  support::ExpectInputError(
      [&] { ReadGreyImage(folder.Write("huge.pgm", "P5 2000000000 2000000000 255\n")); },
      {"huge.pgm"});
}

TEST(ReadGreyImage, ReadsBackWhatWasWritten) {
  const support::TestFolder folder;
  cv::Mat image(5, 7, CV_16UC1, cv::Scalar(257 * 12));
  cv::imwrite((folder / "p.png").string(), image);
  const cv::Mat grey = ReadGreyImage(folder / "p.png");
  EXPECT_EQ(grey.size(), cv::Size(7, 5));
  EXPECT_EQ(grey.type(), CV_8UC1);
  EXPECT_EQ(grey.at<uchar>(4, 6), 12);
}

// A JPEG file with an EXIF orientation (TIFF 6.0, tag 274).
void WriteOriented(const fs::path& file, const cv::Mat& image, char orientation) {
  std::vector<uchar> code;
  cv::imencode(".jpg", image, code, {cv::IMWRITE_JPEG_QUALITY, 100});
  std::string exif = {'\xFF', '\xE1', 0, 34, 'E', 'x', 'i', 'f', 0, 0};  // APP1 of 34 bytes
  exif += {'M', 'M', 0, 42, 0, 0, 0, 8, 0, 1};                           // one entry
  exif += {1, 18, 0, 3, 0, 0, 0, 1, 0, orientation, 0, 0, 0, 0, 0, 0};   // a short
  std::string bytes(code.begin(), code.end());
  bytes.insert(2, exif);
  std::ofstream(file, std::ios::binary) << bytes;
}

TEST(ReadImage, TurnsByTheExifOrientation) {
  const support::TestFolder folder;
  cv::Mat stored(32, 48, CV_8UC1);
  for (int u = 0; u < stored.cols; ++u) stored.col(u) = 4 * u + 20;
  stored.rowRange(0, 8) = 250;
  cv::Mat transposed;
  cv::transpose(stored, transposed);
  struct Case {
    char orientation;
    const cv::Mat& image;
    std::optional<int> flip;
  };
  const std::vector<Case> cases = {{1, stored, {}},
                                   {2, stored, 1},
                                   {3, stored, -1},
                                   {4, stored, 0},
                                   {5, transposed, {}},
                                   {6, transposed, 1},
                                   {7, transposed, -1},
                                   {8, transposed, 0}};
  for (const auto& [orientation, image, flip] : cases) {
    WriteOriented(folder / "p.jpg", stored, orientation);
    cv::Mat expected = image.clone();
    if (flip) cv::flip(image, expected, *flip);
    for (const Pixels pixels : {Pixels::kGrey, Pixels::kColour}) {
      cv::Mat read = ReadImage(folder / "p.jpg", pixels);
      ASSERT_EQ(read.size(), expected.size()) << int{orientation};
      if (pixels == Pixels::kColour) cv::extractChannel(read, read, 0);
      EXPECT_LE(cv::norm(read, expected, cv::NORM_INF), 3) << int{orientation};
    }
  }
}

TEST(ConvertTo, TakesImagesOfASizeThatCamerasHave) {
  cv::Mat result;
  ConvertTo(Pixels::kGrey, cv::Mat(1, 16384, CV_8UC1, cv::Scalar(7)), result, "p.png");
  EXPECT_EQ(result.cols, 16384);
  support::ExpectInputError(
      [&] { ConvertTo(Pixels::kGrey, cv::Mat(16385, 1, CV_8UC1), result, "p.png"); },
      {"p.png: an image of 1x16385 px, must have at most 16384 on a side"});
}

}  // namespace
}  // namespace ceilmap::recordings
