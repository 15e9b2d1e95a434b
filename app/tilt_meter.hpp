#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <future>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/forward_frames.hpp"
#include "app/frame_source.hpp"
#include "app/table.hpp"
#include "calib/rig.hpp"
#include "calib/tilt.hpp"
#include "compensation/tilt_estimator.hpp"

namespace ceilmap::app {

/// The options of a command that can take tilt out.
struct TiltOptions {
  std::string method;  ///< none, forward, ceiling, fused; empty: fused where there is a rig
  std::string forward;
  std::filesystem::path forward_stamps;
  std::filesystem::path uncompensated;

  /// Adds --forward, --forward-stamps, --tilt and --uncompensated.
  void AddTo(CLI::App& cli, const std::string& inputs, const std::string& results);
  /// Checks what can be told without any file. @throws calib::InputError
  void Check(bool have_rig) const;
};

/// The tilt of a recording's frames, measured as TiltOptions say.
class TiltMeter {
 public:
  /// @param stamps  of the upward frames, for the forward ones where they are as many.
  /// @return null when tilt is not measured. @throws calib::InputError
  static std::unique_ptr<TiltMeter> Make(const TiltOptions& options,
                                         const std::optional<calib::Rig>& rig,
                                         const std::filesystem::path& rig_file,
                                         const std::filesystem::path& stamps);

  TiltMeter(const calib::Rig& rig,
            compensation::TiltMethod method,
            std::unique_ptr<ForwardFrames> forward);

  calib::Tilt Measure(const Frame& up);
  /// See compensation::TiltEstimator::Correct.
  void Correct(const compensation::TiltAngles& left) { estimator_.Correct(left); }

  [[nodiscard]] std::vector<std::string> Warnings() const;
  /// For --summary.
  [[nodiscard]] nlohmann::ordered_json Quality() const;
  void AddTimes(nlohmann::ordered_json& stages_ms) const;
  /// For the table that ends a run.
  void AddRows(Table& table) const;

 private:
  compensation::TiltMethod method_;
  compensation::TiltEstimator estimator_;
  std::unique_ptr<ForwardFrames> forward_;
};

/// A frame and how the robot stood.
struct TiltedFrame {
  Frame frame;
  calib::Tilt tilt;
};

/// The frames of the upward camera with their tilt. Of recordings the tilt of the next frame is
/// measured beside the work on the one before.
class TiltedFrames {
 public:
  /// @param meter  may be null: all frames are level then. Both must outlive this.
  TiltedFrames(FrameSource& source, TiltMeter* meter);
  ~TiltedFrames();
  TiltedFrames(const TiltedFrames&) = delete;
  TiltedFrames& operator=(const TiltedFrames&) = delete;

  /// As FrameSource::Read. The meter may be at work between two calls.
  bool Read(TiltedFrame& frame);
  /// What a level map says is left of the tilt of the frame read last.
  void Correct(const compensation::TiltAngles& left);

 private:
  bool ReadNow(TiltedFrame& frame);
  void Begin();

  FrameSource& source_;
  TiltMeter* meter_;
  bool ahead_;
  TiltedFrame next_;
  std::optional<compensation::TiltAngles> left_;  // for the meter, once it is at rest
  std::future<bool> reading_;
};

}  // namespace ceilmap::app
