#include "mapping/change/change_evidence.hpp"

#include <gtest/gtest.h>

#include "tests/mapping/change/looks.hpp"

namespace ceilmap::change {
namespace {

using namespace synthetic;

TEST(ChangeEvidence, ImagesThatAgreeOnAnotherLookAreAChange) {
  ChangeEvidence evidence(kAll);
  AddChangedViews(evidence, {2, 3, 5, 5}, {4, 4, 1, 1}, CellState::kTexture, 3);
  ASSERT_NE(evidence.At({4, 4}), nullptr);
  EXPECT_TRUE(evidence.At({4, 4})->IsChanged());
  EXPECT_EQ(evidence.At({4, 4})->looks[0].views, 3);
  EXPECT_FALSE(evidence.At({3, 4})->IsChanged());
  EXPECT_EQ(evidence.At({3, 4})->same, 3);
  EXPECT_EQ(evidence.At({12, 4}), nullptr);
  EXPECT_EQ(evidence.Views(), 3);
}

TEST(ChangeEvidence, OneImageIsNone) {
  ChangeEvidence evidence(kAll);
  AddChangedViews(evidence, {0, 0, 5, 5}, {1, 1, 1, 1}, CellState::kTexture, 1);
  EXPECT_FALSE(evidence.At({1, 1})->IsChanged());
}

TEST(ChangeEvidence, ImagesThatContradictEachOtherAreNone) {
  ChangeEvidence evidence(kAll);  // something below the ceiling, seen elsewhere by each image
  for (std::uint64_t i = 0; i < 6; ++i) {
    ViewComparison view = SameView({0, 0, 3, 3});
    SetCell(view, {1, 1}, CellState::kTexture, Patch(50 + i));
    evidence.Add(view);
  }
  EXPECT_EQ(evidence.At({1, 1})->differ, 6);
  EXPECT_FALSE(evidence.At({1, 1})->IsChanged());
}

TEST(ChangeEvidence, WhatIsSoonGoneIsNone) {
  ChangeEvidence evidence(kAll);
  AddChangedViews(evidence, {0, 0, 5, 5}, {1, 1, 1, 1}, CellState::kTexture, 2);
  for (int i = 0; i < 4; ++i) evidence.Add(SameView({0, 0, 5, 5}));
  EXPECT_FALSE(evidence.At({1, 1})->IsChanged());
}

TEST(ChangeEvidence, ManyImagesTellWhatOneDoesNot) {
  for (const float log_ratio : {0.0F, 0.006F, 0.05F}) {
    ChangeEvidence evidence(kAll);
    for (int i = 0; i < 4; ++i) {
      ViewComparison view = SameView({0, 0, 3, 3});
      view.cell_noise = 1;
      SetCell(view, {1, 1}, CellState::kUnclear, Patch(5));
      // A texture below the noise, which both have, and a little noise of the brightness.
      view.differences.at<cv::Vec3f>(1, 1) = {log_ratio + (i % 2 == 0 ? 0.003F : -0.003F), 0.6F, 0};
      evidence.Add(view);
    }
    EXPECT_EQ(evidence.At({1, 1})->Verdict(),
              log_ratio > 0.01F ? CellState::kBrightness : CellState::kUnclear);
  }
  ChangeEvidence evidence(kAll);
  for (int i = 0; i < 4; ++i) {
    ViewComparison view = SameView({0, 0, 3, 3});
    view.cell_noise = 1;
    SetCell(view, {1, 1}, CellState::kUnclear, Patch(5));
    view.differences.at<cv::Vec3f>(1, 1) = {0.001F, 0.6F, 0.5F};
    evidence.Add(view);
  }
  EXPECT_EQ(evidence.At({1, 1})->Verdict(), CellState::kTexture);
  EXPECT_NEAR(evidence.At({1, 1})->MeanShare(), 0.5 / 0.6, 1e-6);
}

TEST(ChangeEvidence, TheLookIsTheWeightedMeanOfTheImagesThatAgree) {
  ChangeEvidence evidence(kAll);
  const cv::Mat patch = Patch(7);
  for (const double weight : {1.0, 0.5}) {
    ViewComparison view = SameView({0, 0, 1, 1});
    view.weights.setTo(weight);
    SetCell(view, {0, 0}, CellState::kTexture, patch + (weight == 1 ? 0 : 4));
    evidence.Add(view);
  }
  const cv::Mat mean = evidence.At({0, 0})->looks[0].Mean();
  // Weights are 1 and 1/16: 4 / 17 brighter.
  EXPECT_LE(cv::norm(mean, patch, cv::NORM_INF), 1);
}

TEST(ChangeEvidence, MostLampsDecideOnTheLight) {
  ChangeEvidence evidence(kAll);
  ViewComparison view = SameView({0, 0, 5, 5});
  view.lamps_differ = 30;
  view.lamps_alike = 10;
  evidence.Add(view);
  EXPECT_TRUE(evidence.OtherLight());
  view.lamps_differ = 0;
  view.lamps_alike = 100;
  evidence.Add(view);
  EXPECT_FALSE(evidence.OtherLight());
}

}  // namespace
}  // namespace ceilmap::change
