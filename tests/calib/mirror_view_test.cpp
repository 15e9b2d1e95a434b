#include "calib/mirror_view.hpp"
#include "calib/base/degrees.hpp"

#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "calib/base/error.hpp"
#include "tests/calib/rig_text.hpp"

namespace ceilmap::calib {
namespace {

const MirrorRing kRing{{150.3, 141.8}, 40, 120};
const cv::Size kSize(300, 280);

/// An image of the directions about a centre: value of (azimuth counter-clockwise from the front
/// that is at the top, radius in px). Seen from below, the robot's left is at the right.
using World = std::function<double(double azimuth, double radius)>;

cv::Mat Render(cv::Size size, const Eigen::Vector2d& centre, const World& world) {
  cv::Mat raw(size, CV_8UC1);
  for (int v = 0; v < raw.rows; ++v) {
    for (int u = 0; u < raw.cols; ++u) {
      const double right = u - centre.x();
      const double up = centre.y() - v;
      raw.at<std::uint8_t>(v, u) =
          cv::saturate_cast<std::uint8_t>(world(std::atan2(right, up), std::hypot(right, up)));
    }
  }
  return raw;
}

double Wave(double azimuth) {
  return 128 + 70 * std::sin(azimuth) + 40 * std::cos(3 * azimuth);
}

/// Azimuth that a column stands for.
double AzimuthOf(int column, int columns) {
  return std::numbers::pi * (1 - 2.0 * column / columns);
}

cv::Mat Panorama(const MirrorView& view, const cv::Mat& raw) {
  cv::Mat panorama;
  view.Unwrap(raw, panorama);
  return panorama;
}

std::string MessageOf(const std::function<void()>& call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

MountedCamera OmniCamera() {
  return *ParseRig(kRigText, "rig.yaml").omni;
}

TEST(MirrorView, FrontIsInTheMiddleAndLeftAtAQuarter) {
  const cv::Mat front = Render(kSize, kRing.centre_px, [](double azimuth, double) {
    return std::abs(azimuth) < 10 * kRadPerDeg ? 255 : 0;
  });
  const cv::Mat left = Render(kSize, kRing.centre_px, [](double azimuth, double) {
    return std::abs(azimuth - std::numbers::pi / 2) < 10 * kRadPerDeg ? 255 : 0;
  });
  const MirrorView view(kSize, kRing, {.columns = 360, .rows = 5});
  for (int u = 0; u < 360; ++u) {
    const auto expect = [u](const cv::Mat& panorama, int centre) {
      if (std::abs(std::abs(u - centre) - 10) <= 1) return;  // the edge
      EXPECT_EQ(panorama.at<std::uint8_t>(2, u), std::abs(u - centre) < 10 ? 255 : 0) << u;
    };
    expect(Panorama(view, front), 180);
    expect(Panorama(view, left), 90);
  }
}

class ColumnCount : public ::testing::TestWithParam<int> {};

TEST_P(ColumnCount, EveryColumnShowsItsAzimuth) {
  const int columns = GetParam();
  const cv::Mat raw =
      Render(kSize, kRing.centre_px, [](double azimuth, double) { return Wave(azimuth); });
  const cv::Mat panorama = Panorama(MirrorView(kSize, kRing, {.columns = columns, .rows = 7}), raw);
  ASSERT_EQ(panorama.size(), cv::Size(columns, 7));
  for (int v = 0; v < panorama.rows; ++v) {
    for (int u = 0; u < columns; ++u) {
      EXPECT_NEAR(panorama.at<std::uint8_t>(v, u), Wave(AzimuthOf(u, columns)), 1.1);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, ColumnCount, ::testing::Values(8, 97, 360, 1080, 16384));

TEST(MirrorView, RowsFallEvenlyFromTheOuterCircleToTheInnerOne) {
  const cv::Mat raw =
      Render(kSize, kRing.centre_px, [](double, double radius) { return 2 * radius; });
  const cv::Mat panorama = Panorama(MirrorView(kSize, kRing, {.columns = 90, .rows = 16}), raw);
  for (int v = 0; v < 16; ++v) {
    for (int u = 0; u < 90; ++u) {
      EXPECT_NEAR(panorama.at<std::uint8_t>(v, u), 2 * (120 - 5 * (v + 0.5)), 0.6) << v;
    }
  }
}

TEST(MirrorView, NearestCopiesThePixelThatIsNearest) {
  cv::Mat raw(kSize, CV_8UC3);
  cv::RNG(3).fill(raw, cv::RNG::UNIFORM, 0, 256);
  const cv::Mat panorama = Panorama(
      MirrorView(
          kSize, kRing, {.columns = 100, .rows = 8, .interpolation = Interpolation::kNearest}),
      raw);
  ASSERT_EQ(panorama.type(), CV_8UC3);
  for (int v = 0; v < 8; ++v) {
    for (int u = 0; u < 100; ++u) {
      const double radius = 120 - 10 * (v + 0.5);
      const double azimuth = AzimuthOf(u, 100);
      const cv::Point at(static_cast<int>(std::lround(150.3 + radius * std::sin(azimuth))),
                         static_cast<int>(std::lround(141.8 - radius * std::cos(azimuth))));
      EXPECT_EQ(panorama.at<cv::Vec3b>(v, u), raw.at<cv::Vec3b>(at)) << u << ' ' << v;
    }
  }
}

// A robot that turns left lowers every azimuth: the content moves to the right.
TEST(MirrorView, TurningTheRobotShiftsColumns) {
  constexpr int kColumns = 1080;
  std::mt19937 random(8);
  for (const auto interpolation : {Interpolation::kNearest, Interpolation::kBilinear}) {
    const MirrorView view(
        kSize, kRing, {.columns = kColumns, .rows = 6, .interpolation = interpolation});
    const double bound = interpolation == Interpolation::kNearest ? 8 : 2.1;
    const cv::Mat before =
        Panorama(view, Render(kSize, kRing.centre_px, [](double a, double) { return Wave(a); }));
    for (int trial = 0; trial < 8; ++trial) {
      const int k = static_cast<int>(random() % kColumns);
      const double turn = 2 * std::numbers::pi * k / kColumns;
      const cv::Mat after = Panorama(view, Render(kSize, kRing.centre_px, [turn](double a, double) {
                                       return Wave(a + turn);
                                     }));
      double worst = 0;
      for (int u = 0; u < kColumns; ++u) {
        worst =
            std::max(worst, cv::norm(after.col((u + k) % kColumns), before.col(u), cv::NORM_INF));
      }
      EXPECT_LE(worst, bound) << k;
    }
  }
}

// A quarter turn takes pixels to pixels, so that nothing is left to interpolation.
TEST(MirrorView, AQuarterTurnIsAQuarterOfTheColumns) {
  cv::Mat raw(201, 201, CV_8UC3);
  cv::RNG(5).fill(raw, cv::RNG::UNIFORM, 0, 256);
  cv::Mat left_turn;  // content turns counter-clockwise on the screen
  cv::rotate(raw, left_turn, cv::ROTATE_90_COUNTERCLOCKWISE);
  const MirrorRing ring{{100, 100}, 30.1, 94.7};  // no position half-way between pixels
  for (const auto interpolation : {Interpolation::kNearest, Interpolation::kBilinear}) {
    const MirrorView view(
        raw.size(), ring, {.columns = 360, .rows = 13, .interpolation = interpolation});
    const cv::Mat before = Panorama(view, raw);
    const cv::Mat after = Panorama(view, left_turn);
    cv::Mat shifted;
    cv::hconcat(before.colRange(270, 360), before.colRange(0, 270), shifted);
    EXPECT_LE(cv::norm(after, shifted, cv::NORM_INF),
              interpolation == Interpolation::kNearest ? 0 : 1);
  }
}

/// Raw image of a world at infinity: value of the direction in base.
cv::Mat RenderMirror(const MountedCamera& omni,
                     const std::function<double(const Eigen::Vector3d&)>& world) {
  cv::Mat raw(omni.camera.Size(), CV_8UC1, cv::Scalar(0));
  const Lens& camera = omni.camera;
  const double rim_slope = omni.mirror->CameraSlope(omni.mirror->RimElevation()) + 3 / camera.fx;
  for (int v = 0; v < raw.rows; ++v) {
    for (int u = 0; u < raw.cols; ++u) {
      Eigen::Vector2d ray((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy);
      for (int step = 0; step < 20; ++step) {
        const auto pixel = camera.Project(ray.homogeneous());
        if (!pixel) break;
        ray.x() += (u - pixel->x()) / camera.fx;
        ray.y() += (v - pixel->y()) / camera.fy;
      }
      if (ray.norm() > rim_slope) continue;
      const double elevation = omni.mirror->Elevation(ray.norm());
      const Eigen::Vector2d level = ray.normalized() * std::cos(elevation);
      raw.at<std::uint8_t>(v, u) = cv::saturate_cast<std::uint8_t>(world(
          omni.T_base_cam.linear() * Eigen::Vector3d(level.x(), level.y(), std::sin(elevation))));
    }
  }
  return raw;
}

double Room(const Eigen::Vector3d& direction) {
  const double azimuth = std::atan2(direction.y(), direction.x());
  return Wave(azimuth) * 0.5 + 60 + 140 * direction.z();
}

void ExpectRoom(const MirrorView& view, const cv::Mat& raw, const std::function<double(int)>& row) {
  const cv::Mat panorama = Panorama(view, raw);
  double worst = 0;
  for (int v = 0; v < panorama.rows; ++v) {
    for (int u = 0; u < panorama.cols; ++u) {
      const double azimuth = AzimuthOf(u, panorama.cols);
      const double expected = Room({std::cos(azimuth), std::sin(azimuth), std::sin(row(v))});
      worst = std::max(worst, std::abs(panorama.at<std::uint8_t>(v, u) - expected));
    }
  }
  EXPECT_LT(worst, 1.6);
}

TEST(MirrorView, RowsOfAKnownMirrorAreEvenInElevation) {
  const MountedCamera omni = OmniCamera();
  const MirrorView view(omni, {.columns = 360, .rows = 45});
  const double rim = omni.mirror->RimElevation();
  ExpectRoom(view, RenderMirror(omni, Room), [&](int v) { return rim * (1 - 2 * (v + 0.5) / 45); });
  ASSERT_TRUE(view.HorizonRow());
  EXPECT_NEAR(*view.HorizonRow(), 22, 1e-9);
}

TEST(MirrorView, RowsEvenInTheTangentBetweenGivenElevations) {
  const MountedCamera omni = OmniCamera();
  const MirrorView view(omni,
                        {.columns = 360,
                         .rows = 30,
                         .row_spacing = PanoramaRows::kTanElevation,
                         .highest_elevation_rad = std::atan(0.4),
                         .lowest_elevation_rad = std::atan(-0.2)});
  ExpectRoom(
      view, RenderMirror(omni, Room), [&](int v) { return std::atan(0.4 - 0.6 * (v + 0.5) / 30); });
  EXPECT_NEAR(view.HorizonRow().value(), 19.5, 1e-9);
}

TEST(MirrorView, RowsOfAKnownMirrorByRadiusAreThoseOfItsRing) {
  const MountedCamera omni = OmniCamera();
  const cv::Mat raw = RenderMirror(omni, Room);
  const MirrorView known(omni, {.row_spacing = PanoramaRows::kRadius});
  const double inner = 520 * omni.mirror->CameraSlope(-omni.mirror->RimElevation());
  const double outer = 520 * omni.mirror->CameraSlope(omni.mirror->RimElevation());
  const MirrorView ring(raw.size(), {{239.5, 239.5}, inner, outer});
  EXPECT_LE(cv::norm(Panorama(known, raw), Panorama(ring, raw), cv::NORM_INF), 1);
  EXPECT_FALSE(ring.HorizonRow());
  EXPECT_NEAR(known.HorizonRow().value(), 45 * (outer - 138.7066) / (outer - inner) - 0.5, 1e-3);
}

// As Labrosse unwraps: as many rows as the ring has pixels of radius.
TEST(MirrorView, ARowForEachPixelOfTheRadius) {
  const MirrorViewParams params{.rows = 7, .row_spacing = PanoramaRows::kPixelRadius};
  const MirrorView ring(kSize, {kRing.centre_px, 40, 120.4}, params);
  EXPECT_EQ(ring.Size(), cv::Size(1080, 80));
  const MountedCamera omni = OmniCamera();
  const double inner = 520 * omni.mirror->CameraSlope(-omni.mirror->RimElevation());
  const double outer = 520 * omni.mirror->CameraSlope(omni.mirror->RimElevation());
  const MirrorView known(omni, params);
  EXPECT_EQ(known.Size().height, std::lround(outer - inner));
  const cv::Mat raw = RenderMirror(omni, Room);
  const MirrorView same(omni, {.rows = known.Size().height, .row_spacing = PanoramaRows::kRadius});
  EXPECT_EQ(cv::norm(Panorama(known, raw), Panorama(same, raw), cv::NORM_INF), 0);
}

// Azimuth is in base's axes, however the camera is turned and tilted, and whatever its lens does.
TEST(MirrorView, HonoursTheMountingAndTheLens) {
  using Eigen::AngleAxisd;
  using Eigen::Vector3d;
  MountedCamera omni = OmniCamera();
  omni.T_base_cam.linear() =
      AngleAxisd(37 * kRadPerDeg, Vector3d::UnitZ()) * omni.T_base_cam.linear();
  omni.T_base_cam.linear() =
      AngleAxisd(3 * kRadPerDeg, Vector3d(0.6, 0.8, 0)) * omni.T_base_cam.linear();
  omni.camera.fy = 510;
  omni.camera.distortion = {-0.05, 0.01, 0.001, -0.001, 0};
  const double highest = omni.mirror->RimElevation() - 3 * kRadPerDeg;
  const MirrorView view(omni, {.columns = 360, .rows = 40});
  ExpectRoom(view, RenderMirror(omni, Room), [&](int v) { return highest * (1 - (v + 0.5) / 20); });
}

// A robot that leans sees the room as if it stood level.
TEST(MirrorView, TakesOutATilt) {
  const MountedCamera omni = OmniCamera();
  const double highest = omni.mirror->RimElevation() - 6 * kRadPerDeg;
  const MirrorView view(omni, {.columns = 360, .rows = 40, .highest_elevation_rad = highest});
  for (const auto& [pitch_deg, roll_deg] : {std::pair{3.0, 0.0}, {0.0, -4.0}, {-2.0, 5.0}}) {
    Tilt tilt;
    tilt.pitch_rad = pitch_deg * kRadPerDeg;
    tilt.roll_rad = roll_deg * kRadPerDeg;
    MountedCamera tilted = omni;
    tilted.T_base_cam.linear() = tilt.T_level_base().linear() * omni.T_base_cam.linear();
    const cv::Mat raw = RenderMirror(tilted, Room);
    cv::Mat level;
    view.Unwrap(raw, tilt, level);
    const cv::Mat expected = Panorama(view, RenderMirror(omni, Room));
    EXPECT_LE(cv::norm(level, expected, cv::NORM_INF), 2) << pitch_deg << " " << roll_deg;
    EXPECT_GT(cv::norm(Panorama(view, raw), expected, cv::NORM_INF), 5);
  }
}

// Above the rim there is nothing to see: what is there has the value at the rim.
TEST(MirrorView, ATiltedPanoramaIsWholeUpToTheRim) {
  const MountedCamera omni = OmniCamera();
  const MirrorView view(omni, {.columns = 360, .rows = 45});
  Tilt tilt;
  tilt.pitch_rad = 5 * kRadPerDeg;
  cv::Mat panorama;
  view.Unwrap(RenderMirror(omni, [](const Eigen::Vector3d&) { return 200.0; }), tilt, panorama);
  double least = 0;
  cv::minMaxLoc(panorama, &least);
  EXPECT_GE(least, 150);  // the edge of the rim is mixed with the dark beyond
  cv::Mat level;
  view.Unwrap(RenderMirror(omni, Room), Tilt{}, level);
  EXPECT_EQ(cv::norm(level, Panorama(view, RenderMirror(omni, Room)), cv::NORM_INF), 0);
  const MirrorView ring(kSize, kRing);
  EXPECT_THAT(MessageOf([&] { ring.Unwrap(cv::Mat(kSize, CV_8UC1), tilt, panorama); }),
              testing::HasSubstr("only with a mirror of known shape"));
}

TEST(MirrorView, HonoursTheYawOfARing) {
  MountedCamera omni = OmniCamera();
  omni.mirror.reset();
  omni.mirror_ring = MirrorRing{{230.5, 240}, 60, 220};
  cv::Mat raw(omni.camera.Size(), CV_8UC1);
  cv::RNG(6).fill(raw, cv::RNG::UNIFORM, 0, 256);
  const cv::Mat straight = Panorama(MirrorView(omni, {.columns = 360}), raw);
  const cv::Mat plain = Panorama(MirrorView(raw.size(), *omni.mirror_ring, {.columns = 360}), raw);
  EXPECT_LE(cv::norm(straight, plain, cv::NORM_INF), 1);
  // A camera turned left shows at its image's top what is 30 deg left of the robot's front.
  omni.T_base_cam.linear() =
      Eigen::AngleAxisd(30 * kRadPerDeg, Eigen::Vector3d::UnitZ()) * omni.T_base_cam.linear();
  const cv::Mat turned = Panorama(MirrorView(omni, {.columns = 360}), raw);
  EXPECT_LE(cv::norm(turned.col(150), straight.col(180), cv::NORM_INF), 1);
}

TEST(MirrorView, KeepsThePanoramasMemory) {
  const MirrorView view(kSize, kRing);
  EXPECT_EQ(view.RawSize(), kSize);
  EXPECT_EQ(view.Size(), cv::Size(1080, 45));
  cv::Mat panorama;
  view.Unwrap(cv::Mat(kSize, CV_8UC3, cv::Scalar(1, 2, 3)), panorama);
  const auto* const memory = panorama.data;
  view.Unwrap(cv::Mat(kSize, CV_8UC3, cv::Scalar(4, 5, 6)), panorama);
  EXPECT_EQ(panorama.data, memory);
  EXPECT_EQ(panorama.at<cv::Vec3b>(44, 1079), cv::Vec3b(4, 5, 6));
}

TEST(MirrorViewFaults, Params) {
  const auto with = [](const MirrorViewParams& params) {
    return MessageOf([&] { MirrorView(OmniCamera(), params); });
  };
  EXPECT_EQ(with({.columns = 7}), "MirrorViewParams.columns = 7, must be in 8..16384");
  EXPECT_EQ(with({.columns = 16385}), "MirrorViewParams.columns = 16385, must be in 8..16384");
  EXPECT_EQ(with({.rows = 0}), "MirrorViewParams.rows = 0, must be in 1..4096");
  EXPECT_EQ(with({.highest_elevation_rad = std::numbers::pi / 2}),
            "MirrorViewParams.highest_elevation_rad = 90 deg, must be above -90 deg and below "
            "90 deg");
  EXPECT_EQ(with({.lowest_elevation_rad = std::nan("")}),
            "MirrorViewParams.lowest_elevation_rad = nan deg, must be above -90 deg and below 90 "
            "deg");
  EXPECT_EQ(
      with({.highest_elevation_rad = -20 * kRadPerDeg, .lowest_elevation_rad = -10 * kRadPerDeg}),
      "mirror camera: the panorama's lowest elevation -10 deg must be below its "
      "highest, -20 deg; the maximum of the mirror is 25.46 deg");
  EXPECT_EQ(with({.highest_elevation_rad = 30 * kRadPerDeg}),
            "mirror camera: parts of the panorama lie outside the mirror or the image of 480 x "
            "480 pixels; take a smaller outer radius or a lower highest elevation");
}

TEST(MirrorViewFaults, Cameras) {
  MountedCamera omni = OmniCamera();
  omni.mirror.reset();
  EXPECT_EQ(MessageOf([&] { MirrorView view(omni); }),
            "mirror camera: has no mirror; describe it in the rig (calib/README.md)");
  omni.T_base_cam.linear().setIdentity();
  omni.T_base_cam.linear()(1, 1) = omni.T_base_cam.linear()(2, 2) = -1;
  EXPECT_EQ(MessageOf([&] { MirrorView view(omni); }),
            "mirror camera: its optical axis must point upwards (within 45 deg); correct the "
            "camera's pose in the rig");
}

TEST(MirrorViewFaults, Rings) {
  const auto with = [](const MirrorRing& ring, const MirrorViewParams& params = {}) {
    return MessageOf([&] { MirrorView(kSize, ring, params); });
  };
  const std::string outside =
      "mirror camera: parts of the panorama lie outside the mirror or the image of 300 x 280 "
      "pixels; take a smaller outer radius or a lower highest elevation";
  EXPECT_EQ(with({{150, 140}, 40, 135}), "");
  EXPECT_EQ(with({{150, 140}, 40, 145}), outside);
  EXPECT_EQ(with({{-900, 140}, 40, 100}), outside);
  EXPECT_EQ(with({{150, 140}, 100, 40}),
            "mirror ring: inner radius 100 px, outer 40 px, must be 0 < inner < outer "
            "about a centre in the image");
  EXPECT_NE(with({{150, 140}, 0, 40}), "");
  EXPECT_NE(with({{150, std::nan("")}, 20, 40}), "");
  const std::string unknown =
      "mirror ring: elevations are not known of a mirror without its shape; leave them out, or "
      "give "
      "the mirror's A, B and C in the rig";
  EXPECT_EQ(with({{150, 140}, 40, 135}, {.row_spacing = PanoramaRows::kElevation}), unknown);
  EXPECT_EQ(with({{150, 140}, 40, 135}, {.lowest_elevation_rad = -0.1}), unknown);
  EXPECT_EQ(MessageOf([] {
              MirrorView({1, 5}, kRing);
            }),
            "mirror camera: images of 1 x 5 pixels, must be 2 x 2 to 16384 x 16384");
}

TEST(MirrorViewFaults, Images) {
  const MirrorView view(kSize, kRing);
  cv::Mat panorama;
  EXPECT_EQ(MessageOf([&] { view.Unwrap(cv::Mat(280, 301, CV_8UC1), panorama); }),
            "mirror image of 301 x 280 pixels, CV_8UC1, must be 300 x 280 and CV_8UC1 or CV_8UC3; "
            "use the rig or ring of the camera that took it");
  EXPECT_NE(MessageOf([&] { view.Unwrap(cv::Mat(kSize, CV_16UC1), panorama); }), "");
  EXPECT_NE(MessageOf([&] { view.Unwrap({}, panorama); }), "");
}

}  // namespace
}  // namespace ceilmap::calib
