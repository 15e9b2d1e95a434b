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

/// A calibrated camera, with the data of its report.
struct CameraCalibration {
  std::string name;  ///< of the camera
  calibration::Board board;
  BoardImages images;                         ///< all boards found
  std::vector<calibration::BoardView> views;  ///< views used in the solution
  calibration::CameraSolution solution;       ///< its views are those of `views`
  calibration::Coverage coverage;             ///< coverage of the used views
  std::vector<std::string> warnings;
  struct LeftOut {
    std::string name;
    std::string why;
  };
  std::vector<LeftOut> left_out;
};

/// Selects views, solves, and checks the result.
/// @param max_views  At least 3.
/// @throws InputError when the images do not determine the camera, with the missing information.
CameraCalibration CalibrateCamera(const calibration::Board& board,
                                  BoardImages images,
                                  const calibration::SolverParams& params,
                                  std::size_t max_views);

}  // namespace ceilmap::recordings
