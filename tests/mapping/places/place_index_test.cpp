#include "mapping/places/place_index.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numbers>
#include <random>
#include <set>

#include "calib/base/error.hpp"
#include "mapping/places/place_descriptor.hpp"
#include "tests/mapping/registration/synthetic_ceiling.hpp"

namespace ceilmap::places {
namespace {

using registration::ImageMotion;
using registration::synthetic::SyntheticCeiling;

constexpr int kDimension = 34;

/// Windows at random places with random vectors of length 1.
cv::Mat RandomRows(int count, std::mt19937& random) {
  std::normal_distribution<float> normal;
  cv::Mat rows(count, kDimension, CV_32FC1);
  for (int i = 0; i < count; ++i) {
    for (int k = 0; k < kDimension; ++k) rows.at<float>(i, k) = normal(random);
    cv::Mat vector = rows.row(i).colRange(2, kDimension);
    vector /= cv::norm(vector);
    rows.at<float>(i, 0) *= 60;
    rows.at<float>(i, 1) *= 60;
  }
  return rows;
}

/// The same windows seen again: turned, shifted, vectors a little different.
cv::Mat Revisited(const cv::Mat& rows, const ImageMotion& motion, std::mt19937& random) {
  std::normal_distribution<float> normal(0, 0.03F);
  cv::Mat again = rows.clone();
  for (int i = 0; i < rows.rows; ++i) {
    const Eigen::Vector2d p = motion.Apply({rows.at<float>(i, 0), rows.at<float>(i, 1)});
    again.at<float>(i, 0) = static_cast<float>(p.x());
    again.at<float>(i, 1) = static_cast<float>(p.y());
    for (int k = 2; k < kDimension; ++k) again.at<float>(i, k) += normal(random);
  }
  return again;
}

std::vector<std::int64_t> Ids(const std::vector<PlaceIndex::Match>& matches) {
  std::vector<std::int64_t> ids;
  ids.reserve(matches.size());
  for (const auto& match : matches) ids.push_back(match.keyframe_id);
  return ids;
}

TEST(PlaceIndex, AgreesWithBruteForce) {
  std::mt19937 random(5);
  PlaceIndexParams params;
  params.neighbours = 20;
  params.build_effort = 200;
  params.search_effort = 200;
  PlaceIndex index(kDimension, params);
  std::vector<cv::Mat> windows;
  for (int id = 0; id < 500; ++id) {  // one window each: the order is that of the distances
    windows.push_back(RandomRows(1, random));
    index.Add(id, windows.back());
  }
  for (int trial = 0; trial < 40; ++trial) {
    const cv::Mat query = RandomRows(1, random);
    std::vector<std::pair<double, std::int64_t>> expected;
    for (int id = 0; id < 500; ++id) {
      const auto& window = windows[static_cast<std::size_t>(id)];
      expected.emplace_back(cv::norm(query.colRange(2, kDimension), window.colRange(2, kDimension)),
                            id);
    }
    std::sort(expected.begin(), expected.end());
    const std::vector<std::int64_t> found = Ids(index.Search(query, 19));
    ASSERT_EQ(found.size(), 19U);  // the 20th gives the distance of the others
    for (std::size_t i = 0; i < found.size(); ++i) EXPECT_EQ(found[i], expected[i].second);
  }
}

TEST(PlaceIndex, GivesTheMotionFromTheKeyframe) {
  std::mt19937 random(8);
  PlaceIndex index(kDimension);
  std::vector<cv::Mat> places;
  for (int id = 0; id < 40; ++id) {
    places.push_back(RandomRows(20, random));
    index.Add(id, places.back());
  }
  for (int trial = 0; trial < 10; ++trial) {
    const int id = 4 * trial;
    const ImageMotion motion{12.0 - 3 * trial, 5.0 * trial - 20, 0.6 * trial - 3, 1};
    const cv::Mat query = Revisited(places[static_cast<std::size_t>(id)], motion, random);
    const auto matches = index.Search(query, 3);
    ASSERT_FALSE(matches.empty());
    ASSERT_EQ(matches[0].keyframe_id, id);
    EXPECT_GE(matches[0].windows, 15);
    // Places move with the content: p_query = motion(p_stored).
    const ImageMotion back = motion.Inverse();
    EXPECT_NEAR(matches[0].T_stored_query.x, back.tx_px, 0.5);
    EXPECT_NEAR(matches[0].T_stored_query.y, back.ty_px, 0.5);
    EXPECT_NEAR(WrapAngle(matches[0].T_stored_query.yaw - back.theta_rad), 0, 0.02);
  }
}

TEST(PlaceIndex, ASingleDescriptorGivesThePositionButNotTheYaw) {
  std::mt19937 random(9);
  PlaceIndex index(kDimension);
  cv::Mat first;
  for (int id = 0; id < 40; ++id) {
    const cv::Mat rows = RandomRows(5, random);
    if (id == 0) first = rows;
    index.Add(id, rows);
  }
  const auto matches = index.Search(first.row(2), 1);
  ASSERT_FALSE(matches.empty());
  EXPECT_EQ(matches[0].keyframe_id, 0);
  EXPECT_EQ(matches[0].windows, 0);
  EXPECT_FLOAT_EQ(static_cast<float>(matches[0].T_stored_query.x), first.at<float>(2, 0));
  EXPECT_FLOAT_EQ(static_cast<float>(matches[0].T_stored_query.y), first.at<float>(2, 1));
}

TEST(PlaceIndex, FindsRevisitedKeyframes) {
  std::mt19937 random(6);
  PlaceIndex index(kDimension);
  std::vector<cv::Mat> keyframes;
  for (int id = 0; id < 200; ++id) {
    keyframes.push_back(RandomRows(12, random));
    index.Add(1000 + id, keyframes.back());
  }
  EXPECT_EQ(index.KeyframeCount(), 200U);
  for (int id = 0; id < 200; id += 7) {
    const cv::Mat query =
        Revisited(keyframes[static_cast<std::size_t>(id)], {40, -9, 0.1 * id, 1}, random);
    const auto matches = index.Search(query, 5);
    ASSERT_EQ(matches.size(), 5U);
    EXPECT_EQ(matches[0].keyframe_id, 1000 + id);
    EXPECT_GT(matches[0].score, 2 * matches[1].score);
  }
}

TEST(PlaceIndex, PlacesOfTheWindowsDecide) {
  std::mt19937 random(7);
  const cv::Mat query = RandomRows(12, random);
  cv::Mat elsewhere = Revisited(query, {}, random);
  RandomRows(12, random).colRange(0, 2).copyTo(elsewhere.colRange(0, 2));
  PlaceIndex index(kDimension);
  index.Add(1, elsewhere);
  index.Add(2, Revisited(query, {30, 10, 2.5, 1}, random));
  for (int id = 3; id < 40; ++id) index.Add(id, RandomRows(12, random));
  const auto matches = index.Search(query, 2);
  EXPECT_EQ(Ids(matches), (std::vector<std::int64_t>{2, 1}));
  EXPECT_GT(matches[0].score, 1.5 * matches[1].score);
}

TEST(PlaceIndex, LeavesOutWhatIsExcluded) {
  std::mt19937 random(8);
  PlaceIndex index(kDimension);
  const cv::Mat place = RandomRows(12, random);
  // More neighbours that are similar to the query than the first search returns.
  for (int id = 0; id < 60; ++id) index.Add(id, Revisited(place, {1.0 * id, 0, 0, 1}, random));
  index.Add(60, Revisited(place, {5, 5, 1, 1}, random));
  for (int id = 61; id < 200; ++id) index.Add(id, RandomRows(12, random));
  const auto matches = index.Search(place, 10, [](std::int64_t id) { return id < 60; });
  ASSERT_FALSE(matches.empty());
  EXPECT_EQ(matches[0].keyframe_id, 60);
  for (const auto& match : matches) EXPECT_GE(match.keyframe_id, 60);
  EXPECT_TRUE(index.Search(place, 10, [](std::int64_t) { return true; }).empty());
}

TEST(PlaceIndex, SmallIndexes) {
  std::mt19937 random(9);
  PlaceIndex index(kDimension);
  const cv::Mat place = RandomRows(12, random);
  EXPECT_TRUE(index.Search(place, 3).empty());
  index.Add(4, cv::Mat());
  EXPECT_TRUE(index.Search(place, 3).empty());
  EXPECT_EQ(index.KeyframeCount(), 1U);
  index.Add(5, Revisited(place.rowRange(0, 1), {}, random));
  EXPECT_EQ(Ids(index.Search(place, 3)), (std::vector<std::int64_t>{5}));
  index.Add(6, Revisited(place.rowRange(1, 9), {}, random));
  EXPECT_EQ(Ids(index.Search(place, 3)), (std::vector<std::int64_t>{6, 5}));
  EXPECT_EQ(Ids(index.Search(place, 1)), (std::vector<std::int64_t>{6}));
  EXPECT_TRUE(index.Search(cv::Mat(0, kDimension, CV_32FC1), 3).empty());
}

TEST(PlaceIndex, GrowsAndStaysTheSame) {
  const auto build = [] {
    std::mt19937 random(10);
    PlaceIndex index(kDimension);
    for (int id = 0; id < 400; ++id) index.Add(id, RandomRows(10, random));  // beyond 1024 windows
    return index;
  };
  const PlaceIndex one = build();
  const PlaceIndex two = build();
  std::mt19937 random(11);
  for (int trial = 0; trial < 20; ++trial) {
    const cv::Mat query = RandomRows(15, random);
    const auto first = one.Search(query, 20);
    const auto second = two.Search(query, 20);
    ASSERT_EQ(first.size(), 20U);
    ASSERT_EQ(Ids(first), Ids(second));
    for (std::size_t i = 0; i < first.size(); ++i) EXPECT_EQ(first[i].score, second[i].score);
    EXPECT_TRUE(std::is_sorted(first.begin(), first.end(), [](const auto& a, const auto& b) {
      return a.score > b.score;
    }));
  }
}

/// Recall of the whole: images of an endless ceiling, queries anywhere, turned, darker and noisy.
TEST(PlaceIndex, RecallOnACeiling) {
  const cv::Size size(320, 240);
  const auto params = PlaceDescriptorParams::ForCamera(size, 1.0);
  for (const double tile_px : {110.0, 0.0}) {
    const SyntheticCeiling ceiling({.seed = 12, .tile_px = tile_px});
    std::mt19937 random(13);
    std::uniform_real_distribution<double> unit(0, 1);
    PlaceDescriber describer(size, 1.0, params);
    PlaceIndex index(PlaceDescriber::Dimension());
    std::vector<ImageMotion> keyframes;
    for (int id = 0; id < 400; ++id) {
      const double yaw = id % 40 < 20 ? 0 : std::numbers::pi;
      keyframes.push_back(
          registration::Compose({0, 0, yaw, 1}, {-110.0 * (id % 20), -85.0 * (id / 20), 0, 1}));
      index.Add(id, describer.Describe(ceiling.Render(size, keyframes.back(), 2, 1000 + id)));
    }
    int found = 0;
    constexpr int kQueries = 60;
    for (std::uint32_t q = 0; q < kQueries; ++q) {
      const ImageMotion motion =
          registration::Compose({0, 0, 6.28 * unit(random) - 3.14, 1},
                                {-2090 * unit(random), -1615 * unit(random), 0, 1});
      cv::Mat image;
      ceiling.Render(size, motion, 5, q).convertTo(image, CV_8U, 0.6 + 0.5 * unit(random), 10);
      const auto matches = index.Search(describer.Describe(image), 10);
      found += std::any_of(matches.begin(), matches.end(), [&](const auto& match) {
        const auto& keyframe = keyframes[static_cast<std::size_t>(match.keyframe_id)];
        return registration::OverlapOf(registration::Compose(keyframe, motion.Inverse()), size) >=
               0.5;
      });
    }
    EXPECT_GE(found, 0.95 * kQueries) << "tiles of " << tile_px << " px";
  }
}

template <typename Action>
std::string RefusalOf(Action action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(PlaceIndex, BadInput) {
  std::mt19937 random(14);
  const cv::Mat rows = RandomRows(3, random);
  PlaceIndex index(kDimension);
  index.Add(7, rows);
  EXPECT_EQ(RefusalOf([&] { index.Add(7, rows); }), "place index: keyframe 7 is known already");
  EXPECT_EQ(RefusalOf([&] { index.Add(8, rows.colRange(0, 10)); }),
            "place index: descriptors must be CV_32FC1 with 34 columns");
  EXPECT_EQ(RefusalOf([&] { (void)index.Search(cv::Mat(3, kDimension, CV_64F), 1); }),
            "place index: descriptors must be CV_32FC1 with 34 columns");
  EXPECT_EQ(RefusalOf([&] { (void)index.Search(rows, 0); }), "place index: count = 0, must be > 0");
  cv::Mat broken = rows.clone();
  broken.at<float>(1, 5) = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(RefusalOf([&] { index.Add(8, broken); }), "place index: descriptors must be finite");
  EXPECT_EQ(RefusalOf([] { PlaceIndex(2); }), "place index: dimension = 2, must be > 2");
  PlaceIndexParams params;
  params.neighbours = 1;
  EXPECT_EQ(RefusalOf([&] { PlaceIndex(kDimension, params); }),
            "PlaceIndexParams: neighbours = 1, must be in [2, 1024]");
  EXPECT_EQ(index.KeyframeCount(), 1U);
}

}  // namespace
}  // namespace ceilmap::places
