#pragma once

#include <cstdint>
#include <numbers>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "localization/compass/compass.hpp"
#include "localization/compass/frame_check.hpp"
#include "localization/compass/labrosse/shift_search.hpp"
#include "localization/compass/travel_track.hpp"

namespace ceilmap::labrosse {

/// Where the search for the shift begins.
enum class ExpectedTurn : std::uint8_t {
  kAsBefore,  ///< the robot turns on as between the two frames before
  kNone       ///< it still looks where it looked a frame ago
};

struct Labrosse2006Params {
  /// Of each of the two fields of view, around the direction of travel and its opposite, rad, in
  /// (0, 2 pi]; 2 pi: the whole view.
  double field_of_view_rad = std::numbers::pi / 3;
  /// A reference is kept until the normalised amplitude of its minimum falls below this, [0, 1].
  /// 0: for ever; 1: for one frame. Not used with `skip`.
  double threshold = 0.6055;
  /// Nothing: references by the threshold ("Atm"). n >= 0: every (n+1)-th frame is used, and
  /// compared with the one used before ("Fx n").
  std::optional<int> skip = std::nullopt;
  ExpectedTurn expected = ExpectedTurn::kAsBefore;
  ShiftSearchParams search = {};
  /// A panorama that changes less than this along its rows in the fields of view (RowTexture, grey
  /// levels, >= 0) tells nothing: it is uniform but for noise.
  double min_texture = 2;
  /// Below this normalised amplitude, [0, 1), the minimum is none: the panoramas do not show the
  /// same surroundings.
  double min_amplitude = 0.05;
  /// Width over which the differences of two panoramas are one error, rad, > 0: 4 deg, from the
  /// errors of single measurements on recordings. Only the variance depends on it.
  double independent_rad = std::numbers::pi / 45;
  /// Error of the sub-pixel minimum between panoramas that agree, columns, > 0.
  double interpolation_sigma_columns = 0.05;
  /// While nothing can be measured: standard deviation of the rate at which the robot may turn,
  /// rad/s, > 0.
  double unseen_rate_rad_s = 0.5;

  void Validate() const;  ///< throws InputError naming field, value and range
};

/// The compass of Labrosse, "The visual compass: performance and limitations of an appearance-based
/// method", Journal of Field Robotics 2006, Algorithm 1. Panoramas of 360 x 45 RGB in the paper,
/// any size here.
///
/// The turn since a reference panorama is the column shift of least Euclidean distance
/// d = sqrt(sum of squared colour differences), taken over those columns of the current panorama
/// that lie in fields of view ahead and behind; these follow the direction of travel. The reference
/// is shifted under them. FindShift looks for it from where the turn is expected, BlendedMinimum
/// gives its fraction. When the normalised amplitude of the minimum falls below the threshold the
/// frame before becomes the reference, and the turn is measured again.
///
/// As reconstructed: the blend of the sub-pixel minimum (see BlendedMinimum), and that the
/// normalised amplitude is that of the minimum and the probes around it (see FindShift): indoors
/// the threshold of 0.6055 then keeps a reference for 2 to 4 frames of 5 cm.
///
/// A frame without an answer (uniform, or unlike the reference) leaves the heading as it is. If
/// what follows does not fit the reference either, a new one begins there.
///
/// Time: a few shifts a frame instead of all. Panoramas are copied.
class Labrosse2006 : public compass::Compass {
 public:
  explicit Labrosse2006(const Labrosse2006Params& params = {});

  std::optional<compass::HeadingEstimate> Next(const compass::PanoramaFrame& frame) override;
  /// Over the fields of view of the last frame. Time: columns x a distance.
  [[nodiscard]] compass::DistanceProfile Profile() const override;
  [[nodiscard]] std::int64_t References() const override { return references_; }

 private:
  /// A panorama and the heading it was given.
  struct View {
    cv::Mat panorama;
    std::int64_t frame = 0;
    double stamp_s = 0;
    compass::HeadingEstimate estimate;
    bool measured = false;  ///< else its heading is one that was held
  };
  struct Measurement {
    double shift_columns = 0;
    double amplitude = 0;
    double variance_columns2 = 0;
  };

  void Begin(const compass::PanoramaFrame& frame, bool textured);
  void Follow(const compass::PanoramaFrame& frame);
  [[nodiscard]] Measurement Measure() const;
  [[nodiscard]] double ExpectedHeading() const;
  [[nodiscard]] bool PreviousIsBetter(const Measurement& measured) const;
  void PreviousBecomesReference();
  void Accept(const Measurement& measured, double stamp_s);
  void Hold(double stamp_s);

  Labrosse2006Params params_;
  compass::FrameCheck check_;
  compass::TravelTrack travel_;
  std::vector<float> weights_;  ///< of the last frame's columns
  cv::Mat current_;
  View reference_;  ///< empty: nothing usable was seen yet
  View previous_;   ///< the textured frame before, perhaps the reference itself
  std::int64_t references_ = 0;
  bool compared_ = false;
  compass::HeadingEstimate estimate_;
  // Of the last frame that was measured.
  compass::HeadingEstimate last_;
  double last_stamp_s_ = 0;
  double turn_per_frame_rad_ = 0;
  int frames_since_ = 0;  ///< that were used
};

}  // namespace ceilmap::labrosse
