#pragma once

#include <optional>

#include "localization/robot/heading_source.hpp"

namespace ceilmap::robot {

/// Headings by a gyro alone: the sum of its turns from one upward frame to the next. They count
/// from the first frame, and their variance grows with the noise and the bias of the gyro.
class GyroHeading : public HeadingSource {
 public:
  GyroHeading();

  /// @param turn  since the upward frame before; nothing: the gyro does not tell it, or there was
  /// none. Then the heading is not known, and the next one is independent of those before.
  std::optional<HeadingPrior> At(double stamp_s,
                                 const Image* image,
                                 const std::optional<wheels::RelativeTurn>& turn) override;
  void Locate(double /*stamp_s*/, const std::optional<Pose2>& /*T_map_base*/) override {}
  [[nodiscard]] HeadingReport Report() const override { return report_; }

 private:
  wheels::RelativeTurn turned_;  // since the first frame
  bool began_ = false;
  HeadingReport report_;
};

}  // namespace ceilmap::robot
