#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/terminal/table.hpp"
#include "calib/base/heading.hpp"
#include "calib/base/pose2.hpp"
#include "calib/rig.hpp"

namespace ceilmap::recordings {

/// The options of a command that can use headings.
struct HeadingOptions {
  std::string omni;
  std::filesystem::path omni_stamps;
  std::filesystem::path file;
  std::filesystem::path model;
  /// The forward camera and its stamps, which a model needs: options of somebody else
  /// (TiltOptions), put here before Check and Make.
  std::string forward;
  std::filesystem::path forward_stamps;

  /// Adds --omni, --omni-stamps and --heading.
  void AddTo(CLI::App& cli, const std::string& inputs, const std::string& priors);
  /// Adds --heading-model, where headings may be absolute.
  void AddModelTo(CLI::App& cli, const std::string& priors);
  /// Headings count from the x axis of the learned poses.
  [[nodiscard]] bool Absolute() const { return !model.empty(); }
  /// Checks what can be told without any file. @throws InputError
  void Check(bool have_rig) const;
};

/// Headings for a recording's frames, from the mirror camera, learned colours, or a file.
class HeadingSource {
 public:
  /// @param stamps  of the upward frames, for the mirror camera's where they are as many.
  /// @return null when there are no headings. @throws InputError
  static std::unique_ptr<HeadingSource> Make(const HeadingOptions& options,
                                             const std::optional<calib::Rig>& rig,
                                             const std::filesystem::path& rig_file,
                                             const std::filesystem::path& stamps);
  virtual ~HeadingSource() = default;

  /// The heading at the time of an upward frame; nothing where there is none. Times must not go
  /// back. One call at a time, but from any thread.
  virtual std::optional<HeadingPrior> At(double stamp_s) = 0;
  /// Where the robot was at an upward frame, or that nobody knows: helps a compass to tell travel
  /// from turns. Between two calls of At, and of frames before.
  virtual void Locate(double stamp_s, const std::optional<Pose2>& T_map_base) = 0;

  // The rest once all frames have been asked for.

  [[nodiscard]] virtual std::vector<std::string> Warnings() const = 0;
  /// For --summary.
  [[nodiscard]] virtual nlohmann::ordered_json Quality() const = 0;
  virtual void AddTimes(nlohmann::ordered_json& stages_ms) const = 0;
  /// For the table that ends a run.
  virtual void AddRows(terminal::Table& table) const = 0;

 protected:
  HeadingSource() = default;
  HeadingSource(const HeadingSource&) = default;
  HeadingSource& operator=(const HeadingSource&) = default;
};

}  // namespace ceilmap::recordings
