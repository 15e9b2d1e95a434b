#include "app/recordings/ceiling_keyframes.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "app/terminal/progress.hpp"
#include "calib/base/degrees.hpp"
#include "calib/base/error.hpp"
#include "mapping/registration/registrar.hpp"

namespace ceilmap::recordings {
namespace {

using registration::FrameSpectrum;
using registration::ImageMotion;
using registration::PlaneCamera;
using registration::PlaneMotion;
using registration::Registrar;
constexpr std::size_t kMaxKeyframes =
    97;  // odd: see Keep; about 4 MB each during the measurement of pairs

Registrar MakeRegistrar(const calib::CeilingView& view) {
  registration::RegistrarParams params;
  params.mask = view.Mask();
  return Registrar(view.Size(), params);
}

PlaneMotion LevelMotion(const Pose2& T_reference_current) {
  PlaneMotion motion;
  motion.x = T_reference_current.x;
  motion.y = T_reference_current.y;
  motion.yaw = T_reference_current.yaw;
  return motion;
}

ImageMotion InImage(const PlaneCamera& camera, const Pose2& T_reference_current) {
  const PlaneMotion plane = LevelMotion(T_reference_current);
  const Eigen::Vector2d centre = plane.Apply(camera, Eigen::Vector2d::Zero());
  return {centre.x(), centre.y(), -plane.yaw, 1};
}

// Tracks the camera from keyframe to keyframe.
class CeilingFollower {
 public:
  explicit CeilingFollower(const calib::CeilingView& view)
      : view_(view), camera_(registration::PlaneCameraOf(view)), registrar_(MakeRegistrar(view)) {}

  // False when the image matches none.
  bool Follow(const Frame& frame) {
    KeptImage now{{frame.image.clone(), frame.index, {}}, Analyze(frame.image)};
    if (frames_.empty()) {
      Keep(std::move(now));
      return true;
    }
    std::optional<Pose2> T_key_now = Match(now.spectrum);
    if (!T_key_now && last_) {
      Keep(std::move(*last_));
      last_.reset();
      T_key_now = Match(now.spectrum);
    }
    if (!T_key_now) return false;
    const Pose2 T_first_now = key_.image.T_first_camera * *T_key_now;
    step_ = T_first_last_.Inverse() * T_first_now;
    T_first_last_ = T_first_now;
    now.image.T_first_camera = T_first_now;
    if (Far(*T_key_now)) {
      Keep(std::move(now));
      last_.reset();
    } else {
      last_ = std::move(now);
    }
    return true;
  }

  std::vector<CeilingKeyframe> Finish() {
    if (last_) Keep(std::move(*last_));
    return std::move(frames_);
  }

 private:
  struct KeptImage {
    CeilingKeyframe image;
    FrameSpectrum spectrum;
  };

  FrameSpectrum Analyze(const cv::Mat& raw) {
    return registrar_.Analyze(view_.Rectify(raw, buffer_));
  }

  std::optional<Pose2> Match(const FrameSpectrum& now) {
    const Pose2 expected = key_.image.T_first_camera.Inverse() * T_first_last_ * step_;
    constexpr double kSigmaRatio = 0.1;  // of the image's width
    constexpr double kSigmaDeg = 10;
    const registration::MotionPrior prior{
        InImage(camera_, expected), kSigmaRatio * view_.Size().width, kSigmaDeg * kRadPerDeg};
    const registration::Registration found = registrar_.Register(key_.spectrum, now, prior);
    if (!found.ok()) return std::nullopt;
    const PlaneMotion motion = PlaneMotion::FromSimilarity(camera_, found.motion);
    return Pose2{motion.x, motion.y, motion.yaw};
  }

  [[nodiscard]] bool Far(const Pose2& T_key_now) const {
    const double shift_px = camera_.focal_px * T_key_now.Translation().norm();
    return shift_px > min_fraction_ * std::hypot(view_.Size().width, view_.Size().height) ||
           std::abs(T_key_now.yaw) > min_turn_rad_;
  }

  void Keep(KeptImage image) {
    key_ = std::move(image);
    T_first_last_ = key_.image.T_first_camera;
    frames_.push_back(key_.image);
    if (frames_.size() < kMaxKeyframes) return;
    // Keeps every second keyframe, with the first and the newest one; the spacing of later
    // keyframes doubles too.
    std::vector<CeilingKeyframe> half;
    for (std::size_t i = 0; i < frames_.size(); i += 2) half.push_back(std::move(frames_[i]));
    frames_ = std::move(half);
    min_fraction_ *= 2;
    min_turn_rad_ *= 2;
  }

  const calib::CeilingView& view_;
  PlaneCamera camera_;
  Registrar registrar_;
  cv::Mat buffer_;
  std::vector<CeilingKeyframe> frames_;
  KeptImage key_;
  std::optional<KeptImage> last_;
  Pose2 T_first_last_;
  Pose2 step_;
  double min_fraction_ = 0.035;  // of the image's diagonal
  double min_turn_rad_ = 4.5 * kRadPerDeg;
};

class PairMeter {
 public:
  PairMeter(const CeilingKeyframes& keyframes,
            const calib::MountedCamera& up,
            double ceiling_height_m)
      : view_(up, ceiling_height_m),
        camera_(registration::PlaneCameraOf(view_)),
        R_cam_view_(up.T_base_cam.linear().transpose() * view_.T_base_camera().linear()),
        registrar_(MakeRegistrar(view_)) {
    cv::Mat buffer;
    for (const CeilingKeyframe& frame : keyframes.frames) {
      spectra_.push_back(registrar_.AnalyzeFine(view_.Rectify(frame.raw, buffer)));
    }
  }

  std::vector<calibration::PointCorrespondence> Measure(std::size_t first,
                                                        std::size_t second,
                                                        const Pose2& T_first_second,
                                                        bool known) {
    PlaneMotion motion = LevelMotion(T_first_second);
    if (!known) {
      const registration::PlaneFit fit =
          registrar_.RefinePlane(spectra_[first], spectra_[second], camera_, motion);
      if (!fit.ok) return {};
      motion = fit.motion;
    }
    std::vector<calibration::PointCorrespondence> places;
    for (const registration::PlaneShift& shift :
         registrar_.MeasurePlane(spectra_[first], spectra_[second], camera_, motion)) {
      places.push_back(ToPlace(shift));
    }
    return places;
  }

  [[nodiscard]] double Overlap(const Pose2& T_first_second) const {
    return registration::OverlapOf(InImage(camera_, T_first_second), view_.Size());
  }

 private:
  [[nodiscard]] Eigen::Vector2d Ray(const Eigen::Vector2d& px) const {
    const Eigen::Vector2d slope = (px - camera_.principal_px) / camera_.focal_px;
    return (R_cam_view_ * slope.homogeneous()).hnormalized();
  }

  [[nodiscard]] calibration::PointCorrespondence ToPlace(
      const registration::PlaneShift& shift) const {
    const Eigen::Matrix2d information = shift.block.quality * shift.block.sharpness;
    const Eigen::LLT<Eigen::Matrix2d> root(information + 1e-9 * Eigen::Matrix2d::Identity());
    return {Ray(shift.block.point), Ray(shift.seen), root.matrixU().toDenseMatrix()};
  }

  calib::CeilingView view_;
  PlaneCamera camera_;
  Eigen::Matrix3d R_cam_view_;
  Registrar registrar_;
  std::vector<FrameSpectrum> spectra_;
};

}  // namespace

CeilingKeyframes ReadCeiling(FrameSource& source,
                             const calib::CeilingView& view,
                             const std::string& label) {
  constexpr int kMaxLost = 5;
  CeilingKeyframes result;
  result.source = source.Name();
  CeilingFollower follower(view);
  terminal::Progress progress(label, "frames", source.ExpectedFrames());
  Frame frame;
  int lost = 0;
  while (source.Read(frame)) {
    progress.Update(++result.read);
    if (follower.Follow(frame)) {
      lost = 0;
      continue;
    }
    ++result.lost;
    if (++lost < kMaxLost) continue;
    throw InputError(
        fmt::format("{}: from frame {} on the ceiling does not match the frames before; record it "
                    "more slowly, under a ceiling with texture, with the lights on",
                    source.Name(),
                    frame.index - lost + 1));
  }
  result.frames = follower.Finish();
  return result;
}

calibration::Recording MeasureCeiling(const CeilingKeyframes& keyframes,
                                      const calib::MountedCamera& up,
                                      double ceiling_height_m,
                                      const std::vector<Pose2>& cameras,
                                      bool known) {
  constexpr std::array<std::size_t, 12> kApart{1, 2, 3, 5, 8, 12, 18, 26, 36, 48, 62, 78};
  constexpr double kMinOverlap = 0.35;
  PairMeter meter(keyframes, up, ceiling_height_m);
  calibration::Recording recording;
  for (const Pose2& camera : cameras) {
    recording.cameras.push_back(cameras.front().Inverse() * camera);
  }
  for (std::size_t first = 0; first < cameras.size(); ++first) {
    for (const std::size_t apart : kApart) {
      const std::size_t second = first + apart;
      if (second >= cameras.size()) break;
      const Pose2 T_first_second = cameras[first].Inverse() * cameras[second];
      if (meter.Overlap(T_first_second) < kMinOverlap) continue;
      calibration::ViewPair pair{static_cast<int>(first), static_cast<int>(second), {}};
      pair.places = meter.Measure(first, second, T_first_second, known);
      if (!pair.places.empty()) recording.pairs.push_back(std::move(pair));
    }
  }
  return recording;
}

}  // namespace ceilmap::recordings
