#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "calib/ceiling_view.hpp"
#include "mapping/keyframe.hpp"
#include "mapping/map_file.hpp"
#include "mapping/mosaic.hpp"
#include "mapping/odometry.hpp"

namespace ceilmap::mapping {

struct MapperParams {
  Pose2 origin;  ///< T_map_base of the first mapped frame
  OdometryParams odometry;
  MosaicParams mosaic;
};

/// What a mapping run did, for the summary and for people.
struct MapperReport {
  std::int64_t frames = 0;
  std::int64_t tracked = 0;
  std::int64_t lost = 0;
  std::int64_t ambiguous = 0;
  std::int64_t without_texture = 0;  ///< part of lost
  std::int64_t keyframes = 0;
  double median_peak = 0;
  double path = 0;  ///< length of the trajectory in map units
  MosaicGrid grid;
  double rectify_ms = 0;  ///< totals over the run
  double register_ms = 0;
  double keyframe_ms = 0;
  double mosaic_ms = 0;
};

/// From frames to a map file: odometry against the last keyframe, keyframes into the map file as
/// they come, the mosaic at the end. Memory does not grow with the number of pixels mapped.
class Mapper {
 public:
  /// @param view, writer  must outlive the mapper.
  Mapper(const calib::CeilingView& view,
         MapWriter& writer,
         const MapMetadata& metadata,
         const MapperParams& params = {});
  ~Mapper();

  /// Takes the next frame: CV_8UC1 raw picture of the view's size; stamps must increase.
  /// A frame that cannot be placed comes back as kLost or kAmbiguous and gets no line in the
  /// trajectory.
  FramePose Process(const cv::Mat& raw_grey, std::int64_t frame_index, double stamp_s);

  /// Writes keyframes, trajectory, edges and mosaic to the writer (without Commit).
  /// @param progress  done, total tiles of the mosaic.
  /// @throws calib::RunError when no frame showed any texture.
  void Finish(const std::function<void(int, int)>& progress = {});

  [[nodiscard]] const std::vector<FramePose>& Trajectory() const;  ///< placed frames only
  [[nodiscard]] const MapperReport& Report() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ceilmap::mapping
