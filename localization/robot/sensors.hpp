#pragma once

#include <memory>
#include <optional>

#include "calib/base/heading.hpp"
#include "calib/base/twist2.hpp"
#include "calib/rig.hpp"
#include "calib/wheels/wheels_report.hpp"
#include "compensation/tilt_estimator.hpp"
#include "localization/compass/colour/colour_model.hpp"
#include "localization/robot/camera_stream.hpp"
#include "localization/robot/heading_source.hpp"
#include "localization/robot/image.hpp"
#include "mapping/frame_context.hpp"

namespace ceilmap::robot {

struct SensorsParams {
  /// False: the robot is taken to be level.
  bool measure_tilt = true;
  /// Method and details. Without forward images the ceiling alone is used, except by kForward and
  /// kMatsumoto.
  compensation::TiltEstimatorParams tilt;
  /// Absolute headings by the colours that the forward camera sees: a model that was learned at
  /// poses on the map. Forward images must then be CV_8UC3.
  std::optional<colour::ColourModel> heading_model;
  /// Largest distance in time between an upward frame and the image of another camera that is used
  /// with it, s, > 0.
  double max_offset_s = 0.05;
};

/// What the sensors beside the upward camera contributed so far.
struct SensorsReport {
  std::optional<compensation::TiltReport> tilt;  ///< nothing: tilt is not measured
  compensation::TiltMethod tilt_method = compensation::TiltMethod::kFused;
  StreamReport forward;  ///< missing: all upward frames when no forward image came
  StreamReport omni;
  std::optional<HeadingReport> heading;  ///< nothing: no headings came
  wheels::WheelsReport wheels;
};

/// The sensors of a robot beside its upward camera, as CeilingMapper and CeilingLocalizer take
/// them. Each stream has increasing stamps of one clock, and may come at any rate. What belongs to
/// an upward frame must be added before that frame; a recording's reader adds each stream as far as
/// the first image later than the frame, so that the nearest one is known.
///
/// Headings come from one of: a model of colours (SensorsParams::heading_model), mirror images
/// (AddOmni), samples (AddHeading), or a gyro (AddGyro without AddOdometry).
class Sensors {
 public:
  /// @throws InputError on a stamp that is not later than that of the image before.
  void AddForward(const Image& image);
  /// @throws InputError as AddForward, when the rig has no camera 'omni', and when headings come
  ///   from another sensor already.
  void AddOmni(const Image& image);
  /// @throws InputError on an invalid sample, one that is not later than the one before, another
  ///   frame than before, and when headings come from another sensor already, a gyro included.
  void AddHeading(const HeadingSample& sample, HeadingFrame frame);

  /// Wheels: poses of base in a frame of their own, or speeds of the axle, not both. They may come
  /// later than the image by 0.15 s. @throws InputError as wheels::DeadReckoning.
  void AddOdometry(const wheels::OdometrySample& sample);
  void AddOdometry(const wheels::WheelSpeedSample& sample);
  /// A gyro gives the turn instead of the wheels. Without wheels its turns are headings, unless
  /// headings come from another sensor: then they bridge what a compass does not see.
  void AddGyro(const wheels::GyroSample& sample);

  [[nodiscard]] SensorsReport Sensed() const;

 protected:
  /// An upward frame with what the other sensors report of it.
  struct Frame {
    Image up;          ///< without the bands of flickering lamps (FlickerBands)
    cv::Mat as_taken;  ///< its pixels before these were removed
    Twist2 velocity;   ///< predicted, to correct the image of a rolling shutter
    mapping::FrameContext context;
    /// The upward image, rectified and analysed while the tilt was measured; empty: it was not.
    registration::AnalyzedImage rectified;
  };

  /// @param rig  nothing: no sensor but the upward camera can be used.
  /// @throws InputError when the rig lacks what the parameters need.
  Sensors(const std::optional<calib::Rig>& rig, const SensorsParams& params);
  ~Sensors();
  Sensors(Sensors&&) noexcept;
  Sensors& operator=(Sensors&&) noexcept;

  /// Measures tilt and heading of a frame, in parallel. @throws InputError as TiltEstimator.
  Frame Measure(const Image& up);
  /// Takes the frame that was started before, if any, and starts to measure this one in the
  /// background. Feedback that came since the last call is used for this frame. The second frame of
  /// a rolling shutter is measured at once: the first one is rectified with the velocity that it
  /// shows.
  std::optional<Frame> Exchange(const Image& up);
  /// Takes the frame that was started last; nothing when there is none.
  std::optional<Frame> TakeLast();

  /// Residual tilt of the frame taken last, measured against the map.
  void CorrectTilt(const TiltAngles& residual);
  /// Pose of the frame taken last, or that it is not known. Call it after each frame.
  void Locate(double stamp_s, const std::optional<Pose2>& T_map_base);
  /// Compares the wheels with a pose that the image of the frame taken last determined, or ends the
  /// piece of the way that is compared. Call it after each frame.
  /// @param pose  Its covariance: of the image's measurement.
  void CalibrateWheels(double stamp_s, const std::optional<PoseWithCovariance>& pose);
  /// Velocity that was measured without a pose.
  void Move(const StampedTwist2& velocity);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ceilmap::robot
