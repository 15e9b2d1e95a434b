#include "mapping/change/view_comparison.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <opencv2/imgproc.hpp>

#include "tests/mapping/store/synthetic_map.hpp"
#include "tests/support/temp_folder.hpp"

namespace ceilmap::change {
namespace {

constexpr double kResolution = 0.01;
const store::MosaicGrid kMosaic{-2, 3, kResolution, 480, 400};
const cv::Size kComparedView{256, 192};
// Upper left corner of what the image shows, a corner of cells; the image has its rows along +y.
const cv::Point kComparedCorner{6 * kCellPx, 5 * kCellPx};

/// Textured, without lamps.
cv::Mat Ceiling() {
  cv::Mat ceiling(kMosaic.height_px, kMosaic.width_px, CV_32FC1);
  cv::RNG random(5);
  random.fill(ceiling, cv::RNG::NORMAL, 0, 40);
  cv::GaussianBlur(ceiling, ceiling, {}, 1.5);
  cv::Mat grey;
  ceiling.convertTo(grey, CV_8UC1, 1, 120);
  return grey;
}

/// A tube that is lit, narrower than a cell.
void DrawTube(cv::Mat& ceiling, int row) {
  cv::rectangle(ceiling, cv::Rect(200, row, 90, 4), cv::Scalar(255), cv::FILLED);
}

class ViewComparisonTest : public testing::Test {
 protected:
  /// The map of a ceiling.
  void Map(const cv::Mat& ceiling) {
    store::synthetic::SmallMap map;
    for (graph::Keyframe& keyframe : map.keyframes) keyframe.heights.reset();
    const auto file = folder_ / "map.gpkg";
    store::MapWriter writer(file, map.metadata);
    for (const graph::Keyframe& keyframe : map.keyframes) {
      writer.AddImage(keyframe.id, store::synthetic::Image(keyframe.id, map.metadata.view_size));
    }
    writer.WriteGraph(map.Graph());
    writer.WriteMosaic(kMosaic, [&](const cv::Rect& window, cv::Mat& grey, cv::Mat& alpha) {
      ceiling(window).copyTo(grey);
      alpha = cv::Mat(window.size(), CV_8UC1, cv::Scalar(255));
    });
    writer.Commit();
    map_ = std::make_unique<store::MapReader>(file);
  }

  /// An image of a ceiling, with noise, compared with the map.
  ViewComparison See(const cv::Mat& ceiling) {
    const cv::Point2d middle(kComparedCorner.x + 0.5 * kComparedView.width,
                             kComparedCorner.y + 0.5 * kComparedView.height);
    const Pose2 T_map_view{
        kMosaic.min_x + middle.x * kResolution, kMosaic.max_y - middle.y * kResolution, 0};
    cv::Mat grey;
    cv::flip(ceiling(cv::Rect(kComparedCorner, kComparedView)), grey, 0);
    cv::Mat noise(kComparedView, CV_16SC1);
    cv::RNG(7).fill(noise, cv::RNG::NORMAL, 0, 1);
    cv::add(grey, noise, grey, cv::noArray(), CV_8U);
    ViewComparer comparer(*map_, heights_);
    return comparer.Compare({grey, {}, {T_map_view, kComparedView, kResolution}, kResolution});
  }

  static CellState StateAt(const ViewComparison& view, const cv::Point& cell) {
    const cv::Point at = cell - view.cells.tl();
    if (!cv::Rect({0, 0}, view.states.size()).contains(at)) return CellState::kUnseen;
    return view.states.at<CellState>(at.y, at.x);
  }

  static int CountDiffering(const ViewComparison& view) {
    int count = 0;
    for (int y = 0; y < view.states.rows; ++y) {
      for (int x = 0; x < view.states.cols; ++x) {
        count += Differs(view.states.at<CellState>(y, x)) ? 1 : 0;
      }
    }
    return count;
  }

  support::TempFolder folder_;
  std::unique_ptr<store::MapReader> map_;
  mosaic::HeightMap heights_;
};

TEST_F(ViewComparisonTest, CellsAtTheRimAreNotCompared) {
  Map(Ceiling());
  const ViewComparison view = See(Ceiling());
  const cv::Rect shown(kComparedCorner / kCellPx, kComparedView / kCellPx);
  for (int y = shown.y; y < shown.br().y; ++y) {
    for (int x = shown.x; x < shown.br().x; ++x) {
      const bool rim =
          x == shown.x || y == shown.y || x == shown.br().x - 1 || y == shown.br().y - 1;
      EXPECT_EQ(StateAt(view, {x, y}), rim ? CellState::kUnseen : CellState::kSame)
          << x << ' ' << y;
    }
  }
}

TEST_F(ViewComparisonTest, ATubeNarrowerThanACellIsALamp) {
  cv::Mat lit = Ceiling();
  DrawTube(lit, 150);
  Map(lit);
  const ViewComparison on = See(lit);
  EXPECT_EQ(CountDiffering(on), 0);
  EXPECT_GE(on.lamps_alike, 5);
  EXPECT_EQ(on.lamps_differ, 0);
  const ViewComparison off = See(Ceiling());
  EXPECT_GE(off.lamps_differ, 5);
  EXPECT_EQ(StateAt(off, {240 / kCellPx, 150 / kCellPx}), CellState::kLamp);
  Map(Ceiling());
  EXPECT_EQ(StateAt(See(lit), {240 / kCellPx, 150 / kCellPx}), CellState::kLamp);
}

TEST_F(ViewComparisonTest, ALampThatLiesTwoPixelsBesideIsTheSame) {
  cv::Mat lit = Ceiling();
  DrawTube(lit, 150);
  Map(lit);
  cv::Mat beside = Ceiling();
  DrawTube(beside, 152);
  EXPECT_EQ(See(beside).lamps_differ, 0);
}

}  // namespace
}  // namespace ceilmap::change
