#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>

#include "app/files/output_files.hpp"
#include "app/recordings/bag_options.hpp"
#include "app/recordings/rig_recording.hpp"
#include "calib/solve/rig_solver.hpp"
#include "compensation/mount/up_mount.hpp"

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
  std::filesystem::path spin_odometry;
  std::filesystem::path straight_odometry;
  std::filesystem::path spin_gyro;
  std::filesystem::path straight_gyro;
  recordings::BagOptions bags;  ///< of both drives
  std::optional<double> camera_height_m;
  mount::TapeMeasures tape;
  double lens_sigma_px = calibration::RigSolverParams{}.lens_sigma_px;
  std::filesystem::path output;
  std::filesystem::path report;

  /// Adds all of them to the command.
  void AddTo(CLI::App& cli);
  /// Takes the bag of a drive where only a topic is given. @throws InputError
  void TakeBags();
  /// Checks everything that can be checked without the recordings. @throws InputError
  void Check(files::Existing existing) const;

  [[nodiscard]] bool HasWheels() const;
  /// The recordings, with the forward camera where there is one.
  [[nodiscard]] recordings::RigRecording Spin() const {
    return {spin, spin_forward, spin_stamps, bags.TopicAlone("up"), bags.TopicAlone("forward"), {}};
  }
  [[nodiscard]] recordings::RigRecording Straight() const {
    return {straight,
            straight_forward,
            straight_stamps,
            bags.TopicAlone("up"),
            bags.TopicAlone("forward"),
            {}};
  }

 private:
  void AddInput(CLI::App& cli);
  void AddTape(CLI::App& cli);
  void AddForward(CLI::App& cli);
  void AddWheels(CLI::App& cli);
};

}  // namespace ceilmap::commands
