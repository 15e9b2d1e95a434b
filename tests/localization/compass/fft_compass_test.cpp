#include "localization/compass/fft_compass.hpp"
#include "calib/base/degrees.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>
#include <vector>

#include "calib/base/error.hpp"
#include "calib/base/pose2.hpp"
#include "tests/localization/compass/panorama_room.hpp"
#include "tests/localization/compass/panoramas.hpp"

namespace ceilmap::compass {
namespace {

using std::numbers::pi;

/// A circle of 1 m radius around the middle of the room, driven `rounds` times, 5 cm a frame.
std::vector<Pose2> Circle(double rounds) {
  std::vector<Pose2> poses;
  for (double a = 0; a <= 2 * pi * rounds; a += 0.05) {
    poses.push_back({4 + std::cos(a), 3 + std::sin(a), WrapAngle(a + pi / 2)});
  }
  return poses;
}

std::vector<Pose2> Straight() {
  std::vector<Pose2> poses;
  for (int i = 0; i < 90; ++i) poses.push_back({1.2 + 0.05 * i, 1.5 + 0.015 * i, 0.29});
  return poses;
}

struct Drove {
  std::vector<HeadingEstimate> estimates;
  std::vector<double> errors_rad;

  [[nodiscard]] double Largest() const {
    double largest = 0;
    for (const double error : errors_rad) largest = std::max(largest, std::abs(error));
    return largest;
  }
};

double Error(const HeadingEstimate& estimate, const Pose2& first, const Pose2& now) {
  return WrapAngle(estimate.heading_rad - (now.yaw - first.yaw));
}

/// @param change  of the panorama of a frame, by its number.
template <typename Change>
Drove Drive(FftCompass& compass,
            const PanoramaRoom& room,
            const std::vector<Pose2>& poses,
            Change change) {
  Drove run;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    cv::Mat panorama = room.Render(poses[i]);
    change(i, panorama);
    if (panorama.empty()) continue;
    const auto estimate = compass.Next({panorama, 0.1 * static_cast<double>(i)});
    run.estimates.push_back(estimate.value());
    run.errors_rad.push_back(Error(run.estimates.back(), poses[0], poses[i]));
  }
  return run;
}

Drove Drive(FftCompass& compass, const PanoramaRoom& room, const std::vector<Pose2>& poses) {
  return Drive(compass, room, poses, [](std::size_t, cv::Mat&) {});
}

TEST(FftCompass, FollowsACircle) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    FftCompass compass;
    const Drove run = Drive(compass, PanoramaRoom(seed), Circle(1.05));
    EXPECT_LT(run.Largest(), 1.2 * kRadPerDeg) << seed;
    EXPECT_GT(compass.References(), 5);
    for (std::size_t i = 1; i < run.estimates.size(); ++i) {
      const double sigma = std::sqrt(run.estimates[i].variance_rad2);
      EXPECT_LT(std::abs(run.errors_rad[i]), 4 * sigma + 0.05 * kRadPerDeg) << i;
      EXPECT_GT(run.estimates[i].confidence, 0.5) << i;
    }
  }
}

TEST(FftCompass, DoesNotTakeTravelForATurn) {
  FftCompass compass;
  EXPECT_LT(Drive(compass, PanoramaRoom(4), Straight()).Largest(), 1.2 * kRadPerDeg);
}

/// Drives, and gives the compass the travel between the panoramas.
Drove DriveTelling(const PanoramaRoom& room, const std::vector<Pose2>& poses) {
  FftCompass compass;
  Drove run;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Pose2& last = poses[i == 0 ? 0 : i - 1];
    const Eigen::Vector2d travel =
        poses[i].Rotation().transpose() * (poses[i].Translation() - last.Translation());
    run.estimates.push_back(
        compass.Next({room.Render(poses[i]), 0.1 * static_cast<double>(i), travel}).value());
    run.errors_rad.push_back(Error(run.estimates.back(), poses[0], poses[i]));
  }
  return run;
}

TEST(FftCompass, FollowsARobotThatDrivesSideways) {
  std::vector<Pose2> poses = Straight();
  for (Pose2& pose : poses) pose.yaw += pi / 2;
  const PanoramaRoom room(4);
  EXPECT_LT(DriveTelling(room, poses).Largest(), 1.2 * kRadPerDeg);
  // Without travel the robot is assumed to drive ahead.
  FftCompass without_travel;
  EXPECT_GT(Drive(without_travel, room, poses).Largest(), 3 * kRadPerDeg);
}

TEST(FftCompass, FollowsARobotThatTurnsFreelyOnItsPath) {
  std::vector<Pose2> poses = Circle(1.05);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    poses[i].yaw = 0.4 * std::sin(0.08 * static_cast<double>(i));
  }
  const Drove run = DriveTelling(PanoramaRoom(2), poses);
  EXPECT_LT(run.Largest(), 1.2 * kRadPerDeg);
}

TEST(FftCompass, NeedsNoExactTravel) {
  cv::RNG random(3);
  const PanoramaRoom room(1);
  FftCompass compass;
  const std::vector<Pose2> poses = Circle(1.05);
  double largest = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Eigen::Vector2d travel(0.05 + random.gaussian(0.005), random.gaussian(0.005));
    const auto estimate =
        compass.Next({room.Render(poses[i]), 0.1 * static_cast<double>(i), travel});
    largest = std::max(largest, std::abs(Error(*estimate, poses[0], poses[i])));
  }
  EXPECT_LT(largest, 1.2 * kRadPerDeg);
}

TEST(FftCompass, TurnsOnTheSpotExactly) {
  std::vector<Pose2> poses;
  for (int i = 0; i < 50; ++i) poses.push_back({3, 2, WrapAngle(-0.17 * i)});
  FftCompass compass;
  const Drove run = Drive(compass, PanoramaRoom(5), poses);
  EXPECT_LT(run.Largest(), 0.15 * kRadPerDeg);
  // Nothing moved but the robot's heading: the first panorama stays the reference.
  EXPECT_EQ(compass.References(), 1);
}

TEST(FftCompass, TurnsFurtherThanItCouldPredict) {
  FftCompass compass;
  const PanoramaRoom room(6);
  const std::vector<double> yaws = {0, 0.1, 0.2, 1.9, -2.8, 3.1, 0};
  std::vector<Pose2> poses;
  for (const double yaw : yaws) poses.push_back({5, 2, yaw});
  EXPECT_LT(Drive(compass, room, poses).Largest(), 0.2 * kRadPerDeg);
}

TEST(FftCompass, RecognisesPlaces) {
  FftCompassParams params;
  params.revisits = 0;
  FftCompass forgetful(params);
  FftCompass compass;
  const PanoramaRoom room(7);
  const Drove open = Drive(forgetful, room, Circle(2.1));
  const Drove closed = Drive(compass, room, Circle(2.1));
  EXPECT_GT(compass.Revisits(), 5);
  EXPECT_EQ(forgetful.Revisits(), 0);
  EXPECT_LT(closed.estimates.back().variance_rad2, 0.3 * open.estimates.back().variance_rad2);
  EXPECT_LT(std::abs(closed.errors_rad.back()), 0.3 * kRadPerDeg);
}

TEST(FftCompass, KeepsABoundedNumberOfReferences) {
  FftCompassParams params;
  params.kept_references = 8;
  FftCompass compass(params);
  EXPECT_LT(Drive(compass, PanoramaRoom(8), Circle(2.1)).Largest(), 1.5 * kRadPerDeg);
  EXPECT_GT(compass.References(), 20);
}

TEST(FftCompass, HoldsItsHeadingWithoutTexture) {
  FftCompass compass;
  const PanoramaRoom room(9);
  const std::vector<Pose2> poses = Circle(0.5);
  const Drove run = Drive(compass, room, poses, [](std::size_t i, cv::Mat& panorama) {
    if (i >= 20 && i < 30) panorama = cv::Scalar::all(90);
  });
  for (std::size_t i = 20; i < 30; ++i) {
    EXPECT_EQ(run.estimates[i].confidence, 0);
    EXPECT_EQ(run.estimates[i].heading_rad, run.estimates[19].heading_rad);
    EXPECT_GT(run.estimates[i].variance_rad2, run.estimates[i - 1].variance_rad2);
    EXPECT_LT(std::abs(run.errors_rad[i]), 3 * std::sqrt(run.estimates[i].variance_rad2));
  }
  // Then the heading is known again.
  EXPECT_GT(run.estimates[30].confidence, 0.5);
  EXPECT_LT(std::abs(run.errors_rad.back()), 1.2 * kRadPerDeg);
}

/// Drives with turns that wheels or a gyro tell: the true ones, and `error_rad` more at a frame.
/// @param slips  wheels; else a gyro.
template <typename Change, typename TurnError>
Drove DriveKnown(const PanoramaRoom& room,
                 const std::vector<Pose2>& poses,
                 bool slips,
                 Change change,
                 TurnError error_rad) {
  FftCompass compass;
  Drove run;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    PanoramaFrame frame;
    frame.panorama = room.Render(poses[i]);
    frame.stamp_s = 0.1 * static_cast<double>(i);
    change(i, frame.panorama);
    if (i > 0) {
      constexpr double kNoiseRad2 = 1e-6;
      const double turn = WrapAngle(poses[i].yaw - poses[i - 1].yaw);
      frame.turn = {turn + error_rad(i), kNoiseRad2, 1e-5, slips};
    }
    run.estimates.push_back(compass.Next(frame).value());
    run.errors_rad.push_back(Error(run.estimates.back(), poses[0], poses[i]));
  }
  return run;
}

constexpr auto kAsRendered = [](std::size_t, cv::Mat&) {};
constexpr auto kNoError = [](std::size_t) { return 0.0; };

TEST(FftCompass, AKnownTurnGoesOnWhereNothingIsSeen) {
  const auto dark = [](std::size_t i, cv::Mat& panorama) {
    if (i >= 20 && i < 50) panorama = cv::Scalar::all(2);
  };
  const Drove run = DriveKnown(PanoramaRoom(9), Circle(1), false, dark, kNoError);
  for (std::size_t i = 20; i < 50; ++i) {
    EXPECT_EQ(run.estimates[i].confidence, 0);
    EXPECT_FALSE(run.estimates[i].seen);
    EXPECT_GT(run.estimates[i].variance_rad2, run.estimates[i - 1].variance_rad2);
  }
  // The last reference is far away: soon a new one begins.
  for (std::size_t i = 56; i < run.estimates.size(); ++i) {
    EXPECT_GT(run.estimates[i].confidence, 0.5) << i;
  }
  EXPECT_LT(run.Largest(), 1.2 * kRadPerDeg);
  EXPECT_LT(std::sqrt(run.estimates[49].variance_rad2), 1 * kRadPerDeg);
}

TEST(FftCompass, APanoramaThatContradictsTheTurnIsDropped) {
  // As if all that is seen had turned with the robot, and further.
  const auto deceived = [](std::size_t i, cv::Mat& panorama) {
    if (i >= 20 && i < 30) panorama = Rolled(panorama, panorama.cols / 9);
  };
  for (const bool slips : {false, true}) {
    const Drove known = DriveKnown(PanoramaRoom(9), Circle(0.2), slips, kAsRendered, kNoError);
    EXPECT_GT(known.estimates[22].confidence, 0.5);
    const Drove run = DriveKnown(PanoramaRoom(9), Circle(0.2), slips, deceived, kNoError);
    for (std::size_t i = 20; i < 24; ++i) {
      EXPECT_EQ(run.estimates[i].confidence, 0) << i;
      EXPECT_TRUE(run.estimates[i].seen) << i;
      EXPECT_LT(std::abs(run.errors_rad[i]), 1 * kRadPerDeg) << i;
    }
  }
  FftCompass compass;
  EXPECT_GT(Drive(compass, PanoramaRoom(9), Circle(0.2), deceived).Largest(), 30 * kRadPerDeg);
}

TEST(FftCompass, WheelsThatSlippedAreFoundOutAGyroIsBelieved) {
  const auto slip = [](std::size_t i) { return i == 20 ? 0.4 : 0.0; };
  const Drove wheels = DriveKnown(PanoramaRoom(9), Circle(0.5), true, kAsRendered, slip);
  for (std::size_t i = 20; i < 24; ++i) {
    EXPECT_EQ(wheels.estimates[i].confidence, 0) << i;
    EXPECT_LT(std::abs(wheels.errors_rad[i]), 1.2 * std::sqrt(wheels.estimates[i].variance_rad2));
  }
  for (std::size_t i = 25; i < wheels.estimates.size(); ++i) {
    EXPECT_GT(wheels.estimates[i].confidence, 0.5) << i;
    EXPECT_LT(std::abs(wheels.errors_rad[i]), 1 * kRadPerDeg) << i;
  }
  const Drove gyro = DriveKnown(PanoramaRoom(9), Circle(0.5), false, kAsRendered, slip);
  EXPECT_NEAR(gyro.errors_rad.back(), 0.4, 1 * kRadPerDeg);
}

TEST(FftCompass, KnownTurnsMakeTheHeadingMoreCertain) {
  FftCompass compass;
  const Drove alone = Drive(compass, PanoramaRoom(4), Straight());
  const Drove known = DriveKnown(PanoramaRoom(4), Straight(), false, kAsRendered, kNoError);
  EXPECT_LT(known.estimates.back().variance_rad2, 0.9 * alone.estimates.back().variance_rad2);
  EXPECT_LT(known.Largest(), alone.Largest());
}

TEST(FftCompass, AUniformRecordingHasNoHeading) {
  FftCompass compass;
  const cv::Mat panorama(15, 360, CV_8UC3, cv::Scalar::all(120));
  EXPECT_EQ(compass.Next({panorama, 0, {}})->confidence, 0);
  double variance = 0;
  for (int i = 1; i < 20; ++i) {
    const HeadingEstimate estimate = compass.Next({panorama, 0.1 * i, {}}).value();
    EXPECT_EQ(estimate.confidence, 0);
    EXPECT_EQ(estimate.heading_rad, 0);
    EXPECT_GT(estimate.variance_rad2, variance);
    variance = estimate.variance_rad2;
  }
}

TEST(FftCompass, BearsMissingFrames) {
  FftCompass compass;
  const Drove run =
      Drive(compass, PanoramaRoom(10), Circle(1), [](std::size_t i, cv::Mat& panorama) {
        if (i % 4 == 2 || (i > 50 && i < 56)) panorama.release();
      });
  EXPECT_LT(run.Largest(), 1.2 * kRadPerDeg);
}

/// The paper's car: something bright and large that passes through a field of view.
TEST(FftCompass, IsNotTakenAlongByWhatPasses) {
  FftCompass compass;
  const Drove run = Drive(compass, PanoramaRoom(11), Straight(), [](std::size_t i, cv::Mat& image) {
    if (i < 20 || i > 60) return;
    const int at = 130 + 2 * (static_cast<int>(i) - 20);  // 20 deg/s through the front
    cv::rectangle(image, {at, 3}, {at + 35, 14}, {255, 255, 40}, cv::FILLED);
    cv::rectangle(image, {at + 8, 3}, {at + 16, 9}, {0, 0, 0}, cv::FILLED);
  });
  for (std::size_t i = 1; i < run.errors_rad.size(); ++i) {
    EXPECT_LT(std::abs(run.errors_rad[i] - run.errors_rad[i - 1]), 1 * kRadPerDeg) << i;
  }
  EXPECT_LT(run.Largest(), 2 * kRadPerDeg);
}

TEST(FftCompass, BearsLightThatChanges) {
  FftCompass compass;
  const Drove run =
      Drive(compass, PanoramaRoom(12), Circle(1), [](std::size_t i, cv::Mat& panorama) {
        panorama.convertTo(panorama, -1, 0.8 + 0.15 * std::sin(0.3 * static_cast<double>(i)), 12);
      });
  EXPECT_LT(run.Largest(), 1.2 * kRadPerDeg);
}

/// A mirror whose image is unwrapped about a point 5 of 140 px off its centre.
TEST(FftCompass, BearsAMirrorOffCentre) {
  FftCompass compass;
  const Drove run = Drive(compass, PanoramaRoom(17), Circle(1), [](std::size_t, cv::Mat& panorama) {
    cv::Mat columns(panorama.size(), CV_32FC2);
    for (int u = 0; u < panorama.cols; ++u) {
      const double azimuth = pi - 2 * pi * u / panorama.cols;
      const double off = 5.0 / 140 * std::sin(azimuth - 0.7) * panorama.cols / (2 * pi);
      for (int v = 0; v < panorama.rows; ++v) {
        columns.at<cv::Vec2f>(v, u) = {static_cast<float>(u + off), static_cast<float>(v)};
      }
    }
    cv::Mat seen;
    cv::remap(panorama, seen, columns, {}, cv::INTER_LINEAR, cv::BORDER_WRAP);
    panorama = seen;
  });
  for (std::size_t i = 1; i < run.errors_rad.size(); ++i) {
    EXPECT_LT(std::abs(run.errors_rad[i] - run.errors_rad[i - 1]), 1 * kRadPerDeg) << i;
  }
  EXPECT_LT(run.Largest(), 6 * kRadPerDeg);
}

TEST(FftCompass, BeginsAnewWhereItWasCarriedTo) {
  FftCompass compass;
  const PanoramaRoom here(13);
  const PanoramaRoom there(14);
  for (int i = 0; i < 10; ++i) {
    ASSERT_TRUE(compass.Next({here.Render({3, 3, 0}), 0.1 * i, {}}));
  }
  HeadingEstimate estimate;
  for (int i = 10; i < 40; ++i) {
    estimate = compass.Next({there.Render({3, 3, 0.05 * i}), 0.1 * i, {}}).value();
  }
  EXPECT_GT(estimate.confidence, 0.5);
  // The turn in between is unknown.
  EXPECT_GT(std::sqrt(estimate.variance_rad2), 10 * kRadPerDeg);
}

TEST(FftCompass, ShowsTheDistancesOfTheLastFrame) {
  FftCompass compass;
  const PanoramaRoom room(15);
  EXPECT_TRUE(compass.Profile().distance.empty());
  ASSERT_TRUE(compass.Next({room.Render({3, 3, 0}), 0, {}}));
  EXPECT_TRUE(compass.Profile().distance.empty());
  ASSERT_TRUE(compass.Next({room.Render({3, 3, 30 * kRadPerDeg}), 1, {}}));
  const DistanceProfile profile = compass.Profile();
  ASSERT_EQ(profile.distance.size(), 360U);
  EXPECT_EQ(profile.reference_frame, 0);
  EXPECT_NEAR(profile.shift_columns, 30, 0.2);
  EXPECT_EQ(
      std::min_element(profile.distance.begin(), profile.distance.end()) - profile.distance.begin(),
      30);
}

TEST(FftCompass, RefusesWhatItCannotTake) {
  FftCompass compass;
  const PanoramaRoom room(16);
  EXPECT_THROW(compass.Next({room.Render({3, 3, 0}, 40), 0, {}}), InputError);
  ASSERT_TRUE(compass.Next({room.Render({3, 3, 0}), 1, {}}));
  EXPECT_THROW(compass.Next({room.Render({3, 3, 0}), 1, {}}), InputError);
  for (const wheels::RelativeTurn& turn :
       {wheels::RelativeTurn{NAN, 0, 0}, {0, -1, 0}, {0, 0, INFINITY}}) {
    EXPECT_THROW(compass.Next({room.Render({3, 3, 0}), 2, {}, turn}), InputError);
  }
  EXPECT_THROW(compass.Next({room.Render({3, 3, 0}, 180), 2, {}}), InputError);
  FftCompassParams params;
  params.recent_references = 0;
  EXPECT_THROW(FftCompass{params}, InputError);
}

}  // namespace
}  // namespace ceilmap::compass
