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

enum class Labrosse2006Variant : std::uint8_t {
  kPublished,
  /// `labrosse2006-probes`. The search begins at the turn that continues the rate before, so that
  /// turns faster than the probes reach are followed once they are known. The depth of a minimum is
  /// its RelativeDepth among the probes, which decides the change of reference and is the linear
  /// part of the sub-pixel minimum; it needs no distances beyond those of the search.
  kProbes
};

struct Labrosse2006Params {
  /// Width of each of the two fields of view, centred on the direction of travel and its opposite,
  /// rad, in (0, 2 pi]; 2 pi: the whole view.
  double field_of_view_rad = std::numbers::pi / 3;
  /// A reference is kept until the normalised amplitude of its minimum falls below this, [0, 1]. 0:
  /// it is kept forever; 1: it is kept for one frame. Not used with `skip`.
  double threshold = 0.6055;
  /// Empty: references by the threshold ("Atm"). n >= 0: every (n+1)-th frame is used, and compared
  /// with the one used before ("Fx n").
  std::optional<int> skip = std::nullopt;
  Labrosse2006Variant variant = Labrosse2006Variant::kPublished;

  void Validate() const;  ///< throws InputError naming field, value and range
};

/// The compass of Labrosse, "The visual compass: performance and limitations of an appearance-based
/// method", Journal of Field Robotics 2006, Algorithm 1 and Table 2. Panoramas of 360 x 45 RGB in
/// the paper, any size here.
///
/// The turn since a reference panorama is the column shift of least Euclidean distance d = sqrt(sum
/// of squared colour differences), over those columns of the current panorama that lie in fields of
/// view ahead and behind. The fields follow the direction of travel; the reference is shifted under
/// them. FindShift searches from the turn of the previous frame, and BlendedMinimum computes the
/// fraction. When the normalised amplitude falls below the threshold, the previous frame becomes
/// the reference and the turn is measured again, the search starting from 0.
///
/// What the paper leaves open:
/// - Eq. 12 needs a distance between two columns: it is interpolated linearly.
/// - Fixed skips ("Fx n") compare successive frames that are used; their search starts from 0 too.
/// - A frame without texture, or with a normalised amplitude below 0.05, has no result and leaves
///   the heading unchanged; the paper's method fails there. If the following frame does not fit the
///   reference either, a new reference is created there.
/// - The fields of a reference compared with itself are those of its own frame.
/// - The variance: the paper has none.
///
/// Time: a few shifts per frame instead of all. Panoramas are copied.
class Labrosse2006 : public compass::Compass {
 public:
  explicit Labrosse2006(const Labrosse2006Params& params = {});

  std::optional<compass::HeadingEstimate> Next(const compass::PanoramaFrame& frame) override;
  /// Profile over the fields of view of the last frame. Time: columns x one distance.
  [[nodiscard]] compass::DistanceProfile Profile() const override;
  [[nodiscard]] std::int64_t References() const override { return references_; }

 private:
  /// A panorama and the heading assigned to it.
  struct View {
    cv::Mat panorama;
    std::vector<float> weights;  ///< of its columns
    std::int64_t frame = 0;
    double stamp_s = 0;
    compass::HeadingEstimate estimate;
    bool measured = false;  ///< false: its heading was held, not measured
    /// Compared with itself: Eq. 7 and 9. Only of a reference.
    double own_amplitude = 0;
    double own_column_amplitude = 0;
  };
  struct Measurement {
    double shift_columns = 0;
    double amplitude = 0;  ///< normalised
    double variance_columns2 = 0;
  };

  class Distances;

  void Begin(const compass::PanoramaFrame& frame, bool textured);
  void Follow(const compass::PanoramaFrame& frame);
  [[nodiscard]] Measurement Measure() const;
  [[nodiscard]] double ExpectedHeading() const;
  [[nodiscard]] bool PreviousIsBetter(const Measurement& measured) const;
  void PreviousBecomesReference();
  void MeasureReference();
  [[nodiscard]] Measurement Interpolated(const Distances& distances, const FoundShift& found) const;
  void Accept(const Measurement& measured, double stamp_s);
  void Hold(double stamp_s);

  Labrosse2006Params params_;
  compass::FrameCheck check_;
  compass::TravelTrack travel_;
  std::vector<float> weights_;  ///< weights of the last frame's columns
  cv::Mat current_;
  View reference_;  ///< empty: no usable panorama so far
  View previous_;   ///< the previous textured frame; may be the reference itself
  std::int64_t references_ = 0;
  bool compared_ = false;
  compass::HeadingEstimate estimate_;
  // State at the last frame that was measured.
  compass::HeadingEstimate last_;
  double last_stamp_s_ = 0;
  double turn_per_frame_rad_ = 0;
  int frames_since_ = 0;  ///< number of frames used since then
};

}  // namespace ceilmap::labrosse
