#include "localization/robot/sensors.hpp"

#include <future>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "calib/base/error.hpp"
#include "calib/base/velocity_predictor.hpp"
#include "compensation/flicker_bands.hpp"
#include "localization/robot/colour_heading.hpp"
#include "localization/robot/gyro_heading.hpp"
#include "localization/robot/omni_heading.hpp"
#include "localization/robot/sample_heading.hpp"
#include "mapping/registration/impulses.hpp"

namespace ceilmap::robot {
namespace {

struct Located {
  double stamp_s = 0;
  std::optional<Pose2> T_map_base;
};

/// What is known of an upward frame before it is measured. Holds all that the measurement reads, so
/// that images can be added meanwhile.
struct Task {
  Image up;
  cv::Mat as_taken;
  Twist2 velocity;
  std::optional<Image> forward;
  std::optional<Image> omni;
  std::optional<wheels::RelativeTurn> omni_turn;  // since the mirror image before
  std::optional<HeadingPrior> heading;            // by samples
  std::optional<wheels::RelativeMotion> wheels;
  HeadingSource* by_camera = nullptr;  // null: no camera gives headings
  bool after_gyro = false;             // ... and the gyro gave headings before that camera did
  std::optional<TiltAngles> residual;  // feedback
  std::optional<Located> located;

  [[nodiscard]] const Image* HeadingImage(bool by_colours) const {
    const std::optional<Image>& image = by_colours ? forward : omni;
    return image ? &*image : nullptr;
  }
};

}  // namespace

struct Sensors::Impl {
  Impl(const std::optional<calib::Rig>& robot, const SensorsParams& p)
      : rig(robot), params(p), forward(p.max_offset_s), omni(p.max_offset_s) {
    if (!(p.max_offset_s > 0)) throw InputError("sensors: max_offset_s must be > 0");
    if (!rig) return;
    const wheels::WheelModel model = rig->wheels.value_or(wheels::WheelModel{});
    reckoning = wheels::DeadReckoning(model, rig->axle_behind_mast_m);
    calibrator = wheels::WheelCalibrator(model);
    if (rig->up) {
      const calib::CeilingView view(*rig->up, rig->ceiling_height_m);
      rectified = view.NeedsRectification();
      if (compensation::FlickerBands::Visible(rig->up->readout_time_s)) {
        bands.emplace(view, rig->up->readout_time_s);
      }
    }
    if (params.measure_tilt) tilt.emplace(*rig, params.tilt);
    if (params.heading_model) {
      by_camera = std::make_unique<ColourHeading>(std::move(*params.heading_model), *rig);
      by_colours = true;
      params.heading_model.reset();
    }
  }

  std::optional<calib::Rig> rig;
  SensorsParams params;
  CameraStream forward;
  CameraStream omni;
  std::optional<compensation::FlickerBands> bands;  // nothing: all rows are exposed at once
  std::optional<compensation::TiltEstimator> tilt;
  std::unique_ptr<HeadingSource> by_camera;
  std::unique_ptr<SampleHeading> samples;
  GyroHeading by_gyro;
  bool rectified = false;   // upward images are, before they are registered
  bool by_colours = false;  // by_camera takes forward images, else mirror images
  bool by_turns = false;    // what the calibrator compared last: turns alone, or whole motions
  bool started = false;     // the first upward frame was taken
  cv::Mat forward_grey;
  wheels::DeadReckoning reckoning;
  wheels::WheelCalibrator calibrator;
  std::optional<double> last_up_s;    // of the upward frame before
  std::optional<double> last_omni_s;  // of the mirror image before
  std::int64_t unreckoned = 0;

  // Feedback for the next frame that is measured; it waits while one is being measured.
  std::optional<TiltAngles> residual;
  std::optional<Located> located;
  VelocityPredictor velocity;
  std::future<Frame> measuring;

  Task Prepare(const Image& up);
  /// Whether the wheels, or a gyro without wheels, may be believed.
  [[nodiscard]] bool HasWheels() const;
  [[nodiscard]] bool HasGyroAlone() const;
  std::optional<wheels::RelativeTurn> TurnBetween(const std::optional<double>& before_s,
                                                  double stamp_s) const;
  std::optional<wheels::RelativeMotion> MotionBetween(const std::optional<double>& before_s,
                                                      double stamp_s);
  Frame Measure(const Task& task);
  void MeasureSecond(const Task& task, Frame& first);
  compensation::TiltEstimate MeasureTilt(const Task& task);
};

Task Sensors::Impl::Prepare(const Image& up) {
  Task task;
  task.up = up;
  task.as_taken = up.pixels;
  if (rectified && up.pixels.type() == CV_8UC1) {
    // Rectification would spread single white and black pixels over their neighbours.
    cv::Mat cleaned;
    task.up.pixels = registration::WithoutImpulses(up.pixels, cleaned);
    task.up.encoding.loss_as_taken = registration::LossAsTaken(task.up.pixels);
  }
  if (bands) task.up.pixels = bands->Remove(task.up.pixels, up.stamp_s);
  task.velocity = velocity.At(up.stamp_s).value_or(Twist2{});
  task.forward = forward.Nearest(up.stamp_s);
  task.omni = omni.Nearest(up.stamp_s);
  const std::optional<double> before_s = std::exchange(last_up_s, up.stamp_s);
  task.wheels = MotionBetween(before_s, up.stamp_s);
  if (samples) {
    task.heading = samples->At(up.stamp_s, nullptr, std::nullopt);
  } else if (!by_camera && HasGyroAlone()) {
    task.heading = by_gyro.Next(TurnBetween(before_s, up.stamp_s));
  }
  if (task.omni) {
    const double omni_s = task.omni->stamp_s;
    task.omni_turn = TurnBetween(std::exchange(last_omni_s, omni_s), omni_s);
  }
  task.by_camera = by_camera.get();
  task.after_gyro = by_gyro.Report().headings > 0;
  task.residual = std::exchange(residual, std::nullopt);
  task.located = std::exchange(located, std::nullopt);
  return task;
}

bool Sensors::Impl::HasWheels() const {
  return reckoning.Samples() > 0 && calibrator.Fault() == wheels::WheelFault::kNone;
}

bool Sensors::Impl::HasGyroAlone() const {
  return reckoning.Samples() == 0 && reckoning.HasGyro() &&
         calibrator.Fault() == wheels::WheelFault::kNone;
}

/// Turn since the image before.
std::optional<wheels::RelativeTurn> Sensors::Impl::TurnBetween(
    const std::optional<double>& before_s, double stamp_s) const {
  if (!HasWheels() && !HasGyroAlone()) return std::nullopt;
  if (!before_s || !(stamp_s > *before_s)) return std::nullopt;
  return reckoning.TurnBetween(*before_s, stamp_s);
}

/// Motion since the upward frame before.
std::optional<wheels::RelativeMotion> Sensors::Impl::MotionBetween(
    const std::optional<double>& before_s, double stamp_s) {
  if (!HasWheels() || !before_s || !(stamp_s > *before_s)) return std::nullopt;
  std::optional<wheels::RelativeMotion> motion = reckoning.Between(*before_s, stamp_s);
  if (!motion) ++unreckoned;
  return motion;
}

compensation::TiltEstimate Sensors::Impl::MeasureTilt(const Task& task) {
  compensation::TiltFrame frame;
  frame.up = task.up.pixels;
  frame.stamp_s = task.up.stamp_s;
  frame.velocity = task.velocity;
  frame.encoding = task.up.encoding;
  if (task.forward) frame.forward = task.forward->pixels;
  if (frame.forward.channels() == 3) {
    cv::cvtColor(frame.forward, forward_grey, cv::COLOR_BGR2GRAY);
    frame.forward = forward_grey;
  }
  return tilt->Estimate(frame);
}

Sensors::Frame Sensors::Impl::Measure(const Task& task) {
  if (task.residual && tilt) tilt->Correct(*task.residual);
  Frame frame{task.up, task.as_taken, task.velocity, {}, {}};
  frame.context.heading = task.heading;
  frame.context.encoding = task.up.encoding;
  frame.context.wheels = task.wheels;
  std::future<std::optional<HeadingPrior>> heading;
  if (task.by_camera != nullptr) {
    if (task.located) {
      task.by_camera->Locate(task.located->stamp_s, task.located->T_map_base);
    }
    heading = std::async(std::launch::async, [this, &task] {
      return task.by_camera->At(task.up.stamp_s, task.HeadingImage(by_colours), task.omni_turn);
    });
  }
  if (tilt) {
    compensation::TiltEstimate estimate = MeasureTilt(task);
    frame.context.tilt = estimate.tilt;
    frame.rectified = std::move(estimate.up);
  }
  if (heading.valid()) {
    frame.context.heading = heading.get();
    // It counts from another direction than the headings before.
    if (task.after_gyro && frame.context.heading) {
      frame.context.heading->variance_rad2 += kAnyTurnRad2;
    }
  }
  return frame;
}

Sensors::Sensors(const std::optional<calib::Rig>& rig, const SensorsParams& params)
    : impl_(std::make_unique<Impl>(rig, params)) {}
Sensors::~Sensors() {
  if (impl_ && impl_->measuring.valid()) impl_->measuring.wait();
}
Sensors::Sensors(Sensors&&) noexcept = default;
Sensors& Sensors::operator=(Sensors&&) noexcept = default;

void Sensors::AddForward(const Image& image) {
  impl_->forward.Add(image);
}

void Sensors::AddOmni(const Image& image) {
  Impl& me = *impl_;
  if (!me.by_camera) {
    if (me.samples) throw InputError("headings come from samples already, not from mirror images");
    if (!me.rig) throw InputError("mirror images need the robot's rig");
    me.by_camera = std::make_unique<OmniHeading>(*me.rig);
  } else if (me.by_colours) {
    throw InputError("headings come from a model of colours already, not from mirror images");
  }
  me.omni.Add(image);
}

void Sensors::AddHeading(const HeadingSample& sample, HeadingFrame frame) {
  Impl& me = *impl_;
  if (me.by_camera) throw InputError("headings come from a camera already, not from samples");
  if (me.by_gyro.Report().headings > 0) {
    throw InputError("headings come from a gyro already; add a sample before the first image");
  }
  if (!me.samples) me.samples = std::make_unique<SampleHeading>(frame);
  if (me.samples->Frame() != frame) {
    throw InputError("a heading sample counts from another direction than those before");
  }
  me.samples->Add(sample);
}

void Sensors::AddOdometry(const wheels::OdometrySample& sample) {
  impl_->reckoning.Add(sample);
}

void Sensors::AddOdometry(const wheels::WheelSpeedSample& sample) {
  impl_->reckoning.Add(sample);
}

void Sensors::AddGyro(const wheels::GyroSample& sample) {
  impl_->reckoning.Add(sample);
}

SensorsReport Sensors::Sensed() const {
  const Impl& me = *impl_;
  SensorsReport report;
  if (me.tilt) report.tilt = me.tilt->Report();
  report.tilt_method = me.params.tilt.method;
  report.forward = me.forward.Report();
  report.omni = me.omni.Report();
  if (me.by_camera) report.heading = me.by_camera->Report();
  if (me.samples) report.heading = me.samples->Report();
  std::int64_t unreckoned = me.unreckoned;
  if (const HeadingReport& gyro = me.by_gyro.Report(); gyro.headings > 0 && !report.heading) {
    report.heading = gyro;
    unreckoned = gyro.missing;
  }
  report.wheels = {me.reckoning, me.calibrator, unreckoned};
  return report;
}

Sensors::Frame Sensors::Measure(const Image& up) {
  return impl_->Measure(impl_->Prepare(up));
}

/// The second frame of a rolling shutter shows the velocity with which the first one should have
/// been rectified.
void Sensors::Impl::MeasureSecond(const Task& task, Frame& first) {
  std::promise<Frame> second;
  second.set_value(Measure(task));
  measuring = second.get_future();
  const std::optional<compensation::CorrectedImage> corrected = tilt->TakeCorrected();
  if (!corrected || corrected->stamp_s != first.up.stamp_s) return;
  first.rectified = corrected->up;
  first.velocity = corrected->velocity;
}

std::optional<Sensors::Frame> Sensors::Exchange(const Image& up) {
  Impl& me = *impl_;
  std::optional<Frame> before = TakeLast();
  const bool second = before && !std::exchange(me.started, true);
  if (second && me.tilt && me.rig->up->readout_time_s != 0) {
    me.MeasureSecond(me.Prepare(up), *before);
    return before;
  }
  const bool measures = me.tilt || me.by_camera;
  me.measuring = std::async(measures ? std::launch::async : std::launch::deferred,
                            [&me, task = me.Prepare(up)] { return me.Measure(task); });
  return before;
}

std::optional<Sensors::Frame> Sensors::TakeLast() {
  if (!impl_->measuring.valid()) return std::nullopt;
  return impl_->measuring.get();
}

void Sensors::CorrectTilt(const TiltAngles& residual) {
  impl_->residual = residual;
}

void Sensors::Locate(double stamp_s, const std::optional<Pose2>& T_map_base) {
  impl_->located = Located{stamp_s, T_map_base};
  impl_->velocity.AddPose(T_map_base, stamp_s);
  if (impl_->bands) impl_->bands->Place(stamp_s, T_map_base);
}

void Sensors::CalibrateWheels(double stamp_s, const std::optional<PoseWithCovariance>& pose) {
  Impl& me = *impl_;
  bool learned = false;
  const bool by_turns = me.HasGyroAlone();
  if (std::exchange(me.by_turns, by_turns) != by_turns) {
    me.calibrator.Place(stamp_s, std::nullopt, me.reckoning);  // another piece begins
  }
  if (me.HasWheels()) {
    learned = me.calibrator.Place(stamp_s, pose, me.reckoning);
  } else if (by_turns) {
    std::optional<HeadingPrior> heading;
    if (pose) heading = HeadingPrior{pose->pose.yaw, pose->covariance(2, 2)};
    learned = me.calibrator.PlaceHeading(stamp_s, heading, me.reckoning);
  }
  if (learned) me.reckoning.SetModel(me.calibrator.Model());
}

void Sensors::Move(const StampedTwist2& velocity) {
  impl_->velocity.Add(velocity);
  if (impl_->bands) impl_->bands->Move(velocity);
}

}  // namespace ceilmap::robot
