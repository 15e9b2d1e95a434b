#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>

#include "app/recordings/bag_options.hpp"
#include "app/terminal/summary.hpp"
#include "calib/rig.hpp"
#include "calib/wheels/wheels_report.hpp"

namespace ceilmap::commands {

/// Options of `map`, `localize` and `heading` for wheels and gyro.
struct WheelOptions {
  std::filesystem::path odometry;
  std::filesystem::path gyro;
  std::filesystem::path rig_out;  ///< the rig with what the run found of both

  /// @param inputs, results  groups of the help text. @param gyro_text  help of --gyro.
  void AddTo(CLI::App& cli,
             const std::string& inputs,
             const std::string& results,
             const std::string& gyro_text);
  /// Takes the bag of the command's main source where only a topic is given.
  /// @param main  option and value of that source. @throws InputError
  void TakeBag(const recordings::BagOptions& bags,
               const std::string& main_option,
               const std::string& main);
  /// Says which topics of bags will be read (recordings::ReserveTopic). @throws InputError
  void Reserve(const recordings::BagOptions& bags) const;
  [[nodiscard]] bool Given() const { return !odometry.empty() || !gyro.empty(); }
  /// @throws InputError when --rig-out cannot be written for lack of a rig or of a recording.
  void CheckRigOut(bool have_rig) const;
  /// Writes --rig-out, if it was given, and adds it to the summary. @throws InputError, RunError
  void WriteRig(const calib::Rig& rig,
                const wheels::WheelsReport& wheels,
                terminal::Summary& summary) const;
};

}  // namespace ceilmap::commands
