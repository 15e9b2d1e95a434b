#include "calib/ceiling_view.hpp"
#include "calib/base/degrees.hpp"

#include <gmock/gmock.h>

#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include "calib/base/error.hpp"

namespace ceilmap::calib {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kCeiling = 2.6;

/// The mount of the example in calib/README.md: x_cam = +y_base, y_cam = -x_base, z_cam = +z_base,
/// 0.4 m up the mast.
MountedCamera MakeUpwardCamera() {
  MountedCamera up;
  up.camera.width_px = 640;
  up.camera.height_px = 480;
  up.camera.fx = up.camera.fy = 440;
  up.camera.cx = 319.5;
  up.camera.cy = 239.5;
  up.T_base_cam.linear() = Eigen::AngleAxisd(kPi / 2, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  up.T_base_cam.translation() = Eigen::Vector3d(0, 0, 0.4);
  return up;
}

MountedCamera Tilted(MountedCamera up, double roll_deg, double pitch_deg) {
  up.T_base_cam.linear() =
      Eigen::AngleAxisd(pitch_deg * kRadPerDeg, Eigen::Vector3d::UnitY()).toRotationMatrix() *
      Eigen::AngleAxisd(roll_deg * kRadPerDeg, Eigen::Vector3d::UnitX()).toRotationMatrix() *
      up.T_base_cam.linear();
  return up;
}

Eigen::Vector2d PixelToBase(const CeilingView& view, const Eigen::Vector2d& pixel) {
  const Eigen::Vector2d centre(0.5 * (view.Size().width - 1), 0.5 * (view.Size().height - 1));
  return view.T_base_view() * (view.MetresPerPixel() * (pixel - centre));
}

Eigen::Vector2d BaseToPixel(const CeilingView& view, const Eigen::Vector2d& p_base) {
  const Eigen::Vector2d centre(0.5 * (view.Size().width - 1), 0.5 * (view.Size().height - 1));
  return view.T_base_view().Inverse() * p_base / view.MetresPerPixel() + centre;
}

/// Smooth pattern on the ceiling, grey 28..228 with details of 0.5 m and more.
double Pattern(double x, double y) {
  return 128 + 50 * std::sin(9 * x + 2 * y) + 50 * std::cos(7 * y - 3 * x);
}

/// What a raw camera shows of the pattern; black where it does not see the ceiling.
cv::Mat RenderRaw(const MountedCamera& up) {
  const Lens& camera = up.camera;
  cv::Mat raw(camera.Size(), CV_8UC1, cv::Scalar(0));
  for (int v = 0; v < raw.rows; ++v) {
    for (int u = 0; u < raw.cols; ++u) {
      const auto ray_cam = camera.Ray(Eigen::Vector2d(u, v));
      if (!ray_cam) continue;
      const Eigen::Vector3d ray = up.T_base_cam.linear() * *ray_cam;
      if (!(ray.z() > 0.1)) continue;
      const Eigen::Vector3d origin = up.T_base_cam.translation();
      const Eigen::Vector3d p_base = origin + ray * (kCeiling - origin.z()) / ray.z();
      raw.at<std::uint8_t>(v, u) = cv::saturate_cast<std::uint8_t>(Pattern(p_base.x(), p_base.y()));
    }
  }
  return raw;
}

/// Largest difference, over the pixels with content, between the rectified image and the pattern
/// at the place on the ceiling that the view gives each pixel.
double WorstGreyError(const CeilingView& view, const cv::Mat& rectified) {
  double worst = 0;
  for (int v = 0; v < rectified.rows; ++v) {
    for (int u = 0; u < rectified.cols; ++u) {
      if (!view.Mask().empty() && view.Mask().at<std::uint8_t>(v, u) == 0) continue;
      const Eigen::Vector2d p = PixelToBase(view, {u, v});
      worst = std::max(worst, std::abs(rectified.at<std::uint8_t>(v, u) - Pattern(p.x(), p.y())));
    }
  }
  return worst;
}

TEST(CeilingView, SignsByHand) {
  const CeilingView view(MakeUpwardCamera(), kCeiling);
  EXPECT_NEAR(view.MetresPerPixel(), 2.2 / 440, 1e-15);
  EXPECT_EQ(view.FocalLength(), 440);
  // A lamp 0.5 m ahead of the robot appears 100 px above the centre, one 0.5 m to its left 100 px
  // to the right: u = cx + f Y / Z, v = cy - f X / Z.
  EXPECT_TRUE(BaseToPixel(view, {0.5, 0}).isApprox(Eigen::Vector2d(319.5, 139.5), 1e-12));
  EXPECT_TRUE(BaseToPixel(view, {0, 0.5}).isApprox(Eigen::Vector2d(419.5, 239.5), 1e-12));
  EXPECT_LT((PixelToBase(view, {319.5, 139.5}) - Eigen::Vector2d(0.5, 0)).norm(), 1e-12);
  EXPECT_LT((PixelToBase(view, {419.5, 239.5}) - Eigen::Vector2d(0, 0.5)).norm(), 1e-12);
}

TEST(CeilingView, LevelCameraPassesThroughUntouched) {
  const CeilingView view(MakeUpwardCamera(), kCeiling);
  const cv::Mat raw(480, 640, CV_8UC1, cv::Scalar(9));
  cv::Mat buffer;
  EXPECT_FALSE(view.NeedsRectification());
  EXPECT_EQ(&view.Rectify(raw, buffer), &raw);
  EXPECT_TRUE(buffer.empty());
  EXPECT_TRUE(view.Mask().empty());
}

TEST(CeilingView, RoundedPosesPassThroughUntouched) {
  MountedCamera up = Tilted(MakeUpwardCamera(), 5e-6, -5e-6);
  up.camera.fy *= 1 + 1e-7;
  EXPECT_FALSE(CeilingView(up, kCeiling).NeedsRectification());
  EXPECT_TRUE(CeilingView(Tilted(up, 1e-3, 0), kCeiling).NeedsRectification());
}

TEST(CeilingView, OffsetsOfCameraAndPrincipalPointArePartOfThePose) {
  MountedCamera up = MakeUpwardCamera();
  up.camera.cx = 329.5;  // 10 px right of the centre: the axis meets the ceiling there
  up.T_base_cam.translation() = Eigen::Vector3d(0.2, -0.1, 0.4);
  const CeilingView view(up, kCeiling);
  EXPECT_FALSE(view.NeedsRectification());
  EXPECT_LT((PixelToBase(view, {329.5, 239.5}) - Eigen::Vector2d(0.2, -0.1)).norm(), 1e-12);
  // The image's centre shows what is 10 px = 0.05 m to the robot's right of that.
  EXPECT_NEAR(view.T_base_view().x, 0.2, 1e-12);
  EXPECT_NEAR(view.T_base_view().y, -0.15, 1e-12);
  EXPECT_NEAR(view.T_base_view().yaw, kPi / 2, 1e-12);
}

TEST(CeilingView, AgreesWithTheCameraForAnyYawAndPlace) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> angle(-kPi, kPi);
  std::uniform_real_distribution<double> metres(-1, 1);
  for (int i = 0; i < 200; ++i) {
    MountedCamera up = MakeUpwardCamera();
    up.camera.cx += 40 * metres(random);
    up.camera.cy += 40 * metres(random);
    up.T_base_cam.linear() =
        Eigen::AngleAxisd(angle(random), Eigen::Vector3d::UnitZ()).toRotationMatrix();
    up.T_base_cam.translation() = Eigen::Vector3d(metres(random), metres(random), 0.5);
    const CeilingView view(up, kCeiling);
    ASSERT_FALSE(view.NeedsRectification());
    const Eigen::Vector3d p_base(metres(random), metres(random), kCeiling);
    const auto pixel = up.camera.Project(up.T_base_cam.inverse() * p_base);
    ASSERT_TRUE(pixel);
    EXPECT_LT((BaseToPixel(view, p_base.head<2>()) - *pixel).norm(), 1e-9);
    EXPECT_LT((PixelToBase(view, *pixel) - p_base.head<2>()).norm(), 1e-12);
  }
}

TEST(CeilingView, TakesOutUnequalFocalLengths) {
  MountedCamera up = MakeUpwardCamera();
  up.camera.fx = 430;
  up.camera.fy = 450;
  const CeilingView view(up, kCeiling);
  ASSERT_TRUE(view.NeedsRectification());
  EXPECT_NEAR(view.FocalLength(), std::sqrt(430.0 * 450.0), 1e-12);
  cv::Mat buffer;
  EXPECT_LT(WorstGreyError(view, view.Rectify(RenderRaw(up), buffer)), 1.6);
}

TEST(CeilingView, TakesOutDistortion) {
  MountedCamera up = MakeUpwardCamera();
  up.camera.distortion = {-0.12, 0.02, 0.001, -0.002, 0};
  const CeilingView view(up, kCeiling);
  ASSERT_TRUE(view.NeedsRectification());
  cv::Mat buffer;
  const cv::Mat& rectified = view.Rectify(RenderRaw(up), buffer);
  EXPECT_EQ(&rectified, &buffer);
  EXPECT_LT(WorstGreyError(view, rectified), 1.6);
  EXPECT_TRUE(view.Mask().empty()) << "a barrel lens has a wider view than its ideal image";
}

TEST(CeilingView, MasksPixelsOutsideAPincushionLens) {
  MountedCamera up = MakeUpwardCamera();
  up.camera.distortion[0] = 0.1;
  const CeilingView view(up, kCeiling);
  ASSERT_EQ(view.Mask().type(), CV_8UC1);
  ASSERT_EQ(view.Mask().size(), view.Size());
  EXPECT_EQ(view.Mask().at<std::uint8_t>(0, 0), 0);
  EXPECT_EQ(view.Mask().at<std::uint8_t>(240, 320), 255);
  cv::Mat buffer;
  const cv::Mat& rectified = view.Rectify(RenderRaw(up), buffer);
  EXPECT_EQ(rectified.at<std::uint8_t>(0, 0), 0);
  EXPECT_LT(WorstGreyError(view, rectified), 1.6);
}

TEST(CeilingView, TakesOutTiltDistortionAndFocalLengthsTogether) {
  std::mt19937 random(6);
  std::uniform_real_distribution<double> tilt_deg(-12, 12);
  std::uniform_real_distribution<double> yaw(-kPi, kPi);
  for (int i = 0; i < 6; ++i) {
    MountedCamera up = MakeUpwardCamera();
    up.camera.fy = 452;
    up.camera.cx = 310;
    up.camera.distortion = {-0.1, 0.02, 0.001, 0.001, 0};
    up.T_base_cam.linear() =
        Eigen::AngleAxisd(yaw(random), Eigen::Vector3d::UnitZ()).toRotationMatrix();
    up.T_base_cam.translation() = Eigen::Vector3d(0.3, -0.2, 0.4);
    up = Tilted(up, tilt_deg(random), tilt_deg(random));
    const CeilingView view(up, kCeiling);
    cv::Mat buffer;
    EXPECT_LT(WorstGreyError(view, view.Rectify(RenderRaw(up), buffer)), 1.6) << i;
  }
}

// The raw image of a fisheye has details of a few pixels at its rim; without interpolation errors
// the view shows the same.
TEST(CeilingView, ShowsWhatWideLensesSee) {
  Lens fisheye = Lens::WithoutDistortion(LensModel::kEquidistant, {640, 480}, 230);
  fisheye.distortion = {-0.03, 0.006, -0.003, 0.0004};
  Lens rational = Lens::WithoutDistortion(LensModel::kRational, {640, 480}, 330);
  rational.distortion = {0.3, 0.01, 5e-4, -3e-4, 0, 0.6, 0.05, 0.001};
  for (const Lens& lens : {fisheye, rational}) {
    for (const double tilt_deg : {0.0, 15.0}) {
      MountedCamera up = MakeUpwardCamera();
      up.camera = lens;
      up = Tilted(up, 0.6 * tilt_deg, -0.8 * tilt_deg);
      const CeilingView view(up, kCeiling);
      EXPECT_EQ(view.RawSize(), cv::Size(640, 480));
      cv::Mat buffer;
      const cv::Mat& rectified = view.Rectify(RenderRaw(up), buffer);
      ASSERT_EQ(rectified.size(), view.Size());
      EXPECT_LT(WorstGreyError(view, rectified), 4);
      const double content =
          view.Mask().empty() ? 1 : cv::countNonZero(view.Mask()) / double(view.Size().area());
      EXPECT_GT(content, 0.98);
    }
  }
}

TEST(CeilingView, TiltKeepsYawAndTheMiddleOfTheImage) {
  // Nose-down pitch of 10 deg turns the axis forwards: it meets the ceiling 2.2 tan(10 deg) ahead.
  const MountedCamera up = Tilted(MakeUpwardCamera(), 0, 10);
  const CeilingView view(up, kCeiling);
  EXPECT_NEAR(view.T_base_view().yaw, kPi / 2, 1e-12);
  EXPECT_NEAR(view.T_base_view().x, 2.2 * std::tan(10 * kRadPerDeg), 1e-12);
  EXPECT_NEAR(view.T_base_view().y, 0, 1e-12);
  EXPECT_NEAR(view.MetresPerPixel(), 2.2 / 440, 1e-15);
}

TEST(CeilingView, InPixels) {
  const CeilingView view = CeilingView::InPixels({640, 480});
  EXPECT_EQ(view.Size(), cv::Size(640, 480));
  EXPECT_EQ(view.MetresPerPixel(), 1);
  EXPECT_EQ(view.FocalLength(), 0);
  EXPECT_FALSE(view.NeedsRectification());
  EXPECT_LT((PixelToBase(view, {319.5, 139.5}) - Eigen::Vector2d(100, 0)).norm(), 1e-12);  // ahead
  EXPECT_LT((PixelToBase(view, {419.5, 239.5}) - Eigen::Vector2d(0, 100)).norm(), 1e-12);  // left
}

TEST(CeilingView, RectifiesInPlace) {
  MountedCamera up = MakeUpwardCamera();
  up.camera.distortion[0] = -0.1;
  const CeilingView view(up, kCeiling);
  const cv::Mat raw = RenderRaw(up);
  cv::Mat apart;
  view.Rectify(raw, apart);
  cv::Mat same = raw.clone();
  view.Rectify(same, same);
  EXPECT_EQ(cv::norm(apart, same, cv::NORM_INF), 0);
}

TEST(CeilingView, RefusesOtherImages) {
  const CeilingView view(MakeUpwardCamera(), kCeiling);
  cv::Mat buffer;
  const auto message = [&](const cv::Mat& raw) -> std::string {
    try {
      view.Rectify(raw, buffer);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(message(cv::Mat::zeros(240, 320, CV_8UC1)),
            "image of 320 x 240 pixels, must be 640 x 480 and 8-bit grey; use the rig of the "
            "camera that took it");
  EXPECT_EQ(message(cv::Mat::zeros(480, 640, CV_8UC3)),
            "image of 640 x 480 pixels that is not 8-bit grey, must be 640 x 480 and 8-bit grey; "
            "use the rig of the camera that took it");
}

TEST(CeilingView, RefusesCamerasWithoutAViewOfTheCeiling) {
  const MountedCamera good = MakeUpwardCamera();
  EXPECT_THROW(CeilingView(good, 0.4), InputError);
  EXPECT_THROW(CeilingView(good, -1), InputError);
  EXPECT_THROW(CeilingView(good, std::nan("")), InputError);
  EXPECT_THROW(CeilingView(Tilted(good, 0, 46), kCeiling), InputError);
  EXPECT_THROW(CeilingView(Tilted(good, 180, 0), kCeiling), InputError);
  EXPECT_NO_THROW(CeilingView(Tilted(good, 0, 44), kCeiling));
  MountedCamera bad = good;
  bad.camera.fx = 0;
  EXPECT_THROW(CeilingView(bad, kCeiling), InputError);
  bad = good;
  bad.camera.width_px = 1;
  EXPECT_THROW(CeilingView(bad, kCeiling), InputError);
}

}  // namespace
}  // namespace ceilmap::calib
