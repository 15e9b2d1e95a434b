#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "calib/ceiling_view.hpp"
#include "calib/rig.hpp"
#include "localization/robot/estimate.hpp"
#include "localization/robot/sensors.hpp"
#include "mapping/map_merge.hpp"
#include "mapping/mapper.hpp"

namespace ceilmap::robot {

/// Progress of a long call: done, total.
using ProgressFunction = std::function<void(int, int)>;

struct CeilingMapperParams {
  SensorsParams sensors;
  mapping::MapperParams mapping;
  /// Extend the map, wherever on it the recording begins. mapping.origin is then not used.
  /// The value says which of its poses may change; nothing: the map is made anew.
  std::optional<mapping::HeldPoses> append;
  /// Of the mosaic, map units per pixel, > 0; nothing: that of the camera, or of the extended map.
  std::optional<double> resolution;
  std::string source = "the recording";  ///< its name in messages
  std::string provenance;                ///< stored in the map, one line
};

/// Builds a map of the ceiling while a robot drives: the object that a robot's program holds. Tilt
/// and heading are measured beside the upward camera and used for each frame.
///
/// Not thread-safe. One to four threads of its own work while a frame is measured. Images of
/// keyframes are written to a hidden file beside the map as they arrive, so that memory does not
/// grow with the area.
class CeilingMapper : public Sensors {
 public:
  /// @param rig  needs an upward camera. @param map  ends in .gpkg. The file appears complete with
  ///   Finish() or Commit(); until then, and without, the one that was there stays.
  /// @throws InputError when the file cannot be written, the rig lacks what the parameters need, or
  ///   the map that is to be extended does not fit.
  CeilingMapper(const calib::Rig& rig,
                const std::filesystem::path& map,
                const CeilingMapperParams& params = {});
  /// A camera without a rig: lengths are in pixels of its image, and no other camera is used.
  /// @param size  of the images. @throws InputError as above.
  CeilingMapper(cv::Size size,
                const std::filesystem::path& map,
                const CeilingMapperParams& params = {});
  ~CeilingMapper();

  /// Adds an image; images of other sensors that belong to it must have been added. The pose is
  /// that of the odometry; Finish() optimizes all poses together.
  /// @throws InputError on an image of another size or type, or a stamp that does not increase. The
  ///   content of an image never causes an exception.
  Estimate AddCeiling(const Image& up);

  /// For recordings, at a higher rate: tilt and heading of this image are measured in the
  /// background while the image before is mapped. Feedback reaches the sensors one frame later.
  /// @return the robot at the image before; nothing for the first one. @throws as AddCeiling.
  std::optional<Estimate> AddCeilingPipelined(const Image& up);
  /// The robot at the last image of AddCeilingPipelined; nothing when there is none.
  std::optional<Estimate> Flush();

  /// Optimizes all poses and draws the mosaic, without making the file appear. No image after it.
  /// @throws RunError when no frame showed any texture, or when the recording does not join the map
  ///   that it was to extend.
  mapping::MappingResult Draw(const ProgressFunction& progress = {});
  /// Makes the file appear, after Draw. @throws RunError when the disk refuses.
  void Commit();
  /// Draw, then Commit.
  mapping::MappingResult Finish(const ProgressFunction& progress = {});

  /// The image of the last estimate, rectified: CV_8UC1 of the view's size.
  [[nodiscard]] const cv::Mat& Rectified() const;
  /// Frames placed so far.
  [[nodiscard]] std::size_t PlacedFrames() const;
  [[nodiscard]] const calib::CeilingView& View() const;
  [[nodiscard]] const store::MapMetadata& Metadata() const;

 private:
  CeilingMapper(const std::optional<calib::Rig>& rig,
                const calib::CeilingView& view,
                const std::filesystem::path& map,
                const CeilingMapperParams& params);
  Estimate Map(const Frame& frame);

  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ceilmap::robot
