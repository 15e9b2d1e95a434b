#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "calib/base/stamped_pose.hpp"
#include "localization/compass/travel_forecast.hpp"

namespace ceilmap::commands {

/// Largest difference in time between a frame and its pose, s.
inline constexpr double kMaxPoseDtS = 0.02;

/// Travel of the camera under a mirror between frames, from a file of poses.
class KnownTravel {
 public:
  /// @param file  TUM; empty: nothing is known. @param camera  Position on the robot, base frame,
  /// m.
  KnownTravel(const std::filesystem::path& file, const Eigen::Vector2d& camera);

  /// Since the frame before. Frames in the order of their times; the newest pose before a frame is
  /// that of the frame.
  std::optional<Eigen::Vector2d> To(double stamp_s);
  /// Number of frames with a known travel.
  [[nodiscard]] std::int64_t Reported() const { return reported_; }

 private:
  std::vector<StampedPose> poses_;
  std::size_t next_ = 0;
  compass::TravelForecast forecast_;
  std::optional<double> last_s_;
  std::int64_t reported_ = 0;
};

}  // namespace ceilmap::commands
