#include "app/recordings/sensor_inputs.hpp"

#include <type_traits>

#include "app/files/heading_csv.hpp"
#include "app/recordings/bag_rig.hpp"
#include "localization/compass/colour/colour_model_file.hpp"

namespace ceilmap::recordings {
namespace {

using compensation::TiltMethod;

// A bag has times of its own.
std::filesystem::path StampsOf(const std::string& source,
                               const std::filesystem::path& own,
                               const std::filesystem::path& upward) {
  return own.empty() && !IsBag(source) ? upward : own;
}

}  // namespace

void ReserveTopics(const SensorFiles& files) {
  const auto reserve = [](const std::string& source, const BagTopic& topic, TopicUse use) {
    if (!source.empty() && IsBag(source)) ReserveTopic(source, topic, use);
  };
  reserve(files.forward, files.forward_topic, TopicUse::kImages);
  reserve(files.omni, files.omni_topic, TopicUse::kImages);
  reserve(files.odometry.string(), files.odometry_topic, TopicUse::kOdometry);
  reserve(files.gyro.string(), files.gyro_topic, TopicUse::kGyro);
}

void PrintCameraDifferences(const calib::Rig& rig,
                            const std::string& up,
                            const BagTopic& up_topic,
                            const SensorFiles& files) {
  const auto print = [&rig](const std::string& source,
                            const BagTopic& topic,
                            const char* name,
                            const std::optional<calib::MountedCamera>& camera) {
    if (!source.empty() && camera) PrintCameraDifference(source, topic, name, *camera, rig);
  };
  print(up, up_topic, "up", rig.up);
  print(files.forward, files.forward_topic, "forward", rig.forward);
  print(files.omni, files.omni_topic, "omni", rig.omni);
}

SensorInputs::SensorInputs(const SensorFiles& files, std::optional<calib::Rig>& rig)
    : files_(files), wheels_(files.odometry, files.gyro, files.odometry_topic, files.gyro_topic) {
  if (!rig) return;
  const auto keep = [this](const std::optional<calib::CameraScaling>& scaling) {
    if (scaling) scalings_.push_back(*scaling);
  };
  if (files.forward.empty()) {
    if (files_.tilt) files_.tilt = TiltMethod::kCeiling;
  } else if ((files.tilt && files.tilt != TiltMethod::kCeiling) || !files.heading_model.empty()) {
    forward_ = std::make_unique<SensorStream>(
        files.forward,
        StampsOf(files.forward, files.forward_stamps, files.stamps),
        files.heading_model.empty() ? Pixels::kGrey : Pixels::kColour,
        files.forward_topic);
    keep(calib::FitForwardCamera(*rig, files.forward, forward_->Size()));
  }
  if (!files.omni.empty()) {
    omni_ = std::make_unique<SensorStream>(files.omni,
                                           StampsOf(files.omni, files.omni_stamps, files.stamps),
                                           Pixels::kColour,
                                           files.omni_topic);
    keep(calib::FitOmniCamera(*rig, files.omni, omni_->Size()));
  }
}

robot::SensorsParams SensorInputs::Params(robot::SensorsParams params) const {
  params.measure_tilt = files_.tilt.has_value();
  if (files_.tilt) params.tilt.method = *files_.tilt;
  if (!files_.heading_model.empty()) {
    params.heading_model = colour::ReadColourModel(files_.heading_model);
  }
  return params;
}

void SensorInputs::AddHeadings(robot::Sensors& sensors) const {
  if (files_.headings.empty()) return;
  for (const HeadingSample& sample : files::ReadHeadings(files_.headings)) {
    sensors.AddHeading(sample, files_.headings_frame);
  }
}

void SensorInputs::ReadTo(double stamp_s, robot::Sensors& sensors) {
  if (forward_) {
    forward_->ReadTo(stamp_s, [&](const robot::Image& image) { sensors.AddForward(image); });
  }
  if (omni_) {
    omni_->ReadTo(stamp_s, [&](const robot::Image& image) { sensors.AddOmni(image); });
  }
  wheels_.ReadTo(stamp_s, [&sensors](const auto& sample) {
    if constexpr (std::is_same_v<decltype(sample), const wheels::GyroSample&>) {
      sensors.AddGyro(sample);
    } else {
      sensors.AddOdometry(sample);
    }
  });
}

}  // namespace ceilmap::recordings
