#pragma once

#include <cstdint>
#include <optional>

#include "calib/base/heading.hpp"
#include "calib/base/pose2.hpp"
#include "calib/wheels/relative_motion.hpp"
#include "localization/robot/image.hpp"

namespace ceilmap::robot {

/// The sensor from which headings come.
enum class HeadingSensor {
  kMirror,   ///< visual compass on the camera under a convex mirror
  kColours,  ///< colours that the forward camera sees, against a learned model
  kSamples,  ///< headings of another program (AddHeading)
  kGyro,     ///< turns by a gyro, of a robot without wheels
};

/// Counts of a source of headings.
struct HeadingReport {
  HeadingSensor sensor = HeadingSensor::kMirror;
  std::int64_t headings = 0;
  /// Mirror: images without information, for which the heading was held. Colours: headings that
  /// were not unique.
  std::int64_t uncertain = 0;
  std::int64_t missing = 0;        ///< upward frames without image or sample at their time
  std::int64_t references = 0;     ///< mirror: panoramas that became the reference
  std::int64_t below_horizon = 0;  ///< colours: frames that show only what is below the horizon
  double last_sigma_rad = 0;       ///< of the last heading
  double largest_offset_s = 0;     ///< between matched images
  double compute_ms = 0;           ///< total
};

/// Headings at the times of upward frames, from one sensor.
class HeadingSource {
 public:
  virtual ~HeadingSource() = default;

  /// The heading at the time of an upward frame; nothing when there is none. Stamps must increase.
  /// May run in another thread than the calls before, one call at a time.
  /// @param image  of the sensor's camera, nearest in time; null: none.
  /// @param turn  by wheels or gyro, since the image before, where it is another one.
  /// @throws InputError on an image that does not fit the rig.
  virtual std::optional<HeadingPrior> At(double stamp_s,
                                         const Image* image,
                                         const std::optional<wheels::RelativeTurn>& turn) = 0;
  /// The pose of the robot at an earlier upward frame, or that it is not known.
  virtual void Locate(double stamp_s, const std::optional<Pose2>& T_map_base) = 0;
  [[nodiscard]] virtual HeadingReport Report() const = 0;

 protected:
  HeadingSource() = default;
  HeadingSource(const HeadingSource&) = default;
  HeadingSource& operator=(const HeadingSource&) = default;
};

}  // namespace ceilmap::robot
