#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "calib/ceiling_view.hpp"
#include "mapping/frame_context.hpp"
#include "mapping/graph/keyframe.hpp"
#include "mapping/graph/map_graph.hpp"
#include "mapping/loop_closer.hpp"
#include "mapping/mosaic/mosaic.hpp"
#include "mapping/odometry.hpp"
#include "mapping/store/map_file.hpp"

namespace ceilmap::mapping {

struct MapperParams {
  Pose2 origin;  ///< T_map_base of the first mapped frame
  OdometryParams odometry;
  LoopCloserParams loops;
  graph::PoseGraphParams pose_graph;  ///< of the optimization of all poses at the end
  mosaic::MosaicParams mosaic;
  std::int64_t first_keyframe_id = 0;  ///< for a recording that is added to an existing map
};

/// Statistics of a mapping run.
struct MapperReport {
  std::int64_t frames = 0;
  std::int64_t tracked = 0;
  std::int64_t lost = 0;
  std::int64_t ambiguous = 0;
  std::int64_t predicted = 0;        ///< part of lost and ambiguous: the wheels know the pose
  std::int64_t without_texture = 0;  ///< part of lost
  /// Tracked, but in a segment that is not connected with the map.
  std::int64_t unconnected = 0;
  /// Estimated number of frames that are missing although the stamps have no gap (MissingFrames).
  std::int64_t missing = 0;
  std::int64_t repeated = 0;  ///< part of ambiguous: images that repeat the one before
  double coding_loss = 0;     ///< mean of FrameSpectrum::CodingLoss, 0..1
  std::int64_t keyframes = 0;
  graph::MapQuality quality;
  double median_peak = 0;
  double path = 0;  ///< length of the trajectory in map units
  store::MosaicGrid grid;
  std::vector<store::LeftOut> left_out;  ///< what images show, but the mosaic does not
  double rectify_ms = 0;                 ///< totals over the run
  double register_ms = 0;
  double keyframe_ms = 0;
  double loop_ms = 0;      ///< loop closing, in its own thread
  double optimize_ms = 0;  ///< the full pose graph at the end
  double mosaic_ms = 0;
};

/// Result of mapping one recording.
struct MappingResult {
  std::vector<graph::FramePose> frames;  ///< of the recording, on the map; placed ones only
  /// Frames that were not placed, but whose pose the wheels know; the map has them too.
  std::vector<graph::FramePose> predicted;
  MapperReport report;  ///< of the recording; grid, left_out, quality and keyframes of the map
  std::vector<graph::WeakSpot> weak_spots;  ///< of the whole map

  /// Adds a frame of the trajectory to those of its kind.
  void Add(const graph::FramePose& frame) {
    (graph::HasPose(frame.status) ? frames : predicted).push_back(frame);
  }
};

/// Builds a map from frames. Odometry registers frames against the last keyframe; images of
/// keyframes are written to the map file as they arrive; loop closing runs in its own thread, one
/// keyframe behind and synchronized at fixed points, so that the same recording always gives the
/// same map. At the end all poses are optimized together, and the mosaic is rendered. Memory does
/// not grow with the number of pixels mapped.
class Mapper {
 public:
  /// @param view, writer  must outlive the mapper.
  Mapper(const calib::CeilingView& view,
         store::MapWriter& writer,
         const store::MapMetadata& metadata,
         const MapperParams& params = {});
  ~Mapper();

  /// Processes the next frame: CV_8UC1 raw image of the view's size; stamps must increase.
  /// @param context  Tilt of the robot, where it is known: it is removed from the image and
  /// returned with the pose; needs a view of a rig. Heading, where a compass gives one: it resolves
  /// orientations with the same images (Odometry, LoopCloser, JoinParts). A frame that cannot be
  /// placed is returned as kLost or kAmbiguous and is not added to the trajectory.
  /// @throws InputError on a heading that is not finite or without variance.
  graph::FramePose Process(const cv::Mat& raw_grey,
                           std::int64_t frame_index,
                           double stamp_s,
                           const FrameContext& context = {});
  /// The same with an image that is rectified, and analysed as far as its spectrum goes, already.
  graph::FramePose Process(const registration::AnalyzedImage& rectified,
                           std::int64_t frame_index,
                           double stamp_s,
                           const FrameContext& context = {});

  /// The wheels turned out to be wrong (wheels::WheelFault): Close() leaves out what they alone
  /// know. Parts of the drive that only they connect are joined by their images, or left out.
  void ForgetWheels();
  /// Slips of the wheels that the whole drive showed. Parts that only wheels connect were connected
  /// with those that had been seen until then: Close() adds the others to their covariance.
  void TakeSlips(const wheels::SlipRate& slips);

  /// Ends the recording and optimizes all poses together. No Process after it.
  /// @throws RunError when no frame showed any texture.
  void Close();
  /// Close(), then writes the map and its mosaic to the writer (without Commit).
  /// @param progress  done, total tiles of the mosaic.
  MappingResult Finish(const std::function<void(int, int)>& progress = {});

  /// Placed frames only; before Close() with the poses of the odometry.
  [[nodiscard]] const std::vector<graph::FramePose>& Trajectory() const;
  /// The map without images; complete after Close().
  [[nodiscard]] const graph::MapGraph& Graph() const;
  [[nodiscard]] const MapperReport& Report() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ceilmap::mapping
