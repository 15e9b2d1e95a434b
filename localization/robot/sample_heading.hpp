#pragma once

#include "localization/heading_track.hpp"
#include "localization/robot/heading_source.hpp"

namespace ceilmap::robot {

/// Headings of another program or sensor, interpolated at the times of upward frames.
class SampleHeading : public HeadingSource {
 public:
  explicit SampleHeading(HeadingFrame frame);

  [[nodiscard]] HeadingFrame Frame() const { return frame_; }
  /// @throws InputError on an invalid sample, or one that is not later than the one before.
  void Add(const HeadingSample& sample) { track_.Add(sample); }

  std::optional<HeadingPrior> At(double stamp_s,
                                 const Image* image,
                                 const std::optional<wheels::RelativeTurn>& turn) override;
  void Locate(double /*stamp_s*/, const std::optional<Pose2>& /*T_map_base*/) override {}
  [[nodiscard]] HeadingReport Report() const override { return report_; }

 private:
  HeadingFrame frame_;
  localization::HeadingTrack track_;
  HeadingReport report_;
};

}  // namespace ceilmap::robot
