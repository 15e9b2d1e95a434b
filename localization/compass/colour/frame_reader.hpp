#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "localization/compass/colour/colour_classes.hpp"
#include "localization/compass/colour/exposure_belief.hpp"
#include "localization/compass/colour/line_features.hpp"
#include "localization/compass/colour/scan_lines.hpp"

namespace ceilmap::colour {

/// What a frame shows if its exposure is one of several.
struct Reading {
  LineFeatures features;
  double probability = 1;  ///< of that exposure
};

/// Reads the scan lines of frames at all exposures that they may have compared with the model: one
/// once that is clear, two or three at a change of light. Costs some 15 us a reading.
class FrameReader {
 public:
  /// @param sigma, drift  ColourCompassParams::exposure_sigma and exposure_drift.
  FrameReader(const std::vector<ColourClass>& classes, double sigma, double drift);

  /// Time went by since the frame before.
  void Wait(double seconds);
  /// @param samples  of ScanLines::Sample.
  void Read(const cv::Mat& samples, const ScanLines& lines);
  /// Of the last Read; at least one.
  [[nodiscard]] std::span<const Reading> Readings() const { return readings_; }
  /// @param log_likelihood  of each of Readings(), whose probabilities follow.
  void Weigh(std::span<const double> log_likelihood);
  /// At the most likely exposure.
  [[nodiscard]] const Reading& Best() const;
  /// As just switched on.
  void Reset() { exposure_ = ExposureBelief(sigma_); }

 private:
  ColourClasses classes_;
  double sigma_;
  double drift_;
  ExposureBelief exposure_;
  std::array<cv::Mat, ExposureBelief::kFactors> levels_;  // each a table for cv::LUT
  std::vector<int> factors_;                              // of the readings
  std::vector<Reading> readings_;
  cv::Mat exposed_;  // scratch
};

}  // namespace ceilmap::colour
