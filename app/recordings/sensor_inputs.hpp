#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/recordings/sensor_stream.hpp"
#include "app/recordings/wheel_inputs.hpp"
#include "calib/base/heading.hpp"
#include "calib/rig.hpp"
#include "calib/robot_rig.hpp"
#include "compensation/tilt_estimator.hpp"
#include "localization/robot/sensors.hpp"

namespace ceilmap::recordings {

/// The recordings beside that of the upward camera; empty: there is none.
struct SensorFiles {
  std::string forward;
  std::filesystem::path forward_stamps;  ///< empty: `stamps`
  std::string omni;
  std::filesystem::path omni_stamps;    ///< empty: `stamps`
  std::filesystem::path headings;       ///< files::ReadHeadings
  std::filesystem::path odometry;       ///< files::ReadOdometry
  std::filesystem::path gyro;           ///< files::ReadGyro
  std::filesystem::path heading_model;  ///< colour::ReadColourModel
  BagTopic forward_topic;               ///< of those that are bags
  BagTopic omni_topic;
  BagTopic odometry_topic;
  BagTopic gyro_topic;
  HeadingFrame headings_frame = HeadingFrame::kRelative;
  std::optional<compensation::TiltMethod> tilt;  ///< nothing: tilt is not measured
  std::filesystem::path stamps;                  ///< of the upward frames
};

/// Says which topics of bags will be read (ReserveTopic). To be called before the upward camera is
/// read. @throws InputError
void ReserveTopics(const SensorFiles& files);

/// Prints where bags describe other cameras than the rig (CompareCamera).
/// @param rig  fitted to the recordings.
void PrintCameraDifferences(const calib::Rig& rig,
                            const std::string& up,
                            const BagTopic& up_topic,
                            const SensorFiles& files);

/// Reads the recordings beside that of the upward camera and adds them to a mapper or localizer.
class SensorInputs {
 public:
  /// @param rig  its cameras are fitted to the recordings (calib/robot_rig.hpp).
  /// @throws InputError when a file cannot be used or does not fit the rig.
  SensorInputs(const SensorFiles& files, std::optional<calib::Rig>& rig);

  /// What the mapper or localizer has to know of these recordings.
  /// @param params  what the recordings do not determine is left as it is.
  [[nodiscard]] robot::SensorsParams Params(robot::SensorsParams params = {}) const;
  /// Adds the headings of the file, before the first image.
  void AddHeadings(robot::Sensors& sensors) const;
  /// Adds the images of each camera as far as the first one that is later than `stamp_s`, and the
  /// samples of wheels and gyro up to a moment after it.
  void ReadTo(double stamp_s, robot::Sensors& sensors);

  /// Null where there is no recording.
  [[nodiscard]] const SensorStream* Forward() const { return forward_.get(); }
  [[nodiscard]] const SensorStream* Omni() const { return omni_.get(); }
  [[nodiscard]] const WheelInputs& Wheels() const { return wheels_; }
  [[nodiscard]] const std::filesystem::path& HeadingFile() const { return files_.headings; }
  /// Cameras of the rig that were scaled.
  [[nodiscard]] const std::vector<calib::CameraScaling>& Scalings() const { return scalings_; }

 private:
  SensorFiles files_;
  std::unique_ptr<SensorStream> forward_;
  std::unique_ptr<SensorStream> omni_;
  std::vector<calib::CameraScaling> scalings_;
  WheelInputs wheels_;
};

}  // namespace ceilmap::recordings
