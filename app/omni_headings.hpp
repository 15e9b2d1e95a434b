#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/heading_meter.hpp"
#include "app/second_camera.hpp"
#include "calib/mirror_view.hpp"
#include "localization/compass/compass.hpp"

namespace ceilmap::app {

/// Headings of the mirror camera, by a visual compass that runs in step with the upward frames.
class OmniHeadings : public HeadingMeter {
 public:
  /// @param stamps  of its frames, or of the upward ones where those are as many.
  /// @throws calib::InputError when the source cannot be used, or does not fit the rig.
  static std::unique_ptr<OmniHeadings> Make(const std::string& source,
                                            const std::filesystem::path& stamps,
                                            const calib::Rig& rig,
                                            const std::filesystem::path& rig_file);

  OmniHeadings(std::unique_ptr<SecondCamera> camera,
               calib::MirrorView view,
               std::unique_ptr<compass::Compass> compass);

  /// Of the mirror picture nearest in time. Where the two were not taken at once, what the robot
  /// may have turned meanwhile counts in the variance.
  std::optional<calib::HeadingPrior> At(double stamp_s) override;

  [[nodiscard]] std::vector<std::string> Warnings() const override;
  [[nodiscard]] nlohmann::ordered_json Quality() const override;
  void AddTimes(nlohmann::ordered_json& stages_ms) const override;
  void AddRows(Table& table) const override;

 private:
  void Look(const Frame& frame);

  std::unique_ptr<SecondCamera> camera_;
  calib::MirrorView view_;
  std::unique_ptr<compass::Compass> compass_;
  cv::Mat panorama_;
  std::optional<std::int64_t> seen_;                  // index of the last picture
  std::optional<compass::HeadingEstimate> estimate_;  // of it
  double estimate_s_ = 0;
  double rate_rad_s_ = 0;  // how fast the robot turned before it
  std::int64_t told_ = 0;
  std::int64_t held_ = 0;  // pictures that told nothing
  double compass_ms_ = 0;
};

}  // namespace ceilmap::app
