#include "mapping/mapper_settings.hpp"

namespace ceilmap::mapping {
namespace {

using Range = SettingRange;

void DescribeRegistration(registration::RegistrarParams& params, const Settings& settings) {
  settings.Add("final_blocks",
               params.final_blocks,
               "",
               Range::AtLeast(8),
               "Blocks that are compared in the last rounds of a registration.");
  settings.Add("min_inliers",
               params.min_inliers,
               "",
               Range::AtLeast(3),
               "Blocks that must agree with the motion.");
  settings.Add("min_agreement",
               params.min_agreement,
               "",
               Range::Closed(0, 4),
               "Agreement from which dissimilar images are accepted (other light, blur).");
  settings.Add("min_block_agreement",
               params.min_block_agreement,
               "",
               Range::Closed(0, 2),
               "Agreement of the blocks alone that very dissimilar images must also reach.");
  settings.Add("min_partial_inliers",
               params.min_partial_inliers,
               "",
               Range::Closed(0, 1),
               "Inlier ratio from which images are accepted although a part of the ceiling has "
               "changed.");
  settings.Add("refine_poc_peak",
               params.refine_poc_peak,
               "",
               Range::Closed(0, 1),
               "Used as the peak of the whole images where only blocks are compared.");
}

void DescribeOdometry(OdometryParams& params, const Settings& settings) {
  settings.Add("min_overlap",
               params.min_overlap,
               "",
               Range::Open(0, 1),
               "A new keyframe is made when less than this fraction of the last one is in view.");
  settings.Add("recent_keyframes",
               params.recent_keyframes,
               "",
               Range::AtLeast(1),
               "Keyframes that are compared when the robot is lost, latest first.");
  settings.Add("local_keyframes",
               params.local_keyframes,
               "",
               Range::AtLeast(1),
               "Keyframes that a new keyframe is registered against, if they overlap.");
  settings.Add("heading_noise_rad",
               params.heading_noise_rad,
               "rad",
               Range::Above(0),
               "Smallest standard deviation of a single heading.");
  settings.Add("uneven_ratio",
               params.uneven_ratio,
               "image sides",
               Range::Above(0),
               "Largest difference of a position from constant velocity.");
  settings.Add("uneven_rad",
               params.uneven_rad,
               "rad",
               Range::Above(0),
               "Largest difference of an orientation from constant velocity.");
  settings.Add("restart_after",
               params.restart_after,
               "frames",
               Range::AtLeast(1),
               "A new segment begins after this number of consecutive frames that match no known "
               "place.");
  const Settings noise = settings.In("noise");
  noise.Add("systematic_px",
            params.noise.systematic_px,
            "px",
            Range::Above(0),
            "Standard deviation of a shift between images by errors that residuals do not show.");
  noise.Add("systematic_rad",
            params.noise.systematic_rad,
            "rad",
            Range::Above(0),
            "The same for the rotation.");
  DescribeRegistration(params.registration, settings.In("registration"));
}

void DescribeLoops(LoopCloserParams& params, const Settings& settings) {
  settings.Add("comparisons_per_keyframe",
               params.comparisons_per_keyframe,
               "",
               Range::AtLeast(0),
               "Largest number of registrations for loop closures; 0: no loop is closed.");
  settings.Add("closures_per_keyframe",
               params.closures_per_keyframe,
               "",
               Range::AtLeast(0),
               "Largest number of loop closures of a keyframe.");
  const Settings candidates = settings.In("candidates");
  candidates.Add("min_overlap",
                 params.candidates.min_overlap,
                 "",
                 Range::Open(0, 1),
                 "Smallest shared fraction of the images of candidates by position.");
  candidates.Add("min_keyframe_gap",
                 params.candidates.min_keyframe_gap,
                 "keyframes",
                 Range::AtLeast(1),
                 "Preceding keyframes that place recognition excludes.");
  const Settings judge = settings.In("judge");
  judge.Add("max_contradicting_ratio",
            params.judge.max_contradicting_ratio,
            "",
            Range::AtLeast(0),
            "A closure is rejected when the closures that contradict it exceed this fraction of "
            "those that support it.");
  judge.Add("confirm_within",
            params.judge.confirm_within,
            "keyframes",
            Range::AtLeast(1),
            "An unconfirmed closure is kept for this time.");
}

void DescribePoseGraph(graph::PoseGraphParams& params, const Settings& settings) {
  settings.Add("loop_loss_scale",
               params.loop_loss_scale,
               "sigmas",
               Range::AtLeast(0),
               "Scale of the robust loss of loop closures; 0: plain squares.");
  settings.Add("odometry_loss_scale",
               params.odometry_loss_scale,
               "sigmas",
               Range::AtLeast(0),
               "The same for odometry edges.");
  settings.Add("max_iterations",
               params.max_iterations,
               "",
               Range::AtLeast(1),
               "Largest number of iterations from each start.");
  settings.Add("function_tolerance",
               params.function_tolerance,
               "",
               Range::Above(0),
               "The optimization ends when the relative decrease of the cost is smaller.");
  settings.Add("threads", params.threads, "", Range::AtLeast(0), "Threads; 0: all cores.");
}

void DescribeMosaic(mosaic::MosaicParams& params, const Settings& settings) {
  settings.Add("sharpness_power",
               params.sharpness_power,
               "",
               Range::Closed(0, 64),
               "Exponent of the weight of blurred images; 0: all images have equal weight.");
  settings.Add("level_exposure",
               params.level_exposure,
               "Whether gain differences and vignetting are removed.");
  settings.Add("reject_outliers",
               params.reject_outliers,
               "Whether content that one image shows but most others of the place do not is "
               "excluded.");
  settings.Add("cache_images",
               params.cache_images,
               "images",
               Range::AtLeast(1),
               "Decoded images that are kept in memory.");
  settings.Add("threads", params.threads, "", Range::AtLeast(0), "Threads; 0: all cores.");
}

}  // namespace

void Describe(MapperParams& params, const Settings& settings) {
  DescribeOdometry(params.odometry, settings.In("odometry"));
  DescribeLoops(params.loops, settings.In("loops"));
  DescribePoseGraph(params.pose_graph, settings.In("pose_graph"));
  DescribeMosaic(params.mosaic, settings.In("mosaic"));
}

}  // namespace ceilmap::mapping
