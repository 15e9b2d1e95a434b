#pragma once

#include <optional>

#include "app/reports/localize_report.hpp"
#include "localization/robot/estimate.hpp"

namespace ceilmap::commands {

/// Sums over the frames of `localize`: first pose, length of the path, mean accuracy.
class LocalizeTally {
 public:
  void Add(const robot::Estimate& estimate, reports::LocalizeResult& result);

 private:
  std::optional<double> first_stamp_s_;
  bool had_pose_ = false;  // of the previous frame
  Pose2 last_;
  double variances_ = 0;
  std::int64_t placed_ = 0;
};

}  // namespace ceilmap::commands
