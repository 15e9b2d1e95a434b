#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "app/recordings/board_images.hpp"
#include "calib/solve/board.hpp"
#include "calib/solve/camera_solver.hpp"
#include "calib/solve/view_judge.hpp"

namespace ceilmap::recordings {

/// A camera that was calibrated, with all that a report tells of it.
struct CameraCalibration {
  std::string name;  ///< of the camera
  calibration::Board board;
  BoardImages images;                         ///< all that was found
  std::vector<calibration::BoardView> views;  ///< those that went into the solution
  calibration::CameraSolution solution;       ///< its views count in `views`
  calibration::Coverage coverage;             ///< of those used
  std::vector<std::string> warnings;
  struct LeftOut {
    std::string name;
    std::string why;
  };
  std::vector<LeftOut> left_out;
};

/// Chooses views, solves, judges.
/// @param max_views  at least 3.
/// @throws InputError when the images do not determine the camera: what is missing, and
/// what
///   to add.
CameraCalibration CalibrateCamera(const calibration::Board& board,
                                  BoardImages images,
                                  const calibration::SolverParams& params,
                                  std::size_t max_views);

}  // namespace ceilmap::recordings
