#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/recordings/heading_source.hpp"
#include "app/recordings/synchronized_stream.hpp"
#include "calib/mirror_view.hpp"
#include "localization/compass/compass.hpp"
#include "localization/compass/travel_forecast.hpp"

namespace ceilmap::recordings {

/// Headings of the mirror camera, by a visual compass that runs in step with the upward frames.
class OmniHeadings : public HeadingSource {
 public:
  /// @param stamps  of its frames, or of the upward ones where those are as many.
  /// @throws InputError when the source cannot be used, or does not fit the rig.
  static std::unique_ptr<OmniHeadings> Make(const std::string& source,
                                            const std::filesystem::path& stamps,
                                            const calib::Rig& rig,
                                            const std::filesystem::path& rig_file);

  /// @param position  of the mirror on the robot, base frame, m.
  OmniHeadings(std::unique_ptr<SynchronizedStream> camera,
               calib::MirrorView view,
               std::unique_ptr<compass::Compass> compass,
               const Eigen::Vector2d& position = Eigen::Vector2d::Zero());

  /// Of the mirror image nearest in time. Where the two were not taken at once, what the robot
  /// may have turned meanwhile counts in the variance.
  std::optional<HeadingPrior> At(double stamp_s) override;

  void Locate(double stamp_s, const std::optional<Pose2>& T_map_base) override;
  [[nodiscard]] std::vector<std::string> Warnings() const override;
  [[nodiscard]] nlohmann::ordered_json Quality() const override;
  void AddTimes(nlohmann::ordered_json& stages_ms) const override;
  void AddRows(terminal::Table& table) const override;

 private:
  void Observe(const Frame& frame);

  std::unique_ptr<SynchronizedStream> camera_;
  calib::MirrorView view_;
  std::unique_ptr<compass::Compass> compass_;
  compass::TravelForecast travel_;
  cv::Mat panorama_;
  std::optional<std::int64_t> seen_;                  // index of the last image ...
  double seen_s_ = 0;                                 // ... and its time
  std::optional<compass::HeadingEstimate> estimate_;  // of it
  double estimate_s_ = 0;
  double rate_rad_s_ = 0;  // how fast the robot turned before it
  std::int64_t told_ = 0;
  std::int64_t held_ = 0;  // images that told nothing
  double compass_ms_ = 0;
};

}  // namespace ceilmap::recordings
