#pragma once

#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/recordings/heading_source.hpp"
#include "app/recordings/synchronized_stream.hpp"
#include "localization/compass/colour/colour_compass.hpp"

namespace ceilmap::recordings {

/// Absolute headings of the forward camera, by colours that were learned before (`compass learn`),
/// in the frame of the learned poses. Where the robot is on the map, once that is known, helps.
class ColourHeadings : public HeadingSource {
 public:
  /// @param stamps  of its frames, or of the upward ones where those are as many.
  /// @throws InputError when model, source or rig cannot be used.
  static std::unique_ptr<ColourHeadings> Make(const std::filesystem::path& model,
                                              const std::string& source,
                                              const std::filesystem::path& stamps,
                                              const calib::Rig& rig,
                                              const std::filesystem::path& rig_file);

  ColourHeadings(std::unique_ptr<SynchronizedStream> camera, colour::ColourCompass compass);

  /// Of the forward image nearest in time; nothing while several headings are possible.
  std::optional<HeadingPrior> At(double stamp_s) override;

  void Locate(double stamp_s, const std::optional<Pose2>& T_map_base) override;
  [[nodiscard]] std::vector<std::string> Warnings() const override;
  [[nodiscard]] nlohmann::ordered_json Quality() const override;
  void AddTimes(nlohmann::ordered_json& stages_ms) const override;
  void AddRows(terminal::Table& table) const override;

 private:
  void Observe(const Frame& frame);

  std::unique_ptr<SynchronizedStream> camera_;
  colour::ColourCompass compass_;
  std::optional<std::int64_t> seen_;              // index of the last picture
  std::optional<colour::ColourHeading> heading_;  // of it
  std::optional<colour::PlaceHypothesis> place_;  // where the robot was last, if that was lately
  double placed_s_ = 0;
  std::int64_t told_ = 0;
  std::int64_t unsure_ = 0;
  double compass_ms_ = 0;
};

}  // namespace ceilmap::recordings
