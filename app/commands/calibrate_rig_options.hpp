#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>

#include "app/recordings/rig_calibration.hpp"
#include "app/recordings/rig_recording.hpp"
#include "calib/solve/rig_solver.hpp"

namespace ceilmap::commands {

/// The options of `calibrate rig`.
struct CalibrateRigOptions {
  std::filesystem::path rig;
  std::filesystem::path camera;
  std::string spin;
  std::string spin_forward;
  std::filesystem::path spin_stamps;
  std::string straight;
  std::string straight_forward;
  std::filesystem::path straight_stamps;
  std::string step;
  std::string step_forward;
  std::filesystem::path step_stamps;
  std::optional<double> step_height_m;
  std::optional<double> camera_height_m;
  recordings::TapeMeasures tape;
  double lens_sigma_px = calibration::RigSolverParams{}.lens_sigma_px;
  std::filesystem::path output;
  std::filesystem::path report;

  /// Adds all of them to the command.
  void AddTo(CLI::App& cli);
  /// Checks everything that can be checked without the recordings. @throws InputError
  void Check() const;

  /// The recordings, with the forward camera where there is one.
  [[nodiscard]] recordings::RigRecording Spin() const { return {spin, spin_forward, spin_stamps}; }
  [[nodiscard]] recordings::RigRecording Straight() const {
    return {straight, straight_forward, straight_stamps};
  }
  [[nodiscard]] recordings::RigRecording Step() const { return {step, step_forward, step_stamps}; }

 private:
  void AddInput(CLI::App& cli);
  void AddTape(CLI::App& cli);
  void AddMotion(CLI::App& cli);
  void CheckMotion() const;
};

}  // namespace ceilmap::commands
