#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "app/recordings/bag_options.hpp"
#include "calib/rig.hpp"

namespace ceilmap::commands {

/// The robot's geometry: a rig file, or for a first map with lengths in metres the field of view
/// and the height of the ceiling, or what a bag says of its cameras.
struct RigOptions {
  std::filesystem::path file;
  bool from_bag = false;
  std::optional<double> fov_deg;
  std::optional<double> ceiling_height_m;
  std::optional<double> camera_height_m;  ///< nothing: 0, the ceiling's height counts from there

  void AddTo(CLI::App& cli, const std::string& group);
  /// @throws InputError
  void Check() const;
  /// True when the rig is made from --fov and --ceiling-height.
  [[nodiscard]] bool IsNominal() const { return fov_deg.has_value(); }
  [[nodiscard]] bool IsGiven() const { return !file.empty() || from_bag || IsNominal(); }
  /// The rig of the file; nothing when there is none. @throws InputError
  [[nodiscard]] std::optional<calib::Rig> ReadFile() const;
  /// The rig of --rig-from-bag. @param up, forward  the sources. @throws InputError
  [[nodiscard]] calib::Rig OfBag(const std::string& up,
                                 const std::string& forward,
                                 const recordings::BagOptions& bags) const;
  /// The rig by --fov. @param size  of the recording's images.
  [[nodiscard]] calib::Rig Nominal(cv::Size size) const;
  /// What is assumed about the rig, one line; empty with a rig file.
  [[nodiscard]] std::string Assumption() const;

 private:
  void CheckFromBag() const;
};

}  // namespace ceilmap::commands
