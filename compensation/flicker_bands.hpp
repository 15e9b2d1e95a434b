#pragma once

#include <cstdint>
#include <deque>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "calib/base/pose2.hpp"
#include "calib/base/twist2.hpp"
#include "calib/ceiling_view.hpp"
#include "compensation/band_fit.hpp"

namespace ceilmap::compensation {

/// Removes the bands that lamps on the mains (100 or 120 Hz) draw into the rows of a camera with a
/// rolling shutter. They are no part of the ceiling: they stay in the image while the ceiling
/// moves, or move by themselves, and so spoil the registration and the mosaic.
///
/// The bands are measured from the images before (BandFit), whose ceiling points are found again by
/// the motion of the robot, and predicted by their frequency for the next image. Stamps must
/// therefore be exact to a millisecond; with worse ones nothing is found and nothing removed.
///
/// For each image: Remove(), then Place() when its pose is known, in this order, also when several
/// images are removed before the first of them is placed. Not thread-safe. Takes 0.5 ms for 640 x
/// 480 px.
class FlickerBands {
 public:
  /// Whether bands of the mains can be seen with this read-out time, of whatever sign.
  static bool Visible(double readout_time_s);

  /// @param view  With a rolling shutter; only its parameters are kept.
  FlickerBands(const calib::CeilingView& view, double readout_time_s);

  /// @param raw  CV_8UC1 of view.RawSize(); its rows divided by the predicted bands are returned:
  ///   `raw` itself where no bands were found. Black and saturated pixels remain.
  cv::Mat Remove(const cv::Mat& raw, double stamp_s);
  /// An image divided by given bands, for example by those that were found later. CV_8UC1.
  [[nodiscard]] cv::Mat Without(const Bands& bands, const cv::Mat& raw, double stamp_s);

  /// The pose of the oldest image that was not placed; nothing when it is not known.
  void Place(double stamp_s, const std::optional<Pose2>& T_map_base);
  /// Before Place() without a pose: the mean velocity since the image before.
  void Move(const StampedTwist2& velocity) { velocity_ = velocity.velocity; }

  /// The bands that are being removed.
  [[nodiscard]] const std::optional<Bands>& Found() const { return found_; }

 private:
  struct Seen {
    double stamp_s = 0;
    cv::Mat small;  // reduced raw image, CV_32FC1
    Pose2 T_odom_base;
  };
  /// Where a pixel of the view finds its content in the raw image.
  struct RawPoint {
    double u = 0;
    double v = 0;
  };
  [[nodiscard]] cv::Mat Reduce(const cv::Mat& raw) const;
  [[nodiscard]] std::optional<RawPoint> RawAt(const Eigen::Vector2d& view_pixel) const;
  [[nodiscard]] std::optional<double> LogGrey(const Seen& seen, const RawPoint& at) const;
  [[nodiscard]] double RowTime(double v) const;
  [[nodiscard]] double Radius2(const RawPoint& at) const;
  [[nodiscard]] const Seen* Partner(const Pose2& T_odom_base) const;
  [[nodiscard]] std::vector<BandSample> Compare(const Seen& later, const Seen& earlier) const;

  calib::CeilingView view_;
  double readout_time_s_;
  int factor_;
  std::vector<Eigen::Vector2d> lattice_;  // pixels of the view
  BandFit fit_;
  std::optional<Bands> found_;
  std::uint32_t removed_ = 0;        // images, the seed of their rounding
  std::deque<Seen> waiting_;         // without a pose yet
  std::deque<Seen> placed_;          // the latest last
  std::optional<Pose2> T_map_base_;  // of the last image, where known
  std::optional<Twist2> velocity_;
};

}  // namespace ceilmap::compensation
